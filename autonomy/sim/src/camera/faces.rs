//! How plates look: letters, scales and needles, as colours of points of the plate.

use super::fixtures::{CAPITAL_HEIGHT_M, Face, Fixture, LETTER_ADVANCE_M, LINE_STEP_M};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// Linear colours.
const WHITE: [f32; 3] = [0.82, 0.82, 0.8];
const BLACK: [f32; 3] = [0.02, 0.02, 0.02];
const RED: [f32; 3] = [0.6, 0.03, 0.02];
const CASING: [f32; 3] = [0.28, 0.3, 0.33];
const YELLOW: [f32; 3] = [0.78, 0.56, 0.04];

/// Radius of a gauge, metres.
const GAUGE_RADIUS_M: f32 = 0.05;
/// Width of its rim, metres.
const RIM_M: f32 = 0.004;
/// Height of the middle of a gauge above that of its plate, metres.
const GAUGE_UP_M: f32 = 0.035;
/// The scale covers this angle, symmetric about the top, radians.
const SCALE_RAD: f32 = 4.712_389;
/// Parts of the scale with long marks between them.
const LONG_MARKS: usize = 10;
/// Parts of each of these with short marks between them.
const SHORT_MARKS: usize = 5;
/// Height of capital letters on gauges relative to those of labels.
const GAUGE_LETTERS: f32 = 0.45;

/// Size of the rasters of letters, pixels. Their capitals are 17 px high, and their middle is that of the raster.
const RASTER: RasterHeight = RasterHeight::Size32;
const CAPITAL_PX: f32 = 17.0;
const CAPITAL_MIDDLE_PX: f32 = 16.5;

/// A number on the scale of a gauge.
#[derive(Clone, Debug)]
pub(super) struct ScaleNumber {
    words: String,
    /// Its middle, from that of the gauge, metres.
    middle: [f32; 2],
}

/// The numbers on a fixture, which has none unless it is a gauge. They are made once, because each point of a gauge asks for them.
pub(super) fn scale_numbers(fixture: &Fixture) -> Vec<ScaleNumber> {
    let Face::Gauge { min, max, .. } = fixture.face else { return Vec::new() };
    let numbered = (0..=LONG_MARKS).step_by(2).map(|mark| {
        let at = mark as f32 / LONG_MARKS as f32;
        let (sin, cos) = ((at - 0.5) * SCALE_RAD).sin_cos();
        let value = min + (max - min) * f64::from(at);
        ScaleNumber { words: format!("{value:.0}"), middle: [0.031 * sin, 0.031 * cos] }
    });
    numbered.collect()
}

/// Linear colour of a point of a plate, x to the right and y up from its middle, metres. `numbers`: its [`scale_numbers`].
pub(super) fn colour(fixture: &Fixture, numbers: &[ScaleNumber], point: [f32; 2], seconds: f64) -> [f32; 3] {
    match &fixture.face {
        Face::Label(lines) => label(lines, point),
        Face::Gauge { unit, min, max, reading } => {
            let share = ((reading.at(seconds) - min) / (max - min)) as f32;
            gauge(&fixture.tag, unit, numbers, share.clamp(0.0, 1.0), point)
        }
        Face::Warm { .. } => {
            // Cooling ribs, and the tag on a plate of its own.
            if point[1] < -0.05 {
                return mix(WHITE, BLACK, text(&fixture.tag, [point[0], point[1] + 0.075], 1.0));
            }
            let is_rib = (point[0] / 0.014).rem_euclid(1.0) < 0.6;
            if is_rib { CASING } else { CASING.map(|c| c * 0.45) }
        }
    }
}

fn label(lines: &[String], point: [f32; 2]) -> [f32; 3] {
    let middle = 0.5 * (lines.len() as f32 - 1.0);
    let ink = lines.iter().enumerate().map(|(line, words)| {
        let up = (middle - line as f32) * LINE_STEP_M as f32;
        text(words, [point[0], point[1] - up], 1.0)
    });
    mix(YELLOW, BLACK, ink.fold(0.0, f32::max))
}

