//! `cargo xtask test`: runs the checks of one tier and prints the time of each part.
//!
//! There are three tiers. Each includes the previous one:
//!
//! - every change (no option; what CI runs): format, lints, licences, all tests outside modules named `nightly`, and the browser tests on a quickly
//!   built bundle;
//! - `--nightly`: also the tests in modules named `nightly`. These are long scenarios of which a shorter test runs on every change. The browser draws every
//!   pixel, where on every change it draws every second one of every second row;
//! - `--release-gate`: the browser tests run on the optimised server and bundle of a release, and the benchmarks with limits must meet them.
//!
//! `cargo xtask test security` tries the attacks on the platform and prints what came of each; see `security.rs`.
//! `cargo xtask test schema` compares the answers of the HTTP interface with its description; see `schema.rs`.
//! `cargo xtask test crash` is the crash test alone, with many kills; see `crash.rs`.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

use anyhow::{Context, Result, bail};

use crate::lints::{self, Compiler};
use crate::stages::{StageReport, Stages, Tests};
use crate::toolchain::Toolchain;
use crate::web::{self, Flavour, SizeLimit};
use crate::{bench, crash, schema, security, setup, shell};

/// The module of the integration tests that need a browser, a release server and a bundle.
const BROWSER_TESTS: &str = "browser::";

/// The modules of tests that take too long for every change. For each of them a shorter test runs on every change.
const NIGHTLY_TESTS: &str = "nightly::";

/// Start of the line in which a test prints why it did not run.
const SKIPPED: &str = "skipped: ";

/// Every target with tests.
const TESTED: [&str; 4] = ["--workspace", "--lib", "--bins", "--tests"];

