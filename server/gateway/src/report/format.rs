//! Numbers, times and lengths as text, each with its unit.

use site_model::{LocalDate, LocalDateTime};

const MONTHS: [&str; 12] = [
    "January",
    "February",
    "March",
    "April",
    "May",
    "June",
    "July",
    "August",
    "September",
    "October",
    "November",
    "December",
];
/// Greatest and smallest absolute value that is written without an exponent. Chosen: beyond both, digits are counted rather than read.
const PLAIN_NUMBERS: [f64; 2] = [1e9, 1e-4];

/// `24 November 2026`.
pub(super) fn day(date: LocalDate) -> String {
    let month = MONTHS.get(usize::from(date.month.wrapping_sub(1))).copied().unwrap_or_default();
    format!("{} {month} {}", date.day, date.year)
}

/// `11:05`.
pub(super) fn time(at: LocalDateTime) -> String {
    format!("{:02}:{:02}", at.time.hour, at.time.minute)
}

/// `24 November 2026, 11:05`.
pub(super) fn date_and_time(at: LocalDateTime) -> String {
    format!("{}, {}", day(at.date), time(at))
}

/// `24 Nov, 11:05`, for tables.
pub(super) fn short_date_and_time(at: LocalDateTime) -> String {
    let month = MONTHS.get(usize::from(at.date.month.wrapping_sub(1))).copied().unwrap_or_default();
    format!("{} {}, {}", at.date.day, month.get(..3).unwrap_or_default(), time(at))
}

/// Offset of a clock from UTC: `UTC+01:00`.
pub(super) fn utc_offset(minutes: i64) -> String {
    let sign = if minutes < 0 { '-' } else { '+' };
    let minutes = minutes.unsigned_abs();
    format!("UTC{sign}{:02}:{:02}", minutes / 60, minutes % 60)
}

/// A time span: `42 s`, `12 min 5 s`, `2 h 5 min`.
pub(super) fn duration(seconds: i64) -> String {
    let seconds = seconds.max(0);
    let (hours, minutes, rest) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    match (hours, minutes) {
        (0, 0) => format!("{rest} s"),
        (0, _) => format!("{minutes} min {rest} s"),
        _ => format!("{hours} h {minutes} min"),
    }
}

/// A number with its thousands apart: `12 345`.
pub(super) fn count(number: u64) -> String {
    vocab::grouped(number)
}

/// Length of a file: `12 kB`, `3.4 MB`.
pub(super) fn bytes(number: u64) -> String {
    match number as f64 {
        number if number >= 1e9 => format!("{:.1} GB", number / 1e9),
        number if number >= 1e6 => format!("{:.1} MB", number / 1e6),
        number => format!("{:.0} kB", (number / 1e3).ceil()),
    }
}

/// A number with this many digits after the point.
pub(super) fn decimal(number: f64, decimals: usize) -> String {
    let [greatest, smallest] = PLAIN_NUMBERS;
    let size = number.abs();
    if size >= greatest || size > 0.0 && size < smallest {
        return format!("{number:.2e}");
    }
    let text = format!("{number:.decimals$}");
    let is_zero = text.starts_with('-') && !text.contains(|letter| ('1'..='9').contains(&letter));
    if is_zero { text[1..].to_owned() } else { text }
}

/// Digits after the point of a measured value: as many as its standard deviation has with two digits, or else by its size.
pub(super) fn decimals(value: f64, standard_deviation: Option<f64>) -> usize {
    match standard_deviation.filter(|deviation| deviation.is_finite() && *deviation > 0.0) {
        Some(deviation) => (1.0 - deviation.log10().floor()).clamp(0.0, 6.0) as usize,
        None if value.abs() >= 1000.0 => 0,
        None if value.abs() >= 100.0 => 1,
        None if value == 0.0 || value.abs() >= 0.1 => 2,
        None => 4,
    }
}

/// A limit: with as many digits as it needs, four after the point at most.
pub(super) fn limit(limit: f64) -> String {
    let text = decimal(limit, 4);
    if !text.contains('.') || text.contains('e') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use site_model::LocalTime;

    #[test]
    fn times_read_as_people_write_them() {
        let date = LocalDate { year: 2026, month: 11, day: 4 };
        let at = LocalDateTime { date, time: LocalTime { hour: 9, minute: 5 } };
        assert_eq!(
            (date_and_time(at).as_str(), short_date_and_time(at).as_str()),
            ("4 November 2026, 09:05", "4 Nov, 09:05")
        );
        assert_eq!([0, 60, -210].map(utc_offset), ["UTC+00:00", "UTC+01:00", "UTC-03:30"]);
        assert_eq!([-5, 42, 725, 7_500].map(duration), ["0 s", "42 s", "12 min 5 s", "2 h 5 min"]);
    }

    #[test]
    fn a_value_has_the_digits_that_its_deviation_allows() {
        let shown = |value, deviation| decimal(value, decimals(value, deviation));
        assert_eq!(shown(21.4567, Some(0.05)), "21.457");
        assert_eq!(shown(1234.567, Some(14.0)), "1235");
        assert_eq!(shown(21.4567, None), "21.46");
        assert_eq!(shown(0.012345, Some(f64::NAN)), "0.0123");
        assert_eq!(shown(1e300, None), "1.00e300");
        assert_eq!(shown(-0.001, Some(0.1)), "0.00");
        assert_eq!([80.0, 0.25, 1e12].map(limit), ["80", "0.25", "1.00e12"]);
    }

    #[test]
    fn counts_and_lengths_have_thousands_and_units() {
        assert_eq!([7, 1_234, 1_234_567].map(count), ["7", "1\u{a0}234", "1\u{a0}234\u{a0}567"]);
        assert_eq!([5, 84_211, 3_400_000].map(bytes), ["1 kB", "85 kB", "3.4 MB"]);
    }
}
