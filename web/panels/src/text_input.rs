//! Text inputs: a widget, and the bridge to the page's own inputs.
//!
//! On a page, a text field is an empty box that requests an input of the page over itself: on-screen keyboards, selection, copy and paste and
//! password managers work with those only. Elsewhere (in tests) egui's own text field is drawn. The code that uses [`TextInput`] is the same
//! for both, and any number of fields may be shown.

use crate::theme::{self, Tokens};
use egui::{CornerRadius, Id, Rect, Sense, StrokeKind, Ui, vec2};

/// What is typed into a field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextInputKind {
    /// One line.
    #[default]
    Line,
    /// Several lines.
    Paragraph,
    /// One line, with the browser's button that clears it.
    Search,
    /// One line that is not shown.
    Password,
    /// A number; phones show a numeric keyboard.
    Number,
}

/// An input that the page shall show in this frame.
#[derive(Clone, Debug, PartialEq)]
pub struct TextInputRequest {
    /// Distinguishes it from all others.
    pub id: Id,
    /// Accessible name.
    pub name: String,
    /// The text.
    pub value: String,
    /// Shown while the text is empty.
    pub hint: String,
    /// What is typed.
    pub kind: TextInputKind,
    /// Position on the page, points.
    pub rect: Rect,
    /// The part of the page in which it is visible, points: of a scrolled list.
    pub clip_rect: Rect,
    /// Longest text, UTF-16 code units.
    pub max_length: u32,
    /// The HTML attribute of this name; password managers read it.
    pub autocomplete: &'static str,
    /// Whether the text can be edited.
    pub enabled: bool,
    /// Whether it takes the keyboard focus when it appears.
    pub take_focus: bool,
}

/// What happened to an input of the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TextInputEvent {
    /// Its text is this now.
    Changed(String),
    /// Enter was pressed in a field of one line.
    Submitted,
    /// It got the keyboard focus.
    FocusGained,
    /// It lost the keyboard focus.
    FocusLost,
}

/// The bridge between the fields of a frame and the page's inputs.
#[derive(Debug, Default)]
pub struct TextInputs {
    on_page: bool,
    requests: Vec<TextInputRequest>,
    events: Vec<(Id, TextInputEvent)>,
}

impl TextInputs {
    /// `on_page`: whether the page lays inputs over the fields; else egui draws its own.
    pub fn new(on_page: bool) -> Self {
        Self { on_page, ..Self::default() }
    }

    /// The inputs that this frame requests.
    pub fn requests(&self) -> &[TextInputRequest] {
        &self.requests
    }

    /// Adds an event for the field of this id; the field takes it in the next frame.
    pub fn push_event(&mut self, id: Id, event: TextInputEvent) {
        self.events.push((id, event));
    }

    /// A frame begins: its fields request their inputs anew.
    pub(crate) fn begin_frame(&mut self) {
        self.requests.clear();
    }

    /// A frame ends: events of fields that are gone are dropped.
    pub(crate) fn end_frame(&mut self) {
        self.events.clear();
    }

    fn take_events(&mut self, id: Id) -> Vec<TextInputEvent> {
        self.events.extract_if(.., |(other, _)| *other == id).map(|(_, event)| event).collect()
    }
}

/// What happened to a field since the last frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TextInputResponse {
    /// The text changed.
    pub changed: bool,
    /// Enter was pressed in a field of one line.
    pub submitted: bool,
    /// The keyboard focus left.
    pub lost_focus: bool,
}

/// A text field.
pub struct TextInput<'a> {
    id: Id,
    name: &'a str,
    hint: &'a str,
    kind: TextInputKind,
    rows: u8,
    max_length: u32,
    autocomplete: &'static str,
    enabled: bool,
    take_focus: bool,
}

impl<'a> TextInput<'a> {
    /// A field of one line. `id` distinguishes it from all other fields; `name` is its accessible name.
    pub fn new(id: impl std::hash::Hash + std::fmt::Debug, name: &'a str) -> Self {
        Self {
            id: Id::unique(("text input", id)),
            name,
            hint: "",
            kind: TextInputKind::Line,
            rows: 1,
            max_length: 80,
            autocomplete: "off",
            enabled: true,
            take_focus: false,
        }
    }

