//! Painting that buttons and other widgets share: the outline of the focused control, and icons.

use crate::theme::{self, Tokens, Weight, font};
use egui::text::LayoutJob;
use egui::{Color32, CornerRadius, FontId, Galley, Rect, Stroke, StrokeKind, Ui};
use std::sync::Arc;

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

/// A text in one line; what does not fit into `room`, points, is left out, and a sign says so.
pub(crate) fn one_line(ui: &Ui, text: &str, font: FontId, colour: Color32, room: f32) -> Arc<Galley> {
    lines(ui, text, font, colour, room, 1)
}

/// A text of this width, points, cut after the given number of lines. An ellipsis marks that something was left out.
pub(crate) fn lines(
    ui: &Ui,
    text: &str,
    font: FontId,
    colour: Color32,
    width: f32,
    max_rows: usize,
) -> Arc<Galley> {
    let mut job = LayoutJob::simple(text.to_owned(), font, colour, width);
    job.wrap.max_rows = max_rows;
    job.wrap.break_anywhere = max_rows == 1;
    ui.painter().layout_job(job)
}

/// One line of text from `left` on, cut with an ellipsis where it is wider than `width`, points. `left`: its left end, at half its height.
pub(crate) fn line_at(
    ui: &Ui,
    left: egui::Pos2,
    width: f32,
    text: &str,
    style: (f32, Weight),
    colour: Color32,
) {
    let galley = one_line(ui, text, font(style.0, style.1), colour, width.max(0.0));
    ui.painter().galley(left - egui::vec2(0.0, 0.5 * galley.size().y), galley, colour);
}
