//! A gauge in the pictures of an inspection point: what people describe once, and what becomes of it in each later picture.
//!
//! Pixels count from the top left, x to the right and y down; the middle of the first pixel is 0, 0.

use crate::{Parameter, Parameters};
use serde::{Deserialize, Serialize};
use std::fmt;
use vocab::BlobHash;

/// Parameter that describes the gauge of a photo, a [`GaugeDial`]. The platform sets it from the inspection point, and reads the needle once the picture is taken.
pub const GAUGE_PARAMETER: &str = "gauge";
/// Name of the reading of a needle in an [`crate::ActionReport`].
pub const GAUGE_READING: &str = "gauge";

/// Shortest distance of an end of the scale from its centre, pixels. Chosen: nearer ones are a slip of the pointer, and no needle of this size is read.
const MIN_RADIUS_PX: f64 = 4.0;

/// Distance of the middle of the scale from the line on which its ends let expect it, as a share of the radius: `max_middle_error_share` of crate `gauges`.
const MAX_MIDDLE_ERROR_SHARE: f64 = 0.2;

/// The dial of a gauge, described in one picture. Later pictures are aligned with that one first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GaugeDial {
    /// The picture in which it was described.
    pub picture: BlobHash,
    /// Columns and rows of that picture.
    pub size_px: [u32; 2],
    /// Centre of the scale.
    pub centre_px: [f64; 2],
    /// Lower end of the scale.
    pub start_px: [f64; 2],
    /// The tick half way between both ends: with it, a dial that is seen from the side is read as if from the front. None: the dial is a circle in the picture.
    #[serde(default)]
    pub middle_px: Option<[f64; 2]>,
    /// Upper end of the scale; none: the scale is a full turn and ends where it begins.
    #[serde(default)]
    pub end_px: Option<[f64; 2]>,
    /// From the lower to the upper end. It goes by the middle, if that is known.
    #[serde(default)]
    pub direction: DialDirection,
    /// Values at the lower and the upper end.
    pub range: [f64; 2],
    /// Unit of both, such as `bar`.
    pub unit: String,
}

/// In which direction the values of a dial grow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DialDirection {
    /// As on nearly all gauges.
    #[default]
    Clockwise,
    /// The other way round.
    Counterclockwise,
}

/// Why a description gives no values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GaugeDialError {
    /// A mark is outside the picture.
    OutsidePicture,
    /// An end of the scale is at its centre.
    NoRadius,
    /// The middle of the scale is not half way between its ends.
    MiddleElsewhere,
    /// Both ends of the range are the same value.
    NoRange,
    /// The unit is missing.
    NoUnit,
}

/// What a picture says of the gauge of its inspection point. The value itself is a reading of the report, named [`GAUGE_READING`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GaugeReport {
    /// Why the needle gives no value, one sentence; none if it was read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
    /// Where the needle turns and where it ends, pixels of the picture; none if it was not read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub needle_px: Option<[[f64; 2]; 2]>,
    /// Error of the alignment with the picture in which the gauge was described, pixels: at most this in 95 % of the pictures; none without an alignment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alignment_residual_px: Option<f64>,
}

impl fmt::Display for GaugeDialError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OutsidePicture => "marks inside the picture",
            Self::NoRadius => "ends of the scale away from its centre",
            Self::MiddleElsewhere => "a mark at the value in the middle of the scale",
            Self::NoRange => "two different values at the ends of the scale",
            Self::NoUnit => "a unit",
        })
    }
}

impl std::error::Error for GaugeDialError {}

impl GaugeDial {
    /// Checks that directions of a needle have values.
    ///
    /// # Errors
    /// What is missing. Its text says what the description must have.
    pub fn check(&self) -> Result<(), GaugeDialError> {
        let marks = [Some(self.centre_px), Some(self.start_px), self.middle_px, self.end_px];
        let is_inside = |mark: &[f64; 2]| {
            mark.iter().zip(self.size_px).all(|(px, size)| (-0.5..=f64::from(size) - 0.5).contains(px))
        };
        if !marks.iter().flatten().all(is_inside) {
            return Err(GaugeDialError::OutsidePicture);
        }
        let radius_px = |end: &[f64; 2]| (end[0] - self.centre_px[0]).hypot(end[1] - self.centre_px[1]);
        if marks[1..].iter().flatten().any(|end| radius_px(end) < MIN_RADIUS_PX) {
            return Err(GaugeDialError::NoRadius);
        }
        if self.middle_px.zip(self.end_px).is_some_and(|(middle, end)| !self.is_half_way(middle, end)) {
            return Err(GaugeDialError::MiddleElsewhere);
        }
        if !self.range.iter().all(|value| value.is_finite()) || self.range[0] == self.range[1] {
            return Err(GaugeDialError::NoRange);
        }
        if self.unit.trim().is_empty() {
            return Err(GaugeDialError::NoUnit);
        }
        Ok(())
    }

