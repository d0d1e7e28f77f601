//! Medians and deviations that up to half of the values do not move.

/// Standard deviation of a normal distribution by its median absolute deviation: 1 / Φ⁻¹(3/4).
const DEVIATION_PER_MAD: f64 = 1.482_602_218_505_602;
/// Standard deviation of a normal distribution by its mean absolute deviation: √(π/2).
const DEVIATION_PER_MEAD: f64 = 1.253_314_137_315_500_3;

/// The median; of an even number of values the mean of the two in the middle. None without values. All values are finite. Linear in their number.
pub fn median(values: &[f64]) -> Option<f64> {
    median_in(&mut values.to_vec())
}

/// As [`median`], by changing the order of the values.
pub(crate) fn median_in(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    let is_even = values.len().is_multiple_of(2);
    if values.is_empty() {
        return None;
    }
    let (below, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let upper = *upper;
    let lower = below.iter().copied().max_by(f64::total_cmp).filter(|_| is_even);
    Some(lower.map_or(upper, |lower| lower + 0.5 * (upper - lower)))
}

/// The median of the distances to the median. None without values.
pub fn median_absolute_deviation(values: &[f64]) -> Option<f64> {
    let middle = median(values)?;
    median_in(&mut values.iter().map(|value| (value - middle).abs()).collect::<Vec<_>>())
}

/// A standard deviation that outliers do not move: the median absolute deviation, scaled to that of a normal distribution. Where more than half
/// of the values are equal that is zero, and the mean absolute deviation about the median takes its place.
/// Source: Iglewicz and Hoaglin, How to Detect and Handle Outliers, 1993, chapter 3. None without values.
pub fn robust_deviation(values: &[f64]) -> Option<f64> {
    let mad = median_absolute_deviation(values)?;
    if mad > 0.0 {
        return Some(DEVIATION_PER_MAD * mad);
    }
    let middle = median(values)?;
    let mean = values.iter().map(|value| (value - middle).abs()).sum::<f64>() / values.len() as f64;
    Some(DEVIATION_PER_MEAD * mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_of_few_values() {
        assert_eq!((median(&[]), median(&[3.0]), median(&[4.0, 1.0])), (None, Some(3.0), Some(2.5)));
        assert_eq!(median(&[9.0, 1.0, 5.0, 7.0]), Some(6.0));
        assert_eq!(median_absolute_deviation(&[1.0, 2.0, 3.0, 4.0, 100.0]), Some(1.0));
        assert_eq!(robust_deviation(&[2.0; 5]), Some(0.0));
        let mostly_equal = robust_deviation(&[2.0, 2.0, 2.0, 2.0, 7.0]).unwrap();
        assert!((mostly_equal - DEVIATION_PER_MEAD).abs() < 1e-12, "{mostly_equal}");
    }
}
