//! Gestures on the screen that edits the site: a drag moves nodes over the floor, turns one, draws a box round several, or draws and changes zones. Escape takes a
//! drag back. One drag is one step of undo.

use crate::gesture_context::GestureContext;
use crate::graph_overlay::GraphTarget;
use crate::graph_preview::{EdgeObstruction, GraphPreview};
use crate::vector::vector;
use crate::zone_gestures::{self, ZoneDrag};
use api::RobotBody;
use client_model::{ClientCommand, GraphTool, Model, Selection};
use egui::{PointerButton, Pos2, Rect};
use glam::{DVec2, DVec3};
use panels::theme::Tokens;
use panels::{DragObstruction, SceneDrag};
use scene::{CameraProjection, ColumnsConfig, PointColumns};
use site_model::{Edge, Node, NodeId, Site, Traversal};
use std::collections::{BTreeMap, BTreeSet};

/// Parameters of [`GraphGestures`].
#[derive(Clone, Copy, Debug)]
struct GestureConfig {
    /// Distance on the screen from a node to its handle, logical px: a touch target.
    handle_px: f64,
    /// Turns end at multiples of this while Shift is held, rad: 15 degrees. Chosen: right angles and their thirds and sixths are met.
    turn_step: f64,
    /// Room round the dragged nodes and the ends of their edges for which points are held, m. A drag that leaves it gathers points anew. Chosen: most drags stay within
    /// it; gathering takes longer for more.
    columns_room_m: f64,
    /// Room that is left of it when they are gathered anew, m. Chosen: more than a drag moves in one frame.
    columns_margin_m: f64,
}

const CONFIG: GestureConfig = GestureConfig {
    handle_px: 44.0,
    turn_step: std::f64::consts::PI / 12.0,
    columns_room_m: 8.0,
    columns_margin_m: 1.0,
};

/// What is dragged.
enum Drag {
    Nodes(NodeDrag),
    /// A node is turned, by its handle.
    Heading {
        node: NodeId,
        yaw: f64,
    },
    /// A box, by its first corner.
    Box(Pos2),
    /// A zone.
    Zone(ZoneDrag),
}

/// Nodes that are moved over the floor.
struct NodeDrag {
    /// The one under the pointer.
    grabbed: NodeId,
    /// Where the base was at each of them, m, map frame.
    start: BTreeMap<NodeId, DVec3>,
    /// Points of the map near them.
    columns: PointColumns,
}

/// The drag that is under way.
#[derive(Default)]
pub(crate) struct GraphGestures {
    drag: Option<Drag>,
    preview: GraphPreview,
}

impl GraphGestures {
    /// What the drag would change, as the overlay draws it.
    pub(crate) fn preview(&self) -> &GraphPreview {
        &self.preview
    }

    /// Whether something is dragged, so that Escape belongs to it.
    pub(crate) fn is_dragging(&self) -> bool {
        self.drag.is_some()
    }

    /// What panels have to know of it. `was_dragging`: whether something was dragged when the frame began, so that Escape was for that.
    pub(crate) fn scene_drag(&self, model: &Model, was_dragging: bool) -> SceneDrag {
        let name = |node| model.site.site().and_then(|site| site.node(node)).map(|node| node.name.clone());
        let obstruction = self.preview.obstructed.first().and_then(|edge| {
            Some(DragObstruction {
                from: name(edge.from)?,
                to: name(edge.to)?,
                along_m: edge.along_m,
                others: self.preview.obstructed.len() - 1,
            })
        });
        SceneDrag { is_active: was_dragging || self.is_dragging(), obstruction }
    }

    /// Takes the drag back.
    pub(crate) fn cancel(&mut self) {
        self.drag = None;
        self.preview = GraphPreview::default();
    }

    /// Handles the gestures of a frame. Returns whether something is dragged.
    pub(crate) fn update(&mut self, cx: &GestureContext<'_>, out: &mut Vec<ClientCommand>) -> bool {
        self.preview = GraphPreview { handle_m: handle_m(cx), ..GraphPreview::default() };
        if cx.response.drag_started_by(PointerButton::Primary)
            && let Some(pressed) = cx.ui.input(|input| input.pointer.press_origin())
        {
            self.drag = begin(cx, pressed, out);
        }
        let is_pinched = cx.ui.input(|input| input.multi_touch().is_some());
        if is_pinched || cx.ui.input(|input| input.key_pressed(egui::Key::Escape)) {
            return self.drag.take().is_some();
        }
        let Some(drag) = &mut self.drag else { return false };
        let pointer = cx.response.interact_pointer_pos();
        match drag {
            Drag::Nodes(nodes) => nodes.update(cx, pointer, &mut self.preview),
            Drag::Heading { node, yaw } => {
                if let Some(at) = pointer.and_then(|at| turned(cx, *node, at)) {
                    *yaw = at;
                }
                self.preview.heading = Some((*node, *yaw));
            }
            Drag::Zone(zone) => zone.update(cx, pointer, &mut self.preview),
            Drag::Box(from) => {
                if let Some(to) = pointer {
                    draw_box(cx, Rect::from_two_pos(*from, to));
                    self.preview.boxed = nodes_in(cx, Rect::from_two_pos(*from, to));
                }
            }
        }
        if cx.response.drag_stopped_by(PointerButton::Primary) {
            self.end(cx, out);
        }
        true
    }

