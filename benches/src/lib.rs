//! What the benchmarks share: running programs and reading what they print, and the stack on a simulated walk.

pub mod stack_walk;

use anyhow::{Context, Result, bail};
use rustix::time::{ClockId, clock_gettime};
use serde_json::Value;
use std::process::{Command, Output};

/// Runs a command to a good end.
///
/// # Errors
/// When it cannot be started or fails; with what it said.
pub fn succeed(command: &mut Command) -> Result<Output> {
    let output = command.output().with_context(|| format!("{command:?} cannot be started"))?;
    if !output.status.success() {
        bail!("{command:?} failed: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    Ok(output)
}

/// Runs a command and parses the last line of its standard output.
///
/// # Errors
/// As for [`succeed`], and when that line is no JSON.
pub fn json(command: &mut Command) -> Result<Value> {
    let output = succeed(command)?;
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().last().unwrap_or_default();
    serde_json::from_str(line).with_context(|| format!("{command:?} printed no JSON but '{line}'"))
}

/// CPU time of this thread, milliseconds.
pub fn thread_ms() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}
