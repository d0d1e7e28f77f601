//! Goals: which is active, how far it is, which outcome is shown and how long.

use crate::testing::*;
use crate::*;
use api::{CancelCause, Command, Control, Goal, GoalFailure, GoalKind, GoalProgress, GoalStatus, WaitReason};
use site_model::{DockId, NodeId};
use uuid::Uuid;
use vocab::{GoalId, Pose, Span, Stamp, Vec3};

fn goal(number: u128, status: GoalStatus) -> Goal {
    Goal {
        id: GoalId(Uuid::from_u128(number)),
        kind: GoalKind::WalkTo(Vec3::new(4.0, 2.0, 0.0)),
        by: ME,
        accepted: Stamp::EPOCH,
        status,
    }
}

fn running(remaining_m: Option<f64>) -> GoalStatus {
    GoalStatus::Running(GoalProgress { remaining_m, waits_for: Some(WaitReason::FreePath) })
}

fn succeeded() -> GoalStatus {
    GoalStatus::Succeeded { map_from_base: Pose::IDENTITY, duration: Span::from_secs_f64(8.0) }
}

fn report(client: &mut TestClient, goals: Vec<Goal>) {
    client.event(api::Event::Goals(goals));
}

fn outcome_of(client: &TestClient) -> Option<GoalId> {
    client.model.goals.outcome().map(|outcome| outcome.goal.id)
}

#[test]
fn walking_and_relocalising_are_goals_that_can_be_cancelled() {
    let mut client = TestClient::connected();
    client.event(api::Event::Control(Control { owner: Some(ME), name: String::new(), request: None }));
    client.command(ClientCommand::WalkTo(Vec3::new(1.0, 2.0, 0.0)));
    client.command(ClientCommand::Relocalise);
    let commands = client.take_commands();
    let [Command::StartGoal { goal: walk, kind }, Command::StartGoal { goal: search, .. }] = commands[..]
    else {
        panic!("{commands:?}")
    };
    assert_eq!(kind, GoalKind::WalkTo(Vec3::new(1.0, 2.0, 0.0)));
    assert_ne!(walk, search);
    client.command(ClientCommand::CancelGoal(search));
    assert_eq!(client.take_commands(), [Command::CancelGoal(search)]);
}

#[test]
fn places_of_the_topological_map_are_goals() {
    let mut client = TestClient::connected();
    client.event(api::Event::Control(Control { owner: Some(ME), name: String::new(), request: None }));
    let (node, dock) = (NodeId(Uuid::from_u128(5)), DockId(Uuid::from_u128(6)));
    client.command(ClientCommand::GoToNode(node));
    client.command(ClientCommand::GoToDock(dock));
    client.command(ClientCommand::LeaveDock);
    let commands = client.take_commands();
    let kinds: Vec<_> = commands
        .iter()
        .map(|command| match command {
            Command::StartGoal { kind, .. } => *kind,
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(kinds, [GoalKind::GoToNode(node), GoalKind::GoToDock(dock), GoalKind::Undock]);
}

#[test]
fn progress_is_measured_against_the_longest_path_of_the_goal() {
    let mut client = TestClient::connected();
    let progress = |client: &mut TestClient, remaining_m| {
        report(client, vec![goal(1, running(remaining_m))]);
        let goals = &client.model.goals;
        goals.active().and_then(|goal| goals.progress(goal))
    };
    assert_eq!(progress(&mut client, None), None);
    assert_eq!(progress(&mut client, Some(10.0)), Some(0.0));
    assert_eq!(progress(&mut client, Some(20.0)), Some(0.0), "a detour makes the path longer");
    assert_eq!(progress(&mut client, Some(5.0)), Some(0.75));
}

#[test]
fn an_outcome_stays_with_its_age_until_it_is_dismissed() {
    let mut client = TestClient::connected();
    report(&mut client, vec![goal(1, running(Some(3.0)))]);
    assert_eq!(outcome_of(&client), None);
    let failed = GoalStatus::Failed { reason: GoalFailure::PathBlocked, tried: Vec::new() };
    report(&mut client, vec![goal(1, failed.clone())]);
    client.wait(5.0);
    report(&mut client, vec![goal(1, failed)]);
    let outcome = client.model.goals.outcome().unwrap();
    assert_eq!(client.model.now().since(outcome.ended), 5.0, "repeating it does not make it newer");
    assert!(client.model.goals.active().is_none());
    let id = outcome.goal.id;
    client.command(ClientCommand::DismissGoal(id));
    assert_eq!(outcome_of(&client), None);
}

#[test]
fn outcomes_from_before_the_page_was_opened_are_not_shown() {
    let mut client = TestClient::connected();
    report(&mut client, vec![goal(1, succeeded())]);
    assert_eq!(outcome_of(&client), None);
    report(&mut client, vec![goal(2, succeeded()), goal(1, succeeded())]);
    assert_eq!(outcome_of(&client), Some(GoalId(Uuid::from_u128(2))));
}

#[test]
fn a_replaced_goal_shows_no_outcome() {
    let mut client = TestClient::connected();
    report(&mut client, vec![goal(1, running(None))]);
    let cause = CancelCause::Replaced(GoalId(Uuid::from_u128(2)));
    let replaced = goal(1, GoalStatus::Cancelled { by: ME, cause });
    report(&mut client, vec![goal(2, running(None)), replaced]);
    assert_eq!(outcome_of(&client), None);
    let active = client.model.goals.active().map(|goal| goal.id);
    assert_eq!(active, Some(GoalId(Uuid::from_u128(2))));
}
