//! A reading over time: values, limits, trend, and marks of readings that are unusual or outside the limits. At most one mark is drawn in a column of a pixel, whatever the number of readings.

use super::strip::{ask, paint_labels};
use super::texts;
use super::time_axis::TimeAxis;
use crate::feature_panel::PanelContext;
use crate::theme::{self, Tokens, Weight, font};
use crate::widgets;
use client_model::{PointHistoryCommand, ReadingSeries, SeriesValue};
use egui::{Align2, Id, Painter, Rect, Sense, Shape, Stroke, Ui, Vec2, pos2, vec2};
use missions::SiteZone;

/// Height of a plot without its labels, points.
const PLOT_HEIGHT: f32 = 132.0;
/// Height of the labels of the times, points.
const LABELS_HEIGHT: f32 = 18.0;
/// Room for the labels of the values, points.
const LEFT: f32 = 48.0;
/// Side of the mark of one reading, points.
const DOT: f32 = 3.0;
/// Values with a label at most.
const MAX_LABELS: f64 = 4.0;

/// What the readings in one column of a pixel have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Column {
    least: f64,
    greatest: f64,
    /// The value that is outside the limits, and the one that is unusual, if there is one.
    outside: Option<f64>,
    unusual: Option<f64>,
}

/// The readings of each column; none in a column without any.
pub(super) fn columns(series: &ReadingSeries, axis: &TimeAxis) -> Vec<Option<Column>> {
    let mut columns: Vec<Option<Column>> = vec![None; axis.columns()];
    for value in series.values.iter().filter(|value| value.value.is_finite()) {
        let Some(index) = axis.column(value.at) else { continue };
        let first = Column { least: value.value, greatest: value.value, outside: None, unusual: None };
        let column = columns[index].get_or_insert(first);
        column.least = column.least.min(value.value);
        column.greatest = column.greatest.max(value.value);
        if value.outside.is_some() {
            column.outside = Some(value.value);
        } else if value.is_anomaly {
            column.unusual = Some(value.value);
        }
    }
    columns
}

/// The axis of the values.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ValueAxis {
    least: f64,
    greatest: f64,
    place: Rect,
}

impl ValueAxis {
    /// Over these columns. A limit takes part if it is not farther away than the readings are apart, so that they are not pressed flat.
    fn of(columns: &[Option<Column>], series: &ReadingSeries, place: Rect) -> Option<Self> {
        let shown = || columns.iter().flatten();
        let least = shown().map(|column| column.least).min_by(f64::total_cmp)?;
        let greatest = shown().map(|column| column.greatest).max_by(f64::total_cmp)?;
        let span = (greatest - least).max(1e-3 * greatest.abs().max(1e-6));
        let near = |limit: &f64| *limit >= least - span && *limit <= greatest + span;
        let limits = series.limits.as_ref().map_or([None; 2], |limits| [limits.min, limits.max]);
        let limits = || limits.into_iter().flatten().filter(near);
        let least = limits().fold(least, f64::min);
        let greatest = limits().fold(greatest, f64::max);
        let margin = 0.08 * (greatest - least).max(span);
        Some(Self { least: least - margin, greatest: greatest + margin, place })
    }

    fn y(&self, value: f64) -> f32 {
        let share = (value - self.least) / (self.greatest - self.least).max(f64::MIN_POSITIVE);
        self.place.bottom() - share as f32 * self.place.height()
    }

    /// Distance of the labels: 1, 2 or 5 times a power of ten.
    fn step(&self) -> f64 {
        let least = (self.greatest - self.least) / MAX_LABELS;
        let power = 10_f64.powf(least.log10().floor());
        let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= least).unwrap_or(10.0);
        factor * power
    }
}

/// Shows a plot over the width that there is. A press chooses the result of the nearest reading.
pub(super) fn show(ui: &mut Ui, cx: &mut PanelContext<'_>, series: &ReadingSeries, zone: &SiteZone) {
    let Some(range) = cx.model.point_history.range() else { return };
    let tokens = cx.tokens;
    let size = vec2(ui.available_width(), PLOT_HEIGHT + LABELS_HEIGHT);
    let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
    let place = Rect::from_min_max(
        pos2(rect.left() + LEFT, rect.top()),
        pos2(rect.right(), rect.top() + PLOT_HEIGHT),
    );
    let id = Id::unique(("readings over time", &series.name, &series.unit));
    let response = ui.interact(place, id, Sense::click());
    let deviation = series.analysis.as_ref().map_or(0.0, |analysis| analysis.deviation);
    let decimals = texts::decimals(deviation);
    widgets::status_node(&response, &texts::series(series), &texts::plot_value(series, decimals));
    if !ui.is_rect_visible(rect) {
        return;
    }
    let axis = TimeAxis::new(range, place);
    let painter = ui.painter_at(place.expand(1.0));
    painter.rect_filled(place, f32::from(theme::BUTTON_RADIUS), tokens.raised);
    let columns = columns(series, &axis);
    let Some(values) = ValueAxis::of(&columns, series, place) else {
        return crate::features::runs::show_note(ui, tokens, place, texts::EMPTY_SPAN);
    };
    paint_values_labels(ui, tokens, &values);
    let labels = Rect::from_min_max(pos2(rect.left(), place.bottom()), rect.max);
    paint_labels(ui, tokens, &axis, labels.with_min_x(place.left()), zone);
    paint_limits(&painter, tokens, series, &values);
    paint_trend(&painter, tokens, series, &axis, &values);
    for (index, column) in columns.iter().enumerate() {
        if let Some(column) = column {
            paint_column(&painter, tokens, axis.column_x(index), column, &values);
        }
    }
    let Some(pointer) = response.hover_pos() else { return };
    let at = axis.at(pointer.x);
    let shown = series.values.iter().filter(|value| axis.column(value.at).is_some());
    let Some(nearest) = shown.min_by_key(|value| value.at.0.abs_diff(at.0)) else { return };
    paint_reading(&painter, tokens, nearest, series, (&axis, &values), zone, decimals);
    if response.clicked() {
        ask(cx, PointHistoryCommand::Choose(nearest.result));
    }
}

