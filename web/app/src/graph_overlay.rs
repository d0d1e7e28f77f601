//! The topological map in the scene: edges as lines, nodes and the middles of edges as markers that can be selected. Inspection points: a marker at the target, and a
//! line to it from the node.

use crate::graph_preview::GraphPreview;
use crate::vector::vector;
use client_model::{Model, Selection};
use egui::Color32;
use glam::DVec3;
use panels::theme::{Tokens, mix};
use scene::{Colour, Marker, MarkerShape, Polyline};
use site_model::{Edge, InspectionPoint, Node, NodeId, NodeKind, Site, ZoneId};
use std::collections::{BTreeMap, BTreeSet};

/// Parameters of the overlay.
#[derive(Clone, Copy, Debug, PartialEq)]
struct GraphOverlayConfig {
    /// Height of lines and markers above the floor, m, so that the floor does not hide them. Chosen: above zones (0.08 m), below routes of missions (0.16 m).
    height_m: f64,
    /// Radius of a node, logical px. Chosen: nodes 2 m apart stay apart in a picture of 100 m on 1,080 lines.
    node_radius_px: f32,
    /// Radius of a node that is selected, logical px. Chosen: a third larger than [`Self::node_radius_px`].
    selected_radius_px: f32,
    /// Radius of the handle by which a node is turned, logical px. Chosen: as [`Self::selected_radius_px`]; it is picked within a touch target.
    handle_radius_px: f32,
    /// Radius of the marker in the middle of an edge, logical px. Chosen: smaller than a node, so that both are told apart.
    edge_radius_px: f32,
    /// Width of an edge, logical px. Chosen: seen on a bright floor; wider ones hide it.
    line_width_px: f32,
    /// Radius of the target of an inspection point, logical px. Chosen: between an edge's marker and a node.
    target_radius_px: f32,
    /// Width of the line from a node to a target, logical px. Chosen: half of [`Self::line_width_px`].
    sight_width_px: f32,
    /// Length of a dash of an edge that routes do not use, with its gap, m. Chosen: an edge of 2 m has four.
    dash_m: f32,
}

const CONFIG: GraphOverlayConfig = GraphOverlayConfig {
    height_m: 0.12,
    node_radius_px: 8.0,
    selected_radius_px: 11.0,
    handle_radius_px: 11.0,
    edge_radius_px: 5.0,
    line_width_px: 3.0,
    target_radius_px: 7.0,
    sight_width_px: 1.5,
    dash_m: 0.5,
};

/// What a marker of the topological map is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum GraphTarget {
    /// It selects an object.
    Object(Selection),
    /// It turns a node.
    Heading(NodeId),
    /// It moves a corner of a zone, by its place in the list.
    ZoneCorner(ZoneId, usize),
    /// It draws a new corner out of the side of a zone that begins at this corner.
    ZoneSide(ZoneId, usize),
}

/// Lines and markers of the topological map, and what each marker is for.
#[derive(Default)]
pub(crate) struct GraphOverlay {
    pub(crate) lines: Vec<Polyline>,
    pub(crate) markers: Vec<Marker>,
    targets: Vec<GraphTarget>,
}

/// What the overlay is drawn from.
struct Source<'a> {
    site: &'a Site,
    model: &'a Model,
    preview: &'a GraphPreview,
    tokens: Tokens,
    selected: BTreeSet<NodeId>,
}

impl Source<'_> {
    /// Position of the base at a node, m, map frame.
    fn position(&self, node: &Node) -> DVec3 {
        let dragged = self.preview.nodes.get(&node.id).copied();
        dragged.unwrap_or_else(|| vector(node.map_from_node.position))
    }

    /// Unit vector of the heading at a node.
    fn ahead(&self, node: &Node) -> DVec3 {
        let yaw = match self.preview.heading {
            Some((turned, yaw)) if turned == node.id => yaw,
            _ => yaw_of(node),
        };
        DVec3::new(yaw.cos(), yaw.sin(), 0.0)
    }
}

