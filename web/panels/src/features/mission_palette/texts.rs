//! Texts of the palette, by key.

use client_model::NewTask;

pub(super) const CARD: &str = "Places and actions";
pub(super) const HEAD: &str = "Places and actions";
pub(super) const HINT: &str = "Drag into the list, or press to add behind what is selected.";
pub(super) const SEARCH: &str = "Search places and actions";
pub(super) const SEARCH_HINT: &str = "Search";
pub(super) const POINTS: &str = "Inspection points";
pub(super) const ACTIONS: &str = "Actions";
pub(super) const NODES: &str = "Nodes";
pub(super) const NOTHING: &str = "Nothing has this name.";
pub(super) const NO_POINTS: &str =
    "There are no inspection points yet. Add them on the Site screen, or use nodes and actions.";

/// Accessible name of an entry.
pub(super) fn add(new: NewTask, title: &str) -> String {
    match new {
        NewTask::InspectionPoint(_) => format!("Add inspection point {title}"),
        NewTask::Node(_) => format!("Add node {title}"),
        NewTask::Action(_) => format!("Add action {title}"),
    }
}
