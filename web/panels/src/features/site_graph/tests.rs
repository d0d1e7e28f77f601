//! Editing the topological map by its panel.

use crate::screens;
use crate::test_support::missions::{press, type_into as give, undo};
use crate::test_support::{TestClient, click, map, value};
use api::{Event, SiteParts, SiteState, TopomapGeneration, TopomapStage, TopomapSummary};
use client_model::{CameraMove, ClientCommand, GraphTool, Selection};
use egui_kittest::kittest::Queryable;
use site_model::{EdgeCost, EdgeFailStep, Traversal};
use std::sync::Arc;
use vocab::{MapId, Vec3};

/// A client on the Site screen that views a saved map; the robot has an empty site.
fn client() -> (TestClient, MapId) {
    let hall = map(9, "Hall");
    let id = hall.id;
    let part = SiteParts::new(Arc::new(SiteState::default())).next_part();
    let client = TestClient::connected()
        .event(Event::Maps(vec![hall]))
        .event(Event::SitePart(part))
        .command(ClientCommand::ViewMap(Some(id)))
        .on(screens::SITE);
    (client, id)
}

/// With two nodes, 3 m apart, joined both ways; the second one is selected.
fn with_two_nodes() -> TestClient {
    let (mut client, map) = client();
    let mut last = None;
    for x in [0.0, 3.0] {
        let (node, edit) = client.model.site.adding_node(Vec3::new(x, 0.0, 0.5), map, last);
        client = client.command(ClientCommand::EditSite(edit));
        last = Some(node);
    }
    client.command(ClientCommand::Select(last.map(Selection::Node)))
}

/// Carries out what the panels emitted.
fn carry_out(harness: &mut egui_kittest::Harness<'_, TestClient>) {
    let client = harness.state_mut();
    for command in std::mem::take(&mut client.commands) {
        client.model.handle_event(
            client_model::ClientTime(1.0),
            client_model::ClientEvent::Command(command),
            &mut Vec::new(),
        );
    }
    harness.run_steps(2);
}

#[test]
fn the_first_node_says_which_map_the_site_belongs_to() {
    let (client, map) = client();
    assert!(!client.model.is_site_on_screen());
    let (_, edit) = client.model.site.adding_node(Vec3::new(1.0, 2.0, 0.5), map, None);
    let client = client.command(ClientCommand::EditSite(edit));
    assert!(client.model.is_site_on_screen());
    assert_eq!(client.model.site.unconfirmed(), 1);
}

#[test]
fn a_tool_is_on_until_it_is_pressed_again_or_escape_is() {
    let (client, _) = client();
    let mut harness = client.shown(1440.0, 900.0);
    click(&mut harness, "Add nodes");
    assert!(harness.state().emitted(&ClientCommand::UseGraphTool(Some(GraphTool::AddNodes))));
    carry_out(&mut harness);
    assert_eq!(harness.state().model.graph_tool(), Some(GraphTool::AddNodes));
    harness.key_press(egui::Key::Escape);
    harness.run_steps(2);
    carry_out(&mut harness);
    assert_eq!(harness.state().model.graph_tool(), None);
}

#[test]
fn a_node_is_renamed_given_a_kind_and_deleted_and_each_is_undone() {
    let mut harness = with_two_nodes().shown(1440.0, 2400.0);
    assert_eq!((value(&harness, "Nodes"), value(&harness, "Edges")), ("2".to_owned(), "2".to_owned()));
    click(&mut harness, "Inspection");
    carry_out(&mut harness);
    harness.get_by_label("Node name").focus();
    harness.run_steps(2);
    harness.get_by_label("Node name").type_text(" pump");
    harness.run_steps(2);
    click(&mut harness, "Rename node");
    carry_out(&mut harness);
    let names = |harness: &egui_kittest::Harness<'_, TestClient>| -> Vec<String> {
        let mut names: Vec<_> = harness
            .state()
            .model
            .site
            .site()
            .into_iter()
            .flat_map(|site| site.nodes())
            .map(|node| node.name.clone())
            .collect();
        names.sort();
        names
    };
    let renamed = names(&harness);
    assert!(renamed.iter().any(|name| name.contains("pump")), "{renamed:?}");
    let name = renamed.iter().find(|name| name.contains("pump")).unwrap().clone();
    click(&mut harness, &format!("Delete node {name}"));
    carry_out(&mut harness);
    assert_eq!((value(&harness, "Nodes"), value(&harness, "Edges")), ("1".to_owned(), "0".to_owned()));
    for _ in 0..2 {
        harness.state_mut().commands.push(ClientCommand::Undo);
        carry_out(&mut harness);
    }
    assert_eq!((value(&harness, "Nodes"), value(&harness, "Edges")), ("2".to_owned(), "2".to_owned()));
    assert_eq!(names(&harness), ["N1", "N2"]);
}

