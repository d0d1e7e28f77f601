//! How much likelier two sizes are if they are of one thing than if they are of two.

use std::f64::consts::PI;

/// Parameters of [`log_likelihood_ratio`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizeLikelihoodConfig {
    /// Standard deviation of the difference between two measurements of a side that was seen wholly, metres. Source: the boxes of docs/benchmarks/changes.md, of which most sides differ by 0 to 3 cm.
    pub side_error_m: f64,
    /// Share of the level sides of which only a part was seen, so that any length from [`Self::least_part`] on may be measured. Source: three of the 36 ends of the boxes that were moved in the visits of b1 of
    /// docs/benchmarks/changes.md.
    pub partial_share: f64,
    /// The same of heights. Chosen: a LiDAR looks over most things.
    pub partial_height_share: f64,
    /// Least share of a side that is seen. Source: the hall of docs/benchmarks/changes.md, where with two thirds two boxes of a height and a width were taken for one in seed 3, and with a half in seed 12.
    pub least_part: f64,
    /// Range of the sides of loose things, metres: two of them have sides that differ by anything up to that. Chosen: cartons, tools, carts and cabinets.
    pub side_range_m: f64,
}

impl Default for SizeLikelihoodConfig {
    fn default() -> Self {
        Self {
            side_error_m: 0.02,
            partial_share: 0.1,
            partial_height_share: 0.01,
            least_part: 0.8,
            side_range_m: 1.0,
        }
    }
}

/// Logarithm of the ratio of the likelihoods of two sizes (length, width, height, metres), if they are of one thing that stands on the same side in both places, and if they are of two (docs/maths/object-identity.md, equation 6).
pub(crate) fn log_likelihood_ratio(a_m: &[f64; 3], b_m: &[f64; 3], config: &SizeLikelihoodConfig) -> f64 {
    let [length_m, width_m, height_m] = *a_m;
    let level = |other: [f64; 2]| {
        ratio_of_side(length_m, other[0], config.partial_share, config)
            * ratio_of_side(width_m, other[1], config.partial_share, config)
    };
    // If a part of the longer side was seen, it is named as the width.
    let level_ratio = level([b_m[0], b_m[1]]).max(level([b_m[1], b_m[0]]));
    let of_height = ratio_of_side(height_m, b_m[2], config.partial_height_share, config);
    (level_ratio * of_height).ln()
}

/// The ratio of the likelihoods of the lengths of a side, metres.
fn ratio_of_side(a_m: f64, b_m: f64, partial_share: f64, config: &SizeLikelihoodConfig) -> f64 {
    let deviations = (a_m - b_m) / config.side_error_m;
    let whole = (-deviations * deviations / 2.0).exp() / (config.side_error_m * (2.0 * PI).sqrt());
    let (longer_m, shorter_m) = (a_m.max(b_m).max(config.side_error_m), a_m.min(b_m));
    // Anything from a share to the whole.
    let partial = if shorter_m >= config.least_part * longer_m {
        1.0 / ((1.0 - config.least_part) * longer_m)
    } else {
        0.0
    };
    config.side_range_m * ((1.0 - partial_share) * whole + partial_share * partial)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratio(a: [f64; 3], b: [f64; 3]) -> f64 {
        log_likelihood_ratio(&a, &b, &SizeLikelihoodConfig::default())
    }

    #[test]
    fn one_size_tells_most_and_a_part_of_a_side_tells_less() {
        let whole = ratio([0.72, 0.5, 1.25], [0.71, 0.49, 1.26]);
        let partial = ratio([0.72, 0.5, 1.25], [0.59, 0.48, 1.26]);
        let other = ratio([0.72, 0.5, 1.25], [0.67, 0.55, 1.2]);
        assert!(whole > partial && partial > other && other > 0.0, "{whole} {partial} {other}");
        assert!(ratio([0.72, 0.5, 1.25], [0.3, 0.3, 0.6]) < -4.0);
        // A part of the longer side, which is shorter than the other one.
        let turned = ratio([0.7, 0.6, 1.25], [0.6, 0.57, 1.25]);
        assert!(
            turned > 2.0 && (turned - ratio([0.6, 0.57, 1.25], [0.7, 0.6, 1.25])).abs() < 1e-9,
            "{turned}"
        );
    }
}
