//! What several parts of the panel say of nodes and edges.

use super::texts;
use crate::theme::Tokens;
use crate::widgets;
use egui::Ui;
use site_model::{Edge, MissionId, NodeId, ObjectId, Site};
use std::collections::BTreeSet;

/// An edge, and the one that leads back if there is one.
pub(super) fn both_directions<'a>(site: &'a Site, edge: &'a Edge) -> impl Iterator<Item = &'a Edge> {
    site.edges().filter(|it| it.id == edge.id || (it.from == edge.to && it.to == edge.from))
}

/// Says which missions need one of these nodes.
pub(super) fn needed_by(ui: &mut Ui, tokens: &Tokens, site: &Site, nodes: &BTreeSet<NodeId>) {
    let needed: BTreeSet<MissionId> =
        nodes.iter().flat_map(|node| site.missions_that_need(ObjectId::Node(*node))).collect();
    let names: Vec<&str> = needed.iter().filter_map(|id| Some(site.mission(*id)?.name.as_str())).collect();
    if !names.is_empty() {
        widgets::remark(ui, tokens, &texts::needed_by(&names));
    }
}

/// A name, or what stands for one that is missing.
pub(super) fn missing_name(name: &str) -> &str {
    if name.trim().is_empty() { texts::UNNAMED } else { name }
}

/// Name of a node; a question mark where there is none of this id.
pub(crate) fn name_of(site: &Site, node: NodeId) -> &str {
    site.node(node).map_or("?", |node| node.name.as_str())
}

/// Straight length of an edge, metres; 0 without its nodes.
pub(super) fn length_m(site: &Site, edge: &Edge) -> f64 {
    let position = |node| site.node(node).map(|node| node.map_from_node.position);
    let (Some(a), Some(b)) = (position(edge.from), position(edge.to)) else { return 0.0 };
    (a.x - b.x).hypot(a.y - b.y).hypot(a.z - b.z)
}
