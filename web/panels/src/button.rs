//! The button: one widget for everything that is pressed, with a name in the accessible tree.

use crate::icon;
use crate::paint::{self, focus_ring, icon_at};
use crate::theme::{self, Tokens, Weight, font};
use egui::{
    Color32, CornerRadius, Galley, Pos2, Rect, Response, Role, Sense, Stroke, StrokeKind, Ui, Vec2,
    WidgetInfo, pos2, vec2,
};

/// Room left and right of a button's content together, points.
const PADDING: f32 = 28.0;
/// Room for the caret at the right, points.
const CARET_ROOM: f32 = 20.0;
/// Distance between icon and text, points.
const ICON_GAP: f32 = 8.0;

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
    /// Room left and right of the content together, points.
    padding: f32,
    left: bool,
    caret: bool,
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
            padding: PADDING,
            left: false,
            caret: false,
        }
    }

    /// A square button with an icon and an accessible name that is also its tooltip.
    pub fn icon_only(name: &'a str, icon: &'a str) -> Self {
        Self {
            text: None,
            icon: Some(icon),
            size: Vec2::splat(theme::TOUCH),
            hint: Some(name),
            ..Self::new(name)
        }
    }

    /// An icon before the text.
    pub fn icon(self, icon: &'a str) -> Self {
        Self { icon: Some(icon), ..self }
    }

    /// A shorter text than the accessible name.
    pub fn text(self, text: &'a str) -> Self {
        Self { text: Some(text), ..self }
    }

    /// The kind of action.
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

    /// With little room beside its text, for several side by side.
    pub fn slim(self) -> Self {
        Self { padding: 8.0, ..self }
    }

    /// With no room beside its text, for a row of seven days.
    pub fn tight(self) -> Self {
        Self { padding: 0.0, ..self }
    }

    /// With its content at the left, for rows of a list.
    pub fn left(self) -> Self {
        Self { left: true, ..self }
    }

    /// With a caret at its right, for what unfolds a list.
    pub fn caret(self) -> Self {
        Self { caret: true, padding: PADDING + CARET_ROOM, ..self }
    }

    /// The icon above a small text.
    pub fn stacked(self) -> Self {
        Self { stacked: true, ..self }
    }

    /// Draws it.
    pub fn show(self, ui: &mut Ui, tokens: &Tokens) -> Response {
        let (fill, ink, border) = self.colours(tokens);
        let text_size = if self.stacked { theme::SMALL - 1.0 } else { theme::BODY };
        let icon = self.icon.is_some();
        let lay_out = |text: &str| {
            let text_font = font(text_size, Weight::Medium);
            // A row of a list is no wider than the list; what does not fit is left out.
            let room = self.size.x - self.padding - self.icon_width_beside_text(icon);
            if self.left && room > 0.0 {
                paint::one_line(ui, text, text_font, ink, room)
            } else {
                ui.painter().layout_no_wrap(text.to_owned(), text_font, ink)
            }
        };
        let text = self.text.map(lay_out);
        let (rect, response) = self.allocate(ui, text.as_deref(), icon);
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
        ui.painter().rect(rect, CornerRadius::same(theme::BUTTON_RADIUS), fill, border, StrokeKind::Inside);
        if response.has_focus() {
            focus_ring(ui, rect, tokens);
        }
        let (icon_centre, text_at) = self.positions(rect, text.as_deref(), icon);
        if let Some(icon) = self.icon {
            icon_at(ui, icon_centre, icon, self.icon_size(), ink);
        }
        if self.caret {
            let at = pos2(rect.right() - CARET_ROOM, rect.center().y);
            icon_at(ui, at, icon::CARET_DOWN, theme::BODY, ink);
        }
        if let Some(galley) = text {
            ui.painter().galley(text_at - 0.5 * galley.size(), galley, ink);
        }
        response
    }

    fn icon_size(&self) -> f32 {
        match (self.stacked, self.text) {
            (true, _) => 24.0,
            (false, None) => 20.0,
            (false, Some(_)) => theme::ICON,
        }
    }

    /// Takes the room and says in the accessible tree what it is.
    fn allocate(&self, ui: &mut Ui, text: Option<&Galley>, icon: bool) -> (Rect, Response) {
        let text_width = text.map_or(0.0, |galley| galley.size().x);
        let width = if self.stacked { 0.0 } else { self.icon_width(text, icon) + text_width + self.padding };
        let least = if text.is_some() { width } else { 0.0 };
        let sense = if self.enabled { Sense::click() } else { Sense::hover() };
        let (rect, response) = ui.allocate_exact_size(self.size.max(vec2(least, 0.0)), sense);
        response.widget_info(|| match self.on {
            Some(on) => WidgetInfo::selected(Role::Button, self.enabled, on, self.name),
            None => WidgetInfo::labeled(Role::Button, self.enabled, self.name),
        });
        match self.hint {
            Some(hint) => (rect, response.on_hover_text(hint).on_disabled_hover_text(hint)),
            None => (rect, response),
        }
    }

    /// Width of the icon and the gap after it.
    fn icon_width(&self, text: Option<&Galley>, icon: bool) -> f32 {
        let gap = if text.is_some() { ICON_GAP } else { 0.0 };
        if icon { self.icon_size() + gap } else { 0.0 }
    }

    fn icon_width_beside_text(&self, icon: bool) -> f32 {
        if icon { self.icon_size() + ICON_GAP } else { 0.0 }
    }

    /// Centres of icon and text.
    fn positions(&self, rect: Rect, text: Option<&Galley>, icon: bool) -> (Pos2, Pos2) {
        let middle = rect.center();
        if self.stacked {
            return (middle - vec2(0.0, 8.0), middle + vec2(0.0, 15.0));
        }
        let icon_width = self.icon_width(text, icon);
        let content = icon_width + text.map_or(0.0, |galley| galley.size().x);
        let left = if self.left { rect.left() + 0.5 * PADDING } else { middle.x - 0.5 * content };
        let text_middle = left + icon_width + 0.5 * (content - icon_width);
        (pos2(left + 0.5 * self.icon_size(), middle.y), pos2(text_middle, middle.y))
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
