//! Texts of map alignment, by key.

pub(super) const OFFER_SHORT: &str = "Align to another map";
pub(super) const OFFER_HINT: &str =
    "For two maps of the same site. The result is a third map, in the frame of the other one. Both are kept.";
pub(super) const CANCEL: &str = "Cancel aligning";
pub(super) const CANCEL_SHORT: &str = "Cancel";
pub(super) const CHOOSE_REFERENCE: &str = "Into the frame of which map?";
pub(super) const REFERENCE: &str = "Into the frame of";
pub(super) const PAIRS: &str = "Points picked in both";
pub(super) const RESIDUAL: &str = "They agree to";
pub(super) const CONTRADICTION: &str = "These points contradict each other: one of them is not the same in both maps. Take it back and pick it again.";
pub(super) const JOB_REQUESTED: &str = "Waiting for the robot's computer to begin.";
pub(super) const REMOVE_POINT: &str = "Take the last point back";
pub(super) const REMOVE_POINT_SHORT: &str = "Take back";
pub(super) const REMOVE_POINT_KEYS: &str = "Ctrl Z";
pub(super) const START_BY_POINTS: &str = "Align by the points";
pub(super) const START_BY_APPEARANCE: &str = "Align by what both look like";
pub(super) const START_BY_APPEARANCE_HINT: &str =
    "Without points the robot's computer searches for one map in the other. That takes some seconds.";
pub(super) const ENOUGH_POINTS: &str = "These points are enough.";

/// The head of the card, and the button that begins an alignment.
pub(super) fn align(map: &str) -> String {
    format!("Align {map}")
}

pub(super) fn reference(map: &str) -> String {
    format!("Onto {map}")
}

pub(super) fn view(map: &str) -> String {
    format!("Look at {map}")
}

pub(super) fn start_by_points_short(pairs: usize) -> String {
    format!("Align by {pairs} pairs")
}

pub(super) fn step_view(map: &str) -> String {
    format!("Look at {map} for the next point.")
}

pub(super) fn step_first_point(map: &str, number: usize) -> String {
    format!("Point {number}: click a corner or a pipe's end that {map} and the other map both show.")
}

pub(super) fn step_second_point(map: &str) -> String {
    format!("Click the same point here, in {map}.")
}
