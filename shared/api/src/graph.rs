//! Changes of the pose graph of the current mapping session.
//!
//! A receiver holds one graph. Changes name the session and the revision that they apply to. A receiver applies them only to exactly
//! that graph. If they do not apply, it drops them and asks its sender for the whole graph, once:
//! [`crate::ClientMessage::RequestGraph`], [`crate::GatewayMessage::RequestGraph`]. Until that comes, it drops all changes.

use crate::{Graph, GraphNode};
use serde::{Deserialize, Serialize};
use vocab::{KeyframeId, SessionId};

/// What changed in the graph of [`crate::Event::Graph`]. Changes add up, in the order in which they are sent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GraphChanged {
    /// Which session.
    pub session: Option<SessionId>,
    /// Revision of the graph that the changes apply to.
    pub base_revision: u64,
    /// Its revision afterwards.
    pub revision: u64,
    /// New keyframes, and those that moved noticeably, in the order of their ids.
    pub nodes: Vec<GraphNode>,
    /// New edges of the odometry.
    pub edges: Vec<(KeyframeId, KeyframeId)>,
    /// Loops that are gone, the older keyframe first.
    pub removed_loops: Vec<(KeyframeId, KeyframeId)>,
    /// New loops, the older keyframe first.
    pub loops: Vec<(KeyframeId, KeyframeId)>,
}

impl Graph {
    /// Applies changes. Returns whether they are changes of this revision of this session; the graph is unchanged if not.
    pub fn apply(&mut self, changed: &GraphChanged) -> bool {
        if (changed.session, changed.base_revision) != (self.session, self.revision) {
            return false;
        }
        for node in &changed.nodes {
            match self.nodes.get_mut(node.id.0 as usize) {
                Some(known) => *known = *node,
                None => self.nodes.push(*node),
            }
        }
        self.edges.extend(&changed.edges);
        self.loops.retain(|pair| !changed.removed_loops.contains(pair));
        self.loops.extend(&changed.loops);
        self.revision = changed.revision;
        true
    }
}

impl GraphChanged {
    /// Appends the changes that follow. Returns whether they are those; nothing is appended if not.
    pub fn append(&mut self, later: &Self) -> bool {
        if (later.session, later.base_revision) != (self.session, self.revision) {
            return false;
        }
        for node in &later.nodes {
            match self.nodes.binary_search_by_key(&node.id, |known| known.id) {
                Ok(at) => self.nodes[at] = *node,
                Err(at) => self.nodes.insert(at, *node),
            }
        }
        self.edges.extend(&later.edges);
        // A loop that came and is gone again was never sent.
        let removed = &later.removed_loops;
        let (gone, here): (Vec<_>, Vec<_>) =
            self.loops.iter().copied().partition(|pair| removed.contains(pair));
        self.loops = here;
        self.removed_loops.extend(removed.iter().filter(|pair| !gone.contains(pair)));
        self.loops.extend(&later.loops);
        self.revision = later.revision;
        true
    }
}

#[cfg(test)]
#[path = "graph_tests.rs"]
mod tests;
