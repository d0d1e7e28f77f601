//! Texts of runs, by key.

use super::filter::Filter;
use crate::format;
use client_model::PastRun;
use site_model::{
    AskDefault, LocalDateTime, Reading, RunCause, RunState, RunStatus, Site, TaskState, TaskStatus,
};

pub(super) const CURRENT_TAB: &str = "Now";
pub(super) const HISTORY_TAB: &str = "History";
pub(super) const LOADING: &str = "The robot has not reported its missions yet.";
pub(super) const DELETED_MISSION: &str = "Deleted mission";
pub(super) const DELETED_PLACE: &str = "Deleted place";
pub(super) const DELETED_MONITOR: &str = "A monitor";
pub(super) const VISIT: &str = "Visit";

pub(super) const NOTHING_HEAD: &str = "No mission runs";
pub(super) const NOTHING_RUNS: &str = "Start one now, or schedule it on the Schedule screen.";
pub(super) const NO_MISSIONS: &str =
    "There are no missions yet. Make one on the Missions screen; then start it here.";
pub(super) const NO_TASKS: &str = "Its tasks are shown once it begins.";
pub(super) const PROGRESS: &str = "Progress";
pub(super) const SHOW_RUN: &str = "Show the run";
pub(super) const PAUSE: &str = "Pause";
pub(super) const RESUME: &str = "Resume";
pub(super) const SKIP_TASK: &str = "Skip task";
pub(super) const REDO_TASK: &str = "Redo task";
pub(super) const CANCEL: &str = "Cancel run";
pub(super) const CANCEL_HINT: &str = "The present action is finished, then the run ends where the robot is.";
pub(super) const ABORT: &str = "Abort…";
pub(super) const ABORT_HINT: &str = "The present action is cancelled, and the run ends at once.";
pub(super) const ABORT_QUESTION: &str =
    "Abort the run? Its present action is cancelled. What was gathered before is kept.";
pub(super) const ABORT_NOW: &str = "Abort run";
pub(super) const GO_ON: &str = "Go on with the run";
pub(super) const ANSWER: &str = "Answer";
pub(super) const TRY_AGAIN: &str = "Try again";
pub(super) const SKIP_IT: &str = "Skip it";
pub(super) const END_AT_DOCK: &str = "End at a dock";
pub(super) const END_HERE: &str = "End here";
pub(super) const QUEUE_HEAD: &str = "Waiting";

pub(super) const FILTERS: [(&str, Filter); 3] =
    [("All", Filter::All), ("Succeeded", Filter::Succeeded), ("Others", Filter::Problems)];
pub(super) const NO_PAST_RUNS: &str = "No such run has ended yet.";
pub(super) const FETCHING: &str = "Its tasks are fetched from the robot.";
pub(super) const NO_ATTEMPTS: &str = "It ended before its first task.";
const JUST_ENDED: &str = "Ended a moment ago";

pub(super) fn run_state(state: RunState) -> &'static str {
    match state {
        RunState::Queued => "Queued",
        RunState::Running => "Running",
        RunState::Paused => "Paused",
        RunState::Suspended => "Interrupted",
        RunState::Restarted => "Restarted",
        RunState::Ending => "Ending",
        RunState::Succeeded => "Succeeded",
        RunState::PartiallySucceeded => "In part",
        RunState::Failed => "Failed",
        RunState::Cancelled => "Cancelled",
        RunState::Interrupted => "Ended early",
    }
}

/// What a state means, where its word does not say it.
pub(super) fn run_sentence(run: &RunStatus) -> Option<&'static str> {
    match run.state {
        RunState::Paused => Some("The robot stands. Press \"Resume\" to go on."),
        RunState::Suspended => {
            Some("A monitor has interrupted it, such as for charging. It goes on by itself.")
        }
        RunState::Restarted => {
            Some("The program was restarted. It goes on by itself once the robot knows where it is.")
        }
        RunState::Ending => Some("Its outcome is decided. The robot goes where the run ends."),
        _ => None,
    }
}

pub(super) fn task_state(state: TaskState) -> &'static str {
    match state {
        TaskState::Waiting => "waiting",
        TaskState::Navigating => "on the way",
        TaskState::Running => "acting",
        TaskState::Paused => "paused",
        TaskState::Retriable => "again",
        TaskState::Succeeded => "done",
        TaskState::Failed => "failed",
        TaskState::Skipped => "skipped",
        TaskState::Cancelled => "cancelled",
    }
}

