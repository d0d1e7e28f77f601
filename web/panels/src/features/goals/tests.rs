//! Goals on the screen: state, progress, what it waits for, cancelling, outcome.

use crate::test_support::{ME, TestClient, click, value};
use api::{
    ExecutiveState, ExecutiveStatus, Goal, GoalAttempt, GoalFailure, GoalKind, GoalProgress, GoalStatus,
    WaitReason,
};
use client_model::{ClientCommand, ClientEvent, ClientTime};
use egui_kittest::kittest::Queryable;
use uuid::Uuid;
use vocab::{GoalId, Span, Stamp, Vec3};

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
    client.event(api::Event::Executive(executive)).event(api::Event::Goals(vec![goal]))
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
        let client = TestClient::connected().event(api::Event::Executive(executive));
        let harness = client.shown(1440.0, 900.0);
        assert_eq!(value(&harness, "Executive"), word);
    }
}
