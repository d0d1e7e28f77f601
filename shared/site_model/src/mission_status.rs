//! What people are shown of missions now: runs that have not ended, the route, and where the robot is on the graph. Plain data, published whole on every change.

use crate::{
    DockId, EdgeId, MissionId, MonitorId, NodeId, RouteActionPlace, RunCause, RunId, RunState, TaskFailure,
    TaskId, TaskState, Utc,
};
use serde::{Deserialize, Serialize};
use vocab::{GoalId, Stamp};

/// Runs of [`MissionStatus::ended`] at most.
pub const MAX_ENDED_RUNS: usize = 16;

/// State of all missions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MissionStatus {
    /// Runs that have not ended: the active one, those that are suspended, then the queue in the order in which they begin.
    pub runs: Vec<RunStatus>,
    /// Runs that have ended lately, the newest last. The ledger has all.
    pub ended: Vec<EndedRun>,
    /// The monitor that keeps missions from beginning, if one does.
    pub blocked_by: Option<MonitorId>,
    /// Monitors whose condition holds.
    pub monitors: Vec<MonitorId>,
}

/// A run that has not ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunStatus {
    /// Its id.
    pub run: RunId,
    /// Its mission.
    pub mission: MissionId,
    /// What led to it.
    pub cause: RunCause,
    /// Its state.
    pub state: RunState,
    /// Its outcome, once that is decided and the robot is on its way to where the run ends.
    pub outcome: Option<RunState>,
    /// When it began, by the calendar clock; none while it is queued, or if the time was not known.
    pub began: Option<Utc>,
    /// Its tasks in the order of the plan; none while it is queued.
    pub tasks: Vec<TaskStatus>,
    /// The task about which a person is asked.
    pub question: Option<TaskId>,
}

/// A task of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TaskStatus {
    /// The task of the mission.
    pub task: TaskId,
    /// Where it is done; none if the site has no such place.
    pub node: Option<NodeId>,
    /// Name of the action; none: the place is only visited.
    pub action: Option<String>,
    /// Its state.
    pub state: TaskState,
    /// The present or last attempt, from 1; 0 before the first.
    pub attempt: u32,
    /// Why the last attempt failed, if it did.
    pub failure: Option<TaskFailure>,
}

/// A run that has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct EndedRun {
    /// Its id.
    pub run: RunId,
    /// Its mission.
    pub mission: MissionId,
    /// Its outcome.
    pub outcome: RunState,
}

/// Where the robot is on the topological map, and the route that it follows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RouteStatus {
    /// The node that the robot is at.
    pub at: Option<NodeId>,
    /// The nearest node on its floor.
    pub nearest: Option<NodeId>,
    /// The edge that it is on, if it is at no node.
    pub on: Option<EdgeId>,
    /// The dock in which it is charged.
    pub docked: Option<DockId>,
    /// The route, if it follows one.
    pub route: Option<RouteProgress>,
}

/// A route that the robot follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RouteProgress {
    /// The goal that it belongs to.
    pub goal: GoalId,
    /// The node at its end.
    pub target: NodeId,
    /// Edges that are left, the present one first.
    pub edges: Vec<EdgeId>,
    /// Expected time from the beginning of the present edge, seconds.
    pub remaining_s: f64,
    /// Length from the beginning of the present edge, metres.
    pub remaining_m: f64,
    /// Why the robot stands, if it waits for something.
    pub waits_for: Option<RouteWait>,
}

/// What a robot on a route waits for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RouteWait {
    /// Its place in the map is not known, as just after a start.
    Place,
    /// There is no route but over edges that are blocked for a short time.
    Block {
        /// When the first of them is tried again, robot's clock.
        until: Stamp,
    },
    /// The edge could not be walked, and its fail policy says to wait.
    Retry {
        /// The edge.
        edge: EdgeId,
        /// When it is tried again, robot's clock.
        until: Stamp,
    },
    /// The next edge is of a group that somebody else holds.
    Hold {
        /// The edge.
        edge: EdgeId,
        /// The group.
        group: String,
        /// Who holds it.
        holder: String,
    },
    /// An action at the beginning or the end of an edge.
    Action(RouteActionPlace),
    /// The robot stands on the dock, and the charging current does not flow yet.
    Charge,
}