#[test]
fn an_edge_is_made_one_way_disabled_and_split() {
    let mut harness = with_two_nodes().shown(1440.0, 2400.0);
    click(&mut harness, "Edge N2 to N1");
    carry_out(&mut harness);
    click(&mut harness, "Routes may use it");
    carry_out(&mut harness);
    let enabled = |harness: &egui_kittest::Harness<'_, TestClient>| {
        harness.state().model.site.site().unwrap().edges().filter(|edge| edge.is_enabled).count()
    };
    assert_eq!(enabled(&harness), 0, "both directions");
    click(&mut harness, "Split edge");
    carry_out(&mut harness);
    assert_eq!((value(&harness, "Nodes"), value(&harness, "Edges")), ("3".to_owned(), "4".to_owned()));
    click(&mut harness, "Edge N3 to N1");
    carry_out(&mut harness);
    click(&mut harness, "Both ways");
    carry_out(&mut harness);
    assert_eq!(value(&harness, "Edges"), "3");
}

#[test]
fn actions_along_an_edge_and_what_is_tried_when_it_is_blocked_hold_in_both_directions() {
    let mut harness = with_two_nodes().shown(1440.0, 2400.0);
    let press = |harness: &mut egui_kittest::Harness<'_, TestClient>, name: &str| {
        click(harness, name);
        carry_out(harness);
    };
    press(&mut harness, "Edge N2 to N1");
    press(&mut harness, "Before setting out: add an action");
    press(&mut harness, "Wait");
    harness.get_by_label("Time, s").focus();
    harness.run_steps(2);
    harness.get_by_label("Time, s").type_text("9");
    harness.run_steps(2);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(2);
    carry_out(&mut harness);
    press(&mut harness, "After arriving: add an action");
    press(&mut harness, "Photo");
    press(&mut harness, "Add a step");
    press(&mut harness, "More: Tries 1");
    press(&mut harness, "Add a step");
    press(&mut harness, "Step 2");
    press(&mut harness, "Give up");
    let edges = |harness: &egui_kittest::Harness<'_, TestClient>| {
        harness.state().model.site.site().expect("a site").edges().cloned().collect::<Vec<_>>()
    };
    for edge in edges(&harness) {
        assert_eq!(edge.on_enter[0].action, "wait");
        assert_eq!(edge.on_enter[0].parameters["duration_s"], site_model::Parameter::Integer(9));
        assert_eq!(edge.on_leave[0].action, "photo");
        assert!(edge.during.is_empty());
        assert_eq!(edge.fail_policy, [EdgeFailStep::Retry(2), EdgeFailStep::Fail]);
    }
    click(&mut harness, "Add a step");
    carry_out(&mut harness);
    assert_eq!(edges(&harness)[0].fail_policy.len(), 2, "nothing comes after giving up");
    press(&mut harness, "Remove Before setting out 1: Wait");
    press(&mut harness, "Remove Step 2");
    assert!(edges(&harness).iter().all(|edge| edge.on_enter.is_empty() && edge.fail_policy.len() == 1));
}

