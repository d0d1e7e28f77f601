//! The readings of a point: a plot for each, and what they have in common in words.

use super::{plot, texts};
use crate::feature_panel::PanelContext;
use crate::paint::line_at;
use crate::theme::{self, Tokens, Weight};
use crate::widgets::{self, fact};
use client_model::ReadingSeries;
use egui::{Sense, Ui, vec2};
use missions::SiteZone;

/// Shows all readings, those of the newest result first.
pub(super) fn show(ui: &mut Ui, cx: &mut PanelContext<'_>, zone: &SiteZone) {
    let model = cx.model;
    let series = model.point_history.series();
    if series.is_empty() {
        return;
    }
    widgets::section_head(ui, cx.tokens, texts::READINGS_HEAD);
    for of_one in series {
        ui.push_id((&of_one.name, &of_one.unit), |ui| show_series(ui, cx, of_one, zone));
    }
    widgets::remark(ui, cx.tokens, texts::PLOT_REMARK);
}

/// The title of a plot. It is painted only: in the accessible tree the plot has this name itself.
fn show_title(ui: &mut Ui, tokens: &Tokens, text: &str) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 20.0), Sense::hover());
    line_at(ui, rect.left_center(), rect.width(), text, (theme::BODY, Weight::Medium), tokens.text);
}

fn show_series(ui: &mut Ui, cx: &mut PanelContext<'_>, series: &ReadingSeries, zone: &SiteZone) {
    let tokens = cx.tokens;
    show_title(ui, tokens, &texts::series(series));
    plot::show(ui, cx, series, zone);
    let Some(analysis) = &series.analysis else { return };
    let (unit, decimals) = (&series.unit, texts::decimals(analysis.deviation));
    let median = texts::median(analysis.median, analysis.median_absolute_deviation, unit, decimals);
    fact(ui, tokens, texts::MEDIAN, &median);
    match analysis.trend {
        Some(trend) if analysis.is_trend_clear => {
            fact(ui, tokens, texts::TREND, &texts::trend(trend.per_s, unit, decimals));
        }
        Some(_) => {
            fact(ui, tokens, texts::TREND, texts::NO_CLEAR_TREND);
        }
        None => widgets::remark(ui, tokens, texts::FEW_READINGS),
    }
    let offsets = || analysis.hour_offsets.iter().flatten().copied();
    let range = offsets().min_by(f64::total_cmp).zip(offsets().max_by(f64::total_cmp));
    if let Some((least, greatest)) = range.filter(|(least, greatest)| least < greatest) {
        fact(ui, tokens, texts::BY_HOUR, &texts::by_hour([least, greatest], unit, decimals));
    }
    if let Some(limits) = series.limits.as_ref().filter(|limits| limits.min.is_some() || limits.max.is_some())
    {
        fact(ui, tokens, texts::LIMITS, &texts::limits(limits.min, limits.max, unit));
    }
    let [unusual, outside] = series.remarkable();
    for (name, count) in [(texts::UNUSUAL, unusual), (texts::OUTSIDE, outside)] {
        if count > 0 {
            fact(ui, tokens, name, &texts::readings(count));
        }
    }
}
