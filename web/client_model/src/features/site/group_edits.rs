//! Edits of several objects together: each is one step of undo.

use super::{SiteEdit, SiteFeature};
use crate::{ClientCommand, GraphTool, Selection};
use site_model::{Edge, Node, NodeId, Object, ObjectId, Site};
use std::collections::{BTreeMap, BTreeSet};
use vocab::Vec3;

impl SiteFeature {
    /// Nodes at other positions of the base, metres, map frame. They keep no anchor, so they stay there when the map is corrected.
    pub fn moving_nodes(&self, positions: &BTreeMap<NodeId, Vec3>) -> SiteEdit {
        let moved = positions.iter().flat_map(|(node, position)| self.moving_node(*node, *position).put);
        SiteEdit { put: moved.collect(), removed: Vec::new() }
    }

    /// Nodes after the same change. Those that it leaves as they are, are not part of the edit.
    pub fn changing_nodes(&self, nodes: &BTreeSet<NodeId>, change: impl Fn(&mut Node)) -> SiteEdit {
        let known = |object: &Object| self.site().is_some_and(|site| holds(site, object));
        let changed = nodes.iter().flat_map(|node| self.changing_node(*node, &change).put);
        SiteEdit { put: changed.filter(|object| !known(object)).collect(), removed: Vec::new() }
    }

    /// The edges that both begin and end at one of these nodes, after the same change.
    pub fn changing_edges_between(&self, nodes: &BTreeSet<NodeId>, change: impl Fn(&mut Edge)) -> SiteEdit {
        let put = self.edges_between(nodes).cloned().map(|mut edge| {
            change(&mut edge);
            Object::Edge(edge)
        });
        SiteEdit { put: put.collect(), removed: Vec::new() }
    }

    /// The edges that both begin and end at one of these nodes.
    pub fn edges_between(&self, nodes: &BTreeSet<NodeId>) -> impl Iterator<Item = &Edge> {
        let edges = self.site().into_iter().flat_map(|site| site.edges());
        edges.filter(|edge| nodes.contains(&edge.from) && nodes.contains(&edge.to))
    }

    /// These nodes are removed, with their edges and docks.
    pub fn removing_nodes(&self, nodes: &BTreeSet<NodeId>) -> SiteEdit {
        SiteEdit { put: Vec::new(), removed: nodes.iter().map(|node| ObjectId::Node(*node)).collect() }
    }

    /// What a click on a node does while a tool of the topological map is on. `selected`: the nodes that are.
    pub fn clicking_node(
        &self,
        tool: GraphTool,
        node: NodeId,
        selected: &BTreeSet<NodeId>,
    ) -> Vec<ClientCommand> {
        if tool == GraphTool::SelectSeveral {
            let mut nodes = selected.clone();
            if !nodes.remove(&node) {
                nodes.insert(node);
            }
            return vec![ClientCommand::SelectNodes(nodes)];
        }
        let from = selected.first().filter(|_| selected.len() == 1);
        let edit = from.map(|from| self.connecting(*from, node)).filter(|edit| !edit.put.is_empty());
        let select = ClientCommand::Select(Some(Selection::Node(node)));
        edit.map(ClientCommand::EditSite).into_iter().chain([select]).collect()
    }

    /// What is selected is removed; `None` if nothing of the site is. With an edge goes the one that leads back.
    pub fn removing_selected(
        &self,
        selection: Option<Selection>,
        nodes: &BTreeSet<NodeId>,
    ) -> Option<SiteEdit> {
        let removed = match selection {
            Some(Selection::Edge(edge)) => {
                let site = self.site()?;
                let ends = site.edge(edge).map(|edge| [edge.from, edge.to])?;
                let is_of_pair = |it: &&Edge| it.id == edge || [it.to, it.from] == ends;
                site.edges().filter(is_of_pair).map(|edge| ObjectId::Edge(edge.id)).collect()
            }
            Some(Selection::InspectionPoint(point)) => vec![ObjectId::InspectionPoint(point)],
            Some(Selection::Zone(zone)) => vec![ObjectId::Zone(zone)],
            _ => nodes.iter().map(|node| ObjectId::Node(*node)).collect(),
        };
        (!removed.is_empty()).then_some(SiteEdit { put: Vec::new(), removed })
    }

    /// The shortest edges, in both directions, by which all of these nodes are joined: a minimum spanning tree in which edges that exist cost nothing. Quadratic
    /// in the nodes (Prim).
    pub fn joining_nodes(&self, nodes: &BTreeSet<NodeId>) -> SiteEdit {
        let Some(site) = self.site() else { return SiteEdit::default() };
        let joined: BTreeSet<[NodeId; 2]> =
            self.edges_between(nodes).map(|edge| [edge.from, edge.to]).collect();
        let cost = |a: NodeId, b: NodeId| {
            let is_joined = joined.contains(&[a, b]) && joined.contains(&[b, a]);
            let ends = [a, b].map(|node| site.node(node).map(|node| node.map_from_node.position));
            match ends {
                _ if is_joined => 0.0,
                [Some(a), Some(b)] => (a.x - b.x).hypot(a.y - b.y).hypot(a.z - b.z),
                _ => f64::INFINITY,
            }
        };
        let mut left: Vec<NodeId> = nodes.iter().copied().filter(|node| site.node(*node).is_some()).collect();
        let Some(first) = left.pop() else { return SiteEdit::default() };
        // For each node that is left: the nearest of those that are joined.
        let mut nearest: BTreeMap<NodeId, (f64, NodeId)> =
            left.iter().map(|node| (*node, (cost(first, *node), first))).collect();
        let mut ends = Vec::new();
        while let Some((node, (_, from))) =
            nearest.iter().min_by(|(_, (a, _)), (_, (b, _))| a.total_cmp(b)).map(|(node, to)| (*node, *to))
        {
            nearest.remove(&node);
            ends.extend([[from, node], [node, from]].into_iter().filter(|ends| !joined.contains(ends)));
            for (other, best) in &mut nearest {
                let to_node = cost(node, *other);
                if to_node < best.0 {
                    *best = (to_node, node);
                }
            }
        }
        SiteEdit { put: self.new_edges(ends), removed: Vec::new() }
    }
}

/// Whether the site has exactly this object.
fn holds(site: &Site, object: &Object) -> bool {
    site.get(object.id()).is_some_and(|known| known.object == *object)
}
