//! Goals, failures and zones of missions as those of the executive, and the other way round.

use super::platform;
use executive::MapZone;
use messages::{Approach, GoalFailure, GoalKind, GoalProgress, GoalStatus, GoalUpdate, PoseGoal, Severity};
use missions::{GoalRequest, LegResult, LegWalk, LegWay, MissionNotice};
use navigation::{ZoneArea, ZoneRule};
use site_model::{ReachFailure, RunState, Zone, ZoneEffect};

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

/// Whether an update is of a walk of a route.
pub(super) fn is_walk(update: &GoalUpdate) -> bool {
    update.by == platform() && matches!(update.kind, GoalKind::WalkToPose(_))
}

/// How a walk ended; none while it has not.
pub(super) fn leg_result(status: &GoalStatus) -> Option<LegResult> {
    match status {
        GoalStatus::Accepted | GoalStatus::Running(GoalProgress { .. }) => None,
        GoalStatus::Succeeded(_) => Some(LegResult::Reached),
        GoalStatus::Failed { reason, .. } => Some(LegResult::Failed(match reason {
            GoalFailure::PoseNotFound => ReachFailure::PoseNotFound,
            GoalFailure::MapReplaced => ReachFailure::MapReplaced,
            GoalFailure::DockNotSeen => ReachFailure::DockNotSeen,
            _ => ReachFailure::PathBlocked,
        })),
        GoalStatus::Cancelled { .. } => Some(LegResult::MotionTaken),
    }
}

pub(super) fn pose_goal(leg: &LegWalk) -> PoseGoal {
    PoseGoal {
        map_from_goal: leg.map_from_goal,
        tolerance: leg.tolerance,
        speed_max_m_s: leg.speed_max_m_s,
        approach: if leg.way == LegWay::Path { Approach::Path } else { Approach::Straight },
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

pub(super) fn severity(told: MissionNotice) -> Severity {
    match told {
        MissionNotice::RunEnded { outcome: RunState::Succeeded | RunState::Cancelled, .. } => Severity::Info,
        MissionNotice::PlanKept(_) => Severity::Info,
        _ => Severity::Warning,
    }
}
