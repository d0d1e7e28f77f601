//! Goals: what the robot is to reach, with one identity and exactly one outcome each. ROS 2 calls this an action.
//!
//! A goal is accepted, runs, and ends once: it succeeded, failed or was cancelled. Every change is published as a [`GoalUpdate`].

use crate::Principal;
use serde::{Deserialize, Serialize};
use site_model::{DockId, NodeId, PoseTolerance};
pub use vocab::GoalFailure;
use vocab::{GoalId, Pose, Span, Stamp, Vec3};

/// What the robot is to reach. Further kinds are added at the end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum GoalKind {
    /// Walk to this point of the map (map frame, metres), round obstacles that are seen on the way.
    WalkTo(Vec3),
    /// Find the robot's pose in the saved map in use: stand and look, then walk a little where nothing else helps.
    Relocalise,
    /// Walk to this pose and stand in it, round obstacles that are seen on the way.
    WalkToPose(PoseGoal),
    /// Go to a node over the edges of the topological map, and stand in its pose.
    GoToNode(NodeId),
    /// Go to a dock and be charged in it.
    GoToDock(DockId),
    /// Leave the dock.
    Undock,
}

/// A pose that is to be reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseGoal {
    /// The base at the goal.
    pub map_from_goal: Pose,
    /// Which poses count as reached. None: the robot passes by, and need not slow down or turn.
    pub tolerance: Option<PoseTolerance>,
    /// Greatest speed, m/s; none: that of the robot.
    pub max_speed_m_s: Option<f64>,
    /// How it goes there.
    pub approach: Approach,
}

/// How the robot goes to a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Approach {
    /// On a path round obstacles, facing where it goes.
    Path,
    /// Straight, slowly and without turning first, in any direction: into and out of a dock, where the dock itself looks like an obstacle.
    Straight,
}

/// State of one goal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GoalUpdate {
    /// Made by whoever asked.
    pub id: GoalId,
    /// What is to be reached.
    pub kind: GoalKind,
    /// Who asked.
    pub by: Principal,
    /// When it was accepted.
    pub accepted: Stamp,
    /// How far it is.
    pub status: GoalStatus,
}

/// How far a goal is. The last three are outcomes: nothing comes after them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum GoalStatus {
    /// It will be executed; nothing has been done yet.
    Accepted,
    /// It is being executed.
    Running(GoalProgress),
    /// It was reached.
    Succeeded(GoalResult),
    /// It was not reached.
    Failed {
        /// Why.
        reason: GoalFailure,
        /// What was tried before it was given up.
        tried: Vec<GoalAttempt>,
    },
    /// Somebody ended it.
    Cancelled {
        /// Who.
        by: Principal,
        /// How.
        cause: CancelCause,
    },
}

impl GoalStatus {
    /// Whether the goal has ended.
    pub fn is_outcome(&self) -> bool {
        matches!(self, Self::Succeeded(_) | Self::Failed { .. } | Self::Cancelled { .. })
    }
}

/// Progress of a running goal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GoalProgress {
    /// Distance along the path to the goal, rounded to 0.1 m; none where there is no path.
    pub remaining_m: Option<f64>,
    /// Why the robot stands, if it waits.
    pub waits_for: Option<WaitReason>,
}

/// What a running goal waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum WaitReason {
    /// The LiDAR sees nothing; the robot does not walk blind.
    Sight,
    /// The path is blocked; people may walk on.
    FreePath,
    /// The pose in the map was lost; the goal goes on once the robot is relocalised.
    Relocalisation,
}

/// Result of a goal that was reached.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GoalResult {
    /// Base in the map at the end.
    pub map_from_base: Pose,
    /// From acceptance to the end.
    pub duration: Span,
}

/// Something that was tried for a goal that failed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum GoalAttempt {
    /// Number of paths that were planned.
    PlannedPaths(u32),
    /// The robot stood for this time before a blocked path.
    WaitedForPath(Span),
    /// The robot searched for its pose in the map for this time.
    SearchedForPose(Span),
    /// Number of paths that the robot walked to see more.
    ExploredPaths(u32),
    /// Number of attempts to be charged in a dock.
    DockingAttempts(u32),
}

/// How a goal was cancelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CancelCause {
    /// Its cancellation was asked for.
    Requested,
    /// Motion was stopped.
    MotionStopped,
    /// The robot was driven by hand.
    DrivenByHand,
    /// This goal replaced it.
    Replaced(GoalId),
}

/// State of the executive: what moves the robot now. A state with a smaller number takes precedence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum ExecutiveState {
    /// Motion is stopped until somebody allows it again.
    Stopped,
    /// A person drives.
    ManualDriving,
    /// A goal waits while the robot relocalises in the map.
    Recovering,
    /// A goal is executed.
    Executing,
    /// The robot stands and is free to move.
    #[default]
    Idle,
}

/// An event of the executive's state table; also the cause of a transition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum ExecutiveEvent {
    /// The stack has started.
    Started,
    /// Somebody stops motion.
    StopRequested,
    /// Somebody allows motion again.
    MotionAllowed,
    /// Somebody drives by hand.
    VelocityCommanded,
    /// No velocity came for the profile's watchdog time.
    VelocityTimedOut,
    /// The control lease went to somebody else, or was given back.
    LeaseLost,
    /// Somebody asks for a goal that can be begun.
    GoalRequested,
    /// Somebody cancels the running goal.
    CancelRequested,
    /// The behaviour has reached what it was for.
    BehaviourSucceeded,
    /// The behaviour has given up.
    BehaviourFailed,
    /// The robot's pose in the saved map is not known any more.
    PoseLost,
    /// The robot's pose in the saved map is known.
    PoseFound,
    /// Odometry has begun anew: its frame has nothing to do with the one before.
    OdometryRestarted,
    /// The map or its frame was replaced.
    MapReplaced,
}

/// State of the executive, published when it changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExecutiveStatus {
    /// What moves the robot.
    pub state: ExecutiveState,
    /// Since when.
    pub since: Stamp,
    /// What led to it.
    pub cause: ExecutiveEvent,
    /// The goal that is executed or waits, if any.
    pub goal: Option<GoalId>,
}
