//! Instants and durations as whole nanoseconds, so that arithmetic is exact and equal everywhere.

use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

const NANOS_PER_SEC: i64 = 1_000_000_000;

/// An instant: nanoseconds since the Unix epoch on the robot's clock (years 1678 to 2262).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Stamp(i64);

/// A signed duration in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Span(i64);

impl Stamp {
    /// The Unix epoch.
    pub const EPOCH: Self = Self(0);

    /// From nanoseconds since the Unix epoch.
    pub const fn from_nanos(nanos: i64) -> Self {
        Self(nanos)
    }

    /// From seconds since the Unix epoch; saturates, and NaN becomes the epoch. Exact to about 0.2 µs today.
    pub fn from_secs_f64(secs: f64) -> Self {
        Self(Span::from_secs_f64(secs).0)
    }

    /// From the seconds and nanoseconds of a ROS time.
    pub const fn from_parts(secs: i64, nanos: u32) -> Self {
        Self(secs.saturating_mul(NANOS_PER_SEC).saturating_add(nanos as i64))
    }

    /// Nanoseconds since the Unix epoch.
    pub const fn nanos(self) -> i64 {
        self.0
    }

    /// Seconds since the Unix epoch, rounded to the nearest f64.
    pub fn secs_f64(self) -> f64 {
        Span(self.0).secs_f64()
    }

    /// Whole seconds (rounded down) and the nanoseconds after them, as in a ROS time.
    pub const fn parts(self) -> (i64, u32) {
        (self.0.div_euclid(NANOS_PER_SEC), self.0.rem_euclid(NANOS_PER_SEC) as u32)
    }
}

impl Span {
    /// The empty duration.
    pub const ZERO: Self = Self(0);
    /// A minute.
    pub const MINUTE: Self = Self(60 * NANOS_PER_SEC);

    /// From nanoseconds.
    pub const fn from_nanos(nanos: i64) -> Self {
        Self(nanos)
    }

    /// From milliseconds.
    pub const fn from_millis(millis: i64) -> Self {
        Self(millis.saturating_mul(1_000_000))
    }

    /// From seconds; saturates, and NaN becomes zero.
    pub fn from_secs_f64(secs: f64) -> Self {
        // Splitting keeps the fraction exact for large values; `as` saturates and maps NaN to 0.
        let whole = secs.trunc();
        let frac = ((secs - whole) * NANOS_PER_SEC as f64).round() as i64;
        Self((whole as i64).saturating_mul(NANOS_PER_SEC).saturating_add(frac))
    }

    /// Nanoseconds.
    pub const fn nanos(self) -> i64 {
        self.0
    }

    /// Seconds, rounded to the nearest f64.
    pub fn secs_f64(self) -> f64 {
        (self.0 / NANOS_PER_SEC) as f64 + (self.0 % NANOS_PER_SEC) as f64 * 1e-9
    }
}

impl Add<Span> for Stamp {
    type Output = Self;
    fn add(self, rhs: Span) -> Self {
        Self(self.0.saturating_add(rhs.0))
    }
}

impl Sub<Span> for Stamp {
    type Output = Self;
    fn sub(self, rhs: Span) -> Self {
        Self(self.0.saturating_sub(rhs.0))
    }
}

impl Sub for Stamp {
    type Output = Span;
    fn sub(self, rhs: Self) -> Span {
        Span(self.0.saturating_sub(rhs.0))
    }
}

impl AddAssign<Span> for Stamp {
    fn add_assign(&mut self, rhs: Span) {
        *self = *self + rhs;
    }
}

impl SubAssign<Span> for Stamp {
    fn sub_assign(&mut self, rhs: Span) {
        *self = *self - rhs;
    }
}

impl Add for Span {
    type Output = Self;
    fn add(self, rhs: Self) -> Self {
        Self(self.0.saturating_add(rhs.0))
    }
}

impl Sub for Span {
    type Output = Self;
    fn sub(self, rhs: Self) -> Self {
        Self(self.0.saturating_sub(rhs.0))
    }
}

impl Neg for Span {
    type Output = Self;
    fn neg(self) -> Self {
        Self(self.0.saturating_neg())
    }
}

impl Mul<i64> for Span {
    type Output = Self;
    fn mul(self, rhs: i64) -> Self {
        Self(self.0.saturating_mul(rhs))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_and_seconds_agree_before_and_after_the_epoch() {
        for nanos in [-1_500_000_000, -1, 0, 1, 1_700_000_000_123_456_789] {
            let stamp = Stamp::from_nanos(nanos);
            let (secs, rest) = stamp.parts();
            assert_eq!(Stamp::from_parts(secs, rest), stamp);
            assert!((stamp.secs_f64() - nanos as f64 * 1e-9).abs() < 1e-6);
        }
    }

    #[test]
    fn seconds_out_of_range_saturate_instead_of_wrapping() {
        assert_eq!(Span::from_secs_f64(f64::NAN), Span::ZERO);
        assert_eq!(Span::from_secs_f64(f64::INFINITY).nanos(), i64::MAX);
        assert_eq!(Stamp::from_nanos(i64::MAX) + Span::from_millis(1), Stamp::from_nanos(i64::MAX));
    }
}
