//! Goals, failures and zones of missions as those of the executive, and the other way round.

use super::open_call::TurnEnd;
use super::platform;
use executive::{BehaviourOutcome, DockGoal, MapZone, RouteLeg, RouteRemainder};
use messages::{Approach, GoalAttempt, GoalFailure, GoalKind, GoalStatus, PoseGoal, Severity, WaitReason};
use missions::{
    GoalRequest, LegKind, LegResult, LegWalk, MissionNotice, RouteAttempt, RouteGoalResult, RouteRemaining,
};
use navigation::{ZoneArea, ZoneRule};
use site_model::{ReachFailure, RouteWait, RunState, Zone, ZoneEffect};
use vocab::LegId;

/// A zone as the executive needs it; none if nothing of it concerns walking.
pub(super) fn map_zone(zone: &Zone) -> Option<MapZone> {
    let rule = match zone.effect {
        ZoneEffect::KeepOut => ZoneRule::KeepOut,
        ZoneEffect::SpeedLimit(limit_m_s) => ZoneRule::SpeedLimit(limit_m_s),
        ZoneEffect::Penalty(factor) => ZoneRule::Penalty(factor),
        ZoneEffect::Action(_) => return None,
    };
    let area = ZoneArea { corners_m: zone.corners_m.clone(), rule };
    Some(MapZone { area, height_m: zone.height_m })
}

/// How a leg ended.
pub(super) fn leg_result(outcome: BehaviourOutcome) -> LegResult {
    match outcome {
        Ok(()) => LegResult::Reached,
        Err(reason) => LegResult::Failed(reach_failure(reason)),
    }
}

/// How a leg by which the body turns ended.
pub(super) fn turn_end_of_leg(outcome: BehaviourOutcome) -> TurnEnd {
    if outcome.is_ok() { TurnEnd::Turned } else { TurnEnd::Blocked }
}

/// How a goal by which the body turns ended.
pub(super) fn turn_end_of_goal(status: &GoalStatus) -> TurnEnd {
    match status {
        GoalStatus::Succeeded(_) => TurnEnd::Turned,
        GoalStatus::Cancelled { .. } => TurnEnd::MotionTaken,
        GoalStatus::Accepted | GoalStatus::Running(_) | GoalStatus::Failed { .. } => TurnEnd::Blocked,
    }
}

/// How a goal ended, for the runner; none while it has not.
pub(super) fn goal_result(status: &GoalStatus) -> Option<RouteGoalResult> {
    match status {
        GoalStatus::Accepted | GoalStatus::Running(_) => None,
        GoalStatus::Succeeded(_) => Some(RouteGoalResult::Reached),
        GoalStatus::Failed { reason, .. } => Some(RouteGoalResult::Failed(reach_failure(*reason))),
        GoalStatus::Cancelled { by, .. } if *by == platform() => Some(RouteGoalResult::Cancelled),
        GoalStatus::Cancelled { .. } => Some(RouteGoalResult::MotionTaken),
    }
}

/// A walk of a route as a leg of its goal.
pub(super) fn route_leg(id: LegId, walk: &LegWalk) -> RouteLeg {
    let LegWalk { map_from_goal, tolerance, max_speed_m_s, kind } = *walk;
    let approach = if kind == LegKind::Path { Approach::Path } else { Approach::Straight };
    let dock = match kind {
        LegKind::OntoDock { is_facing } => {
            Some(DockGoal { map_from_docked: map_from_goal, is_facing, max_speed_m_s })
        }
        LegKind::Path | LegKind::Straight => None,
    };
    RouteLeg { id, pose: PoseGoal { map_from_goal, tolerance, max_speed_m_s, approach }, dock }
}

/// What is left of a route, as it is published with the progress of its goal. What exactly it waits for stands in the published route.
pub(super) fn route_remainder(remaining: RouteRemaining) -> RouteRemainder {
    let waits_for = remaining.waits_for.and_then(|wait| match wait {
        RouteWait::Block { .. } | RouteWait::Retry { .. } | RouteWait::Hold { .. } => {
            Some(WaitReason::FreePath)
        }
        RouteWait::Place => Some(WaitReason::Relocalisation),
        RouteWait::Action(_) | RouteWait::Charge => None,
    });
    RouteRemainder { beyond_leg_m: remaining.beyond_leg_m, waits_for }
}

pub(super) fn goal_attempt(attempt: RouteAttempt) -> GoalAttempt {
    match attempt {
        RouteAttempt::WaitedForEdge(time) => GoalAttempt::WaitedForPath(time),
        RouteAttempt::WaitedForPlace(time) => GoalAttempt::SearchedForPose(time),
        RouteAttempt::Docking => GoalAttempt::DockingAttempts(1),
    }
}

/// What a goal on the topological map asks for; none for goals of the other kinds.
pub(crate) fn goal_request(kind: GoalKind) -> Option<GoalRequest> {
    match kind {
        GoalKind::GoToNode(node) => Some(GoalRequest::Route(node)),
        GoalKind::GoToDock(dock) => Some(GoalRequest::Dock(dock)),
        GoalKind::Undock => Some(GoalRequest::Undock),
        GoalKind::WalkTo(_) | GoalKind::WalkToPose(_) | GoalKind::Relocalise => None,
    }
}

pub(super) fn goal_kind(request: GoalRequest) -> GoalKind {
    match request {
        GoalRequest::Route(node) => GoalKind::GoToNode(node),
        GoalRequest::Dock(dock) => GoalKind::GoToDock(dock),
        GoalRequest::Undock => GoalKind::Undock,
    }
}

pub(super) fn goal_failure(reason: &ReachFailure) -> GoalFailure {
    match reason {
        ReachFailure::NoSuchPlace => GoalFailure::NoSuchPlace,
        ReachFailure::NoRoute { .. } => GoalFailure::NoRoute,
        ReachFailure::PathBlocked => GoalFailure::PathBlocked,
        ReachFailure::PoseNotFound => GoalFailure::PoseNotFound,
        ReachFailure::MapReplaced => GoalFailure::MapReplaced,
        ReachFailure::NotUndocked => GoalFailure::NotUndocked,
        ReachFailure::NotDocked => GoalFailure::NotDocked,
        ReachFailure::DockNotSeen => GoalFailure::DockNotSeen,
    }
}

pub(super) fn reach_failure(reason: GoalFailure) -> ReachFailure {
    match reason {
        GoalFailure::NoSuchPlace => ReachFailure::NoSuchPlace,
        GoalFailure::NoRoute => ReachFailure::NoRoute { closed: Vec::new() },
        GoalFailure::PathBlocked => ReachFailure::PathBlocked,
        GoalFailure::PoseNotFound => ReachFailure::PoseNotFound,
        GoalFailure::MapReplaced => ReachFailure::MapReplaced,
        GoalFailure::NotUndocked => ReachFailure::NotUndocked,
        GoalFailure::NotDocked => ReachFailure::NotDocked,
        GoalFailure::DockNotSeen => ReachFailure::DockNotSeen,
    }
}

pub(super) fn severity(notice: MissionNotice) -> Severity {
    match notice {
        MissionNotice::RunEnded { outcome: RunState::Succeeded | RunState::Cancelled, .. } => Severity::Info,
        MissionNotice::PlanKept(_) => Severity::Info,
        _ => Severity::Warning,
    }
}

#[cfg(test)]
#[path = "conversions_tests.rs"]
mod tests;
