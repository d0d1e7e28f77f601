//! A gamma spectrum as a plot (SVG): counts on a logarithmic axis over the energy.

use super::html::Html;
use super::{format, texts};
use site_model::GammaSpectrum;
use std::fmt::Write as _;
use std::io;

/// Points of the curve at most. Chosen: one for less than two CSS pixels of its width.
const MAX_POINTS: usize = 400;
/// Channels of a spectrum that is drawn, at most. Chosen: a hundred times those of common instruments.
const MAX_CHANNELS: usize = 1 << 20;
/// Greatest energy that is drawn, keV. Chosen: far beyond gamma rays of nuclides.
const MAX_KEV: f64 = 1e6;
/// Labels of the energy axis at most.
const MAX_LABELS: u32 = 12;
/// Left edge of the plot in its picture of 720 by 260.
const LEFT: f64 = 58.0;
/// Right edge.
const RIGHT: f64 = 708.0;
/// Upper edge.
const TOP: f64 = 12.0;
/// Lower edge.
const BOTTOM: f64 = 212.0;

/// Whether a spectrum can be drawn.
pub(super) fn is_drawable(spectrum: &GammaSpectrum) -> bool {
    let last_kev = last_kev(spectrum);
    (1..=MAX_CHANNELS).contains(&spectrum.counts.len())
        && spectrum.channel_kev.is_finite()
        && spectrum.channel_kev > 0.0
        && spectrum.first_kev.abs() <= MAX_KEV
        && last_kev <= MAX_KEV
        && last_kev > spectrum.first_kev
}

/// Writes the plot with its axes. `place`: where it was measured.
pub(super) fn write_spectrum(html: &mut Html<'_>, spectrum: &GammaSpectrum, place: &str) -> io::Result<()> {
    let axes = Axes::of(spectrum);
    let curve = curve(spectrum, &axes);
    html.markup("<svg viewBox=\"0 0 720 260\" role=\"img\" aria-label=\"")?;
    html.text(&texts::spectrum_of(place))?;
    html.markup("\">\n")?;
    write_axes(html, &axes)?;
    let points = path(&curve);
    let area =
        format!("M{} L{:.1} {BOTTOM} L{LEFT} {BOTTOM} Z", points, curve.last().map_or(LEFT, |at| at[0]));
    write_path(html, "area", &area)?;
    write_path(html, "curve", &format!("M{points}"))?;
    write_path(html, "axis", &format!("M{LEFT} {TOP} V{BOTTOM} H{RIGHT}"))?;
    html.markup("</svg>\n")
}

/// Events of a whole spectrum.
pub(super) fn total(spectrum: &GammaSpectrum) -> u64 {
    spectrum.counts.iter().map(|count| u64::from(*count)).sum()
}

/// The axes of a plot.
struct Axes {
    first_kev: f64,
    last_kev: f64,
    /// Powers of ten up to the greatest number of events.
    decades: u32,
}

impl Axes {
    fn of(spectrum: &GammaSpectrum) -> Self {
        let highest = spectrum.counts.iter().copied().max().unwrap_or(0).max(1);
        let decades = (f64::from(highest).log10().ceil() as u32).max(1);
        Self { first_kev: spectrum.first_kev, last_kev: last_kev(spectrum), decades }
    }

    fn x(&self, kev: f64) -> f64 {
        let share = (kev - self.first_kev) / (self.last_kev - self.first_kev).max(f64::EPSILON);
        LEFT + share.clamp(0.0, 1.0) * (RIGHT - LEFT)
    }

    /// Half an event lies on the axis, so that one event can be seen.
    fn y(&self, count: f64) -> f64 {
        let share = (count.max(0.5) * 2.0).log10() / (f64::from(self.decades) + 2.0_f64.log10());
        BOTTOM - share.min(1.0) * (BOTTOM - TOP)
    }

    /// Distance of the labels of the energy axis, keV: 1, 2 or 5 times a power of ten.
    fn energy_step(&self) -> f64 {
        let least = ((self.last_kev - self.first_kev) / f64::from(MAX_LABELS)).max(f64::MIN_POSITIVE);
        let power = 10_f64.powf(least.log10().floor());
        let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= least).unwrap_or(10.0);
        factor * power
    }
}

/// Energy at the upper edge of the last channel, keV.
fn last_kev(spectrum: &GammaSpectrum) -> f64 {
    spectrum.first_kev + spectrum.channel_kev * spectrum.counts.len() as f64
}

/// The points of the curve. Of the channels of one point, that with the most events is drawn, so that no line of the spectrum is lost.
fn curve(spectrum: &GammaSpectrum, axes: &Axes) -> Vec<[f64; 2]> {
    let channels = spectrum.counts.len();
    let points = channels.min(MAX_POINTS);
    let point = |number: usize| {
        let range = number * channels / points..(number + 1) * channels / points;
        let middle = 0.5 * (range.start + range.end) as f64;
        let highest = spectrum.counts.get(range)?.iter().max()?;
        Some([axes.x(spectrum.first_kev + middle * spectrum.channel_kev), axes.y(f64::from(*highest))])
    };
    (0..points).filter_map(point).collect()
}

