//! Dials that the camera sees from the side: their scale is an ellipse in the picture, and equal steps of it are unequal angles.
//!
//! Four marks say how the scale lies: its centre, both ends, and the tick half way between them. The picture is resampled as if it were seen from the front, and read there.

use crate::{Dial, DialError, GaugeConfig, GaugeReading, Picture, UnsureReason, read_gauge};
use std::f64::consts::TAU;

/// A scale in a picture, by four of its points. Pixels: x to the right, y down, the middle of the first pixel is 0, 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DialMarks {
    /// Centre of the scale, where the needle turns.
    pub centre_px: [f64; 2],
    /// Lower end of the scale.
    pub start_px: [f64; 2],
    /// The tick half way between both ends.
    pub middle_px: [f64; 2],
    /// Upper end of the scale.
    pub end_px: [f64; 2],
    /// Values at both ends.
    pub range: [f64; 2],
}

/// How the dial lies in the picture: an affine map from the frontal dial, in which the middle of the scale is up and the radius is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Slant {
    centre_px: [f64; 2],
    /// Where a step of one radius to the right goes, pixels.
    right_px: [f64; 2],
    /// Where a step of one radius up goes, pixels.
    up_px: [f64; 2],
    /// Angle from the middle of the scale to each end, radians.
    half_sweep_rad: f64,
}

impl DialMarks {
    /// With `u(θ)` the point of the frontal scale at the angle `θ` from its middle, `u(−σ) + u(σ) = 2 cos σ u(0)` and `u(σ) − u(−σ) = 2 sin σ x`. An affine map keeps both.
    fn slant(&self, config: &GaugeConfig) -> Result<Slant, DialError> {
        let numbers = [self.centre_px, self.start_px, self.middle_px, self.end_px, self.range];
        if !numbers.as_flattened().iter().all(|number| number.is_finite()) {
            return Err(DialError::NotFinite);
        }
        if self.range[0] == self.range[1] {
            return Err(DialError::NoRange);
        }
        let from_centre = |px: [f64; 2]| [px[0] - self.centre_px[0], px[1] - self.centre_px[1]];
        let [start, middle, end] = [self.start_px, self.middle_px, self.end_px].map(from_centre);
        let middle_squared = dot(middle, middle);
        if middle_squared <= 0.0 {
            return Err(DialError::NoRadius);
        }
        let sum = [start[0] + end[0], start[1] + end[1]];
        let cosine = dot(sum, middle) / (2.0 * middle_squared);
        let off_px = [sum[0] - 2.0 * cosine * middle[0], sum[1] - 2.0 * cosine * middle[1]];
        let is_between = cosine.abs() < 1.0 - config.min_sweep_margin;
        if !is_between || length(off_px) > config.max_middle_error_share * middle_squared.sqrt() {
            return Err(DialError::MarksDisagree);
        }
        let half_sweep_rad = cosine.acos();
        let sine = 2.0 * half_sweep_rad.sin();
        let right_px = [(end[0] - start[0]) / sine, (end[1] - start[1]) / sine];
        let slant = Slant { centre_px: self.centre_px, right_px, up_px: middle, half_sweep_rad };
        if slant.area_px2().abs() < 1e-9 { Err(DialError::NoRadius) } else { Ok(slant) }
    }
}

impl Slant {
    /// Where a point of the frontal dial is in the picture; its axes are to the right and up, in radii.
    fn to_picture(self, [right, up]: [f64; 2]) -> [f64; 2] {
        let along = |axis: usize| self.centre_px[axis] + right * self.right_px[axis] + up * self.up_px[axis];
        [along(0), along(1)]
    }

    fn area_px2(&self) -> f64 {
        self.right_px[0] * self.up_px[1] - self.right_px[1] * self.up_px[0]
    }

    /// Both half axes of the ellipse, pixels, the longer one first: the singular values of the map.
    fn half_axes_px(&self) -> [f64; 2] {
        let half_sum = 0.5 * (dot(self.right_px, self.right_px) + dot(self.up_px, self.up_px));
        let root = (half_sum * half_sum - self.area_px2().powi(2)).max(0.0).sqrt();
        [(half_sum + root).sqrt(), (half_sum - root).max(0.0).sqrt()]
    }
}

/// Reads a gauge that is seen from the side. Linear in the pixels of the dial.
///
/// # Errors
/// When the marks give no dial.
pub fn read_slanted_gauge(
    picture: &Picture,
    marks: &DialMarks,
    config: &GaugeConfig,
) -> Result<GaugeReading, DialError> {
    let slant = marks.slant(config)?;
    let [radius_px, least_px] = slant.half_axes_px();
    if least_px < config.min_radius_px {
        return Ok(GaugeReading::TooSmall { radius_px: least_px, least_px: config.min_radius_px });
    }
    if !is_in_picture(picture, &slant) {
        return Ok(GaugeReading::Unsure { reason: UnsureReason::OutsidePicture, likeliest: None });
    }
    let (frontal, centre_px) = frontal_picture(picture, &slant, radius_px, config);
    let dial = Dial {
        centre_px: [centre_px; 2],
        axis_px: [centre_px; 2],
        radius_px,
        start_rad: -slant.half_sweep_rad,
        sweep_rad: 2.0 * slant.half_sweep_rad,
        range: marks.range,
    };
    let read = read_gauge(&frontal, &dial, config)?;
    let GaugeReading::Read { value, uncertainty, tip_px, evidence, quality, .. } = read else {
        return Ok(read);
    };
    let tip_px = slant.to_picture([(tip_px[0] - centre_px) / radius_px, (centre_px - tip_px[1]) / radius_px]);
    let direction_rad = Dial::direction_rad(slant.centre_px, tip_px);
    Ok(GaugeReading::Read { value, uncertainty, direction_rad, tip_px, evidence, quality })
}

/// The dial as it looks from the front, and the coordinate of its centre in both directions.
fn frontal_picture(picture: &Picture, slant: &Slant, radius_px: f64, config: &GaugeConfig) -> (Picture, f64) {
    let half = (config.frontal_share * radius_px).ceil();
    let side = 2 * half as usize + 1;
    let pixel = |index: usize| {
        let (column, row) = ((index % side) as f64, (index / side) as f64);
        picture.sample(slant.to_picture([(column - half) / radius_px, (half - row) / radius_px]))
    };
    let pixels = (0..side * side).map(pixel).collect();
    // A side has three pixels at least, and there are as many pixels as that says.
    let frontal = Picture::new([side; 2], pixels).unwrap_or_else(|_| picture.clone());
    (frontal, half)
}

/// Whether three quarters of the scale's ellipse are in the picture: crops cut edges.
fn is_in_picture(picture: &Picture, slant: &Slant) -> bool {
    let [width, height] = picture.size_px().map(|side| side as f64);
    let is_inside = |step: &u32| {
        let (sine, cosine) = (f64::from(*step) / 16.0 * TAU).sin_cos();
        let [x, y] = slant.to_picture([sine, cosine]);
        (0.0..width).contains(&x) && (0.0..height).contains(&y)
    };
    (0..16).filter(is_inside).count() >= 12
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn length(a: [f64; 2]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
#[path = "slanted_tests.rs"]
mod tests;
