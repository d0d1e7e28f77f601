//! Fields for dates, times and numbers: a text with a button at each side.

use super::texts;
use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::theme::{self, Weight, font};
use crate::{TextInput, icon};
use egui::{Align2, Sense, Ui, vec2};
use missions::{MINUTES_A_DAY, date_of, day_number};
use site_model::{LocalDate, LocalTime};
use std::collections::BTreeMap;

/// Width of the names of fields, points.
const NAME_WIDTH: f32 = 68.0;
/// Longest text of a field, characters.
const MAX_CHARS: u32 = 24;

/// Texts that are typed and not given yet, by the keys of their fields.
#[derive(Debug, Default)]
pub(super) struct TypedFields {
    typed: BTreeMap<String, Typed>,
}

#[derive(Debug)]
struct Typed {
    text: String,
    /// What the field showed when the typing began. Another value replaces what is typed.
    shown: String,
}

impl TypedFields {
    /// Forgets what is typed, as for another schedule.
    pub(super) fn clear(&mut self) {
        self.typed.clear();
    }

    /// What is typed in a field that shows `shown`.
    pub(super) fn text(&mut self, key: &str, shown: &str) -> &mut String {
        let typed = self
            .typed
            .entry(key.to_owned())
            .or_insert_with(|| Typed { text: shown.to_owned(), shown: shown.to_owned() });
        if typed.shown != shown {
            *typed = Typed { text: shown.to_owned(), shown: shown.to_owned() };
        }
        &mut typed.text
    }

    fn forget(&mut self, key: &str) {
        self.typed.remove(key);
    }
}

/// A value with buttons for the one before and the one after.
pub(super) struct StepperField<'a> {
    /// Distinguishes it from all other fields.
    pub(super) key: &'a str,
    /// Its accessible name.
    pub(super) name: &'a str,
    /// Written at its left, if anything is.
    pub(super) caption: &'a str,
    /// The value as text.
    pub(super) shown: &'a str,
}

/// What a stepper was told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum StepperInput {
    Earlier,
    Later,
    Typed(String),
}

impl StepperField<'_> {
    /// Shows it in a row of its own, with `spare` points left free at its right.
    pub(super) fn show(
        self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        typed: &mut TypedFields,
        spare: f32,
    ) -> Option<StepperInput> {
        let tokens = cx.tokens;
        let mut step = None;
        ui.spacing_mut().item_spacing.x = 4.0;
        if !self.caption.is_empty() {
            let (rect, _) = ui.allocate_exact_size(vec2(NAME_WIDTH, theme::TOUCH), Sense::hover());
            let caption_font = font(theme::BODY, Weight::Regular);
            ui.painter().text(
                rect.left_center(),
                Align2::LEFT_CENTER,
                self.caption,
                caption_font,
                tokens.dim,
            );
        }
        if Button::icon_only(&texts::earlier(self.name), icon::MINUS).show(ui, tokens).clicked() {
            step = Some(StepperInput::Earlier);
        }
        let width = (ui.available_width() - theme::TOUCH - 4.0 - spare).max(60.0);
        let text = typed.text(self.key, self.shown);
        let response = ui
            .allocate_ui(vec2(width, theme::TOUCH), |ui| {
                ui.set_max_width(width);
                let field = TextInput::new(("schedule field", self.key), self.name).max_length(MAX_CHARS);
                field.show(ui, tokens, cx.text_inputs, text)
            })
            .inner;
        if response.submitted || response.lost_focus {
            let given = text.clone();
            typed.forget(self.key);
            if given != self.shown {
                step = Some(StepperInput::Typed(given));
            }
        }
        if Button::icon_only(&texts::later(self.name), icon::PLUS).show(ui, tokens).clicked() {
            step = Some(StepperInput::Later);
        }
        step
    }
}

/// The time after a step of 15 minutes, or as it was typed: `9`, `9:30`, `930`.
pub(super) fn stepped_time(time: LocalTime, step: &StepperInput) -> Option<LocalTime> {
    let minute = i64::from(time.hour) * 60 + i64::from(time.minute);
    match step {
        StepperInput::Earlier => Some(time_of((minute - 1).div_euclid(15) * 15)),
        StepperInput::Later => Some(time_of(minute.div_euclid(15) * 15 + 15)),
        StepperInput::Typed(text) => parse_time(text),
    }
}

fn time_of(minute: i64) -> LocalTime {
    let minute = minute.rem_euclid(MINUTES_A_DAY);
    LocalTime { hour: (minute / 60) as u8, minute: (minute % 60) as u8 }
}

/// A time as it is typed: `9`, `9:30`, `930`.
pub(crate) fn parse_time(text: &str) -> Option<LocalTime> {
    let text = text.trim();
    let (hour, minute) = match text.split_once([':', '.', ' ']) {
        Some(parts) => parts,
        None if text.len() > 2 && text.is_ascii() => text.split_at(text.len() - 2),
        None => (text, "0"),
    };
    let time = LocalTime { hour: hour.parse().ok()?, minute: minute.parse().ok()? };
    time.is_valid().then_some(time)
}

/// The day before or after, or as it was typed: `2026-11-25`.
pub(super) fn stepped_date(date: LocalDate, step: &StepperInput) -> Option<LocalDate> {
    match step {
        StepperInput::Earlier => Some(date_of(day_number(date) - 1)),
        StepperInput::Later => Some(date_of(day_number(date) + 1)),
        StepperInput::Typed(text) => parse_date(text),
    }
}

/// A date as it is typed: `2026-11-25`.
pub(crate) fn parse_date(text: &str) -> Option<LocalDate> {
    let mut parts = text.trim().split(['-', '/']);
    let date = LocalDate {
        year: parts.next()?.parse().ok()?,
        month: parts.next()?.parse().ok()?,
        day: parts.next()?.parse().ok()?,
    };
    (parts.next().is_none() && date.is_valid()).then_some(date)
}

/// An interval in minutes, longer or shorter, or as it was typed: `90`, `90 min`, `4 h`, `2 d`.
pub(super) fn stepped_interval(minutes: i64, step: &StepperInput) -> Option<i64> {
    let unit = match minutes {
        _ if minutes % MINUTES_A_DAY == 0 => MINUTES_A_DAY,
        _ if minutes % 60 == 0 => 60,
        _ => 5,
    };
    match step {
        StepperInput::Earlier if minutes > unit => Some(minutes - unit),
        // One unit less than one unit is counted in the next smaller one.
        StepperInput::Earlier => Some((minutes - if unit == MINUTES_A_DAY { 60 } else { 5 }).max(5)),
        StepperInput::Later => Some(minutes + unit),
        StepperInput::Typed(text) => parse_interval(text),
    }
}

pub(super) fn parse_interval(text: &str) -> Option<i64> {
    let text = text.trim().to_lowercase();
    let digits = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let unit_min = match unit.trim().chars().next() {
        None | Some('m') => 1,
        Some('h') => 60,
        Some('d') => MINUTES_A_DAY,
        Some(_) => return None,
    };
    let number: i64 = if number.is_empty() { 1 } else { number.parse().ok()? };
    number.checked_mul(unit_min).filter(|minutes| (5..=366 * MINUTES_A_DAY).contains(minutes))
}