    /// Makes one edit of what was dragged.
    fn end(&mut self, cx: &GestureContext<'_>, out: &mut Vec<ClientCommand>) {
        let site = &cx.model.site;
        match self.drag.take() {
            Some(Drag::Nodes(_)) => {
                let positions: BTreeMap<_, _> = self
                    .preview
                    .nodes
                    .iter()
                    .map(|(node, at)| (*node, vocab::Vec3::from(at.to_array())))
                    .collect();
                out.push(ClientCommand::EditSite(site.moving_nodes(&positions)));
            }
            Some(Drag::Heading { node, yaw }) => {
                let (z, w) = (0.5 * yaw).sin_cos();
                let orientation = vocab::Quat { x: 0.0, y: 0.0, z, w };
                out.push(ClientCommand::EditSite(
                    site.changing_node(node, |node| node.map_from_node.orientation = orientation),
                ));
            }
            Some(Drag::Box(_)) => {
                let nodes = &cx.model.selected_nodes() | &self.preview.boxed;
                out.push(ClientCommand::SelectNodes(nodes));
            }
            Some(Drag::Zone(_)) => {
                if let Some(zone) = &self.preview.zone {
                    zone_gestures::end(site, zone, out);
                }
            }
            None => {}
        }
    }
}

/// What a drag from a place drags: a zone, a node with those that are selected with it, its handle, or a box.
fn begin(cx: &GestureContext<'_>, pressed: Pos2, out: &mut Vec<ClientCommand>) -> Option<Drag> {
    let target = (cx.target_at)(pressed);
    let selected = cx.model.selected_nodes();
    let tool = panels::graph_tool(cx.ui.ctx(), cx.model);
    if let Some(zone) = ZoneDrag::begin(cx, pressed, target, tool, out) {
        return Some(Drag::Zone(zone));
    }
    let is_adding = cx.ui.input(|input| input.modifiers.command);
    match target {
        Some(GraphTarget::Heading(node)) => Some(Drag::Heading { node, yaw: 0.0 }),
        Some(GraphTarget::Object(Selection::Node(node))) if !is_adding => {
            let nodes = if selected.contains(&node) { selected } else { BTreeSet::from([node]) };
            if nodes.len() == 1 {
                out.push(ClientCommand::Select(Some(Selection::Node(node))));
            }
            NodeDrag::begin(cx, node, &nodes).map(Drag::Nodes)
        }
        _ if tool == Some(GraphTool::SelectSeveral) => Some(Drag::Box(pressed)),
        _ => None,
    }
}

impl NodeDrag {
    fn begin(cx: &GestureContext<'_>, grabbed: NodeId, nodes: &BTreeSet<NodeId>) -> Option<Self> {
        let site = cx.model.site.site()?;
        let position = |node: &NodeId| Some((*node, vector(site.node(*node)?.map_from_node.position)));
        let start: BTreeMap<NodeId, DVec3> = nodes.iter().filter_map(position).collect();
        let columns = gather(cx, site, &start);
        start.contains_key(&grabbed).then_some(Self { grabbed, start, columns })
    }

    /// Moves the nodes to where the pointer is, each onto the floor there, and looks along their edges.
    fn update(&mut self, cx: &GestureContext<'_>, pointer: Option<Pos2>, preview: &mut GraphPreview) {
        let Some(site) = cx.model.site.site() else { return };
        let from = self.start[&self.grabbed];
        let projection = CameraProjection::new(cx.view.camera, cx.view.viewport_px);
        // The height of a node is that of the base; the pointer shows a place on the floor.
        let standing_height_m = cx.model.platform.standing_height_m();
        let on_floor = |at| projection.ray((cx.pixel)(at)).at_height(from.z - standing_height_m);
        let near = |to: &DVec3| to.distance(projection.camera_position()) < cx.max_distance_m;
        let to = pointer.and_then(on_floor).filter(near);
        let by = to.map_or(DVec2::ZERO, |to| (to - from).truncate());
        let moved: BTreeMap<NodeId, DVec3> =
            self.start.iter().map(|(node, at)| (*node, at + by.extend(0.0))).collect();
        if moved.values().any(|at| !self.columns.covers(at.truncate(), CONFIG.columns_margin_m)) {
            self.columns = gather(cx, site, &moved);
        }
        let snapped = |at: &DVec3| {
            let floor = self.columns.floor(at.truncate(), at.z - standing_height_m);
            floor.map_or(*at, |floor| at.with_z(floor + standing_height_m))
        };
        preview.nodes = moved.iter().map(|(node, at)| (*node, snapped(at))).collect();
        preview.obstructed = self.obstructed(site, &preview.nodes, standing_height_m);
    }

