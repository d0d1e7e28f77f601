//! The value that a dial shows.

use crate::evidence::Evidence;
use crate::needle::{self, Needle};
use crate::{Dial, DialError, EvidenceKind, GaugeConfig, Picture};
use std::f64::consts::{PI, TAU};

/// What a picture says of a gauge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GaugeReading {
    /// A value.
    Read {
        /// The value, in the unit of the dial's range.
        value: f64,
        /// Standard deviation of the value, in the same unit.
        uncertainty: f64,
        /// Direction of the needle, radians, clockwise, 0 is up.
        direction_rad: f64,
        /// Where the needle ends, pixels.
        tip_px: [f64; 2],
        /// In what the needle differed from the face.
        evidence: EvidenceKind,
        /// How clearly there is one needle, 0 to 1.
        quality: f64,
    },
    /// No value that can be trusted.
    Unsure {
        /// Why.
        reason: UnsureReason,
        /// The value that is likeliest, if there is any.
        likeliest: Option<f64>,
    },
    /// The dial is too small in the picture.
    TooSmall {
        /// Radius of its scale, pixels.
        radius_px: f64,
        /// Least radius that is read, pixels.
        least_px: f64,
    },
}

/// Why a picture gives no value that can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnsureReason {
    /// The dial, or most of it, is outside the picture.
    OutsidePicture,
    /// Nothing that reaches from the axis stands out from the face: a blank, dark or blurred picture.
    NoNeedle,
    /// What was found is short or indistinct: glare, dirt or something before the dial.
    Indistinct,
    /// Two needles in different directions are as likely.
    Ambiguous,
    /// The needle is found, and its direction is not exact enough.
    Inexact,
    /// The needle points outside the scale.
    OutsideScale,
}

/// Reads a gauge from a picture. Linear in the pixels of the picture.
///
/// # Errors
/// When the dial has no values.
pub fn read_gauge(picture: &Picture, dial: &Dial, config: &GaugeConfig) -> Result<GaugeReading, DialError> {
    dial.check()?;
    if dial.radius_px < config.min_radius_px {
        return Ok(GaugeReading::TooSmall { radius_px: dial.radius_px, least_px: config.min_radius_px });
    }
    let unsure = |reason, likeliest| Ok(GaugeReading::Unsure { reason, likeliest });
    if !is_in_picture(picture, dial) {
        return unsure(UnsureReason::OutsidePicture, None);
    }
    let evidence = Evidence::all(picture, dial, config);
    let mut needles: Vec<Needle> =
        evidence.iter().filter_map(|evidence| needle::find(evidence, dial, config)).collect();
    needles.sort_by(|a, b| b.quality.total_cmp(&a.quality));
    let Some(best) = needles.first() else { return unsure(UnsureReason::NoNeedle, None) };
    let value = dial.value(best.direction_rad, config.beyond_end_rad);
    if best.quality < config.min_quality {
        return unsure(UnsureReason::Indistinct, value);
    }
    let is_rival = |other: &Needle| {
        other.quality >= config.rival_share * best.quality
            && angle_rad(other.direction_rad, best.direction_rad) > config.rival_direction_rad
    };
    if needles[1..].iter().any(is_rival) {
        return unsure(UnsureReason::Ambiguous, value);
    }
    let edge_rad = config.edge_error_px / best.length_px;
    let deviation_rad = best.spread_rad.hypot(edge_rad).hypot(config.dial_error_rad);
    if deviation_rad > config.max_uncertainty_share * TAU {
        return unsure(UnsureReason::Inexact, value);
    }
    let Some(value) = value else { return unsure(UnsureReason::OutsideScale, None) };
    let (sine, cosine) = best.direction_rad.sin_cos();
    Ok(GaugeReading::Read {
        value,
        uncertainty: deviation_rad * dial.value_per_rad(),
        direction_rad: best.direction_rad,
        tip_px: [dial.axis_px[0] + sine * best.length_px, dial.axis_px[1] - cosine * best.length_px],
        evidence: best.kind,
        quality: best.quality,
    })
}

/// Whether three quarters of the circle of the scale are in the picture: crops cut edges.
fn is_in_picture(picture: &Picture, dial: &Dial) -> bool {
    let [width, height] = picture.size_px().map(|side| side as f64);
    let inside = (0..16)
        .filter(|step| {
            let (sine, cosine) = (f64::from(*step) / 16.0 * TAU).sin_cos();
            let (x, y) =
                (dial.centre_px[0] + sine * dial.radius_px, dial.centre_px[1] - cosine * dial.radius_px);
            (0.0..width).contains(&x) && (0.0..height).contains(&y)
        })
        .count();
    inside >= 12
}

/// Angle between two directions, radians, at least 0.
fn angle_rad(a: f64, b: f64) -> f64 {
    ((a - b + PI).rem_euclid(TAU) - PI).abs()
}

#[cfg(test)]
#[path = "read_tests.rs"]
mod tests;
