//! Texts of reports for people, by key. English.

use super::format;
use site_model::{
    Alert, AlertCause, AlertSeverity, AlertState, Movement, OutsideLimits, ReadingLimits, ReviewState,
    RunState, SceneChange, SceneChangeKind, TaskState,
};

/// Characters of a name from outside that a report shows, at most.
pub(super) const MAX_NAME_CHARS: usize = 160;
/// Characters of a sentence from outside that a report shows, at most.
pub(super) const MAX_SENTENCE_CHARS: usize = 600;

pub(super) const UNNAMED_SITE: &str = "Site";
pub(super) const DELETED_MISSION: &str = "Deleted mission";
pub(super) const DELETED_PLACE: &str = "Deleted place";
pub(super) const DELETED_EDGE: &str = "Deleted edge";
pub(super) const DELETED_ZONE: &str = "Deleted zone";
pub(super) const VISIT: &str = "Visit";

pub(super) const OF_RUN: &str = "Report of a run";
pub(super) const OF_PERIOD: &str = "Report of all runs";
pub(super) const BEGAN: &str = "Began";
pub(super) const ENDED: &str = "Ended";
pub(super) const DURATION: &str = "Duration";
pub(super) const CAUSE: &str = "Asked for by";
pub(super) const FROM: &str = "From";
pub(super) const TO: &str = "To";
pub(super) const TIME_ZONE: &str = "Time zone";
pub(super) const NOT_BEGUN: &str = "Not yet";
pub(super) const NOT_ENDED: &str = "Not yet";

pub(super) const TASKS_DONE: &str = "tasks done";
pub(super) const TASKS_FAILED: &str = "failed";
pub(super) const TASKS_SKIPPED: &str = "skipped";
pub(super) const TASKS_OPEN: &str = "not done";
pub(super) const RUNS: [&str; 2] = ["run", "runs"];
pub(super) const READINGS_OUTSIDE: [&str; 2] =
    ["reading outside its limits", "readings outside their limits"];
pub(super) const CHANGES_FOUND: [&str; 2] = ["change of the scene", "changes of the scene"];

pub(super) const ATTENTION_HEAD: &str = "What needs attention";
pub(super) const NO_ATTENTION: &str = "Nothing. No task has failed or was skipped, no reading is outside its limits, every gauge was read, no change of the scene was found, and no alert is open.";
pub(super) const SEVERITY: &str = "Severity";
pub(super) const ALERT: &str = "Alert";
pub(super) const RAISED: &str = "Raised last";
pub(super) const OWNER: &str = "Owner";
pub(super) const WORK_ORDER: &str = "Work order";
pub(super) const ALERTS_HEAD: &str = "Alerts that are not closed";
pub(super) const READINGS_HEAD: &str = "Readings outside their limits";
pub(super) const GAUGES_HEAD: &str = "Gauges that were not read";
pub(super) const NOT_DONE_HEAD: &str = "Tasks that were not done";
pub(super) const CHANGES_HEAD: &str = "Changes of the scene";
pub(super) const SUMMARY_HEAD: &str = "Runs";
pub(super) const TASKS_HEAD: &str = "Tasks";
pub(super) const NO_RUNS: &str = "No run was asked for in this time.";
pub(super) const NO_TASKS_YET: &str = "It has not begun.";
pub(super) const NO_TASKS: &str = "It ended before its first task.";
pub(super) const SKIPPED_BY: &str = "A person left it out, or nobody answered the question about it in time.";

