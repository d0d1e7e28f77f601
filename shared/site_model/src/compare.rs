//! Comparing two states of a site, and merging two that come from a common one.

use crate::{Change, Edit, EditId, Object, ObjectId, Site};
use std::collections::BTreeSet;

/// The edit, named `id`, that turns the objects of `from` into those of `to`. Revisions are not compared. Linear in both.
pub fn diff(id: EditId, from: &Site, to: &Site) -> Edit {
    let changes = ids_of(&[from, to]).into_iter().filter_map(|object| {
        let (before, after) = (from.get(object), to.get(object));
        match (before, after) {
            (before, Some(after)) if before.is_none_or(|before| before.object != after.object) => {
                let base = before.map(|before| before.revision);
                Some(Change::Put { base, object: after.object.clone() })
            }
            (Some(before), None) => Some(Change::Remove { base: before.revision, object }),
            _ => None,
        }
    });
    Edit { id, changes: changes.collect() }
}

/// An object that both sides have changed, in different ways. None stands for an object that is not there.
#[derive(Clone, Debug, PartialEq)]
pub struct MergeConflict {
    /// Which.
    pub object: ObjectId,
    /// What it was.
    pub before: Option<Object>,
    /// What it is here.
    pub ours: Option<Object>,
    /// What it is there.
    pub theirs: Option<Object>,
}

/// Result of [`merge`].
#[derive(Clone, Debug, PartialEq)]
pub struct Merged {
    /// Changes of `ours` that bring in what only `theirs` changed.
    pub edit: Edit,
    /// What a person has to decide. These objects stay as they are in `ours`.
    pub conflicts: Vec<MergeConflict>,
}

/// Merges `theirs` into `ours`, which both come from `before`. Objects that only one side changed are taken from that side. Linear in all three.
pub fn merge(id: EditId, before: &Site, ours: &Site, theirs: &Site) -> Merged {
    let mut merged = Merged { edit: Edit { id, changes: Vec::new() }, conflicts: Vec::new() };
    for object in ids_of(&[before, ours, theirs]) {
        let [was, here, there] =
            [before, ours, theirs].map(|site| site.get(object).map(|versioned| &versioned.object));
        if there == was || there == here {
            continue;
        }
        if here != was {
            let [before, ours, theirs] = [was, here, there].map(|object| object.cloned());
            merged.conflicts.push(MergeConflict { object, before, ours, theirs });
            continue;
        }
        let base = ours.revision(object);
        merged.edit.changes.extend(match (there, base) {
            (Some(there), base) => Some(Change::Put { base, object: there.clone() }),
            (None, Some(base)) => Some(Change::Remove { base, object }),
            (None, None) => None,
        });
    }
    merged
}

fn ids_of(sites: &[&Site]) -> BTreeSet<ObjectId> {
    sites.iter().flat_map(|site| site.objects().map(|versioned| versioned.object.id())).collect()
}