    /// Whether a mark is on the line on which the middle of the scale is, however the dial is seen: the sum of both ends, from the centre, points along it.
    fn is_half_way(&self, middle_px: [f64; 2], end_px: [f64; 2]) -> bool {
        let from_centre = |px: [f64; 2]| [px[0] - self.centre_px[0], px[1] - self.centre_px[1]];
        let [start, middle, end] = [self.start_px, middle_px, end_px].map(from_centre);
        let sum = [start[0] + end[0], start[1] + end[1]];
        let across = (sum[0] * middle[1] - sum[1] * middle[0]) / middle[0].hypot(middle[1]);
        across.abs() <= MAX_MIDDLE_ERROR_SHARE * middle[0].hypot(middle[1])
    }

    /// All its numbers.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f64> {
        let ends = self.end_px.into_iter().chain(self.middle_px).flatten();
        [self.centre_px, self.start_px, self.range].into_iter().flatten().chain(ends)
    }

    /// It as a parameter of an action, in the form of its JSON.
    pub fn parameter(&self) -> Parameter {
        let pair = |pair: [f64; 2]| Parameter::List(pair.map(Parameter::Number).into());
        let size = self.size_px.map(|side| Parameter::Integer(side.into()));
        let direction = match self.direction {
            DialDirection::Clockwise => "clockwise",
            DialDirection::Counterclockwise => "counterclockwise",
        };
        let mut fields = Parameters::from(
            [
                ("picture", Parameter::Text(self.picture.to_string())),
                ("size_px", Parameter::List(size.into())),
                ("centre_px", pair(self.centre_px)),
                ("start_px", pair(self.start_px)),
                ("direction", Parameter::Text(direction.to_owned())),
                ("range", pair(self.range)),
                ("unit", Parameter::Text(self.unit.clone())),
            ]
            .map(|(name, value)| (name.to_owned(), value)),
        );
        for (name, mark) in [("middle_px", self.middle_px), ("end_px", self.end_px)] {
            if let Some(px) = mark {
                fields.insert(name.to_owned(), pair(px));
            }
        }
        Parameter::Map(fields)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dial() -> GaugeDial {
        GaugeDial {
            picture: BlobHash([7; 32]),
            size_px: [640, 480],
            centre_px: [320.0, 240.0],
            start_px: [270.0, 290.0],
            middle_px: Some([320.0, 170.0]),
            end_px: Some([370.5, 290.0]),
            direction: DialDirection::Clockwise,
            range: [0.0, 6.0],
            unit: "bar".to_owned(),
        }
    }

    #[test]
    fn the_parameter_of_an_action_reads_back_as_the_dial() {
        let backwards = GaugeDial { end_px: None, direction: DialDirection::Counterclockwise, ..dial() };
        for dial in [dial(), backwards] {
            let json = serde_json::to_string(&dial.parameter()).expect("plain data");
            assert_eq!(serde_json::from_str::<GaugeDial>(&json).expect("reads"), dial);
        }
    }

    #[test]
    fn a_dial_without_values_says_what_it_must_have() {
        assert_eq!(dial().check(), Ok(()));
        let check = |change: fn(&mut GaugeDial)| {
            let mut changed = dial();
            change(&mut changed);
            changed.check().expect_err("has no values")
        };
        assert_eq!(check(|dial| dial.start_px[0] = 640.0), GaugeDialError::OutsidePicture);
        assert_eq!(check(|dial| dial.centre_px[0] = f64::NAN), GaugeDialError::OutsidePicture);
        assert_eq!(check(|dial| dial.end_px = Some([321.0, 241.0])), GaugeDialError::NoRadius);
        assert_eq!(check(|dial| dial.middle_px = Some([370.0, 240.0])), GaugeDialError::MiddleElsewhere);
        assert_eq!(check(|dial| dial.range[1] = 0.0), GaugeDialError::NoRange);
        assert_eq!(check(|dial| dial.unit = " ".to_owned()), GaugeDialError::NoUnit);
    }
}
