//! Actions of edges, zones, turns of the body for the camera, and waits before blocked edges, on the simulated site.

use crate::day::{Day, first};
use crate::mission_tests::{MISSION, RUN, localised, node, site, until_ended};
use crate::replay;
use geometry::{Vector3, isometry_from_pose};
use messages::{CancelCause, CommandKind, GoalFailure, GoalKind, GoalStatus, LedgerEvent};
use sim::Start;
use site_model::{
    ActionRequest, Edge, EdgeBlock, EdgeId, EditId, MissionCommandKind, Object, Parameters, RunState, Site,
    StartMode, Zone, ZoneEffect, ZoneId,
};
use stack::Stack;
use uuid::Uuid;
use vocab::{Pose, Span, Vec3};

/// A robot in the node before the dock.
fn before_the_dock(seed: u64, site: Site) -> Day {
    let start = Start { position: Vec3::new(18.2, 23.5, 0.0), yaw: 0.0 };
    localised(Day::among(0, start, seed, None), site)
}

fn put(site: &mut Site, object: Object) {
    let id = EditId(Uuid::nil());
    let edit = site.put(id, object);
    assert!(site.apply(&edit, id).is_ok());
}

/// A rectangle of the simulated site.
fn zone([x, y]: [[f64; 2]; 2], effect: ZoneEffect) -> Object {
    let (_, _, origin) = first();
    let corner = |x: f64, y: f64| [x - origin.x, y - origin.y];
    Object::Zone(Zone {
        id: ZoneId(Uuid::from_u128(900)),
        name: "Zone".to_owned(),
        corners_m: vec![corner(x[0], y[0]), corner(x[1], y[0]), corner(x[1], y[1]), corner(x[0], y[1])],
        height_m: None,
        effect,
        daily: None,
    })
}

fn heading(pose: &Pose) -> f64 {
    let ahead = isometry_from_pose(pose).map_or_else(Vector3::zeros, |pose| pose.rotation * Vector3::x());
    ahead.y.atan2(ahead.x)
}

/// Goes to a node, and calls `watch` ten times a second with the true position.
fn go_to(day: &mut Day, number: u128, mut watch: impl FnMut(Vector3)) {
    day.start_goal(GoalKind::GoToNode(node(number)));
    day.run(1.0);
    for _ in 0..1_500 {
        day.run(0.1);
        watch(day.true_position());
        if day.route.route.is_none() && day.route.at == Some(node(number)) {
            return;
        }
    }
    panic!("not reached: {:?} {:?} {:?}", day.route, day.motion, day.refusals);
}

#[test]
fn the_body_turns_where_the_head_does_not_pan_so_far_and_the_action_is_called_again() {
    let (_, _, origin) = first();
    let mut day = before_the_dock(61, site(origin));
    day.lockstep.demand_turns(&[0.8]);
    let start = MissionCommandKind::Start { run: RUN, mission: MISSION, mode: StartMode::Now };
    day.command(CommandKind::Mission(start));
    assert_eq!(until_ended(&mut day, 240), Some(RunState::Succeeded), "{:?} {:?}", day.missions, day.notices);
    let calls = day.lockstep.calls();
    assert_eq!(calls.len(), 3, "the first photo twice");
    assert_eq!((calls[0].call, calls[2].call == calls[0].call), (calls[1].call, false));
    let [before, after] = [0, 1].map(|call| calls[call].truth.site_from_base);
    let turned = heading(&after) - heading(&before);
    assert!((turned.sin().atan2(turned.cos()) - 0.9).abs() < 0.06, "{turned} rad");
    let moved_m = (after.position.x - before.position.x).hypot(after.position.y - before.position.y);
    assert!(moved_m < 0.15, "{moved_m} m");
    let again = replay(day.lockstep.log().iter().cloned(), &mut Stack::new());
    assert_eq!(again.hex(), day.lockstep.digest().hex());
}

