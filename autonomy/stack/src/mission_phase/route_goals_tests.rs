//! Goals on the topological map: who may begin them, what becomes of the effects of the route executor, and what people are told.

use super::super::goal_request;
use super::super::testing::{AHEAD, Rig, client, goal_id, node_id};
use super::*;
use messages::{CommandKind, GoalAttempt, GoalFailure, GoalStatus, Notice};
use missions::{MissionEffect, RouteAttempt};
use site_model::{Dock, EdgeBlock, ReachFailure};
use uuid::Uuid;
use vocab::{Pose, Span, Twist, Vec3};

const TO_SECOND: GoalKind = GoalKind::GoToNode(site_model::NodeId(Uuid::from_u128(2)));
const DOCK: DockId = DockId(Uuid::from_u128(30));

/// What the effect of the executor becomes.
fn handle(rig: &mut Rig, effect: RouteEffect) -> Vec<StackEffect> {
    let (at, mut effects) = (rig.at, Vec::new());
    rig.running().handle_route_effects(at, vec![effect], &mut effects);
    effects
}

fn notices(effects: &[StackEffect]) -> Vec<(Severity, &str)> {
    let of_notice = |effect| match effect {
        &StackEffect::Publish(Publication::Notice(Notice { severity, ref text, .. })) => {
            Some((severity, text.as_str()))
        }
        _ => None,
    };
    effects.iter().filter_map(of_notice).collect()
}

fn site_write(effects: &[StackEffect]) -> Option<&SiteWrite> {
    effects.iter().find_map(|effect| match effect {
        StackEffect::Commit { events, .. } => match &events[..] {
            [LedgerEvent::Site(write)] => Some(write),
            _ => None,
        },
        _ => None,
    })
}

fn start(rig: &mut Rig, number: u128, kind: GoalKind) -> Result<(), String> {
    let Some(request) = goal_request(kind) else { panic!("not on the topological map") };
    let (at, mut effects) = (rig.at, Vec::new());
    let started = rig.running().start_route(at, (goal_id(number), kind, client(1)), request, &mut effects);
    assert!(effects.is_empty(), "{effects:?}");
    started
}

#[test]
fn a_goal_needs_the_site_and_the_pose_of_the_robot_in_it() {
    let mut rig = Rig::booted();
    assert_eq!(start(&mut rig, 1, TO_SECOND), Err(texts::NO_SITE.to_owned()));
    let mut rig = Rig::new();
    assert_eq!(start(&mut rig, 1, TO_SECOND), Err(texts::NOT_LOCALISED_IN_SITE.to_owned()));
    // One that has begun needs nothing more.
    assert_eq!(rig.begin(1, TO_SECOND), Ok(()));
    assert_eq!(start(&mut rig, 1, TO_SECOND), Ok(()));
}

#[test]
fn a_site_that_names_no_map_has_any_and_one_that_names_a_map_has_that_alone() {
    let [one, other] = [1, 2].map(|number| Some(MapId(Uuid::from_u128(number))));
    assert!(is_map_of_site(one, None) && is_map_of_site(one, one));
    assert!(!is_map_of_site(one, other));
    assert!(!is_map_of_site(None, None) && !is_map_of_site(None, one));
}

#[test]
fn missions_move_a_robot_that_is_idle_or_follows_the_platform() {
    let mut rig = Rig::new();
    assert!(rig.running().can_move_for_missions());
    assert_eq!(rig.command(1, CommandKind::StopMotion), None);
    assert!(!rig.running().can_move_for_missions(), "motion is stopped");
    assert_eq!(rig.command(1, CommandKind::AllowMotion), None);
    assert!(rig.running().can_move_for_missions());
    assert_eq!(rig.command(1, CommandKind::Teleoperate(Twist::default())), None);
    assert!(!rig.running().can_move_for_missions(), "somebody drives");

    let mut rig = Rig::new();
    assert_eq!(rig.begin(1, TO_SECOND), Ok(()));
    assert!(!rig.running().can_move_for_missions(), "the goal is a person's");

    let mut rig = Rig::new();
    let wanted = MissionEffect::RequestGoal { goal: goal_id(5), request: GoalRequest::Route(node_id(2)) };
    let (at, mut effects) = (rig.at, Vec::new());
    rig.running().handle_mission_effect(at, wanted, &mut effects);
    assert_eq!(rig.running().executive.goal(), Some(goal_id(5)));
    assert!(rig.running().can_move_for_missions(), "the goal is the platform's");
}