fn gauge(tag: &str, unit: &str, numbers: &[ScaleNumber], share: f32, point: [f32; 2]) -> [f32; 3] {
    let tag_ink = text(tag, [point[0], point[1] + 0.085], 0.8);
    let offset = [point[0], point[1] - GAUGE_UP_M];
    let radius = offset[0].hypot(offset[1]);
    if radius > GAUGE_RADIUS_M + RIM_M {
        return mix(WHITE, BLACK, tag_ink);
    }
    if radius > GAUGE_RADIUS_M {
        return BLACK;
    }
    // Clockwise from the top, as the needle turns.
    let angle = offset[0].atan2(offset[1]);
    let along = angle / SCALE_RAD + 0.5;
    if is_needle(offset, share) {
        return RED;
    }
    let marks = (LONG_MARKS * SHORT_MARKS) as f32;
    let nearest = (along * marks).round();
    let is_long = (nearest as i64).rem_euclid(SHORT_MARKS as i64) == 0;
    let across = (along - nearest / marks) * SCALE_RAD * radius;
    let (length, width) = if is_long { (0.009, 0.0006) } else { (0.005, 0.0003) };
    let on_scale = (-0.001..=1.001).contains(&(nearest / marks));
    let is_mark = on_scale && across.abs() < width && (0.047 - length..0.047).contains(&radius);
    if is_mark {
        return BLACK;
    }
    let mut ink = text(unit, [offset[0], offset[1] + 0.026], GAUGE_LETTERS);
    for number in numbers {
        let [x, y] = number.middle;
        ink = ink.max(text(&number.words, [offset[0] - x, offset[1] - y], GAUGE_LETTERS));
    }
    mix(WHITE, BLACK, ink)
}

/// Whether a point, relative to the middle of the gauge, is on the needle or its hub.
fn is_needle(offset: [f32; 2], share: f32) -> bool {
    let (sin, cos) = ((share - 0.5) * SCALE_RAD).sin_cos();
    let (along, across) = (offset[0] * sin + offset[1] * cos, offset[0] * cos - offset[1] * sin);
    let width = 0.0018 * (1.0 - along / 0.05).clamp(0.2, 1.0);
    let is_hub = offset[0].hypot(offset[1]) < 0.005;
    is_hub || ((-0.012..0.042).contains(&along) && across.abs() < width)
}

/// How much ink of a centred line of text there is at a point relative to its middle, 0 to 1. `scale`: height of the letters relative to those of labels.
pub(crate) fn text(words: &str, point: [f32; 2], scale: f32) -> f32 {
    let advance = LETTER_ADVANCE_M as f32 * scale;
    let letter_m = CAPITAL_HEIGHT_M as f32 * scale;
    if point[1].abs() > letter_m {
        return 0.0;
    }
    let count = words.chars().count() as f32;
    let column = point[0] / advance + 0.5 * count;
    if !(0.0..count).contains(&column) {
        return 0.0;
    }
    let Some(letter) = words.chars().nth(column as usize) else { return 0.0 };
    let Some(raster) = get_raster(letter, FontWeight::Bold, RASTER) else { return 0.0 };
    // Pixels of the raster, from its top left corner.
    let px_per_m = CAPITAL_PX / letter_m;
    let width = get_raster_width(FontWeight::Bold, RASTER) as f32;
    let x = (column.fract() - 0.5) * advance * px_per_m + 0.5 * width - 0.5;
    let y = CAPITAL_MIDDLE_PX - point[1] * px_per_m - 0.5;
    let ink = |row: f32, column: f32| {
        let is_inside = row >= 0.0 && column >= 0.0;
        let pixel = is_inside.then(|| raster.pixel(column as usize, row as usize)).flatten();
        f32::from(pixel.unwrap_or(0)) / 255.0
    };
    let (left, top) = (x.floor(), y.floor());
    let (right_share, low_share) = (x - left, y - top);
    let upper = ink(top, left) * (1.0 - right_share) + ink(top, left + 1.0) * right_share;
    let lower = ink(top + 1.0, left) * (1.0 - right_share) + ink(top + 1.0, left + 1.0) * right_share;
    upper * (1.0 - low_share) + lower * low_share
}

fn mix(paper: [f32; 3], ink: [f32; 3], share: f32) -> [f32; 3] {
    [0, 1, 2].map(|i| paper[i] + (ink[i] - paper[i]) * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_have_the_stated_height_and_are_centred() {
        let step = 1e-4;
        let inked: Vec<f32> = (-300..=300)
            .map(|row| row as f32 * step)
            .filter(|&y| (-90..=90).any(|column| text("H", [column as f32 * step, y], 1.0) > 0.5))
            .collect();
        let (low, high) = (inked[0], inked[inked.len() - 1]);
        assert!((high - low - CAPITAL_HEIGHT_M as f32).abs() < 0.001, "{low} to {high} m");
        assert!((high + low).abs() < 0.002, "{low} to {high} m");
    }

    #[test]
    fn the_needle_turns_clockwise_with_the_value() {
        // A quarter, half and three quarters of the scale: left, up, right.
        for (share, [x, y]) in [(0.25, [-0.03, 0.0124]), (0.5, [0.0, 0.03]), (0.75, [0.03, 0.0124])] {
            assert!(is_needle([x, y], share), "{share}");
            assert!(!is_needle([-x, -y], share), "{share}");
        }
    }
}
