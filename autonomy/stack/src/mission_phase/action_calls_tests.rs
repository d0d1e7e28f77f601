//! Calls of actions: who decides on them, how they end, and when the body turns for the camera.

use super::super::testing::{AHEAD, Rig, goal_id, node_id};
use super::*;
use messages::{CommandKind, Input, LedgerEvent};
use missions::{GoalRequest, MissionEffect};
use site_model::{Edge, Object, Parameter, Parameters};
use std::f64::consts::FRAC_PI_2;
use uuid::Uuid;

const TO_SECOND: GoalKind = GoalKind::GoToNode(site_model::NodeId(Uuid::from_u128(2)));
const CALL: ActionCallId = ActionCallId(Uuid::from_u128(40));

fn request() -> ActionRequest {
    let zoom = ("zoom".to_owned(), Parameter::Integer(2));
    ActionRequest { action: "photo".to_owned(), parameters: Parameters::from([zoom]) }
}

/// The call as an effect.
fn called() -> StackEffect {
    StackEffect::CallAction { call: CALL, action: "photo".to_owned(), parameters: r#"{"zoom":2}"#.to_owned() }
}

/// What a function of the stack asks for.
fn effects_of(
    rig: &mut Rig,
    act: impl FnOnce(&mut Running, Stamp, &mut Vec<StackEffect>),
) -> Vec<StackEffect> {
    let (at, mut effects) = (rig.at, Vec::new());
    act(rig.running(), at, &mut effects);
    effects
}

/// A robot that stands on a floor that it sees, with a call of a task.
fn with_call() -> Rig {
    let mut rig = Rig::new();
    rig.see_floor();
    let effects = effects_of(&mut rig, |running, _, effects| running.call_action(CALL, request(), effects));
    assert_eq!(effects, [called()]);
    rig
}

/// Tells the stack that the camera does not pan that far, radians. Returns whether the body turns.
fn begin_turn(rig: &mut Rig, turn_rad: f64) -> bool {
    let (at, mut effects) = (rig.at, Vec::new());
    rig.running().begin_turn(at, CALL, turn_rad, &mut effects)
}

fn end_turn(rig: &mut Rig, number: u32, end: TurnEnd) -> (bool, Vec<StackEffect>) {
    let mut is_turn = false;
    let turn = turn_leg_id(CALL, number);
    let effects = effects_of(rig, |running, at, effects| is_turn = running.end_turn(at, turn, end, effects));
    (is_turn, effects)
}

fn is_open(rig: &mut Rig) -> bool {
    rig.running().missions.calls.contains_key(&CALL)
}

/// A goal of the platform, as the runner requests it.
fn begin_goal_of_runner(rig: &mut Rig) {
    let wanted = MissionEffect::RequestGoal { goal: goal_id(5), request: GoalRequest::Route(node_id(2)) };
    effects_of(rig, |running, at, effects| running.handle_mission_effect(at, wanted, effects));
    assert_eq!(rig.running().executive.goal(), Some(goal_id(5)));
}

#[test]
fn the_runner_decides_on_actions_of_its_own_routes_alone() {
    let place = RouteActionPlace::Edge { edge: AHEAD, stage: site_model::EdgeStage::Enter, index: 0 };
    let call = |rig: &mut Rig| {
        effects_of(rig, |running, _, effects| running.call_route_action(CALL, place, request(), effects))
    };
    let mut rig = Rig::new();
    assert_eq!(rig.begin(1, TO_SECOND), Ok(()));
    assert_eq!(call(&mut rig), [called()], "a person's goal");
    let mut rig = Rig::new();
    begin_goal_of_runner(&mut rig);
    assert_eq!(call(&mut rig), []);
    let Some(MissionInput::RouteActionWanted { goal, call, request: wanted, .. }) =
        rig.running().missions.pending.pop_back()
    else {
        panic!("the runner is not asked")
    };
    assert_eq!((goal, call, wanted), (goal_id(5), CALL, request()));
    assert!(!is_open(&mut rig));
}

#[test]
fn a_call_that_was_not_made_yet_is_cancelled_by_the_runner() {
    let cancel = |rig: &mut Rig| {
        effects_of(rig, |running, at, effects| running.cancel_route_action(at, CALL, effects))
    };
    let mut rig = with_call();
    assert_eq!(cancel(&mut rig), [StackEffect::CancelAction(CALL)]);
    assert!(is_open(&mut rig), "its end follows");
    let mut rig = Rig::new();
    assert_eq!(cancel(&mut rig), []);
    let pending = rig.running().missions.pending.pop_back();
    assert!(matches!(pending, Some(MissionInput::RouteActionCancelled(CALL))), "{pending:?}");
}

#[test]
fn the_body_turns_beyond_the_reach_of_the_head_and_the_action_is_called_again() {
    for (turn_rad, yaw_rad) in [(0.4, 0.5), (-0.4, -0.5)] {
        let mut rig = with_call();
        rig.step(Input::ActionDone { call: CALL, outcome: ActionOutcome::NeedsTurn { turn_rad } });
        let turn = turn_leg_id(CALL, 0);
        assert_eq!(rig.running().executive.goal(), Some(turn_goal(turn)));
        let Some((GoalKind::WalkToPose(pose), by)) = rig.running().executive.request() else {
            panic!("the body does not turn")
        };
        let found = pose.map_from_goal.orientation;
        assert!((2.0 * found.z.atan2(found.w) - yaw_rad).abs() < 1e-9, "{found:?}");
        assert_eq!(*by, platform());
        assert!(rig.updates.is_empty(), "clients do not see it");
        assert_eq!(end_turn(&mut rig, 0, TurnEnd::Turned), (true, vec![called()]));
        assert!(is_open(&mut rig));
    }
}

#[test]
fn a_call_ends_when_the_body_was_kept_from_turning() {
    for end in [TurnEnd::Blocked, TurnEnd::MotionTaken] {
        let mut rig = with_call();
        assert!(begin_turn(&mut rig, FRAC_PI_2));
        assert!(!end_turn(&mut rig, 1, end).0, "another turn");
        assert!(is_open(&mut rig));
        assert!(end_turn(&mut rig, 0, end).0);
        assert!(!is_open(&mut rig), "{end:?}");
        assert!(!end_turn(&mut rig, 0, end).0, "it has ended");
    }
}

#[test]
fn the_body_turns_as_often_as_it_may() {
    let mut rig = with_call();
    let max_turns = rig.running().missions.config.max_turns;
    for number in 0..max_turns {
        assert!(begin_turn(&mut rig, FRAC_PI_2), "{number}");
        assert_eq!(rig.command(1, CommandKind::StopMotion), None);
        assert_eq!(rig.command(1, CommandKind::AllowMotion), None);
        // The stop has ended the call. It is made once more.
        assert!(!is_open(&mut rig), "{number}");
        effects_of(&mut rig, |running, _, effects| running.call_action(CALL, request(), effects));
        let call = rig.running().missions.calls.get_mut(&CALL);
        call.unwrap_or_else(|| panic!("the call was made")).turns = number + 1;
    }
    assert!(!begin_turn(&mut rig, FRAC_PI_2));
    assert_eq!(rig.running().executive.goal(), None);
}

#[test]
fn the_body_does_not_turn_for_nothing_or_while_it_is_not_free() {
    let mut rig = with_call();
    assert!(!begin_turn(&mut rig, f64::NAN));
    assert_eq!(rig.command(1, CommandKind::StopMotion), None);
    assert!(!begin_turn(&mut rig, FRAC_PI_2), "motion is stopped");
    let mut rig = with_call();
    assert_eq!(rig.begin(1, TO_SECOND), Ok(()));
    assert!(!begin_turn(&mut rig, FRAC_PI_2), "the goal of a person is executed");
    assert_eq!(rig.running().executive.goal(), Some(goal_id(1)));
    let mut rig = with_call();
    begin_goal_of_runner(&mut rig);
    assert!(!begin_turn(&mut rig, FRAC_PI_2), "the robot does not stand for the call");
    let mut rig = Rig::new();
    rig.see_floor();
    assert!(!begin_turn(&mut rig, FRAC_PI_2), "there is no such call");
}

#[test]
fn a_call_that_is_cancelled_while_the_body_turns_ends_at_once() {
    let mut rig = with_call();
    assert!(begin_turn(&mut rig, FRAC_PI_2));
    let effects = effects_of(&mut rig, |running, at, effects| running.cancel_action(at, CALL, effects));
    assert!(!effects.contains(&StackEffect::CancelAction(CALL)), "nobody performs it");
    assert!(!is_open(&mut rig));
    assert_eq!(rig.running().executive.goal(), None);
    let pending = rig.running().missions.pending.pop_back();
    let Some(MissionInput::Action { call, result }) = pending else { panic!("{pending:?}") };
    assert_eq!((call, result), (CALL, ActionResult::Cancelled));
}

#[test]
fn every_outcome_but_a_turn_ends_the_call() {
    let outcomes = [
        ActionOutcome::Succeeded { result: "{}".to_owned() },
        ActionOutcome::Failed { reason: "It is dark.".to_owned() },
        ActionOutcome::Cancelled,
        // Of a body that cannot turn.
        ActionOutcome::NeedsTurn { turn_rad: f64::NAN },
    ];
    for outcome in outcomes {
        let mut rig = with_call();
        rig.step(Input::ActionDone { call: CALL, outcome: outcome.clone() });
        assert!(!is_open(&mut rig), "{outcome:?}");
    }
}

/// A person's goal over an edge with an action before it. The robot stands at its beginning until the action has ended.
fn standing_for_edge_action() -> (Rig, ActionCallId) {
    let mut rig = Rig::new();
    rig.see_floor();
    let on_enter = vec![request()];
    let edge = Edge::walk(AHEAD, node_id(1), node_id(2));
    rig.give_objects(vec![Object::Edge(Edge { on_enter, ..edge })]);
    rig.stand_at_first_node();
    assert_eq!(rig.begin(1, TO_SECOND), Ok(()));
    let calls = rig.running().missions.calls.keys().copied().collect::<Vec<_>>();
    let [call] = calls[..] else { panic!("{calls:?}") };
    assert!(rig.running().executive.leg().is_none());
    (rig, call)
}

/// Why edges were blocked.
fn reasons_of_blocks(effects: &[StackEffect]) -> Vec<&str> {
    let commits = effects.iter().filter_map(|effect| match effect {
        StackEffect::Commit { events, .. } => Some(events),
        _ => None,
    });
    let put = commits.flatten().filter_map(|event| match event {
        LedgerEvent::Site(write) => Some(&write.put),
        _ => None,
    });
    let blocks = put.flatten().filter_map(|object| match object {
        Object::EdgeBlock(block) => Some(block.reason.as_str()),
        _ => None,
    });
    blocks.collect()
}

#[test]
fn the_route_goes_on_when_the_action_of_its_edge_was_done_and_one_that_failed_blocks_the_edge() {
    let (mut rig, call) = standing_for_edge_action();
    let succeeded = ActionOutcome::Succeeded { result: "{}".to_owned() };
    rig.step(Input::ActionDone { call, outcome: succeeded });
    assert!(rig.running().executive.leg().is_some());
    // One that failed blocks the edge, with its reason.
    for (outcome, reason) in [
        (ActionOutcome::Failed { reason: "It is dark.".to_owned() }, "It is dark."),
        (ActionOutcome::Cancelled, texts::ACTION_CANCELLED),
    ] {
        let (mut rig, call) = standing_for_edge_action();
        rig.step(Input::ActionDone { call, outcome });
        assert!(rig.running().executive.leg().is_none());
        let [found] = reasons_of_blocks(&rig.effects)[..] else { panic!("{:?}", rig.effects) };
        assert!(found.contains(reason), "{found}");
    }
}

#[test]
fn the_body_turns_within_the_goal_whose_edge_needs_the_action() {
    let (mut rig, call) = standing_for_edge_action();
    rig.step(Input::ActionDone { call, outcome: ActionOutcome::NeedsTurn { turn_rad: 0.4 } });
    assert_eq!(rig.running().executive.goal(), Some(goal_id(1)));
    assert_eq!(rig.running().executive.leg(), Some(turn_leg_id(call, 0)));
}

#[test]
fn an_edge_is_blocked_with_what_has_kept_the_body_from_turning() {
    for (end, reason) in
        [(TurnEnd::Blocked, texts::TURN_BLOCKED), (TurnEnd::MotionTaken, texts::MOTION_TAKEN_WHILE_TURNING)]
    {
        let (mut rig, call) = standing_for_edge_action();
        rig.step(Input::ActionDone { call, outcome: ActionOutcome::NeedsTurn { turn_rad: 0.4 } });
        let turn = turn_leg_id(call, 0);
        let effects = effects_of(&mut rig, |running, at, effects| {
            assert!(running.end_turn(at, turn, end, effects));
        });
        let [found] = reasons_of_blocks(&effects)[..] else { panic!("{effects:?}") };
        assert!(found.contains(reason), "{found}");
    }
}
