//! Events of runs, schedules and monitors. They are durable before the robot acts on them, and all state is rebuilt from them.

use crate::{
    DockId, EdgeId, EndPlace, LocalDateTime, MissionId, MonitorId, QuestionAnswer, Revision, RouteActionStep,
    RunCause, RunId, RunPlan, RunState, ScheduleId, TaskId, TaskState, Utc,
};
use serde::{Deserialize, Serialize};
use vocab::{ActionCallId, CommandId, GoalId};

/// An event.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissionEvent {
    /// When, by the calendar clock; none if it was not known.
    pub utc: Option<Utc>,
    /// The command that led to it, if one did.
    pub command: Option<CommandId>,
    /// What happened.
    pub kind: MissionEventKind,
}

/// What happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MissionEventKind {
    /// A run was asked for. It is queued.
    RunQueued {
        /// Which.
        run: RunId,
        /// Of which mission.
        mission: MissionId,
        /// What led to it.
        cause: RunCause,
        /// Runs of greater priority begin first.
        priority: i32,
    },
    /// A queued run began, with this plan.
    RunBegan {
        /// Which.
        run: RunId,
        /// What it does.
        plan: RunPlan,
    },
    /// A run is in another state, without an end in sight.
    RunChanged {
        /// Which.
        run: RunId,
        /// Its state.
        state: RunState,
        /// Why.
        reason: RunChangeReason,
    },
    /// The outcome of a run is decided.
    RunEnding {
        /// Which.
        run: RunId,
        /// Its outcome.
        outcome: RunState,
        /// Where the robot goes first.
        place: EndPlace,
    },
    /// A run sets out to where it ends.
    RunSetOutToEnd {
        /// Which.
        run: RunId,
        /// Goal of the executive.
        goal: GoalId,
        /// The dock, if it goes to one.
        dock: Option<DockId>,
    },
    /// A run has ended.
    RunEnded {
        /// Which.
        run: RunId,
        /// Its outcome.
        outcome: RunState,
    },
    /// A task is one step further. The last step that is an outcome is the result of record; earlier ones are kept.
    Task {
        /// The run.
        run: RunId,
        /// The task.
        task: TaskId,
        /// Counts from 1; a redo and every further try is a new attempt.
        attempt: u32,
        /// Its step.
        step: TaskStep,
    },
    /// A question was answered, or its time was over.
    QuestionAnswered {
        /// The run.
        run: RunId,
        /// The task.
        task: TaskId,
        /// The answer.
        answer: QuestionAnswer,
        /// Whether it is the default, because nobody answered in time.
        is_default: bool,
    },
    /// A schedule is followed from now on. Earlier slots of it do not count as missed.
    ScheduleAdopted {
        /// Which.
        schedule: ScheduleId,
        /// In this state.
        revision: Revision,
        /// Since when.
        since: Utc,
    },
    /// It was decided what becomes of a slot. This happens once for each slot.
    SlotDecided {
        /// The schedule.
        schedule: ScheduleId,
        /// The slot, in the site's time zone.
        slot: LocalDateTime,
        /// When it was due.
        due: Utc,
        /// The decision.
        decision: SlotDecision,
    },
    /// Many slots were missed for long. Recorded as one.
    SlotsMissed {
        /// The schedule.
        schedule: ScheduleId,
        /// The first slot.
        first: LocalDateTime,
        /// The last one.
        last: LocalDateTime,
        /// When the last one was due.
        last_due: Utc,
        /// How many.
        count: u32,
    },
    /// The condition of a monitor began to hold, or ended.
    MonitorChanged {
        /// Which.
        monitor: MonitorId,
        /// Whether it holds.
        holds: bool,
    },
    /// A monitor sends the robot to a dock.
    DockingBegan {
        /// Counts from 0 over all of these events.
        number: u64,
        /// The dock.
        dock: DockId,
        /// Goal of the executive.
        goal: GoalId,
    },
    /// An action on the way of a run is one step further.
    RouteAction {
        /// The run.
        run: RunId,
        /// The call.
        call: ActionCallId,
        /// Its step.
        step: RouteActionStep,
    },
}

/// Why the state of a run changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunChangeReason {
    /// A person or program asked for it.
    Requested,
    /// Motion was stopped, or the robot was driven by hand.
    MotionTaken,
    /// The condition of a monitor holds.
    MonitorHolds(MonitorId),
    /// No monitor interrupts any more.
    MonitorsReleased,
    /// The program was restarted.
    ProgramRestarted,
    /// The robot's place is known again.
    PlaceKnown,
}

