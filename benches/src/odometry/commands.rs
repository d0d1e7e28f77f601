//! Runs the `autoinspect` program and reads its JSON.

use crate::arguments::Arguments;
use crate::table::Row;
use anyhow::Result;
use benches::json;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Records a walk; `blind` covers the LiDAR between two times, seconds from the start.
pub fn record(
    arguments: &Arguments,
    site: &str,
    seed: u64,
    blind: Option<(f64, f64)>,
    out: &Path,
) -> Result<()> {
    let mut command = Command::new(&arguments.program);
    command.args(["sim", "record", "--site", site, "--route", "round", "--json"]);
    command.args(["--seed", &seed.to_string(), "--minutes", &arguments.minutes.to_string()]);
    command.args(["--columns", &arguments.columns.to_string(), "--people", &arguments.people.to_string()]);
    if let Some((from, until)) = blind {
        command.args(["--faults", &format!("blind-lidar@{from}-{until}")]);
    }
    json(command.arg("--out").arg(out)).map(drop)
}

/// Maps a recording and compares the trajectory with the ground truth. Loops are left open, because the other programs close none.
pub fn map_and_compare(arguments: &Arguments, recording: &Path, out: &Path, sources: &str) -> Result<Row> {
    let mut map = Command::new("taskset");
    map.args(["-c", "0"]).arg(&arguments.program).arg("map").arg(recording);
    map.args(["--sources", sources, "--no-loops", "--json"]).arg("--out").arg(out);
    let summary = json(&mut map)?;
    let mut compare = Command::new(&arguments.program);
    compare.args(["trajectory", "compare", "--align", "se3", "--json"]);
    let errors = json(compare.arg(recording).arg(out.join("trajectory.tum")))?;
    Ok(Row {
        scans: number(&summary, "/scans") as u64,
        path: number(&summary, "/distance_m"),
        error: errors.pointer("/ape_m/rmse").and_then(Value::as_f64),
        vertical: errors.pointer("/ape_vertical_m/max").and_then(Value::as_f64),
        cpu_ms: number(&summary, "/scan_ms/mean"),
        p99_ms: number(&summary, "/scan_ms/p99"),
        peak_mb: number(&summary, "/peak_memory_bytes") * 1e-6,
        ..Row::default()
    })
}

fn number(value: &Value, pointer: &str) -> f64 {
    value.pointer(pointer).and_then(Value::as_f64).unwrap_or(f64::NAN)
}
