//! Goals on the topological map between executive and route executor. The robot stands at node 1, and the only edge is blocked, so that the goal waits.

use super::platform;
use super::testing::{Rig, client, goal_id, node_id};
use messages::{
    CancelCause, CommandKind, ExecutiveState, GoalAttempt, GoalFailure, GoalKind, GoalProgress, GoalStatus,
    Publication, StackEffect, WaitReason,
};
use missions::{GoalRequest, MissionEffect};
use uuid::Uuid;
use vocab::{Twist, Vec3};

const TO_SECOND: GoalKind = GoalKind::GoToNode(site_model::NodeId(Uuid::from_u128(2)));

/// A goal to node 2 that waits for 10 s.
fn waiting() -> Rig {
    let mut rig = Rig::new();
    rig.stand_at_first_node();
    rig.block(10.0);
    assert_eq!(rig.begin(1, TO_SECOND), Ok(()));
    rig.run(1.0);
    assert_eq!(rig.running().executive.state(), ExecutiveState::Executing);
    assert_eq!(rig.running().executive.goal(), Some(goal_id(1)));
    assert!(!is_walking(&mut rig) && rig.outcomes(1).is_empty());
    rig
}

/// Whether the executive has a leg to walk.
fn is_walking(rig: &mut Rig) -> bool {
    rig.running().executive.leg().is_some()
}

#[test]
fn without_anybody_in_between_the_goal_walks_on_after_its_wait() {
    let mut rig = waiting();
    rig.run(10.0);
    assert!(is_walking(&mut rig));
    assert!(rig.outcomes(1).is_empty());
}

#[test]
fn a_stop_ends_a_goal_that_waits_and_nothing_walks_when_motion_is_allowed() {
    let mut rig = waiting();
    assert_eq!(rig.command(2, CommandKind::StopMotion), None);
    let by = client(2);
    let outcome = GoalStatus::Cancelled { by, cause: CancelCause::MotionStopped };
    assert_eq!(rig.outcomes(1), [&outcome]);
    assert_eq!(rig.command(1, CommandKind::AllowMotion), None);
    rig.run(20.0);
    assert_eq!(rig.running().executive.state(), ExecutiveState::Idle);
    assert_eq!(rig.outcomes(1), [&outcome]);
    assert_eq!(rig.running().missions.executor.goal(), None);
}

#[test]
fn a_person_who_drives_keeps_the_robot_from_a_goal_that_waited() {
    let mut rig = waiting();
    for _ in 0..100 {
        assert_eq!(rig.command(1, CommandKind::Teleoperate(Twist::default())), None);
        rig.run(0.2);
        assert_eq!(rig.running().executive.state(), ExecutiveState::ManualDriving);
    }
    let outcome = GoalStatus::Cancelled { by: client(1), cause: CancelCause::DrivenByHand };
    assert_eq!(rig.outcomes(1), [&outcome]);
}

#[test]
fn a_newer_goal_is_not_replaced_by_one_that_waited() {
    let mut rig = waiting();
    rig.see_floor();
    let walk = GoalKind::WalkTo(Vec3::new(2.0, 0.0, -0.5));
    assert_eq!(rig.command(1, CommandKind::StartGoal { goal: goal_id(2), kind: walk }), None);
    let outcome = GoalStatus::Cancelled { by: client(1), cause: CancelCause::Replaced(goal_id(2)) };
    assert_eq!(rig.outcomes(1), [&outcome]);
    rig.run(20.0);
    assert_eq!(rig.running().executive.goal(), Some(goal_id(2)));
    assert_eq!((rig.outcomes(1).len(), rig.outcomes(2).len()), (1, 0));
}