pub(super) const RUN: &str = "Run";
pub(super) const MISSION: &str = "Mission";
pub(super) const OUTCOME: &str = "Outcome";
pub(super) const PLACE: &str = "Place";
pub(super) const ACTION: &str = "Action";
pub(super) const STATE: &str = "State";
pub(super) const REASON: &str = "Reason";
pub(super) const TIME: &str = "Time";
pub(super) const TOOK: &str = "Took";
pub(super) const ATTEMPT: &str = "Attempt";
pub(super) const READING: &str = "Reading";
pub(super) const VALUE: &str = "Value";
pub(super) const DEVIATION: &str = "Std. dev.";
pub(super) const UNIT: &str = "Unit";
pub(super) const LIMITS: &str = "Limits";
pub(super) const JUDGEMENT: &str = "Judged";
pub(super) const WITHIN: &str = "within limits";
pub(super) const KIND: &str = "Change";
pub(super) const SIZE: &str = "Size";
pub(super) const REVIEW: &str = "Review";
pub(super) const DONE_OF_ALL: &str = "Tasks done";
pub(super) const OUTSIDE: &str = "Outside limits";

pub(super) const ENERGY_AXIS: &str = "Energy, keV";
pub(super) const COUNT_AXIS: &str = "Counts in a channel";

pub(super) const RUN_ID: &str = "Run";
pub(super) const MISSION_ID: &str = "Mission";
pub(super) const SITE_REVISION: &str = "Revision of the site";
pub(super) const MADE: &str = "Report made";
pub(super) const LIMITS_NOTE: &str =
    "Readings are judged by the limits that the inspection points had when the report was made.";

/// The outcome of a run, or its state while it has none.
pub(super) fn run_state(state: RunState) -> &'static str {
    match state {
        RunState::Queued => "Waits for its turn",
        RunState::Running => "Under way",
        RunState::Paused => "Paused",
        RunState::Suspended => "Interrupted by a monitor",
        RunState::Restarted => "Waits after a restart",
        RunState::Ending => "Ending",
        RunState::Succeeded => "Succeeded",
        RunState::PartiallySucceeded => "Succeeded in part",
        RunState::Failed => "Failed",
        RunState::Cancelled => "Cancelled by a person",
        RunState::Interrupted => "Ended by a monitor or a schedule",
    }
}

/// The state of a task.
pub(super) fn task_state(state: TaskState) -> &'static str {
    match state {
        TaskState::Waiting => "Waiting",
        TaskState::Navigating => "On the way",
        TaskState::Running => "Under way",
        TaskState::Paused => "Paused",
        TaskState::Retriable => "Failed, to be tried again",
        TaskState::Succeeded => "Done",
        TaskState::Failed => "Failed",
        TaskState::Skipped => "Skipped",
        TaskState::Cancelled => "Cancelled",
    }
}

pub(super) const CAUSE_PERSON: &str = "a person or a program";
pub(super) const NOT_KNOWN: &str = "not known";

/// `schedule Weekdays, slot 11:00`.
pub(super) fn cause_schedule(schedule: Option<&str>, slot: &str) -> String {
    match schedule {
        Some(schedule) => format!("schedule {schedule}, slot {slot}"),
        None => format!("a schedule that was deleted, slot {slot}"),
    }
}

/// `monitor Low battery`.
pub(super) fn cause_monitor(monitor: Option<&str>) -> String {
    monitor.map_or_else(|| "a monitor".to_owned(), |monitor| format!("monitor {monitor}"))
}

/// `Works 3: Morning round, 24 November 2026, 11:00`.
pub(super) fn title(site: &str, of: &str, at: &str) -> String {
    format!("{site}: {of}, {at}")
}

/// `7 of 9`.
pub(super) fn of_all(done: usize, all: usize) -> String {
    format!("{done} of {all}")
}

/// `Europe/London (UTC+01:00)`.
pub(super) fn zone(name: &str, offset: &str) -> String {
    format!("{name} ({offset})")
}

