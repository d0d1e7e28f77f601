//! A draft of the site: edits that gather in this client until they are published as one, or discarded.
//!
//! A draft holds, for each object that it changes, what the object was when the draft changed it first, and what it is in the draft. What others change meanwhile
//! shows at once in all other objects. Where somebody has changed the same object differently, the operator decides which of the two counts.

use serde::{Deserialize, Serialize};
use site_model::{Change, Edit, EditId, Object, ObjectId, Site};
use std::collections::BTreeMap;

/// What the operator does with the draft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DraftCommand {
    /// Edits go into the draft from now on.
    Begin,
    /// The site gets all of it as one edit.
    Publish,
    /// It ends, and its changes are gone. It can be undone.
    Discard,
    /// Of an object that somebody else has changed too, one of the two counts.
    Resolve {
        /// Which object.
        object: ObjectId,
        /// Whether it is that of the draft.
        keep_mine: bool,
    },
}

/// A draft that was sent to be published.
#[derive(Clone, Debug)]
pub(super) struct PublishedDraft {
    /// The edit as which it was sent.
    pub(super) edit: EditId,
    /// What it held.
    pub(super) changes: Vec<DraftChange>,
}

/// Parameters of a draft.
struct DraftConfig {
    /// Steps of undo that are kept. Chosen: as the history of all features.
    max_steps: usize,
}

const CONFIG: DraftConfig = DraftConfig { max_steps: 200 };

/// One object of a draft. `None` stands for an object that is not there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DraftChange {
    /// What it was when the draft changed it first.
    pub before: Option<Object>,
    /// What it is in the draft.
    pub mine: Option<Object>,
}

/// What a draft does with an object, beside what the site has.
#[derive(Clone, Debug, PartialEq)]
pub struct DraftEntry<'a> {
    /// Which object.
    pub id: ObjectId,
    /// What it was when the draft changed it first.
    pub before: Option<&'a Object>,
    /// What the site has.
    pub theirs: Option<&'a Object>,
    /// What the draft has.
    pub mine: Option<&'a Object>,
    /// Whether somebody has changed it differently since the draft did.
    pub is_conflict: bool,
}

/// Changes of a draft as the browser keeps them over a reload.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StoredDraft {
    /// Whether edits go into the draft.
    pub is_on: bool,
    /// What it changes.
    pub changes: Vec<DraftChange>,
}

/// One step of undo: what it replaced, and by what.
#[derive(Clone, Debug, PartialEq)]
struct Step {
    was_on: bool,
    changes: Vec<(ObjectId, Option<DraftChange>)>,
}

/// The draft with its own steps of undo.
#[derive(Clone, Debug, Default)]
pub(super) struct Draft {
    is_on: bool,
    changes: BTreeMap<ObjectId, DraftChange>,
    past: Vec<Step>,
    future: Vec<Step>,
}

impl Draft {
    /// From what was stored. An entry without any object says nothing and is left out.
    pub(super) fn from_stored(stored: StoredDraft) -> Self {
        let keyed = |change: DraftChange| {
            let id = change.mine.as_ref().or(change.before.as_ref())?.id();
            Some((id, change))
        };
        let changes = stored.changes.into_iter().filter_map(keyed).collect();
        Self { is_on: stored.is_on, changes, ..Self::default() }
    }

    pub(super) fn to_stored(&self) -> StoredDraft {
        StoredDraft { is_on: self.is_on, changes: self.changes.values().cloned().collect() }
    }

    /// Whether edits go into it.
    pub(super) fn is_on(&self) -> bool {
        self.is_on
    }

    pub(super) fn set_on(&mut self, is_on: bool) {
        self.is_on = is_on;
    }

    /// What it does with each object that is different in `site`.
    pub(super) fn entries<'a>(&'a self, site: &'a Site) -> impl Iterator<Item = DraftEntry<'a>> {
        self.changes.iter().filter_map(|(id, change)| {
            let theirs = site.get(*id).map(|versioned| &versioned.object);
            let mine = change.mine.as_ref();
            let is_conflict = theirs != change.before.as_ref();
            (mine != theirs).then_some(DraftEntry {
                id: *id,
                before: change.before.as_ref(),
                theirs,
                mine,
                is_conflict,
            })
        })
    }

