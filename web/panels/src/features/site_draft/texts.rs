//! Texts of the draft, by key.

use super::row_kind::RowKind;
use client_model::FieldChange;
use site_model::ObjectKind;

pub(super) const TAB: &str = "Draft";
pub(super) const HEAD: &str = "Draft";
pub(super) const LOADING: &str = "The site has not arrived from the robot yet.";
pub(super) const EXPLANATION: &str = "Edits take effect at once. In a draft they gather here, and the robot gets all of them when you publish it. The draft is kept when the page is closed.";
pub(super) const BEGIN: &str = "Edit as draft";
pub(super) const CHANGES: &str = "Changes";
pub(super) const PUBLISH: &str = "Publish";
pub(super) const DISCARD: &str = "Discard the draft";
pub(super) const DISCARD_HINT: &str = "It can be undone.";
pub(super) const END: &str = "End the draft";
pub(super) const EMPTY: &str =
    "Nothing is changed yet. Edit the map, inspection points, missions or schedules.";
pub(super) const SHOW: &str = "Show the draft";
pub(super) const SHOW_SHORT: &str = "Show";
pub(super) const THEIRS: &str = "Somebody else has changed it meanwhile:";
pub(super) const MINE: &str = "Keep mine";
pub(super) const THEIRS_SHORT: &str = "Take theirs";

pub(super) fn banner(changes: usize) -> String {
    match changes {
        0 => "You edit a draft. The robot works with what is published.".to_owned(),
        1 => "Draft: 1 change is not published. The robot works with what is.".to_owned(),
        changes => format!("Draft: {changes} changes are not published. The robot works with what is."),
    }
}

pub(super) fn conflicts(count: usize) -> String {
    let objects = if count == 1 { "1 object was".to_owned() } else { format!("{count} objects were") };
    format!("{objects} changed by somebody else too. Choose which of the two counts.")
}

/// Kind and name of an object.
pub(super) fn object(kind: ObjectKind, name: &str) -> String {
    let kind = match kind {
        ObjectKind::Settings => "Settings of the site",
        ObjectKind::Node => "Node",
        ObjectKind::Edge => "Edge",
        ObjectKind::EdgeBlock => "Block of an edge",
        ObjectKind::Zone => "Zone",
        ObjectKind::Dock => "Dock",
        ObjectKind::Asset => "Asset",
        ObjectKind::InspectionPoint => "Inspection point",
        ObjectKind::Mission => "Mission",
        ObjectKind::Schedule => "Schedule",
        ObjectKind::Monitor => "Monitor",
        ObjectKind::MutexHold => "Hold of edges",
        ObjectKind::SceneChange => "Change",
        ObjectKind::Alert => "Alert",
    };
    format!("{kind} {name}").trim_end().to_owned()
}

pub(super) fn edge(from: &str, to: &str) -> String {
    format!("Edge {from} → {to}")
}

pub(super) fn row(kind: RowKind, name: &str) -> String {
    let done = match kind {
        RowKind::Added => "added",
        RowKind::Changed => "changed",
        RowKind::Removed => "removed",
    };
    format!("{name}: {done}")
}

/// Old and new value of a field.
pub(super) fn field(change: &FieldChange) -> String {
    let shown = |value: &str| if value.is_empty() { "nothing".to_owned() } else { value.to_owned() };
    format!("{}: {} → {}", change.field, shown(&change.before), shown(&change.after))
}

pub(super) fn more(count: usize) -> String {
    format!("And {count} more.")
}

pub(super) fn more_fields(count: usize) -> String {
    format!("And {count} more fields.")
}

/// What removing an object breaks.
pub(super) fn breaks(missions: &[String]) -> String {
    format!("Needed by: {}. Their tasks here will have to be changed.", missions.join(", "))
}

pub(super) fn keep_mine(name: &str) -> String {
    format!("Keep mine: {name}")
}

pub(super) fn take_theirs(name: &str) -> String {
    format!("Take theirs: {name}")
}
