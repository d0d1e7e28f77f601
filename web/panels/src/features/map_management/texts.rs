//! Texts of renaming, deleting and restoring maps, by key.

pub(super) const RENAME_SHORT: &str = "Rename";
pub(super) const DELETE_SHORT: &str = "Delete";
pub(super) const DELETE_DAMAGED_SHORT: &str = "Move to the bin";
pub(super) const NEW_NAME: &str = "New map name";
pub(super) const SAVE_NAME: &str = "Save the name";
pub(super) const SAVE_NAME_SHORT: &str = "Save";
pub(super) const KEEP_NAME: &str = "Keep the name";
pub(super) const KEEP_NAME_SHORT: &str = "Cancel";
pub(super) const UNDO: &str = "Undo";
pub(super) const DISMISS: &str = "Dismiss the deletion";
pub(super) const BIN: &str = "Bin";
pub(super) const BIN_HINT: &str = "Deleted maps are kept for 7 days.";
pub(super) const RESTORE_SHORT: &str = "Restore";
pub(super) const CONFIRM_PERMANENTLY: &str = "Delete for good";
pub(super) const KEEP: &str = "Keep in the bin";
/// Why a map cannot be deleted now, and what to do.
pub(super) const IN_USE: &str = "The robot uses this map. Leave it, then it can be deleted.";
pub(super) const EXTENDED: &str =
    "The mapping session extends this map. Save or discard the session, then it can be deleted.";
pub(super) const INTERRUPTED: &str =
    "An interrupted mapping session extends this map. Save or discard the session, then it can be deleted.";
/// The time is not known at which a map is deleted for good.
pub(super) const NO_CLOCK: &str =
    "Kept until the clock of the robot's computer is synchronised, and 7 days longer.";

pub(super) fn rename(map: &str) -> String {
    format!("Rename {map}")
}

pub(super) fn delete(map: &str) -> String {
    format!("Delete {map}")
}

pub(super) fn restore(map: &str) -> String {
    format!("Restore {map}")
}

pub(super) fn delete_permanently(map: &str) -> String {
    format!("Delete {map} for good")
}

pub(super) fn delete_permanently_warning(map: &str) -> String {
    format!("Delete {map} for good? It cannot be restored then.")
}

/// A map was moved to the bin; `until` is a day.
pub(super) fn deleted(map: &str, until: Option<&str>) -> String {
    match until {
        Some(until) => format!("{map} is in the bin, kept until {until}."),
        None => format!("{map} is in the bin."),
    }
}

/// Text of the button that opens the bin.
pub(super) fn bin(maps: usize) -> String {
    if maps == 1 { "Bin · 1 map".to_owned() } else { format!("Bin · {maps} maps") }
}

/// Accessible name of a map in the bin.
pub(super) fn entry(map: &str) -> String {
    format!("Deleted map {map}")
}

/// `left` as "6 days".
pub(super) fn time_left(left: &str) -> String {
    format!("{left} left")
}