#[test]
fn another_map_ends_a_goal_that_waits() {
    let mut rig = waiting();
    assert_eq!(rig.command(1, CommandKind::LeaveMap), None);
    let [GoalStatus::Failed { reason, .. }] = rig.outcomes(1)[..] else { panic!("{:?}", rig.updates) };
    assert_eq!(*reason, GoalFailure::MapReplaced);
    rig.run(20.0);
    assert_eq!(rig.running().executive.state(), ExecutiveState::Idle);
    assert_eq!(rig.outcomes(1).len(), 1);
}

#[test]
fn a_goal_that_has_ended_does_not_begin_again_under_its_id() {
    let mut rig = waiting();
    assert_eq!(rig.command(1, CommandKind::CancelGoal(goal_id(1))), None);
    let outcome = GoalStatus::Cancelled { by: client(1), cause: CancelCause::Requested };
    assert_eq!(rig.outcomes(1), [&outcome]);
    let count = rig.updates.len();
    assert_eq!(rig.command(1, CommandKind::StartGoal { goal: goal_id(1), kind: TO_SECOND }), None);
    rig.run(1.0);
    assert_eq!(rig.updates.len(), count);
    assert!(rig.begin(1, TO_SECOND).is_err(), "a run would be told");
    // A goal that needs the topological map is refused where the robot is not localised in it.
    assert!(rig.command(1, CommandKind::StartGoal { goal: goal_id(2), kind: TO_SECOND }).is_some());
}

#[test]
fn progress_is_that_of_the_whole_route_and_says_what_the_goal_waits_for() {
    let mut rig = waiting();
    rig.run(10.0);
    let progress: Vec<&GoalProgress> = rig
        .updates
        .iter()
        .filter_map(|update| match &update.status {
            GoalStatus::Running(progress) => Some(progress),
            _ => None,
        })
        .collect();
    assert_eq!(progress.first().map(|first| first.waits_for), Some(Some(WaitReason::FreePath)));
    // Two legs of 5 m, of which the first is to be walked.
    assert_eq!(progress.last().and_then(|last| last.remaining_m), Some(10.0));
}

#[test]
fn a_goal_that_fails_says_what_was_tried() {
    let mut rig = Rig::new();
    // Nobody knows where the robot is.
    assert_eq!(rig.begin(1, TO_SECOND), Ok(()));
    rig.run(30.0);
    let [GoalStatus::Failed { reason, tried }] = rig.outcomes(1)[..] else { panic!("{:?}", rig.updates) };
    assert_eq!(*reason, GoalFailure::PoseNotFound);
    let [GoalAttempt::SearchedForPose(time)] = tried[..] else { panic!("{tried:?}") };
    assert!((20.0..25.0).contains(&time.secs_f64()), "{time:?}");
}

#[test]
fn a_goal_of_the_runner_that_cannot_begin_is_taken_from_it() {
    let mut rig = Rig::new();
    assert_eq!(rig.command(1, CommandKind::StopMotion), None);
    let (at, mut effects) = (rig.at, Vec::new());
    let wanted = MissionEffect::RequestGoal { goal: goal_id(5), request: GoalRequest::Route(node_id(2)) };
    rig.running().handle_mission_effect(at, wanted, &mut effects);
    assert!(effects.is_empty());
    assert_eq!(rig.running().missions.pending.len(), 1);

    let mut rig = Rig::new();
    let wanted = MissionEffect::RequestGoal { goal: goal_id(5), request: GoalRequest::Route(node_id(2)) };
    let (at, mut effects) = (rig.at, Vec::new());
    rig.running().handle_mission_effect(at, wanted, &mut effects);
    let accepted = effects.iter().any(|effect| {
        matches!(effect, StackEffect::Publish(Publication::Goal(update)) if update.id == goal_id(5) && update.by == platform())
    });
    assert!(accepted && rig.running().can_move_for_missions());
    let mut effects = Vec::new();
    rig.running().handle_mission_effect(at, MissionEffect::CancelGoal(goal_id(5)), &mut effects);
    assert_eq!(rig.running().executive.goal(), None);
    assert_eq!(rig.running().missions.executor.goal(), None);
}
