//! Numbers as text, each with its unit.

use crate::texts;
use site_model::LocalDate;
use vocab::{Stamp, Vec3};

/// The least standard deviation that is shown, metres: smaller ones would read as 0 mm.
pub const MIN_SHOWN_DEVIATION_M: f64 = 1e-3;

/// Metres: `0.4 m`, `12.3 m`, `1.24 km`.
pub fn distance(metres: f64) -> String {
    if metres.abs() >= 1000.0 {
        format!("{:.2} km", metres / 1000.0)
    } else {
        format!("{} m", decimal(metres, 1))
    }
}

/// A number with this many digits after the point. What rounds to zero has no sign.
pub fn decimal(number: f64, decimals: usize) -> String {
    let text = format!("{number:.decimals$}");
    let is_zero = text.starts_with('-') && !text.contains(|letter| ('1'..='9').contains(&letter));
    if is_zero { text[1..].to_owned() } else { text }
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
        texts::UNKNOWN.to_owned()
    }
}

/// Seconds as a clock: `0:07`, `12:40`, `1:02:33`.
pub fn elapsed(seconds: f64) -> String {
    let whole = seconds.max(0.0) as u64;
    let (hours, minutes, seconds) = (whole / 3600, whole / 60 % 60, whole % 60);
    if hours > 0 { format!("{hours}:{minutes:02}:{seconds:02}") } else { format!("{minutes}:{seconds:02}") }
}

/// Seconds roughly: `8 s`, `12 min`, `2 h 05`, `1 day`, `12 days`.
pub fn duration(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round() as u64;
    if seconds < 60.0 {
        format!("{:.0} s", seconds.max(0.0))
    } else if minutes < 60 {
        format!("{minutes} min")
    } else if minutes < 24 * 60 {
        format!("{} h {:02}", minutes / 60, minutes % 60)
    } else {
        match (seconds / 86_400.0).round() {
            1.0 => "1 day".to_owned(),
            days => format!("{days:.0} days"),
        }
    }
}

/// How old: `0.3 s old`, `12 s old`, `3 min old`.
pub fn age(seconds: f64) -> String {
    texts::old(&if seconds < 10.0 { format!("{seconds:.1} s") } else { duration(seconds) })
}

/// A number with its thousands apart: `1 234 567`, with thin spaces.
pub fn count(number: u64) -> String {
    vocab::grouped(number)
}

/// Points: `830`, `64 k`, `1.24 million`.
pub fn points(number: u64) -> String {
    match number {
        0..10_000 => count(number),
        10_000..1_000_000 => format!("{} k", number / 1000),
        _ => texts::millions(number as f64 / 1e6),
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
    let local = stamp.parts().0.saturating_add(utc_offset_s);
    let (days, second) = (local.div_euclid(86_400), local.rem_euclid(86_400));
    let LocalDate { year, month, day } = missions::date_of(days);
    let month = texts::month(month);
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
        _ => texts::days(hours.div_ceil(24)),
    }
}

/// A position, `1.2, -3.4, 0.0 m`.
pub fn position(position: &Vec3) -> String {
    // What rounds to zero has no sign.
    let [x, y, z] = position.to_array().map(|c| (c * 10.0).round() / 10.0 + 0.0);
    format!("{x:.1}, {y:.1}, {z:.1} m")
}

/// A speed, `0.8 m/s`.
pub fn speed(speed_m_s: f64) -> String {
    format!("{speed_m_s:.1} m/s")
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
