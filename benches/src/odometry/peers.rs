//! Runs another program over a sequence and reads its line of JSON.

use crate::arguments::Arguments;
use crate::table::Row;
use serde::Deserialize;
use std::path::Path;
use std::process::Command;

/// The JSON that the script prints.
#[derive(Deserialize)]
struct Printed {
    error: Option<f64>,
    #[serde(default)]
    cpu_ms: f64,
    #[serde(default)]
    p99_ms: f64,
    #[serde(default)]
    path_m: f64,
    #[serde(default)]
    poses: u64,
    #[serde(default)]
    peak_mb: f64,
    #[serde(default)]
    note: String,
}

/// Runs a program and returns its row. If it fails, the row contains the error.
pub fn run(arguments: &Arguments, site: &str, seed: u64, peer: &str, sequence: &Path) -> Row {
    let failed =
        |note: String| Row { site: site.to_owned(), seed, who: peer.to_owned(), note, ..Row::default() };
    // The library path is the script's folder, because the script imports another file there.
    let output = Command::new("taskset")
        .args(["-c", "0"])
        .arg(&arguments.python)
        .arg(&arguments.peer_script)
        .arg(sequence)
        .arg(peer)
        .env("OMP_NUM_THREADS", "1")
        .output();
    let output = match output {
        Ok(output) => output,
        Err(error) => return failed(format!("skipped: {error}")),
    };
    let text = String::from_utf8_lossy(&output.stdout);
    let Some(printed) = text.lines().rev().find_map(|line| serde_json::from_str::<Printed>(line).ok()) else {
        let reason = String::from_utf8_lossy(&output.stderr).lines().last().unwrap_or("no output").to_owned();
        return failed(format!("failed: {reason}"));
    };
    Row {
        site: site.to_owned(),
        seed,
        who: peer.to_owned(),
        scans: printed.poses,
        path: printed.path_m,
        error: printed.error,
        vertical: None,
        cpu_ms: printed.cpu_ms,
        p99_ms: printed.p99_ms,
        peak_mb: printed.peak_mb,
        note: printed.note,
    }
}