fn paint_values_labels(ui: &Ui, tokens: &Tokens, values: &ValueAxis) {
    let step = values.step();
    let decimals = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
    let mut value = (values.least / step).ceil() * step;
    while value <= values.greatest {
        let y = values.y(value);
        let line = [pos2(values.place.left(), y), pos2(values.place.right(), y)];
        ui.painter().line_segment(line, Stroke::new(1.0, tokens.faint()));
        let at = pos2(values.place.left() - 6.0, y);
        let text = crate::format::decimal(value, decimals);
        ui.painter().text(at, Align2::RIGHT_CENTER, text, font(theme::SMALL, Weight::Regular), tokens.dim);
        value += step;
    }
}

fn paint_limits(painter: &Painter, tokens: &Tokens, series: &ReadingSeries, values: &ValueAxis) {
    let limits = series.limits.as_ref().map_or([None; 2], |limits| [limits.min, limits.max]);
    for limit in limits.into_iter().flatten() {
        let y = values.y(limit);
        let line = [pos2(values.place.left(), y), pos2(values.place.right(), y)];
        painter.extend(Shape::dashed_line(&line, Stroke::new(1.5, tokens.bad), 6.0, 4.0));
    }
}

fn paint_trend(
    painter: &Painter,
    tokens: &Tokens,
    series: &ReadingSeries,
    axis: &TimeAxis,
    values: &ValueAxis,
) {
    if let (Some(from), Some(to)) = (series.trend_at(axis.from), series.trend_at(axis.to)) {
        let line = [pos2(axis.x(axis.from), values.y(from)), pos2(axis.x(axis.to), values.y(to))];
        painter.line_segment(line, Stroke::new(1.5, tokens.dim));
    }
}

/// One column: a dot, or a line from the least to the greatest reading, and a sign if one of them is unusual or outside the limits.
fn paint_column(painter: &Painter, tokens: &Tokens, x: f32, column: &Column, values: &ValueAxis) {
    let [low, high] = [values.y(column.least), values.y(column.greatest)];
    if low - high > 3.0 {
        painter.line_segment([pos2(x, low), pos2(x, high)], Stroke::new(1.5, tokens.accent));
    } else {
        let dot = Rect::from_center_size(pos2(x, 0.5 * (low + high)), Vec2::splat(DOT));
        painter.rect_filled(dot, 0.0, tokens.accent);
    }
    if let Some(value) = column.outside {
        let centre = pos2(x, values.y(value));
        for tip in [vec2(4.0, 4.0), vec2(4.0, -4.0)] {
            painter.line_segment([centre - tip, centre + tip], Stroke::new(2.0, tokens.bad));
        }
    } else if let Some(value) = column.unusual {
        let centre = pos2(x, values.y(value));
        let tips = [vec2(0.0, -5.5), vec2(5.0, 4.0), vec2(-5.0, 4.0)].map(|tip| centre + tip);
        painter.add(Shape::closed_line(tips.to_vec(), Stroke::new(1.8, tokens.warn)));
    }
}

/// The reading that is nearest to the pointer.
fn paint_reading(
    painter: &Painter,
    tokens: &Tokens,
    value: &SeriesValue,
    series: &ReadingSeries,
    (axis, values): (&TimeAxis, &ValueAxis),
    zone: &SiteZone,
    decimals: usize,
) {
    let at = pos2(axis.x(value.at), values.y(value.value));
    painter.circle_stroke(at, 5.0, Stroke::new(2.0, tokens.text));
    let text = texts::value_at(value.value, &series.unit, decimals, zone.to_local(value.at));
    let galley = painter.layout_no_wrap(text, font(theme::SMALL, Weight::Medium), tokens.text);
    let place = values.place;
    let left =
        (at.x - 0.5 * galley.size().x).min(place.right() - galley.size().x - 8.0).max(place.left() + 8.0);
    let is_low = at.y < place.center().y;
    let top = if is_low { place.bottom() - galley.size().y - 6.0 } else { place.top() + 6.0 };
    let label = Rect::from_min_size(pos2(left, top), galley.size());
    painter.rect_filled(
        label.expand2(vec2(6.0, 3.0)),
        f32::from(theme::BUTTON_RADIUS),
        tokens.card.to_opaque(),
    );
    painter.galley(label.min, galley, tokens.text);
}
