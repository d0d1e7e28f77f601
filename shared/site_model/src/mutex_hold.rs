//! Groups of edges that somebody else uses.

use crate::MutexHoldId;
use serde::{Deserialize, Serialize};

/// A group of edges ([`crate::Edge::mutex_group`]) is held by a person or another system. The robot waits before the edges of the group until the hold is removed; one that it
/// walks already it walks to its end.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MutexHold {
    /// Its id.
    pub id: MutexHoldId,
    /// Name of the group.
    pub group: String,
    /// Who holds it, shown to people.
    pub holder: String,
}