#[test]
fn fields_move_and_turn_a_node_and_set_how_an_edge_is_used() {
    let mut harness = with_two_nodes().shown(1440.0, 2400.0);
    click(&mut harness, "More: x (m)");
    carry_out(&mut harness);
    click(&mut harness, "More: Heading (°)");
    carry_out(&mut harness);
    click(&mut harness, "More: Floor");
    carry_out(&mut harness);
    let node = |harness: &egui_kittest::Harness<'_, TestClient>| {
        let model = &harness.state().model;
        let node = model.selected_nodes().first().copied().expect("selected");
        model.site.site().and_then(|site| site.node(node)).expect("a node").clone()
    };
    let after = node(&harness);
    assert!((after.map_from_node.position.x - 3.1).abs() < 1e-9);
    assert!((crate::heading::heading_deg(&after.map_from_node.orientation) - 15.0).abs() < 0.01);
    assert_eq!(after.floor, 1);
    harness.state_mut().commands.push(ClientCommand::Undo);
    carry_out(&mut harness);
    assert_eq!(node(&harness).floor, 0);

    click(&mut harness, "Edge N2 to N1");
    carry_out(&mut harness);
    click(&mut harness, "More: Speed (m/s)");
    carry_out(&mut harness);
    click(&mut harness, "Less: Room left (m)");
    carry_out(&mut harness);
    let model = &harness.state().model;
    let edges: Vec<_> = model.site.site().expect("a site").edges().collect();
    assert!(edges.iter().all(|edge| edge.max_speed_m_s == Some(0.1)), "both directions");
    let of_selected = |edge: &&&site_model::Edge| model.selection() == Some(Selection::Edge(edge.id));
    let selected = edges.iter().find(of_selected).expect("selected");
    let back = edges.iter().find(|edge| edge.id != selected.id).expect("the other");
    assert!((selected.corridor.left_m - 0.9).abs() < 1e-9 && (back.corridor.right_m - 0.9).abs() < 1e-9);
    assert!((selected.corridor.right_m - 1.0).abs() < 1e-9);
}

#[test]
fn all_nodes_are_selected_by_keys_changed_and_deleted_together() {
    let mut harness = with_two_nodes().shown(1440.0, 2400.0);
    harness.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    harness.run_steps(2);
    carry_out(&mut harness);
    assert_eq!(value(&harness, "Selected"), "2");
    click(&mut harness, "Hold");
    carry_out(&mut harness);
    click(&mut harness, "More: Middle, x (m)");
    carry_out(&mut harness);
    let xs = |harness: &egui_kittest::Harness<'_, TestClient>| -> Vec<i64> {
        let nodes = harness.state().model.site.site().into_iter().flat_map(|site| site.nodes());
        let mut xs: Vec<i64> =
            nodes.map(|node| (10.0 * node.map_from_node.position.x).round() as i64).collect();
        xs.sort_unstable();
        xs
    };
    assert_eq!(xs(&harness), [1, 31]);
    harness.key_press(egui::Key::Delete);
    harness.run_steps(2);
    carry_out(&mut harness);
    assert_eq!((value(&harness, "Nodes"), value(&harness, "Edges")), ("0".to_owned(), "0".to_owned()));
    for _ in 0..2 {
        harness.state_mut().commands.push(ClientCommand::Undo);
        carry_out(&mut harness);
    }
    assert_eq!(xs(&harness), [0, 30]);
}

#[test]
fn escape_belongs_to_a_drag_in_the_scene_and_what_obstructs_is_said() {
    let mut client = with_two_nodes();
    let obstruction = crate::DragObstruction { from: "N1".into(), to: "N2".into(), along_m: 1.2, others: 1 };
    client.panels.set_scene_drag(crate::SceneDrag { is_active: true, obstruction: Some(obstruction) });
    let mut harness = client.shown(1440.0, 900.0);
    let is_said = |text: Option<String>| {
        text.as_deref()
            == Some("Something stands between N1 and N2, 1.2 m from N1. One more edge is not free.")
    };
    assert!(harness.query_all_by(|node| is_said(node.value())).next().is_some());
    harness.key_press(egui::Key::Escape);
    harness.run_steps(2);
    assert!(!harness.state().emitted(&ClientCommand::StopMotion));
    assert!(!harness.state().emitted(&ClientCommand::Select(None)));
}

#[test]
fn floors_are_offered_where_there_are_several() {
    let mut harness = with_two_nodes().shown(1440.0, 2400.0);
    assert!(harness.query_by_label("All floors").is_none());
    click(&mut harness, "More: Floor");
    carry_out(&mut harness);
    click(&mut harness, "Floor 1");
    assert!(harness.state().emitted(&ClientCommand::ShowFloor(Some(1))));
}

