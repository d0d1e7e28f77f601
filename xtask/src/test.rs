//! `cargo xtask test`: everything a change must pass, in one command, with the time each part took. With `--release` the browser
//! tests run on the server and bundle that are shipped, which take a quarter of an hour longer to build.

use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

use anyhow::{Context, Result, bail};

use crate::stages::{Report, Stages, Tests};
use crate::toolchain::{TARGET, Toolchain};
use crate::web::{self, Flavour};
use crate::{setup, shell};

/// The module of the integration tests that need a browser, a release server and a bundle.
const BROWSER_TESTS: &str = "browser::";

/// Every package and target with tests. Benchmarks have none; clippy has seen to it that they compile.
const TESTED: [&str; 6] = ["--workspace", "--exclude", "benches", "--lib", "--bins", "--tests"];

const DENY_WARNINGS: [&str; 3] = ["--", "-D", "warnings"];

pub(crate) fn command(arguments: Vec<OsString>) -> Result<ExitCode> {
    let (mut quick, mut shipped) = (false, false);
    let mut filters = Vec::new();
    for argument in arguments {
        match argument.to_str() {
            Some("--quick") => quick = true,
            Some("--release") => shipped = true,
            Some(filter) if !filter.starts_with('-') => filters.push(filter.to_owned()),
            _ => bail!("`cargo xtask test` does not know {}", argument.display()),
        }
    }

    let mut stages = Stages::new();
    if filters.is_empty() {
        stages.run("format", || checked(shell::cargo().args(["fmt", "--all", "--check"])));
        stages.run("clippy", || checked(clippy("--workspace", "--all-targets").args(DENY_WARNINGS)));
        browser_clippy(&mut stages);
        licences(&mut stages);
    }
    stages.run("tests", || tests(&Selection::Native(&filters)));
    if quick || !filters.is_empty() {
        for name in ["browser bundle", "browser tests"] {
            stages.skip(name, if quick { "--quick" } else { "only the named tests were asked for" });
        }
    } else if shipped {
        stages.run_together(
            ("server (release)", || {
                checked(shell::cargo().args(["build", "--quiet", "--release", "-p", "autoinspect"]))
            }),
            ("browser bundle (release)", || checked_bundle(Flavour::Release)),
        );
        browser_tests(&mut stages, &shell::target().join("release/autoinspect"));
    } else {
        // The server is the one that the tests before have built; of one package alone, with other features, half of all would be
        // compiled anew.
        stages.run("browser bundle", || checked_bundle(Flavour::Dev));
        browser_tests(&mut stages, &shell::target().join("debug/autoinspect"));
    }
    Ok(if stages.finish() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn checked_bundle(least: Flavour) -> Result<Report> {
    web::build_if_stale(least).map(|()| Report::default())
}

fn browser_tests(stages: &mut Stages, autoinspect: &Path) {
    match setup::find_or_install_chromium() {
        Some(_) => stages.run("browser tests", || tests(&Selection::Browser(autoinspect))),
        None => stages
            .skip("browser tests", "no Chromium on this machine; `cargo xtask setup` says how to get it"),
    }
}

fn checked(command: &mut Command) -> Result<Report> {
    shell::run(command).map(|()| Report::default())
}

fn clippy(packages: &str, what: &str) -> Command {
    let mut clippy = shell::cargo();
    clippy.args(["clippy", "--quiet", packages, what]);
    clippy
}

/// Most of the client exists only for the browser, so a native clippy never sees it.
fn browser_clippy(stages: &mut Stages) {
    match Toolchain::find_or_install() {
        Ok(Toolchain::Active) => stages.run("clippy (browser)", || {
            let mut clippy = clippy("--package=app", "--lib");
            clippy.args(["--target", TARGET, "--target-dir"]).arg(Toolchain::Active.target_folder());
            checked(clippy.args(DENY_WARNINGS))
        }),
        Ok(Toolchain::Debian) => {
            stages.skip("clippy (browser)", "Debian's Rust has no clippy for the browser")
        }
        Err(error) => stages.skip("clippy (browser)", &error.to_string()),
    }
}

fn licences(stages: &mut Stages) {
    if shell::on_path("cargo-deny") {
        // Advisories need a database from the network; licences, bans and sources do not.
        stages.run("licences", || {
            checked(shell::cargo().args(["deny", "check", "licenses", "bans", "sources"]))
        });
    } else {
        stages.skip("licences", "cargo-deny is not installed");
    }
}

/// Which of the tests to run.
enum Selection<'a> {
    /// All that need no browser; if names are given, those whose name contains one of them.
    Native(&'a [String]),
    /// Those that do, against this server program.
    Browser(&'a Path),
}

/// Runs tests, passing their output on and counting them.
fn tests(selection: &Selection<'_>) -> Result<Report> {
    let nextest = shell::on_path("cargo-nextest");
    let mut command = shell::cargo();
    if let Selection::Browser(autoinspect) = selection {
        command.env("AUTOINSPECT_BIN", autoinspect);
    }
    let browser = format!("package(tests) and test(/^{BROWSER_TESTS}/)");
    match (nextest, selection) {
        (true, Selection::Native(filters)) => {
            command.args(["nextest", "run"]).args(TESTED);
            command.args(["--no-fail-fast", "--success-output=immediate"]);
            command.args(["-E", &format!("not ({browser})")]).args(*filters);
        }
        (true, Selection::Browser(_)) => {
            command.args(["nextest", "run"]).args(TESTED);
            command.args(["--no-fail-fast", "--success-output=immediate", "-E", &browser]);
        }
        (false, Selection::Native(filters)) => {
            command.arg("test").args(TESTED).args(["--no-fail-fast", "--", "--show-output"]);
            command.args(["--skip", BROWSER_TESTS]).args(*filters);
        }
        (false, Selection::Browser(_)) => {
            // The same selection again, so that nothing is compiled anew.
            command.arg("test").args(TESTED).args(["--no-fail-fast", "--", "--show-output", BROWSER_TESTS]);
        }
    }

    // nextest reports on standard error, the standard harness on standard output; one pipe for both keeps their order.
    let (reader, writer) = std::io::pipe().context("could not make a pipe")?;
    command.stdin(Stdio::null()).stdout(writer.try_clone()?).stderr(writer);
    let mut child = command.spawn().context("could not start the tests")?;
    // The command keeps its ends of the pipe open until it is dropped, and the reading below would never end.
    drop(command);
    let mut report = Report::default();
    for line in BufReader::new(reader).lines() {
        let line = line.context("the tests' output is not text")?;
        eprintln!("{line}");
        count(&line, &mut report);
    }
    let status = child.wait().context("lost the tests")?;
    if report.tests.failed == 0 && !status.success() {
        bail!("the tests did not run to their end ({status})");
    }
    // To its runner, a test that found nothing to test has passed.
    report.tests.passed = report.tests.passed.saturating_sub(report.skipped.len());
    Ok(report)
}

/// Adds to `report` what one line of output says: a runner's summary, or a test's note that it did not run, which is
/// `skipped: ` and the reason, once a test.
fn count(line: &str, report: &mut Report) {
    // nextest shows each test's own summary as well, indented: those are in its own already.
    let summary = match line.split_once(" tests run: ") {
        Some((_, counts)) => Some(counts),
        None => line.strip_prefix("test result: "),
    };
    let line = line.trim();
    if let Some(counts) = summary {
        let counted = Tests::parse(counts);
        report.tests.passed += counted.passed;
        report.tests.failed += counted.failed;
        report.tests.skipped += counted.skipped;
    } else if line.starts_with("skipped: ") {
        report.skipped.push(line.to_owned());
    }
}

impl Tests {
    /// Reads `12 passed (1 slow), 2 failed, 3 skipped` and `ok. 12 passed; 2 failed; 3 ignored; …`.
    fn parse(counts: &str) -> Self {
        let words: Vec<&str> = counts.split([' ', ',', ';']).filter(|word| !word.is_empty()).collect();
        let number_before = |names: &[&str]| -> usize {
            words
                .windows(2)
                .filter(|pair| names.contains(&pair[1]))
                .filter_map(|pair| pair[0].parse::<usize>().ok())
                .sum()
        };
        Self {
            passed: number_before(&["passed"]),
            failed: number_before(&["failed", "timed"]),
            skipped: number_before(&["ignored"]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(line: &str, passed: usize, failed: usize, skipped: usize) {
        let mut report = Report::default();
        count(line, &mut report);
        let counted = (report.tests.passed, report.tests.failed, report.tests.skipped + report.skipped.len());
        assert_eq!(counted, (passed, failed, skipped), "{line}");
    }

    #[test]
    fn both_runners_are_counted() {
        check(
            "     Summary [   0.104s] 15 tests run: 12 passed (1 slow), 2 failed, 1 timed out, 0 skipped",
            12,
            3,
            0,
        );
        check(
            "test result: FAILED. 12 passed; 2 failed; 3 ignored; 0 measured; 0 filtered out; in 0.10s",
            12,
            2,
            3,
        );
        check("    test result: ok. 1 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out", 0, 0, 0);
        check("    skipped: no recordings beside this clone", 0, 0, 1);
        check("running 12 tests", 0, 0, 0);
    }
}
