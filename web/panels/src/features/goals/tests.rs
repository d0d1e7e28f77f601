//! Goals on the screen: state, progress, what it waits for, cancelling, outcome.

use crate::test_support::{ME, TestClient, click, value};
use api::{
    Event, ExecutiveState, ExecutiveStatus, Goal, GoalAttempt, GoalFailure, GoalKind, GoalProgress,
    GoalStatus, Motion, SiteParts, SiteState, WaitReason,
};
use client_model::{ClientCommand, ClientEvent, ClientTime};
use egui_kittest::kittest::Queryable;
use site_model::{DockId, NodeId};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{GoalId, MapId, Span, Stamp, Vec3};

const GOAL: GoalId = GoalId(Uuid::from_u128(4));

fn report(client: TestClient, state: ExecutiveState, status: GoalStatus) -> TestClient {
    let goal = Goal {
        id: GOAL,
        kind: GoalKind::WalkTo(Vec3::new(4.0, 2.0, 0.0)),
        by: ME,
        accepted: Stamp::EPOCH,
        status,
    };
    let executive = ExecutiveStatus { state, ..ExecutiveStatus::default() };
    client.event(Event::Executive(executive)).event(Event::Goals(vec![goal]))
}

fn running(remaining_m: f64, waits_for: Option<WaitReason>) -> GoalStatus {
    GoalStatus::Running(GoalProgress { remaining_m: Some(remaining_m), waits_for })
}

#[test]
fn a_running_goal_shows_where_to_how_far_and_what_it_waits_for() {
    let client = report(TestClient::connected(), ExecutiveState::Executing, running(20.0, None));
    let waiting = running(6.4, Some(WaitReason::FreePath));
    let mut harness = report(client, ExecutiveState::Executing, waiting).shown(1440.0, 900.0);
    assert_eq!(value(&harness, "Executive"), "Executing a goal");
    assert_eq!(value(&harness, "Doing"), "Walking to 4.0, 2.0, 0.0 m");
    assert_eq!(value(&harness, "To go"), "6.4 m");
    assert!(value(&harness, "Waiting").contains("path is blocked"));
    assert_eq!(value(&harness, "Progress"), "68 %");
    click(&mut harness, "Cancel goal");
    assert!(harness.state().emitted(&ClientCommand::CancelGoal(GOAL)));
}

#[test]
fn an_outcome_shows_its_reason_what_was_tried_and_its_age_until_it_is_dismissed() {
    let client = report(TestClient::connected(), ExecutiveState::Executing, running(20.0, None));
    let tried = vec![GoalAttempt::PlannedPaths(3), GoalAttempt::WaitedForPath(Span::from_secs_f64(30.0))];
    let failed = GoalStatus::Failed { reason: GoalFailure::PathBlocked, tried };
    let mut client = report(client, ExecutiveState::Idle, failed);
    client.model.handle_event(ClientTime(121.0), ClientEvent::Tick, &mut Vec::new());
    let mut harness = client.shown(1440.0, 900.0);
    assert_eq!(
        value(&harness, "Outcome"),
        "The path stayed blocked. Choose another point or drive round by hand. Tried: 3 paths planned, waited 30 s for a free path. 2 min ago."
    );
    assert!(harness.query_by_label("Cancel goal").is_none());
    click(&mut harness, "Dismiss the outcome");
    assert!(harness.state().emitted(&ClientCommand::DismissGoal(GOAL)));
}

#[test]
fn every_state_of_the_executive_has_a_word() {
    for (state, word) in [
        (ExecutiveState::Stopped, "Motion stopped"),
        (ExecutiveState::ManualDriving, "Driven by hand"),
        (ExecutiveState::Recovering, "Relocalising"),
        (ExecutiveState::Executing, "Executing a goal"),
        (ExecutiveState::Idle, "Idle"),
    ] {
        let executive = ExecutiveStatus { state, ..ExecutiveStatus::default() };
        let client = TestClient::connected().event(Event::Executive(executive));
        let harness = client.shown(1440.0, 900.0);
        assert_eq!(value(&harness, "Executive"), word);
    }
}

/// A client of a robot that is idle, with a site of two nodes, of which the second one is a dock.
fn with_dock() -> (TestClient, DockId) {
    let part = SiteParts::new(Arc::new(SiteState::default())).next_part();
    let status = ExecutiveStatus { state: ExecutiveState::Idle, ..ExecutiveStatus::default() };
    let mut client = TestClient::connected().event(Event::SitePart(part)).event(Event::Executive(status));
    let mut last = None;
    for x in [0.0, 3.0] {
        let map = MapId(Uuid::from_u128(9));
        let (node, edit) = client.model.site.adding_node(Vec3::new(x, 0.0, 0.5), map, last);
        client = client.command(ClientCommand::EditSite(edit));
        last = Some(node);
    }
    let edit = client.model.site.making_dock(last.expect("added"));
    let client = client.command(ClientCommand::EditSite(edit));
    let dock = client.model.site.site().and_then(|site| site.docks().next()).expect("made").id;
    (client, dock)
}

#[test]
fn the_robot_is_sent_to_a_dock_or_a_node_by_its_name() {
    let (client, dock) = with_dock();
    let site = client.model.site.site().expect("a site");
    let node = site.nodes().find(|node| node.name == "N1").expect("the first one").id;
    let name = site.docks().next().map(|dock| dock.name.clone()).expect("a dock");
    let mut harness = client.shown(1440.0, 900.0);
    for (name, command) in
        [(name.as_str(), ClientCommand::GoToDock(dock)), ("N1", ClientCommand::GoToNode(node))]
    {
        click(&mut harness, "Go to");
        click(&mut harness, name);
        assert!(harness.state().emitted(&command), "{name}");
    }
    assert!(harness.query_by_label("Leave the dock").is_none(), "it is in none");
}

#[test]
fn a_robot_in_a_dock_can_leave_it() {
    let (client, dock) = with_dock();
    let route = site_model::RouteStatus { docked: Some(dock), ..site_model::RouteStatus::default() };
    let mut harness = client.event(Event::Route(route)).shown(1440.0, 900.0);
    click(&mut harness, "Leave the dock");
    assert!(harness.state().emitted(&ClientCommand::LeaveDock));
}

#[test]
fn nobody_sends_a_robot_whose_motion_is_stopped() {
    let (client, _) = with_dock();
    let client = client.event(Event::Motion(Motion::Stopped { by: None }));
    let harness = client.shown(1440.0, 900.0);
    assert!(harness.query_by_label("Go to").is_none());
}

#[test]
fn a_goal_on_the_topological_map_has_the_name_of_its_place() {
    let (client, dock) = with_dock();
    let node = client.model.site.site().and_then(|site| site.nodes().next()).expect("a node").clone();
    for (kind, words) in [
        (GoalKind::GoToNode(node.id), format!("Going to {}", node.name)),
        (GoalKind::GoToNode(NodeId(Uuid::nil())), "Going to a node".to_owned()),
        (GoalKind::GoToDock(dock), "Going to Dock".to_owned()),
    ] {
        let goal = Goal { id: GOAL, kind, by: ME, accepted: Stamp::EPOCH, status: running(6.0, None) };
        let (client, _) = with_dock();
        let harness = client.event(Event::Goals(vec![goal])).shown(1440.0, 900.0);
        assert!(value(&harness, "Doing").starts_with(&words), "{words}");
    }
}