#[test]
fn a_blocked_edge_is_written_to_the_site_and_removed_once_it_was_walked() {
    let mut rig = Rig::new();
    let until = rig.at + Span::from_millis(60_000);
    let block = EdgeBlock { edge: AHEAD, until, failures: 1, reason: "A pallet.".to_owned() };
    let effects = handle(&mut rig, RouteEffect::Block(block.clone()));
    let write = SiteWrite { put: vec![Object::EdgeBlock(block)], removed: Vec::new() };
    assert_eq!(site_write(&effects), Some(&write));
    let effects = handle(&mut rig, RouteEffect::Unblock(AHEAD));
    let write = SiteWrite { put: Vec::new(), removed: vec![ObjectId::EdgeBlock(AHEAD)] };
    assert_eq!(site_write(&effects), Some(&write));
}

#[test]
fn the_runner_hears_of_walked_edges_and_people_of_actions_that_failed() {
    let mut rig = Rig::new();
    let walked_for = Span::from_millis(7_000);
    assert_eq!(handle(&mut rig, RouteEffect::Traversed(AHEAD, walked_for)), []);
    let Some(MissionInput::Traversed { edge, duration }) = rig.running().missions.pending.pop_back() else {
        panic!("the runner does not hear of it")
    };
    assert_eq!((edge, duration), (AHEAD, walked_for));
    let failed = RouteEffect::ActionFailed("open_door".to_owned(), "It is locked.".to_owned());
    let effects = handle(&mut rig, failed);
    assert_eq!(
        notices(&effects),
        [(Severity::Warning, texts::edge_action_failed("open_door", "It is locked.").as_str())]
    );
}

#[test]
fn the_end_of_the_executors_goal_is_the_outcome_with_what_was_tried() {
    let mut rig = Rig::new();
    assert_eq!(rig.begin(1, TO_SECOND), Ok(()));
    for _ in 0..2 {
        assert_eq!(handle(&mut rig, RouteEffect::Tried(RouteAttempt::Docking)), []);
    }
    // The executive ends such goals itself, and another goal is not this one.
    for (goal, result) in [
        (goal_id(1), RouteGoalResult::MotionTaken),
        (goal_id(1), RouteGoalResult::Cancelled),
        (goal_id(2), RouteGoalResult::Reached),
    ] {
        assert_eq!(handle(&mut rig, RouteEffect::Ended(goal, result)), []);
        assert_eq!(rig.running().executive.goal(), Some(goal_id(1)));
    }
    assert!(rig.running().missions.pending.is_empty());
    let result = RouteGoalResult::Failed(ReachFailure::NotDocked);
    let effects = handle(&mut rig, RouteEffect::Ended(goal_id(1), result.clone()));
    let outcome = effects.iter().find_map(|effect| match effect {
        StackEffect::Publish(Publication::Goal(update)) => Some(update.status.clone()),
        _ => None,
    });
    let tried = vec![GoalAttempt::DockingAttempts(2)];
    assert_eq!(outcome, Some(GoalStatus::Failed { reason: GoalFailure::NotDocked, tried }));
    let Some(MissionInput::Goal { goal, result: told }) = rig.running().missions.pending.pop_back() else {
        panic!("the runner does not hear of it")
    };
    assert_eq!((goal, told), (goal_id(1), result));
    assert_eq!(notices(&effects), [], "it is no dock");
}

#[test]
fn a_leg_that_the_executor_cancels_is_not_walked_on_and_the_goal_stays() {
    let mut rig = Rig::new();
    rig.see_floor();
    rig.stand_at_first_node();
    assert_eq!(rig.begin(1, TO_SECOND), Ok(()));
    let Some(leg) = rig.running().executive.leg() else { panic!("the robot does not walk") };
    let effects = handle(&mut rig, RouteEffect::CancelWalk(leg));
    let [StackEffect::Drive(drive)] = &effects[..] else { panic!("{effects:?}") };
    assert_eq!(drive.velocity, Twist::default(), "the legs stand");
    assert_eq!(rig.running().executive.leg(), None);
    assert_eq!(rig.running().executive.goal(), Some(goal_id(1)));
}

