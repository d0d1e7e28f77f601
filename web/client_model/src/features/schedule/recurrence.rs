//! Changes of recurrences: moved, ended, and cut in two.

use missions::{MINUTES_A_DAY, SiteZone, Slots, date_of, day_number, local_of, minute_number, weekday_of};
use site_model::{LocalDate, LocalDateTime, LocalTime, Recurrence, Schedule, ScheduleId, Utc, Weekday};
use std::collections::BTreeSet;
use vocab::Span;

/// Days of the week in their order.
const WEEK: [Weekday; 7] = [
    Weekday::Monday,
    Weekday::Tuesday,
    Weekday::Wednesday,
    Weekday::Thursday,
    Weekday::Friday,
    Weekday::Saturday,
    Weekday::Sunday,
];

/// Day of the week of a day.
pub(super) fn weekday(day: LocalDate) -> Weekday {
    WEEK[usize::from(weekday_of(day_number(day)))]
}

/// The first slot of a recurrence; none if it has none.
pub fn first_slot(recurrence: &Recurrence) -> Option<LocalDateTime> {
    // Which slots there are in local time is the same in every zone.
    let slots = Slots::new(recurrence, &SiteZone::utc()).ok()?;
    slots.after(Utc(i64::MIN / 2)).next().map(|slot| slot.slot)
}

/// The recurrence after its slot at `from` was moved to `to`, with all others. None where that has no meaning.
///
/// A weekly one has the same times on all its days. So another time takes the place of the earlier one on all days, and another day the place of the earlier one
/// at all times.
pub fn moved_recurrence(
    recurrence: &Recurrence,
    from: LocalDateTime,
    to: LocalDateTime,
) -> Option<Recurrence> {
    let shifted =
        |first: LocalDateTime| local_of(minute_number(first) + minute_number(to) - minute_number(from));
    match recurrence {
        Recurrence::Once(_) => Some(Recurrence::Once(to)),
        Recurrence::Weekly { days, times, first_day, last_day } => {
            let mut days = days.clone();
            if weekday(from.date) != weekday(to.date) {
                days.remove(&weekday(from.date));
                days.insert(weekday(to.date));
            }
            Some(Recurrence::Weekly {
                days,
                times: replaced(times, from.time, to.time),
                first_day: (*first_day).min(to.date),
                last_day: last_day.map(|last| last.max(to.date)),
            })
        }
        Recurrence::Every { first, interval } => {
            Some(Recurrence::Every { first: shifted(*first), interval: *interval })
        }
        // The parts of a rule that name days or times would have to move too.
        Recurrence::Rule { rule, .. } if rule.to_ascii_uppercase().contains("BY") => None,
        Recurrence::Rule { first, rule } => {
            Some(Recurrence::Rule { first: shifted(*first), rule: rule.clone() })
        }
    }
}

fn replaced(times: &[LocalTime], from: LocalTime, to: LocalTime) -> Vec<LocalTime> {
    let times: BTreeSet<LocalTime> =
        times.iter().map(|time| if *time == from { to } else { *time }).collect();
    times.into_iter().collect()
}

/// The recurrence with this last day. None where it cannot be said.
pub fn with_last_day(recurrence: &Recurrence, last_day: Option<LocalDate>) -> Option<Recurrence> {
    match recurrence {
        Recurrence::Once(_) => None,
        Recurrence::Weekly { days, times, first_day, .. } => Some(Recurrence::Weekly {
            days: days.clone(),
            times: times.clone(),
            first_day: *first_day,
            last_day,
        }),
        Recurrence::Every { first, interval } => match last_day {
            None => Some(recurrence.clone()),
            Some(day) => Some(Recurrence::Rule {
                first: *first,
                rule: format!("FREQ=DAILY;INTERVAL={}{}", whole_days(*interval)?, until_end_of(day)),
            }),
        },
        Recurrence::Rule { first, rule } => {
            let until = last_day.map(until_end_of).unwrap_or_default();
            Some(Recurrence::Rule { first: *first, rule: format!("{}{until}", without_until(rule)?) })
        }
    }
}