/// Name of a reading: `Dose rate`.
pub(super) fn reading_name(name: &str) -> String {
    let words = name.replace('_', " ");
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// A standard deviation: `± 0.05`.
pub(super) fn deviation(deviation: &str) -> String {
    format!("± {deviation}")
}

/// What limits allow: `50 to 80`.
pub(super) fn limits(limits: &ReadingLimits) -> String {
    match (limits.min, limits.max) {
        (Some(min), Some(max)) => format!("{} to {}", format::limit(min), format::limit(max)),
        (Some(min), None) => format!("at least {}", format::limit(min)),
        (None, Some(max)) => format!("at most {}", format::limit(max)),
        (None, None) => String::new(),
    }
}

/// Which limit a reading does not keep: `above 80`.
pub(super) fn outside(outside: OutsideLimits) -> String {
    match outside {
        OutsideLimits::Below(min) => format!("below {}", format::limit(min)),
        OutsideLimits::Above(max) => format!("above {}", format::limit(max)),
    }
}

/// What becomes of an entry beyond the greatest number of a list.
pub(super) fn more(count: usize) -> String {
    format!("And {} more.", format::count(count as u64))
}

pub(super) fn alert_severity(severity: AlertSeverity) -> &'static str {
    match severity {
        AlertSeverity::Information => "Information",
        AlertSeverity::Warning => "Warning",
        AlertSeverity::Critical => "Critical",
    }
}

/// What an alert is about: `Pressure 5.3 bar, above 5`.
pub(super) fn alert(alert: &Alert) -> String {
    let what = match &alert.cause {
        AlertCause::OutsideLimits { reading, .. } => {
            let value = format::decimal(reading.value, format::decimals(reading.value, None));
            let outside = outside(reading.outside);
            format!("{} {value} {}, {outside}", reading_name(&reading.name), reading.unit)
        }
        AlertCause::GaugeNotRead { reason, .. } => reason.clone(),
        AlertCause::TaskFailed { reason, .. } => reason.clone(),
        AlertCause::SceneChange(_) => "Change of the scene".to_owned(),
        AlertCause::ByHand { .. } => alert.comment.clone(),
    };
    vocab::legible(&what, MAX_SENTENCE_CHARS)
}

/// When it was raised last, and how often: `24 Nov, 11:05, 3 times`.
pub(super) fn alert_raised(at: &str, times: u32) -> String {
    if times > 1 { format!("{at}, {} times", format::count(times.into())) } else { at.to_owned() }
}

/// The state of an alert, and whether its cause is gone.
pub(super) fn alert_state(alert: &Alert) -> String {
    let state = match &alert.state {
        AlertState::Open => "open".to_owned(),
        AlertState::Acknowledged { by, .. } => {
            format!("acknowledged by {}", vocab::legible(by, MAX_NAME_CHARS))
        }
        AlertState::Closed { .. } => "closed".to_owned(),
    };
    if alert.recovered.is_some() { format!("{state}, normal again") } else { state }
}

/// What became of an object.
pub(super) fn change_kind(change: &SceneChange) -> String {
    match change.kind {
        SceneChangeKind::Appeared => "Appeared".to_owned(),
        SceneChangeKind::Removed => "Removed".to_owned(),
        SceneChangeKind::Moved { from } => match Movement::between(&from, &change.place) {
            Movement::Shifted { distance_m } => format!("Moved by {} m", format::decimal(distance_m, 1)),
            Movement::Turned { turn_rad } => {
                format!("Turned by {}°", format::decimal(turn_rad.to_degrees(), 0))
            }
        },
    }
}

/// `0.6 × 0.4 × 1.0 m`.
pub(super) fn change_size(change: &SceneChange) -> String {
    let [length, width, height] = change.place.size_m.map(|side| format::decimal(side, 1));
    format!("{length} × {width} × {height} m")
}

/// Where an object is: `near Pump 7 (x 6.0 m, y 1.2 m)`.
pub(super) fn change_place(near: Option<&str>, x: f64, y: f64) -> String {
    let at = format!("x {} m, y {} m", format::decimal(x, 1), format::decimal(y, 1));
    near.map_or_else(|| at.clone(), |near| format!("near {near} ({at})"))
}

