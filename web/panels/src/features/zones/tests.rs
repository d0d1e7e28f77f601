//! Zones by their panel.

use crate::screens;
use crate::test_support::missions::type_into;
use crate::test_support::{TestClient, click, map};
use api::{Event, SiteParts, SiteState};
use client_model::{ClientCommand, GraphTool, Selection};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use site_model::{LocalTime, Zone, ZoneEffect};
use std::sync::Arc;
use vocab::Vec3;

const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]];

/// A client on the Site screen with nodes on two floors.
fn client() -> TestClient {
    let hall = map(9, "Hall");
    let id = hall.id;
    let part = SiteParts::new(Arc::new(SiteState::default())).next_part();
    let mut client = TestClient::connected()
        .event(Event::Maps(vec![hall]))
        .event(Event::SitePart(part))
        .command(ClientCommand::ViewMap(Some(id)))
        .on(screens::SITE);
    for (z, floor) in [(0.5, 0), (4.5, 1)] {
        let (node, edit) = client.model.site.adding_node(Vec3::new(0.0, 0.0, z), id, None);
        client = client.command(ClientCommand::EditSite(edit));
        let edit = client.model.site.changing_node(node, |node| node.floor = floor);
        client = client.command(ClientCommand::EditSite(edit));
    }
    client
}

/// With a zone, which is selected.
fn with_zone<'a>() -> Harness<'a, TestClient> {
    let client = client();
    let (zone, edit) = client.model.site.adding_zone(CORNERS.to_vec());
    let client = client.command(ClientCommand::EditSite(edit));
    let mut harness =
        client.command(ClientCommand::Select(Some(Selection::Zone(zone)))).shown(1440.0, 2000.0);
    harness.run_steps(2);
    harness
}

fn carry_out(harness: &mut Harness<'_, TestClient>) {
    let client = harness.state_mut();
    for command in std::mem::take(&mut client.commands) {
        let event = client_model::ClientEvent::Command(command);
        client.model.handle_event(client_model::ClientTime(1.0), event, &mut Vec::new());
    }
    harness.run_steps(2);
}

fn press(harness: &mut Harness<'_, TestClient>, name: &str) {
    click(harness, name);
    carry_out(harness);
}

fn zone(harness: &Harness<'_, TestClient>) -> Zone {
    harness.state().model.site.zones()[0].clone()
}

#[test]
fn the_next_drag_draws_a_zone_and_escape_ends_that() {
    let mut harness = client().shown(1440.0, 1200.0);
    press(&mut harness, "Zones");
    press(&mut harness, "Draw a zone");
    assert_eq!(harness.state().model.graph_tool(), Some(GraphTool::DrawZone));
    harness.key_press(egui::Key::Escape);
    harness.run_steps(2);
    carry_out(&mut harness);
    assert_eq!(harness.state().model.graph_tool(), None);
}

#[test]
fn what_holds_in_a_zone_is_chosen_with_its_number() {
    let mut harness = with_zone();
    press(&mut harness, "Speed limit");
    assert_eq!(zone(&harness).effect, ZoneEffect::SpeedLimit(0.3));
    press(&mut harness, "More: At most (m/s)");
    match zone(&harness).effect {
        ZoneEffect::SpeedLimit(speed) => assert!((speed - 0.4).abs() < 1e-9, "{speed}"),
        other => panic!("{other:?}"),
    }
    assert!(harness.query_by_label("Zone Zone 1").is_some());
    press(&mut harness, "Penalty");
    press(&mut harness, "Less: Factor");
    assert_eq!(zone(&harness).effect, ZoneEffect::Penalty(2.0));
    for _ in 0..4 {
        harness.state_mut().commands.push(ClientCommand::Undo);
        carry_out(&mut harness);
    }
    assert_eq!(zone(&harness).effect, ZoneEffect::KeepOut);
}

#[test]
fn a_zone_calls_an_action_with_its_parameters() {
    let mut harness = with_zone();
    press(&mut harness, "Action");
    let action = |harness: &Harness<'_, TestClient>| match zone(harness).effect {
        ZoneEffect::Action(request) => request,
        other => panic!("{other:?}"),
    };
    assert_eq!(action(&harness).action, "message");
    type_into(&mut harness, "Text", "Mind the gate.");
    // Enter begins another line in a field of several.
    harness.get_by_label("Zone name").focus();
    harness.run_steps(2);
    carry_out(&mut harness);
    let text = action(&harness).parameters["text"].clone();
    assert_eq!(text, site_model::Parameter::Text("Mind the gate.".into()));
    press(&mut harness, "Action on entering");
    press(&mut harness, "Photo");
    assert_eq!(action(&harness).action, "photo");
    assert!(action(&harness).parameters.is_empty());
    harness.state_mut().commands.push(ClientCommand::Undo);
    carry_out(&mut harness);
    assert_eq!(action(&harness).parameters["text"], text);
}

#[test]
fn a_zone_holds_on_a_floor_or_between_heights_and_at_some_hours() {
    let mut harness = with_zone();
    press(&mut harness, "Only floor 1");
    assert_eq!(zone(&harness).height_m, Some([3.5, 6.0]));
    press(&mut harness, "Less: To (m)");
    assert_eq!(zone(&harness).height_m, Some([3.5, 5.5]));
    press(&mut harness, "All heights");
    assert_eq!(zone(&harness).height_m, None);
    press(&mut harness, "Every day");
    let hour = |hour| LocalTime { hour, minute: 0 };
    assert_eq!(zone(&harness).daily, Some([hour(8), hour(17)]));
    harness.get_by_label("Until").focus();
    harness.run_steps(2);
    for _ in 0..5 {
        harness.key_press(egui::Key::Backspace);
    }
    harness.get_by_label("Until").type_text("22");
    harness.run_steps(2);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(2);
    carry_out(&mut harness);
    assert_eq!(zone(&harness).daily, Some([hour(8), hour(22)]));
    press(&mut harness, "Always");
    assert_eq!(zone(&harness).daily, None);
}

#[test]
fn corners_are_numbers_too_and_three_of_them_stay() {
    let mut harness = with_zone();
    press(&mut harness, "4 corners");
    press(&mut harness, "More: 3: y (m)");
    assert!((zone(&harness).corners_m[2][1] - 1.1).abs() < 1e-9);
    press(&mut harness, "Remove corner 4");
    assert_eq!(zone(&harness).corners_m.len(), 3);
    press(&mut harness, "Remove corner 1");
    assert_eq!(zone(&harness).corners_m.len(), 3, "the button is disabled");
    press(&mut harness, "Add a corner");
    assert_eq!(zone(&harness).corners_m[3], [1.0, 0.55]);
}

#[test]
fn a_zone_is_deleted_by_button_and_key_and_comes_back() {
    let mut harness = with_zone();
    press(&mut harness, "Delete zone Zone 1");
    assert!(harness.state().model.site.zones().is_empty());
    harness.state_mut().commands.push(ClientCommand::Undo);
    carry_out(&mut harness);
    press(&mut harness, "Zone Zone 1");
    harness.key_press(egui::Key::Delete);
    harness.run_steps(2);
    carry_out(&mut harness);
    assert!(harness.state().model.site.zones().is_empty());
}
