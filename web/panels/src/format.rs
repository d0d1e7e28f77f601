//! Numbers as text, each with its unit.

use vocab::{Stamp, Vec3};

/// The least standard deviation that is shown, metres: smaller ones would read as 0 mm.
pub const SHOWN_DEVIATION_MIN_M: f64 = 1e-3;

/// Metres: `0.4 m`, `12.3 m`, `1.24 km`.
pub fn distance(metres: f64) -> String {
    if metres.abs() >= 1000.0 { format!("{:.2} km", metres / 1000.0) } else { format!("{metres:.1} m") }
}

/// An area: `7.4 m²`, `412 m²`.
pub fn area(square_metres: f64) -> String {
    if square_metres < 10.0 { format!("{square_metres:.1} m²") } else { format!("{square_metres:.0} m²") }
}

/// A small length: `4 mm`, `1.4 cm`, `0.35 m`.
pub fn accuracy(metres: f64) -> String {
    if metres < 0.01 {
        format!("{:.0} mm", metres * 1000.0)
    } else if metres < 0.1 {
        format!("{:.1} cm", metres * 100.0)
    } else if metres < 100.0 {
        format!("{metres:.2} m")
    } else {
        "unknown".to_owned()
    }
}

/// Seconds as a clock: `0:07`, `12:40`, `1:02:33`.
pub fn elapsed(seconds: f64) -> String {
    let whole = seconds.max(0.0) as u64;
    let (hours, minutes, seconds) = (whole / 3600, whole / 60 % 60, whole % 60);
    if hours > 0 { format!("{hours}:{minutes:02}:{seconds:02}") } else { format!("{minutes}:{seconds:02}") }
}

/// Seconds roughly: `8 s`, `12 min`, `2 h 05`.
pub fn duration(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round() as u64;
    if seconds < 60.0 {
        format!("{:.0} s", seconds.max(0.0))
    } else if minutes < 60 {
        format!("{minutes} min")
    } else {
        format!("{} h {:02}", minutes / 60, minutes % 60)
    }
}

/// How old: `0.3 s old`, `12 s old`, `3 min old`.
pub fn age(seconds: f64) -> String {
    if seconds < 10.0 { format!("{seconds:.1} s old") } else { format!("{} old", duration(seconds)) }
}

/// A number with its thousands apart: `1 234 567`, with thin spaces.
pub fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut grouped = String::with_capacity(digits.len() * 2);
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            grouped.push('\u{a0}');
        }
        grouped.push(digit);
    }
    grouped
}

/// Points: `830`, `64 k`, `1.24 million`.
pub fn points(number: u64) -> String {
    match number {
        0..10_000 => count(number),
        10_000..1_000_000 => format!("{} k", number / 1000),
        _ => format!("{:.2} million", number as f64 / 1e6),
    }
}

/// Bytes: `12 kB`, `3.4 MB`.
pub fn bytes(number: u64) -> String {
    let number = number as f64;
    if number >= 1e9 {
        format!("{:.1} GB", number / 1e9)
    } else if number >= 1e6 {
        format!("{:.1} MB", number / 1e6)
    } else {
        format!("{:.0} kB", number / 1e3)
    }
}

/// Bits per second: `12 kbit/s`, `1.8 Mbit/s`.
pub fn bit_rate(bits_per_s: f64) -> String {
    if bits_per_s >= 1e6 {
        format!("{:.1} Mbit/s", bits_per_s / 1e6)
    } else {
        format!("{:.0} kbit/s", bits_per_s / 1e3)
    }
}

/// A day and time where the client is, `21 Nov 2026, 11:40`.
pub fn date(stamp: Stamp, utc_offset_s: i64) -> String {
    const MONTHS: [&str; 12] =
        ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
    let local = stamp.parts().0.saturating_add(utc_offset_s);
    let (days, second) = (local.div_euclid(86_400), local.rem_euclid(86_400));
    let (year, month, day) = civil_from_days(days);
    let month = MONTHS.get(month - 1).copied().unwrap_or_default();
    format!("{day} {month} {year}, {:02}:{:02}", second / 3600, second / 60 % 60)
}

/// A day where the client is, `1 Dec`.
pub fn day(stamp: Stamp, utc_offset_s: i64) -> String {
    let date = date(stamp, utc_offset_s);
    date.split(' ').take(2).collect::<Vec<_>>().join(" ")
}

/// Seconds until something happens, rounded up: `6 days`, `1 day`, `5 h`.
pub fn time_left(seconds: f64) -> String {
    let hours = (seconds.max(0.0) / 3600.0).ceil() as u64;
    match hours {
        0..24 => format!("{hours} h"),
        24 => "1 day".to_owned(),
        _ => format!("{} days", hours.div_ceil(24)),
    }
}

/// Year, month (1 to 12) and day of the Gregorian calendar, from days since 1970-01-01.
///
/// Counts in years that begin in March, so that the leap day is the last one.
fn civil_from_days(days: i64) -> (i64, usize, i64) {
    const DAYS_OF_400_YEARS: i64 = 146_097;
    let since_march_of_0 = days + 719_468;
    let era = since_march_of_0.div_euclid(DAYS_OF_400_YEARS);
    let day_of_era = since_march_of_0.rem_euclid(DAYS_OF_400_YEARS);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    (year_of_era + era * 400 + i64::from(month <= 2), month as usize, day)
}

/// A position, `1.2, -3.4, 0.0 m`.
pub fn position(position: &Vec3) -> String {
    // What rounds to zero has no sign.
    let [x, y, z] = position.to_array().map(|c| (c * 10.0).round() / 10.0 + 0.0);
    format!("{x:.1}, {y:.1}, {z:.1} m")
}

/// A speed, `0.8 m/s`.
pub fn speed(speed_mps: f64) -> String {
    format!("{speed_mps:.1} m/s")
}

/// A rate: `9.9 Hz` below twenty, `200 Hz` above.
pub fn rate(rate_hz: f32) -> String {
    if rate_hz < 20.0 { format!("{rate_hz:.1} Hz") } else { format!("{rate_hz:.0} Hz") }
}

/// A share as a whole number, `63 %`.
pub fn percent(share: f32) -> String {
    format!("{:.0} %", share * 100.0)
}

/// A share: `0.4 %` below ten, `63 %` above.
pub fn share(share: f32) -> String {
    let percent = share * 100.0;
    if percent < 9.95 && percent > 0.0 { format!("{percent:.1} %") } else { format!("{percent:.0} %") }
}

#[cfg(test)]
mod tests;
