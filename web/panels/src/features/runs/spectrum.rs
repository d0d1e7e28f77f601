//! A gamma spectrum as a plot: counts on a logarithmic axis over the energy.

use super::texts;
use crate::format;
use crate::theme::{self, Tokens, Weight, font, mix};
use egui::{Align2, Painter, Pos2, Rect, Stroke, Ui, pos2, vec2};
use site_model::GammaSpectrum;

/// Least distance of the labels of the energy axis, points.
const LABEL_DISTANCE: f32 = 72.0;
/// Space for the labels at the left and below, points.
const MARGIN: egui::Vec2 = vec2(44.0, 36.0);

/// Events of a whole spectrum.
pub(super) fn total(spectrum: &GammaSpectrum) -> u64 {
    spectrum.counts.iter().map(|count| u64::from(*count)).sum()
}

/// Greatest number of events in a channel.
pub(super) fn highest(spectrum: &GammaSpectrum) -> u32 {
    spectrum.counts.iter().copied().max().unwrap_or(0)
}

/// The axes of one or several plots.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Axes {
    plot: Rect,
    first_kev: f64,
    last_kev: f64,
    /// Logarithm of the greatest number of events.
    decades: f32,
}

impl Axes {
    fn x(&self, kev: f64) -> f32 {
        let share = (kev - self.first_kev) / (self.last_kev - self.first_kev).max(f64::EPSILON);
        self.plot.left() + share as f32 * self.plot.width()
    }

    fn kev(&self, x: f32) -> f64 {
        let share = f64::from((x - self.plot.left()) / self.plot.width().max(1.0));
        self.first_kev + share * (self.last_kev - self.first_kev)
    }

    /// Half an event lies on the axis, so that one event can be seen.
    fn y(&self, count: f32) -> f32 {
        let share = (count.max(0.5) * 2.0).log10() / (self.decades + 2.0_f32.log10());
        self.plot.bottom() - share.min(1.0) * self.plot.height()
    }
}

/// Paints the curve only, as a small picture of the spectrum.
pub(super) fn paint_small(ui: &Ui, tokens: &Tokens, rect: Rect, spectrum: &GammaSpectrum) {
    let axes = axes_in(rect.shrink2(vec2(8.0, 8.0)), spectrum, highest(spectrum));
    paint_curve(ui.painter(), tokens, &axes, spectrum);
}

/// Paints the plot. `highest`: greatest number of events that the axis shows. `hover`: where the pointer is. Returns what is read there.
pub(super) fn paint(
    ui: &Ui,
    tokens: &Tokens,
    rect: Rect,
    spectrum: &GammaSpectrum,
    highest: u32,
    hover: Option<Pos2>,
) -> Option<String> {
    let plot = Rect::from_min_max(
        rect.min + vec2(MARGIN.x, 12.0),
        pos2(rect.right() - 12.0, rect.bottom() - MARGIN.y),
    );
    let axes = axes_in(plot, spectrum, highest);
    let painter = ui.painter_at(rect);
    paint_axes(&painter, tokens, &axes);
    paint_curve(&painter, tokens, &axes, spectrum);
    let at = hover.filter(|at| plot.contains(*at))?;
    let kev = axes.kev(at.x);
    let channel = ((kev - spectrum.first_kev) / spectrum.channel_kev.max(f64::EPSILON)).floor();
    let count = *spectrum.counts.get(channel.max(0.0) as usize)?;
    let stroke = Stroke::new(1.0, tokens.accent);
    painter.line_segment([pos2(at.x, plot.top()), pos2(at.x, plot.bottom())], stroke);
    painter.circle_filled(pos2(at.x, axes.y(count as f32)), 4.0, tokens.accent);
    let text = texts::spectrum_at(kev, count);
    let is_left = at.x > plot.center().x;
    let (align, offset) = if is_left { (Align2::RIGHT_TOP, -10.0) } else { (Align2::LEFT_TOP, 10.0) };
    let galley = painter.layout_no_wrap(text.clone(), font(theme::BODY, Weight::Medium), tokens.text);
    let label = align.anchor_size(pos2(at.x + offset, plot.top() + 8.0), galley.size());
    painter.rect(
        label.expand2(vec2(8.0, 4.0)),
        f32::from(theme::BUTTON_RADIUS),
        tokens.raised,
        tokens.border(),
        egui::StrokeKind::Inside,
    );
    painter.galley(label.min, galley, tokens.text);
    Some(text)
}

