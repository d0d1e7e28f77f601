//! Floors of the topological map, and which of them is shown.

use super::SiteFeature;
use site_model::{Edge, InspectionPoint, Node, NodeId};
use std::collections::BTreeSet;

impl SiteFeature {
    /// The floors that nodes are on, the lowest first.
    pub fn floors(&self) -> BTreeSet<i32> {
        self.site().into_iter().flat_map(|site| site.nodes()).map(|node| node.floor).collect()
    }

    /// The floor that alone is shown; `None`: all are. A floor without nodes is not shown alone.
    pub fn shown_floor(&self) -> Option<i32> {
        self.floor.filter(|floor| self.floors().contains(floor))
    }

    /// The nodes on the floors that are shown.
    pub fn shown_nodes(&self) -> impl Iterator<Item = &Node> {
        let floor = self.shown_floor();
        let nodes = self.site().into_iter().flat_map(|site| site.nodes());
        nodes.filter(move |node| floor.is_none_or(|floor| node.floor == floor))
    }

    /// Whether an edge is shown: one of its ends is.
    pub fn is_edge_shown(&self, edge: &Edge) -> bool {
        self.is_node_shown(edge.from) || self.is_node_shown(edge.to)
    }

    /// Whether an inspection point is shown: the node from which it is looked at is.
    pub fn is_point_shown(&self, point: &InspectionPoint) -> bool {
        self.is_node_shown(point.node)
    }

    /// Lowest and greatest height of the base at the nodes of the floor that is shown, metres, map frame; `None` while all floors are.
    pub fn shown_heights_m(&self) -> Option<[f64; 2]> {
        self.shown_floor()?;
        let heights = || self.shown_nodes().map(|node| node.map_from_node.position.z);
        Some([heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max)])
    }

    fn is_node_shown(&self, node: NodeId) -> bool {
        let floor = self.shown_floor();
        floor.is_none()
            || self.site().and_then(|site| site.node(node)).is_some_and(|node| Some(node.floor) == floor)
    }
}
