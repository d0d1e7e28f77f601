//! The operator's edits that the robot has not confirmed, in the order in which they were made.

use site_model::{Change, Edit, EditId, ObjectId, RevisionChange, Site};
use std::collections::BTreeSet;

/// An edit that is not confirmed.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PendingEdit {
    pub(super) edit: Edit,
    /// Revisions that it makes, if it is applied.
    pub(super) revisions: Vec<RevisionChange>,
    /// Earlier edits of the same objects that it was built on.
    depends_on: BTreeSet<EditId>,
    is_sent: bool,
    /// Revision of the site after it, once the robot has said it.
    applied: Option<u64>,
    /// Whether the operator sees it: not while somebody else's change is in its way.
    is_shown: bool,
}

impl PendingEdit {
    fn touches(&self, edit: &Edit) -> bool {
        let ids: BTreeSet<ObjectId> = edit.changes.iter().map(Change::object_id).collect();
        self.edit.changes.iter().any(|change| ids.contains(&change.object_id()))
    }
}

/// All of them.
#[derive(Clone, Debug, Default)]
pub(super) struct PendingEdits {
    edits: Vec<PendingEdit>,
}

impl PendingEdits {
    pub(super) fn len(&self) -> usize {
        self.edits.len()
    }

    /// Adds an edit that was applied to what is shown.
    pub(super) fn add(&mut self, edit: Edit, revisions: Vec<RevisionChange>) {
        let earlier = self.edits.iter().filter(|earlier| earlier.is_shown && earlier.touches(&edit));
        let depends_on = earlier.map(|earlier| earlier.edit.id).collect();
        self.edits.push(PendingEdit {
            edit,
            revisions,
            depends_on,
            is_sent: false,
            applied: None,
            is_shown: true,
        });
    }

    /// Whether any of them changes an object of this edit.
    pub(super) fn touches(&self, edit: &Edit) -> bool {
        self.edits.iter().any(|pending| pending.touches(edit))
    }

    /// Applies all that can be to the confirmed site.
    pub(super) fn apply_to(&mut self, site: &mut Site) {
        let mut hidden = BTreeSet::new();
        for pending in &mut self.edits {
            pending.is_shown =
                pending.depends_on.is_disjoint(&hidden) && site.apply(&pending.edit, pending.edit.id).is_ok();
            if !pending.is_shown {
                hidden.insert(pending.edit.id);
            }
        }
    }

    /// The edits that may be sent, now counted as sent: `max` are sent and not confirmed at most, and none of the same objects as an earlier one.
    pub(super) fn take_sendable(&mut self, max: usize) -> impl Iterator<Item = Edit> {
        let mut busy = BTreeSet::new();
        let mut sent = self.edits.iter().filter(|pending| pending.is_sent).count();
        let mut sendable = Vec::new();
        for pending in &mut self.edits {
            if sent >= max {
                break;
            }
            let ids: Vec<ObjectId> = pending.edit.changes.iter().map(Change::object_id).collect();
            if !pending.is_sent && !ids.iter().any(|id| busy.contains(id)) {
                pending.is_sent = true;
                sent += 1;
                sendable.push(pending.edit.clone());
            }
            busy.extend(ids);
        }
        sendable.into_iter()
    }

    /// The confirmed site holds this edit. Returns whether it was pending and shown.
    pub(super) fn confirm(&mut self, id: EditId) -> bool {
        let Some(index) = self.edits.iter().position(|pending| pending.edit.id == id) else { return false };
        self.edits.remove(index).is_shown
    }

    /// The robot has said that an edit led to this revision.
    pub(super) fn set_applied(&mut self, id: EditId, revision: u64) {
        if let Some(pending) = self.find(id) {
            pending.applied = Some(revision);
        }
    }

    /// The confirmed site holds all edits up to this revision. Returns whether any of them was pending.
    pub(super) fn confirm_up_to(&mut self, revision: u64) -> bool {
        let before = self.edits.len();
        self.edits.retain(|pending| pending.applied.is_none_or(|applied| applied > revision));
        self.edits.len() < before
    }

    /// An edit has to be sent again.
    pub(super) fn set_unsent(&mut self, id: EditId) {
        if let Some(pending) = self.find(id) {
            pending.is_sent = false;
        }
    }

    /// All have to be sent again.
    pub(super) fn set_all_unsent(&mut self) {
        self.edits.iter_mut().for_each(|pending| pending.is_sent = false);
    }

    /// Removes an edit and all that were built on it.
    pub(super) fn drop_with_dependents(&mut self, id: EditId) -> Vec<PendingEdit> {
        let mut ids = BTreeSet::from([id]);
        let (mut dropped, mut kept) = (Vec::new(), Vec::new());
        for pending in self.edits.drain(..) {
            if pending.edit.id == id || !pending.depends_on.is_disjoint(&ids) {
                ids.insert(pending.edit.id);
                dropped.push(pending);
            } else {
                kept.push(pending);
            }
        }
        self.edits = kept;
        dropped
    }

    fn find(&mut self, id: EditId) -> Option<&mut PendingEdit> {
        self.edits.iter_mut().find(|pending| pending.edit.id == id)
    }
}