    /// The edges of moved nodes in which something stands. Stairs and docks are no floor that can be looked along.
    fn obstructed(
        &self,
        site: &Site,
        moved: &BTreeMap<NodeId, DVec3>,
        standing_height_m: f64,
    ) -> Vec<EdgeObstruction> {
        let floor = |node: NodeId| {
            let at =
                moved.get(&node).copied().or_else(|| Some(vector(site.node(node)?.map_from_node.position)));
            at.map(|at| at - DVec3::Z * standing_height_m)
        };
        let is_walked =
            |edge: &&Edge| matches!(edge.traversal, Traversal::Walk | Traversal::Slow | Traversal::Door);
        let is_moved = |edge: &&Edge| moved.contains_key(&edge.from) || moved.contains_key(&edge.to);
        let mut seen = BTreeSet::new();
        let edges = site.edges().filter(is_walked).filter(is_moved);
        // Of a pair, one is looked along.
        let once = edges.filter(|edge| seen.insert([edge.from.min(edge.to), edge.from.max(edge.to)]));
        once.filter_map(|edge| {
            let found = self.columns.obstruction([floor(edge.from)?, floor(edge.to)?])?;
            Some(EdgeObstruction { from: edge.from, to: edge.to, along_m: found.along_m })
        })
        .collect()
    }
}

/// Points of the map round nodes and the other ends of their edges.
fn gather(cx: &GestureContext<'_>, site: &Site, nodes: &BTreeMap<NodeId, DVec3>) -> PointColumns {
    let ends = site.edges().filter(|edge| nodes.contains_key(&edge.from));
    let ends = ends.filter_map(|edge| site.node(edge.to));
    let mut places: Vec<DVec2> = nodes.values().map(|at| at.truncate()).collect();
    places.extend(ends.map(|node| vector(node.map_from_node.position).truncate()));
    let min = places.iter().copied().fold(DVec2::INFINITY, DVec2::min) - CONFIG.columns_room_m;
    let max = places.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max) + CONFIG.columns_room_m;
    let config = columns_config(cx.model.platform.body());
    cx.scene.renderer.borrow().columns(config, [min, max])
}

/// What is in the way of this robot. Where nobody has walked, it needs the room in which it turns.
fn columns_config(body: Option<RobotBody>) -> ColumnsConfig {
    let known = ColumnsConfig::default();
    body.map_or(known, |body| ColumnsConfig {
        half_width_m: body.footprint_radius_m,
        step_m: body.step_height_m,
        clearance_m: body.clearance_height_m,
        ..known
    })
}

/// Heading of a node towards a place on the screen, rad; with Shift, in steps.
fn turned(cx: &GestureContext<'_>, node: NodeId, at: Pos2) -> Option<f64> {
    let from = vector(cx.model.site.site()?.node(node)?.map_from_node.position);
    let projection = CameraProjection::new(cx.view.camera, cx.view.viewport_px);
    let to = projection.ray((cx.pixel)(at)).at_height(from.z - cx.model.platform.standing_height_m())?;
    let yaw = (to - from).y.atan2((to - from).x);
    let is_stepped = cx.ui.input(|input| input.modifiers.shift);
    Some(if is_stepped { (yaw / CONFIG.turn_step).round() * CONFIG.turn_step } else { yaw })
}

/// Distance from the selected node to its handle, m.
fn handle_m(cx: &GestureContext<'_>) -> f64 {
    let selected = cx.model.selected_nodes();
    let node = selected.first().and_then(|node| cx.model.site.site()?.node(*node));
    let projection = CameraProjection::new(cx.view.camera, cx.view.viewport_px);
    let depth = node.map_or(0.0, |node| projection.depth(vector(node.map_from_node.position)));
    CONFIG.handle_px * f64::from(cx.view.pixels_per_point) * depth.max(0.1) / projection.focal_px()
}

/// The nodes that are shown inside a box on the screen.
fn nodes_in(cx: &GestureContext<'_>, area: Rect) -> BTreeSet<NodeId> {
    let corners = [(cx.pixel)(area.min), (cx.pixel)(area.max)];
    let projection = CameraProjection::new(cx.view.camera, cx.view.viewport_px);
    let is_inside = |node: &&Node| {
        let floor = vector(node.map_from_node.position) - DVec3::Z * cx.model.platform.standing_height_m();
        let at = projection.project(floor);
        at.is_some_and(|(at, _)| at.cmpge(corners[0]).all() && at.cmple(corners[1]).all())
    };
    cx.model.site.shown_nodes().filter(is_inside).map(|node| node.id).collect()
}

fn draw_box(cx: &GestureContext<'_>, area: Rect) {
    let tokens = Tokens::of(cx.model.view_settings().theme);
    let layer = egui::LayerId::new(egui::Order::Background, egui::Id::unique("box over the scene"));
    let painter = cx.ui.ctx().layer_painter(layer);
    painter.rect(
        area,
        egui::CornerRadius::same(2),
        tokens.accent.gamma_multiply(0.15),
        egui::Stroke::new(1.5, tokens.accent),
        egui::StrokeKind::Inside,
    );
}
