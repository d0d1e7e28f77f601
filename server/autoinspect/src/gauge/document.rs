//! The result of `autoinspect gauge` as JSON.

use super::dial_file::Gauge;
use super::texts;
use gauges::{EvidenceKind, GaugeReading};
use serde::Serialize;

/// What a picture says of a gauge.
#[derive(Debug, Serialize)]
pub struct Document {
    gauge: String,
    #[serde(flatten)]
    reading: Reading,
}

#[derive(Debug, Serialize)]
#[serde(tag = "result", rename_all = "snake_case")]
enum Reading {
    Read {
        value: f64,
        /// Standard deviation of the value.
        uncertainty: f64,
        unit: Option<String>,
        /// Direction of the needle, degrees, clockwise from up.
        angle_deg: f64,
        tip_px: [f64; 2],
        /// In what the needle differs from the face: colour, darker or lighter.
        evidence: &'static str,
        /// How clearly there is one needle, 0 to 1.
        quality: f64,
    },
    Unsure {
        reason: &'static str,
        explanation: &'static str,
        /// The likeliest value, which cannot be trusted.
        likeliest: Option<f64>,
        unit: Option<String>,
    },
    TooSmall {
        /// Radius of the scale and the least one that is read, pixels.
        radius_px: f64,
        least_px: f64,
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
                };
                let angle_deg = direction_rad.to_degrees();
                Reading::Read { value, uncertainty, unit, angle_deg, tip_px, evidence, quality }
            }
            GaugeReading::Unsure { reason, likeliest } => {
                let (reason, explanation) = texts::unsure(reason);
                Reading::Unsure { reason, explanation, likeliest, unit }
            }
            GaugeReading::TooSmall { radius_px, least_px } => Reading::TooSmall { radius_px, least_px },
        };
        Self { gauge: gauge.name.clone(), reading }
    }
}
