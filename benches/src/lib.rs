//! Shared code of the benchmarks: running programs and reading their output, the stack on a simulated walk, scores of maps, localisation at
//! random places and after faults, missions, and quantiles.

pub mod cast_visits;
pub mod fault_recovery;
pub mod loop_score;
pub mod map_score;
pub mod mapped_folder;
pub mod mapped_site;
pub mod mission_runs;
pub mod prior_map;
pub mod random_places;
pub mod stack_walk;

use anyhow::{Context, Result, bail};
use mapping::KeyframePolicy;
use messages::RobotProfile;
use rustix::time::{ClockId, clock_gettime};
use serde_json::Value;
use std::process::{Command, Output};

/// Runs a command that must succeed.
///
/// # Errors
/// When it cannot be started or fails; the error contains its standard error.
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
/// The errors of [`succeed`], and an error when that line is not JSON.
pub fn json(command: &mut Command) -> Result<Value> {
    let output = succeed(command)?;
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().last().unwrap_or_default();
    serde_json::from_str(line).with_context(|| format!("{command:?} printed no JSON but '{line}'"))
}

/// A position in the map is right if it is at most this far from the truth, metres.
pub const POSITION_TOLERANCE_M: f64 = 0.2;
/// An orientation in the map is right if it is at most this far from the truth, radians: three degrees.
pub const ROTATION_TOLERANCE_RAD: f64 = 0.052;

/// The keyframes of the simulated robot.
pub fn keyframe_policy() -> KeyframePolicy {
    let RobotProfile { keyframe_distance_m, keyframe_rotation_rad, .. } = RobotProfile::default();
    KeyframePolicy { distance_m: keyframe_distance_m, rotation_rad: keyframe_rotation_rad }
}

/// CPU time of this thread, milliseconds.
pub fn thread_ms() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}

/// The quantile of values in ascending order by nearest rank: `share` 0 is the least, 0.5 the median, 1 the greatest. NaN without values.
pub fn quantile(ascending: &[f64], share: f64) -> f64 {
    let rank = (share * ascending.len() as f64).ceil() as usize;
    ascending.get(rank.saturating_sub(1)).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::quantile;

    #[test]
    fn quantiles_are_values_of_the_list() {
        let values: Vec<f64> = (0..=1000).map(f64::from).collect();
        for (share, value) in [(0.0, 0.0), (0.5, 500.0), (0.99, 990.0), (0.999, 999.0), (1.0, 1000.0)] {
            assert_eq!(quantile(&values, share), value, "{share}");
        }
        assert_eq!(quantile(&[7.0], 0.999), 7.0);
        assert!(quantile(&[], 0.5).is_nan());
    }
}
