//! Arithmetic on days and times of day.

use site_model::{LocalDate, LocalDateTime, LocalTime};

/// Minutes of a day without a change of the clocks.
pub const MINUTES_A_DAY: i64 = 24 * 60;

/// Days since 1970-01-01. The algorithm of Howard Hinnant, *chrono-compatible low-level date algorithms*. Valid for all years.
pub fn day_number(date: LocalDate) -> i64 {
    let (year, month, day) = (i64::from(date.year), i64::from(date.month), i64::from(date.day));
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let year_of_era = year.rem_euclid(400);
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
    era * 146_097 + day_of_era - 719_468
}

/// The day of a number. The inverse of [`day_number`].
pub fn date_of(number: i64) -> LocalDate {
    let days = number + 719_468;
    let era = days.div_euclid(146_097);
    let day_of_era = days.rem_euclid(146_097);
    let year_of_era = (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    LocalDate { year: year.clamp(-9_999, 9_999) as i16, month: month as u8, day: day as u8 }
}

/// Day of the week of a day number: 0 is Monday.
pub fn weekday_of(number: i64) -> u8 {
    (number + 3).rem_euclid(7) as u8
}

/// Minutes since 1970-01-01 00:00 of a local time, as if the zone had no changes.
pub fn minute_number(at: LocalDateTime) -> i64 {
    day_number(at.date) * MINUTES_A_DAY + i64::from(at.time.hour) * 60 + i64::from(at.time.minute)
}

/// The local time of a minute. The inverse of [`minute_number`].
pub fn local_of(minutes: i64) -> LocalDateTime {
    let (day, minute) = (minutes.div_euclid(MINUTES_A_DAY), minutes.rem_euclid(MINUTES_A_DAY));
    LocalDateTime { date: date_of(day), time: time_of(minute) }
}

/// The time of a minute of the day.
pub(crate) fn time_of(minute: i64) -> LocalTime {
    LocalTime { hour: (minute / 60) as u8, minute: (minute % 60) as u8 }
}

/// Number of the first day of a month. Months beyond 12 are those of later years.
pub(crate) fn first_of_month(year: i64, month: i64) -> i64 {
    let (year, month) = (year + (month - 1).div_euclid(12), (month - 1).rem_euclid(12) + 1);
    day_number(LocalDate { year: year.clamp(-9_999, 9_999) as i16, month: month as u8, day: 1 })
}
