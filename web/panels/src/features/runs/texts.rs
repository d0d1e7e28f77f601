//! Texts of runs, by key.

use crate::format;
use client_model::{PastRun, StoredResult};
use site_model::{
    ActionReport, AskDefault, LocalDateTime, OutsideLimits, Reading, RouteWait, RunCause, RunState,
    RunStatus, Site, SkipReason, TaskState, TaskStatus,
};

pub(super) const CURRENT_TAB: &str = "Now";
pub(super) const HISTORY_TAB: &str = "History";
pub(super) const LOADING: &str = "The robot has not reported its missions yet.";
pub(super) const DELETED_MISSION: &str = "Deleted mission";
pub(super) const DELETED_SCHEDULE: &str = "Deleted schedule";
pub(super) const DELETED_PLACE: &str = "Deleted place";
pub(super) const DELETED_EDGE: &str = "Deleted edge";
pub(super) const DELETED_ZONE: &str = "Deleted zone";
pub(super) const DELETED_MONITOR: &str = "A monitor";
pub(super) const VISIT: &str = "Visit";

pub(super) const LAST_HEAD: &str = "Last run";
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

pub(super) const MISSION_FILTER: &str = "Mission";
pub(super) const OUTCOME_FILTER: &str = "Outcome";
pub(super) const FROM_FILTER: &str = "From";
pub(super) const TO_FILTER: &str = "To";
pub(super) const DATE_HINT: &str = "2026-11-24";
pub(super) const DATE_MALFORMED: &str = "Write a date like 2026-11-24.";
pub(super) const ALL_MISSIONS: &str = "All missions";
pub(super) const ALL_OUTCOMES: &str = "All outcomes";
pub(super) const SKIPPED: &str = "Skipped";
pub(super) const MISSED: &str = "Missed";
/// Outcomes that can be chosen.
pub(super) const OUTCOMES: [RunState; 5] = [
    RunState::Succeeded,
    RunState::PartiallySucceeded,
    RunState::Failed,
    RunState::Cancelled,
    RunState::Interrupted,
];
pub(super) const CLEAR_FILTER: &str = "Show all";
pub(super) const OLDER: &str = "Show older runs";
pub(super) const FETCHING_LIST: &str = "The runs are fetched from the robot.";
/// A file of a run.
pub(super) struct RunFile {
    /// Name of its button.
    pub(super) name: &'static str,
    /// The same, on the button.
    pub(super) short: &'static str,
    pub(super) hint: &'static str,
}

pub(super) const DOWNLOAD: RunFile = RunFile {
    name: "Download the run",
    short: "Download",
    hint: "One ZIP file with pictures, readings as a table, and all records.",
};
pub(super) const REPORT: RunFile = RunFile { name: "Report", short: "Report", hint: REPORT_HINT };
pub(super) const MCAP: RunFile = RunFile {
    name: "Download for Foxglove",
    short: "MCAP",
    hint: "One MCAP file with pictures, readings, spectra and poses at their times, for Foxglove and other programs.",
};
pub(super) const REPORT_HINT: &str =
    "One HTML file to read, print and pass on. What needs attention comes first.";
pub(super) const WEEK_REPORT: &str = "Report of the week";

pub(super) const LIGHTBOX: &str = "Pictures of the run";
pub(super) const PICTURE: &str = "Picture";
pub(super) const SPECTRUM: &str = "Spectrum";
pub(super) const CLOSE: &str = "Close the pictures";
pub(super) const PREVIOUS: &str = "Previous picture";
pub(super) const NEXT: &str = "Next picture";
pub(super) const ZOOM_IN: &str = "Zoom in";
pub(super) const ZOOM_OUT: &str = "Zoom out";
pub(super) const WHOLE: &str = "Whole picture";
pub(super) const COMPARE: &str = "With the last one";
pub(super) const FETCHING_FILE: &str = "It is fetched from the robot.";
pub(super) const WARMEST: &str = "warmest";
pub(super) const HERE: &str = "here";
pub(super) const ENERGY_AXIS: &str = "Energy, keV";
pub(super) const COUNT_AXIS: &str = "Counts in a channel";
pub(super) const POINT_HISTORY: &str = "History of this point";
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

