//! What a reading has in addition at each hour of the day, such as warmth in the afternoon.

use crate::robust::median_in;
use std::collections::BTreeSet;

/// Hours of a day.
pub(crate) const HOURS: usize = 24;

/// The median residual of each hour of the day; none for an hour with readings on fewer than `min_days` days. `residuals`: day, hour, value.
pub(crate) fn offsets_by_hour(residuals: &[(i64, u8, f64)], min_days: usize) -> [Option<f64>; HOURS] {
    std::array::from_fn(|hour| {
        let of_hour = || residuals.iter().filter(|(_, at, _)| usize::from(*at) == hour);
        let days: BTreeSet<i64> = of_hour().map(|(day, ..)| *day).collect();
        if days.len() < min_days {
            return None;
        }
        median_in(&mut of_hour().map(|(.., value)| *value).collect::<Vec<_>>())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_hour_with_too_few_days_has_no_offset() {
        let mut residuals: Vec<(i64, u8, f64)> = (0..7).map(|day| (day, 11, 2.0)).collect();
        residuals.extend((0..20).map(|_| (3, 15, 9.0)));
        let offsets = offsets_by_hour(&residuals, 7);
        assert_eq!((offsets[11], offsets[15], offsets[0]), (Some(2.0), None, None));
    }
}
