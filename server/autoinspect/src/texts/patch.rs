//! Errors of `autoinspect patch`: why a new version of a map was not kept.

/// A new version of a map that was removed because it is worse.
pub fn version_is_worse(reason: &str) -> String {
    format!("the new version is worse and was not kept: {reason}")
}

/// Tracking is lost more often.
pub fn loses_more(after: u64, before: u64) -> String {
    format!("in it the robot loses its place {after} time(s), {before} before")
}

/// Fewer scans are localised, percent.
pub fn localises_less(after: f64, before: f64) -> String {
    format!("in it the robot is localised after {after:.1} % of the scans, {before:.1} % before")
}

/// Scans fit less, 0 to 1.
pub fn fits_less(after: f64, before: f64) -> String {
    format!("scans fit it by {after:.3}, {before:.3} before")
}

/// More points of scans lie in free space, 0 to 1.
pub fn contradicts_more(after: f64, before: f64) -> String {
    format!("scans contradict it by {after:.3}, {before:.3} before")
}
