//! Runs as they are stored, in the form in which they are served.

use api::{StoredResult, StoredRun, StoredSlot, StoredStep};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use site_model::{MissionId, RunId, ScheduleId};
use utoipa::ToSchema;

/// A page of a list.
#[derive(Serialize, ToSchema)]
pub(crate) struct RunPage<T: Serialize + ToSchema> {
    pub(super) items: Vec<T>,
    /// `before` or `after` of the next page; null: there is none.
    pub(super) next: Option<String>,
}

/// A run as it is stored.
#[derive(Serialize, ToSchema)]
#[schema(as = StoredRun)]
pub(crate) struct RunDocument {
    /// Its id.
    #[schema(value_type = String)]
    run: RunId,
    /// Its mission.
    #[schema(value_type = String)]
    mission: MissionId,
    /// Its state.
    state: String,
    /// Whether it has ended.
    is_ended: bool,
    /// What led to it, when it began, and the revisions of the objects that it was made from.
    #[schema(value_type = Object)]
    details: Value,
    /// When it was asked for, nanoseconds since 1970 UTC.
    asked_ns: i64,
    /// When it changed last.
    changed_ns: i64,
}

/// An attempt of a task.
#[derive(Serialize, ToSchema)]
#[schema(as = StoredStep)]
pub(crate) struct StepDocument {
    /// Number of the task in its run, from 0.
    step: u32,
    /// Number of the attempt, from 1.
    attempt: u32,
    /// Its state.
    state: String,
    /// The task, its node and action, and why it failed.
    #[schema(value_type = Object)]
    details: Value,
    /// When it was intended, nanoseconds since 1970 UTC.
    intended_ns: i64,
    /// When it was done; null: not yet.
    done_ns: Option<i64>,
}

/// A result of a task.
#[derive(Serialize, ToSchema)]
#[schema(as = StoredResult)]
pub(crate) struct ResultDocument {
    /// Its number among all results.
    number: u64,
    /// Its run.
    #[schema(value_type = String)]
    run: RunId,
    /// Number of the task in its run, from 0.
    step: u32,
    /// Number of the attempt, from 1.
    attempt: u32,
    /// The action, such as `photo`.
    kind: String,
    /// BLAKE3 of its most important file; null: it has none.
    blob: Option<String>,
    /// The report of the action, where the robot was, and the revisions of the objects.
    #[schema(value_type = Object)]
    details: Value,
    /// How its photo differs from an earlier one: `before` is the number of the result with that one, and `outcome` what was found. Null: it was not compared, or not yet.
    #[schema(value_type = Option<Object>)]
    comparison: Option<Value>,
    /// When it was stored, nanoseconds since 1970 UTC.
    at_ns: i64,
}

/// A cloud that the robot saw on a run.
#[derive(Deserialize, Serialize, ToSchema)]
#[schema(as = RunCloud)]
pub(crate) struct RunCloudDocument {
    /// Its number in the run, from 1.
    #[serde(default)]
    pub(super) number: u64,
    /// BLAKE3 of its file.
    cloud: String,
    /// Length of its file.
    bytes: u64,
    /// When it was seen, on the robot's clock, nanoseconds.
    robot_time: i64,
    /// The same, nanoseconds since 1970 UTC.
    utc_ns: i64,
    /// `distance` or `task`.
    cause: String,
    /// Number of the task in the run, from 0, of one that was kept because of a task.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    step: Option<u32>,
    /// The map, the pose of the base in it with its covariance, and how far that is to be trusted.
    #[schema(value_type = Object)]
    place: Value,
    /// The sensor in the base, metres: x, y, z.
    base_from_sensor_m: Vec<f64>,
    /// Points, in the frame of the base.
    points: u32,
}

/// A slot of a schedule that was decided.
#[derive(Serialize, ToSchema)]
#[schema(as = StoredSlot)]
pub(crate) struct SlotDocument {
    /// Its schedule.
    #[schema(value_type = String)]
    schedule: ScheduleId,
    /// When it was due, nanoseconds since 1970 UTC.
    due_ns: i64,
    /// The run that it began; null: it began none.
    #[schema(value_type = Option<String>)]
    run: Option<RunId>,
    /// `run`, `missed`, or why it was skipped: `requested`, `schedule_paused`, `later_slot_runs`, `other_run`, `already_queued`, `queue_full`, `blocked`,
    /// `no_mission`, `same_instant`.
    outcome: String,
    /// The slot by the clock of the site, and the decision; of several that were missed, the first and last one and how many.
    #[schema(value_type = Object)]
    details: Value,
}

/// Details that the core has written as JSON.
fn details(body: &str) -> Value {
    serde_json::from_str(body).unwrap_or(Value::Null)
}

pub(super) fn run_document(stored: StoredRun) -> RunDocument {
    let StoredRun { run, mission, state, is_ended, body, began, changed } = stored;
    let (asked_ns, changed_ns) = (began.nanos(), changed.nanos());
    RunDocument { run, mission, state, is_ended, details: details(&body), asked_ns, changed_ns }
}

pub(super) fn step_document(stored: StoredStep) -> StepDocument {
    let StoredStep { step, attempt, state, body, intended, done } = stored;
    let (intended_ns, done_ns) = (intended.nanos(), done.map(vocab::Stamp::nanos));
    StepDocument { step, attempt, state, details: details(&body), intended_ns, done_ns }
}

pub(super) fn result_document(stored: StoredResult) -> ResultDocument {
    let StoredResult { number, run, step, attempt, kind, blob, body, comparison, at } = stored;
    let blob = blob.map(|hash| hash.iter().map(|byte| format!("{byte:02x}")).collect());
    let comparison = comparison.as_deref().map(details);
    let (details, at_ns) = (details(&body), at.nanos());
    ResultDocument { number, run, step, attempt, kind, blob, details, comparison, at_ns }
}

pub(super) fn slot_document(stored: StoredSlot) -> SlotDocument {
    let StoredSlot { schedule, due, run, outcome, body } = stored;
    SlotDocument { schedule, due_ns: due.nanos(), run, outcome, details: details(&body) }
}