/// Why the robot stands on its way.
pub(super) fn route_wait(wait: &RouteWait) -> String {
    let text = match wait {
        RouteWait::Hold { group, holder, .. } => {
            return format!("The robot waits: {holder} holds {group}.");
        }
        RouteWait::Place => "The robot waits until it knows where it is.",
        RouteWait::Block { .. } => "The robot waits: the only way is blocked. It is tried again by itself.",
        RouteWait::Retry { .. } => "The robot waits: the edge was blocked. It is tried again by itself.",
        RouteWait::Action(_) => "The robot stands while an action of the edge is performed.",
        RouteWait::Charge => "The robot waits for the charging current.",
    };
    text.to_owned()
}

pub(super) fn navigating(remaining_m: f64, remaining_s: f64) -> String {
    format!("{} · {}", format::distance(remaining_m), format::elapsed(remaining_s))
}

/// `Gauge north · Photo · 12 s old`.
pub(super) fn newest(task: &str, action: &str, age_s: f64) -> String {
    format!("{task} · {action} · {}", format::age(age_s))
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
        RunCause::Account { account, .. } => format!("Asked for by {account}"),
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

fn month(at: LocalDateTime) -> &'static str {
    const MONTHS: [&str; 12] =
        ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
    MONTHS.get(usize::from(at.date.month.wrapping_sub(1))).copied().unwrap_or_default()
}

/// `24 Nov, 11:00`.
pub(super) fn day_and_time(at: LocalDateTime) -> String {
    format!("{} {}, {:02}:{:02}", at.date.day, month(at), at.time.hour, at.time.minute)
}

/// `24 Nov 2026, 11:00`.
pub(crate) fn date_and_time(at: LocalDateTime) -> String {
    let (date, time) = (at.date, at.time);
    format!("{} {} {}, {:02}:{:02}", date.day, month(at), date.year, time.hour, time.minute)
}

/// Why a slot of a schedule was skipped, a clause.
pub(crate) fn skip_reason(site: &Site, reason: SkipReason) -> String {
    match reason {
        SkipReason::Blocked(monitor) => {
            let monitor = site.monitors().find(|it| it.id == monitor);
            let name = monitor.map_or(DELETED_MONITOR, |monitor| &monitor.name);
            format!("{name} blocked missions for too long")
        }
        reason => missions::skip_reason(reason).to_owned(),
    }
}

/// `24 Nov, 11:00 · Round A: the queue was full`.
pub(super) fn skipped_facts(at: Option<LocalDateTime>, schedule: &str, reason: &str, count: u64) -> String {
    let at = at.map(|at| format!("{} · ", day_and_time(at))).unwrap_or_default();
    let more = if count > 1 { format!(" ({count} in a row)") } else { String::new() };
    format!("{at}{schedule}: {reason}{more}")
}

/// `24 Nov, 11:00 · Round A, 11:00`.
pub(super) fn past_facts(site: &Site, run: &PastRun<'_>, began: Option<LocalDateTime>) -> String {
    let began = began.map(day_and_time);
    let cause = run.cause.map(|of_run| cause(site, of_run));
    let facts: Vec<String> = began.into_iter().chain(cause).collect();
    if facts.is_empty() { JUST_ENDED.to_owned() } else { facts.join(" · ") }
}

