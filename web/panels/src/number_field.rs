//! A field for a number of an object: a caption, a text, and a button at each side for a step less and a step more.

use crate::TextInput;
use crate::TextInputKind;
use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::features::action_form::{parameter_problem, show_problem};
use crate::format::decimal;
use crate::icon;
use crate::paint::line_at;
use crate::theme::{self, Weight};
use client_model::ParameterProblem;
use egui::{Sense, Ui, vec2};
use site_model::ObjectId;

/// Width of the caption, points.
const CAPTION_WIDTH: f32 = 104.0;
/// Distance between the parts, points.
const GAP: f32 = 4.0;
/// Longest text, characters.
const MAX_CHARS: u32 = 16;

/// A field of this object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NumberField<'a> {
    /// Accessible name and caption, with the unit.
    pub(crate) name: &'a str,
    /// The object.
    pub(crate) object: ObjectId,
    /// Its number; `None`: it has none.
    pub(crate) value: Option<f64>,
    /// What holds while it has none.
    pub(crate) hint: &'a str,
    /// What a button adds or takes. From no number, the first step leads to the number of the range that is nearest to 0.
    pub(crate) step: f64,
    /// Digits after the point.
    pub(crate) decimals: usize,
    /// Smallest and greatest number.
    pub(crate) range: [f64; 2],
}

/// What is typed in one of the fields of a panel and not taken yet.
#[derive(Debug, Default)]
pub(crate) struct TypedNumber(Option<Typed>);

#[derive(Debug)]
struct Typed {
    field: (ObjectId, String),
    /// What the field showed when the typing began. Another number replaces what is typed.
    shown: String,
    text: String,
}

impl NumberField<'_> {
    /// Shows it in a row. Returns the number once it is changed; `Some(None)` once it was taken away.
    pub(crate) fn show(
        self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        typed: &mut TypedNumber,
    ) -> Option<Option<f64>> {
        let tokens = cx.tokens;
        let shown = self.value.map(|value| decimal(value, self.decimals)).unwrap_or_default();
        let key = (self.object, self.name.to_owned());
        let before = typed.0.as_ref().filter(|typed| typed.field == key && typed.shown == shown);
        let mut text = before.map_or_else(|| shown.clone(), |typed| typed.text.clone());
        let mut changed = None;
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = GAP;
            let (rect, _) = ui.allocate_exact_size(vec2(CAPTION_WIDTH, theme::TOUCH), Sense::hover());
            line_at(
                ui,
                rect.left_center(),
                rect.width(),
                self.name,
                (theme::BODY, Weight::Regular),
                tokens.dim,
            );
            if Button::icon_only(&less(self.name), icon::MINUS).show(ui, tokens).clicked() {
                changed = Some(Some(self.stepped(-self.step)));
            }
            let width = (ui.available_width() - theme::TOUCH - GAP).max(48.0);
            let response = ui
                .allocate_ui(vec2(width, theme::TOUCH), |ui| {
                    ui.set_max_width(width);
                    let input = TextInput::new(("number", &key), self.name).kind(TextInputKind::Number);
                    input.hint(self.hint).max_length(MAX_CHARS).show(ui, tokens, cx.text_inputs, &mut text)
                })
                .inner;
            if response.submitted || response.lost_focus {
                typed.0 = None;
                if text.trim() != shown {
                    changed = self.parse(&text);
                }
            } else if response.changed {
                typed.0 = Some(Typed { field: key, shown, text });
            }
            if Button::icon_only(&more(self.name), icon::PLUS).show(ui, tokens).clicked() {
                changed = Some(Some(self.stepped(self.step)));
            }
        });
        let is_typed = |typed: &&Typed| typed.field.0 == self.object && typed.field.1 == self.name;
        if let Some(problem) = typed.0.as_ref().filter(is_typed).and_then(|typed| self.problem(&typed.text)) {
            show_problem(ui, tokens, &parameter_problem(self.name, "", 1.0, problem));
        }
        changed.filter(|value| *value != self.value)
    }

    /// What is wrong with a typed text. When the field is left, a number out of range becomes the nearest in it, and what is no number is dropped.
    fn problem(&self, text: &str) -> Option<ParameterProblem> {
        let [min, max] = self.range;
        match text.trim().replace(',', ".").parse::<f64>() {
            _ if text.trim().is_empty() => self.hint.is_empty().then_some(ParameterProblem::Missing),
            Ok(number) if (min..=max).contains(&number) => None,
            Ok(_) => Some(ParameterProblem::OutOfRange(min, max)),
            Err(_) => Some(ParameterProblem::WrongType),
        }
    }

    /// The next number in this direction; steps end at multiples of themselves.
    fn stepped(&self, step: f64) -> f64 {
        let [min, max] = self.range;
        let Some(value) = self.value else { return 0.0_f64.clamp(min, max) };
        let steps = value / self.step;
        // A number that is nearly a multiple counts as one.
        let next = if step < 0.0 { (steps - 1e-6).ceil() - 1.0 } else { (steps + 1e-6).floor() + 1.0 };
        (next * self.step).clamp(min, max)
    }

    /// A typed number; an empty text takes it away. `None` for what is no number.
    fn parse(&self, text: &str) -> Option<Option<f64>> {
        let text = text.trim().replace(',', ".");
        if text.is_empty() {
            return (!self.hint.is_empty()).then_some(None);
        }
        let number: f64 = text.parse().ok().filter(|number: &f64| number.is_finite())?;
        Some(Some(number.clamp(self.range[0], self.range[1])))
    }
}

fn less(name: &str) -> String {
    format!("Less: {name}")
}

fn more(name: &str) -> String {
    format!("More: {name}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(value: Option<f64>) -> NumberField<'static> {
        let object = ObjectId::Settings;
        NumberField {
            name: "Width (m)",
            object,
            value,
            hint: "any",
            step: 0.1,
            decimals: 2,
            range: [0.0, 1.0],
        }
    }

    #[test]
    fn steps_lead_to_multiples_and_stay_in_range() {
        assert!((field(Some(0.34)).stepped(0.1) - 0.4).abs() < 1e-9);
        assert!((field(Some(0.3)).stepped(-0.1) - 0.2).abs() < 1e-9);
        assert_eq!(field(Some(1.0)).stepped(0.1), 1.0);
        assert_eq!(field(None).stepped(0.1), 0.0);
    }

    #[test]
    fn what_is_wrong_with_a_typed_number_is_said() {
        assert_eq!(field(None).problem("0,5"), None);
        assert_eq!(field(None).problem("7"), Some(ParameterProblem::OutOfRange(0.0, 1.0)));
        assert_eq!(field(None).problem("wide"), Some(ParameterProblem::WrongType));
        assert_eq!(field(None).problem(""), None, "it may have none");
        let needed = NumberField { hint: "", ..field(Some(0.5)) };
        assert_eq!(needed.problem(" "), Some(ParameterProblem::Missing));
    }

    #[test]
    fn typed_numbers_are_kept_in_range_and_nonsense_changes_nothing() {
        assert_eq!(field(None).parse("0,5"), Some(Some(0.5)));
        assert_eq!(field(None).parse("7"), Some(Some(1.0)));
        assert_eq!(field(Some(0.5)).parse(" "), Some(None));
        assert_eq!(field(None).parse("inf"), None);
        assert_eq!(field(None).parse("wide"), None);
        assert_eq!(NumberField { hint: "", ..field(Some(0.5)) }.parse(""), None);
    }
}