impl GraphOverlay {
    /// Of what the model shows; nothing while the site belongs to another map than the one on the screen. `preview`: what an operator drags.
    pub(crate) fn of(model: &Model, preview: &GraphPreview) -> Self {
        let mut overlay = Self::default();
        if let Some(site) = model.site.site().filter(|_| model.is_site_on_screen()) {
            let tokens = Tokens::of(model.view_settings().theme);
            let selected = &model.selected_nodes() | &preview.boxed;
            overlay.add(&Source { site, model, preview, tokens, selected });
        }
        overlay
    }

    /// What a marker of this id is for.
    pub(crate) fn target(&self, marker: u64) -> Option<GraphTarget> {
        self.targets.get(usize::try_from(marker).ok()?).copied()
    }

    fn add(&mut self, source: &Source<'_>) {
        let Source { site, model, .. } = source;
        let standing_height_m = model.platform.standing_height_m();
        let positions: BTreeMap<NodeId, DVec3> =
            site.nodes().map(|node| (node.id, on_floor(source.position(node), standing_height_m))).collect();
        let directions: BTreeSet<[NodeId; 2]> = site.edges().map(|edge| [edge.from, edge.to]).collect();
        let blocked: BTreeSet<_> = site.edge_blocks().map(|block| block.edge).collect();
        let selected_direction = match model.selection() {
            Some(Selection::Edge(edge)) => site.edge(edge).map(|edge| [edge.from, edge.to]),
            _ => None,
        };
        for edge in site.edges().filter(|edge| model.site.is_edge_shown(edge)) {
            let is_pair = directions.contains(&[edge.to, edge.from]);
            let is_selected = model.selection() == Some(Selection::Edge(edge.id));
            // One of a pair stands for both, unless the other one is selected.
            let back_is_selected = selected_direction == Some([edge.to, edge.from]);
            if is_pair && !is_selected && (back_is_selected || edge.from > edge.to) {
                continue;
            }
            if let (Some(from), Some(to)) = (positions.get(&edge.from), positions.get(&edge.to)) {
                let is_open = edge.is_enabled && !blocked.contains(&edge.id);
                self.add_edge(source, edge, [*from, *to], is_pair, is_open);
            }
        }
        for node in model.site.shown_nodes() {
            self.add_node(source, node, positions[&node.id]);
        }
        for point in model.site.inspection_points() {
            if let Some(node) = site.node(point.node).filter(|_| model.site.is_point_shown(point)) {
                self.add_point(source, point, source.position(node));
            }
        }
    }

    fn add_edge(&mut self, source: &Source<'_>, edge: &Edge, ends: [DVec3; 2], is_pair: bool, is_open: bool) {
        let Source { model, preview, tokens, .. } = source;
        let [from, to] = ends;
        let is_selected = model.selection() == Some(Selection::Edge(edge.id));
        let colour = if preview.is_obstructed(edge.from, edge.to) {
            tokens.bad
        } else if is_selected {
            tokens.accent
        } else if is_open {
            mix(tokens.accent, tokens.text, 0.45)
        } else {
            tokens.warn
        };
        let dash = if is_open { 0.0 } else { CONFIG.dash_m };
        let is_wide = is_selected || preview.is_obstructed(edge.from, edge.to);
        let width = if is_wide { 2.0 * CONFIG.line_width_px } else { CONFIG.line_width_px };
        self.lines.push(Polyline { points: vec![from, to], colour: solid(colour), width, dash });
        let (shape, ahead) =
            if is_pair { (MarkerShape::Disc, DVec3::ZERO) } else { (MarkerShape::Arrow, to - from) };
        let radius = if is_pair { CONFIG.edge_radius_px } else { 2.0 * CONFIG.edge_radius_px };
        let marker = Marker { ahead, ..marker(from.midpoint(to), shape, radius, colour, tokens.ground) };
        self.push(marker, GraphTarget::Object(Selection::Edge(edge.id)));
    }

