//! Runs as the robot has stored them: lists, attempts of tasks and results, in the form in which it serves them over HTTP.

use serde::Deserialize;
use serde_json::Value;
use site_model::{
    ActionReport, InspectionPointId, LocalDateTime, MissionId, NodeId, PictureComparison, RouteActionPlace,
    RunCause, RunId, RunState, ScheduleId, SkipReason, TaskId, TaskState, Utc,
};

/// Which of the stored runs are wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RunQuery {
    /// Of this mission.
    pub mission: Option<MissionId>,
    /// With this outcome.
    pub outcome: Option<RunState>,
    /// Asked for at this instant or later.
    pub from: Option<Utc>,
    /// Asked for before this instant.
    pub to: Option<Utc>,
}

impl RunQuery {
    /// Whether a run that has ended a moment ago is one of them.
    pub fn has_new(&self, mission: MissionId, outcome: RunState) -> bool {
        self.mission.is_none_or(|wanted| wanted == mission)
            && self.outcome.is_none_or(|wanted| wanted == outcome)
            && self.to.is_none()
    }
}

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

/// An attempt of a task, or an action of an edge or a zone on the way.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct StoredAttempt {
    /// Number of the task in its run, from 0. Actions on the way follow after the tasks.
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
    /// The task; of an action on the way the one to which the robot was going. None: it was going to where the run ends.
    #[serde(default)]
    pub task: Option<TaskId>,
    /// Where a task is done.
    #[serde(default)]
    pub node: Option<NodeId>,
    /// What an action on the way belongs to; none: a task.
    #[serde(default)]
    pub place: Option<RouteActionPlace>,
    /// Name of the action; none: the place is only visited.
    #[serde(default)]
    pub action: Option<String>,
}

/// A slot of a schedule that was decided.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct StoredSlot {
    /// Its schedule.
    pub schedule: ScheduleId,
    /// When it was due.
    #[serde(rename = "due_ns")]
    pub due: Utc,
    /// More of it.
    pub details: StoredSlotDetails,
}

/// More of a slot.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct StoredSlotDetails {
    /// The slot; none if several were missed.
    #[serde(default)]
    pub slot: Option<LocalDateTime>,
    /// What became of it.
    #[serde(default)]
    pub decision: Option<site_model::SlotDecision>,
    /// The last one of several that were missed in a row.
    #[serde(default)]
    pub last: Option<LocalDateTime>,
    /// How many were missed.
    #[serde(default)]
    pub count: Option<u64>,
}

impl StoredSlot {
    /// The slot by the clock of the site, if it is known.
    pub fn slot(&self) -> Option<LocalDateTime> {
        self.details.slot.or(self.details.last)
    }

    /// Why it was skipped; none: it has a run.
    pub fn skipped(&self) -> Option<SkipReason> {
        match self.details.decision {
            Some(site_model::SlotDecision::Run(_)) => None,
            Some(site_model::SlotDecision::Skipped(reason)) => Some(reason),
            None => Some(SkipReason::Missed),
        }
    }
}

/// A result of a task.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct StoredResult {
    /// Its number among all results.
    pub number: u64,
    /// When it was stored.
    #[serde(rename = "at_ns")]
    pub at: Utc,
    /// Its run.
    pub run: RunId,
    /// The action, such as `photo`.
    #[serde(default)]
    pub kind: String,
    /// Number of the task in its run, from 0.
    pub step: u32,
    /// Counts from 1.
    pub attempt: u32,
    /// What was gathered.
    pub details: StoredResultDetails,
    /// How its photo differs from an earlier one; none: it was not compared, or not yet.
    #[serde(default)]
    pub comparison: Option<PictureComparison>,
}

/// More of a result.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct StoredResultDetails {
    /// Report of the action: a [`ActionReport`], or whatever a program of somebody else's answers.
    #[serde(default)]
    pub value: Value,
    /// The inspection point of the task, by which results of several runs are compared.
    #[serde(default)]
    pub inspection_point: Option<InspectionPointId>,
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
