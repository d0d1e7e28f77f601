//! Every reason, outcome and zone has its counterpart.

use super::*;
use messages::{CancelCause, Principal};
use site_model::{DockId, NodeId, ZoneId};
use uuid::Uuid;
use vocab::{ClientId, GoalId, Pose, Span, Stamp};

#[test]
fn a_reason_is_the_same_after_it_went_to_the_executive_and_back() {
    let reasons = [
        ReachFailure::NoSuchPlace,
        ReachFailure::NoRoute { closed: Vec::new() },
        ReachFailure::PathBlocked,
        ReachFailure::PoseNotFound,
        ReachFailure::MapReplaced,
        ReachFailure::NotUndocked,
        ReachFailure::NotDocked,
        ReachFailure::DockNotSeen,
    ];
    for reason in reasons {
        assert_eq!(reach_failure(goal_failure(&reason)), reason);
        assert_eq!(leg_result(Err(goal_failure(&reason))), LegResult::Failed(reason));
    }
    assert_eq!(leg_result(Ok(())), LegResult::Reached);
}

#[test]
fn only_the_platform_cancels_a_goal_without_taking_motion_from_its_run() {
    let cancelled = |by: Principal, cause| goal_result(&GoalStatus::Cancelled { by, cause });
    let person = Principal::operator(ClientId(Uuid::from_u128(1)));
    for cause in [
        CancelCause::Requested,
        CancelCause::MotionStopped,
        CancelCause::DrivenByHand,
        CancelCause::Replaced(GoalId(Uuid::from_u128(2))),
    ] {
        assert_eq!(cancelled(person.clone(), cause), Some(RouteGoalResult::MotionTaken));
    }
    assert_eq!(cancelled(platform(), CancelCause::Requested), Some(RouteGoalResult::Cancelled));
    assert_eq!(goal_result(&GoalStatus::Accepted), None);
    let failed = GoalStatus::Failed { reason: GoalFailure::NoRoute, tried: Vec::new() };
    let no_route = ReachFailure::NoRoute { closed: Vec::new() };
    assert_eq!(goal_result(&failed), Some(RouteGoalResult::Failed(no_route)));
    assert_eq!(turn_end_of_goal(&failed), TurnEnd::Blocked);
    let stopped = GoalStatus::Cancelled { by: person, cause: CancelCause::MotionStopped };
    assert_eq!(turn_end_of_goal(&stopped), TurnEnd::MotionTaken);
}

#[test]
fn what_is_asked_for_is_the_same_in_both_directions() {
    let (node, dock) = (NodeId(Uuid::from_u128(1)), DockId(Uuid::from_u128(2)));
    for request in [GoalRequest::Route(node), GoalRequest::Dock(dock), GoalRequest::Undock] {
        assert_eq!(goal_request(goal_kind(request)), Some(request));
    }
    assert_eq!(goal_request(GoalKind::Relocalise), None);
}

#[test]
fn only_a_walk_onto_a_dock_looks_for_one() {
    let walk = |kind| {
        let tolerance = None;
        LegWalk { map_from_goal: Pose::IDENTITY, tolerance, max_speed_m_s: Some(0.2), kind }
    };
    let id = LegId(Uuid::from_u128(3));
    let leg = route_leg(id, &walk(LegKind::OntoDock { is_facing: true }));
    let dock = leg.dock.unwrap_or_else(|| panic!("no dock"));
    assert_eq!((leg.id, dock.is_facing, dock.max_speed_m_s), (id, true, Some(0.2)));
    assert_eq!(leg.pose.approach, Approach::Straight);
    let straight = route_leg(id, &walk(LegKind::Straight));
    assert_eq!((straight.dock, straight.pose.approach), (None, Approach::Straight));
    assert_eq!(route_leg(id, &walk(LegKind::Path)).pose.approach, Approach::Path);
}

#[test]
fn waits_for_a_route_and_for_the_place_are_told_with_the_progress() {
    let wait_reason =
        |waits_for| route_remainder(RouteRemaining { beyond_leg_m: Some(2.0), waits_for }).waits_for;
    assert_eq!(wait_reason(Some(RouteWait::Block { until: Stamp::EPOCH })), Some(WaitReason::FreePath));
    assert_eq!(wait_reason(Some(RouteWait::Place)), Some(WaitReason::Relocalisation));
    assert_eq!([wait_reason(Some(RouteWait::Charge)), wait_reason(None)], [None; 2]);
    assert_eq!(goal_attempt(RouteAttempt::Docking), GoalAttempt::DockingAttempts(1));
    let time = Span::from_millis(3_000);
    assert_eq!(goal_attempt(RouteAttempt::WaitedForEdge(time)), GoalAttempt::WaitedForPath(time));
    assert_eq!(goal_attempt(RouteAttempt::WaitedForPlace(time)), GoalAttempt::SearchedForPose(time));
}

#[test]
fn zones_of_actions_are_no_matter_of_walking() {
    let zone = |effect| Zone {
        id: ZoneId(Uuid::from_u128(1)),
        name: "Zone".to_owned(),
        corners_m: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
        height_m: Some([0.0, 2.0]),
        effect,
        daily: None,
    };
    let limited = map_zone(&zone(ZoneEffect::SpeedLimit(0.3))).unwrap_or_else(|| panic!("no zone"));
    assert!(matches!(limited.area.rule, ZoneRule::SpeedLimit(limit) if limit == 0.3));
    assert_eq!((limited.area.corners_m.len(), limited.height_m), (3, Some([0.0, 2.0])));
    let action =
        site_model::ActionRequest { action: "photo".to_owned(), parameters: site_model::Parameters::new() };
    assert!(map_zone(&zone(ZoneEffect::Action(action))).is_none());
}
