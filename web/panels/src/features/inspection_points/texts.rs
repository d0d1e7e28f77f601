//! Texts of inspection points, by key.

use crate::format;
use crate::name_field::NameFieldTexts;

pub(super) const HISTORY: &str = "History of this point";
pub(super) const TAB: &str = "Inspection points";
pub(super) const HEAD: &str = "Inspection points";
pub(super) const LOADING: &str = "The site has not arrived from the robot yet.";
pub(super) const OTHER_MAP: &str =
    "Targets are picked in the map of the site. View it on the tab of the topological map.";
pub(super) const ADD: &str = "Add inspection points";
pub(super) const ADD_REMARK: &str =
    "Each click on a thing in the map makes one. The robot looks from the nearest node that sees it.";
pub(super) const ADD_HINT: &str = "Click the things in the map that the robot shall look at. Escape ends it.";
pub(super) const PICK_HINT: &str = "Click the thing in the map that the robot shall look at. Escape ends it.";
pub(super) const NO_NODES: &str = "The robot looks at things from nodes. Make the topological map first.";
pub(super) const EMPTY: &str = "There are no inspection points yet.";
pub(super) const VIEW_HEAD: &str = "View";
pub(super) const NAME_FIELD: NameFieldTexts = NameFieldTexts {
    field: "Inspection point name",
    rename: "Rename inspection point",
    rename_short: "Rename",
};
pub(super) const NODE: &str = "Seen from";
pub(super) const STAND_OFF: &str = "Stand-off";
pub(super) const STAND_OFF_FIELD: &str = "Stand off (m)";
pub(super) const FACE: &str = "Turn the node to the target";
pub(super) const SIGHT: &str = "Camera view";
pub(super) const UNCHECKED: &str = "The points of the map are being looked at.";
pub(super) const TILT_IMPOSSIBLE: &str =
    "The camera cannot tilt that far. Stand farther off, or choose another node.";
pub(super) const TARGET: &str = "Target";
pub(super) const MOVE_TARGET: &str = "Pick the target anew";
pub(super) const SHOW: &str = "Show the target";
pub(super) const ACTION: &str = "Action";
pub(super) const ASSET: &str = "Asset";
pub(super) const NO_ASSET: &str = "None";
pub(super) const LIMITS_HEAD: &str = "Limits of the reading";
pub(super) const READING: &str = "Reading";
pub(super) const NOT_JUDGED: &str = "Not judged";
pub(super) const NO_LIMIT: &str = "None";
pub(super) const LIMITS_REMARK: &str =
    "The Runs screen marks readings of this unit that are below or above. An empty field is no limit.";

/// Units of readings, with what is read in them.
const UNITS: [(&str, &str); 5] = [
    ("°C", "Temperature (°C)"),
    ("%", "Humidity (%)"),
    ("1/s", "Count rate (1/s)"),
    ("µSv/h", "Dose rate (µSv/h)"),
    ("bar", "Pressure (bar)"),
];

/// Units of what an action reads; of an action that the platform does not know, all.
pub(super) fn units(action: &str) -> &'static [(&'static str, &'static str)] {
    match action {
        "thermal_photo" => &UNITS[..1],
        "temperature_humidity" => &UNITS[..2],
        "gamma_spectrum" => &UNITS[2..4],
        _ => &UNITS,
    }
}

/// Name of the field of a limit.
pub(super) fn limit(is_max: bool, unit: &str) -> String {
    format!("{} ({unit})", if is_max { "At most" } else { "At least" })
}

pub(super) const DELETE_SHORT: &str = "Delete";

pub(super) fn point(name: &str) -> String {
    format!("Inspection point {name}")
}

pub(super) fn row(name: &str, node: &str) -> String {
    format!("{name} · from {node}")
}

pub(super) fn delete(name: &str) -> String {
    format!("Delete inspection point {name}")
}

pub(super) fn needed_by(missions: &[&str]) -> String {
    format!("Needed by: {}. Their tasks here will have to be changed.", missions.join(", "))
}

/// The line of sight ends at the target.
pub(super) fn clear(distance_m: f64) -> String {
    format!("Nothing stands in the way. The target is {} from the camera.", format::distance(distance_m))
}

pub(super) fn blocked(blocked_m: f64) -> String {
    format!(
        "Something stands in the way, {} from the camera. Choose another node or target.",
        format::distance(blocked_m)
    )
}

/// Other points that a change of the node concerns.
pub(super) fn shared_node(node: &str, points: &[&str]) -> String {
    format!("{node} moves for these too: {}.", points.join(", "))
}

/// A node from which a target can be seen, with its distance.
pub(super) fn node_option(name: &str, distance_m: f64) -> String {
    format!("{name} · {}", format::distance(distance_m))
}
