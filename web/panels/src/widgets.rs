//! The few widgets everything is made of: buttons, facts, heads, boxes. Each is an accessible element with a name.

use crate::theme::{self, Tokens, Weight, font};
use egui::{
    Align2, Color32, CornerRadius, Rect, Response, Role, Sense, Stroke, StrokeKind, Ui, Vec2, WidgetInfo,
    vec2,
};

/// What a button is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// One of several.
    #[default]
    Plain,
    /// The one to press next.
    Primary,
    /// The stop button and nothing else.
    Stop,
    /// Throws something away.
    Danger,
    /// No box until the pointer is there.
    Quiet,
}

/// A button, to be shown with [`Button::show`].
#[derive(Clone, Copy, Debug)]
pub struct Button<'a> {
    name: &'a str,
    text: Option<&'a str>,
    icon: Option<&'a str>,
    kind: Kind,
    enabled: bool,
    /// `None`: pressed and done; else a switch.
    on: Option<bool>,
    size: Vec2,
    hint: Option<&'a str>,
    stacked: bool,
}

impl<'a> Button<'a> {
    /// A button whose text is its accessible name.
    pub fn new(name: &'a str) -> Self {
        Self {
            name,
            text: Some(name),
            icon: None,
            kind: Kind::Plain,
            enabled: true,
            on: None,
            size: vec2(0.0, theme::TOUCH),
            hint: None,
            stacked: false,
        }
    }

    /// A square button with a sign and an accessible name that is also its tooltip.
    pub fn icon_only(name: &'a str, icon: &'a str) -> Self {
        Self {
            text: None,
            icon: Some(icon),
            size: Vec2::splat(theme::TOUCH),
            hint: Some(name),
            ..Self::new(name)
        }
    }

    /// A sign before the text.
    pub fn icon(self, icon: &'a str) -> Self {
        Self { icon: Some(icon), ..self }
    }

    /// A shorter text than the accessible name.
    pub fn text(self, text: &'a str) -> Self {
        Self { text: Some(text), ..self }
    }

    /// What it is for.
    pub fn kind(self, kind: Kind) -> Self {
        Self { kind, ..self }
    }

    /// Whether it can be pressed.
    pub fn enabled(self, enabled: bool) -> Self {
        Self { enabled, ..self }
    }

    /// A switch that is on or off.
    pub fn on(self, on: bool) -> Self {
        Self { on: Some(on), ..self }
    }

    /// Shown when the pointer rests on it.
    pub fn hint(self, hint: &'a str) -> Self {
        Self { hint: Some(hint), ..self }
    }

    /// Least size, points.
    pub fn size(self, width: f32, height: f32) -> Self {
        Self { size: vec2(width, height), ..self }
    }

    /// As wide as there is room.
    pub fn wide(self, ui: &Ui) -> Self {
        Self { size: vec2(ui.available_width(), self.size.y), ..self }
    }

    /// The sign above a small text.
    pub fn stacked(self) -> Self {
        Self { stacked: true, ..self }
    }

    /// Draws it.
    pub fn show(self, ui: &mut Ui, tokens: &Tokens) -> Response {
        let (text_size, weight) =
            if self.stacked { (theme::SMALL - 1.0, Weight::Medium) } else { (theme::BODY, Weight::Medium) };
        let (fill, ink, border) = self.colours(tokens);
        let text =
            self.text.map(|text| ui.painter().layout_no_wrap(text.to_owned(), font(text_size, weight), ink));
        let icon = self.icon.map(|icon| {
            let size = if self.stacked { 22.0 } else { theme::ICON };
            ui.painter().layout_no_wrap(icon.to_owned(), font(size, Weight::Regular), ink)
        });
        let width = text.as_ref().map_or(0.0, |galley| galley.size().x)
            + icon.as_ref().map_or(0.0, |i| i.size().x + 6.0);
        let padding = if self.text.is_some() && !self.stacked { 28.0 } else { 0.0 };
        let size = self.size.max(vec2(if self.stacked { 0.0 } else { width + padding }, self.size.y));
        let sense = if self.enabled { Sense::click() } else { Sense::hover() };
        let (rect, mut response) = ui.allocate_exact_size(size, sense);
        response.widget_info(|| match self.on {
            Some(on) => WidgetInfo::selected(Role::Button, self.enabled, on, self.name),
            None => WidgetInfo::labeled(Role::Button, self.enabled, self.name),
        });
        if let Some(hint) = self.hint {
            response = response.on_hover_text(hint).on_disabled_hover_text(hint);
        }
        if !ui.is_rect_visible(rect) {
            return response;
        }
        let fill = if response.is_pointer_button_down_on() {
            theme::mix(fill, tokens.text, 0.16)
        } else if response.hovered() && self.enabled {
            tokens.hovered(fill)
        } else {
            fill
        };
        let painter = ui.painter();
        painter.rect(rect, CornerRadius::same(theme::BUTTON_RADIUS), fill, border, StrokeKind::Inside);
        if response.has_focus() {
            focus_ring(ui, rect, tokens);
        }
        if self.stacked {
            if let Some(galley) = icon {
                let at = Align2::CENTER_CENTER
                    .align_size_within_rect(galley.size(), rect.translate(vec2(0.0, -8.0)));
                painter.galley(at.min, galley, ink);
            }
            if let Some(galley) = text {
                let at = Align2::CENTER_CENTER
                    .align_size_within_rect(galley.size(), rect.translate(vec2(0.0, 15.0)));
                painter.galley(at.min, galley, ink);
            }
            return response;
        }
        let gap = if text.is_some() && icon.is_some() { 6.0 } else { 0.0 };
        let content =
            text.as_ref().map_or(0.0, |g| g.size().x) + icon.as_ref().map_or(0.0, |g| g.size().x) + gap;
        let mut x = rect.center().x - 0.5 * content;
        for galley in [icon, text].into_iter().flatten() {
            let at = egui::pos2(x, rect.center().y - 0.5 * galley.size().y);
            x += galley.size().x + gap;
            painter.galley(at, galley, ink);
        }
        response
    }

