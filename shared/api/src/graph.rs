//! Changes of the pose graph of the current mapping session.

use crate::{Graph, GraphNode};
use serde::{Deserialize, Serialize};
use vocab::{KeyframeId, SessionId};

/// What changed in the last [`crate::Event::Graph`]. Changes add up, in the order in which they are sent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GraphChanged {
    /// Which session; changes of another one are ignored.
    pub session: Option<SessionId>,
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
    /// Applies changes. Returns whether they are of this session; the graph is unchanged if not.
    pub fn apply(&mut self, changed: &GraphChanged) -> bool {
        if changed.session != self.session {
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
        true
    }
}

impl GraphChanged {
    /// Appends later changes of the same session.
    pub fn append(&mut self, later: Self) {
        for node in later.nodes {
            match self.nodes.binary_search_by_key(&node.id, |known| known.id) {
                Ok(at) => self.nodes[at] = node,
                Err(at) => self.nodes.insert(at, node),
            }
        }
        self.edges.extend(later.edges);
        // A loop that came and is gone again was never sent.
        let removed = &later.removed_loops;
        let (gone, here): (Vec<_>, Vec<_>) =
            self.loops.iter().copied().partition(|pair| removed.contains(pair));
        self.loops = here;
        self.removed_loops.extend(removed.iter().filter(|pair| !gone.contains(pair)));
        self.loops.extend(later.loops);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vocab::{Pose, Vec3};

    fn node(id: u32, x: f64) -> GraphNode {
        let map_from_keyframe = Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::IDENTITY };
        GraphNode { id: KeyframeId(id), map_from_keyframe, ..GraphNode::default() }
    }

    fn pair(from: u32, to: u32) -> (KeyframeId, KeyframeId) {
        (KeyframeId(from), KeyframeId(to))
    }

    #[test]
    fn changes_applied_one_by_one_or_together_give_the_same_graph() {
        let changes = [
            GraphChanged { nodes: vec![node(0, 0.0)], ..GraphChanged::default() },
            GraphChanged { nodes: vec![node(1, 1.0)], edges: vec![pair(0, 1)], ..GraphChanged::default() },
            GraphChanged {
                nodes: vec![node(0, 0.5), node(2, 2.0)],
                edges: vec![pair(1, 2)],
                loops: vec![pair(0, 2)],
                ..GraphChanged::default()
            },
            GraphChanged {
                removed_loops: vec![pair(0, 2)],
                loops: vec![pair(0, 1)],
                ..GraphChanged::default()
            },
        ];
        let (mut one_by_one, mut together) = (Graph::default(), Graph::default());
        let mut sum = GraphChanged::default();
        for changed in changes {
            assert!(one_by_one.apply(&changed));
            sum.append(changed);
        }
        assert!(together.apply(&sum));
        assert_eq!(one_by_one, together);
        assert_eq!(together.nodes, [node(0, 0.5), node(1, 1.0), node(2, 2.0)]);
        assert_eq!((together.edges.len(), together.loops), (2, vec![pair(0, 1)]));
    }
}
