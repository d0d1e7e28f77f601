//! The build tool: `cargo xtask setup | web | run | test | package | bench | fuzz`.
//!
//! It only starts other programs, measures their time and reports their results. Parts that need more than the standard library are
//! elsewhere: bundling in `bundler`, benchmarks in `benches`, tests in `tests`.
#![allow(clippy::print_stdout, reason = "a build tool's reports are its output")]

use std::ffi::OsString;
use std::process::ExitCode;

use anyhow::{Result, bail};

mod bench;
mod crash;
mod debian;
mod fingerprint;
mod fuzz;
mod lints;
mod package;
mod run;
mod schema;
mod security;
mod setup;
mod shell;
mod stages;
mod test;
mod toolchain;
mod web;

const HELP: &str = "\
cargo xtask COMMAND

  setup                      Install what building and testing need: WASM toolchain, Chromium.
  web [--dev | --release]    Build the browser client into static/pkg (default: --release).
      [--toolchain NAME]     rustup or debian instead of the first one found.
  run [--site NAME] [--port N] [--data DIR] [--speed X] [--dev]
                             Build what is stale, then serve a simulated robot on http://127.0.0.1:8080.
  test [--quick] [FILTER...] Everything a change must pass; what CI runs. --quick leaves out bundle and browser. FILTER: only
                             tests whose name contains it.
  test --nightly [FILTER...] The same, and the long scenarios (tests in modules named `nightly`).
  test --release-gate        The same as --nightly, with the browser tests on the optimised server and bundle that are
                             shipped, and the benchmarks that have a bar, each of which must meet it.
                             A test that lacks its browser or its data counts as skipped, and says why.
  test crash [--kills N] [--seed N] [--only SITUATION [--case N]]
                             Kill the program N times (default: 300) at random moments while it maps, saves, localises, imports
                             and idles, and damage every file of a data directory in turn (situation `damage`). Prints a table;
                             fails if anything was lost.
  test security              Try the attacks on the platform that stand as tests. Prints a table; fails if one succeeds.
  test schema [--requests N] [--server PROGRAM]
                             Make N requests (default: 10,000) as nobody and as each role, of which the description of the HTTP
                             interface allows some and forbids others (needs the Python program schemathesis). Fails on an error
                             of the server and on an answer that the description does not have.
  package [--check]          Build a Debian package with a sandboxed service, into target/package. --check (as root): install it in a
                             clean Debian, run its service there as its own user, upgrade and remove it.
  bench NAME [ARGUMENT...]   Run a benchmark; without a name, list them.
  fuzz [--minutes N] [--slot S] [--together K] [--folder DIR] [--no-build] [TARGET...]
                             Fuzz each parser, or those named, until it has had N minutes of processor time (default: 30), in
                             slots of S seconds (default: 60), one program at a time, K targets in rotation (default: all).
                             Stop it at any time; it goes on where it was. Prints a table; fails if an input was found.
  fuzz --minimise [TARGET...]
                             Choose from what was found worth keeping the corpus that the tests replay.
";

fn main() -> ExitCode {
    match dispatch() {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn dispatch() -> Result<ExitCode> {
    let mut arguments = std::env::args_os().skip(1);
    let command = arguments.next().unwrap_or_else(|| OsString::from("help"));
    let rest: Vec<OsString> = arguments.collect();
    let done = |result: Result<()>| result.map(|()| ExitCode::SUCCESS);
    match command.to_str() {
        Some("setup") => done(setup::setup(rest)),
        Some("web") => done(web::command(rest)),
        Some("run") => done(run::command(rest)),
        Some("test") => test::command(rest),
        Some("package") => done(package::command(rest)),
        Some("bench") => done(bench::command(rest)),
        Some("fuzz") => fuzz::command(&rest),
        Some("help" | "--help" | "-h") => {
            print!("{HELP}");
            Ok(ExitCode::SUCCESS)
        }
        _ => bail!("no command {}; `cargo xtask help` lists them", command.display()),
    }
}