/// Name of a reading: `Dose rate`.
pub(crate) fn reading_name(name: &str) -> String {
    let words = name.replace('_', " ");
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// `0.11 ± 0.02 µSv/h`.
pub(crate) fn reading(reading: &Reading) -> String {
    let digits = if reading.value.abs() >= 100.0 { 0 } else { 2 };
    let deviation = reading.standard_deviation.map(|deviation| format!(" ± {deviation:.digits$}"));
    format!("{:.digits$}{} {}", reading.value, deviation.unwrap_or_default(), reading.unit)
}

/// Which limit of its inspection point a reading does not keep.
pub(crate) fn outside(outside: OutsideLimits, unit: &str) -> String {
    match outside {
        OutsideLimits::Below(min) => format!("below {} {unit}", format::decimal(min, 2)),
        OutsideLimits::Above(max) => format!("above {} {unit}", format::decimal(max, 2)),
    }
}

pub(super) fn open_file(file: &str, task: &str) -> String {
    format!("Open {file} of {task}")
}

/// Accessible name of the button that leads to all results at a place.
pub(super) fn point_history(place: &str) -> String {
    format!("{POINT_HISTORY}: {place}")
}

pub(super) fn file(name: &str, bytes: u64) -> String {
    format!("{name} · {}", format::bytes(bytes))
}

/// Accessible name of the row of a run that has ended.
pub(super) fn past_row(mission: &str, outcome: &str, facts: &str) -> String {
    format!("{mission}, {outcome}, {facts}")
}

/// Accessible name of a picture in the list.
pub(super) fn show_file(file: &str, task: &str) -> String {
    format!("Show {file} of {task}")
}

/// `3 of 9: Pump 7, Photo`.
pub(super) fn result_view(number: usize, all: usize, title: &str, action: &str) -> String {
    format!("{number} of {all}: {title}, {action}")
}

/// `Photo · 3 of 9 · Round A`.
pub(super) fn exhibit_rest(number: usize, all: usize, action: &str, mission: &str) -> String {
    format!("{action} · {number} of {all} · {mission}")
}

pub(super) fn this_run(taken: &str) -> String {
    format!("This run · {taken}")
}

/// `Before · 17 Nov 2026, 11:02 · 7 days earlier`.
pub(super) fn before(taken: &str, age_s: f64) -> String {
    format!("Before · {taken} · {} earlier", format::duration(age_s))
}

/// Why there is no earlier picture beside one. `has_point`: whether it was taken at an inspection point.
pub(super) fn no_previous(
    has_point: bool,
    previous: Option<&Result<Option<(StoredResult, ActionReport)>, String>>,
) -> String {
    match previous {
        Some(Err(sentence)) => sentence.clone(),
        Some(Ok(_)) => "There is no earlier one of this inspection point.".to_owned(),
        None if !has_point => {
            "It was not taken at an inspection point, so none of another run belongs to it.".to_owned()
        }
        None => FETCHING_FILE.to_owned(),
    }
}

/// What differs in how two pictures were taken, a clause; none if that is little.
pub(crate) fn difference(before: &ActionReport, now: &ActionReport) -> Option<String> {
    let (before, now) = (before.camera?.aim, now.camera?.aim);
    let turned = (before.pan_rad - now.pan_rad).hypot(before.tilt_rad - now.tilt_rad).to_degrees();
    let zoomed = (before.zoom / now.zoom.max(f64::EPSILON)).ln().abs() > 0.05;
    match (turned > 2.0, zoomed) {
        (_, true) => Some(format!("before: zoom {:.1}×", before.zoom)),
        (true, false) => Some(format!("before: head turned {turned:.0}° otherwise")),
        (false, false) => None,
    }
}

/// `Pan 69° · tilt 6° · zoom 4.0× · focal length 2217 px · position ±2 cm · Centre temperature 41.20 °C`.
pub(super) fn exhibit_facts(report: &ActionReport, difference: Option<&str>) -> String {
    let mut facts = Vec::new();
    if let Some(camera) = &report.camera {
        let aim = camera.aim;
        facts.push(format!("Pan {:.0}°", aim.pan_rad.to_degrees()));
        facts.push(format!("tilt {:.0}°", aim.tilt_rad.to_degrees()));
        facts.push(format!("zoom {:.1}×", aim.zoom));
        facts.push(format!("focal length {:.0} px", camera.focal_px));
    }
    if let Some(place) = &report.place {
        let rows = place.covariance.0;
        let sigma_m = (rows[3][3] + rows[4][4]).max(0.0).sqrt();
        facts.push(format!("Robot's position {}", format::accuracy(sigma_m)));
    }
    facts.extend(report.readings.iter().map(|it| format!("{} {}", reading_name(&it.name), reading(it))));
    facts.extend(difference.map(str::to_owned));
    facts.join(" · ")
}

/// `21.4 °C`.
pub(super) fn celsius(celsius: f64) -> String {
    format!("{celsius:.1} °C")
}

/// `warmest 62.1 °C`.
pub(super) fn marker(what: &str, celsius: f64) -> String {
    format!("{what} {celsius:.1} °C")
}

/// `12 345 counts in 60 s live time`.
pub(super) fn spectrum_total(counts: u64, live_time_s: f64) -> String {
    format!("{} counts in {live_time_s:.0} s live time", format::count(counts))
}

/// `662 keV · 134 counts`.
pub(super) fn spectrum_at(kev: f64, count: u32) -> String {
    format!("{kev:.0} keV · {} counts", format::count(count.into()))
}
