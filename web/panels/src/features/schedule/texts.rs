//! Texts of schedules, by key.

use crate::format;
use client_model::{ChangeScope, OccurrenceState};
use missions::{ClockChange, day_number, weekday_of};
use site_model::{LocalDate, LocalDateTime, LocalTime, MissedSlots, OverlapPolicy, RunState};

pub(super) use super::when_texts::*;

pub(super) const TAB: &str = "Schedule";
pub(super) const CARD: &str = "Week";
pub(super) const LOADING: &str = "The site has not arrived from the robot yet.";
pub(super) const NO_MISSIONS: &str =
    "There are no missions yet. Make one on the Missions screen; then drag it from here into the week.";
pub(super) const NO_SCHEDULES: &str = "Nothing is scheduled yet. Drag a mission from the list into the week.";
pub(super) const NOTHING_DUE: &str = "Nothing is due in the next 14 days.";

pub(super) const NEXT_RUN: &str = "Next run";

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

pub(super) const MISSED_CHOICES: [(&str, MissedSlots); 3] =
    [("Skip", MissedSlots::Skip), ("Run one", MissedSlots::RunOnce), ("Run all", MissedSlots::RunAll)];

pub(super) const OVERLAP_CHOICES: [(&str, OverlapPolicy); 3] =
    [("Skip", OverlapPolicy::Skip), ("Queue one", OverlapPolicy::Queue), ("Replace", OverlapPolicy::Replace)];

/// How late a slot may begin, as it is offered, minutes.
pub(super) const GRACES_MIN: [(&str, i64); 4] = [("5 min", 5), ("15 min", 15), ("1 h", 60), ("4 h", 240)];

/// When the next run begins: `15:00` today, else `Thu 11:00`.
pub(super) fn next_run(at: LocalDateTime, today: LocalDate) -> String {
    if at.date == today {
        return time(at.time);
    }
    format!("{} {}", DAYS[usize::from(weekday_of(day_number(at.date)))].0, time(at.time))
}

pub(super) fn next_run_hint(run: &str) -> String {
    format!("The next run that a schedule begins: {run}.")
}

pub(super) const SKIPPED: &str = "skipped";
const PLANNED: &str = "planned";
const PAST: &str = "past";

pub(super) fn state(state: OccurrenceState, is_past: bool) -> &'static str {
    match state {
        OccurrenceState::Skipped => SKIPPED,
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

/// `skipped: the queue was full`.
pub(super) fn with_reason(state: &str, reason: Option<&str>) -> String {
    reason.map_or_else(|| state.to_owned(), |reason| format!("{state}: {reason}"))
}

/// `It was skipped: the queue was full.`
pub(super) fn was_skipped(reason: &str) -> String {
    format!("It was skipped: {reason}.")
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
