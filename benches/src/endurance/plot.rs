//! The plot: CPU time per scan at the top, memory in the middle, the pose graph at the bottom.

use crate::measure::Minute;
use anyhow::{Context, Result};
use plotters::prelude::*;
use std::path::Path;

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
