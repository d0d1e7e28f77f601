//! How much each pixel of a dial differs from its face.

use crate::{Dial, GaugeConfig, Picture};

/// In what a needle differs from the face of its dial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EvidenceKind {
    /// Its colour, whatever its brightness.
    Colour,
    /// It is darker.
    Darker,
    /// It is lighter.
    Lighter,
}

/// How much each pixel differs from the face of a dial in one respect.
#[derive(Clone, Debug)]
pub(crate) struct Evidence {
    pub(crate) kind: EvidenceKind,
    width: usize,
    height: usize,
    /// Row by row; 0 outside the dial.
    values: Vec<f32>,
    /// From this value on a pixel may be of the needle.
    pub(crate) threshold: f32,
    /// Ratio of the mean strength above the threshold to the noise below it.
    pub(crate) signal: f64,
}

/// Mean of the colour of a pixel, and the shares of red and green.
fn parts(pixel: [u8; 3]) -> [f64; 3] {
    let [red, green, blue] = pixel.map(f64::from);
    let sum = red + green + blue + 1.0;
    [sum, red / sum, green / sum]
}

/// The middle one of values; none of none.
fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

impl Evidence {
    /// The evidence of all kinds in which something on the dial stands out; the face is the median of the dial. Linear in the pixels
    /// (docs/maths/gauges.md, equations 1 to 3).
    pub(crate) fn all(picture: &Picture, dial: &Dial, config: &GaugeConfig) -> Vec<Self> {
        let [width, height] = picture.size_px();
        let range_px = |pixel: usize| {
            let offset =
                [(pixel % width) as f64 - dial.centre_px[0], (pixel / width) as f64 - dial.centre_px[1]];
            offset[0].hypot(offset[1])
        };
        let is_on_dial: Vec<bool> =
            (0..width * height).map(|pixel| range_px(pixel) <= dial.radius_px).collect();
        let face_of = |part: usize| {
            let of_face = picture.pixels().iter().enumerate().filter(|(pixel, _)| {
                is_on_dial[*pixel] && range_px(*pixel) > config.face_inner_share * dial.radius_px
            });
            median(of_face.map(|(_, colour)| parts(*colour)[part]).collect())
        };
        let (Some(face), Some(face_red), Some(face_green)) = (face_of(0), face_of(1), face_of(2)) else {
            return Vec::new();
        };
        let value = |kind: EvidenceKind, colour: [u8; 3]| {
            let [sum, red, green] = parts(colour);
            match kind {
                EvidenceKind::Colour => {
                    (red - face_red).hypot(green - face_green) * (sum / (config.dim_share * face)).min(1.0)
                }
                EvidenceKind::Darker => (1.0 - sum / face).max(0.0),
                EvidenceKind::Lighter => (sum / face - 1.0).max(0.0),
            }
        };
        [EvidenceKind::Colour, EvidenceKind::Darker, EvidenceKind::Lighter]
            .into_iter()
            .filter_map(|kind| {
                let of = |(colour, is_on): (&[u8; 3], &bool)| {
                    if *is_on { value(kind, *colour) as f32 } else { 0.0 }
                };
                let values: Vec<f32> = picture.pixels().iter().zip(&is_on_dial).map(of).collect();
                Self::of_values(kind, [width, height], values, &is_on_dial, config)
            })
            .collect()
    }

    fn of_values(
        kind: EvidenceKind,
        [width, height]: [usize; 2],
        values: Vec<f32>,
        is_on_dial: &[bool],
        config: &GaugeConfig,
    ) -> Option<Self> {
        let on_dial: Vec<f64> = values
            .iter()
            .zip(is_on_dial)
            .filter(|(_, is_on)| **is_on)
            .map(|(value, _)| f64::from(*value))
            .collect();
        let threshold = otsu(&on_dial)?;
        let (above, below): (Vec<f64>, Vec<f64>) = on_dial.iter().partition(|value| **value > threshold);
        if above.is_empty() || above.len() as f64 > config.max_area_share * on_dial.len() as f64 {
            return None;
        }
        let middle = median(below.clone())?;
        let noise = 1.48 * median(below.iter().map(|value| (value - middle).abs()).collect())?;
        let strength = above.iter().sum::<f64>() / above.len() as f64 - middle;
        let least = match kind {
            EvidenceKind::Colour => config.min_colour_contrast,
            EvidenceKind::Darker => config.min_dark_contrast,
            EvidenceKind::Lighter => config.min_light_contrast,
        };
        let signal = strength / (noise + config.noise_floor);
        let is_enough = strength >= least && signal >= config.min_signal;
        is_enough.then_some(Self { kind, width, height, values, threshold: threshold as f32, signal })
    }

    /// Whether the picture shows a needle at a place, pixels: evidence between pixels is interpolated.
    pub(crate) fn is_needle(&self, [x, y]: [f64; 2]) -> bool {
        let (column, row) = (x.floor(), y.floor());
        let is_inside =
            column >= 0.0 && row >= 0.0 && column < self.width as f64 - 1.0 && row < self.height as f64 - 1.0;
        if !is_inside {
            return false;
        }
        let (right, down) = ((x - column) as f32, (y - row) as f32);
        let at = row as usize * self.width + column as usize;
        let upper = self.values[at] * (1.0 - right) + self.values[at + 1] * right;
        let lower = self.values[at + self.width] * (1.0 - right) + self.values[at + self.width + 1] * right;
        upper * (1.0 - down) + lower * down > self.threshold
    }
}

/// The threshold that parts values best into two groups (least variance within them). Source: Otsu, *A Threshold Selection Method from Gray-Level Histograms*, 1979.
fn otsu(values: &[f64]) -> Option<f64> {
    // As many as the grey values of a pixel.
    const BINS: usize = 256;
    let lowest = values.iter().copied().min_by(f64::total_cmp)?;
    let highest = values.iter().copied().max_by(f64::total_cmp)?;
    let width = (highest - lowest) / BINS as f64;
    if width.is_nan() || width <= 0.0 {
        return None;
    }
    let mut counts = [0.0; BINS];
    for value in values {
        counts[(((value - lowest) / width) as usize).min(BINS - 1)] += 1.0;
    }
    let middle = |bin: usize| lowest + (bin as f64 + 0.5) * width;
    let total = values.len() as f64;
    let sum: f64 = (0..BINS).map(|bin| counts[bin] * middle(bin)).sum();
    let (mut count_below, mut sum_below) = (0.0, 0.0);
    let mut best: Option<(f64, f64)> = None;
    for bin in 0..BINS - 1 {
        count_below += counts[bin];
        sum_below += counts[bin] * middle(bin);
        let count_above = total - count_below;
        if count_below > 0.0 && count_above > 0.0 {
            let apart = sum_below / count_below - (sum - sum_below) / count_above;
            let between = count_below * count_above * apart * apart;
            if best.is_none_or(|(most, _)| between > most) {
                best = Some((between, middle(bin)));
            }
        }
    }
    best.map(|(_, threshold)| threshold)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_groups_of_values_are_parted_between_them() {
        let values: Vec<f64> =
            (0..100).map(|at| if at < 80 { 0.1 } else { 0.9 } + f64::from(at % 5) * 0.01).collect();
        let threshold = otsu(&values).expect("two groups");
        assert!((0.13..0.9).contains(&threshold), "{threshold}");
        assert_eq!(otsu(&[0.5; 9]), None);
        assert_eq!(otsu(&[]), None);
    }
}
