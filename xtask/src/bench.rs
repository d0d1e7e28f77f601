//! `cargo xtask bench`: runs the benchmarks in `benches`.

use std::ffi::{OsStr, OsString};
use std::fs;

use anyhow::{Context, Result, bail};

use crate::shell;

/// The benchmarks with limits, which fail when they exceed them: name of the stage, benchmark, arguments.
pub(crate) const WITH_BARS: [(&str, &str, &[&str]); 8] = [
    ("endurance", "endurance", &["--site", "b1", "--minutes", "60"]),
    (
        "fault recovery",
        "localisation",
        &["--places", "0", "--days", "0", "--columns", "500", "--fault-recoveries", "6", "--bar"],
    ),
    ("pictures", "pictures", &["--bar"]),
    ("topological maps", "topomap", &["--bar"]),
    ("cost of a mission", "cost", &["--minutes", "3", "--bar"]),
    ("missions", "missions", &["--seeds", "20", "--columns", "250", "--bar"]),
    ("a year of results", "year", &["--bar"]),
    ("days of missions against the background", "background", &["--bar"]),
];

/// The benchmarks that start `target/release/autoinspect`, which is built first for them.
const STARTING_THE_PROGRAM: [&str; 6] = ["background", "cost", "first_map", "graphs", "odometry", "year"];

pub(crate) fn command(arguments: Vec<OsString>) -> Result<()> {
    let mut arguments = arguments.into_iter();
    let names = names()?;
    let name = match arguments.next() {
        Some(name) if name != "--help" => name,
        _ => {
            println!("benchmarks: {}", names.join(", "));
            return Ok(());
        }
    };
    if !names.iter().any(|known| name == known.as_str()) {
        bail!("no benchmark {}; there are: {}", name.display(), names.join(", "));
    }
    run(&name, arguments)
}

/// Builds and runs one benchmark, and builds the program where it starts that.
///
/// # Errors
/// When it cannot be built or fails. A benchmark with limits fails when it exceeds them.
pub(crate) fn run(
    name: impl AsRef<OsStr>,
    arguments: impl IntoIterator<Item = impl AsRef<OsStr>>,
) -> Result<()> {
    let name = name.as_ref();
    if STARTING_THE_PROGRAM.iter().any(|known| name == *known) {
        shell::run(shell::cargo().args(["build", "--release", "-p", "autoinspect"]))?;
    }
    let mut bench = shell::cargo();
    bench.args(["run", "--release", "-p", "benches", "--bin"]).arg(name).arg("--").args(arguments);
    shell::run(&mut bench)
}

/// Names of the benchmarks. Each is a program in its own folder, `benches/src/NAME/main.rs`.
fn names() -> Result<Vec<String>> {
    let folder = shell::root().join("benches/src");
    let entries = fs::read_dir(&folder).with_context(|| format!("could not list {}", folder.display()))?;
    let paths = entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>>>()?;
    let programs =
        paths.iter().filter(|path| path.join("main.rs").exists()).filter_map(|path| path.file_name());
    let mut names: Vec<_> = programs.map(|name| name.to_string_lossy().into_owned()).collect();
    names.sort();
    Ok(names)
}