    /// The site with the draft in it.
    pub(super) fn applied_to(&self, site: &Site) -> Site {
        let mut shown = site.clone();
        let edit = self.edit(EditId(uuid::Uuid::nil()), site);
        // Every change has the revision that the site has, so it fits.
        let _ = shown.apply(&edit, edit.id);
        shown
    }

    /// The edit of `site` that publishes all of it.
    pub(super) fn edit(&self, id: EditId, site: &Site) -> Edit {
        let changes = self.entries(site).filter_map(|entry| {
            let base = site.revision(entry.id);
            match entry.mine {
                Some(object) => Some(Change::Put { base, object: object.clone() }),
                None => base.map(|base| Change::Remove { base, object: entry.id }),
            }
        });
        Edit { id, changes: changes.collect() }
    }

    /// Takes an edit of the shown site into the draft. Returns whether anything changed.
    pub(super) fn add(&mut self, edit: &Edit, site: &Site) -> bool {
        let change = |change: &Change| {
            let id = change.object_id();
            let before = match self.changes.get(&id) {
                Some(known) => known.before.clone(),
                None => site.get(id).map(|versioned| versioned.object.clone()),
            };
            let mine = match change {
                Change::Put { object, .. } => Some(object.clone()),
                Change::Remove { .. } => None,
            };
            (id, (mine != before).then_some(DraftChange { before, mine }))
        };
        let changes = edit.changes.iter().map(change).collect();
        self.apply_step(Step { was_on: true, changes })
    }

    /// Decides a conflict: the draft's object counts, or that of the site.
    pub(super) fn resolve(&mut self, id: ObjectId, keep_mine: bool, site: &Site) -> bool {
        let Some(change) = self.changes.get(&id) else { return false };
        let theirs = site.get(id).map(|versioned| versioned.object.clone());
        let kept = keep_mine.then(|| DraftChange { before: theirs, mine: change.mine.clone() });
        self.apply_step(Step { was_on: true, changes: vec![(id, kept)] })
    }

    /// Takes everything out and ends it. It can be undone.
    pub(super) fn discard(&mut self) -> bool {
        let changes = self.changes.keys().map(|id| (*id, None)).collect();
        self.apply_step(Step { was_on: false, changes })
    }

    /// Ends it without a step of undo: all of it is published. Returns its changes, for [`Self::restore`].
    pub(super) fn take_published(&mut self) -> Vec<DraftChange> {
        let changes = std::mem::take(&mut self.changes).into_values().collect();
        *self = Self::default();
        changes
    }

    /// Goes on with changes that could not be published. Later ones count more.
    pub(super) fn restore(&mut self, changes: Vec<DraftChange>) {
        let restored = Self::from_stored(StoredDraft { is_on: true, changes });
        self.is_on = true;
        for (id, change) in restored.changes {
            self.changes.entry(id).or_insert(change);
        }
    }

    /// Undoes the last step. Returns whether there was one.
    pub(super) fn undo(&mut self) -> bool {
        let Some(step) = self.past.pop() else { return false };
        let opposite = self.swap(step);
        self.future.push(opposite);
        true
    }

    /// Does the step again that was undone last. Returns whether there was one.
    pub(super) fn redo(&mut self) -> bool {
        let Some(step) = self.future.pop() else { return false };
        let opposite = self.swap(step);
        self.past.push(opposite);
        true
    }

    fn apply_step(&mut self, step: Step) -> bool {
        let is_new = step.was_on != self.is_on
            || step.changes.iter().any(|(id, change)| self.changes.get(id) != change.as_ref());
        if is_new {
            let opposite = self.swap(step);
            self.past.push(opposite);
            self.future.clear();
            if self.past.len() > CONFIG.max_steps {
                self.past.remove(0);
            }
        }
        is_new
    }

    /// Makes a step; returns the one that takes it back.
    fn swap(&mut self, step: Step) -> Step {
        let was_on = std::mem::replace(&mut self.is_on, step.was_on);
        let swapped = step.changes.into_iter().map(|(id, change)| {
            let before = match change {
                Some(change) => self.changes.insert(id, change),
                None => self.changes.remove(&id),
            };
            (id, before)
        });
        Step { changes: swapped.collect(), was_on }
    }
}