#[test]
fn problems_are_listed_and_select_their_object() {
    let (client, map) = client();
    let (node, edit) = client.model.site.adding_node(Vec3::new(0.0, 0.0, 0.5), map, None);
    let client = client.command(ClientCommand::EditSite(edit));
    let edit = client.model.site.changing_node(node, |node| node.name.clear());
    let mut harness = client.command(ClientCommand::EditSite(edit)).shown(1440.0, 900.0);
    harness.get_by_label_contains("it has no name").click();
    harness.run_steps(2);
    assert!(harness.state().emitted(&ClientCommand::Select(Some(Selection::Node(node)))));
}

#[test]
fn nothing_can_be_edited_while_another_map_is_on_the_screen() {
    let other = map(10, "Yard");
    let other_id = other.id;
    let client = with_two_nodes().event(Event::Maps(vec![map(9, "Hall"), other]));
    let mut harness = client.command(ClientCommand::ViewMap(Some(other_id))).shown(1440.0, 900.0);
    assert!(harness.query_by_label("Add nodes").is_none());
    assert!(!crate::is_editing_graph(&harness.state().model));
    click(&mut harness, "View its map");
    assert!(harness.state().emitted(&ClientCommand::ViewMap(Some(map(9, "Hall").id))));
}

#[test]
fn an_empty_site_is_made_from_the_map_by_one_click() {
    let (client, map) = client();
    let mut harness = client.shown(1440.0, 900.0);
    click(&mut harness, "Make from the map");
    assert!(harness.state().emitted(&ClientCommand::GenerateTopomap(map)));
}

#[test]
fn a_topological_map_is_only_replaced_after_a_question() {
    let mut harness = with_two_nodes().shown(1440.0, 900.0);
    let map = harness.state().model.saved_map_on_screen().expect("viewed");
    click(&mut harness, "Make from the map");
    click(&mut harness, "Keep them");
    assert!(!harness.state().emitted(&ClientCommand::GenerateTopomap(map)));
    click(&mut harness, "Make from the map");
    harness.key_press(egui::Key::Escape);
    harness.run_steps(2);
    assert!(harness.query_by_label("Replace them").is_none(), "Escape means no");
    click(&mut harness, "Make from the map");
    click(&mut harness, "Replace them");
    assert!(harness.state().emitted(&ClientCommand::GenerateTopomap(map)));
}

#[test]
fn the_making_shows_its_stage_and_then_what_was_made_with_its_problems() {
    let (client, map) = client();
    let running = TopomapGeneration::Running { map, stage: TopomapStage::Generating };
    let client = client.event(Event::TopomapGeneration(running));
    let harness = client.shown(1440.0, 900.0);
    assert!(value(&harness, "Making the topological map").contains("ways"));
    assert!(harness.query_by_label("Make from the map").is_none());

    let (client, map) = self::client();
    let ends = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(3.0, 0.0, 0.0)];
    let summary = TopomapSummary {
        nodes: 42,
        edges: 96,
        docks: 1,
        floors: 2,
        length_m: 210.0,
        pieces: 2,
        blocked: vec![ends],
        kept_nodes: 0,
    };
    let edit = site_model::EditId(uuid::Uuid::from_u128(1));
    let mut harness = client
        .event(Event::TopomapGeneration(TopomapGeneration::Running { map, stage: TopomapStage::Storing }))
        .event(Event::TopomapGeneration(TopomapGeneration::Done { map, edit, summary }))
        .shown(1440.0, 1200.0);
    assert_eq!(value(&harness, "Result"), "Made 42 nodes, 96 edges and 1 dock on 2 floors: 210.0 m of ways.");
    harness.get_by_label_contains("2 pieces");
    click(&mut harness, "Blocked stretch 1 · 2.0 m");
    let there = ClientCommand::MoveCamera(CameraMove::Point(Vec3::new(2.0, 0.0, 0.0)));
    assert!(harness.state().emitted(&there));
    click(&mut harness, "Dismiss the result");
    assert!(harness.state().emitted(&ClientCommand::DismissTopomapResult));
}

/// Types a text into a field and leaves it.
fn type_into(harness: &mut egui_kittest::Harness<'_, TestClient>, field: &str, text: &str) {
    harness.get_by_label(field).focus();
    harness.run_steps(2);
    for _ in 0..8 {
        harness.key_press(egui::Key::Backspace);
    }
    harness.get_by_label(field).type_text(text);
    harness.run_steps(2);
}