    fn colours(&self, tokens: &Tokens) -> (Color32, Color32, Stroke) {
        let (fill, ink, border) = match (self.kind, self.on) {
            (_, Some(true)) => {
                (tokens.selected(), tokens.accent, Stroke::new(tokens.line_width, tokens.accent))
            }
            (Kind::Primary, _) => (tokens.accent_filled, tokens.on_filled, Stroke::NONE),
            (Kind::Stop, _) => (tokens.stop, tokens.on_filled, Stroke::NONE),
            (Kind::Danger, _) => (tokens.raised, tokens.bad, tokens.border()),
            (Kind::Plain, _) => (tokens.raised, tokens.text, tokens.border()),
            (Kind::Quiet, _) => (Color32::TRANSPARENT, tokens.dim, Stroke::NONE),
        };
        if self.enabled {
            return (fill, ink, border);
        }
        (
            theme::mix(fill, tokens.card.to_opaque(), 0.6),
            theme::mix(ink, tokens.card.to_opaque(), 0.5),
            border,
        )
    }
}

/// Outline of what the keyboard is on.
pub fn focus_ring(ui: &Ui, rect: Rect, tokens: &Tokens) {
    let radius = CornerRadius::same(theme::BUTTON_RADIUS + 2);
    ui.painter().rect_stroke(rect.expand(2.0), radius, Stroke::new(2.0, tokens.accent), StrokeKind::Outside);
}

/// Head of a card or part of one.
pub fn head(ui: &mut Ui, tokens: &Tokens, text: &str) {
    let response =
        ui.label(egui::RichText::new(text).font(font(theme::HEAD, Weight::SemiBold)).color(tokens.text));
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_role(Role::Heading));
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
    response.ctx.accesskit_node_builder(response.id, |node| {
        node.set_role(Role::Status);
        node.set_label(name);
        node.set_value(value);
    });
}

/// Signs and texts in a row, told as one status. Returns its response.
pub fn status_line(ui: &mut Ui, name: &str, value: &str, parts: &[(&str, f32, Weight, Color32)]) -> Response {
    let galleys: Vec<_> = parts
        .iter()
        .filter(|(text, ..)| !text.is_empty())
        .map(|&(text, size, weight, colour)| {
            (ui.painter().layout_no_wrap(text.to_owned(), font(size, weight), colour), colour)
        })
        .collect();
    let width: f32 = galleys.iter().map(|(galley, _)| galley.size().x + 6.0).sum::<f32>() - 6.0;
    let (rect, response) = ui.allocate_exact_size(vec2(width.max(0.0), 32.0), Sense::hover());
    let mut x = rect.left();
    for (galley, colour) in galleys {
        let at = egui::pos2(x, rect.center().y - 0.5 * galley.size().y);
        x += galley.size().x + 6.0;
        ui.painter().galley(at, galley, colour);
    }
    status_node(&response, name, value);
    response
}

/// A box with a coloured edge, for something that needs attention or is under way.
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

/// A thin line across.
pub fn rule(ui: &mut Ui, tokens: &Tokens) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), tokens.line_width), Sense::hover());
    ui.painter().rect_filled(rect, CornerRadius::ZERO, tokens.line);
}
