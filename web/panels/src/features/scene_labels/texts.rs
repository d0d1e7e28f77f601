//! Texts of the labels in the scene, by key: names for the accessible tree, and tags.

use crate::format;
use api::SurveyReason;
use vocab::KeyframeId;

pub(super) const ROBOT: &str = "Robot in the scene";
pub(super) const GOAL: &str = "Goal";
pub(super) const DOCK_TAG: &str = "Dock";

pub(super) fn robot_tag(speed_m_s: f64) -> String {
    format!("Robot · {speed_m_s:.1} m/s")
}

pub(super) fn goal_tag(remaining_m: f64) -> String {
    format!("Goal · {}", format::distance(remaining_m))
}

pub(super) fn survey_target(number: usize) -> String {
    format!("Suggested walk {number}, in the scene")
}

/// Why a walk is suggested.
pub(super) fn survey_target_tag(reason: SurveyReason) -> String {
    match reason {
        SurveyReason::FromAfar { area_m2 } => format!("Seen from afar only · {}", format::area(area_m2)),
        SurveyReason::Uncertain { deviation_m } => format!("Known to {} only", format::accuracy(deviation_m)),
    }
}

pub(super) fn dock(number: usize) -> String {
    format!("Dock {number} in the scene")
}

pub(super) fn alignment_point(number: usize) -> String {
    format!("Picked point {number}")
}

pub(super) fn node(name: &str) -> String {
    format!("Node {name} in the scene")
}

pub(super) fn mission_stop(numbers: &[usize], place: &str) -> String {
    format!("Stop {} at {place}", listed(numbers))
}

pub(super) fn mission_stop_tag(numbers: &[usize], place: &str) -> String {
    format!("{} · {place}", listed(numbers))
}

fn listed(numbers: &[usize]) -> String {
    numbers.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}

pub(super) fn inspection_point(name: &str) -> String {
    format!("Inspection point {name} in the scene")
}

pub(super) fn zone(name: &str) -> String {
    format!("Zone {name} in the scene")
}

pub(super) fn keyframe(id: KeyframeId) -> String {
    format!("Keyframe {}", id.0)
}

pub(super) fn keyframe_tag(id: KeyframeId, sigma_m: Option<f64>) -> String {
    match sigma_m {
        Some(sigma_m) => format!("{} · known to {}", keyframe(id), format::accuracy(sigma_m)),
        None => keyframe(id),
    }
}
