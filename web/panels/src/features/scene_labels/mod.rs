//! Labels of the 3D scene: accessible elements and tags at the robot, its goal, docks, picked points and keyframes.

mod placement;
#[cfg(test)]
mod tests;
mod texts;

use crate::features::zones;
use crate::format;
use crate::theme::{self, Tokens, Weight, font};
use api::SurveyReason;
use client_model::{ClientCommand, GraphTool, Model, Selection};
use egui::{CornerRadius, Id, Pos2, Rect, Role, Sense, Stroke, StrokeKind, Ui, Vec2, WidgetInfo, vec2};
use placement::{LabelPlacementConfig, LabelPlacer, RING_RADIUS, RING_WIDTH, covering_rects};
use site_model::{InspectionPointId, NodeId, Zone};
use vocab::KeyframeId;

/// Side of the click target of a label that has others close to it, points.
const SMALL_TARGET: f32 = 20.0;
/// Side of the marker of a node or an inspection point, points.
const MARKER: f32 = 14.0;

/// A thing of the scene and its position on the screen.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLabel {
    /// Its accessible name.
    name: String,
    /// The text of its tag; it has no tag if empty.
    tag: String,
    /// Its position on the screen, points.
    at: Pos2,
    /// Size of the thing on the screen where no tag may hide it, points; zero where tags may.
    size: Vec2,
    /// What a click on it selects; nothing if none.
    selects: Option<Selection>,
    /// Whether it is selected.
    is_selected: bool,
    /// Whether other labels are close to it. Only its marker can be clicked then.
    is_crowded: bool,
}

impl SceneLabel {
    fn new(name: String, tag: String, at: Pos2) -> Self {
        Self { name, tag, at, size: Vec2::ZERO, selects: None, is_selected: false, is_crowded: false }
    }

    /// The robot, with the rectangle that it covers on the screen and its horizontal speed, m/s. No tag hides it.
    pub fn robot(body: Rect, speed_m_s: f64, is_selected: bool) -> Self {
        let label = Self::new(texts::ROBOT.to_owned(), texts::robot_tag(speed_m_s), body.center());
        let size = body.size().max(Vec2::splat(2.0 * RING_RADIUS));
        Self { size, selects: Some(Selection::Robot), is_selected, ..label }
    }

    /// The point to which the robot walks, with the rest of the path, metres.
    pub fn goal(at: Pos2, remaining_m: f64) -> Self {
        Self::new(texts::GOAL.to_owned(), texts::goal_tag(remaining_m), at)
    }

    /// A place to survey. Numbers begin with 1.
    pub fn survey_target(at: Pos2, number: usize, reason: SurveyReason) -> Self {
        Self::new(texts::survey_target(number), texts::survey_target_tag(reason), at)
    }

    /// A dock. Numbers begin with 1.
    pub fn dock(at: Pos2, number: usize) -> Self {
        Self::new(texts::dock(number), texts::DOCK_TAG.to_owned(), at)
    }

    /// A point that was picked to align two maps. Numbers begin with 1.
    pub fn alignment_point(at: Pos2, number: usize) -> Self {
        Self::new(texts::alignment_point(number), number.to_string(), at)
    }

    /// A node of the topological map, with its name as its tag.
    pub fn node(at: Pos2, id: NodeId, name: &str, is_selected: bool) -> Self {
        let label = Self::new(texts::node(name), name.to_owned(), at);
        Self { selects: Some(Selection::Node(id)), is_selected, is_crowded: true, ..label }
    }

    /// A place at which tasks of a mission are done, with their numbers as its tag.
    pub fn mission_stop(at: Pos2, numbers: &[usize], place: &str) -> Self {
        Self::new(texts::mission_stop(numbers, place), texts::mission_stop_tag(numbers, place), at)
    }

    /// The target of an inspection point, with its name as its tag.
    pub fn inspection_point(at: Pos2, id: InspectionPointId, name: &str, is_selected: bool) -> Self {
        let label = Self::new(texts::inspection_point(name), name.to_owned(), at);
        Self { selects: Some(Selection::InspectionPoint(id)), is_selected, is_crowded: true, ..label }
    }

    /// A zone, with its name and what holds in it as its tag.
    pub fn zone(at: Pos2, zone: &Zone, is_selected: bool) -> Self {
        let label = Self::new(texts::zone(&zone.name), zones::tag(zone), at);
        Self { selects: Some(Selection::Zone(zone.id)), is_selected, is_crowded: true, ..label }
    }

    /// The rectangle of the thing on the screen, points.
    fn body(&self) -> Rect {
        Rect::from_center_size(self.at, self.size)
    }

    /// The same without its tag, where another label names the place.
    pub fn without_tag(self) -> Self {
        Self { tag: String::new(), ..self }
    }

