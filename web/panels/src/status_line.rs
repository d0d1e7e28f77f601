//! Statuses of the top bar: icon and texts in a row, in as much detail as there is room for.

use crate::theme::{self, Weight, font};
use crate::widgets;
use egui::{Color32, Response, Ui};

/// How much the statuses of the top bar show. The bar takes the first of [`Self::ALL`] that fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum StatusDetail {
    /// Icons, and words where an icon does not say enough.
    Least,
    /// One word or figure for each.
    Short,
    /// With the figures that belong to them.
    Normal,
    /// With ages, remaining times and names of the statuses.
    Full,
}

impl StatusDetail {
    /// All of them, the most detailed first.
    pub(crate) const ALL: [Self; 4] = [Self::Full, Self::Normal, Self::Short, Self::Least];

    /// Distance between two statuses, points.
    pub(crate) fn spacing(self) -> f32 {
        if self == Self::Full { 18.0 } else { 10.0 }
    }
}

/// One status: its parts side by side.
#[derive(Clone, Debug)]
pub(crate) struct StatusLine {
    name: &'static str,
    value: String,
    parts: Vec<(String, f32, Weight, Color32)>,
    hint: Option<String>,
}

impl StatusLine {
    /// A status that has this name and value in the accessible tree, whatever of it is shown.
    pub(crate) fn new(name: &'static str, value: &str) -> Self {
        Self { name, value: value.trim().to_owned(), parts: Vec::new(), hint: None }
    }

    /// With an icon.
    pub(crate) fn icon(self, icon: &str, colour: Color32) -> Self {
        self.part(icon, theme::ICON, Weight::Regular, colour)
    }

    /// With a text; an empty one is not shown.
    pub(crate) fn text(self, text: &str, colour: Color32) -> Self {
        self.part(text, theme::BODY, Weight::Regular, colour)
    }

    /// With a text of another size or weight.
    pub(crate) fn part(mut self, text: &str, size: f32, weight: Weight, colour: Color32) -> Self {
        self.parts.push((text.to_owned(), size, weight, colour));
        self
    }

    /// With an explanation for a pointer that rests on it.
    pub(crate) fn hint(self, hint: String) -> Self {
        Self { hint: Some(hint), ..self }
    }

    /// Its width, points.
    pub(crate) fn width(&self, ui: &Ui) -> f32 {
        let width = |(text, size, weight, colour): &(String, f32, Weight, Color32)| {
            ui.painter().layout_no_wrap(text.clone(), font(*size, *weight), *colour).size().x
        };
        let widths = self.parts.iter().filter(|(text, ..)| !text.is_empty()).map(width);
        widths.reduce(|sum, width| sum + widgets::STATUS_PART_GAP + width).unwrap_or(0.0)
    }

    /// Shows it.
    pub(crate) fn show(&self, ui: &mut Ui) -> Response {
        let parts: Vec<_> = self
            .parts
            .iter()
            .map(|(text, size, weight, colour)| (text.as_str(), *size, *weight, *colour))
            .collect();
        let response = widgets::status_line(ui, self.name, &self.value, &parts);
        match &self.hint {
            Some(hint) => response.on_hover_text(hint),
            None => response,
        }
    }
}
