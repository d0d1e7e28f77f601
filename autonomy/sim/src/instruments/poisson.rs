//! Random counts after the law of Poisson.

use geometry::Rng;

/// Mean up to which a count is drawn by Knuth's multiplication: `exp(-mean)` stays far from the smallest number.
const MAX_MULTIPLICATION_MEAN: f64 = 30.0;
/// Mean from which the normal law is used. Its skewness is below 0.001 there, and counts of this size are never looked at one by one.
const MIN_NORMAL_MEAN: f64 = 1e6;

/// A count with this mean. A sum of two counts with half the mean has the same law, so large means are halved.
pub(super) fn draw(mean: f64, rng: &mut Rng) -> u64 {
    if !mean.is_finite() || mean <= 0.0 {
        return 0;
    }
    if mean >= MIN_NORMAL_MEAN {
        return (mean + mean.sqrt() * rng.normal()).round().max(0.0) as u64;
    }
    if mean > MAX_MULTIPLICATION_MEAN {
        return draw(0.5 * mean, rng) + draw(0.5 * mean, rng);
    }
    let limit = (-mean).exp();
    let mut product = rng.uniform();
    let mut count = 0;
    while product > limit {
        product *= rng.uniform();
        count += 1;
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    #[test]
    fn mean_and_variance_are_equal_and_the_probability_of_nothing_is_right() {
        for mean in [0.05, 0.7, 4.0, 29.0, 75.0, 1200.0] {
            let mut rng = RngTree::new(7).child(&mean.to_string()).rng();
            let draws: Vec<f64> = (0..20_000).map(|_| draw(mean, &mut rng) as f64).collect();
            let count = draws.len() as f64;
            let average = draws.iter().sum::<f64>() / count;
            let variance = draws.iter().map(|d| (d - average).powi(2)).sum::<f64>() / (count - 1.0);
            // Four standard deviations of both estimates.
            assert!((average - mean).abs() < 4.0 * (mean / count).sqrt(), "{average} for {mean}");
            let of_variance = ((mean + 2.0 * mean * mean) / count).sqrt();
            assert!((variance - mean).abs() < 4.0 * of_variance, "{variance} for {mean}");
            let none = draws.iter().filter(|d| **d == 0.0).count() as f64 / count;
            let expected = (-mean).exp();
            assert!(
                (none - expected).abs() < 4.0 * (expected / count).sqrt() + 1e-9,
                "{none} for {expected}"
            );
        }
        let mut rng = RngTree::new(1).rng();
        assert_eq!([0.0, -1.0, f64::NAN, f64::INFINITY].map(|mean| draw(mean, &mut rng)), [0; 4]);
    }
}
