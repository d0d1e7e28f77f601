//! The list of missions.

use crate::test_support::missions::{carry_out, client, point, put, with_mission};
use crate::test_support::{TestClient, click};
use client_model::{ClientCommand, MissionEditorCommand};
use egui_kittest::kittest::Queryable;
use site_model::{LocalDate, LocalDateTime, LocalTime, MissionId, Object, Recurrence, Schedule, ScheduleId};
use uuid::Uuid;
use vocab::Span;

/// The list, with one mission of two tasks.
fn listed() -> (TestClient, MissionId) {
    let client = with_mission(&[point(2), point(3)]);
    let mission = client.model.missions.open().expect("open");
    (client.command(ClientCommand::MissionEditor(MissionEditorCommand::Open(None))), mission)
}

fn scheduled() -> TestClient {
    let (client, mission) = listed();
    let date = LocalDate { year: 2026, month: 11, day: 24 };
    put(
        client,
        Object::Schedule(Schedule {
            id: ScheduleId(Uuid::from_u128(1)),
            name: "Every morning".to_owned(),
            mission,
            recurrence: Recurrence::Once(LocalDateTime { date, time: LocalTime { hour: 11, minute: 0 } }),
            is_paused: false,
            skipped: Vec::new(),
            grace: Span::ZERO,
            missed: Default::default(),
            overlap: Default::default(),
            priority: 0,
        }),
    )
}

#[test]
fn a_mission_is_made_opened_and_left() {
    let mut harness = client().shown(1440.0, 900.0);
    assert!(harness.query_by_label_contains("There are no missions yet").is_some());
    click(&mut harness, "New mission");
    carry_out(&mut harness);
    assert!(
        harness.query_by_label("Mission name").is_some() && harness.query_by_label("New mission").is_none()
    );
    click(&mut harness, "All missions");
    carry_out(&mut harness);
    click(&mut harness, "Mission Mission 1");
    carry_out(&mut harness);
    assert!(harness.query_by_label("Mission name").is_some());
}

#[test]
fn a_mission_is_duplicated_and_deleted_and_both_are_undone() {
    let (client, _) = listed();
    let mut harness = client.shown(1440.0, 900.0);
    click(&mut harness, "Duplicate Mission 1");
    carry_out(&mut harness);
    click(&mut harness, "All missions");
    carry_out(&mut harness);
    assert!(harness.query_by_label("Mission Mission 1 copy").is_some());
    click(&mut harness, "Delete Mission 1 copy");
    carry_out(&mut harness);
    assert!(harness.query_by_label("Mission Mission 1 copy").is_none(), "nothing depends on it: no question");
    harness.state_mut().commands.push(ClientCommand::Undo);
    carry_out(&mut harness);
    assert!(harness.query_by_label("Mission Mission 1 copy").is_some());
}

#[test]
fn a_deletion_names_the_schedules_that_go_with_it_and_can_be_left() {
    let mut harness = scheduled().shown(1440.0, 900.0);
    click(&mut harness, "Delete Mission 1");
    assert!(harness.query_by_label_contains("Its schedules go with it: Every morning.").is_some());
    harness.key_press(egui::Key::Escape);
    harness.run_steps(2);
    assert!(!harness.state().emitted(&ClientCommand::StopMotion), "Escape belongs to the question");
    assert!(harness.query_by_label("Keep the mission").is_none());
    click(&mut harness, "Delete Mission 1");
    click(&mut harness, "Delete Mission 1 with its schedules");
    carry_out(&mut harness);
    let site = harness.state().model.site.site().expect("loaded");
    assert_eq!((site.missions().count(), site.schedules().count()), (0, 0));
}

#[test]
fn without_nodes_the_way_to_the_site_screen_is_shown() {
    let mut harness = TestClient::connected()
        .event(api::Event::SitePart(api::SiteParts::new(Default::default()).next_part()))
        .on(crate::screens::MISSIONS)
        .shown(1440.0, 900.0);
    click(&mut harness, "Go to the Site screen");
    assert!(harness.state().emitted(&ClientCommand::ShowScreen(crate::screens::SITE)));
}

#[test]
fn long_lists_are_searched() {
    let (mut client, mission) = listed();
    for _ in 0..6 {
        let (_, edit) = client.model.site.duplicating_mission(mission).expect("there");
        client = client.command(ClientCommand::EditSite(edit));
    }
    let mut harness = client.shown(1440.0, 900.0);
    harness.get_by_label("Search missions").focus();
    harness.run_steps(2);
    harness.get_by_label("Search missions").type_text("copy 4");
    harness.run_steps(3);
    assert!(harness.query_by_label("Mission Mission 1 copy 4").is_some());
    assert!(harness.query_by_label("Mission Mission 1").is_none());
}

#[test]
fn missions_are_saved_to_a_file_and_loaded_from_one() {
    let (client, _) = listed();
    let mut harness = client.shown(1440.0, 900.0);
    click(&mut harness, "Save to a file");
    assert!(harness.state().emitted(&ClientCommand::SavePlanFile));
    click(&mut harness, "Load from a file");
    assert!(harness.state().emitted(&ClientCommand::LoadPlanFile));
}
