//! `cargo xtask test security`: runs the attacks on the platform that stand as tests, and prints what came of each.

use std::collections::BTreeSet;
use std::process::{ExitCode, Stdio};

use anyhow::{Result, bail};

use crate::shell;

/// The packages with such tests.
const PACKAGES: [&str; 6] = ["accounts", "api", "autoinspect", "gateway", "runtime", "store"];

/// Their modules and names.
const TESTS: &str = "not test(/(^|::)nightly::/) and (test(/(^|::)(attacks|access|audit_notes|repeats|journal|ledger::tests|privilege_matrix|reserved_places|abuse|uploads|tls|throttle|passwords|cookies|hosts|address_places|core_queue|authority|tls::files|lease_arbiter)::/) or binary(privileges) \
                      or test(/no_path_leads_out/) or binary(ledger_kills))";

pub(crate) fn command() -> Result<ExitCode> {
    let mut tests = shell::cargo();
    // The whole workspace, because packages alone select other features, and half of all crates would be compiled again.
    tests.args(["nextest", "run", "--workspace"]);
    tests.args(["--no-fail-fast", "--color", "never", "--status-level", "all"]);
    let packages = PACKAGES.map(|package| format!("package({package})")).join(" or ");
    let output = tests
        .args(["-E", &format!("({packages}) and {TESTS}")])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .output()?;
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let mut rows: Vec<_> = text.lines().filter_map(row).collect();
    // What failed is printed once more at the end.
    let mut seen = BTreeSet::new();
    rows.retain(|row| seen.insert(row.clone()));
    if rows.is_empty() {
        bail!("no attack was tried; cargo nextest says:\n{text}");
    }
    let width = rows.iter().map(|(attack, _)| attack.chars().count()).max().unwrap_or(0);
    println!("{:width$}  outcome", "attack, and what has to come of it");
    for (attack, has_passed) in &rows {
        println!("{attack:width$}  {}", if *has_passed { "as it should" } else { "FAILED" });
    }
    let failed = rows.iter().filter(|(_, has_passed)| !has_passed).count();
    println!("{} of {} as they should", rows.len() - failed, rows.len());
    Ok(if output.status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Attack and outcome of a line such as `PASS [   0.012s] (1/9) gateway::gateway attacks::a_stolen_secret`.
fn row(line: &str) -> Option<(String, bool)> {
    let (status, rest) = line.trim().split_once(' ')?;
    let has_passed = match status {
        "PASS" => true,
        "FAIL" | "TIMEOUT" | "SIGSEGV" | "SIGABRT" => false,
        _ => return None,
    };
    let mut words = rest.split_whitespace().rev();
    let (name, program) = (words.next()?, words.next().unwrap_or_default());
    // A test that is in no module is called by the program that it is in.
    let (module, test) = name.rsplit_once("::").unwrap_or((program, name));
    let module = module.strip_suffix("::tests").unwrap_or(module).rsplit("::").next().unwrap_or_default();
    Some((format!("{module}: {}", test.replace('_', " ")), has_passed))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_tests_become_rows() {
        let line = "        PASS [   0.012s] (1/9) gateway::gateway attacks::a_stolen_secret";
        assert_eq!(row(line), Some(("attacks: a stolen secret".to_owned(), true)));
        let line = "PASS [   0.004s] api::privileges the_guide_prints_the_privilege_table";
        assert_eq!(row(line), Some(("privileges: the guide prints the privilege table".to_owned(), true)));
        assert_eq!(row("   Compiling gateway v0.1.0"), None);
        let failed = "FAIL [   1.2s] accounts throttle::tests::few_are_remembered";
        assert_eq!(row(failed), Some(("throttle: few are remembered".to_owned(), false)));
    }
}
