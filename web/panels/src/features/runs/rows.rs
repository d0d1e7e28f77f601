//! Rows of tasks and runs.

use super::look::StateStyle;
use crate::paint::{focus_ring, icon_at, one_line};
use crate::theme::{self, Tokens, Weight, font, mix};
use egui::{Align2, CornerRadius, Id, Rect, Response, Role, Sense, Ui, WidgetInfo, pos2, vec2};

/// Height of a row, points.
const HEIGHT: f32 = 52.0;
/// Width of the part at the right, points.
const SIDE_WIDTH: f32 = 98.0;

/// A row.
pub(super) struct ResultRow<'a> {
    /// Its accessible name.
    pub(super) name: &'a str,
    pub(super) title: &'a str,
    pub(super) facts: &'a str,
    /// At the right: the state, and below it a time.
    pub(super) state: &'a str,
    pub(super) time: &'a str,
    pub(super) look: StateStyle,
    pub(super) is_selected: bool,
}

/// Shows a row, which can be pressed.
pub(super) fn show_row(ui: &mut Ui, tokens: &Tokens, id: Id, row: &ResultRow<'_>) -> Response {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
    let response = ui.interact(rect, id, Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, row.is_selected, row.name));
    if !ui.is_rect_visible(rect) {
        return response;
    }
    let look = row.look;
    let fill = if look.is_filled { mix(tokens.raised, look.colour, 0.16) } else { tokens.raised };
    let fill = if response.hovered() { tokens.hovered(fill) } else { fill };
    let radius = CornerRadius::same(theme::BUTTON_RADIUS);
    let painter = ui.painter();
    painter.rect_filled(rect, radius, fill);
    let edge = Rect::from_min_size(rect.min, vec2(4.0, rect.height()));
    painter.rect_filled(edge, CornerRadius { ne: 0, se: 0, ..radius }, look.colour);
    if row.is_selected {
        let stroke = egui::Stroke::new(tokens.line_width, tokens.accent);
        painter.rect_stroke(rect, radius, stroke, egui::StrokeKind::Inside);
    }
    let left = rect.left() + 14.0;
    let room = rect.width() - 14.0 - SIDE_WIDTH - 8.0;
    let title = one_line(ui, row.title, font(theme::BODY, Weight::Medium), tokens.text, room);
    painter.galley(pos2(left, rect.top() + 8.0), title, tokens.text);
    let facts = one_line(ui, row.facts, font(theme::SMALL, Weight::Regular), tokens.dim, room);
    painter.galley(pos2(left, rect.top() + 29.0), facts, tokens.dim);
    let right = rect.right() - 10.0;
    let ink = if look.is_filled { mix(look.colour, tokens.text, 0.35) } else { tokens.dim };
    let small = font(theme::SMALL, Weight::Medium);
    let state_y = if row.time.is_empty() { rect.center().y } else { rect.top() + 17.0 };
    let state = painter.text(pos2(right, state_y), Align2::RIGHT_CENTER, row.state, small, ink);
    icon_at(ui, pos2(state.left() - 11.0, state_y), look.sign, 14.0, ink);
    if !row.time.is_empty() {
        let time_font = font(theme::SMALL, Weight::Regular);
        painter.text(pos2(right, rect.top() + 36.0), Align2::RIGHT_CENTER, row.time, time_font, tokens.dim);
    }
    if response.has_focus() {
        focus_ring(ui, rect, tokens);
    }
    response
}
