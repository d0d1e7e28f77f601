//! The plot: cost per scan above, memory in the middle, the graph below.

use anyhow::{Context, Result};
use plotters::prelude::*;
use std::path::Path;

/// One minute of the walk.
#[derive(Clone, Copy, Debug)]
pub struct Minute {
    /// Counts from 1.
    pub number: u32,
    /// Rounds walked to their end.
    pub rounds: u32,
    /// How far the estimate at the minute's end is from the truth, millimetres.
    pub off_mm: f64,
    /// Visits to known ground that were confirmed in this minute.
    pub ties: usize,
    /// Scans that gave an estimate.
    pub scans: usize,
    /// Mean CPU time of a scan, milliseconds.
    pub mean_ms: f64,
    /// Its 99th percentile, milliseconds.
    pub p99_ms: f64,
    /// Resident memory of the process at the minute's end, megabytes.
    pub resident_mb: f64,
    /// Keyframes so far.
    pub keyframes: u64,
    /// CPU time of steps that made one, median and greatest, milliseconds.
    pub keyframe_ms: (f64, f64),
    /// The same of steps that took the result of a loop's verification in.
    pub loop_ms: (f64, f64),
    /// Loops closed so far.
    pub loops: usize,
}

/// One line of a chart.
struct Curve {
    label: &'static str,
    colour: RGBColor,
    value: fn(&Minute) -> f64,
}

const TIME: [Curve; 2] = [
    Curve { label: "mean", colour: RGBColor(31, 111, 178), value: |minute| minute.mean_ms },
    Curve { label: "99th percentile", colour: RGBColor(200, 120, 30), value: |minute| minute.p99_ms },
];
const MEMORY: [Curve; 1] =
    [Curve { label: "resident", colour: RGBColor(60, 130, 80), value: |minute| minute.resident_mb }];

const GRAPH: [Curve; 2] = [
    Curve { label: "keyframes", colour: RGBColor(31, 111, 178), value: |minute| minute.keyframes as f64 },
    Curve { label: "loops", colour: RGBColor(150, 70, 160), value: |minute| minute.loops as f64 },
];

/// Draws all charts into an SVG file.
pub fn draw(path: &Path, title: &str, minutes: &[Minute]) -> Result<()> {
    let root = SVGBackend::new(path, (760, 680)).into_drawing_area();
    root.fill(&WHITE)?;
    let (above, rest) = root.split_vertically(240);
    let (middle, below) = rest.split_vertically(220);
    chart(&above, &format!("{title}: CPU time per scan, ms"), minutes, &TIME)?;
    chart(&middle, "Memory of the process, MB", minutes, &MEMORY)?;
    chart(&below, "Pose graph", minutes, &GRAPH)?;
    root.present().with_context(|| format!("{} cannot be written", path.display()))
}

fn chart(
    area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    caption: &str,
    minutes: &[Minute],
    curves: &[Curve],
) -> Result<()> {
    let top = minutes.iter().flat_map(|m| curves.iter().map(|c| (c.value)(m))).fold(0.0, f64::max);
    let last = minutes.iter().map(|m| m.number).max().unwrap_or(1);
    let mut chart = ChartBuilder::on(area)
        .caption(caption, ("sans-serif", 15))
        .margin(10)
        .x_label_area_size(28)
        .y_label_area_size(46)
        .build_cartesian_2d(0.0..f64::from(last), 0.0..top * 1.15)?;
    chart.configure_mesh().light_line_style(WHITE).x_desc("minutes").draw()?;
    for curve in curves {
        let line = minutes.iter().map(|m| (f64::from(m.number), (curve.value)(m)));
        let colour = curve.colour;
        chart
            .draw_series(LineSeries::new(line, colour.stroke_width(2)))?
            .label(curve.label)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerRight)
        .border_style(BLACK.mix(0.2))
        .draw()?;
    Ok(())
}
