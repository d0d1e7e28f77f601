//! Edits: what people and programs change of a site in one step.

use crate::{EditId, Object, ObjectId, Revision};
use serde::{Deserialize, Serialize};

/// Changes that are made together or not at all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Edit {
    /// Made by the client.
    pub id: EditId,
    /// At most one change of each object.
    pub changes: Vec<Change>,
}

/// A change of one object. `base` is the revision of the object that it changes; none if there is no such object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// The object is added, or replaces the one of its id.
    Put {
        /// Revision that is replaced; none: the object is new.
        base: Option<Revision>,
        /// What it is afterwards.
        object: Object,
    },
    /// The object is removed.
    Remove {
        /// Revision that is removed.
        base: Revision,
        /// Which.
        object: ObjectId,
    },
}

impl Change {
    /// The object that is changed.
    pub fn object_id(&self) -> ObjectId {
        match self {
            Self::Put { object, .. } => object.id(),
            Self::Remove { object, .. } => *object,
        }
    }

    /// The revision that is changed; none if there is no such object.
    pub fn base(&self) -> Option<Revision> {
        match self {
            Self::Put { base, .. } => *base,
            Self::Remove { base, .. } => Some(*base),
        }
    }
}

/// What an edit did.
#[derive(Clone, Debug, PartialEq)]
pub struct Applied {
    /// Changes the site back.
    pub inverse: Edit,
    /// The revisions of the changed objects, in the order of the changes.
    pub revisions: Vec<RevisionChange>,
}

/// Revisions of a changed object. None: there is no such object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RevisionChange {
    /// Which.
    pub object: ObjectId,
    /// Its revision before the edit.
    pub before: Option<Revision>,
    /// Its revision after it.
    pub after: Option<Revision>,
}

/// Why an edit was not applied.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum EditError {
    /// Somebody else has changed an object in the meantime.
    #[error("{object} was changed by somebody else in the meantime; look at the change and repeat yours")]
    Conflict {
        /// Which object.
        object: ObjectId,
        /// Its revision; none if it was removed.
        revision: Option<Revision>,
    },
    /// The edit changes an object twice.
    #[error("the edit changes {0} twice")]
    ChangedTwice(ObjectId),
    /// A number is not finite. The site cannot hold it.
    #[error("a number of {0} is not finite")]
    NotFinite(ObjectId),
}