    fn add_node(&mut self, source: &Source<'_>, node: &Node, at: DVec3) {
        let Source { tokens, preview, selected, .. } = source;
        let is_selected = selected.contains(&node.id);
        let radius = if is_selected { CONFIG.selected_radius_px } else { CONFIG.node_radius_px };
        let white = mix(tokens.card, tokens.text, if tokens.dark { 1.0 } else { 0.0 });
        let fill = if is_selected { tokens.accent } else { white };
        let rim = if tokens.dark { tokens.ground } else { tokens.text };
        // Only one node at a time is turned.
        if is_selected && selected.len() == 1 && preview.handle_m > 0.0 {
            let ahead = source.ahead(node);
            let handle = at + ahead * preview.handle_m;
            let (colour, width) = (solid(tokens.accent), CONFIG.line_width_px);
            self.lines.push(Polyline { points: vec![at, handle], colour, width, dash: 0.0 });
            let arrow = marker(handle, MarkerShape::Arrow, CONFIG.handle_radius_px, tokens.accent, rim);
            self.push(Marker { ahead, ..arrow }, GraphTarget::Heading(node.id));
        }
        if is_selected && !node.influence_area_m.is_empty() {
            let ahead = source.ahead(node);
            let left = DVec3::new(-ahead.y, ahead.x, 0.0);
            let mut points: Vec<DVec3> =
                node.influence_area_m.iter().map(|[x, y]| at + ahead * *x + left * *y).collect();
            points.extend(points.first().copied());
            let (colour, width) = (solid(tokens.accent), CONFIG.line_width_px);
            self.lines.push(Polyline { points, colour, width, dash: CONFIG.dash_m });
        }
        let marker = marker(at, shape_of(node.kind), radius, fill, rim);
        self.push(marker, GraphTarget::Object(Selection::Node(node.id)));
    }

    fn add_point(&mut self, source: &Source<'_>, point: &InspectionPoint, from: DVec3) {
        let Source { model, tokens, .. } = source;
        let is_selected = model.selection() == Some(Selection::InspectionPoint(point.id));
        let colour = if is_selected { tokens.accent } else { tokens.good };
        let target = vector(point.target_m);
        let width = if is_selected { 2.0 * CONFIG.sight_width_px } else { CONFIG.sight_width_px };
        self.lines.push(Polyline { points: vec![from, target], colour: solid(colour), width, dash: 0.0 });
        let radius = if is_selected { CONFIG.selected_radius_px } else { CONFIG.target_radius_px };
        let marker = marker(target, MarkerShape::Diamond, radius, colour, tokens.ground);
        self.push(marker, GraphTarget::Object(Selection::InspectionPoint(point.id)));
    }

    /// Adds a marker that is for something.
    pub(crate) fn push(&mut self, marker: Marker, target: GraphTarget) {
        self.markers.push(Marker { id: Some(self.targets.len() as u64), ..marker });
        self.targets.push(target);
    }
}

/// A place just above the floor under a position of the base, so that the floor does not hide it.
fn on_floor(base: DVec3, standing_height_m: f64) -> DVec3 {
    base - DVec3::Z * (standing_height_m - CONFIG.height_m)
}

/// A marker without direction that cannot be picked yet.
pub(crate) fn marker(
    position: DVec3,
    shape: MarkerShape,
    radius: f32,
    fill: Color32,
    rim: Color32,
) -> Marker {
    let (fill, rim) = (solid(fill), solid(rim));
    Marker { id: None, position, ahead: DVec3::ZERO, shape, radius, fill, rim }
}

/// Heading of a node, rad.
fn yaw_of(node: &Node) -> f64 {
    let q = node.map_from_node.orientation;
    (2.0 * (q.w * q.z + q.x * q.y)).atan2(1.0 - 2.0 * (q.y * q.y + q.z * q.z))
}

/// Shape by which the kind of a node is told.
fn shape_of(kind: NodeKind) -> MarkerShape {
    match kind {
        NodeKind::Inspection => MarkerShape::Diamond,
        NodeKind::Dock | NodeKind::DockApproach => MarkerShape::Square,
        NodeKind::Waypoint | NodeKind::Hold | NodeKind::Portal | NodeKind::Safe => MarkerShape::Disc,
    }
}

pub(crate) fn solid(colour: Color32) -> Colour {
    [colour.r(), colour.g(), colour.b(), 255]
}
