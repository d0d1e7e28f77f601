//! Inspection points by their panel.

use crate::screens;
use crate::test_support::missions::{press, type_into, undo};
use crate::test_support::{TestClient, click, map, value};
use api::{Event, SiteParts, SiteState};
use client_model::{ClientCommand, GraphTool, Selection};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use site_model::{InspectionPoint, NodeId, ReadingLimits};
use std::sync::Arc;
use vocab::Vec3;

/// A client on the Site screen with a node, which is selected.
fn with_node() -> (TestClient, NodeId) {
    let hall = map(9, "Hall");
    let id = hall.id;
    let part = SiteParts::new(Arc::new(SiteState::default())).next_part();
    let client = TestClient::connected()
        .event(Event::Maps(vec![hall]))
        .event(Event::SitePart(part))
        .command(ClientCommand::ViewMap(Some(id)))
        .on(screens::SITE);
    let (node, edit) = client.model.site.adding_node(Vec3::new(0.0, 0.0, 0.5), id, None);
    let client = client.command(ClientCommand::EditSite(edit));
    (client.command(ClientCommand::Select(Some(Selection::Node(node)))), node)
}

/// With an inspection point 2 m ahead of the node, which is selected.
fn with_point<'a>() -> Harness<'a, TestClient> {
    let (client, node) = with_node();
    let (point, edit) = client.model.site.adding_inspection_point(node, Vec3::new(2.0, 0.0, 0.5));
    let client = client.command(ClientCommand::EditSite(edit));
    client.command(ClientCommand::Select(Some(Selection::InspectionPoint(point)))).shown(1440.0, 1700.0)
}

fn carry_out(harness: &mut Harness<'_, TestClient>) {
    let client = harness.state_mut();
    for command in std::mem::take(&mut client.commands) {
        let event = client_model::ClientEvent::Command(command);
        client.model.handle_event(client_model::ClientTime(1.0), event, &mut Vec::new());
    }
    harness.run_steps(2);
}

fn points(harness: &Harness<'_, TestClient>) -> Vec<InspectionPoint> {
    harness.state().model.site.inspection_points().into_iter().cloned().collect()
}

#[test]
fn clicks_make_inspection_points_while_the_tool_is_on_and_escape_ends_it() {
    let (client, _) = with_node();
    let mut harness = client.shown(1440.0, 1200.0);
    click(&mut harness, "Inspection points");
    click(&mut harness, "Add inspection points");
    assert!(harness.state().emitted(&ClientCommand::UseGraphTool(Some(GraphTool::AddInspectionPoints))));
    carry_out(&mut harness);
    let is_hint = |text: Option<String>| text.is_some_and(|text| text.starts_with("Click the things"));
    assert!(harness.query_all_by(|node| is_hint(node.value())).next().is_some());
    harness.key_press(egui::Key::Escape);
    harness.run_steps(2);
    carry_out(&mut harness);
    assert_eq!(harness.state().model.graph_tool(), None);
}

#[test]
fn another_node_is_chosen_to_look_from() {
    let (client, near) = with_node();
    let (far, edit) = client.model.site.adding_node(Vec3::new(-3.0, 0.0, 0.5), map(9, "Hall").id, None);
    let client = client.command(ClientCommand::EditSite(edit));
    let (point, edit) = client.model.site.adding_inspection_point(near, Vec3::new(2.0, 0.0, 0.5));
    let client = client.command(ClientCommand::EditSite(edit));
    let selected = Some(Selection::InspectionPoint(point));
    let mut harness = client.command(ClientCommand::Select(selected)).shown(1440.0, 1700.0);
    harness.run_steps(2);
    click(&mut harness, "Seen from");
    click(&mut harness, "N2 · 5.0 m");
    carry_out(&mut harness);
    assert_eq!(points(&harness)[0].node, far);
    assert_eq!(value(&harness, "Stand-off"), "5.0 m");
}

#[test]
fn a_point_selected_in_the_scene_opens_its_tab_with_node_and_stand_off() {
    let mut harness = with_point();
    harness.run_steps(2);
    assert_eq!(value(&harness, "Stand-off"), "2.0 m");
    click(&mut harness, "Pick the target anew");
    assert!(harness.state().emitted(&ClientCommand::UseGraphTool(Some(GraphTool::PickTarget))));
}

