//! What the stack wants to be durable: stops of motion, changes of the site, and what becomes of runs of missions.
//!
//! The ledger stores runs, steps and results without understanding them: what else there is to say of them is a `body` of JSON, and [`LEDGER_BODY_VERSION`] is
//! stored beside it. Whoever changes the meaning of a body raises the version.

use crate::{GoalUpdate, StopLatch};
use serde::{Deserialize, Serialize};
use site_model::{MissionEvent, MissionId, Object, ObjectId, RunId, ScheduleId};

/// Version of the bodies of all records.
pub const LEDGER_BODY_VERSION: u32 = 1;

/// An event that must be durable before the stack acts on it. Further kinds are added at the end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum LedgerEvent {
    /// A goal was accepted or has ended. Reserved: nothing commits it yet.
    Goal(GoalUpdate),
    /// Motion was stopped, or `None`: it was allowed again. This takes effect at once; what waits for the commit is the answer to the command.
    StopLatch(Option<StopLatch>),
    /// The robot changes the site, such as by blocking an edge.
    Site(SiteWrite),
    /// A run of a mission began, changed or ended.
    Run(RunRecord),
    /// A step of a run is intended, or done.
    Step(StepRecord),
    /// A step has a result. Its file, if it has one, is on the disk.
    Result(ResultRecord),
    /// A slot of a schedule was used, skipped or missed.
    Firing(FiringRecord),
    /// Something happened in a run, a schedule or a monitor. The state of missions is rebuilt from all of these after a restart.
    Mission(MissionEvent),
}

/// Objects that the robot itself puts and removes, whatever revision they have.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SiteWrite {
    /// Objects as they are from now on.
    pub put: Vec<Object>,
    /// Objects that are removed; one that is not there counts as removed.
    pub removed: Vec<ObjectId>,
}

/// State of a run. It replaces the one before.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Which run.
    pub run: RunId,
    /// Of which mission.
    pub mission: MissionId,
    /// Its state, such as `running`.
    pub state: String,
    /// Whether it has ended. What has not ended goes on after a restart.
    pub is_ended: bool,
    /// More of it as JSON.
    pub body: String,
}

/// State of an attempt of a step. It replaces the one before.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StepRecord {
    /// Which run.
    pub run: RunId,
    /// Number of the step in its run, from 0.
    pub step: u32,
    /// Number of the attempt, from 0.
    pub attempt: u32,
    /// Its state, such as `intended`.
    pub state: String,
    /// Whether it is done, one way or the other.
    pub is_done: bool,
    /// More of it as JSON.
    pub body: String,
}

/// A result of a step. It adds to those before.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ResultRecord {
    /// Which run.
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
}

/// What became of a slot of a schedule. The first record of a slot stays.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FiringRecord {
    /// Which schedule.
    pub schedule: ScheduleId,
    /// When it was due, nanoseconds since 1970-01-01 UTC.
    pub due_utc_ns: i64,
    /// The run that it began, if it began one.
    pub run: Option<RunId>,
    /// What became of it, such as `missed`.
    pub outcome: String,
    /// More of it as JSON.
    pub body: String,
}
