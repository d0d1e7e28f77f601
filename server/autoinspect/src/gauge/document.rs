//! The result of `autoinspect gauge` as JSON.

use super::texts;
use gauge_file::Gauge;
use gauges::{EvidenceKind, GaugeReading};
use serde::{Deserialize, Serialize};
use std::fmt::Display;

/// What a picture says of a gauge.
#[derive(Debug, Serialize, Deserialize)]
pub struct Document {
    gauge: String,
    #[serde(flatten)]
    pub reading: Reading,
    /// Error of the alignment with the picture in which the gauge was described, pixels: at most this in 95 % of the pictures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alignment_residual_px: Option<f64>,
}

/// What was found.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "result", rename_all = "snake_case")]
pub enum Reading {
    Read {
        value: f64,
        /// Standard deviation of the value.
        uncertainty: f64,
        unit: Option<String>,
        /// Direction of the needle, degrees, clockwise from up.
        angle_deg: f64,
        /// Where it turns and where it ends.
        axis_px: [f64; 2],
        tip_px: [f64; 2],
        /// In what the needle differs from the face: colour, darker or lighter.
        evidence: String,
        /// How clearly there is one needle, 0 to 1.
        quality: f64,
    },
    Unsure {
        reason: String,
        explanation: String,
        /// The likeliest value, which cannot be trusted.
        likeliest: Option<f64>,
        unit: Option<String>,
    },
    TooSmall {
        /// Radius of the scale and the least one that is read, pixels.
        radius_px: f64,
        least_px: f64,
    },
    NotAligned {
        explanation: String,
    },
}

impl Document {
    /// The document of a reading.
    pub fn new(gauge: &Gauge, reading: &GaugeReading) -> Self {
        let unit = gauge.unit.clone();
        let reading = match *reading {
            GaugeReading::Read { value, uncertainty, direction_rad, tip_px, evidence, quality } => {
                let evidence = match evidence {
                    EvidenceKind::Colour => "colour",
                    EvidenceKind::Darker => "darker",
                    EvidenceKind::Lighter => "lighter",
                }
                .to_owned();
                let angle_deg = direction_rad.to_degrees();
                let axis_px = gauge.dial.axis_px;
                Reading::Read { value, uncertainty, unit, angle_deg, axis_px, tip_px, evidence, quality }
            }
            GaugeReading::Unsure { reason, likeliest } => {
                let (reason, explanation) = texts::unsure(reason);
                let (reason, explanation) = (reason.to_owned(), explanation.to_owned());
                Reading::Unsure { reason, explanation, likeliest, unit }
            }
            GaugeReading::TooSmall { radius_px, least_px } => Reading::TooSmall { radius_px, least_px },
        };
        Self { gauge: gauge.name.clone(), reading, alignment_residual_px: None }
    }

    /// The document of a picture that could not be aligned with that in which the gauge was described.
    pub fn not_aligned(gauge: &Gauge, reason: &dyn Display) -> Self {
        let reading = Reading::NotAligned { explanation: reason.to_string() };
        Self { gauge: gauge.name.clone(), reading, alignment_residual_px: None }
    }

    /// It with the error of the alignment.
    pub fn with_residual(self, residual_px: f64) -> Self {
        Self { alignment_residual_px: Some(residual_px), ..self }
    }
}
