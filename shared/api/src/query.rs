//! Questions about what is stored. Answers are pages of bounded length.

use serde::{Deserialize, Serialize};
use site_model::{InspectionPointId, MissionId, Object, ObjectId, Revision, RunId, RunState, ScheduleId};
use vocab::Stamp;

/// Entries of one page at most.
pub const MAX_PAGE: u32 = 100;
/// Bytes of one page of objects, about.
pub const MAX_PAGE_BYTES: usize = 1 << 20;

/// A question. `limit` is the number of entries wanted, [`MAX_PAGE`] at most.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Query {
    /// The earlier and present revisions of an object, the newest first.
    Revisions {
        /// Which object.
        object: ObjectId,
        /// Only those before this one.
        before: Option<Revision>,
        /// How many.
        limit: u32,
    },
    /// Runs of missions, the newest first.
    Runs {
        /// Which of them.
        filter: RunFilter,
        /// Only those that were asked for before this one.
        before: Option<RunId>,
        /// How many.
        limit: u32,
    },
    /// One run; the answer is [`QueryReply::Runs`].
    Run(RunId),
    /// Attempts of the steps of a run, in their order.
    Steps {
        /// Which run.
        run: RunId,
        /// Only those after this step and attempt.
        after: Option<(u32, u32)>,
        /// How many.
        limit: u32,
    },
    /// Results of a run, in the order in which they were stored.
    Results {
        /// Which run.
        run: RunId,
        /// Only those after this number.
        after: Option<u64>,
        /// How many.
        limit: u32,
    },
    /// Results of all runs at an inspection point, the newest first; the answer is [`QueryReply::Results`].
    PointResults {
        /// Which point.
        point: InspectionPointId,
        /// Only those before this number.
        before: Option<u64>,
        /// How many.
        limit: u32,
    },
    /// How the pictures of two results of one inspection point are aligned, and what has changed. They are compared now, unless they were before.
    PictureComparison {
        /// Number of the result with the earlier picture.
        before: u64,
        /// Number of the result with the later one.
        after: u64,
    },
    /// Slots of all schedules that were decided, those due last first.
    Slots {
        /// Only those due before this instant, or then and of a schedule with a smaller id.
        before: Option<(Stamp, ScheduleId)>,
        /// How many.
        limit: u32,
    },
    /// Entries of the audit log, the newest first.
    Audit {
        /// Only those before this number.
        before: Option<u64>,
        /// Only those with this text in the account, the address, the command or the outcome, in any case; empty: all.
        containing: String,
        /// How many.
        limit: u32,
    },
}

/// Which runs are wanted. Without any of these: all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunFilter {
    /// Of this mission.
    pub mission: Option<MissionId>,
    /// In this state.
    pub state: Option<RunState>,
    /// Asked for at this instant or later, by calendar time.
    pub from: Option<Stamp>,
    /// Asked for before this instant.
    pub to: Option<Stamp>,
}

/// The answer to a [`Query`], of the same kind. Empty: there is nothing, or nothing more.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "as for the questions")]
pub enum QueryReply {
    Revisions(Vec<StoredRevision>),
    Runs(Vec<StoredRun>),
    Steps(Vec<StoredStep>),
    Results(Vec<StoredResult>),
    /// A `site_model::PictureComparison` as JSON; none: the two results are no photos of one inspection point.
    PictureComparison(Option<String>),
    Slots(Vec<StoredSlot>),
    Audit(Vec<StoredAudit>),
}

/// An entry of the audit log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoredAudit {
    /// Its number. There are no gaps.
    pub number: u64,
    /// When it was written, by calendar time.
    pub at: Stamp,
    /// Who and from where: a `messages::Principal` with an address as JSON; none: the platform itself.
    pub origin: Option<String>,
    /// What was asked.
    pub command: String,
    /// What became of it.
    pub outcome: String,
}

/// A state of an object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredRevision {
    /// Its revision.
    pub revision: Revision,
    /// The object; none: it was removed.
    pub object: Option<Object>,
    /// Who made it, a `messages::Principal` as JSON; none: the robot itself.
    pub author: Option<String>,
    /// When, by calendar time.
    pub at: Stamp,
}

/// A run of a mission.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredRun {
    /// Which.
    pub run: RunId,
    /// Of which mission.
    pub mission: MissionId,
    /// Its state.
    pub state: String,
    /// Whether it has ended.
    pub is_ended: bool,
    /// More of it as JSON.
    pub body: String,
    /// When it was stored first, by calendar time.
    pub began: Stamp,
    /// When it was stored last.
    pub changed: Stamp,
}

/// An attempt of a step.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoredStep {
    /// Number of the step in its run, from 0.
    pub step: u32,
    /// Number of the attempt, from 0.
    pub attempt: u32,
    /// Its state.
    pub state: String,
    /// More of it as JSON.
    pub body: String,
    /// When it was intended, by calendar time.
    pub intended: Stamp,
    /// When it was done; none: it is not.
    pub done: Option<Stamp>,
}

/// A result of a step.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoredResult {
    /// Its number, by which pages are asked for.
    pub number: u64,
    /// The run.
    pub run: RunId,
    /// Number of the step in its run.
    pub step: u32,
    /// Number of the attempt.
    pub attempt: u32,
    /// What it is, such as `photo`.
    pub kind: String,
    /// BLAKE3 of the file with its content, if it has one.
    pub blob: Option<[u8; 32]>,
    /// More of it as JSON.
    pub body: String,
    /// How its picture differs from an earlier one, a `site_model::PictureComparison` as JSON; none: it was not compared, or not yet.
    pub comparison: Option<String>,
    /// When, by calendar time.
    pub at: Stamp,
}

impl StoredResult {
    /// Greatest number of results that are kept for a client that connects later, the newest.
    pub const MAX_KEPT: usize = 64;
}

/// A slot of a schedule that was decided.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StoredSlot {
    /// Of which schedule.
    pub schedule: ScheduleId,
    /// When it was due, by calendar time.
    pub due: Stamp,
    /// The run that it began, if it began one.
    pub run: Option<RunId>,
    /// What became of it: `run`, `missed`, or why it was skipped.
    pub outcome: String,
    /// More of it as JSON.
    pub body: String,
}
