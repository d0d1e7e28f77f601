//! Runs as the robot has stored them: lists, attempts of tasks and results, in the form in which it serves them over HTTP.

use serde::Deserialize;
use serde_json::Value;
use site_model::{ActionReport, MissionId, NodeId, RunCause, RunId, RunState, TaskId, TaskState, Utc};

/// A page of a list.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct StoredPage<T> {
    /// Its entries.
    pub items: Vec<T>,
    /// Where the next page begins; none: this is the last one.
    #[serde(default)]
    pub next: Option<String>,
}

/// A run in the list of all.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct StoredRun {
    /// Its id.
    pub run: RunId,
    /// Its mission.
    pub mission: MissionId,
    /// Its state.
    pub state: RunState,
    /// Whether it has ended.
    pub is_ended: bool,
    /// What led to it, and when it began; none if that was not stored.
    #[serde(default)]
    pub details: Option<StoredRunDetails>,
    /// When it was asked for.
    #[serde(rename = "asked_ns")]
    pub asked: Utc,
    /// When it changed last.
    #[serde(rename = "changed_ns")]
    pub changed: Utc,
}

/// More of a run.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct StoredRunDetails {
    /// What led to it.
    pub cause: RunCause,
    /// When it began; none if the time was not known.
    #[serde(default)]
    pub began: Option<Utc>,
}

/// An attempt of a task.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct StoredAttempt {
    /// Number of the task in its run, from 0.
    pub step: u32,
    /// Counts from 1.
    pub attempt: u32,
    /// Its state.
    pub state: TaskState,
    /// The task, its place and its action.
    pub details: StoredAttemptDetails,
    /// When it was intended.
    #[serde(rename = "intended_ns")]
    pub intended: Utc,
    /// When it was done; none: it was not.
    #[serde(default, rename = "done_ns")]
    pub done: Option<Utc>,
}

/// More of an attempt.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct StoredAttemptDetails {
    /// The task.
    pub task: TaskId,
    /// Where.
    #[serde(default)]
    pub node: Option<NodeId>,
    /// Name of the action; none: the place is only visited.
    #[serde(default)]
    pub action: Option<String>,
}

/// A result of a task.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct StoredResult {
    /// Number of the task in its run, from 0.
    pub step: u32,
    /// Counts from 1.
    pub attempt: u32,
    /// What was gathered.
    pub details: StoredResultDetails,
}

/// More of a result.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct StoredResultDetails {
    /// Report of the action: a [`ActionReport`], or whatever a program of somebody else's answers.
    #[serde(default)]
    pub value: Value,
}

impl StoredResult {
    /// The report of an action that comes with the platform.
    pub fn report(&self) -> Option<ActionReport> {
        serde_json::from_value(self.details.value.clone()).ok()
    }
}

/// All that is stored of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunContent {
    /// Attempts of its tasks, in their order.
    pub attempts: Vec<StoredAttempt>,
    /// Results.
    pub results: Vec<StoredResult>,
}

impl RunContent {
    /// The last attempt of each task.
    pub fn last_attempts(&self) -> impl Iterator<Item = &StoredAttempt> {
        self.attempts.iter().enumerate().filter_map(|(index, attempt)| {
            let is_last = self.attempts.get(index + 1).is_none_or(|next| next.step != attempt.step);
            is_last.then_some(attempt)
        })
    }

    /// The results of an attempt.
    pub fn results_of(&self, attempt: &StoredAttempt) -> impl Iterator<Item = &StoredResult> {
        let (step, number) = (attempt.step, attempt.attempt);
        self.results.iter().filter(move |result| result.step == step && result.attempt == number)
    }
}
