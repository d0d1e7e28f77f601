//! Edits of the topological map as operators make them: each a step of undo.

use super::{SiteEdit, SiteFeature};
use site_model::{Edge, EdgeId, Node, NodeId, NodeKind, Object, ObjectId, PoseTolerance, Site, SiteSettings};
use vocab::{MapId, Pose, Quat, Vec3};

impl SiteFeature {
    /// A new node at a position of the base, metres, frame of `map`; and a pair of edges to `from`, if that is given. A site without a map gets this one.
    pub fn adding_node(&self, position: Vec3, map: MapId, from: Option<NodeId>) -> (NodeId, SiteEdit) {
        let node = NodeId(self.new_id(0));
        let mut edit = SiteEdit::default();
        let Some(site) = self.site() else { return (node, edit) };
        if site.settings().and_then(|settings| settings.map).is_none() {
            let settings = site.settings().cloned().unwrap_or_else(|| SiteSettings::of_unnamed(map));
            edit.put.push(Object::Settings(SiteSettings { map: Some(map), ..settings }));
        }
        edit.put.push(Object::Node(Node {
            id: node,
            name: free_name(site),
            kind: NodeKind::Waypoint,
            map_from_node: Pose { position, orientation: Quat { x: 0.0, y: 0.0, z: 0.0, w: 1.0 } },
            anchor: None,
            tolerance: PoseTolerance::default(),
            influence_area_m: Vec::new(),
            floor: from.and_then(|from| site.node(from)).map_or(0, |from| from.floor),
            tags: Default::default(),
            properties: Default::default(),
        }));
        if let Some(from) = from.filter(|from| site.node(*from).is_some()) {
            edit.put.extend(self.new_edges([[from, node], [node, from]]));
        }
        (node, edit)
    }

    /// The edges that are missing between two nodes, in both directions.
    pub fn connecting(&self, a: NodeId, b: NodeId) -> SiteEdit {
        let Some(site) = self.site().filter(|_| a != b) else { return SiteEdit::default() };
        let is_missing = |ends: &[NodeId; 2]| !site.edges().any(|edge| [edge.from, edge.to] == *ends);
        let missing: Vec<_> = [[a, b], [b, a]].into_iter().filter(is_missing).collect();
        SiteEdit { put: self.new_edges(missing), removed: Vec::new() }
    }

    /// A node at another position of the base, metres, map frame. It keeps no anchor, so it stays there when the map is corrected.
    pub fn moving_node(&self, node: NodeId, position: Vec3) -> SiteEdit {
        self.changing_node(node, |node| {
            node.map_from_node.position = position;
            node.anchor = None;
        })
    }

    /// A node after a change.
    pub fn changing_node(&self, node: NodeId, change: impl FnOnce(&mut Node)) -> SiteEdit {
        let mut edit = SiteEdit::default();
        if let Some(mut node) = self.site().and_then(|site| site.node(node)).cloned() {
            change(&mut node);
            edit.put.push(Object::Node(node));
        }
        edit
    }

    /// An edge after a change.
    pub fn changing_edge(&self, edge: EdgeId, change: impl FnOnce(&mut Edge)) -> SiteEdit {
        let mut edit = SiteEdit::default();
        if let Some(mut edge) = self.site().and_then(|site| site.edge(edge)).cloned() {
            change(&mut edge);
            edit.put.push(Object::Edge(edge));
        }
        edit
    }

    /// An edge and the one that leads back, if there is one, with a node in the middle of both.
    pub fn splitting_edge(&self, edge: EdgeId, map: MapId) -> Option<(NodeId, SiteEdit)> {
        let site = self.site()?;
        let edge = site.edge(edge)?;
        let ends = [site.node(edge.from)?, site.node(edge.to)?].map(|node| node.map_from_node.position);
        let [a, b] = ends;
        let middle = Vec3::new(0.5 * (a.x + b.x), 0.5 * (a.y + b.y), 0.5 * (a.z + b.z));
        let (node, mut edit) = self.adding_node(middle, map, None);
        let back = site.edges().find(|it| it.from == edge.to && it.to == edge.from);
        for (number, whole) in [Some(edge), back].into_iter().flatten().enumerate() {
            edit.removed.push(ObjectId::Edge(whole.id));
            for (half, [from, to]) in [[whole.from, node], [node, whole.to]].into_iter().enumerate() {
                let id = EdgeId(self.new_id(1 + 2 * number as u32 + half as u32));
                edit.put.push(Object::Edge(Edge { id, from, to, ..whole.clone() }));
            }
        }
        Some((node, edit))
    }

    pub(super) fn new_edges(&self, ends: impl IntoIterator<Item = [NodeId; 2]>) -> Vec<Object> {
        let edge = |(number, [from, to]): (u32, [NodeId; 2])| {
            Object::Edge(Edge::walk(EdgeId(self.new_id(number)), from, to))
        };
        (1..).zip(ends).map(edge).collect()
    }
}

/// The first of the names `N1`, `N2` and so on that no node has.
fn free_name(site: &Site) -> String {
    let names: std::collections::BTreeSet<&str> = site.nodes().map(|node| node.name.as_str()).collect();
    let mut number = site.nodes().count() + 1;
    loop {
        let name = format!("N{number}");
        if !names.contains(name.as_str()) {
            return name;
        }
        number += 1;
    }
}
