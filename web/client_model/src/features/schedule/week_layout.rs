//! Where the occurrences of a week are drawn: in which day, from when to when, and side by side where they overlap.

use missions::{MINUTES_A_DAY, date_of, day_number, weekday_of};
use site_model::LocalDate;

/// Days of a week.
const DAYS: i64 = 7;

/// Something that takes time in the week.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShownSpan {
    /// Minutes from the beginning of the week, in local time. Negative: it began in the week before.
    pub start_min: i64,
    /// Its length.
    pub length_min: i64,
}

/// The part of a span that lies in one day.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DaySegment {
    /// Position of the span in the list.
    pub span: usize,
    /// Day of the week, 0 is the first.
    pub day: usize,
    /// Minute of the day at which it begins.
    pub from_min: i64,
    /// Minute of the day at which it ends.
    pub to_min: i64,
    /// Its column within the day.
    pub lane: usize,
    /// Number of columns that those have which overlap here.
    pub lanes: usize,
    /// Whether it goes on from the day before.
    pub is_continued: bool,
    /// Whether it goes on in the day after.
    pub continues: bool,
}

/// The first day, Monday, of the week of a day.
pub fn week_of(day: LocalDate) -> LocalDate {
    let number = day_number(day);
    date_of(number - i64::from(weekday_of(number)))
}

/// Cuts spans at midnight, and puts those that overlap side by side. In the order of days and beginnings.
pub fn lay_out_week(spans: &[ShownSpan]) -> Vec<DaySegment> {
    let mut segments: Vec<DaySegment> =
        spans.iter().enumerate().flat_map(|(span, shown)| segments_of(span, *shown)).collect();
    segments.sort_by_key(|segment| (segment.day, segment.from_min, segment.span));
    let mut begin = 0;
    while begin < segments.len() {
        let end = group_end(&segments, begin);
        give_lanes(&mut segments[begin..end]);
        begin = end;
    }
    segments
}

fn segments_of(span: usize, shown: ShownSpan) -> impl Iterator<Item = DaySegment> {
    let end = shown.start_min + shown.length_min.max(1);
    let first = shown.start_min.div_euclid(MINUTES_A_DAY);
    let last = (end - 1).div_euclid(MINUTES_A_DAY);
    (first.max(0)..=last.min(DAYS - 1)).map(move |day| DaySegment {
        span,
        day: day as usize,
        from_min: (shown.start_min - day * MINUTES_A_DAY).max(0),
        to_min: (end - day * MINUTES_A_DAY).min(MINUTES_A_DAY),
        lane: 0,
        lanes: 1,
        is_continued: day > first,
        continues: day < last,
    })
}

/// End of the segments from `begin` on that overlap each other, directly or through others.
fn group_end(segments: &[DaySegment], begin: usize) -> usize {
    let mut until = segments[begin].to_min;
    let mut end = begin + 1;
    while end < segments.len() && segments[end].day == segments[begin].day && segments[end].from_min < until {
        until = until.max(segments[end].to_min);
        end += 1;
    }
    end
}

/// Gives each segment the first lane that is free when it begins.
fn give_lanes(group: &mut [DaySegment]) {
    let mut ends: Vec<i64> = Vec::new();
    for segment in group.iter_mut() {
        let free = ends.iter().position(|end| *end <= segment.from_min);
        segment.lane = free.unwrap_or(ends.len());
        match free {
            Some(lane) => ends[lane] = segment.to_min,
            None => ends.push(segment.to_min),
        }
    }
    for segment in group {
        segment.lanes = ends.len();
    }
}
