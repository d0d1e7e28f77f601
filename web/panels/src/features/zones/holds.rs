//! At which heights and times a zone holds.

use super::change::change;
use super::texts;
use crate::feature_panel::PanelContext;
use crate::features::schedule::{parse_time, shown_time};
use crate::number_field::{NumberField, TypedNumber};
use crate::select::show_caption;
use crate::{TextInput, widgets};
use egui::Ui;
use site_model::{LocalTime, ObjectId, Zone, ZoneId};

/// Heights that people may enter, m.
const RANGE_M: [f64; 2] = [-10_000.0, 10_000.0];
/// What the limits of a zone begin with.
#[derive(Clone, Copy, Debug)]
struct NewLimitsConfig {
    /// Heights of a zone that held at all of them, metres: those of a robot on the floor on which the map began. Chosen: they hold for no other floor.
    heights_m: [f64; 2],
    /// Smallest difference of the two heights, metres. Chosen: a decimetre, the last digit that people enter.
    min_height_range_m: f64,
    /// Hours of a zone that held always: a working day. Chosen: as common at many sites.
    hours: [LocalTime; 2],
}

const NEW: NewLimitsConfig = NewLimitsConfig {
    heights_m: [-1.0, 2.0],
    min_height_range_m: 0.1,
    hours: [LocalTime { hour: 8, minute: 0 }, LocalTime { hour: 17, minute: 0 }],
};
/// Longest text of a time, characters.
const TIME_CHARS: u32 = 8;

/// All heights, the heights of a floor, or from one to another.
pub(super) fn show_heights(ui: &mut Ui, cx: &mut PanelContext<'_>, typed: &mut TypedNumber, zone: &Zone) {
    let (site, tokens) = (&cx.model.site, cx.tokens);
    widgets::section_head(ui, tokens, texts::HEIGHT_HEAD);
    let first = cx.model.site.shown_floor().and_then(|floor| site.floor_heights_m(floor));
    let first = first.unwrap_or(NEW.heights_m);
    let mut chosen = zone.height_m;
    let choices = [(texts::ALL_HEIGHTS, false), (texts::SOME_HEIGHTS, true)];
    widgets::choice(ui, tokens, &choices, zone.height_m.is_some(), |is_limited| {
        chosen = is_limited.then(|| zone.height_m.unwrap_or(first));
    });
    let floors = site.floors();
    if floors.len() > 1 {
        let of_floors: Vec<(String, [f64; 2])> = floors
            .into_iter()
            .filter_map(|floor| Some((texts::only_floor(floor), site.floor_heights_m(floor)?)))
            .collect();
        for row in of_floors.chunks(2) {
            let row: Vec<(&str, Option<[f64; 2]>)> =
                row.iter().map(|(name, heights)| (name.as_str(), Some(*heights))).collect();
            widgets::choice(ui, tokens, &row, zone.height_m, |heights| chosen = heights);
        }
    }
    if let Some([low, high]) = zone.height_m {
        let object = ObjectId::Zone(zone.id);
        let ranges =
            [[RANGE_M[0], high - NEW.min_height_range_m], [low + NEW.min_height_range_m, RANGE_M[1]]];
        for (index, name) in texts::HEIGHTS.into_iter().enumerate() {
            let value = Some([low, high][index]);
            let range = ranges[index];
            let field = NumberField { name, object, value, hint: "", step: 0.5, decimals: 2, range };
            if let Some(height) = field.show(ui, cx, typed).flatten() {
                chosen = Some(if index == 0 { [height, high] } else { [low, height] });
            }
        }
    }
    if chosen != zone.height_m {
        change(cx, zone, |zone| zone.height_m = chosen);
    }
}

/// What is typed of the hours of a zone.
#[derive(Debug, Default)]
pub(super) struct HoldsFields {
    typed: Option<(ZoneId, [String; 2])>,
}

impl HoldsFields {
    /// Always, or from one time of each day to another.
    pub(super) fn show_times(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, zone: &Zone) {
        let tokens = cx.tokens;
        widgets::section_head(ui, tokens, texts::TIME_HEAD);
        let choices = [(texts::ALWAYS, false), (texts::DAILY, true)];
        let mut chosen = zone.daily;
        widgets::choice(ui, tokens, &choices, zone.daily.is_some(), |is_limited| {
            chosen = is_limited.then(|| zone.daily.unwrap_or(NEW.hours));
        });
        if let Some(hours) = zone.daily {
            chosen = self.show_hours(ui, cx, zone, hours).or(chosen);
            widgets::remark(ui, tokens, texts::DAILY_REMARK);
        } else {
            self.typed = None;
        }
        if chosen != zone.daily {
            self.typed = None;
            change(cx, zone, |zone| zone.daily = chosen);
        }
    }

    fn show_hours(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        zone: &Zone,
        hours: [LocalTime; 2],
    ) -> Option<[LocalTime; 2]> {
        if self.typed.as_ref().is_none_or(|(of, _)| *of != zone.id) {
            self.typed = Some((zone.id, hours.map(shown_time)));
        }
        let (_, typed) = self.typed.as_mut()?;
        let (mut is_left, tokens) = (false, cx.tokens);
        ui.horizontal_top(|ui| {
            ui.spacing_mut().item_spacing.x = 8.0;
            let width = ((ui.available_width() - 8.0) / 2.0).floor();
            for (text, name) in typed.iter_mut().zip(texts::HOURS) {
                ui.vertical(|ui| {
                    ui.set_width(width);
                    show_caption(ui, tokens, name);
                    let field = TextInput::new(("hours of zone", zone.id.0, name), name);
                    let response = field.max_length(TIME_CHARS).show(ui, tokens, cx.text_inputs, text);
                    is_left |= response.submitted || response.lost_focus;
                });
            }
        });
        let given = [parse_time(&typed[0])?, parse_time(&typed[1])?];
        (is_left && given[0] != given[1]).then_some(given)
    }
}