/// `58.8 102.1 L60.4 98.0`: points of a path after its `M`.
fn path(points: &[[f64; 2]]) -> String {
    let mut path = String::new();
    for [x, y] in points {
        // A string takes all that is written to it.
        let _ = write!(path, "{}{x:.1} {y:.1}", if path.is_empty() { "" } else { " L" });
    }
    path
}

fn write_axes(html: &mut Html<'_>, axes: &Axes) -> io::Result<()> {
    for decade in 0..=axes.decades {
        let count = 10_u64.pow(decade);
        let y = axes.y(count as f64);
        write_path(html, "grid", &format!("M{LEFT} {y:.1} H{RIGHT}"))?;
        write_label(html, "end", LEFT - 8.0, y + 4.0, &format::count(count))?;
    }
    let step = axes.energy_step();
    let first = (axes.first_kev / step).ceil() * step;
    let energies = (0..=MAX_LABELS).map(|number| first + f64::from(number) * step);
    let decimals = if step < 1.0 { 2 } else { 0 };
    for kev in energies.take_while(|kev| *kev <= axes.last_kev) {
        let x = axes.x(kev);
        write_path(html, "grid", &format!("M{x:.1} {TOP} V{BOTTOM}"))?;
        write_label(html, "middle", x, BOTTOM + 17.0, &format::decimal(kev, decimals))?;
    }
    write_label(html, "middle", 0.5 * (LEFT + RIGHT), BOTTOM + 38.0, texts::ENERGY_AXIS)?;
    write_label(html, "end", RIGHT - 4.0, TOP + 14.0, texts::COUNT_AXIS)
}

fn write_path(html: &mut Html<'_>, class: &'static str, path: &str) -> io::Result<()> {
    html.markup("<path class=\"")?;
    html.markup(class)?;
    html.markup("\" d=\"")?;
    html.text(path)?;
    html.markup("\"/>\n")
}

/// `anchor`: which end of the text is at the place.
fn write_label(html: &mut Html<'_>, anchor: &'static str, x: f64, y: f64, text: &str) -> io::Result<()> {
    html.markup("<text text-anchor=\"")?;
    html.markup(anchor)?;
    html.markup("\" x=\"")?;
    html.text(&format!("{x:.1}"))?;
    html.markup("\" y=\"")?;
    html.text(&format!("{y:.1}"))?;
    html.markup("\">")?;
    html.text(text)?;
    html.markup("</text>\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spectrum(counts: Vec<u32>) -> GammaSpectrum {
        GammaSpectrum { live_time_s: 60.0, first_kev: 0.0, channel_kev: 3.0, counts }
    }

    #[test]
    fn counts_are_logarithmic_and_energies_have_round_steps() {
        let spectrum = spectrum(vec![1, 10, 100, 1_000]);
        let axes = Axes::of(&spectrum);
        let [one, ten, hundred] = [1.0, 10.0, 100.0].map(|count| axes.y(count));
        assert!(((one - ten) - (ten - hundred)).abs() < 1e-9, "equal steps of a factor of ten");
        assert!((axes.y(1_000.0) - TOP).abs() < 1e-9 && axes.y(0.0) == BOTTOM);
        assert_eq!((axes.x(0.0), axes.x(12.0), axes.energy_step()), (LEFT, RIGHT, 1.0));
        assert_eq!(total(&spectrum), 1_111);
    }

    #[test]
    fn a_long_spectrum_becomes_few_points_and_keeps_its_narrow_lines() {
        let mut counts = vec![2; 8_192];
        counts[5_000] = 900;
        let spectrum = spectrum(counts);
        let axes = Axes::of(&spectrum);
        let points = curve(&spectrum, &axes);
        assert_eq!(points.len(), MAX_POINTS);
        let top = points.iter().min_by(|a, b| a[1].total_cmp(&b[1])).unwrap();
        assert!((top[1] - axes.y(900.0)).abs() < 1e-9);
        assert!((top[0] - axes.x(15_000.0)).abs() < 2.0, "at its energy");
    }

    #[test]
    fn what_has_no_axes_is_not_drawn_and_odd_axes_have_few_labels() {
        let good = spectrum(vec![1, 2]);
        assert!(is_drawable(&good));
        let cases = [(f64::NAN, 3.0), (0.0, 0.0), (0.0, f64::INFINITY), (1e9, 3.0), (1e6, 1e-30)];
        for (first_kev, channel_kev) in cases {
            assert!(
                !is_drawable(&GammaSpectrum { first_kev, channel_kev, ..good.clone() }),
                "{first_kev} {channel_kev}"
            );
        }
        assert!(!is_drawable(&spectrum(Vec::new())));
        for narrow in [1e-9, 1e-3, 400_000.0] {
            let spectrum = GammaSpectrum { channel_kev: narrow, ..good.clone() };
            let mut bytes = Vec::new();
            write_spectrum(&mut Html::new(&mut bytes), &spectrum, "here").unwrap();
            let labels = String::from_utf8(bytes).unwrap().matches("<text").count();
            assert!(labels <= MAX_LABELS as usize + 6, "{labels}");
        }
    }
}
