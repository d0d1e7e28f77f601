//! Things in the 3D scene as accessible elements and tags: robot, goal, docks, points, keyframes.

mod placement;

use crate::theme::{self, Tokens, Weight, font};
use client_model::{ClientCommand, Selection};
use egui::{CornerRadius, Id, Pos2, Rect, Role, Sense, Stroke, StrokeKind, Ui, Vec2, WidgetInfo, vec2};
use placement::{LabelPlacementConfig, LabelPlacer, covering_rects};

/// Side of the click target of one of many, points.
const SMALL_TARGET: f32 = 20.0;

/// What a label stands at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LabelKind {
    /// Something that can be selected.
    Selectable(Selection),
    /// Where the robot walks to.
    Goal,
    /// Where it is worth walking to.
    WorthAWalk,
    /// Where it was charged.
    Dock,
    /// A point that two maps share.
    Picked,
}

/// A thing of the scene and where it is on the screen.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLabel {
    /// What it is.
    pub kind: LabelKind,
    /// Its accessible name.
    pub name: String,
    /// What the tag says; no tag if empty.
    pub tag: String,
    /// Where it is, points.
    pub at: Pos2,
    /// Whether it is selected.
    pub selected: bool,
    /// Whether it is one of many close together, of which only the sign itself is clicked.
    pub small: bool,
}

/// Draws the labels over the scene, under all cards. The most important come first: tags avoid cards and the tags before them, and are left
/// out where there is no room.
pub fn show_labels(ui: &mut Ui, tokens: &Tokens, labels: &[SceneLabel], out: &mut Vec<ClientCommand>) {
    let cards = covering_rects(ui.ctx());
    let mut placer = LabelPlacer::new(LabelPlacementConfig::default(), ui.max_rect(), cards);
    for label in labels {
        // Beside a keyframe's marker the scene decides what a click selects: another thing may be nearer.
        let side = if label.small { SMALL_TARGET } else { theme::TOUCH };
        let target = Rect::from_center_size(label.at, Vec2::splat(side));
        if let LabelKind::Selectable(selection) = label.kind {
            let response = ui.interact(target, Id::unique(("scene", &label.name)), Sense::click());
            response.widget_info(|| WidgetInfo::selected(Role::Button, true, label.selected, &label.name));
            if response.clicked() {
                out.push(ClientCommand::Select((!label.selected).then_some(selection)));
            }
            if (label.selected || response.has_focus()) && placer.has_room_for_ring(label.at) {
                ui.painter().circle_stroke(label.at, 14.0, Stroke::new(2.0, tokens.accent));
            }
        }
        if !label.tag.is_empty() {
            tag(ui, tokens, label, &mut placer);
        }
    }
}

fn tag(ui: &Ui, tokens: &Tokens, label: &SceneLabel, placer: &mut LabelPlacer) {
    let text = font(theme::SMALL, Weight::Medium);
    let galley = ui.painter().layout_no_wrap(label.tag.clone(), text, tokens.text);
    let Some(rect) = placer.place(label.at, galley.size() + vec2(14.0, 8.0)) else { return };
    let radius = CornerRadius::same(5);
    ui.painter().rect(
        rect,
        radius,
        tokens.card,
        Stroke::new(tokens.line_width, tokens.line),
        StrokeKind::Inside,
    );
    ui.painter().galley(rect.min + vec2(7.0, 4.0), galley, tokens.text);
}