#[test]
fn how_near_counts_as_reached_is_typed_and_what_is_out_of_range_is_explained_at_the_field() {
    let mut harness = with_two_nodes().shown(1440.0, 2600.0);
    let tolerance = |harness: &egui_kittest::Harness<'_, TestClient>| {
        let model = &harness.state().model;
        let node = model.selected_nodes().first().copied().expect("selected");
        model.site.site().and_then(|site| site.node(node)).expect("a node").tolerance
    };
    let before = tolerance(&harness);
    type_into(&mut harness, "Turned (°)", "500");
    assert!(harness.query_by_label_contains("Turned (°) must be from 0.5 to 180.").is_some());
    type_into(&mut harness, "Turned (°)", "10");
    assert!(harness.query_by_label_contains("Turned (°) must be").is_none());
    harness.key_press(egui::Key::Enter);
    harness.run_steps(2);
    carry_out(&mut harness);
    click(&mut harness, "More: Ahead (m)");
    carry_out(&mut harness);
    let after = tolerance(&harness);
    assert!((after.yaw_rad.to_degrees() - 10.0).abs() < 1e-9 && (after.along_m - 0.15).abs() < 1e-9);
    assert_eq!(after.across_m, before.across_m);
    for _ in 0..2 {
        harness.state_mut().commands.push(ClientCommand::Undo);
        carry_out(&mut harness);
    }
    assert_eq!(tolerance(&harness), before);
}

#[test]
fn cost_group_and_traversal_by_an_action_of_the_robot_are_set_for_both_directions() {
    let lift = api::OfferedAction {
        name: "ride_lift".to_owned(),
        title: "Ride the lift".to_owned(),
        parameter_schema:
            r#"{ "type": "object", "properties": { "floor": { "type": "integer", "title": "To floor" } } }"#
                .to_owned(),
        expected: vocab::Span::from_millis(60_000),
        expected_energy_j: 0,
        is_idempotent: false,
    };
    let mut harness = with_two_nodes().event(Event::Actions(vec![lift])).shown(1440.0, 2600.0);
    let edges = |harness: &egui_kittest::Harness<'_, TestClient>| {
        harness.state().model.site.site().expect("a site").edges().cloned().collect::<Vec<_>>()
    };
    let before = edges(&harness);
    let press = |harness: &mut egui_kittest::Harness<'_, TestClient>, name: &str| {
        click(harness, name);
        carry_out(harness);
    };
    press(&mut harness, "Edge N2 to N1");
    press(&mut harness, "Fixed");
    press(&mut harness, "More: Cost (s)");
    assert!(edges(&harness).iter().all(|edge| edge.cost == EdgeCost::Fixed(15.0)));
    type_into(&mut harness, "One robot at a time", " Lift A ");
    harness.key_press(egui::Key::Enter);
    harness.run_steps(2);
    carry_out(&mut harness);
    assert!(edges(&harness).iter().all(|edge| edge.mutex_group.as_deref() == Some("Lift A")));
    press(&mut harness, "Traversal");
    press(&mut harness, "Ride the lift");
    type_into(&mut harness, "To floor", "2");
    harness.key_press(egui::Key::Enter);
    harness.run_steps(2);
    carry_out(&mut harness);
    for edge in edges(&harness) {
        let Traversal::Action { name, parameters } = edge.traversal else { panic!("{edge:?}") };
        assert_eq!((&*name, &parameters["floor"]), ("ride_lift", &site_model::Parameter::Integer(2)));
    }
    for _ in 0..5 {
        harness.state_mut().commands.push(ClientCommand::Undo);
        carry_out(&mut harness);
    }
    assert_eq!(edges(&harness), before, "each of the five is one step");
}

