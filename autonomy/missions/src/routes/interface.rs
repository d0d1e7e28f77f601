//! What enters and leaves the route executor.

use crate::graph::{GraphPlace, RouteGraph};
use crate::runs::RouteGoalResult;
use site_model::{
    ActionRequest, DockId, EdgeBlock, EdgeId, LocalTime, PoseTolerance, ReachFailure, RouteActionPlace, Site,
};
use vocab::{ActionCallId, GoalId, LegId, Pose, Span};

/// What the executor sees at each update.
#[derive(Clone, Copy, Debug)]
pub struct RouteView<'a> {
    /// The site on which routes are planned.
    pub site: &'a Site,
    /// The newest site, whose zones and holds count now.
    pub newest: &'a Site,
    /// The time of day at the site, by which zones hold; none while it is not known.
    pub time_of_day: Option<LocalTime>,
    /// Its graph, with the blocks and times that hold now.
    pub graph: &'a RouteGraph,
    /// The base in the map; none before the robot is localised.
    pub map_from_base: Option<Pose>,
    /// Where that is on the graph.
    pub place: GraphPlace,
    /// The dock in which the robot is charged.
    pub docked: Option<DockId>,
}

/// A walk that the executive is to do: one leg of the goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LegWalk {
    /// The base at its end.
    pub map_from_goal: Pose,
    /// Which poses count as reached; none: the robot passes by.
    pub tolerance: Option<PoseTolerance>,
    /// Greatest speed, m/s; none: that of the robot.
    pub max_speed_m_s: Option<f64>,
    /// How it goes.
    pub kind: LegKind,
}

/// How a walk goes to its pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LegKind {
    /// On a path round obstacles.
    Path,
    /// Straight and in any direction, as out of a dock.
    Straight,
    /// Into the dock that the scans show near the pose.
    OntoDock {
        /// Whether the robot walks in forward. Otherwise it walks in backward.
        is_facing: bool,
    },
}

/// How a walk ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LegResult {
    /// It reached its pose.
    Reached,
    /// It did not.
    Failed(ReachFailure),
}

/// Something that was tried for a goal between its walks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RouteAttempt {
    /// The robot stood for this time before an edge that was blocked.
    WaitedForEdge(Span),
    /// The robot stood for this time because its place was not known.
    WaitedForPlace(Span),
    /// An attempt to be charged in a dock.
    Docking,
}

/// An effect of the executor.
#[derive(Clone, Debug, PartialEq)]
pub enum RouteEffect {
    /// Begin a walk. It ends with [`super::RouteExecutor::end_leg`], unless it is cancelled.
    Walk(LegId, LegWalk),
    /// End a walk. Its result is not waited for.
    CancelWalk(LegId),
    /// Something was tried in vain, or waited for.
    Tried(RouteAttempt),
    /// A goal has ended.
    Ended(GoalId, RouteGoalResult),
    /// An edge could not be walked: it is not used for a while.
    Block(EdgeBlock),
    /// An edge that could not be walked before was walked: its record is removed.
    Unblock(EdgeId),
    /// An edge was walked.
    Traversed(EdgeId, Span),
    /// Call an action of an edge or a zone. It ends with [`super::RouteExecutor::end_action`], also when it is cancelled.
    CallAction(ActionCallId, RouteActionPlace, ActionRequest),
    /// Cancel a call. Its result is not waited for.
    CancelAction(ActionCallId),
    /// An action of an edge or a zone has failed, and the robot goes on without it: its name and why, a sentence. People are told.
    ActionFailed(String, String),
}
