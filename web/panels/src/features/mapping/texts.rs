//! Texts of mapping, by key.

pub(super) const HEAD: &str = "Make a map";
pub(super) const START: &str = "Start mapping";
pub(super) const START_PENDING: &str = "Starting…";
pub(super) const CANCEL: &str = "Cancel mapping";
pub(super) const FINISH: &str = "Finish and save";
pub(super) const DISCARD: &str = "Discard";
pub(super) const DISCARD_SHORT: &str = "Discard…";
pub(super) const CONFIRM_DISCARD: &str = "Discard map";
pub(super) const KEEP_MAPPING: &str = "Keep mapping";
pub(super) const MAP_NAME: &str = "Map name";

pub(super) const STATE: &str = "Mapping";
pub(super) const STARTING: &str = "Finding gravity";
pub(super) const LOADING: &str = "Reading the map";
pub(super) const LOCALISING: &str = "Localising in the map";
pub(super) const RUNNING: &str = "Mapping";
pub(super) const SAVING: &str = "Saving the map";

pub(super) const ELAPSED: &str = "Elapsed";
pub(super) const DISTANCE: &str = "Distance";
pub(super) const KEYFRAMES: &str = "Keyframes";
pub(super) const GROUND: &str = "Ground";
pub(super) const POINTS: &str = "Points in map";
pub(super) const EXTENDS: &str = "Extends";
pub(super) const LOCALISING_DISTANCE: &str = "Driven so far";

pub(super) const FIRST_MAP_HINT: &str = "No map yet. Put the robot where it can stand still for a moment, start mapping, \
     then drive it through every room. Finish where you began: that makes the map most exact.";
pub(super) const MAP_HINT: &str =
    "Let the robot stand still, start mapping, drive it through every room, and finish where you began.";
pub(super) const STARTING_HINT: &str =
    "Keep the robot still for a few seconds. Mapping then begins by itself.";
pub(super) const SAVING_HINT: &str =
    "The map is shown as soon as it is written. You may go on driving meanwhile.";
pub(super) const DISCARD_WARNING: &str = "Discard this map? It cannot be restored.";

pub(super) fn control_needed_to_map(holder: &str) -> String {
    format!("{holder} controls the robot. Take control to map.")
}

pub(super) fn control_needed_to_finish(holder: &str) -> String {
    format!("{holder} controls the robot. Take control to finish.")
}

pub(super) fn loading_hint(map: &str) -> String {
    format!("{map} is being read.")
}

pub(super) fn localising_hint(map: &str, distance_m: f64) -> String {
    format!(
        "Drive the robot some {distance_m:.0} m through a part that {map} shows. It is then localised by itself."
    )
}

pub(super) fn ambiguous_hint(map: &str) -> String {
    format!("The scans so far fit {map} in two places. Drive to a part that exists only once.")
}

/// Whether the robot is where the extended map already shows everything.
pub(super) fn ground(is_known: bool) -> &'static str {
    if is_known { "Known: nothing to add" } else { "New" }
}

/// Name of a map that is not named by anybody.
pub(super) fn default_map_name(number: usize) -> String {
    format!("Map {number}")
}