#[test]
fn a_dock_gets_a_name_and_is_listed() {
    let mut harness = with_two_nodes().shown(1440.0, 2800.0);
    press(&mut harness, "Make it a dock");
    give(&mut harness, "Dock name", "Charger north");
    let docks = |harness: &egui_kittest::Harness<'_, TestClient>| -> Vec<site_model::Dock> {
        harness.state().model.site.site().unwrap().docks().cloned().collect()
    };
    let dock = docks(&harness)[0].clone();
    assert_eq!(dock.name, "Charger north");
    harness.state_mut().commands.push(ClientCommand::Select(None));
    carry_out(&mut harness);
    press(&mut harness, "Dock Charger north");
    assert_eq!(harness.state().model.selection(), Some(Selection::Node(dock.node)));
    let site = harness.state().model.site.site().unwrap();
    let other = site.nodes().find(|node| node.id != dock.node && node.id != dock.approach).unwrap().id;
    let edit = harness.state().model.site.connecting(other, dock.node);
    harness.state_mut().commands.push(ClientCommand::EditSite(edit));
    carry_out(&mut harness);
    press(&mut harness, "Approached from");
    press(&mut harness, "N1");
    assert_eq!(docks(&harness)[0].approach, other);
    undo(&mut harness);
    assert_eq!(docks(&harness)[0].approach, dock.approach);
}

#[test]
fn a_node_gets_tags_properties_and_an_area_in_which_the_robot_is_there() {
    let mut harness = with_two_nodes().shown(1440.0, 2800.0);
    let node = |harness: &egui_kittest::Harness<'_, TestClient>| {
        let Some(Selection::Node(node)) = harness.state().model.selection() else { panic!("a node") };
        harness.state().model.site.site().unwrap().node(node).unwrap().clone()
    };
    give(&mut harness, "Tags", "gate, south");
    assert_eq!(node(&harness).tags.len(), 2);
    give(&mut harness, "New property", "owner: maintenance");
    give(&mut harness, "New property", "no value");
    assert_eq!(node(&harness).properties, [("owner".to_owned(), "maintenance".to_owned())].into());
    give(&mut harness, "owner", "operations");
    assert_eq!(node(&harness).properties["owner"], "operations");
    give(&mut harness, "owner", "");
    assert!(node(&harness).properties.is_empty());
    press(&mut harness, "In an area too");
    press(&mut harness, "More: 1: x (m)");
    assert!((node(&harness).influence_area_m[0][0] - 0.6).abs() < 1e-9);
    press(&mut harness, "Near it");
    assert!(node(&harness).influence_area_m.is_empty());
    undo(&mut harness);
    assert_eq!(node(&harness).influence_area_m.len(), 4);
}

#[test]
fn blocked_edges_say_why_and_are_unblocked_and_groups_are_held_and_released() {
    let client = with_two_nodes();
    let site = client.model.site.site().unwrap();
    let edges: Vec<_> = site.edges().cloned().collect();
    let block = |edge: &site_model::Edge| {
        let reason = "The path is blocked at 1.0, 2.0 m.".to_owned();
        let until = vocab::Stamp::from_secs_f64(90.0);
        site_model::Object::EdgeBlock(site_model::EdgeBlock { edge: edge.id, until, failures: 3, reason })
    };
    let put = edges.iter().map(block).collect();
    let edit = client_model::SiteEdit { put, removed: Vec::new() };
    let mut harness = client
        .command(ClientCommand::EditSite(edit))
        .command(ClientCommand::Select(Some(Selection::Edge(edges[0].id))))
        .shown(1440.0, 3200.0);
    let blocks = |harness: &egui_kittest::Harness<'_, TestClient>| {
        harness.state().model.site.site().unwrap().edge_blocks().count()
    };
    let said = harness.query_all_by_label("Block of N1 → N2").next().and_then(|node| node.value());
    let said = said.or_else(|| Some(value(&harness, "Block of N2 → N1"))).unwrap();
    assert!(said.contains("blocked at 1.0, 2.0 m") && said.contains("tried 3 times"), "{said}");
    harness.state_mut().commands.push(ClientCommand::Select(None));
    carry_out(&mut harness);
    press(&mut harness, "Unblock N1 → N2 now");
    assert_eq!(blocks(&harness), 0, "both directions");
    undo(&mut harness);
    assert_eq!(blocks(&harness), 2);

    press(&mut harness, "Show N2 → N1");
    give(&mut harness, "One robot at a time", "Corridor");
    press(&mut harness, "Hold Corridor");
    assert!(harness.query_all_by_label_contains("holds Corridor (2 edges)").next().is_some());
    harness.state_mut().commands.push(ClientCommand::Select(None));
    carry_out(&mut harness);
    press(&mut harness, "Release Corridor");
    assert!(harness.state().model.site.mutex_holds().is_empty());
}