#[test]
fn a_leg_that_cannot_begin_ends_the_goal() {
    let mut rig = Rig::new();
    rig.stand_at_first_node();
    assert_eq!(rig.begin(1, TO_SECOND), Ok(()));
    // Once more, to get hold of the leg.
    let at = rig.at;
    let request = GoalRequest::Route(node_id(2));
    let legs = rig.running().with_view(at, |executor, view| executor.begin(at, goal_id(1), request, view));
    let found = legs.iter().find_map(|effect| match effect {
        RouteEffect::Walk(leg, walk) => Some((*leg, *walk)),
        _ => None,
    });
    let Some((leg, walk)) = found else { panic!("{legs:?}") };
    let nowhere = Pose { position: Vec3::new(f64::NAN, 0.0, 0.0), ..Pose::IDENTITY };
    let effects = handle(&mut rig, RouteEffect::Walk(leg, LegWalk { map_from_goal: nowhere, ..walk }));
    let is_failed = |effect: &StackEffect| match effect {
        StackEffect::Publish(Publication::Goal(update)) => {
            matches!(update.status, GoalStatus::Failed { reason: GoalFailure::NoSuchPlace, .. })
        }
        _ => false,
    };
    assert!(effects.iter().any(is_failed), "{effects:?}");
    assert_eq!(rig.running().missions.executor.goal(), None);
    assert_eq!(rig.running().executive.goal(), None);
}

/// The notices of a goal to the dock at node 1 that ends so. The base is ahead of the node by this, metres.
fn notices_of_docking(offset_m: Option<f64>, result: RouteGoalResult) -> Vec<(Severity, String)> {
    let mut rig = Rig::new();
    let dock = Dock { id: DOCK, name: "East".to_owned(), node: node_id(1), approach: node_id(2) };
    rig.give_objects(vec![Object::Dock(dock)]);
    assert_eq!(rig.begin(1, GoalKind::GoToDock(DOCK)), Ok(()));
    let pose = |x_m: f64| Pose { position: Vec3::new(x_m, 0.0, 0.0), ..Pose::IDENTITY };
    rig.running().missions.map_from_base = offset_m.map(pose);
    let effects = handle(&mut rig, RouteEffect::Ended(goal_id(1), result));
    notices(&effects).into_iter().map(|(severity, text)| (severity, text.to_owned())).collect()
}

#[test]
fn people_are_told_of_a_dock_that_was_not_reached_or_stands_elsewhere() {
    let failed = notices_of_docking(None, RouteGoalResult::Failed(ReachFailure::DockNotSeen));
    let why = missions::reach_failure(&ReachFailure::DockNotSeen);
    assert_eq!(failed, [(Severity::Warning, texts::not_docked("East", &why))]);
    let moved = notices_of_docking(Some(0.3), RouteGoalResult::Reached);
    assert_eq!(moved, [(Severity::Info, texts::dock_is_elsewhere("East", 0.3, 0.0))]);
    assert_eq!(notices_of_docking(Some(0.05), RouteGoalResult::Reached), [], "as near as localisation is");
    assert_eq!(notices_of_docking(None, RouteGoalResult::Reached), [], "nobody knows where the robot is");
}

#[test]
fn the_route_is_published_when_it_changes_and_not_before_the_site_is_known() {
    let published = |rig: &Rig| {
        let of_route = |effect: &StackEffect| match effect {
            StackEffect::Publish(Publication::Route(status)) => Some(status.at),
            _ => None,
        };
        rig.effects.iter().filter_map(of_route).collect::<Vec<_>>()
    };
    let mut rig = Rig::booted();
    rig.run(1.0);
    assert_eq!(published(&rig), []);
    let mut rig = Rig::new();
    rig.run(1.0);
    assert_eq!(published(&rig), [None]);
    rig.stand_at_first_node();
    rig.run(1.0);
    assert_eq!(published(&rig), [None, Some(node_id(1))]);
}

#[test]
fn without_a_site_the_executor_is_not_asked() {
    let mut rig = Rig::booted();
    let at = rig.at;
    let asked = rig.running().with_view(at, |_, _| vec![RouteEffect::Unblock(AHEAD)]);
    assert_eq!(asked, []);
    let mut rig = Rig::new();
    let asked = rig.running().with_view(at, |_, _| vec![RouteEffect::Unblock(AHEAD)]);
    assert_eq!(asked, [RouteEffect::Unblock(AHEAD)]);
}
