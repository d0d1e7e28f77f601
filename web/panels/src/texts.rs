//! Texts that no feature owns, by key: words beside numbers, names of tabs that several features share, and names of parts of the frame. English.

/// Stands for a number that is too uncertain to be shown.
pub(crate) const UNKNOWN: &str = "unknown";
/// Stands for the name of a map that is not in the list.
pub(crate) const UNKNOWN_MAP: &str = "the map";
/// Accessible name of a message. Its value is the sentence.
pub(crate) const MESSAGE: &str = "Message";

/// Adds a corner to an area.
pub(crate) const ADD_CORNER: &str = "Add a corner";
/// Name of the field for the tags of an object.
pub(crate) const TAGS: &str = "Tags";
/// Shown while an object has no tags.
pub(crate) const TAGS_HINT: &str = "Words, with commas between them";

/// Name of the field for a property that an object does not have yet.
pub(crate) const NEW_PROPERTY: &str = "New property";
/// Shown while nothing is typed there.
pub(crate) const NEW_PROPERTY_HINT: &str = "Name: value";
/// Shown while the value of a property is emptied.
pub(crate) const PROPERTY_VALUE_HINT: &str = "Leave it empty to remove it";

/// Name of the tab with what the robot reports of itself.
pub(crate) const ROBOT_TAB: &str = "Robot";
/// Name of the tab with the mapping session and the saved maps.
pub(crate) const SESSION_TAB: &str = "Session";
/// Name of the tab with missions.
pub(crate) const MISSIONS_TAB: &str = "Missions";

/// A month, from 1, short. Empty for a number that is none.
pub(crate) fn month(number: u8) -> &'static str {
    const MONTHS: [&str; 12] =
        ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
    usize::from(number).checked_sub(1).and_then(|index| MONTHS.get(index)).copied().unwrap_or_default()
}

/// Name of the field of a coordinate of a corner.
pub(crate) fn coordinate(number: usize, axis: usize) -> String {
    format!("{number}: {} (m)", ["x", "y"][axis])
}

/// Name of the button that removes a corner.
pub(crate) fn remove_corner(number: usize) -> String {
    format!("Remove corner {number}")
}

/// `12 s old`, of a duration with its unit.
pub(crate) fn old(duration: &str) -> String {
    format!("{duration} old")
}

/// `1.24 million`.
pub(crate) fn millions(number: f64) -> String {
    format!("{number:.2} million")
}

/// `1 day`, `6 days`.
pub(crate) fn days(number: u64) -> String {
    if number == 1 { "1 day".to_owned() } else { format!("{number} days") }
}
