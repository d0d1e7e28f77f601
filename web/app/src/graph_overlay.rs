//! The topological map in the scene: edges as lines, nodes and the middles of edges as markers that can be selected. Inspection points: a marker at the target, and a
//! line to it from the node.

use crate::vector::vector;
use client_model::{Model, Selection};
use glam::DVec3;
use panels::theme::{Tokens, mix};
use scene::{Colour, Marker, Polyline, STANDING_HEIGHT_M, Shape};
use site_model::{Node, NodeId, NodeKind, Site};
use std::collections::{BTreeMap, BTreeSet};

/// Parameters of the overlay.
#[derive(Clone, Copy, Debug, PartialEq)]
struct GraphOverlayConfig {
    /// Height of lines and markers above the floor, m, so that the floor does not hide them.
    height_m: f64,
    /// Radius of a node, logical px.
    node_radius_px: f32,
    /// Radius of a node that is selected, logical px.
    selected_radius_px: f32,
    /// Radius of the marker in the middle of an edge, logical px.
    edge_radius_px: f32,
    /// Width of an edge, logical px.
    line_width_px: f32,
    /// Radius of the target of an inspection point, logical px.
    target_radius_px: f32,
    /// Width of the line from a node to a target, logical px.
    sight_width_px: f32,
    /// Length of a dash of an edge that routes do not use, with its gap, m.
    dash_m: f32,
}

const CONFIG: GraphOverlayConfig = GraphOverlayConfig {
    height_m: 0.12,
    node_radius_px: 8.0,
    selected_radius_px: 11.0,
    edge_radius_px: 5.0,
    line_width_px: 3.0,
    target_radius_px: 7.0,
    sight_width_px: 1.5,
    dash_m: 0.5,
};

/// Lines and markers of the topological map, and what each marker selects.
#[derive(Default)]
pub(crate) struct GraphOverlay {
    pub(crate) lines: Vec<Polyline>,
    pub(crate) markers: Vec<Marker>,
    targets: Vec<Selection>,
}

impl GraphOverlay {
    /// Of what the model shows; nothing while the site belongs to another map than the one on the screen. `dragged`: a node at another position of the base
    /// than its own, while an operator moves it.
    pub(crate) fn of(model: &Model, dragged: Option<(NodeId, DVec3)>) -> Self {
        let mut overlay = Self::default();
        if let Some(site) = model.site.site().filter(|_| model.is_site_on_screen()) {
            overlay.add(site, model, dragged);
        }
        overlay
    }

    /// What a marker of this id selects.
    pub(crate) fn target(&self, marker: u64) -> Option<Selection> {
        self.targets.get(usize::try_from(marker).ok()?).copied()
    }

    fn add(&mut self, site: &Site, model: &Model, dragged: Option<(NodeId, DVec3)>) {
        let tokens = Tokens::of(model.view_settings().theme);
        let position = |node: &Node| match dragged {
            Some((moved, at)) if moved == node.id => at,
            _ => vector(node.map_from_node.position),
        };
        let floor = |at: DVec3| at - DVec3::Z * (STANDING_HEIGHT_M - CONFIG.height_m);
        let positions: BTreeMap<NodeId, DVec3> =
            site.nodes().map(|node| (node.id, floor(position(node)))).collect();
        let ways: BTreeSet<[NodeId; 2]> = site.edges().map(|edge| [edge.from, edge.to]).collect();
        let blocked: BTreeSet<_> = site.edge_blocks().map(|block| block.edge).collect();
        let selected_way = match model.selection() {
            Some(Selection::Edge(edge)) => site.edge(edge).map(|edge| [edge.from, edge.to]),
            _ => None,
        };
        for edge in site.edges() {
            let is_pair = ways.contains(&[edge.to, edge.from]);
            let is_selected = model.selection() == Some(Selection::Edge(edge.id));
            // One of a pair stands for both, unless the other one is selected.
            let back_is_selected = selected_way == Some([edge.to, edge.from]);
            if is_pair && !is_selected && (back_is_selected || edge.from > edge.to) {
                continue;
            }
            let (Some(from), Some(to)) = (positions.get(&edge.from), positions.get(&edge.to)) else {
                continue;
            };
            let is_open = edge.is_enabled && !blocked.contains(&edge.id);
            let colour = if is_selected {
                tokens.accent
            } else if is_open {
                mix(tokens.accent, tokens.text, 0.45)
            } else {
                tokens.warn
            };
            let dash = if is_open { 0.0 } else { CONFIG.dash_m };
            let width = if is_selected { 2.0 * CONFIG.line_width_px } else { CONFIG.line_width_px };
            self.lines.push(Polyline { points: vec![*from, *to], colour: solid(colour), width, dash });
            let (shape, ahead) =
                if is_pair { (Shape::Disc, DVec3::ZERO) } else { (Shape::Arrow, *to - *from) };
            let radius = if is_pair { CONFIG.edge_radius_px } else { 2.0 * CONFIG.edge_radius_px };
            let middle = from.midpoint(*to);
            let marker = Marker {
                id: None,
                position: middle,
                ahead,
                shape,
                radius,
                fill: solid(colour),
                rim: solid(tokens.ground),
            };
            self.push(marker, Selection::Edge(edge.id));
        }
        for node in site.nodes() {
            let is_selected = model.selection() == Some(Selection::Node(node.id));
            let radius = if is_selected { CONFIG.selected_radius_px } else { CONFIG.node_radius_px };
            let fill = if is_selected {
                tokens.accent
            } else {
                mix(tokens.card, tokens.text, if tokens.dark { 1.0 } else { 0.0 })
            };
            let marker = Marker {
                id: None,
                position: positions[&node.id],
                ahead: DVec3::ZERO,
                shape: shape_of(node.kind),
                radius,
                fill: solid(fill),
                rim: solid(if tokens.dark { tokens.ground } else { tokens.text }),
            };
            self.push(marker, Selection::Node(node.id));
        }
        for point in model.site.inspection_points() {
            let Some(node) = site.node(point.node) else { continue };
            let is_selected = model.selection() == Some(Selection::InspectionPoint(point.id));
            let colour = if is_selected { tokens.accent } else { tokens.good };
            let target = vector(point.target_m);
            let points = vec![position(node), target];
            let width = if is_selected { 2.0 * CONFIG.sight_width_px } else { CONFIG.sight_width_px };
            self.lines.push(Polyline { points, colour: solid(colour), width, dash: 0.0 });
            let radius = if is_selected { CONFIG.selected_radius_px } else { CONFIG.target_radius_px };
            let marker = Marker {
                id: None,
                position: target,
                ahead: DVec3::ZERO,
                shape: Shape::Diamond,
                radius,
                fill: solid(colour),
                rim: solid(tokens.ground),
            };
            self.push(marker, Selection::InspectionPoint(point.id));
        }
    }

    fn push(&mut self, marker: Marker, target: Selection) {
        self.markers.push(Marker { id: Some(self.targets.len() as u64), ..marker });
        self.targets.push(target);
    }
}

/// Shape by which the kind of a node is told.
fn shape_of(kind: NodeKind) -> Shape {
    match kind {
        NodeKind::Inspection => Shape::Diamond,
        NodeKind::Dock | NodeKind::DockApproach => Shape::Square,
        NodeKind::Waypoint | NodeKind::Hold | NodeKind::Portal | NodeKind::Safe => Shape::Disc,
    }
}

fn solid(colour: egui::Color32) -> Colour {
    [colour.r(), colour.g(), colour.b(), 255]
}