#[test]
fn a_point_is_renamed_given_another_action_and_deleted_and_each_is_undone() {
    let mut harness = with_point();
    harness.run_steps(2);
    harness.get_by_label("Inspection point name").focus();
    harness.run_steps(2);
    harness.get_by_label("Inspection point name").type_text(" gauge");
    harness.run_steps(2);
    click(&mut harness, "Rename inspection point");
    carry_out(&mut harness);
    assert!(points(&harness)[0].name.contains("gauge"), "{:?}", points(&harness));
    click(&mut harness, "Action");
    click(&mut harness, "Thermal photo");
    carry_out(&mut harness);
    assert_eq!(points(&harness)[0].request.action, "thermal_photo");
    let name = format!("Delete inspection point {}", points(&harness)[0].name);
    click(&mut harness, &name);
    carry_out(&mut harness);
    assert!(points(&harness).is_empty());
    for _ in 0..3 {
        harness.state_mut().commands.push(ClientCommand::Undo);
        carry_out(&mut harness);
    }
    let after = points(&harness);
    assert_eq!((after[0].name.as_str(), after[0].request.action.as_str()), ("P1", "photo"));
}

#[test]
fn the_form_of_the_action_has_no_fields_for_what_the_target_aims() {
    let mut harness = with_point();
    harness.run_steps(2);
    assert!(harness.query_by_label("Pan, °").is_none(), "the target aims the camera");
    harness.get_by_label("Zoom").focus();
    harness.run_steps(2);
    harness.get_by_label("Zoom").type_text("4");
    harness.run_steps(2);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(2);
    carry_out(&mut harness);
    let zoom = points(&harness)[0].request.parameters.get("zoom").cloned();
    assert_eq!(zoom, Some(site_model::Parameter::Integer(4)));
}

#[test]
fn the_node_is_placed_at_a_distance_and_turned_and_the_line_of_sight_is_said() {
    let mut harness = with_point();
    harness.run_steps(2);
    let sight = harness.state().panels.camera_preview().expect("room for the picture").sight;
    assert_eq!(value(&harness, "Camera view"), "The points of the map are being looked at.");
    let check = crate::SightCheck { sight, blocked_m: Some(1.2) };
    harness.state_mut().panels.set_sight_check(check);
    harness.run_steps(2);
    assert!(value(&harness, "Camera view").starts_with("Something stands in the way, 1.2 m"));
    click(&mut harness, "Less: Stand off (m)");
    carry_out(&mut harness);
    assert_eq!(value(&harness, "Stand-off"), "1.9 m");
    let before = value(&harness, "Camera view");
    assert_eq!(before, "The points of the map are being looked at.", "the check was of another place");
}

#[test]
fn limits_of_the_reading_have_a_unit_and_stay_in_order() {
    let mut harness = with_point();
    let limits = |harness: &Harness<'_, TestClient>| points(harness)[0].limits.clone();
    press(&mut harness, "Reading");
    press(&mut harness, "Temperature (°C)");
    assert_eq!(limits(&harness), Some(ReadingLimits { min: None, max: None, unit: "°C".into() }));
    type_into(&mut harness, "At most (°C)", "60");
    type_into(&mut harness, "At least (°C)", "-5,5");
    let wanted = ReadingLimits { min: Some(-5.5), max: Some(60.0), unit: "°C".into() };
    assert_eq!(limits(&harness), Some(wanted.clone()));
    type_into(&mut harness, "At least (°C)", "80");
    assert_eq!(limits(&harness).and_then(|limits| limits.min), Some(59.99), "below the greater one");
    undo(&mut harness);
    assert_eq!(limits(&harness), Some(wanted));
    type_into(&mut harness, "At most (°C)", "");
    assert_eq!(limits(&harness).and_then(|limits| limits.max), None);
    press(&mut harness, "Reading");
    press(&mut harness, "Not judged");
    assert_eq!(limits(&harness), None);
}
