//! Sites for tests: nodes and edges by number.

use site_model::{
    Dock, DockId, Edge, EdgeCost, EdgeId, EditId, LocalTime, Node, NodeId, NodeKind, Object, PoseTolerance,
    Site, Zone, ZoneEffect, ZoneId,
};
use std::collections::{BTreeMap, BTreeSet};
use uuid::Uuid;
use vocab::{Pose, Vec3};

pub(crate) fn node_id(number: u128) -> NodeId {
    NodeId(Uuid::from_u128(number))
}

/// The edge between two numbered nodes.
pub(crate) fn edge_id(from: u128, to: u128) -> EdgeId {
    EdgeId(Uuid::from_u128(from * 1_000 + to))
}

/// Makes a site.
#[derive(Clone, Debug, Default)]
pub(crate) struct SiteBuilder {
    site: Site,
}

impl SiteBuilder {
    pub fn new() -> Self {
        Self::default()
    }

    pub fn site(&self) -> Site {
        self.site.clone()
    }

    pub fn put(&mut self, object: Object) -> &mut Self {
        let id = EditId(Uuid::nil());
        let edit = self.site.put(id, object);
        self.site.apply(&edit, id).expect("made from this state");
        self
    }

    pub fn apply(&mut self, edit: &site_model::Edit) {
        self.site.apply(edit, EditId(Uuid::nil())).expect("made from this state");
    }

    pub fn node(&mut self, number: u128, x: f64, y: f64) -> &mut Self {
        self.put(Object::Node(Node {
            id: node_id(number),
            name: format!("N{number}"),
            kind: NodeKind::Waypoint,
            map_from_node: Pose { position: Vec3::new(x, y, 0.0), ..Pose::IDENTITY },
            anchor: None,
            tolerance: PoseTolerance::default(),
            influence_area_m: Vec::new(),
            floor: 0,
            tags: BTreeSet::new(),
            properties: BTreeMap::new(),
        }))
    }

    pub fn edge(&mut self, from: u128, to: u128) -> &mut Self {
        self.put(Object::Edge(edge(edge_id(from, to), from, to)))
    }

    pub fn edge_of_cost(&mut self, id: u128, from: u128, to: u128, cost_s: f64) -> &mut Self {
        let cost = EdgeCost::Fixed(cost_s);
        self.put(Object::Edge(Edge { cost, ..edge(EdgeId(Uuid::from_u128(id)), from, to) }))
    }

    pub fn pair(&mut self, a: u128, b: u128) -> &mut Self {
        self.edge(a, b).edge(b, a)
    }

    pub fn change_node(&mut self, number: u128, change: impl FnOnce(&mut Node)) -> &mut Self {
        let mut node = self.site.node(node_id(number)).expect("a node").clone();
        change(&mut node);
        self.put(Object::Node(node))
    }

    pub fn change_edge(&mut self, from: u128, to: u128, change: impl FnOnce(&mut Edge)) -> &mut Self {
        let mut edge = self.site.edge(edge_id(from, to)).expect("an edge").clone();
        change(&mut edge);
        self.put(Object::Edge(edge))
    }

    pub fn dock(&mut self, number: u128, node: u128, approach: u128) -> &mut Self {
        self.put(Object::Dock(Dock {
            id: DockId(Uuid::from_u128(number)),
            name: format!("Dock {number}"),
            node: node_id(node),
            approach: node_id(approach),
        }))
    }

    pub fn zone(
        &mut self,
        number: u128,
        corners_m: [[f64; 2]; 4],
        effect: ZoneEffect,
        daily: Option<[LocalTime; 2]>,
    ) -> &mut Self {
        self.put(Object::Zone(Zone {
            id: ZoneId(Uuid::from_u128(number)),
            name: format!("Z{number}"),
            corners_m: corners_m.to_vec(),
            height_m: None,
            effect,
            daily,
        }))
    }
}

fn edge(id: EdgeId, from: u128, to: u128) -> Edge {
    Edge::walk(id, node_id(from), node_id(to))
}