#[test]
fn actions_of_an_edge_are_performed_at_its_ends() {
    let (_, _, origin) = first();
    let mut site = site(origin);
    let id = EdgeId(Uuid::from_u128(203));
    let edge = site.edge(id).expect("an edge").clone();
    let request = |action: &str| ActionRequest { action: action.to_owned(), parameters: Parameters::new() };
    let edge = Edge { on_enter: vec![request("open")], on_leave: vec![request("close")], ..edge };
    put(&mut site, Object::Edge(edge));
    let mut day = before_the_dock(62, site);
    go_to(&mut day, 3, |_| {});
    let calls: Vec<_> = day.lockstep.calls().iter().map(|call| (call.action.as_str(), call.truth)).collect();
    assert_eq!(calls.iter().map(|(action, _)| *action).collect::<Vec<_>>(), ["open", "close"]);
    let x = |call: usize| calls[call].1.site_from_base.position.x;
    assert!((x(0) - 18.2).abs() < 1.0 && (x(1) - 24.0).abs() < 1.0, "{} {}", x(0), x(1));
}

#[test]
fn route_actions_of_a_run_stand_in_it_like_those_of_tasks() {
    let (_, _, origin) = first();
    let mut site = site(origin);
    let request = |action: &str| ActionRequest { action: action.to_owned(), parameters: Parameters::new() };
    let edge = site.edge(EdgeId(Uuid::from_u128(203))).expect("an edge").clone();
    put(&mut site, Object::Edge(Edge { on_enter: vec![request("wait")], ..edge }));
    put(&mut site, zone([[20.0, 22.0], [20.0, 26.0]], ZoneEffect::Action(request("message"))));
    let mut day = before_the_dock(65, site);
    let start = MissionCommandKind::Start { run: RUN, mission: MISSION, mode: StartMode::Now };
    day.command(CommandKind::Mission(start));
    assert_eq!(until_ended(&mut day, 240), Some(RunState::Succeeded), "{:?} {:?}", day.missions, day.notices);
    // The mission has two tasks, and the actions on the way follow.
    let steps = day.lockstep.rows().iter().filter_map(|row| match row {
        LedgerEvent::Step(step) if step.step >= 2 => Some((step.step, step.state.as_str(), step.is_done)),
        _ => None,
    });
    let steps: Vec<_> = steps.collect();
    let began_and_ended = |number| {
        let of: Vec<_> = steps.iter().filter(|step| step.0 == number).collect();
        matches!(of[..], [(_, "running", false), (_, "succeeded", true)])
    };
    assert!(began_and_ended(2) && began_and_ended(3), "{steps:?}");
    let results = day.lockstep.rows().iter().filter_map(|row| match row {
        LedgerEvent::Result(result) => Some((result.step, result.kind.as_str(), result.body.as_str())),
        _ => None,
    });
    let results: Vec<_> = results.collect();
    let of = |kind: &str| results.iter().filter(|result| result.1 == kind).collect::<Vec<_>>();
    let ([wait], [message, ..]) = (&of("wait")[..], &of("message")[..]) else { panic!("{results:?}") };
    assert!(wait.0 == 2 && wait.2.contains(r#""stage":"enter""#), "{wait:?}");
    assert!(message.0 == 3 && message.2.contains(r#""zone":"#), "{message:?}");
    assert_eq!(results.len(), day.lockstep.calls().len(), "one result for each call: {results:?}");
}

#[test]
fn a_robot_walks_slowly_in_a_zone_with_a_speed_limit_and_fast_beside_it() {
    let (_, _, origin) = first();
    let mut site = site(origin);
    put(&mut site, zone([[20.0, 22.0], [20.0, 26.0]], ZoneEffect::SpeedLimit(0.3)));
    let mut day = before_the_dock(63, site);
    let (mut inside, mut outside, mut places) = (0.0_f64, 0.0_f64, Vec::<Vector3>::new());
    go_to(&mut day, 3, |at| {
        places.push(at);
        // Over half a second, because the body sways with each step.
        let Some(earlier) = places.len().checked_sub(6).map(|index| places[index]) else { return };
        let is_inside = |place: &Vector3| (20.2..22.0).contains(&place.x);
        let greatest = if is_inside(&at) && is_inside(&earlier) { &mut inside } else { &mut outside };
        *greatest = greatest.max((at - earlier).xy().norm() / 0.5);
    });
    assert!(inside > 0.15 && inside < 0.33, "{inside} m/s in the zone");
    assert!(outside > 0.5, "{outside} m/s beside it");
}

#[test]
fn a_route_leads_round_a_keep_out_zone_between_its_nodes() {
    let (_, _, origin) = first();
    let mut site = site(origin);
    // Beside the line from node 2 to node 3, so that the edge stays open, and on the line from node 3 to node 4, which closes that edge.
    put(&mut site, zone([[25.5, 27.5], [20.0, 25.0]], ZoneEffect::KeepOut));
    let mut day = before_the_dock(64, site);
    let mut is_entered = false;
    go_to(&mut day, 4, |at| is_entered |= (25.6..27.4).contains(&at.x) && (20.1..24.9).contains(&at.y));
    assert!(!is_entered);
}

/// Blocks both edges that lead away from the dock for 6 s, and starts a goal, which waits for them.
fn start_before_blocked_edges(day: &mut Day) {
    let until = day.lockstep.now() + Span::from_millis(6_000);
    let block = |number| EdgeBlock {
        edge: EdgeId(Uuid::from_u128(number)),
        until,
        failures: 1,
        reason: "A pallet.".to_owned(),
    };
    let mut site = day.lockstep.site().clone();
    put(&mut site, Object::EdgeBlock(block(203)));
    put(&mut site, Object::EdgeBlock(block(207)));
    day.lockstep.give_site(site);
    day.run(0.5);
    day.outcomes.clear();
    day.start_goal(GoalKind::GoToNode(node(4)));
    day.run(1.0);
    assert!(day.outcomes.is_empty() && day.route.route.is_some(), "{:?} {:?}", day.outcomes, day.refusals);
}

#[test]
fn whatever_takes_the_robot_from_a_goal_that_waits_keeps_it() {
    let (_, _, origin) = first();
    let mut day = before_the_dock(65, site(origin));
    let start = day.true_position();
    let moved_m = |day: &mut Day| (day.true_position() - start).xy().norm();

    start_before_blocked_edges(&mut day);
    day.command(CommandKind::StopMotion);
    day.command(CommandKind::AllowMotion);
    day.run(9.0);
    let stopped = [GoalStatus::Cancelled { by: day.operator(), cause: CancelCause::MotionStopped }];
    assert_eq!(day.outcomes, stopped);
    assert!(moved_m(&mut day) < 0.1, "it walked off by itself");

    start_before_blocked_edges(&mut day);
    for _ in 0..45 {
        day.command(CommandKind::Teleoperate(vocab::Twist::default()));
        day.run(0.2);
    }
    let driven = [GoalStatus::Cancelled { by: day.operator(), cause: CancelCause::DrivenByHand }];
    assert_eq!(day.outcomes, driven);
    assert!(moved_m(&mut day) < 0.1, "it was taken from the person who drives");

    start_before_blocked_edges(&mut day);
    day.command(CommandKind::LeaveMap);
    day.run(9.0);
    let replaced = GoalFailure::MapReplaced;
    assert!(
        matches!(day.outcomes[..], [GoalStatus::Failed { reason, .. }] if reason == replaced),
        "{:?}",
        day.outcomes
    );
    assert!(moved_m(&mut day) < 0.1, "it walks by a map that is not in use");
    let again = replay(day.lockstep.log().iter().cloned(), &mut Stack::new());
    assert_eq!(again.hex(), day.lockstep.digest().hex());
}

#[test]
fn without_anybody_in_between_a_goal_that_waited_is_reached() {
    let (_, _, origin) = first();
    let mut day = before_the_dock(66, site(origin));
    start_before_blocked_edges(&mut day);
    day.run(60.0);
    assert!(matches!(day.outcomes[..], [GoalStatus::Succeeded(_)]), "{:?} {:?}", day.outcomes, day.route);
    // What remained, as published: it never grew again by more than a step round something.
    let remaining: Vec<f64> = day.remaining_m.clone();
    let longest = remaining.iter().copied().fold(0.0, f64::max);
    assert!((10.0..16.0).contains(&longest), "{longest} m in all");
    let least = remaining.iter().scan(f64::INFINITY, |least, now| {
        let before = *least;
        *least = least.min(*now);
        Some(now - before)
    });
    let growth = least.fold(0.0, f64::max);
    assert!(growth < 1.0, "the way grew by {growth} m: {remaining:?}");
}
