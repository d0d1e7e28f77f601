//! Texts of schedules, by key.

use crate::format;
use client_model::{ChangeScope, OccurrenceState};
use missions::{ClockChange, day_number, weekday_of};
use site_model::{
    LocalDate, LocalDateTime, LocalTime, MissedSlots, OverlapPolicy, Recurrence, RunState, Weekday, Weekdays,
};
use vocab::Span;

pub(super) const TAB: &str = "Schedule";
pub(super) const CARD: &str = "Week";
pub(super) const LOADING: &str = "The site has not arrived from the robot yet.";
pub(super) const NO_MISSIONS: &str =
    "There are no missions yet. Make one on the Missions screen; then drag it from here into the week.";
pub(super) const NO_SCHEDULES: &str = "Nothing is scheduled yet. Drag a mission from the list into the week.";
pub(super) const NOTHING_DUE: &str = "Nothing is due in the next 14 days.";

pub(super) const WEEK: &str = "Week";
pub(super) const AGENDA: &str = "Agenda";
pub(super) const EARLIER_WEEK: &str = "Earlier week";
pub(super) const THIS_WEEK: &str = "This week";
pub(super) const LATER_WEEK: &str = "Later week";
pub(super) const SITE_TIME: &str = "Site time";
pub(super) const YOUR_TIME: &str = "Your time";
pub(super) const SITE_COLUMN: &str = "site";
pub(super) const YOUR_COLUMN: &str = "you";

pub(super) const MISSIONS_HEAD: &str = "Missions";
pub(super) const DRAG_HINT: &str = "Drag one into the week, or press it.";
pub(super) const SCHEDULES_HEAD: &str = "Schedules";
pub(super) const OUTLOOK_HEAD: &str = "Next 30 days";
pub(super) const FILES_HEAD: &str = "Plan";
pub(super) const SAVE: &str = "Save to a file";
pub(super) const LOAD: &str = "Load from a file";
pub(super) const UNDO: &str = "Undo";
pub(super) const REDO: &str = "Redo";

pub(super) const ALL_SCHEDULES: &str = "All schedules";
pub(super) const NAME: &str = "Schedule name";
pub(super) const MISSION: &str = "Mission";
pub(super) const OCCURRENCE_HEAD: &str = "This occurrence";
pub(super) const WHEN_HEAD: &str = "When";
pub(super) const POLICY_HEAD: &str = "If something is in the way";
pub(super) const DATE: &str = "Date";
pub(super) const TIME: &str = "Time";
pub(super) const TIMES: &str = "Times";
pub(super) const ADD_TIME: &str = "Add a time";
pub(super) const FIRST_DAY: &str = "From";
pub(super) const LAST_DAY: &str = "Until";
pub(super) const NO_END: &str = "No end";
pub(super) const INTERVAL: &str = "Interval";
pub(super) const RULE: &str = "Rule (RFC 5545)";
pub(super) const RULE_SHORT: &str = "Rule";
pub(super) const ADD_END: &str = "Add an end date";
pub(super) const WEEKLY: &str = "Weekly";
pub(super) const ONCE: &str = "Once";
pub(super) const EVERY: &str = "Interval";
pub(super) const MISSED: &str = "Missed";
pub(super) const MISSED_REMARK: &str = "A slot that was missed, as while the robot was switched off:";
pub(super) const GRACE: &str = "May begin late by";
pub(super) const OVERLAP_REMARK: &str = "If another mission runs:";
pub(super) const PRIORITY: &str = "Priority";
pub(super) const PAUSE: &str = "Pause schedule";
pub(super) const PAUSE_SHORT: &str = "Pause";
pub(super) const RESUME: &str = "Resume schedule";
pub(super) const RESUME_SHORT: &str = "Resume";
pub(super) const SKIP_NEXT: &str = "Skip next";
pub(super) const SKIP_THIS: &str = "Skip this one";
pub(super) const UNSKIP_THIS: &str = "Run it after all";
pub(super) const SPLIT: &str = "Change from here on";
pub(super) const SPLIT_HINT: &str = "Makes a schedule of its own of this occurrence and those after it.";
pub(super) const DELETE: &str = "Delete schedule";
pub(super) const DELETE_SHORT: &str = "Delete";
pub(super) const IN_THE_PAST: &str = "This time has passed.";