/// `5 of 9 · 4 min left`.
pub(super) fn progress(done: usize, all: usize, remaining_s: Option<f64>) -> String {
    match remaining_s {
        Some(remaining_s) => format!("{done} of {all} · {} left", format::duration(remaining_s)),
        None => format!("{done} of {all}"),
    }
}

/// `Photo · attempt 2 · The path stayed blocked.`
pub(super) fn task_facts(action: &str, task: &TaskStatus) -> String {
    let mut facts = action.to_owned();
    if task.attempt > 1 {
        facts.push_str(&format!(" · attempt {}", task.attempt));
    }
    if let Some(failure) = &task.failure {
        facts.push_str(&format!(" · {}", missions::task_failure(failure)));
    }
    facts
}

/// Accessible name of the row of a task.
pub(super) fn task_row(title: &str, state: &str) -> String {
    format!("{title}, {state}")
}

pub(super) fn on_the_way(remaining_m: f64, remaining_s: f64) -> String {
    format!("{} · {}", format::distance(remaining_m), format::elapsed(remaining_s))
}

pub(super) fn skip_named(task: &str) -> String {
    format!("Skip task {task}")
}

pub(super) fn redo_named(task: &str) -> String {
    format!("Redo task {task}")
}

pub(super) fn start(mission: &str) -> String {
    format!("Run {mission}")
}

pub(super) fn remove_from_queue(mission: &str) -> String {
    format!("Remove {mission} from the queue")
}

pub(super) fn blocked(monitor: &str) -> String {
    format!("{monitor} keeps missions from beginning. They begin by themselves when it permits.")
}

pub(super) fn question_elsewhere(mission: &str) -> String {
    format!("{mission} waits for an answer.")
}

/// `failure` is a sentence.
pub(super) fn question(task: &str, failure: &str) -> String {
    format!("{task}: {failure} What now?")
}

pub(super) fn question_limit(limit_s: f64, default: AskDefault) -> String {
    let otherwise = match default {
        AskDefault::Skip => "the task is skipped",
        AskDefault::EndAtDock => "the run ends at a dock",
        AskDefault::EndHere => "the run ends here",
    };
    format!("Without an answer within {}, {otherwise}.", format::duration(limit_s))
}

pub(super) fn cause(site: &Site, cause: &RunCause) -> String {
    match cause {
        RunCause::Command(_) => "Asked for by a person".to_owned(),
        RunCause::Schedule { schedule, slot } => {
            let name = site.schedule(*schedule).map_or("a schedule", |it| it.name.as_str());
            format!("{name}, {:02}:{:02}", slot.time.hour, slot.time.minute)
        }
        RunCause::Monitor(monitor) => {
            let name = site.monitors().find(|it| it.id == *monitor).map(|it| it.name.clone());
            name.unwrap_or_else(|| "A monitor".to_owned())
        }
    }
}

/// `24 Nov, 11:00 · Round A, 11:00`.
pub(super) fn past_facts(site: &Site, run: &PastRun<'_>, began: Option<LocalDateTime>) -> String {
    const MONTHS: [&str; 12] =
        ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
    let began = began.map(|at| {
        let month = MONTHS.get(usize::from(at.date.month.wrapping_sub(1))).copied().unwrap_or_default();
        format!("{} {month}, {:02}:{:02}", at.date.day, at.time.hour, at.time.minute)
    });
    let cause = run.cause.map(|of_run| cause(site, &of_run));
    let facts: Vec<String> = began.into_iter().chain(cause).collect();
    if facts.is_empty() { JUST_ENDED.to_owned() } else { facts.join(" · ") }
}

/// Name of a reading: `Dose rate`.
pub(super) fn reading_name(name: &str) -> String {
    let words = name.replace('_', " ");
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// `0.11 ± 0.02 µSv/h`.
pub(super) fn reading(reading: &Reading) -> String {
    let digits = if reading.value.abs() >= 100.0 { 0 } else { 2 };
    let deviation = reading.standard_deviation.map(|deviation| format!(" ± {deviation:.digits$}"));
    format!("{:.digits$}{} {}", reading.value, deviation.unwrap_or_default(), reading.unit)
}

pub(super) fn open_file(file: &str, task: &str) -> String {
    format!("Open {file} of {task}")
}

pub(super) fn file(name: &str, bytes: u64) -> String {
    format!("{name} · {}", format::bytes(bytes))
}

/// Accessible name of the row of a run that has ended.
pub(super) fn past_row(mission: &str, outcome: &str, facts: &str) -> String {
    format!("{mission}, {outcome}, {facts}")
}