pub(crate) fn command(arguments: Vec<OsString>) -> Result<ExitCode> {
    if let Some((first, rest)) = arguments.split_first()
        && first == "crash"
    {
        return crash::command(rest);
    }
    if arguments == ["security"] {
        return security::command();
    }
    if let Some((first, rest)) = arguments.split_first()
        && first == "schema"
    {
        return schema::command(rest);
    }
    let Options { tier, quick, filters } = Options::parse(&arguments)?;
    let mut stages = Stages::new();
    let mut compiler = Compiler::Plain;
    if filters.is_empty() {
        stages.run("format", || checked(shell::cargo().args(["fmt", "--all", "--check"])));
        compiler = compile_with_lints(&mut stages);
        licences(&mut stages);
    }
    stages.run("tests", || tests(&Selection::Native(tier, &filters), compiler));
    if quick || !filters.is_empty() {
        for name in ["browser bundle", "browser tests"] {
            stages.skip(name, if quick { "--quick" } else { "only the named tests were asked for" });
        }
    } else if tier == Tier::ReleaseGate {
        stages.run_together(
            ("server (release)", || {
                checked(shell::cargo().args(["build", "--quiet", "--release", "-p", "autoinspect"]))
            }),
            ("browser bundle (release)", || checked_bundle(Flavour::Release, Compiler::Plain)),
        );
        browser_tests(&mut stages, tier, &shell::target().join("release/autoinspect"), compiler);
        match schema::missing() {
            None => stages.run("schema", || {
                schema::run(&shell::target().join("release/autoinspect"), schema::REQUESTS)
                    .map(|()| StageReport::default())
            }),
            Some(reason) => stages.skip("schema", &reason),
        }
        for (name, benchmark, arguments) in bench::WITH_BARS {
            stages.run(name, || bench::run(benchmark, arguments).map(|()| StageReport::default()));
        }
    } else {
        // The server is the one that the earlier tests have built. Building its package alone selects other features, and half of all
        // crates would be compiled again.
        stages.run("browser bundle", || checked_bundle(Flavour::Dev, compiler));
        browser_tests(&mut stages, tier, &shell::target().join("debug/autoinspect"), compiler);
    }
    Ok(if stages.finish(tier.description()) { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The extent of the checks. Each tier includes the previous ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tier {
    /// The checks of every change, which CI runs.
    EveryChange,
    /// Also long scenarios.
    Nightly,
    /// Also the release build and the benchmarks with limits.
    ReleaseGate,
}

impl Tier {
    /// One line that names the checks which the tier leaves out.
    fn description(self) -> &'static str {
        match self {
            Self::EveryChange => "tier: every change (without the nightly tests and the release gate)",
            Self::Nightly => "tier: nightly (without the release gate)",
            Self::ReleaseGate => "tier: release gate",
        }
    }
}

/// Options of the command line.
#[derive(Debug, PartialEq, Eq)]
struct Options {
    tier: Tier,
    /// Without server, bundle and browser.
    quick: bool,
    /// Parts of names: only tests whose name contains one of them run. Empty: all tests of the tier.
    filters: Vec<String>,
}

impl Options {
    /// # Errors
    /// On an unknown option, on two tiers, and on `--quick` together with a tier.
    fn parse(arguments: &[OsString]) -> Result<Self> {
        let (mut tiers, mut quick, mut filters) = (Vec::new(), false, Vec::new());
        for argument in arguments {
            match argument.to_str() {
                Some("--nightly") => tiers.push(Tier::Nightly),
                Some("--release-gate") => tiers.push(Tier::ReleaseGate),
                Some("--quick") => quick = true,
                Some(filter) if !filter.starts_with('-') => filters.push(filter.to_owned()),
                _ => bail!("`cargo xtask test` does not know {}", argument.display()),
            }
        }
        let tier = match tiers[..] {
            [] => Tier::EveryChange,
            [tier] => tier,
            _ => bail!("one tier at a time: --release-gate holds --nightly"),
        };
        if quick && tier != Tier::EveryChange {
            bail!("--quick leaves out what a tier is for; use it without one");
        }
        if tier == Tier::ReleaseGate && !filters.is_empty() {
            bail!("the release gate is passed as a whole: it takes no names of tests");
        }
        Ok(Self { tier, quick, filters })
    }
}

fn checked_bundle(least: Flavour, compiler: Compiler) -> Result<StageReport> {
    web::build_if_stale(least, SizeLimit::Enforced, compiler).map(|()| StageReport::default())
}

fn browser_tests(stages: &mut Stages, tier: Tier, autoinspect: &Path, compiler: Compiler) {
    match setup::find_or_install_chromium() {
        Some(_) => stages.run("browser tests", || tests(&Selection::Browser(tier, autoinspect), compiler)),
        None => stages
            .skip("browser tests", "no Chromium on this machine; `cargo xtask setup` says how to get it"),
    }
}

fn checked(command: &mut Command) -> Result<StageReport> {
    shell::run(command).map(|()| StageReport::default())
}

/// Compiles everything that the tests need, and the benchmarks, with lints. The compiler that the stages after it must use so that nothing is compiled again.
fn compile_with_lints(stages: &mut Stages) -> Compiler {
    let Some(compiler) = Compiler::linting() else {
        stages.skip("lints", "clippy is not installed");
        return Compiler::Plain;
    };
    let everything = || {
        let mut build = shell::cargo();
        build.args(["build", "--workspace", "--all-targets"]);
        build
    };
    stages.run("compile and lint", || lints::compile(everything).map(|()| StageReport::default()));
    // Most of the client is compiled only for the browser.
    let client = "compile and lint (browser)";
    match Toolchain::find_or_install() {
        Ok(Toolchain::Active) => stages.run(client, || web::lint().map(|()| StageReport::default())),
        Ok(Toolchain::Debian) => stages.skip(client, "Debian's Rust has no clippy for the browser"),
        Err(error) => stages.skip(client, &error.to_string()),
    }
    compiler
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

/// The tests to run.
enum Selection<'a> {
    /// Tests of a tier that need no browser; if names are given, those whose name contains one of them.
    Native(Tier, &'a [String]),
    /// Tests of a tier that need a browser, with this server program.
    Browser(Tier, &'a Path),
}

impl Selection<'_> {
    /// The command that runs the selected tests, with nextest or with cargo's own runner.
    fn command(&self, nextest: bool, compiler: Compiler) -> Command {
        let mut command = shell::cargo();
        compiler.compiles(&mut command);
        match nextest {
            true => command.args(["nextest", "run"]).args(TESTED).args(self.nextest_arguments()),
            false => command.arg("test").args(TESTED).args(self.libtest_arguments()),
        };
        if let Selection::Browser(tier, autoinspect) = self {
            command.env("AUTOINSPECT_BIN", autoinspect);
            if *tier == Tier::EveryChange {
                // A quarter of the pixels: drawn in software, they take half of the time of the tests. Nightly all are drawn.
                command.env("AUTOINSPECT_BROWSER_SCALE", "0.5");
            }
        }
        command
    }

    fn nextest_arguments(&self) -> Vec<String> {
        let browser = format!("package(tests) and test(/^{BROWSER_TESTS}/)");
        let nightly = format!("test(/(^|::){NIGHTLY_TESTS}/)");
        let (expression, filters) = match self {
            Selection::Native(Tier::EveryChange, filters) => {
                (format!("not ({browser}) and not {nightly}"), *filters)
            }
            Selection::Native(Tier::Nightly | Tier::ReleaseGate, filters) => {
                (format!("not ({browser})"), *filters)
            }
            Selection::Browser(Tier::EveryChange, _) => (format!("{browser} and not {nightly}"), &[][..]),
            Selection::Browser(..) => (browser, &[][..]),
        };
        let fixed = ["--no-fail-fast", "--success-output=immediate", "-E"].map(str::to_owned);
        fixed.into_iter().chain([expression]).chain(filters.iter().cloned()).collect()
    }

    fn libtest_arguments(&self) -> Vec<String> {
        let mut arguments = ["--no-fail-fast", "--", "--show-output"].map(str::to_owned).to_vec();
        match self {
            Selection::Native(tier, filters) => {
                arguments.extend(["--skip", BROWSER_TESTS].map(str::to_owned));
                if *tier == Tier::EveryChange {
                    arguments.extend(["--skip", NIGHTLY_TESTS].map(str::to_owned));
                }
                arguments.extend(filters.iter().cloned());
            }
            // The same targets as before, so that nothing is compiled again.
            Selection::Browser(tier, _) => {
                arguments.push(BROWSER_TESTS.to_owned());
                if *tier == Tier::EveryChange {
                    arguments.extend(["--skip", NIGHTLY_TESTS].map(str::to_owned));
                }
            }
        }
        arguments
    }
}

/// Runs tests, prints their output and counts them.
fn tests(selection: &Selection<'_>, compiler: Compiler) -> Result<StageReport> {
    let mut command = selection.command(shell::on_path("cargo-nextest"), compiler);
    // nextest reports on standard error, the standard harness on standard output; one pipe for both keeps their order.
    let (reader, writer) = std::io::pipe().context("could not make a pipe")?;
    command.stdin(Stdio::null()).stdout(writer.try_clone()?).stderr(writer);
    let mut child = command.spawn().context("could not start the tests")?;
    // The command keeps its ends of the pipe open until it is dropped; without this, the loop below would never end.
    drop(command);
    let mut counter = Counter::default();
    for line in BufReader::new(reader).lines() {
        let line = line.context("the tests' output is not text")?;
        eprintln!("{line}");
        counter.read(&line);
    }
    let status = child.wait().context("lost the tests")?;
    let report = counter.report();
    if report.tests.failed == 0 && !status.success() {
        bail!("the tests did not run to their end ({status})");
    }
    Ok(report)
}

/// Counts tests from a runner's output.
///
/// A test without its requirements (a browser, data, a graphics adapter) prints `skipped: ` and the reason, and returns. The runner counts it
/// as passed. Here it counts as skipped, once, even if it prints several such lines.
#[derive(Default)]
struct Counter {
    tests: Tests,
    /// The test whose output is being read, if it passed.
    current: Option<String>,
    /// The first reason of each test that was skipped, by the test's name.
    skipped: BTreeMap<String, String>,
}

impl Counter {
    fn read(&mut self, line: &str) {
        // nextest also shows the indented summary of each test. Its own summary includes them.
        let summary = match line.split_once(" tests run: ").or_else(|| line.split_once(" test run: ")) {
            Some((_, counts)) => Some(counts),
            None => line.strip_prefix("test result: "),
        };
        if let Some(counts) = summary {
            let counted = Tests::parse(counts);
            self.tests.passed += counted.passed;
            self.tests.failed += counted.failed;
            self.tests.skipped += counted.skipped;
        } else if let Some(test) = test_whose_output_begins(line) {
            self.current = test;
        } else if let Some(reason) = line.trim().strip_prefix(SKIPPED)
            && let Some(test) = &self.current
        {
            self.skipped.entry(test.clone()).or_insert_with(|| reason.to_owned());
        }
    }

    fn report(mut self) -> StageReport {
        self.tests.passed = self.tests.passed.saturating_sub(self.skipped.len());
        let skipped = self.skipped.iter().map(|(test, reason)| format!("{SKIPPED}{test}: {reason}"));
        StageReport { tests: self.tests, skipped: skipped.collect() }
    }
}

/// The test whose output follows this line: `Some(None)` if that test failed, `None` if the line begins no output.
fn test_whose_output_begins(line: &str) -> Option<Option<String>> {
    // Of nextest: `        PASS [   0.012s] (1/12) package module::name`, `FAIL [`, `TIMEOUT [`.
    let line = line.trim();
    if let Some((state, rest)) = line.split_once(" [")
        && state.split(' ').all(|word| {
            !word.is_empty() && word.chars().all(|c| c.is_ascii_uppercase() || "0123456789-".contains(c))
        })
        && let Some((_, name)) = rest.split_once("s] ")
    {
        let name = match name.strip_prefix('(') {
            Some(numbered) => numbered.split_once(") ").map_or(numbered, |(_, name)| name),
            None => name,
        };
        return Some((state == "PASS").then(|| name.trim().to_owned()));
    }
    // Of the standard harness: `---- module::name stdout ----`.
    let name = line.strip_prefix("---- ")?.strip_suffix(" stdout ----")?;
    Some(Some(name.to_owned()))
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

    fn parse(arguments: &str) -> Result<Options> {
        Options::parse(&arguments.split_whitespace().map(OsString::from).collect::<Vec<_>>())
    }

    #[track_caller]
    fn check_tier(arguments: &str, tier: Tier, quick: bool, filters: &[&str]) {
        let filters = filters.iter().map(|&filter| filter.to_owned()).collect();
        assert_eq!(parse(arguments).unwrap(), Options { tier, quick, filters }, "{arguments}");
    }

    #[test]
    fn tiers_are_read_from_the_command_line() {
        check_tier("", Tier::EveryChange, false, &[]);
        check_tier("--quick", Tier::EveryChange, true, &[]);
        check_tier("loops odometry", Tier::EveryChange, false, &["loops", "odometry"]);
        check_tier("--nightly", Tier::Nightly, false, &[]);
        check_tier("loops --nightly", Tier::Nightly, false, &["loops"]);
        check_tier("--release-gate", Tier::ReleaseGate, false, &[]);
    }

    #[test]
    fn contradictory_options_are_rejected() {
        let refused = [
            "--release",
            "--nightly --release-gate",
            "--nightly --nightly",
            "--quick --nightly",
            "--quick --release-gate",
            "--release-gate loops",
        ];
        for arguments in refused {
            assert!(parse(arguments).is_err(), "{arguments}");
        }
    }

    #[test]
    fn nightly_tests_are_selected_by_the_name_of_their_module() {
        let expression = |selection: &Selection<'_>| selection.nextest_arguments()[3].clone();
        let change = Selection::Native(Tier::EveryChange, &[]);
        assert!(expression(&change).contains("and not test(/(^|::)nightly::/)"));
        assert!(change.libtest_arguments().join(" ").contains("--skip nightly::"));
        for tier in [Tier::Nightly, Tier::ReleaseGate] {
            let selection = Selection::Native(tier, &[]);
            assert!(!expression(&selection).contains("nightly"));
            assert!(!selection.libtest_arguments().join(" ").contains("nightly"));
        }
        let filters = ["loops".to_owned()];
        let named = Selection::Native(Tier::EveryChange, &filters);
        assert_eq!(named.nextest_arguments().last().unwrap(), "loops");
        assert_eq!(named.libtest_arguments().last().unwrap(), "loops");
    }

    #[track_caller]
    fn check(output: &str, passed: usize, failed: usize, skipped: usize) -> Vec<String> {
        let mut counter = Counter::default();
        output.lines().for_each(|line| counter.read(line));
        let report = counter.report();
        let counted = (report.tests.passed, report.tests.failed, report.tests.skipped + report.skipped.len());
        assert_eq!(counted, (passed, failed, skipped), "{output}");
        report.skipped
    }

    #[test]
    fn the_output_of_both_runners_is_counted() {
        check(
            "     Summary [   0.104s] 15 tests run: 12 passed (1 slow), 2 failed, 1 timed out, 0 skipped",
            12,
            3,
            0,
        );
        check("     Summary [   0.104s] 1 test run: 1 passed, 320 skipped", 1, 0, 0);
        check(
            "test result: FAILED. 12 passed; 2 failed; 3 ignored; 0 measured; 0 filtered out; in 0.10s",
            12,
            2,
            3,
        );
        check("    test result: ok. 1 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out", 0, 0, 0);
        check("running 12 tests", 0, 0, 0);
    }

    #[test]
    fn a_test_without_its_data_counts_as_skipped_once_with_its_reason() {
        let nextest = "
        PASS [   0.012s] (1/3) factors::it published::graphs
  stdout ───

    running 1 test
    skipped: intel.g2o is not there
    skipped: CSAIL.g2o is not there
    test published::graphs ... ok

    test result: ok. 1 passed; 0 failed; 0 ignored; 0 measured; 9 filtered out; finished in 0.01s

        PASS [   0.020s] (2/3) factors jacobians
        FAIL [   0.020s] (3/3) factors::it robust::loops
  stdout ───
    skipped: intel.g2o is not there
     Summary [   0.104s] 3 tests run: 2 passed, 1 failed, 0 skipped
        FAIL [   0.020s] (3/3) factors::it robust::loops";
        let skipped = check(nextest, 1, 1, 1);
        assert_eq!(skipped, ["skipped: factors::it published::graphs: intel.g2o is not there"]);

        let libtest = "
---- published::graphs stdout ----
skipped: intel.g2o is not there

---- jacobians stdout ----
fine
test result: ok. 2 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.10s";
        let skipped = check(libtest, 1, 0, 1);
        assert_eq!(skipped, ["skipped: published::graphs: intel.g2o is not there"]);
    }
}
