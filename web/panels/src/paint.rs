//! Painting that buttons and other widgets share: the outline of the focused control, and icons.

use crate::theme::{self, Tokens, Weight, font};
use egui::{Color32, CornerRadius, Rect, Stroke, StrokeKind, Ui};

/// Outline of the control that has the keyboard focus.
pub(crate) fn focus_ring(ui: &Ui, rect: Rect, tokens: &Tokens) {
    let radius = CornerRadius::same(theme::BUTTON_RADIUS + 2);
    ui.painter().rect_stroke(rect.expand(2.0), radius, Stroke::new(2.0, tokens.accent), StrokeKind::Outside);
}

/// An icon, centred at `centre` by what is drawn of it: icons sit lower in their line than letters.
pub(crate) fn icon_at(ui: &Ui, centre: egui::Pos2, icon: &str, size: f32, colour: Color32) {
    let galley = ui.painter().layout_no_wrap(icon.to_owned(), font(size, Weight::Regular), colour);
    ui.painter().galley(centre - galley.mesh_bounds.center().to_vec2(), galley, colour);
}
