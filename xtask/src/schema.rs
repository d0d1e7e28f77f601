//! `cargo xtask test schema`: asks a running server for everything that the description of its HTTP interface allows, and for what it does not, as each role, and fails on
//! an error of the server and on an answer that the description does not have.
//!
//! The requests are made by `schemathesis` (`pip install schemathesis`, 4.32 or later). Without it the check is skipped, with that reason.

use std::ffi::OsString;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, bail, ensure};

use crate::shell;

/// The program that makes the requests.
const FUZZER: &str = "schemathesis";

/// Requests as each role, if nothing else is asked for.
pub(crate) const REQUESTS: usize = 10_000;

/// Who asks: nobody, and a program with a token of each role.
const ROLES: [&str; 4] = ["nobody", "viewer", "operator", "admin"];

/// What is checked of each answer.
const CHECKS: &str = "not_a_server_error,status_code_conformance,content_type_conformance,response_schema_conformance,response_headers_conformance";

/// The operations that end tokens, such as that of the fuzzer, which finds it in the list of tokens. They are tried last, with another one.
const ENDING_TOKENS: [&str; 2] = ["signOut", "revokeToken"];

/// Operations of the interface, about: their examples are chosen so that the wanted number of requests is exceeded.
const OPERATIONS: usize = 50;

/// Rounds with further seeds at most, until there were enough requests.
const ROUNDS: u64 = 5;

/// Why the check cannot run here; `None`: it can.
pub(crate) fn missing() -> Option<String> {
    let is_there = shell::output(fuzzer().arg("--version")).is_some();
    (!is_there).then(|| {
        format!("{FUZZER} is not there: `pip install {FUZZER}`, or give its path in AUTOINSPECT_SCHEMATHESIS")
    })
}

pub(crate) fn command(arguments: &[OsString]) -> Result<ExitCode> {
    let mut requests = REQUESTS;
    let mut server = shell::target().join("debug/autoinspect");
    let mut arguments = arguments.iter();
    while let Some(name) = arguments.next() {
        let value = arguments.next().with_context(|| format!("{} needs a value", name.display()))?;
        match name.to_str() {
            Some("--requests") => {
                requests = value.to_string_lossy().parse().context("--requests needs a number")?
            }
            Some("--server") => server = PathBuf::from(value),
            _ => bail!("`cargo xtask test schema` does not know {}", name.display()),
        }
    }
    if let Some(reason) = missing() {
        println!("skipped: {reason}");
        return Ok(ExitCode::SUCCESS);
    }
    ensure!(server.is_file(), "{} is not built; run `cargo build -p autoinspect`", server.display());
    run(&server, requests).map(|()| ExitCode::SUCCESS)
}

/// Tries all roles, and prints a table.
///
/// # Errors
/// When an answer is wrong, or nothing can be tried.
pub(crate) fn run(server: &Path, requests: usize) -> Result<()> {
    let mut failed = Vec::new();
    for role in ROLES {
        let started = Instant::now();
        let report = try_role(server, role, requests)?;
        let outcome = if report.is_right { "all answers as described" } else { "FAILED" };
        println!(
            "{role:8}  {:6} requests  {:4.0} s  {outcome}",
            report.requests,
            started.elapsed().as_secs_f64()
        );
        if !report.is_right {
            failed.push(role);
        }
    }
    ensure!(failed.is_empty(), "answers that the description does not have, as {}", failed.join(", "));
    Ok(())
}

/// What came of one role.
struct Report {
    requests: usize,
    is_right: bool,
}