fn axes_in(plot: Rect, spectrum: &GammaSpectrum, highest: u32) -> Axes {
    let last_kev = spectrum.first_kev + spectrum.channel_kev * spectrum.counts.len() as f64;
    let decades = (highest.max(1) as f32).log10().ceil().max(1.0);
    Axes { plot, first_kev: spectrum.first_kev, last_kev, decades }
}

fn paint_axes(painter: &Painter, tokens: &Tokens, axes: &Axes) {
    let plot = axes.plot;
    let small = font(theme::SMALL, Weight::Regular);
    let grid = Stroke::new(1.0, tokens.faint());
    for decade in 0..=axes.decades as u32 {
        let count = 10_u64.pow(decade);
        let y = axes.y(count as f32);
        painter.line_segment([pos2(plot.left(), y), pos2(plot.right(), y)], grid);
        let at = pos2(plot.left() - 8.0, y);
        painter.text(at, Align2::RIGHT_CENTER, format::count(count), small.clone(), tokens.dim);
    }
    let step = energy_step(axes);
    let mut kev = (axes.first_kev / step).ceil() * step;
    while kev <= axes.last_kev {
        let x = axes.x(kev);
        painter.line_segment([pos2(x, plot.top()), pos2(x, plot.bottom())], grid);
        let at = pos2(x, plot.bottom() + 4.0);
        painter.text(at, Align2::CENTER_TOP, format!("{kev:.0}"), small.clone(), tokens.dim);
        kev += step;
    }
    let below = pos2(plot.center().x, plot.bottom() + 19.0);
    painter.text(below, Align2::CENTER_TOP, texts::ENERGY_AXIS, small.clone(), tokens.dim);
    let above = plot.left_top() + vec2(6.0, 2.0);
    painter.text(above, Align2::LEFT_TOP, texts::COUNT_AXIS, small, tokens.dim);
    let border = Stroke::new(1.0, tokens.dim);
    painter.line_segment([plot.left_bottom(), plot.right_bottom()], border);
    painter.line_segment([plot.left_top(), plot.left_bottom()], border);
}

/// Distance of the labels of the energy axis, keV: 1, 2 or 5 times a power of ten.
fn energy_step(axes: &Axes) -> f64 {
    let labels = f64::from((axes.plot.width() / LABEL_DISTANCE).max(1.0));
    let least = ((axes.last_kev - axes.first_kev) / labels).max(1.0);
    let power = 10_f64.powf(least.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= least).unwrap_or(10.0);
    factor * power
}

/// Of the channels within one column of pixels, the one with the most events is drawn, so that no line of the spectrum is lost.
fn paint_curve(painter: &Painter, tokens: &Tokens, axes: &Axes, spectrum: &GammaSpectrum) {
    let columns = (axes.plot.width().ceil() as usize).clamp(1, 4_096);
    let channels = spectrum.counts.len();
    if channels == 0 {
        return;
    }
    let mut line = Vec::with_capacity(columns);
    let fill = mix(tokens.card, tokens.accent, 0.28);
    for column in 0..columns {
        let range = column * channels / columns
            ..((column + 1) * channels / columns).max(column * channels / columns + 1);
        let Some(count) = spectrum.counts.get(range).and_then(|counts| counts.iter().max()) else { continue };
        let top = pos2(axes.plot.left() + column as f32 + 0.5, axes.y(*count as f32));
        painter.line_segment([pos2(top.x, axes.plot.bottom()), top], Stroke::new(1.2, fill));
        line.push(top);
    }
    painter.line(line, Stroke::new(1.5, tokens.accent));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_of_counts_is_logarithmic_and_that_of_energy_has_round_steps() {
        let spectrum = GammaSpectrum {
            live_time_s: 60.0,
            first_kev: 0.0,
            channel_kev: 3.0,
            counts: vec![1, 10, 100, 1_000],
        };
        assert_eq!((total(&spectrum), highest(&spectrum)), (1_111, 1_000));
        let plot = Rect::from_min_size(pos2(10.0, 20.0), vec2(400.0, 300.0));
        let axes = axes_in(plot, &spectrum, highest(&spectrum));
        let [one, ten, hundred] = [1.0, 10.0, 100.0].map(|count| axes.y(count));
        assert!(((one - ten) - (ten - hundred)).abs() < 0.01, "equal steps of a factor of ten");
        assert!((axes.y(1_000.0) - plot.top()).abs() < 0.01 && axes.y(0.0) == plot.bottom());
        assert!((axes.kev(axes.x(7.5)) - 7.5).abs() < 1e-3);
        let wide = Axes { last_kev: 3_000.0, ..axes };
        assert_eq!(energy_step(&wide), 1_000.0);
    }
}
