//! Texts of viewing a saved map, by key.

use crate::format;

pub(super) const BACK: &str = "Back to live";

pub(super) fn opening(map: &str) -> String {
    format!("Opening {map}…")
}

/// While points of the map are still on their way.
pub(super) fn loading(map: &str, loaded: u64, all: u64) -> String {
    format!("{map} · {} of {} points", format::points(loaded), format::points(all))
}

pub(super) fn loaded(map: &str, points: u64) -> String {
    format!("{map} · {} points", format::points(points))
}
