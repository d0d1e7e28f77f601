//! Runs the program and finds test data.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The program under test.
pub fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_autoinspect"));
    command.env("RUST_LOG", "warn");
    command
}

/// Runs it to its end.
pub fn run(arguments: &[&str]) -> Output {
    program().args(arguments).output().expect("the program starts")
}

/// Runs it with `--json` and returns its last line.
pub fn json(arguments: &[&str]) -> Value {
    let output = run(&[arguments, &["--json"]].concat());
    let output_text = String::from_utf8_lossy(&output.stdout);
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {complaint}");
    serde_json::from_str(output_text.lines().last().unwrap_or_default()).expect("the last line is JSON")
}

/// Runs it and expects exit code 2 and one sentence.
pub fn refused(arguments: &[&str]) -> String {
    let output = run(arguments);
    let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {complaint}");
    assert!(output.stdout.is_empty(), "{arguments:?} printed a result");
    assert!(!complaint.contains("panicked"), "{arguments:?}: {complaint}");
    complaint
}

/// A path as an argument.
pub fn text(path: &Path) -> &str {
    path.to_str().expect("test paths are UTF-8")
}

/// A folder of the shared test data; `None`, with a printed note, if it does not exist.
pub fn data(name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("AUTOINSPECT_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from);
    let path = root.join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: test data {} is not there; set AUTOINSPECT_DATA", path.display());
    None
}
