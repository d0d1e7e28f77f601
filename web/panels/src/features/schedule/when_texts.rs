//! Texts of days, times and recurrences.

use missions::{day_number, weekday_of};
use site_model::{LocalDate, LocalDateTime, LocalTime, Recurrence, Weekday, Weekdays};
use vocab::Span;

/// Days of the week from Monday on, short.
pub(super) const DAYS: [(&str, Weekday); 7] = [
    ("Mon", Weekday::Monday),
    ("Tue", Weekday::Tuesday),
    ("Wed", Weekday::Wednesday),
    ("Thu", Weekday::Thursday),
    ("Fri", Weekday::Friday),
    ("Sat", Weekday::Saturday),
    ("Sun", Weekday::Sunday),
];

const MONTHS: [&str; 12] =
    ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];

/// `09:30`.
pub(crate) fn time(time: LocalTime) -> String {
    format!("{:02}:{:02}", time.hour, time.minute)
}

fn month(date: LocalDate) -> &'static str {
    MONTHS.get(usize::from(date.month.wrapping_sub(1))).copied().unwrap_or_default()
}

/// `Wed`.
pub(super) fn weekday(date: LocalDate) -> &'static str {
    DAYS[usize::from(weekday_of(day_number(date)))].0
}

/// `Wed 25`.
pub(super) fn day_head(date: LocalDate) -> String {
    format!("{} {}", weekday(date), date.day)
}

/// `Wed 25 Nov`.
pub(super) fn day(date: LocalDate) -> String {
    format!("{} {} {}", weekday(date), date.day, month(date))
}

/// `Wed 25 Nov 2026`.
pub(super) fn day_with_year(date: LocalDate) -> String {
    format!("{} {}", day(date), date.year)
}

/// `2026-11-25`, as dates are typed.
pub(super) fn iso_date(date: LocalDate) -> String {
    format!("{:04}-{:02}-{:02}", date.year, date.month, date.day)
}

/// `Wed 25 Nov, 15:00`.
pub(super) fn day_and_time(at: LocalDateTime) -> String {
    format!("{}, {}", day(at.date), time(at.time))
}

/// `23 to 29 Nov 2026`, `30 Nov to 6 Dec 2026`.
pub(super) fn week(first: LocalDate, last: LocalDate) -> String {
    let begin = if first.year != last.year {
        format!("{} {} {}", first.day, month(first), first.year)
    } else if first.month != last.month {
        format!("{} {}", first.day, month(first))
    } else {
        first.day.to_string()
    };
    format!("{begin} to {} {} {}", last.day, month(last), last.year)
}

/// `13:42, Europe/London`.
pub(super) fn clock(at: LocalDateTime, zone: &str) -> String {
    format!("{}, {zone}", time(at.time))
}

/// Words in a row: `a`, `a and b`, `a, b and c`.
fn listed(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

fn days(days: &Weekdays) -> String {
    let on: Vec<usize> = (0..7).filter(|index| days.contains(&DAYS[*index].1)).collect();
    let is_row = on.windows(2).all(|pair| pair[1] == pair[0] + 1);
    match on.as_slice() {
        [] => "On no day".to_owned(),
        all if all.len() == 7 => "Every day".to_owned(),
        [first, .., last] if is_row && on.len() > 2 => format!("{} to {}", DAYS[*first].0, DAYS[*last].0),
        some => listed(&some.iter().map(|index| DAYS[*index].0.to_owned()).collect::<Vec<_>>()),
    }
}

/// When a schedule has its slots: `Mon to Fri at 11:00 and 15:00`.
pub(super) fn recurrence(recurrence: &Recurrence) -> String {
    match recurrence {
        Recurrence::Once(at) => format!("Once, {} at {}", day_with_year(at.date), time(at.time)),
        Recurrence::Weekly { days: on, times, last_day, .. } => {
            let times: Vec<String> = times.iter().map(|at| time(*at)).collect();
            let at =
                if times.is_empty() { "at no time".to_owned() } else { format!("at {}", listed(&times)) };
            let end = last_day.map(|last| format!(", until {}", day_with_year(last))).unwrap_or_default();
            format!("{} {at}{end}", days(on))
        }
        Recurrence::Every { first, interval } => {
            format!("Every {}, from {}", self::interval(*interval), day_and_time(*first))
        }
        Recurrence::Rule { first, rule } => format!("{rule}, from {}", day_and_time(*first)),
    }
}

/// `2 days`, `90 min`, `4 h`.
pub(super) fn interval(interval: Span) -> String {
    let minutes = interval.nanos() / Span::MINUTE.nanos();
    match minutes {
        1_440 => "day".to_owned(),
        _ if minutes % 1_440 == 0 => format!("{} days", minutes / 1_440),
        _ if minutes % 60 == 0 => format!("{} h", minutes / 60),
        _ => format!("{minutes} min"),
    }
}
