//! Texts of the beginning, by key.

use api::ImportStage;

pub(super) const HEAD: &str = "Start here";
pub(super) const EMPTY: &str = "There is no map yet. Robots find their way, and inspect, in a map.";
pub(super) const EXPLORE: &str = "Explore the example";
pub(super) const EXPLORE_HINT: &str = "A test hall with its map, nine inspection points, a mission and a schedule. A simulated robot walks through it first, \
     which takes about a minute.";
pub(super) const LOOKING_ONLY: &str =
    "Your robot is not in this hall. You can look at everything, but the mission cannot run.";
pub(super) const MAP_OWN: &str = "Map your own";
pub(super) const MAP_OWN_HINT: &str =
    "Drive the robot once through your site. Its map, and all that is built on it, follow from that walk.";
pub(super) const DISMISS: &str = "Not now";

pub(super) const MAKING: &str = "Making the example";
pub(super) const STATE: &str = "Example";
pub(super) const CANCEL: &str = "Cancel the example";

/// What is done in a stage.
pub(super) fn stage(stage: ImportStage) -> &'static str {
    match stage {
        ImportStage::Walking => "A simulated robot walks through the hall and maps it",
        ImportStage::Writing | ImportStage::Reading | ImportStage::ComputingViewpoints => "The map is saved",
        ImportStage::MakingTopomap => "Nodes, ways and inspection points are found",
    }
}

/// Value of the progress in the accessible tree.
pub(super) fn progress(activity: &str, percent: &str) -> String {
    format!("{activity}, {percent}")
}

pub(super) fn failed(reason: &str) -> String {
    format!("The example could not be made. {reason}")
}