fn try_role(server: &Path, role: &str, requests: usize) -> Result<Report> {
    let folder = shell::target().join("schema").join(role);
    if folder.exists() {
        fs::remove_dir_all(&folder).with_context(|| format!("could not remove {}", folder.display()))?;
    }
    fs::create_dir_all(folder.join("static")).context("could not make a folder")?;
    fs::write(folder.join("static/index.html"), "<title>AutoInspect</title>")?;
    let data = folder.join("data");
    fs::create_dir_all(&data)?;
    let token = |name: &str| (role != "nobody").then(|| token(server, &data, name, role)).transpose();
    let (first, last) = (token("first")?, token("last")?);
    let platform = Platform::start(server, &folder)?;
    let mut report = Report { requests: 0, is_right: true };
    let examples = requests.div_ceil(OPERATIONS);
    for seed in 1..=ROUNDS {
        platform.ask(first.as_deref(), "--exclude-operation-id", examples, seed, &folder, &mut report)?;
        if report.requests >= requests {
            break;
        }
    }
    platform.ask(last.as_deref(), "--include-operation-id", examples, 1, &folder, &mut report)?;
    Ok(report)
}

fn fuzzer() -> Command {
    shell::program(std::env::var_os("AUTOINSPECT_SCHEMATHESIS").unwrap_or_else(|| FUZZER.into()))
}

/// The secret of a new token.
fn token(server: &Path, data: &Path, name: &str, role: &str) -> Result<String> {
    let mut account = shell::program(server);
    account.args(["account", "--data"]).arg(data).args(["token", "add", name, "--role", role]);
    shell::output(&mut account).context("could not make a token")
}

/// A running platform. It ends when it is dropped.
struct Platform {
    child: Child,
    address: String,
}

impl Platform {
    fn start(server: &Path, folder: &Path) -> Result<Self> {
        let log = fs::File::create(folder.join("platform.log"))?;
        let mut child = shell::program(server)
            .arg("up")
            .arg("--data")
            .arg(folder.join("data"))
            .arg("--static")
            .arg(folder.join("static"))
            .args(["--listen", "127.0.0.1:0", "--no-record"])
            .args(["--robot", "sim:b1", "--people", "0", "--lidar-columns", "50"])
            .stdout(Stdio::piped())
            .stderr(log)
            .spawn()
            .context("could not start the server")?;
        let mut line = String::new();
        let output = child.stdout.take().context("the server has no output")?;
        BufReader::new(output).read_line(&mut line)?;
        let address = line.trim().split_once("http://").map(|(_, address)| address.to_owned());
        let platform = Self { child, address: address.unwrap_or_default() };
        ensure!(
            !platform.address.is_empty(),
            "the server has not started: {}",
            folder.join("platform.log").display()
        );
        Ok(platform)
    }

    /// Makes requests with this token.
    fn ask(
        &self,
        token: Option<&str>,
        which: &str,
        examples: usize,
        seed: u64,
        folder: &Path,
        report: &mut Report,
    ) -> Result<()> {
        let mut fuzz = fuzzer();
        fuzz.arg("run").arg(format!("http://{}/api/v1/openapi.json", self.address));
        fuzz.args(ENDING_TOKENS.into_iter().flat_map(|operation| [which, operation]));
        fuzz.args(["--phases", "examples,coverage,fuzzing", "--checks", CHECKS]);
        fuzz.args(["--continue-on-failure", "--no-shrink", "--no-color", "--request-timeout", "30"]);
        fuzz.args(["--max-examples", &examples.to_string(), "--seed", &seed.to_string()]);
        if let Some(token) = token {
            fuzz.args(["--header", &format!("Authorization: Bearer {token}")]);
        }
        // It keeps examples of failures in its directory.
        fuzz.current_dir(folder);
        let output =
            fuzz.stdin(Stdio::null()).output().with_context(|| format!("could not start {FUZZER}"))?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        fs::write(folder.join(format!("{}-{seed}.log", which.trim_start_matches('-'))), &text)?;
        let generated = text.lines().filter_map(|line| line.trim().split_once(" generated"));
        let generated: Option<usize> = generated.filter_map(|(count, _)| count.parse().ok()).next_back();
        report.requests += generated.with_context(|| format!("{FUZZER} has made no requests:\n{text}"))?;
        if !output.status.success() {
            report.is_right = false;
            println!("{text}");
        }
        Ok(())
    }
}

impl Drop for Platform {
    fn drop(&mut self) {
        // An orderly end: the supervisor ends its processes.
        let mut end = shell::program("kill");
        let _ = end.arg(self.child.id().to_string()).status();
        let _ = self.child.wait();
    }
}
