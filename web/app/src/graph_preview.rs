//! What a drag would change of the topological map, as the overlay draws it.

use glam::DVec3;
use site_model::{NodeId, ZoneId};
use std::collections::{BTreeMap, BTreeSet};

/// An edge with something in its corridor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EdgeObstruction {
    pub(crate) from: NodeId,
    pub(crate) to: NodeId,
    /// Distance from `from`, m.
    pub(crate) along_m: f64,
}

/// A zone while it is drawn or changed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ZonePreview {
    /// Which; `None`: a new one.
    pub(crate) zone: Option<ZoneId>,
    /// Corners, m, map frame.
    pub(crate) corners_m: Vec<[f64; 2]>,
    /// Height of the floor, m, map frame.
    pub(crate) floor_m: f64,
}

/// The topological map while something of it is dragged.
#[derive(Default)]
pub(crate) struct GraphPreview {
    /// Nodes at other positions of the base than their own, m, map frame.
    pub(crate) nodes: BTreeMap<NodeId, DVec3>,
    /// A node with another heading than its own, rad.
    pub(crate) heading: Option<(NodeId, f64)>,
    /// Nodes in a box that is drawn.
    pub(crate) boxed: BTreeSet<NodeId>,
    /// Edges of moved nodes in which something stands.
    pub(crate) obstructed: Vec<EdgeObstruction>,
    /// A zone with other corners than its own, or a new one.
    pub(crate) zone: Option<ZonePreview>,
    /// Distance from the selected node to the handle by which it is turned, m.
    pub(crate) handle_m: f64,
}

impl GraphPreview {
    /// Whether something stands in an edge between two nodes.
    pub(crate) fn is_obstructed(&self, a: NodeId, b: NodeId) -> bool {
        self.obstructed.iter().any(|edge| [edge.from, edge.to] == [a, b] || [edge.from, edge.to] == [b, a])
    }
}
