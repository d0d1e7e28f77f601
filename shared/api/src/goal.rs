//! Goals of the robot and the state of its executive, as clients see them.

use serde::{Deserialize, Serialize};
use site_model::{DockId, NodeId};
pub use vocab::GoalFailure;
use vocab::{ClientId, GoalId, Pose, Span, Stamp, Vec3};

/// Goals in [`crate::Event::Goals`] at most.
pub const MAX_GOALS: usize = 8;

/// What the robot is to reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum GoalKind {
    /// Walk to this point of the map (map frame, metres), round obstacles.
    WalkTo(Vec3),
    /// Find the robot's pose in the saved map in use, walking a little where nothing else helps.
    Relocalise,
    /// Go to a node over the edges of the topological map, and stand in its pose.
    GoToNode(NodeId),
    /// Go to a dock and be charged in it.
    GoToDock(DockId),
    /// Leave the dock.
    Undock,
}

/// A goal and how far it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Goal {
    /// Id made by the client that asked.
    pub id: GoalId,
    /// What is to be reached.
    pub kind: GoalKind,
    /// Who asked.
    pub by: ClientId,
    /// When it was accepted.
    pub accepted: Stamp,
    /// How far it is.
    pub status: GoalStatus,
}

/// How far a goal is. The last three are outcomes: a goal has exactly one, and nothing comes after it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum GoalStatus {
    /// It will be executed.
    Accepted,
    /// It is being executed.
    Running(GoalProgress),
    /// It was reached.
    Succeeded {
        /// Base in the map at the end.
        map_from_base: Pose,
        /// From acceptance to the end.
        duration: Span,
    },
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
        by: ClientId,
        /// How.
        cause: CancelCause,
    },
}

impl GoalStatus {
    /// Whether the goal has ended.
    pub fn is_outcome(&self) -> bool {
        matches!(self, Self::Succeeded { .. } | Self::Failed { .. } | Self::Cancelled { .. })
    }
}

/// Progress of a running goal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GoalProgress {
    /// Distance along the path to the goal, in steps of 0.1 m; none where there is no path.
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

/// State of the executive: what moves the robot now.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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

/// What moves the robot, the first in precedence first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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

/// What led to a state of the executive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ExecutiveEvent {
    /// The stack has started.
    #[default]
    Started,
    /// Somebody stopped motion.
    StopRequested,
    /// Somebody allowed motion again.
    MotionAllowed,
    /// Somebody drove by hand.
    VelocityCommanded,
    /// No velocity came for a while.
    VelocityTimedOut,
    /// The control lease went to somebody else, or was given back.
    LeaseLost,
    /// Somebody asked for a goal.
    GoalRequested,
    /// Somebody cancelled the goal.
    CancelRequested,
    /// The goal was reached.
    BehaviourSucceeded,
    /// The goal was given up.
    BehaviourFailed,
    /// The robot's pose in the saved map was lost.
    PoseLost,
    /// The robot's pose in the saved map was found.
    PoseFound,
    /// Odometry began anew.
    OdometryRestarted,
    /// The map or its frame was replaced.
    MapReplaced,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number of a variant on the wire: the first byte.
    fn number<T: Serialize>(variant: T) -> u8 {
        crate::encode(&variant)[0]
    }

    /// Variants may be renamed and added at the end. If this test fails, one has moved: then [`crate::VERSION`] has to rise.
    #[test]
    fn variants_keep_their_numbers_on_the_wire() {
        use {ExecutiveEvent as Event, ExecutiveState as State};
        assert_eq!(
            [WaitReason::Sight, WaitReason::FreePath, WaitReason::Relocalisation].map(number),
            [0, 1, 2]
        );
        let failures = [GoalFailure::PathBlocked, GoalFailure::PoseNotFound, GoalFailure::MapReplaced];
        assert_eq!(failures.map(number), [0, 1, 2]);
        assert_eq!([GoalFailure::NotUndocked, GoalFailure::DockNotSeen].map(number), [6, 7]);
        let attempts = [
            GoalAttempt::PlannedPaths(9),
            GoalAttempt::WaitedForPath(Span::ZERO),
            GoalAttempt::SearchedForPose(Span::ZERO),
            GoalAttempt::ExploredPaths(9),
            GoalAttempt::DockingAttempts(9),
        ];
        assert_eq!(attempts.map(number), [0, 1, 2, 3, 4]);
        let states = [State::Stopped, State::ManualDriving, State::Recovering, State::Executing, State::Idle];
        assert_eq!(states.map(number), [0, 1, 2, 3, 4]);
        let events =
            [Event::Started, Event::PoseLost, Event::PoseFound, Event::OdometryRestarted, Event::MapReplaced];
        assert_eq!(events.map(number), [0, 10, 11, 12, 13]);
    }
}
