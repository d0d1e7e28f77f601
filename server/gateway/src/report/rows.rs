//! Runs, attempts and results as the core has stored them, with what a report shows of each. What is not there, or cannot be understood, is left out.

use super::texts;
use crate::runs::{CoreQueries, action_report, for_each_step, stored_json};
use api::{StoredResult, StoredRun, StoredStep};
use serde::de::DeserializeOwned;
use serde_json::Value;
use site_model::{
    ActionReport, InspectionPointId, MissionId, NodeId, RouteActionPlace, RunCause, RunId, RunState,
    TaskFailure, TaskId, TaskState, TaskStep, Utc,
};
use std::io;
use vocab::legible;

/// A run.
pub(super) struct RunRow {
    pub(super) run: RunId,
    pub(super) mission: MissionId,
    /// Its state; none: one that this program does not know.
    pub(super) state: Option<RunState>,
    pub(super) is_ended: bool,
    pub(super) cause: Option<RunCause>,
    /// When it was asked for.
    pub(super) asked: Utc,
    /// When it began; none: it has not, or the time was not known.
    pub(super) began: Option<Utc>,
    pub(super) ended: Option<Utc>,
    /// Number of its tasks; 0 before it began.
    pub(super) tasks: u32,
}

impl RunRow {
    pub(super) fn of(stored: &StoredRun) -> Self {
        let details = stored_json(&stored.body);
        Self {
            run: stored.run,
            mission: stored.mission,
            state: state(&stored.state),
            is_ended: stored.is_ended,
            cause: field(&details, "cause"),
            asked: Utc(stored.began.nanos()),
            began: field(&details, "began"),
            ended: stored.is_ended.then(|| Utc(stored.changed.nanos())),
            tasks: field(&details, "tasks").unwrap_or(0),
        }
    }

    /// When it began, or else when it was asked for.
    pub(super) fn at(&self) -> Utc {
        self.began.unwrap_or(self.asked)
    }
}

/// An attempt of a task, or an action of an edge or a zone on the way.
pub(super) struct Attempt {
    /// Number of the task in its run, from 0. Actions on the way follow after the tasks.
    pub(super) step: u32,
    /// Counts from 1.
    pub(super) attempt: u32,
    /// Its state; none: one that this program does not know.
    pub(super) state: Option<TaskState>,
    pub(super) task: Option<TaskId>,
    pub(super) node: Option<NodeId>,
    /// What an action on the way belongs to; none: a task.
    pub(super) place: Option<RouteActionPlace>,
    /// Name of the action; none: the place is only visited.
    pub(super) action: Option<String>,
    pub(super) failure: Option<TaskFailure>,
    pub(super) began: Utc,
    pub(super) ended: Option<Utc>,
}

impl Attempt {
    pub(super) fn of(stored: &StoredStep) -> Self {
        let details = stored_json(&stored.body);
        Self {
            step: stored.step,
            attempt: stored.attempt,
            state: state(&stored.state),
            task: field(&details, "task"),
            node: field(&details, "node"),
            place: field(&details, "place"),
            action: field(&details, "action"),
            failure: field::<TaskStep>(&details, "step").and_then(|step| step.failure().cloned()),
            began: Utc(stored.intended.nanos()),
            ended: stored.done.map(|done| Utc(done.nanos())),
        }
    }

    /// Whether it belongs to a task, not to the way.
    pub(super) fn is_of_task(&self) -> bool {
        self.place.is_none()
    }

    /// Whether somebody should look at it: it has failed or was left out.
    pub(super) fn is_failed_or_skipped(&self) -> bool {
        matches!(self.state, Some(TaskState::Failed | TaskState::Skipped))
    }

    /// Whole seconds that it took; none: it was not done.
    pub(super) fn took_s(&self) -> Option<i64> {
        self.ended.map(|ended| seconds_between(self.began, ended))
    }
}

/// Why the last of these attempts of one task was not done; none if it was.
pub(super) fn reason(attempts: &[Attempt]) -> Option<String> {
    let last = attempts.last()?;
    let of = |attempt: &Attempt| {
        let failure = attempt.failure.as_ref().map(missions::task_failure);
        failure.map(|sentence| legible(&sentence, texts::MAX_SENTENCE_CHARS))
    };
    match last.state {
        Some(TaskState::Skipped) => {
            let known = attempts.iter().rev().find_map(of);
            Some(known.map_or_else(
                || texts::SKIPPED_BY.to_owned(),
                |known| format!("{known} {}", texts::SKIPPED_BY),
            ))
        }
        _ => of(last),
    }
}

/// A result of an attempt.
pub(super) struct ResultRow {
    pub(super) step: u32,
    pub(super) at: Utc,
    pub(super) point: Option<InspectionPointId>,
    pub(super) node: Option<NodeId>,
    pub(super) content: ResultContent,
}

/// What an action has answered.
pub(super) enum ResultContent {
    /// A report in the form of all actions that come with the platform.
    Report(ActionReport),
    /// The answer of another program's action.
    Other(String),
    Nothing,
}

impl ResultRow {
    pub(super) fn of(stored: &StoredResult) -> Self {
        let details = stored_json(&stored.body);
        let content = match (action_report(&details), details.get("value")) {
            (Some(report), _) => ResultContent::Report(report),
            (None, None | Some(Value::Null)) => ResultContent::Nothing,
            (None, Some(Value::String(text))) => {
                ResultContent::Other(legible(text, texts::MAX_SENTENCE_CHARS))
            }
            (None, Some(value)) => {
                ResultContent::Other(legible(&value.to_string(), texts::MAX_SENTENCE_CHARS))
            }
        };
        Self {
            step: stored.step,
            at: Utc(stored.at.nanos()),
            point: field(&details, "inspection_point"),
            node: field(&details, "node"),
            content,
        }
    }
}

/// Hands all attempts of each task to `take`, in the order of the tasks. Memory holds a page of attempts, and those of one task.
///
/// # Errors
/// When the core or `take` fails.
pub(super) fn for_each_task(
    core: &dyn CoreQueries,
    run: RunId,
    mut take: impl FnMut(&[Attempt]) -> io::Result<()>,
) -> io::Result<()> {
    let mut attempts: Vec<Attempt> = Vec::new();
    for_each_step(core, run, |stored| {
        if attempts.last().is_some_and(|last| last.step != stored.step) {
            take(&attempts)?;
            attempts.clear();
        }
        attempts.push(Attempt::of(&stored));
        Ok(())
    })?;
    if attempts.is_empty() { Ok(()) } else { take(&attempts) }
}

/// Whole seconds between two instants.
pub(super) fn seconds_between(from: Utc, to: Utc) -> i64 {
    to.0.saturating_sub(from.0) / 1_000_000_000
}

/// A field of a JSON object.
fn field<T: DeserializeOwned>(details: &Value, name: &str) -> Option<T> {
    serde_json::from_value(details.get(name)?.clone()).ok()
}

/// A state by its name.
fn state<T: DeserializeOwned>(name: &str) -> Option<T> {
    serde_json::from_value(Value::String(name.to_owned())).ok()
}
