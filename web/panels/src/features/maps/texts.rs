//! Texts of saved maps, by key.

use crate::format;
use api::{DamagedMap, MapSummary};

pub(super) const HEAD: &str = "Saved maps";
pub(super) const LOADING: &str = "Waiting for the robot to list them.";
pub(super) const NONE: &str = "None yet.";
pub(super) const VIEW_SHORT: &str = "View";
pub(super) const CLOSE_SHORT: &str = "Close";
pub(super) const EXTEND_SHORT: &str = "Extend this map";
pub(super) const EXTEND_HINT: &str =
    "Goes on mapping where this map ends. This map is kept; the larger one is saved beside it.";

pub(super) fn view(map: &str) -> String {
    format!("View {map}")
}

pub(super) fn close(map: &str) -> String {
    format!("Close {map}")
}

pub(super) fn extend(map: &str) -> String {
    format!("Extend {map}")
}

pub(super) fn entry(map: &str) -> String {
    format!("Saved map {map}")
}

/// Name of a map that cannot be read.
pub(super) fn damaged(map: &DamagedMap) -> String {
    format!("Damaged map {}", map.folder)
}

/// What is wrong with it and what to do, for screen readers.
pub(super) fn damaged_value(map: &DamagedMap) -> String {
    format!("{} {}", map.problem, map.remedy)
}

/// Value of an entry in the accessible tree.
pub(super) fn entry_value(map: &MapSummary, utc_offset_s: i64) -> String {
    format!("{}, {}", format::date(map.created, utc_offset_s), format::distance(map.distance_m))
}

/// Travelled distance, points and bytes of a map. An imported map has no travelled distance.
pub(super) fn size(map: &MapSummary) -> String {
    let size = format!("{} points · {}", format::points(map.points), format::bytes(map.bytes));
    if map.distance_m > 0.0 { format!("{} · {size}", format::distance(map.distance_m)) } else { size }
}
