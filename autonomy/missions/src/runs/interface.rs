//! What enters and leaves the mission runner.

use crate::graph::GraphPlace;
use site_model::{
    ActionRequest, DockId, EdgeId, MissionCommand, MissionEvent, MissionId, MonitorId, NodeId, ReachFailure,
    RouteActionPlace, RunId, RunState, ScheduleId, Site, TaskId, Utc,
};
use std::collections::BTreeMap;
use std::sync::Arc;
use vocab::{ActionCallId, CommandId, GoalId, Span};

/// An input of the runner.
#[derive(Clone, Debug)]
pub enum MissionInput {
    /// Time has passed.
    Tick,
    /// A command of a person or program.
    Command(MissionCommand),
    /// A goal that the runner requested has ended.
    Goal {
        /// Which.
        goal: GoalId,
        /// How.
        result: RouteGoalResult,
    },
    /// An action that the runner called has ended.
    Action {
        /// Which call.
        call: ActionCallId,
        /// How.
        result: ActionResult,
    },
    /// The commit of this number, and those before it, are durable.
    Committed(u64),
    /// The calendar time, once a second.
    Clock {
        /// The time.
        utc: Utc,
        /// Whether the clock follows a time server. Schedules wait while it does not.
        is_synchronised: bool,
    },
    /// Where the robot is and whether it can move.
    Situation(MissionSituation),
    /// A value of a signal that monitors watch, such as `battery.charge` (0 to 1).
    Signal {
        /// Name of the signal.
        name: String,
        /// Its value.
        value: f64,
    },
    /// The site, after every edit. Runs that have begun keep their plan.
    Site(Arc<Site>),
    /// The actions that are registered now, by name.
    Actions(BTreeMap<String, ActionInfo>),
    /// The robot walked along an edge.
    Traversed {
        /// Which.
        edge: EdgeId,
        /// How long it took.
        duration: Span,
    },
    /// The route of a goal needs an action of an edge or a zone. The answer is [`MissionEffect::CallRouteAction`] or [`MissionEffect::RefuseRouteAction`]; none if the goal
    /// has ended.
    RouteActionWanted {
        /// The goal.
        goal: GoalId,
        /// The call that is to be made. No other one has its id.
        call: ActionCallId,
        /// What the action belongs to.
        place: RouteActionPlace,
        /// What is to be called.
        request: ActionRequest,
    },
    /// An action on the way has ended.
    RouteActionEnded {
        /// Which call.
        call: ActionCallId,
        /// How.
        result: ActionResult,
    },
    /// An action on the way is not wanted any more. It still ends with [`Self::RouteActionEnded`], if it was called.
    RouteActionCancelled(ActionCallId),
}

/// How a goal ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RouteGoalResult {
    /// It was reached.
    Reached,
    /// It was not.
    Failed(ReachFailure),
    /// Motion was stopped, or somebody drives or asked for another goal.
    MotionTaken,
    /// The runner cancelled it.
    Cancelled,
}

/// How an action ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ActionResult {
    /// It was done, with its result as JSON. What it gathered is on the disk.
    Succeeded(Option<String>),
    /// It failed, with a sentence for people.
    Failed(String),
    /// It was cancelled.
    Cancelled,
    /// The program that offers it is gone.
    Unavailable,
}

/// What is known of a registered action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ActionInfo {
    /// Whether it can be repeated without harm.
    pub is_idempotent: bool,
    /// How long it is expected to take.
    pub expected: Span,
}

/// Where the robot is and whether it can move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MissionSituation {
    /// Its place on the graph.
    pub place: GraphPlace,
    /// Whether its pose in the site's map is known.
    pub is_localised: bool,
    /// Whether goals can begin: motion is not stopped, and nobody drives.
    pub can_move: bool,
    /// The dock in which it is charged.
    pub docked: Option<DockId>,
}

/// An effect of the runner.
#[derive(Clone, Debug, PartialEq)]
pub enum MissionEffect {
    /// Write these events to durable storage, in this order, then answer with [`MissionInput::Committed`].
    Commit {
        /// Counts from 0 in each runner.
        number: u64,
        /// The events.
        events: Vec<MissionEvent>,
    },
    /// Begin a goal. It ends with [`MissionInput::Goal`].
    RequestGoal {
        /// Its id, which no other goal has.
        goal: GoalId,
        /// What is to be reached.
        request: GoalRequest,
    },
    /// End a goal.
    CancelGoal(GoalId),
    /// Call an action. It ends with [`MissionInput::Action`].
    CallAction {
        /// Its id, which no other call has.
        call: ActionCallId,
        /// The run.
        run: RunId,
        /// The task.
        task: TaskId,
        /// What is called.
        request: ActionRequest,
    },
    /// Cancel a call. It still ends with [`MissionInput::Action`], or [`MissionInput::RouteActionEnded`].
    CancelAction(ActionCallId),
    /// Call an action on the way. It ends with [`MissionInput::RouteActionEnded`].
    CallRouteAction {
        /// The call.
        call: ActionCallId,
        /// What is called.
        request: ActionRequest,
    },
    /// An action on the way is not called: it may have been done already, and must not be repeated.
    RefuseRouteAction {
        /// The call.
        call: ActionCallId,
        /// Why, a sentence.
        reason: String,
    },
    /// Answer a command.
    Answer {
        /// Which.
        command: CommandId,
        /// None when it was accepted; else one sentence: why not and what to do.
        refused: Option<String>,
    },
    /// Tell people.
    Notice(MissionNotice),
}

/// What is to be reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoalRequest {
    /// A node, over the edges of the graph.
    Route(NodeId),
    /// Charging in a dock.
    Dock(DockId),
    /// Out of the dock.
    Undock,
}

/// Something that people are told. `texts.rs` has the sentences.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissionNotice {
    /// A run has ended.
    RunEnded {
        /// Of which mission.
        mission: MissionId,
        /// How.
        outcome: RunState,
        /// Tasks that succeeded.
        succeeded: usize,
        /// All tasks of its plan; none if it never began.
        tasks: usize,
    },
    /// A person is asked what becomes of a task.
    Question(RunId, TaskId),
    /// No dock was reached.
    NoDockReached,
    /// Schedules wait because the clock is not synchronised.
    ClockNotSynchronised,
    /// The rule or time zone of a schedule cannot be used.
    ScheduleUnusable(ScheduleId),
    /// The condition of a monitor began to hold.
    MonitorHolds(MonitorId),
    /// The site has changed and lacks something that the run needs; the run keeps its plan.
    PlanKept(RunId),
    /// An action did not end after it was cancelled.
    ActionSilent(ActionCallId),
}
