//! Widgets that all panels share: facts, heads, boxes. Each is an accessible element with a name.

use crate::button::Button;
use crate::theme::{self, Tokens, Weight, font};
use egui::{Align2, Color32, CornerRadius, Rect, Response, Role, Sense, Ui, vec2};

/// Head of a card or part of one.
pub fn head(ui: &mut Ui, tokens: &Tokens, text: &str) {
    let response =
        ui.label(egui::RichText::new(text).font(font(theme::HEAD, Weight::SemiBold)).color(tokens.text));
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_role(Role::Heading));
}

/// A line across, and the head of the section below it.
pub(crate) fn section_head(ui: &mut Ui, tokens: &Tokens, text: &str) {
    ui.add_space(8.0);
    rule(ui, tokens);
    ui.add_space(4.0);
    head(ui, tokens, text);
}

/// A sentence, wrapped.
pub fn sentence(ui: &mut Ui, tokens: &Tokens, text: &str) {
    ui.add(egui::Label::new(egui::RichText::new(text).size(theme::BODY).color(tokens.text)).wrap());
}

/// A sentence that is less important, wrapped.
pub fn remark(ui: &mut Ui, tokens: &Tokens, text: &str) {
    ui.add(egui::Label::new(egui::RichText::new(text).size(theme::SMALL).color(tokens.dim)).wrap());
}

/// A line with a name at the left and a value at the right. In the accessible tree: a status of that name and value.
pub fn fact(ui: &mut Ui, tokens: &Tokens, name: &str, value: &str) -> Response {
    fact_with_note(ui, tokens, name, value, None)
}

/// As [`fact`], with a note before the value, in a colour of its own: an age, or what is wrong.
pub fn fact_with_note(
    ui: &mut Ui,
    tokens: &Tokens,
    name: &str,
    value: &str,
    note: Option<(&str, Color32)>,
) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 24.0), Sense::hover());
    let painter = ui.painter();
    let middle = rect.center().y;
    let left = egui::pos2(rect.left(), middle);
    painter.text(left, Align2::LEFT_CENTER, name, font(theme::BODY, Weight::Regular), tokens.dim);
    let right = egui::pos2(rect.right(), middle);
    let drawn =
        painter.text(right, Align2::RIGHT_CENTER, value, font(theme::BODY, Weight::Medium), tokens.text);
    if let Some((note, colour)) = note {
        let right = egui::pos2(drawn.left() - 8.0, middle);
        painter.text(right, Align2::RIGHT_CENTER, note, font(theme::SMALL, Weight::Regular), colour);
    }
    status_node(
        &response,
        name,
        &note.map_or_else(|| value.to_owned(), |(note, _)| format!("{value}, {note}")),
    );
    response
}

/// Says in the accessible tree that `response` is a status of this name and value.
pub fn status_node(response: &Response, name: &str, value: &str) {
    let Rect { min, max } = response.rect;
    response.ctx.accesskit_node_builder(response.id, |node| {
        node.set_role(Role::Status);
        node.set_bounds(egui::accesskit::Rect::new(min.x.into(), min.y.into(), max.x.into(), max.y.into()));
        node.set_label(name);
        node.set_value(value);
    });
}

/// Distance between the parts of a [`status_line`], points.
pub(crate) const STATUS_PART_GAP: f32 = 6.0;

/// Icons and texts in a row: one status in the accessible tree. Returns its response.
pub fn status_line(ui: &mut Ui, name: &str, value: &str, parts: &[(&str, f32, Weight, Color32)]) -> Response {
    let galleys: Vec<_> = parts
        .iter()
        .filter(|(text, ..)| !text.is_empty())
        .map(|&(text, size, weight, colour)| {
            (ui.painter().layout_no_wrap(text.to_owned(), font(size, weight), colour), colour)
        })
        .collect();
    let width: f32 = galleys.iter().map(|(galley, _)| galley.size().x + STATUS_PART_GAP).sum::<f32>();
    let width = width - STATUS_PART_GAP;
    let (rect, response) = ui.allocate_exact_size(vec2(width.max(0.0), 32.0), Sense::hover());
    let mut x = rect.left();
    for (galley, colour) in galleys {
        let at = egui::pos2(x, rect.center().y - 0.5 * galley.size().y);
        x += galley.size().x + STATUS_PART_GAP;
        ui.painter().galley(at, galley, colour);
    }
    status_node(&response, name, value);
    response
}

/// A box with a coloured edge, for something that needs attention or is in progress.
pub fn tinted_box<R>(ui: &mut Ui, tokens: &Tokens, colour: Color32, content: impl FnOnce(&mut Ui) -> R) -> R {
    let shown = egui::Frame::new()
        .fill(tokens.tinted(colour))
        .corner_radius(CornerRadius::same(theme::BUTTON_RADIUS))
        .inner_margin(egui::Margin { left: 14, right: 12, top: 10, bottom: 10 })
        .show(ui, |ui| {
            ui.set_width(ui.available_width());
            content(ui)
        });
    let rect = shown.response.rect;
    let edge = Rect::from_min_size(rect.min, vec2(4.0, rect.height()));
    let left = CornerRadius { nw: theme::BUTTON_RADIUS, sw: theme::BUTTON_RADIUS, ..CornerRadius::ZERO };
    ui.painter().rect_filled(edge, left, colour);
    shown.inner
}

/// Switches side by side, of which one is on. Calls `chosen` with the value of the one that is pressed.
pub(crate) fn choice<T: Copy + PartialEq>(
    ui: &mut Ui,
    tokens: &Tokens,
    choices: &[(&str, T)],
    on: T,
    mut chosen: impl FnMut(T),
) {
    ui.horizontal(|ui| {
        let gap = 6.0;
        ui.spacing_mut().item_spacing.x = gap;
        let width = ((ui.available_width() + gap) / choices.len() as f32 - gap).floor();
        for (name, value) in choices {
            if Button::new(name).on(*value == on).size(width, theme::TOUCH).slim().show(ui, tokens).clicked()
            {
                chosen(*value);
            }
        }
    });
}

/// Height of a progress bar, points.
const BAR_HEIGHT: f32 = 6.0;

/// A bar that is filled to `share`, 0 to 1.
pub(crate) fn progress_bar(ui: &mut Ui, tokens: &Tokens, share: f32) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), BAR_HEIGHT), Sense::hover());
    let radius = CornerRadius::same(3);
    ui.painter().rect_filled(rect, radius, tokens.faint());
    let mut done = rect;
    done.set_width(rect.width() * share);
    ui.painter().rect_filled(done, radius, tokens.accent);
    response
}

/// A thin line across.
pub fn rule(ui: &mut Ui, tokens: &Tokens) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), tokens.line_width), Sense::hover());
    ui.painter().rect_filled(rect, CornerRadius::ZERO, tokens.line);
}
