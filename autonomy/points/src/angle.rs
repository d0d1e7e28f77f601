//! Directions of points, fast and equal on every machine. The mathematics libraries of two systems may differ in the last bit.

use std::f32::consts::{FRAC_PI_2, PI};

/// Angle of the direction (`x`, `y`) from the x axis, radians, -π to π. The error is at most 3e-6 rad: 0.1 mm in a distance of 30 m. NaN if a
/// coordinate is NaN, and for two infinite ones; 0 for two zeros.
///
/// The polynomial is the one of least greatest error among the odd ones of degree 11 (Chebyshev approximation of the arctangent on 0 to 1).
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    const COEFFICIENTS: [f32; 6] =
        [0.999_977_2, -0.332_622_83, 0.193_540_38, -0.116_426_48, 0.052_647_35, -0.011_719_136];
    let (along, across) = (x.abs(), y.abs());
    let (smaller, larger) = if across > along { (along, across) } else { (across, along) };
    let ratio = if larger == 0.0 { 0.0 } else { smaller / larger };
    let square = ratio * ratio;
    let series = COEFFICIENTS.iter().rev().fold(0.0, |sum, coefficient| sum * square + coefficient);
    let within_octant = ratio * series;
    let within_quadrant = if across > along { FRAC_PI_2 - within_octant } else { within_octant };
    let within_half = if x < 0.0 { PI - within_quadrant } else { within_quadrant };
    if y < 0.0 { -within_half } else { within_half }
}

#[cfg(test)]
mod tests {
    use super::atan2;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn angles_are_those_of_the_exact_function(y in -100.0_f32..100.0, x in -100.0_f32..100.0) {
            prop_assert!((f64::from(atan2(y, x)) - f64::from(y).atan2(f64::from(x))).abs() < 3e-6);
        }
    }

    #[test]
    fn axes_and_degenerate_directions() {
        use std::f32::consts::{FRAC_PI_2, PI};
        let known = [
            (0.0, 1.0, 0.0),
            (1.0, 0.0, FRAC_PI_2),
            (0.0, -1.0, PI),
            (-1.0, 0.0, -FRAC_PI_2),
            (0.0, 0.0, 0.0),
        ];
        for (y, x, angle) in known {
            assert_eq!(atan2(y, x), angle, "({x}, {y})");
        }
        assert!(atan2(f32::NAN, 1.0).is_nan() && atan2(1.0, f32::NAN).is_nan());
    }
}
