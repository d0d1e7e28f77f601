//! Texts of goals, by key.

use crate::format;
use api::{CancelCause, ExecutiveState, Goal, GoalAttempt, GoalKind, GoalStatus, WaitReason};
use site_model::Site;

pub(super) const WALK_TO_POINT: &str = "Walk to a point";
pub(super) const CANCEL_WALK: &str = "Cancel walk";
pub(super) const PICK_HINT: &str = "Click the floor where the robot shall walk.";
pub(super) const GO_TO: &str = "Go to";
pub(super) const CHOOSE_DESTINATION: &str = "Choose a place";
pub(super) const LEAVE_DOCK: &str = "Leave the dock";
pub(super) const SEND_TO_NODE: &str = "Send the robot here";
pub(super) const SEND_TO_DOCK: &str = "Send the robot to charge";
pub(super) const HEAD: &str = "Goal";
pub(super) const STATE: &str = "Executive";
pub(super) const GOAL: &str = "Doing";
pub(super) const REMAINING: &str = "To go";
pub(super) const WAITS: &str = "Waiting";
pub(super) const PROGRESS: &str = "Progress";
pub(super) const CANCEL: &str = "Cancel goal";
pub(super) const CANCEL_SHORT: &str = "Cancel";
pub(super) const OUTCOME: &str = "Outcome";
pub(super) const DISMISS: &str = "Dismiss the outcome";

/// What moves the robot.
pub(super) fn state(state: ExecutiveState) -> &'static str {
    match state {
        ExecutiveState::Stopped => "Motion stopped",
        ExecutiveState::ManualDriving => "Driven by hand",
        ExecutiveState::Recovering => "Relocalising",
        ExecutiveState::Executing => "Executing a goal",
        ExecutiveState::Idle => "Idle",
    }
}

/// What the robot does. `site` has the names of nodes and docks.
pub(super) fn goal(kind: GoalKind, site: Option<&Site>) -> String {
    match kind {
        GoalKind::WalkTo(point) => format!("Walking to {}", format::position(&point)),
        GoalKind::Relocalise => "Relocalising".to_owned(),
        GoalKind::GoToNode(id) => match site.and_then(|site| site.node(id)) {
            Some(node) => format!("Going to {}", node.name),
            None => "Going to a node".to_owned(),
        },
        GoalKind::GoToDock(id) => match site.and_then(|site| site.docks().find(|dock| dock.id == id)) {
            Some(dock) => format!("Going to {}", dock.name),
            None => "Going to a dock".to_owned(),
        },
        GoalKind::Undock => "Leaving the dock".to_owned(),
    }
}

pub(super) fn wait(reason: WaitReason) -> &'static str {
    match reason {
        WaitReason::Sight => "Waiting: the LiDAR sees nothing. The robot goes on when it sees again.",
        WaitReason::FreePath => "Waiting: the path is blocked. The robot goes on when it is free.",
        WaitReason::Relocalisation => "Waiting: the robot has to relocalise first.",
    }
}

pub(super) fn outcome_word(status: &GoalStatus) -> &'static str {
    match status {
        GoalStatus::Succeeded { .. } => "Succeeded",
        GoalStatus::Failed { .. } => "Failed",
        GoalStatus::Cancelled { .. } => "Cancelled",
        GoalStatus::Accepted | GoalStatus::Running(_) => "Running",
    }
}

/// What became of a goal, and what to do next.
pub(super) fn outcome(goal: &Goal) -> String {
    match &goal.status {
        GoalStatus::Succeeded { duration, .. } => {
            let took = format::duration(duration.secs_f64());
            match goal.kind {
                GoalKind::WalkTo(_) | GoalKind::GoToNode(_) => {
                    format!("The robot reached its goal in {took}.")
                }
                GoalKind::GoToDock(_) => format!("The robot is charged after {took}."),
                GoalKind::Undock => format!("The robot left its dock in {took}."),
                GoalKind::Relocalise => format!("The robot is localised after {took}."),
            }
        }
        GoalStatus::Failed { reason, .. } => reason.sentence().to_owned(),
        GoalStatus::Cancelled { cause, .. } => match cause {
            CancelCause::Requested => "An operator cancelled it.",
            CancelCause::MotionStopped => "Motion was stopped.",
            CancelCause::DrivenByHand => "The robot was driven by hand.",
            CancelCause::Replaced(_) => "Another goal replaced it.",
        }
        .to_owned(),
        GoalStatus::Accepted | GoalStatus::Running(_) => String::new(),
    }
}

/// What was tried before a goal failed; `None` if nothing is known.
pub(super) fn tried(status: &GoalStatus) -> Option<String> {
    let GoalStatus::Failed { tried, .. } = status else { return None };
    let tried: Vec<String> = tried.iter().map(attempt).collect();
    (!tried.is_empty()).then(|| format!("Tried: {}.", tried.join(", ")))
}

fn attempt(attempt: &GoalAttempt) -> String {
    match attempt {
        GoalAttempt::PlannedPaths(1) => "1 path planned".to_owned(),
        GoalAttempt::PlannedPaths(paths) => format!("{paths} paths planned"),
        GoalAttempt::WaitedForPath(span) => {
            format!("waited {} for a free path", format::duration(span.secs_f64()))
        }
        GoalAttempt::SearchedForPose(span) => {
            format!("searched the map for {}", format::duration(span.secs_f64()))
        }
        GoalAttempt::ExploredPaths(1) => "1 path explored".to_owned(),
        GoalAttempt::ExploredPaths(paths) => format!("{paths} paths explored"),
        GoalAttempt::DockingAttempts(1) => "1 attempt to dock".to_owned(),
        GoalAttempt::DockingAttempts(attempts) => format!("{attempts} attempts to dock"),
    }
}

pub(super) fn ago(duration: &str) -> String {
    format!("{duration} ago.")
}