pub(super) const QUESTION: &str = "Which occurrences?";
pub(super) const CANCEL: &str = "Cancel";
pub(super) const PAST_REMARK: &str =
    "The occurrence itself would be in the past, so it cannot move there alone.";

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

pub(super) const MISSED_CHOICES: [(&str, MissedSlots); 3] =
    [("Skip", MissedSlots::Skip), ("Run one", MissedSlots::RunOnce), ("Run all", MissedSlots::RunAll)];

pub(super) const OVERLAP_CHOICES: [(&str, OverlapPolicy); 3] =
    [("Skip", OverlapPolicy::Skip), ("Queue one", OverlapPolicy::Queue), ("Replace", OverlapPolicy::Replace)];

/// How late a slot may begin, as it is offered, minutes.
pub(super) const GRACES_MIN: [(&str, i64); 4] = [("5 min", 5), ("15 min", 15), ("1 h", 60), ("4 h", 240)];

pub(super) fn time(time: LocalTime) -> String {
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
    let minutes = interval.nanos() / 60_000_000_000;
    match minutes {
        1_440 => "day".to_owned(),
        _ if minutes % 1_440 == 0 => format!("{} days", minutes / 1_440),
        _ if minutes % 60 == 0 => format!("{} h", minutes / 60),
        _ => format!("{minutes} min"),
    }
}

const PLANNED: &str = "planned";
const PAST: &str = "past";

pub(super) fn state(state: OccurrenceState, is_past: bool) -> &'static str {
    match state {
        OccurrenceState::Skipped => "skipped",
        OccurrenceState::Paused => "paused",
        OccurrenceState::SameInstant => "runs with another one",
        OccurrenceState::Planned if is_past => PAST,
        OccurrenceState::Planned => PLANNED,
    }
}

/// As [`state`], or the state of the run if the slot has one.
pub(super) fn state_with_outcome(
    state: OccurrenceState,
    outcome: Option<RunState>,
    is_past: bool,
) -> &'static str {
    match outcome {
        None => self::state(state, is_past),
        Some(RunState::Queued) => "waits",
        Some(RunState::Running | RunState::Ending) => "runs",
        Some(RunState::Paused) => "paused",
        Some(RunState::Suspended | RunState::Restarted) => "interrupted",
        Some(RunState::Succeeded) => "done",
        Some(RunState::PartiallySucceeded) => "done in part",
        Some(RunState::Failed) => "failed",
        Some(RunState::Cancelled) => "cancelled",
        Some(RunState::Interrupted) => "ended early",
    }
}

/// Accessible name of an occurrence.
pub(super) fn occurrence(schedule: &str, at: LocalDateTime, state: &str) -> String {
    format!("{schedule}, {}, {state}", day_and_time(at))
}

/// The line within a block. A state that is not the usual one comes first, so that it is read also where there is little room.
pub(super) fn block(schedule: &str, at: LocalTime, state: &str) -> String {
    if [PLANNED, PAST].contains(&state) {
        return format!("{} {schedule}", time(at));
    }
    format!("{} {state}: {schedule}", time(at))
}

pub(super) fn moved(from: LocalTime, to: LocalTime) -> String {
    format!("{} → {}", time(from), time(to))
}

pub(super) fn moving(from: LocalDateTime, to: LocalDateTime) -> String {
    let to = if from.date == to.date { time(to.time) } else { day_and_time(to) };
    format!("{} → {to}", day_and_time(from))
}

pub(super) fn move_head(schedule: &str) -> String {
    format!("Move {schedule}")
}

pub(super) fn delete_head(schedule: &str) -> String {
    format!("Delete {schedule}")
}

pub(super) fn scope(scope: ChangeScope) -> &'static str {
    match scope {
        ChangeScope::This => "This one",
        ChangeScope::Following => "This and following",
        ChangeScope::All => "All",
    }
}

pub(super) fn schedule_mission(mission: &str) -> String {
    format!("Schedule mission {mission}")
}

/// `9 tasks · about 12 min`.
pub(super) fn mission_facts(tasks: usize, duration_s: Option<f64>) -> String {
    let tasks = if tasks == 1 { "1 task".to_owned() } else { format!("{tasks} tasks") };
    match duration_s {
        Some(duration_s) => format!("{tasks} · about {}", format::duration(duration_s)),
        None => format!("{tasks} · no route yet"),
    }
}

