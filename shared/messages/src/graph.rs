//! Changes of the pose graph under construction.

use crate::{EdgeKind, GraphEdge, GraphNode, PoseGraph};
use serde::{Deserialize, Serialize};
use vocab::{KeyframeId, SessionId};

/// What changed in a pose graph. Bytes follow what changed, not the size of the graph.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GraphDelta {
    /// Which mapping session.
    pub session: SessionId,
    /// Revision of the graph that this applies to.
    pub base_revision: u64,
    /// Its revision afterwards.
    pub revision: u64,
    /// New keyframes, and those that moved noticeably, in the order of their ids.
    pub nodes: Vec<GraphNode>,
    /// Loops that are gone, the older keyframe first.
    pub removed_loops: Vec<(KeyframeId, KeyframeId)>,
    /// New edges: those of the odometry, then loops.
    pub edges: Vec<GraphEdge>,
}

impl PoseGraph {
    /// Applies changes. Returns whether they apply to this revision; the graph is unchanged if not.
    pub fn apply(&mut self, delta: &GraphDelta) -> bool {
        if delta.base_revision != self.revision {
            return false;
        }
        for node in &delta.nodes {
            match self.nodes.get_mut(node.id.0 as usize) {
                Some(known) => *known = *node,
                None => self.nodes.push(*node),
            }
        }
        let is_removed = |edge: &GraphEdge| {
            edge.kind == EdgeKind::Loop && delta.removed_loops.contains(&(edge.from, edge.to))
        };
        self.edges.retain(|edge| !is_removed(edge));
        // Edges of the odometry come before loops.
        let loops =
            self.edges.iter().position(|edge| edge.kind == EdgeKind::Loop).unwrap_or(self.edges.len());
        let of_kind = |kind| delta.edges.iter().filter(move |edge| edge.kind == kind).copied();
        self.edges.splice(loops..loops, of_kind(EdgeKind::Odometry));
        self.edges.extend(of_kind(EdgeKind::Loop));
        self.revision = delta.revision;
        true
    }
}
