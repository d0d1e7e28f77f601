//! What the operator can undo, in the order in which it was done: edits of the view and of the site, decisions on loops, deletions of maps.
//!
//! The view keeps its own copies ([`ValueHistory`]). A decision on a loop is kept as the command that undoes it, because the
//! robot holds the graph.

mod undo;

pub use undo::{EditResult, ValueHistory};

use crate::LoopPair;
use vocab::{CommandId, MapId};

/// Parameters of the history.
struct HistoryConfig {
    /// Steps kept of all features together. Chosen: twice those of one feature, more than anybody takes back.
    max_steps: usize,
}

const CONFIG: HistoryConfig = HistoryConfig { max_steps: 200 };

/// A decision on a loop that the operator made on this client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoopEdit {
    /// The loop.
    pub pair: LoopPair,
    /// Whether it was accepted; else it was rejected. Each undoes the other.
    pub accepted: bool,
    /// The command that was sent last for it.
    pub(crate) command: CommandId,
}

/// A step that can be undone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HistoryStep {
    /// The view was edited.
    View,
    /// A loop was decided on.
    Loop(LoopEdit),
    /// The site was edited. Its feature holds what was done.
    Site,
    /// The draft of the site was edited. Its feature holds what was done.
    Draft,
    /// A saved map was deleted. Undone, it is not done again.
    MapDeleted(MapId),
}

/// What was done, and what was undone of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct History {
    past: Vec<HistoryStep>,
    future: Vec<HistoryStep>,
}

impl History {
    /// A step was done; nothing that was undone before can be redone.
    pub(crate) fn add(&mut self, step: HistoryStep) {
        self.future.clear();
        self.past.push(step);
        if self.past.len() > CONFIG.max_steps {
            self.past.remove(0);
        }
    }

    /// The last step done. Whoever undoes it calls [`Self::add_undone`].
    pub(crate) fn take_last(&mut self) -> Option<HistoryStep> {
        self.past.pop()
    }

    /// The last decision on a loop. Whoever undoes it calls [`Self::add_undone`].
    pub(crate) fn take_last_loop(&mut self) -> Option<LoopEdit> {
        let at = self.past.iter().rposition(|step| matches!(step, HistoryStep::Loop(_)))?;
        match self.past.remove(at) {
            HistoryStep::Loop(edit) => Some(edit),
            HistoryStep::View | HistoryStep::Site | HistoryStep::Draft | HistoryStep::MapDeleted(_) => None,
        }
    }

    /// The last step undone. Whoever does it again calls [`Self::add_redone`].
    pub(crate) fn take_undone(&mut self) -> Option<HistoryStep> {
        self.future.pop()
    }

    /// A step was undone.
    pub(crate) fn add_undone(&mut self, step: HistoryStep) {
        self.future.push(step);
    }

    /// A step was done again.
    pub(crate) fn add_redone(&mut self, step: HistoryStep) {
        self.past.push(step);
    }

    /// The decision on a loop that would be undone next.
    pub(crate) fn last_loop(&self) -> Option<&LoopEdit> {
        self.past.iter().rev().find_map(|step| match step {
            HistoryStep::Loop(edit) => Some(edit),
            HistoryStep::View | HistoryStep::Site | HistoryStep::Draft | HistoryStep::MapDeleted(_) => None,
        })
    }

    /// The robot refused a command: its step was neither done nor undone.
    pub(crate) fn forget_command(&mut self, command: CommandId) {
        self.retain_loops(|edit| edit.command != command);
    }

    /// Another session: its keyframes have other ids.
    pub(crate) fn forget_loops(&mut self) {
        self.retain_loops(|_| false);
    }

    /// A deleted map was restored, or deleted for good: its deletion cannot be undone any more.
    pub(crate) fn forget_map(&mut self, map: MapId) {
        self.past.retain(|step| *step != HistoryStep::MapDeleted(map));
    }

    /// The draft of the site was published: its steps cannot be taken one by one any more.
    pub(crate) fn forget_drafts(&mut self) {
        for steps in [&mut self.past, &mut self.future] {
            steps.retain(|step| *step != HistoryStep::Draft);
        }
    }

    fn retain_loops(&mut self, keep: impl Fn(&LoopEdit) -> bool) {
        for steps in [&mut self.past, &mut self.future] {
            steps.retain(|step| match step {
                HistoryStep::Loop(edit) => keep(edit),
                HistoryStep::View | HistoryStep::Site | HistoryStep::Draft | HistoryStep::MapDeleted(_) => {
                    true
                }
            });
        }
    }
}