/// A step of a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskStep {
    /// It waits: for the first time, for a redo, after an interruption or a restart.
    Waits,
    /// The robot is to go to its place. Written before it goes.
    SetsOut {
        /// Goal of the executive.
        goal: GoalId,
    },
    /// Its action is to be called. Written before the call.
    Acts {
        /// The call.
        call: ActionCallId,
    },
    /// The robot was on its way when the run was paused.
    Paused,
    /// An attempt failed. The next one follows at once.
    TriesAgain(TaskFailure),
    /// It failed. It is tried once more after the others.
    TriesLater(TaskFailure),
    /// It failed. A person is asked.
    Asks(TaskFailure),
    /// It was done.
    Succeeded {
        /// Result of the action as JSON, if there was an action.
        result: Option<String>,
    },
    /// It could not be done.
    Failed(TaskFailure),
    /// It was left out.
    Skipped,
    /// The run ended before it was done.
    Cancelled,
}

impl TaskStep {
    /// Why an attempt failed, if it did.
    pub fn failure(&self) -> Option<&TaskFailure> {
        match self {
            Self::TriesAgain(failure)
            | Self::TriesLater(failure)
            | Self::Asks(failure)
            | Self::Failed(failure) => Some(failure),
            _ => None,
        }
    }
}

impl TaskStep {
    /// The state that the task is in afterwards.
    pub fn state(&self) -> TaskState {
        match self {
            Self::Waits => TaskState::Waiting,
            Self::SetsOut { .. } => TaskState::Navigating,
            Self::Acts { .. } => TaskState::Running,
            Self::Paused => TaskState::Paused,
            Self::TriesAgain(_) | Self::TriesLater(_) | Self::Asks(_) => TaskState::Retriable,
            Self::Succeeded { .. } => TaskState::Succeeded,
            Self::Failed(_) => TaskState::Failed,
            Self::Skipped => TaskState::Skipped,
            Self::Cancelled => TaskState::Cancelled,
        }
    }
}

/// Why a task failed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskFailure {
    /// Its place was not reached.
    NotReached(ReachFailure),
    /// Its action failed, with a sentence for people.
    ActionFailed(String),
    /// No such action is registered, or the program that offers it is gone.
    ActionUnavailable,
    /// Its action did not end in its time.
    ActionTimedOut,
    /// Its action was begun, and it is not known how it ended. It is not done twice without a person's word.
    OutcomeUnknown,
    /// On the way to it this action of an edge or a zone was begun, and it is not known how it ended. It is not done twice without a person's word.
    RouteActionUnknown(String),
}

/// Why a place was not reached.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReachFailure {
    /// The site has no such place.
    NoSuchPlace,
    /// No route leads there.
    NoRoute {
        /// Edges that would lead there, and are blocked, disabled or in a keep-out zone.
        closed: Vec<EdgeId>,
    },
    /// No path was free for too long.
    PathBlocked,
    /// The robot's pose in the map was not found.
    PoseNotFound,
    /// The map was replaced.
    MapReplaced,
    /// The robot could not leave its dock.
    NotUndocked,
    /// The robot was not charged after all attempts to dock.
    NotDocked,
    /// The scans showed no dock where the map has it.
    DockNotSeen,
}

/// What becomes of a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SlotDecision {
    /// It runs, or is queued.
    Run(RunId),
    /// It does not run.
    Skipped(SkipReason),
}

/// Why a slot does not run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SkipReason {
    /// A person left this slot out.
    Requested,
    /// The schedule was paused.
    SchedulePaused,
    /// It was noticed too late, as after the robot was switched off.
    Missed,
    /// A later missed slot of the schedule runs instead.
    LaterSlotRuns,
    /// Another run was under way.
    OtherRun(RunId),
    /// A run of this schedule waits already.
    AlreadyQueued(RunId),
    /// The queue was full.
    QueueFull,
    /// A monitor blocked missions for too long.
    Blocked(MonitorId),
    /// The mission does not exist, or cannot be used.
    NoMission,
    /// Another slot of the schedule is due at the same instant, as where clocks go forward.
    SameInstant,
}

impl MissionEventKind {
    /// The run that the event is of, if it is of one.
    pub fn run(&self) -> Option<RunId> {
        match self {
            Self::RunQueued { run, .. }
            | Self::RunBegan { run, .. }
            | Self::RunChanged { run, .. }
            | Self::RunEnding { run, .. }
            | Self::RunSetOutToEnd { run, .. }
            | Self::RunEnded { run, .. }
            | Self::Task { run, .. }
            | Self::QuestionAnswered { run, .. }
            | Self::RouteAction { run, .. } => Some(*run),
            Self::ScheduleAdopted { .. }
            | Self::SlotDecided { .. }
            | Self::SlotsMissed { .. }
            | Self::MonitorChanged { .. }
            | Self::DockingBegan { .. } => None,
        }
    }
}
