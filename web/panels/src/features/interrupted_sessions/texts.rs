//! Texts of interrupted mapping sessions, by key.

pub(super) const HEAD: &str = "Interrupted mapping";
pub(super) const RESUME: &str = "Go on mapping";
pub(super) const SAVE: &str = "Save interrupted map";
pub(super) const DISCARD: &str = "Discard interrupted map";
pub(super) const DISCARD_SHORT: &str = "Discard…";
pub(super) const CONFIRM_DISCARD: &str = "Discard it for good";
pub(super) const KEEP: &str = "Keep it";
pub(super) const DAMAGED: &str = "A mapping session was interrupted, and its files are damaged. It cannot be saved. Its clouds are kept until it is discarded.";
pub(super) const DISCARD_WARNING: &str = "Discard the interrupted map? It cannot be restored.";

/// A session was interrupted after this number of keyframes.
pub(super) fn interrupted(when: &str, keyframes: u32, distance: &str) -> String {
    let noun = if keyframes == 1 { "keyframe" } else { "keyframes" };
    format!("Interrupted on {when}, {keyframes} {noun}, {distance}. Go on or save?")
}

/// Name of a map that is not named by anybody.
pub(super) fn default_map_name(number: usize) -> String {
    format!("Map {number}")
}