    /// A keyframe. Only a selected one has a tag, with the standard deviation of its position, metres, if it is known.
    pub fn keyframe(at: Pos2, id: KeyframeId, sigma_m: Option<f64>, is_selected: bool) -> Self {
        let sigma_m = sigma_m.map(|sigma_m| sigma_m.max(format::MIN_SHOWN_DEVIATION_M));
        let tag = if is_selected { texts::keyframe_tag(id, sigma_m) } else { String::new() };
        let label = Self::new(texts::keyframe(id), tag, at);
        Self { selects: Some(Selection::Keyframe(id)), is_selected, is_crowded: true, ..label }
    }
}

/// Draws the labels over the scene and under all cards, the most important first. A tag avoids the cards and the tags before it. It is left
/// out where there is no room.
pub fn show_labels(
    ui: &mut Ui,
    model: &Model,
    tokens: &Tokens,
    labels: &[SceneLabel],
    commands: &mut Vec<ClientCommand>,
) {
    let cards = covering_rects(ui.ctx());
    let mut placer = LabelPlacer::new(LabelPlacementConfig::default(), ui.max_rect(), cards);
    for label in labels.iter().filter(|label| label.size != Vec2::ZERO) {
        placer.keep_clear(label.body());
    }
    // A name over the marker of another thing would hide what is to be clicked.
    for label in labels.iter().filter(|label| label.is_crowded && !label.tag.is_empty()) {
        placer.keep_clear(Rect::from_center_size(label.at, Vec2::splat(MARKER)));
    }
    // What is pointed at on the map may be under a label.
    let is_map_clicked = graph_tool(ui.ctx(), model).is_some_and(|tool| !tool.is_for_nodes());
    for label in labels {
        if let Some(selection) = label.selects
            && show_target(ui, tokens, label, &placer, !is_map_clicked)
        {
            commands.extend(on_click(ui, model, selection, label.is_selected));
        }
        if !label.tag.is_empty() {
            paint_tag(ui, tokens, label, &mut placer);
        }
    }
}

/// What a click on a label does: it selects, or works as a click on the thing itself does while a tool is on.
fn on_click(ui: &Ui, model: &Model, selection: Selection, is_selected: bool) -> Vec<ClientCommand> {
    match (selection, graph_tool(ui.ctx(), model)) {
        (Selection::Node(node), Some(tool)) if tool.is_for_nodes() => {
            model.site.clicking_node(tool, node, &model.selected_nodes())
        }
        _ => vec![ClientCommand::Select((!is_selected).then_some(selection))],
    }
}

/// The tool of the topological map that works now. While Ctrl is held, nodes are selected together.
pub fn graph_tool(ctx: &egui::Context, model: &Model) -> Option<GraphTool> {
    let is_adding = crate::is_editing_graph(model) && ctx.input(|input| input.modifiers.command);
    if is_adding { Some(GraphTool::SelectSeveral) } else { model.graph_tool() }
}

/// The click target of a label, and the ring around it while it is selected or has the keyboard's focus. Without `takes_clicks`, clicks go to the scene below. Returns
/// whether it was clicked.
fn show_target(
    ui: &Ui,
    tokens: &Tokens,
    label: &SceneLabel,
    placer: &LabelPlacer,
    takes_clicks: bool,
) -> bool {
    // Beside the marker of a crowded label the scene decides what a click selects, because another thing may be nearer.
    let side = if label.is_crowded { SMALL_TARGET } else { theme::TOUCH };
    let target = Rect::from_center_size(label.at, Vec2::splat(side));
    let sense = if takes_clicks { Sense::click() } else { Sense::hover() };
    let response = ui.interact(target, Id::unique(("scene", &label.name)), sense);
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, label.is_selected, &label.name));
    if (label.is_selected || response.has_focus()) && placer.has_room_for_ring(label.at) {
        ui.painter().circle_stroke(label.at, RING_RADIUS, Stroke::new(RING_WIDTH, tokens.accent));
    }
    response.clicked()
}

fn paint_tag(ui: &Ui, tokens: &Tokens, label: &SceneLabel, placer: &mut LabelPlacer) {
    let text = font(theme::SMALL, Weight::Medium);
    let galley = ui.painter().layout_no_wrap(label.tag.clone(), text, tokens.text);
    let Some(rect) = placer.place(label.body(), galley.size() + vec2(14.0, 8.0)) else { return };
    let line = Stroke::new(tokens.line_width, tokens.line);
    ui.painter().rect(rect, CornerRadius::same(5), tokens.card, line, StrokeKind::Inside);
    ui.painter().galley(rect.min + vec2(7.0, 4.0), galley, tokens.text);
}