    /// Shows `hint` while the text is empty.
    pub fn hint(self, hint: &'a str) -> Self {
        Self { hint, ..self }
    }

    /// What is typed.
    pub fn kind(self, kind: TextInputKind) -> Self {
        Self { kind, ..self }
    }

    /// A field of several lines, of which `rows` are visible.
    pub fn paragraph(self, rows: u8) -> Self {
        Self { kind: TextInputKind::Paragraph, rows, ..self }
    }

    /// Longest text, UTF-16 code units.
    pub fn max_length(self, max_length: u32) -> Self {
        Self { max_length, ..self }
    }

    /// The HTML attribute of this name, such as `current-password`.
    pub fn autocomplete(self, autocomplete: &'static str) -> Self {
        Self { autocomplete, ..self }
    }

    /// Whether the text can be edited.
    pub fn enabled(self, enabled: bool) -> Self {
        Self { enabled, ..self }
    }

    /// Takes the keyboard focus when the field appears.
    pub fn take_focus(self) -> Self {
        Self { take_focus: true, ..self }
    }

    /// Shows the field over the available width and edits `value`.
    pub fn show(
        self,
        ui: &mut Ui,
        tokens: &Tokens,
        inputs: &mut TextInputs,
        value: &mut String,
    ) -> TextInputResponse {
        if inputs.on_page { self.request(ui, tokens, inputs, value) } else { self.draw(ui, value) }
    }

    fn request(
        self,
        ui: &mut Ui,
        tokens: &Tokens,
        inputs: &mut TextInputs,
        value: &mut String,
    ) -> TextInputResponse {
        let mut response = TextInputResponse::default();
        for event in inputs.take_events(self.id) {
            match event {
                TextInputEvent::Changed(text) => {
                    response.changed |= text != *value;
                    *value = text;
                }
                TextInputEvent::Submitted => response.submitted = true,
                TextInputEvent::FocusGained => {}
                TextInputEvent::FocusLost => response.lost_focus = true,
            }
        }
        let height = theme::TOUCH + f32::from(self.rows.saturating_sub(1)) * 22.0;
        let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), height), Sense::hover());
        let radius = CornerRadius::same(theme::BUTTON_RADIUS);
        ui.painter().rect(rect, radius, tokens.ground, tokens.border(), StrokeKind::Inside);
        let clip_rect = ui.clip_rect();
        // An input of the page is above everything that egui draws, so a field under a menu has none.
        let covered = ui.ctx().layer_id_at(rect.center()).is_some_and(|top| top != ui.layer_id());
        if clip_rect.intersects(rect) && !covered {
            inputs.requests.push(TextInputRequest {
                id: self.id,
                name: self.name.to_owned(),
                value: value.clone(),
                hint: self.hint.to_owned(),
                kind: self.kind,
                rect,
                clip_rect,
                max_length: self.max_length,
                autocomplete: self.autocomplete,
                enabled: self.enabled,
                take_focus: self.take_focus,
            });
        }
        response
    }

    fn draw(self, ui: &mut Ui, value: &mut String) -> TextInputResponse {
        let edit = match self.kind {
            TextInputKind::Paragraph => egui::TextEdit::multiline(value).desired_rows(usize::from(self.rows)),
            kind => egui::TextEdit::singleline(value).password(kind == TextInputKind::Password),
        };
        let edit = edit
            .id(self.id)
            .hint_text(self.hint)
            .char_limit(self.max_length as usize)
            .margin(vec2(12.0, 13.0))
            .desired_width(f32::INFINITY);
        let response = ui.add_enabled(self.enabled, edit);
        ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(self.name));
        let lost_focus = response.lost_focus();
        let enter = ui.input(|input| input.key_pressed(egui::Key::Enter));
        TextInputResponse { changed: response.changed(), submitted: lost_focus && enter, lost_focus }
    }
}

#[cfg(test)]
mod tests;
