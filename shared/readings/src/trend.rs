//! A straight line through readings, of which up to about 29 % may be wrong: the median of the slopes between pairs (Theil 1950, Sen 1968).

use crate::robust::median_in;

/// A straight line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Trend {
    /// Slope, units of the reading a second.
    pub per_s: f64,
    /// A time on the line, seconds, on the clock of the samples.
    pub at_s: f64,
    /// Value of the line at that time.
    pub value: f64,
    /// Standard error of the slope for errors that are normal and independent. Errors that last for long make the true one greater.
    pub standard_error_per_s: f64,
}

impl Trend {
    /// Value of the line at a time, seconds, on the clock of the samples.
    pub fn at(&self, at_s: f64) -> f64 {
        self.value + self.per_s * (at_s - self.at_s)
    }
}

/// The median of the slopes between pairs of points `[time, value]`; none without two points of different times. All numbers are finite.
///
/// Up to `max_pairs` pairs all of them are taken. With more, each point is paired with the points at the same distances in the list, so that each
/// takes part equally often, and the share of wrong points that the slope stands stays the same. `n` points then cost `max_pairs` slopes, or `n` if
/// that is more: time and memory grow with the square of `n` up to `max_pairs`, and linearly after it.
pub fn theil_sen_slope(points: &[[f64; 2]], max_pairs: usize) -> Option<f64> {
    let count = points.len();
    let mut slopes = Vec::new();
    let mut add = |a: usize, b: usize| {
        let ([a_s, a], [b_s, b]) = (points[a], points[b]);
        if a_s != b_s {
            slopes.push((b - a) / (b_s - a_s));
        }
    };
    if count.saturating_mul(count.saturating_sub(1)) / 2 <= max_pairs {
        for a in 0..count {
            for b in a + 1..count {
                add(a, b);
            }
        }
    } else {
        // Distances from 1 to (count - 1) / 2 around a ring of the points give each pair once.
        let longest = (count - 1) / 2;
        let distances = (max_pairs / count).clamp(1, longest.max(1));
        for index in 0..distances {
            let distance = 1 + (2 * index + 1) * longest.saturating_sub(1) / (2 * distances);
            for a in 0..count {
                add(a, (a + distance) % count);
            }
        }
    }
    median_in(&mut slopes)
}

/// The line with this slope that leaves as many points above as below. `deviation`: that of the points around it.
pub(crate) fn line_through(points: &[[f64; 2]], per_s: f64, deviation: f64) -> Option<Trend> {
    let at_s = median_in(&mut points.iter().map(|[at_s, _]| *at_s).collect::<Vec<_>>())?;
    let levels = points.iter().map(|[time_s, value]| value - per_s * (time_s - at_s));
    let value = median_in(&mut levels.collect::<Vec<_>>())?;
    let mean_s = points.iter().map(|[time_s, _]| time_s - at_s).sum::<f64>() / points.len() as f64;
    let squares = points.iter().map(|[time_s, _]| (time_s - at_s - mean_s).powi(2)).sum::<f64>();
    // That of least squares, by the efficiency of the method for normal errors, 3/π (Sen 1968).
    let standard_error_per_s =
        deviation / squares.sqrt().max(f64::MIN_POSITIVE) * (std::f64::consts::PI / 3.0).sqrt();
    Some(Trend { per_s, at_s, value, standard_error_per_s })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_although_a_quarter_of_the_points_is_wrong_with_all_and_with_few_pairs() {
        let wrong = |index: usize| if index % 4 == 1 { 1e6 } else { 0.0 };
        let points: Vec<[f64; 2]> =
            (0..400).map(|index| [index as f64, 3.0 + 0.25 * index as f64 + wrong(index)]).collect();
        for max_pairs in [usize::MAX, 20_000, 4_000] {
            let slope = theil_sen_slope(&points, max_pairs).unwrap();
            assert!((slope - 0.25).abs() < 1e-9, "{max_pairs} pairs: {slope}");
        }
    }

    #[test]
    fn there_is_no_slope_without_two_times() {
        assert_eq!(theil_sen_slope(&[], 100), None);
        assert_eq!(theil_sen_slope(&[[1.0, 2.0], [1.0, 3.0]], 100), None);
        assert_eq!(
            theil_sen_slope(&[[1.0, 2.0], [3.0, 3.0]], 0),
            Some(0.5),
            "at least as many pairs as points"
        );
    }

    #[test]
    fn the_standard_error_is_that_of_repeated_measurements() {
        // The sum of three uniform numbers is nearly normal; a counter stands for chance.
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
        };
        let slopes: Vec<f64> = (0..400)
            .map(|_| {
                let points: Vec<[f64; 2]> =
                    (0..60).map(|at| [f64::from(at), 2.0 * (uniform() + uniform() + uniform())]).collect();
                theil_sen_slope(&points, 10_000).unwrap()
            })
            .collect();
        let spread = (slopes.iter().map(|slope| slope * slope).sum::<f64>() / slopes.len() as f64).sqrt();
        let times: Vec<[f64; 2]> = (0..60).map(|at| [f64::from(at), 0.0]).collect();
        // Three uniform numbers of width 1 have a standard deviation of 1/2.
        let expected = line_through(&times, 0.0, 1.0).unwrap().standard_error_per_s;
        assert!((spread / expected - 1.0).abs() < 0.15, "{spread} {expected}");
    }
}
