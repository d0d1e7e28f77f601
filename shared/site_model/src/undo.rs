//! What one person can undo and redo, while others edit the same site.

use crate::{Applied, Change, Edit, EditError, EditId, ObjectId, Revision, RevisionChange, Site};
use std::collections::BTreeMap;

/// The edits of one person that can be undone, and those that were undone and can be redone.
///
/// An undone object has a new revision, but its earlier content. Earlier edits of the same person refer to the revision that had this content, so they are
/// made to refer to the new one. Objects that somebody else has changed since are not undone: [`Site::apply`] reports the conflict.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UndoHistory {
    undo: Vec<Step>,
    redo: Vec<Step>,
}

/// An edit that takes a step back or forward.
#[derive(Clone, Debug, PartialEq)]
struct Step {
    edit: Edit,
    /// The revisions whose content it brings back.
    restores: BTreeMap<ObjectId, Revision>,
}

impl Step {
    fn new(applied: Applied) -> Self {
        let before = applied.revisions.iter().filter_map(|change| Some((change.object, change.before?)));
        Self { restores: before.collect(), edit: applied.inverse }
    }

    /// Refers to `after` where it referred to `before`, which has the same content.
    fn rename(&mut self, object: ObjectId, before: Revision, after: Revision) {
        for change in self.edit.changes.iter_mut().filter(|change| change.object_id() == object) {
            match change {
                Change::Put { base: Some(base), .. } | Change::Remove { base, .. } if *base == before => {
                    *base = after;
                }
                _ => {}
            }
        }
        if let Some(restored) = self.restores.get_mut(&object).filter(|restored| **restored == before) {
            *restored = after;
        }
    }
}

impl UndoHistory {
    /// Adds an edit that the person has made. What was undone before can no longer be redone.
    pub fn record(&mut self, applied: Applied) {
        self.redo.clear();
        self.undo.push(Step::new(applied));
    }

    /// Forgets an edit that was not applied after all, with all steps that refer to the revisions which it would have made: these revisions belong to others. The
    /// edit must have been applied here under its own id as the name of its inverse.
    pub fn forget(&mut self, id: EditId, revisions: &[RevisionChange]) {
        let refers = |change: &Change| {
            let made = revisions.iter().find(|made| made.object == change.object_id());
            made.is_some_and(|made| change.base() == made.after)
        };
        for steps in [&mut self.undo, &mut self.redo] {
            steps.retain(|step| step.edit.id != id && !step.edit.changes.iter().any(refers));
        }
    }

    /// Number of steps that can be undone.
    pub fn undo_len(&self) -> usize {
        self.undo.len()
    }

    /// Whether there is something to undo.
    pub fn can_undo(&self) -> bool {
        !self.undo.is_empty()
    }

    /// Whether there is something to redo.
    pub fn can_redo(&self) -> bool {
        !self.redo.is_empty()
    }

    /// Undoes the person's last edit in `site`. Returns the edit that did it, named `id`; none if there is nothing to undo.
    ///
    /// # Errors
    /// When somebody else has changed one of its objects since. The edit is then given up, and the next call undoes the one before.
    pub fn undo(&mut self, site: &mut Site, id: EditId) -> Result<Option<Edit>, EditError> {
        let Some(step) = self.undo.pop() else { return Ok(None) };
        let (edit, opposite) = self.apply_step(step, site, id)?;
        self.redo.push(opposite);
        Ok(Some(edit))
    }

    /// Makes the edit again that was undone last. Otherwise as [`Self::undo`].
    ///
    /// # Errors
    /// As for [`Self::undo`].
    pub fn redo(&mut self, site: &mut Site, id: EditId) -> Result<Option<Edit>, EditError> {
        let Some(step) = self.redo.pop() else { return Ok(None) };
        let (edit, opposite) = self.apply_step(step, site, id)?;
        self.undo.push(opposite);
        Ok(Some(edit))
    }

    /// Applies a step to `site`, and makes the other steps refer to the revisions after it. Returns the edit and the opposite step.
    fn apply_step(&mut self, step: Step, site: &mut Site, id: EditId) -> Result<(Edit, Step), EditError> {
        let edit = Edit { id, ..step.edit };
        let applied = site.apply(&edit, id)?;
        for change in &applied.revisions {
            if let (Some(before), Some(after)) = (step.restores.get(&change.object), change.after) {
                for other in self.undo.iter_mut().chain(&mut self.redo) {
                    other.rename(change.object, *before, after);
                }
            }
        }
        Ok((edit, Step::new(applied)))
    }
}
