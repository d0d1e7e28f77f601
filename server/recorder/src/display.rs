//! [`RecordingInfo`] as a table for a terminal.

use crate::info::{RecordingInfo, TopicInfo};
use std::fmt;
use vocab::Stamp;

impl fmt::Display for RecordingInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.path)?;
        let messages = self.topics.iter().fold(0_u64, |sum, topic| sum.saturating_add(topic.count));
        write!(f, "{}, {}, {} messages", self.format, duration(self.duration), grouped(messages))?;
        // A clock that was never set starts at 1970, so its date is not shown.
        match self.start.filter(|start| start.secs_f64() > 1e8) {
            Some(start) => writeln!(f, ", from {} UTC", date(start))?,
            None => writeln!(f)?,
        }
        writeln!(f)?;
        write_table(f, &self.topics)?;
        write_list(f, "Sensors", '•', &self.sensors)?;
        write_list(f, "Missing", '○', &self.missing)?;
        write_list(f, "Notes", '!', &self.warnings)
    }
}

fn write_table(f: &mut fmt::Formatter<'_>, topics: &[TopicInfo]) -> fmt::Result {
    const TITLES: [&str; 5] = ["topic", "type", "messages", "Hz", "used as"];
    let rows: Vec<[String; 5]> = topics
        .iter()
        .map(|topic| {
            [
                topic.name.clone(),
                topic.type_name.clone(),
                grouped(topic.count),
                topic.hz.map_or(String::new(), |hz| format!("{hz:.1}")),
                topic.role.map_or(String::new(), |role| role.name().to_owned()),
            ]
        })
        .collect();
    let width = |column: usize| {
        let cells = rows.iter().map(|row| row[column].chars().count());
        cells.chain([TITLES[column].len()]).max().unwrap_or(0)
    };
    let widths = [0, 1, 2, 3, 4].map(width);
    let mut line = |cells: [&str; 5]| {
        let [topic, kind, count, hz, role] = cells;
        let [a, b, c, d, _] = widths;
        let text = format!("  {topic:<a$}  {kind:<b$}  {count:>c$}  {hz:>d$}  {role}");
        writeln!(f, "{}", text.trim_end())
    };
    line(TITLES)?;
    let rules = widths.map(|width| "─".repeat(width));
    line([&rules[0], &rules[1], &rules[2], &rules[3], &rules[4]])?;
    rows.iter().try_for_each(|row| line([&row[0], &row[1], &row[2], &row[3], &row[4]]))
}

fn write_list(f: &mut fmt::Formatter<'_>, title: &str, mark: char, lines: &[String]) -> fmt::Result {
    if lines.is_empty() {
        return Ok(());
    }
    writeln!(f, "\n{title}")?;
    lines.iter().try_for_each(|line| write_wrapped(f, mark, line))
}

/// Lines of at most about 100 characters, with a hanging indent.
fn write_wrapped(f: &mut fmt::Formatter<'_>, mark: char, text: &str) -> fmt::Result {
    const WIDTH: usize = 96;
    let mut line = format!("  {mark}");
    for word in text.split_whitespace() {
        if line.chars().count() + 1 + word.chars().count() > WIDTH && line.trim().chars().count() > 1 {
            writeln!(f, "{line}")?;
            line = "   ".to_owned();
        }
        line.push(' ');
        line.push_str(word);
    }
    writeln!(f, "{line}")
}

/// `12 345`, with a narrow no-break space.
fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    out
}

fn duration(seconds: f64) -> String {
    let whole = seconds as u64;
    match whole {
        0..60 => format!("{seconds:.1} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

/// `2026-11-21 10:32:05`. Years are counted from March, so that the leap day is the last one.
fn date(stamp: Stamp) -> String {
    let (seconds, _) = stamp.parts();
    let (days, time) = (seconds.div_euclid(86_400) + 719_468, seconds.rem_euclid(86_400));
    let (era, day_of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = era * 400 + year_of_era + i64::from(month <= 2);
    let (hour, minute, second) = (time / 3600, time / 60 % 60, time % 60);
    format!("{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_durations_and_counts_are_formatted_for_reading() {
        assert_eq!(date(Stamp::from_parts(1_709_210_096, 0)), "2024-02-29 12:34:56");
        assert_eq!(date(Stamp::EPOCH), "1970-01-01 00:00:00");
        assert_eq!(duration(49.51), "49.5 s");
        assert_eq!(duration(3725.0), "1 h 02 min");
        assert_eq!(grouped(1_234_567), "1\u{202f}234\u{202f}567");
    }
}