pub(super) fn open_schedule(schedule: &str) -> String {
    format!("Open schedule {schedule}")
}

pub(super) fn paused(sentence: &str) -> String {
    format!("Paused · {sentence}")
}

pub(super) fn in_zone(sentence: &str, zone: &str) -> String {
    format!("{sentence}, {zone}")
}

/// `44 runs · 8 h 20 · 2 conflicts`.
pub(super) fn outlook(runs: usize, duration_s: f64, conflicts: usize) -> String {
    let runs = if runs == 1 { "1 run".to_owned() } else { format!("{runs} runs") };
    let conflicts = match conflicts {
        0 => "no conflicts".to_owned(),
        1 => "1 conflict".to_owned(),
        number => format!("{number} conflicts"),
    };
    if duration_s < 1.0 {
        return format!("{runs} · {conflicts}");
    }
    format!("{runs} · about {} · {conflicts}", format::duration(duration_s))
}

pub(super) fn conflict(at: LocalDateTime, schedule: &str, running: &str, policy: OverlapPolicy) -> String {
    format!("{}: {running} still runs. {}", day_and_time(at), consequence(schedule, policy))
}

pub(super) fn due_together(at: LocalDateTime, schedule: &str, other: &str, policy: OverlapPolicy) -> String {
    format!("{}: {other} is due at the same time. {}", day_and_time(at), consequence(schedule, policy))
}

pub(super) fn move_to(schedule: &str, at: LocalDateTime) -> String {
    format!("Move {schedule} to {}", time(at.time))
}

fn consequence(schedule: &str, policy: OverlapPolicy) -> String {
    match policy {
        OverlapPolicy::Skip => format!("{schedule} is skipped."),
        OverlapPolicy::Queue => format!("{schedule} waits."),
        OverlapPolicy::Replace => format!("{schedule} ends it."),
    }
}

pub(super) fn clock_change(slot: LocalDateTime, due: LocalDateTime, change: ClockChange) -> Option<String> {
    match change {
        ClockChange::None => None,
        ClockChange::Skipped => Some(format!(
            "{}: clocks go forward. {} runs at {}.",
            day(slot.date),
            time(slot.time),
            time(due.time)
        )),
        ClockChange::Repeated => Some(format!(
            "{}: clocks go back. {} comes twice; the first one runs.",
            day(slot.date),
            time(slot.time)
        )),
    }
}

pub(super) fn shortened(schedule: &str) -> String {
    format!("{schedule} has more occurrences than are shown.")
}

pub(super) fn unusable(schedule: &str, reason: &str) -> String {
    format!("{schedule} cannot be used: {reason}.")
}

pub(super) fn unknown_zone(zone: &str) -> String {
    format!("There is no time zone \"{zone}\", so schedules wait. Choose one on the Settings screen.")
}

/// `Wed 25 Nov, 16:00 for you`.
pub(super) fn for_you(at: LocalDateTime) -> String {
    format!("{} for you", day_and_time(at))
}

pub(super) fn earlier(name: &str) -> String {
    format!("{name}: earlier")
}

pub(super) fn later(name: &str) -> String {
    format!("{name}: later")
}

pub(super) fn numbered_time(number: usize) -> String {
    format!("Time {number}")
}

pub(super) fn remove_time(at: LocalTime) -> String {
    format!("Remove {}", time(at))
}

pub(super) fn next(at: Option<LocalDateTime>) -> String {
    at.map_or_else(|| "Does not run again".to_owned(), |at| format!("Next: {}", day_and_time(at)))
}

/// A row of the agenda: `15:00   Round A · about 12 min`.
pub(super) fn agenda_row(
    at: LocalTime,
    yours: Option<LocalTime>,
    schedule: &str,
    minutes: i64,
    state: &str,
) -> String {
    let yours = yours.map(|at| format!(" ({} for you)", time(at))).unwrap_or_default();
    let length = if minutes > 0 { format!(" · about {minutes} min") } else { String::new() };
    let state = if state == PLANNED { String::new() } else { format!(" · {state}") };
    format!("{}{yours}   {schedule}{length}{state}", time(at))
}

/// How many occurrences are hidden in a day of the agenda.
pub(super) fn more(number: usize) -> String {
    format!("and {number} more")
}
