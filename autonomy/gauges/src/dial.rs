//! What is given once for a gauge in the pictures of a camera.

use std::f64::consts::TAU;
use std::fmt;

/// A dial in the pictures of a camera. Pixels: x to the right, y down, the middle of the first pixel is 0, 0. Angles: radians, clockwise, 0 is up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dial {
    /// Centre of the scale, pixels.
    pub centre_px: [f64; 2],
    /// Where the needle turns in the picture, pixels: the centre, unless the needle is so far before the scale that the camera sees it displaced.
    pub axis_px: [f64; 2],
    /// Radius of the scale, pixels.
    pub radius_px: f64,
    /// Direction of the lower end of the range.
    pub start_rad: f64,
    /// Turn from the lower to the upper end of the range: positive clockwise; a full turn for scales that go on at their end.
    pub sweep_rad: f64,
    /// Values at both ends.
    pub range: [f64; 2],
}

/// Why a dial cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DialError {
    /// A number is not finite.
    NotFinite,
    /// The radius is not positive.
    NoRadius,
    /// The scale has no extent, or more than a turn.
    NoSweep,
    /// Both ends of the range are the same value.
    NoRange,
    /// The mark in the middle of a scale does not fit those at its ends.
    MarksDisagree,
}

impl fmt::Display for DialError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "a number of the dial is not finite",
            Self::NoRadius => "the end of the scale is at the centre of the dial, so that it has no radius",
            Self::NoSweep => "the scale of the dial has no extent, or more than a turn",
            Self::NoRange => "both ends of the range are the same value",
            Self::MarksDisagree => {
                "the tick in the middle of the scale is not half way between its ends; mark the value in the middle of the range"
            }
        })
    }
}

impl std::error::Error for DialError {}

impl Dial {
    /// Direction from one pixel to another.
    pub fn direction_rad(from_px: [f64; 2], to_px: [f64; 2]) -> f64 {
        (to_px[0] - from_px[0]).atan2(from_px[1] - to_px[1])
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// When there is no value for a direction.
    pub fn check(&self) -> Result<(), DialError> {
        let numbers = [self.centre_px, self.axis_px, self.range, [self.radius_px, self.start_rad]];
        if !numbers.iter().flatten().chain([&self.sweep_rad]).all(|number| number.is_finite()) {
            return Err(DialError::NotFinite);
        }
        if self.radius_px <= 0.0 {
            return Err(DialError::NoRadius);
        }
        if self.sweep_rad.abs() < 1e-3 || self.sweep_rad.abs() > TAU + 1e-3 {
            return Err(DialError::NoSweep);
        }
        if self.range[0] == self.range[1] {
            return Err(DialError::NoRange);
        }
        Ok(())
    }

    /// Whether the scale goes on at its end.
    pub fn is_full_turn(&self) -> bool {
        self.sweep_rad.abs() > TAU - 1e-3
    }

    /// The value of a direction of the needle; none if it is farther than `beyond_rad` outside the scale.
    pub(crate) fn value(&self, direction_rad: f64, beyond_rad: f64) -> Option<f64> {
        let turned_rad = ((direction_rad - self.start_rad) * self.sweep_rad.signum()).rem_euclid(TAU);
        let span_rad = self.sweep_rad.abs();
        let share = if self.is_full_turn() || turned_rad <= span_rad {
            turned_rad / span_rad
        } else if turned_rad - span_rad <= beyond_rad {
            1.0
        } else if TAU - turned_rad <= beyond_rad {
            0.0
        } else {
            return None;
        };
        Some(self.range[0] + share * (self.range[1] - self.range[0]))
    }

    /// Value of a turn by one radian.
    pub(crate) fn value_per_rad(&self) -> f64 {
        ((self.range[1] - self.range[0]) / self.sweep_rad).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dial(start_deg: f64, sweep_deg: f64, range: [f64; 2]) -> Dial {
        let (start_rad, sweep_rad) = (start_deg.to_radians(), sweep_deg.to_radians());
        Dial { centre_px: [50.0; 2], axis_px: [50.0; 2], radius_px: 40.0, start_rad, sweep_rad, range }
    }

    fn value(dial: &Dial, direction_deg: f64) -> Option<f64> {
        dial.value(direction_deg.to_radians(), 0.1).map(|value| (value * 1e6).round() / 1e6)
    }

    #[test]
    fn directions_have_values_clockwise_counterclockwise_and_round_the_end() {
        let meter = dial(-1.0, 360.0, [0.0, 10.0]);
        assert_eq!(value(&meter, 35.0), Some(1.0));
        assert_eq!(value(&meter, 341.0), Some(9.5));
        assert_eq!(value(&dial(0.0, -360.0, [0.0, 10.0]), 36.0), Some(9.0));
        let pressure = dial(-135.0, 270.0, [0.0, 6.0]);
        assert_eq!(value(&pressure, 0.0), Some(3.0));
        assert_eq!(value(&pressure, 135.0), Some(6.0));
        assert_eq!(value(&pressure, 138.0), Some(6.0), "on the pin");
        assert_eq!(value(&pressure, -138.0), Some(0.0), "on the pin");
        assert_eq!(value(&pressure, 180.0), None);
        assert_eq!(Dial::direction_rad([5.0, 5.0], [9.0, 5.0]).to_degrees(), 90.0);
    }

    #[test]
    fn dials_without_values_are_refused() {
        assert_eq!(dial(0.0, 360.0, [0.0, 10.0]).check(), Ok(()));
        assert_eq!(dial(0.0, 0.0, [0.0, 10.0]).check(), Err(DialError::NoSweep));
        assert_eq!(dial(0.0, 400.0, [0.0, 10.0]).check(), Err(DialError::NoSweep));
        assert_eq!(dial(0.0, 270.0, [1.0, 1.0]).check(), Err(DialError::NoRange));
        assert_eq!(dial(f64::NAN, 270.0, [0.0, 1.0]).check(), Err(DialError::NotFinite));
        assert_eq!(Dial { radius_px: 0.0, ..dial(0.0, 270.0, [0.0, 1.0]) }.check(), Err(DialError::NoRadius));
    }
}
