//! `cargo xtask bench`: one door to the benchmarks in `benches`.

use std::ffi::OsString;
use std::fs;

use anyhow::{Context, Result, bail};

use crate::shell;

pub(crate) fn command(arguments: Vec<OsString>) -> Result<()> {
    let mut arguments = arguments.into_iter();
    let names = names()?;
    let name = match arguments.next() {
        Some(name) if name != "--help" => name,
        _ => {
            println!(
                "benchmarks: {}",
                if names.is_empty() { "none yet".to_owned() } else { names.join(", ") }
            );
            return Ok(());
        }
    };
    if !names.iter().any(|known| name == known.as_str()) {
        bail!("no benchmark {}; there are: {}", name.display(), names.join(", "));
    }
    let mut bench = shell::cargo();
    bench.args(["run", "--release", "-p", "benches", "--bin"]).arg(name).arg("--").args(arguments);
    shell::run(&mut bench)
}

/// The benchmarks there are: one program each in `benches/src/bin`, a file or a folder.
fn names() -> Result<Vec<String>> {
    let folder = shell::root().join("benches/src/bin");
    if !folder.exists() {
        return Ok(Vec::new());
    }
    let entries = fs::read_dir(&folder).with_context(|| format!("could not list {}", folder.display()))?;
    let mut names = entries
        .map(|entry| {
            Ok(entry?.path().with_extension("").file_name().map(|name| name.to_string_lossy().into_owned()))
        })
        .filter_map(Result::transpose)
        .collect::<Result<Vec<_>>>()?;
    names.sort();
    Ok(names)
}