/// What people have decided of a change. `reason` of a dismissal is from outside.
pub(super) fn review(review: &ReviewState) -> String {
    match review {
        ReviewState::New => "not looked at yet".to_owned(),
        ReviewState::Acknowledged => "acknowledged".to_owned(),
        ReviewState::Dismissed { reason } => {
            format!("dismissed: {}", vocab::legible(reason, MAX_SENTENCE_CHARS))
        }
        ReviewState::Watched => "watched".to_owned(),
        ReviewState::Normal { .. } => "normal by now".to_owned(),
        ReviewState::Routine => "comes and goes".to_owned(),
    }
}

/// `photo.jpg · 84 kB`.
pub(super) fn file(name: &str, bytes: u64) -> String {
    format!("{name} · {}", format::bytes(bytes))
}

/// Why a file is only named.
pub(super) const FILE_MISSING: &str = "not on the robot's disk any more";
/// Why a file is only named.
pub(super) const FILE_TOO_LARGE: &str = "larger than 16 MB, so it is not shown here";
/// Why a file is only named.
pub(super) const FILE_NO_PICTURE: &str = "neither JPEG nor PNG, so it is not shown here";

/// What stands below a picture: `Pump 7 · 24 Nov, 11:05 · photo.jpg`.
pub(super) fn caption(place: &str, at: &str, file: &str) -> String {
    format!("{place} · {at} · {file}")
}

/// Above a photo that differs from the one before, which stands beside it.
pub(super) fn changed_photo(places: usize, residual_px: f64) -> String {
    let places = if places == 1 { "1 place".to_owned() } else { format!("{places} places") };
    format!("The photo differs from the one before in {places}. Both are aligned within {residual_px:.1} px.")
}

/// Below the photo before.
pub(super) fn photo_before(place: &str, at: &str) -> String {
    format!("{place} · before: {at}")
}

/// What a picture shows, for people who do not see it.
pub(super) fn picture_of(file: &str, place: &str) -> String {
    format!("{file} of {place}")
}

/// What a spectrum shows, for people who do not see it.
pub(super) fn spectrum_of(place: &str) -> String {
    format!("Gamma spectrum of {place}")
}

/// `12 345 counts in 60 s live time`.
pub(super) fn spectrum_total(counts: u64, live_time_s: f64) -> String {
    format!("{} counts in {} s live time", format::count(counts), format::decimal(live_time_s, 0))
}

/// `2 attempts`.
pub(super) fn attempts(attempts: usize) -> String {
    format!("{attempts} attempts")
}

/// The line above the title: `Works 3 · Report of a run`.
pub(super) fn kicker(site: &str, what: &str) -> String {
    format!("{site} · {what}")
}

/// `17 November 2026 to 24 November 2026`.
pub(super) fn days(from: &str, to: &str) -> String {
    if from == to { from.to_owned() } else { format!("{from} to {to}") }
}

/// `Morning round, 24 Nov, 11:05`.
pub(super) fn run_head(mission: &str, at: &str) -> String {
    format!("{mission}, {at}")
}

/// The id of a run below its tasks.
pub(super) fn run_id(run: site_model::RunId) -> String {
    format!("{RUN_ID} {run}")
}

/// The file of a report of a period, without its ending: `report_2026-11-17_to_2026-11-24`.
pub(super) fn period_file_name([from, to]: [site_model::LocalDate; 2]) -> String {
    let day = |date: site_model::LocalDate| format!("{:04}-{:02}-{:02}", date.year, date.month, date.day);
    format!("report_{}_to_{}", day(from), day(to))
}

// Refusals. Clauses for `query_malformed`.

pub(super) const SPAN_REVERSED: &str = "to_ns is not after from_ns";

/// A period that is too long.
pub(super) fn span_too_long(max_days: i64) -> String {
    format!("A report covers {max_days} days at most. Bring from_ns and to_ns nearer to each other.")
}

/// A period with too many runs.
pub(super) fn too_many_runs(max_runs: usize) -> String {
    format!(
        "A report covers {max_runs} runs at most, and there are more between from_ns and to_ns. Ask for a shorter time."
    )
}
