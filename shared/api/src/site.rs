//! The documents of the site on their way to clients: the whole site in parts, then every edit as it was applied.
//!
//! Whoever has the site of revision `n` and applies the change of revision `n + 1` to it has the site of revision `n + 1`, with the same revisions of all
//! objects. A receiver that misses a change asks for the whole site.

use serde::{Deserialize, Serialize};
use site_model::{Edit, EditError, EditId, ObjectId, Revision, RevisionChange, Site, Versioned};
use std::sync::Arc;
use vocab::ClientId;

/// Changes of one edit at most: a topological map of several thousand nodes that is entered at once.
pub const MAX_EDIT_CHANGES: usize = 20_000;
/// Longest edit, bytes of its encoding.
pub const MAX_EDIT_BYTES: usize = 4 << 20;
/// Largest object, bytes of its encoding: a mission of some thousand tasks.
pub const MAX_OBJECT_BYTES: usize = 256 << 10;
/// Objects of a site at most.
pub const MAX_SITE_OBJECTS: usize = 50_000;
/// Bytes after which a part of the site ends. Its last object may go beyond it.
const SITE_PART_BYTES: usize = 256 << 10;

/// A site with the number of edits that led to it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SiteState {
    /// Number of edits since the site began.
    pub revision: u64,
    /// Its objects.
    pub site: Site,
}

impl SiteState {
    /// Applies the next change. Returns whether it is the next one; nothing is changed if not.
    pub fn apply(&mut self, changed: &SiteChanged) -> bool {
        let is_next = self.revision.checked_add(1) == Some(changed.revision);
        let is_applied = is_next && self.site.apply(&changed.edit, changed.edit.id).is_ok();
        if is_applied {
            self.revision = changed.revision;
        }
        is_applied
    }
}

/// A part of the whole site. The first part takes the place of any site that its receiver has; the site is whole with the last.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SitePart {
    /// Revision of the whole site.
    pub revision: u64,
    /// Number of the part, from 0.
    pub index: u32,
    /// Whether it is the last part.
    pub is_last: bool,
    /// Objects.
    pub objects: Vec<Versioned>,
    /// Objects that were removed, with the revision of the removal.
    pub removed: Vec<(ObjectId, Revision)>,
}

/// Makes the parts of a site one after the other.
#[derive(Clone, Debug)]
pub struct SiteParts {
    state: Arc<SiteState>,
    index: u32,
    objects: usize,
    removed: usize,
}

impl SiteParts {
    /// All parts of this site.
    pub fn new(state: Arc<SiteState>) -> Self {
        Self { state, index: 0, objects: 0, removed: 0 }
    }

    /// The revision that the receiver has after the last part.
    pub fn revision(&self) -> u64 {
        self.state.revision
    }

    /// The next part. After that with `is_last` there is none.
    pub fn next_part(&mut self) -> SitePart {
        let site = &self.state.site;
        let mut bytes = 0;
        let mut has_room = |entry: usize| {
            let is_free = bytes < SITE_PART_BYTES;
            bytes += entry;
            is_free
        };
        let objects = site.objects().skip(self.objects);
        let objects: Vec<_> =
            objects.take_while(|versioned| has_room(encoded_bytes(*versioned))).cloned().collect();
        self.objects += objects.len();
        let mut removed = Vec::new();
        if self.objects == site.objects().len() {
            let entries = site.removed().skip(self.removed);
            removed.extend(entries.take_while(|_| has_room(size_of::<(ObjectId, Revision)>())));
            self.removed += removed.len();
        }
        let is_last = self.objects == site.objects().len() && self.removed == site.removed().len();
        let index = self.index;
        self.index += 1;
        SitePart { revision: self.state.revision, index, is_last, objects, removed }
    }
}

/// Bytes of a message.
pub fn encoded_bytes<T: Serialize>(message: &T) -> usize {
    postcard::experimental::serialized_size(message).unwrap_or(0)
}

/// Puts the parts of a site together.
#[derive(Clone, Debug, Default)]
pub struct SiteAssembly {
    parts: Vec<SitePart>,
}

impl SiteAssembly {
    /// Adds a part. Returns the site with its last part. A part that does not follow the one before drops what came so far.
    pub fn add(&mut self, part: &SitePart) -> Option<SiteState> {
        if part.index == 0 {
            self.parts.clear();
        }
        let follows = part.index as usize == self.parts.len()
            && self.parts.first().is_none_or(|first| first.revision == part.revision);
        if !follows {
            self.parts.clear();
            return None;
        }
        self.parts.push(part.clone());
        if !part.is_last {
            return None;
        }
        let (mut objects, mut removed) = (Vec::new(), Vec::new());
        for part in self.parts.drain(..) {
            objects.extend(part.objects);
            removed.extend(part.removed);
        }
        Some(SiteState { revision: part.revision, site: Site::new(objects, removed) })
    }
}

/// An edit that was applied and is durable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SiteChanged {
    /// Revision of the site after it.
    pub revision: u64,
    /// Whose edit it is; none: the robot's own.
    pub by: Option<ClientId>,
    /// The edit.
    pub edit: Edit,
}

/// What became of an edit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum EditOutcome {
    /// It is applied and durable. An edit that is sent again gets the same answer again.
    Applied {
        /// Revision of the site after it.
        revision: u64,
        /// Revisions of the changed objects, in the order of the changes.
        changes: Vec<RevisionChange>,
    },
    /// Nothing of it was applied.
    Refused(EditRefusal),
}

/// Why nothing of an edit was applied.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum EditRefusal {
    /// It does not fit the site: all reasons.
    Invalid(Vec<EditError>),
    /// It is not accepted, however often it is sent; the sentence says why.
    Rejected(String),
    /// It cannot be applied now, and may be sent again; the sentence says why.
    Unavailable(String),
}

/// Identifies the answer to an edit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EditDone {
    /// Id of the edit.
    pub id: EditId,
    /// What became of it.
    pub outcome: EditOutcome,
}

#[cfg(test)]
#[path = "site_tests.rs"]
mod tests;
