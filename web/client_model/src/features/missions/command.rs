//! What the operator asks of the mission editor.

use super::drag::TaskDrag;
use site_model::{MissionId, TaskId};
use std::collections::BTreeSet;

/// A command that changes what is shown of a mission, and nothing of the site. Edits are [`crate::ClientCommand::EditSite`].
#[derive(Clone, Debug, PartialEq)]
pub enum MissionEditorCommand {
    /// Edit this mission; `None`: show the list of missions.
    Open(Option<MissionId>),
    /// Select these tasks and no others.
    Select(BTreeSet<TaskId>),
    /// Begin to drag tasks, or drag them on.
    Drag(TaskDrag),
    /// End the drag. Where the tasks were dropped is an edit of the site.
    EndDrag,
    /// Show the shortest order before it is chosen, or no longer.
    ProposeOrder(bool),
}
