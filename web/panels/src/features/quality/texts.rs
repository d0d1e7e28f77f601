//! Texts of the map's quality, by key.

use crate::format;
use api::SurveyReason;

pub(super) const FLOOR_COVERED: &str = "Floor covered";
pub(super) const ACCURACY: &str = "Known to";
pub(super) const NOT_YET_KNOWN: &str = "not yet";
pub(super) const ACCURACY_HINT: &str = "One standard deviation of the keyframe with the least certain position. Such nodes of the graph are amber.";
pub(super) const SURVEY_TARGETS: &str = "Suggested walks";
pub(super) const GO: &str = "Go";

pub(super) fn survey_target(number: usize) -> String {
    format!("Suggested walk {number}")
}

pub(super) fn walk_to(number: usize) -> String {
    format!("Walk to position {number}")
}

pub(super) fn more_targets(number: usize) -> String {
    format!("and {number} more, marked on the map")
}

/// Why a walk is suggested, and what to do there.
pub(super) fn reason(reason: SurveyReason) -> String {
    match reason {
        SurveyReason::FromAfar { area_m2 } => format!("{} seen from afar only", format::area(area_m2)),
        SurveyReason::Uncertain { deviation_m } => {
            format!("Known to {} only: drive back to where you began", format::accuracy(deviation_m))
        }
    }
}