/// Days of an interval; none if they are not whole.
fn whole_days(interval: Span) -> Option<i64> {
    let minutes = interval.nanos() / Span::MINUTE.nanos();
    (minutes > 0 && minutes % MINUTES_A_DAY == 0).then_some(minutes / MINUTES_A_DAY)
}

fn until_end_of(day: LocalDate) -> String {
    until(LocalDateTime { date: day, time: LocalTime { hour: 23, minute: 59 } })
}

fn until(at: LocalDateTime) -> String {
    let LocalDateTime { date, time } = at;
    format!(";UNTIL={:04}{:02}{:02}T{:02}{:02}00", date.year, date.month, date.day, time.hour, time.minute)
}

/// A rule without its end by date. None if it ends after a number of slots.
fn without_until(rule: &str) -> Option<String> {
    let rule = rule.trim().to_ascii_uppercase();
    let parts =
        rule.strip_prefix("RRULE:").unwrap_or(&rule).split(';').filter(|part| !part.starts_with("UNTIL="));
    let kept: Vec<&str> = parts.collect();
    (!kept.iter().any(|part| part.starts_with("COUNT="))).then(|| kept.join(";"))
}

/// Cuts a schedule in two before one of its slots: the first ends before it, the second, under the id `new`, begins with it. None where that has no meaning: for
/// the first slot, and where the rule cannot be ended.
pub fn split_schedule(
    schedule: &Schedule,
    slot: LocalDateTime,
    new: ScheduleId,
) -> Option<(Schedule, Schedule)> {
    if first_slot(&schedule.recurrence)? >= slot {
        return None;
    }
    let (before, after) = split_recurrence(&schedule.recurrence, slot)?;
    let mut skipped_before = schedule.skipped.clone();
    skipped_before.retain(|skipped| *skipped < slot);
    let mut skipped_after = schedule.skipped.clone();
    skipped_after.retain(|skipped| *skipped >= slot);
    if let Recurrence::Weekly { times, .. } = &schedule.recurrence {
        // Both parts have the day of the cut, each with the times that belong to it.
        for time in times {
            let at = LocalDateTime { date: slot.date, time: *time };
            if at < slot {
                skipped_after.push(at);
            } else {
                skipped_before.push(at);
            }
        }
    }
    for skipped in [&mut skipped_before, &mut skipped_after] {
        skipped.sort_unstable();
        skipped.dedup();
    }
    let mut earlier = Schedule { recurrence: before, skipped: skipped_before, ..schedule.clone() };
    if let Recurrence::Weekly { times, last_day, .. } = &mut earlier.recurrence
        && times.iter().all(|time| *time >= slot.time)
    {
        *last_day = Some(date_of(day_number(slot.date) - 1));
        earlier.skipped.retain(|skipped| skipped.date < slot.date);
    }
    let later = Schedule { id: new, recurrence: after, skipped: skipped_after, ..schedule.clone() };
    Some((earlier, later))
}

fn split_recurrence(recurrence: &Recurrence, slot: LocalDateTime) -> Option<(Recurrence, Recurrence)> {
    match recurrence {
        Recurrence::Once(_) => None,
        Recurrence::Weekly { days, times, last_day, .. } => {
            let after = Recurrence::Weekly {
                days: days.clone(),
                times: times.clone(),
                first_day: slot.date,
                last_day: *last_day,
            };
            Some((with_last_day(recurrence, Some(slot.date))?, after))
        }
        Recurrence::Every { first, interval } => {
            let days = whole_days(*interval)?;
            let rule = format!("FREQ=DAILY;INTERVAL={days}{}", until(minute_before(slot)));
            let before = Recurrence::Rule { first: *first, rule };
            Some((before, Recurrence::Every { first: slot, interval: *interval }))
        }
        Recurrence::Rule { first, rule } => {
            let endless = without_until(rule)?;
            let before =
                Recurrence::Rule { first: *first, rule: format!("{endless}{}", until(minute_before(slot))) };
            Some((before, Recurrence::Rule { first: slot, rule: rule.clone() }))
        }
    }
}

fn minute_before(at: LocalDateTime) -> LocalDateTime {
    local_of(minute_number(at) - 1)
}
