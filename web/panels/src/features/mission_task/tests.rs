//! The form of a task.

use crate::test_support::missions::{carry_out, mission, node, point, put, with_mission};
use crate::test_support::{click, value};
use client_model::{ClientCommand, NewTask};
use egui_kittest::kittest::Queryable;
use site_model::{FailureStep, Object, Parameter, TaskPlace};

/// A value of the first task's parameters.
fn parameter(client: &crate::test_support::TestClient, name: &str) -> Option<Parameter> {
    match &mission(client).tasks[0].place {
        TaskPlace::Node { request, .. } => request.as_ref()?.parameters.get(name).cloned(),
        TaskPlace::ByAction { request } => request.parameters.get(name).cloned(),
        TaskPlace::InspectionPoint(_) => None,
    }
}

#[test]
fn an_action_is_chosen_and_its_form_takes_only_what_the_schema_allows() {
    let mut harness = with_mission(&[node(2)]).shown(1440.0, 900.0);
    click(&mut harness, "Task 1 N2");
    carry_out(&mut harness);
    click(&mut harness, "Action");
    click(&mut harness, "Gamma spectrum");
    carry_out(&mut harness);
    assert_eq!(value(&harness, "Expected time"), "1 min 22 s", "20 s of walking and 62 s of counting");
    harness.get_by_label("Counting time, s").focus();
    harness.run_steps(2);
    harness.get_by_label("Counting time, s").type_text("7200");
    harness.run_steps(2);
    assert!(harness.query_by_label("Counting time must be from 1 to 3600\u{a0}s.").is_some());
    harness.key_press(egui::Key::Enter);
    harness.run_steps(2);
    carry_out(&mut harness);
    assert_eq!(parameter(harness.state(), "duration_s"), None, "out of range");
    harness.get_by_label("Counting time, s").focus();
    harness.run_steps(2);
    for _ in 0..4 {
        harness.key_press(egui::Key::Backspace);
    }
    harness.get_by_label("Counting time, s").type_text("120");
    harness.run_steps(2);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(2);
    carry_out(&mut harness);
    assert_eq!(parameter(harness.state(), "duration_s"), Some(Parameter::Integer(120)));
    assert_eq!(value(&harness, "Expected time"), "2 min 22 s");
    harness.state_mut().commands.push(ClientCommand::Undo);
    carry_out(&mut harness);
    assert_eq!(parameter(harness.state(), "duration_s"), None);
}

#[test]
fn angles_are_shown_in_degrees_and_kept_in_radians() {
    let mut harness = with_mission(&[node(2)]).shown(1440.0, 900.0);
    click(&mut harness, "Task 1 N2");
    carry_out(&mut harness);
    click(&mut harness, "Action");
    click(&mut harness, "Photo");
    carry_out(&mut harness);
    harness.get_by_label("Pan, °").focus();
    harness.run_steps(2);
    harness.get_by_label("Pan, °").type_text("-90");
    harness.run_steps(2);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(2);
    carry_out(&mut harness);
    match parameter(harness.state(), "pan_rad") {
        Some(Parameter::Number(pan)) => assert!((pan + std::f64::consts::FRAC_PI_2).abs() < 1e-9, "{pan}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn policies_for_reaching_and_acting_are_chosen_apart() {
    let mut harness = with_mission(&[point(2)]).shown(1440.0, 900.0);
    click(&mut harness, "Task 1 P2");
    carry_out(&mut harness);
    click(&mut harness, "If the place cannot be reached: Further tries");
    click(&mut harness, "3");
    carry_out(&mut harness);
    click(&mut harness, "If the action fails: Then");
    click(&mut harness, "Ask a person");
    carry_out(&mut harness);
    let task = mission(harness.state()).tasks[0].clone();
    assert_eq!((task.on_unreachable.retries, task.on_unreachable.then), (3, FailureStep::Skip));
    assert!(matches!(task.on_action_failure.then, FailureStep::Ask { .. }));
    assert!(harness.query_by_label("If the action fails: Without an answer").is_some());
}

#[test]
fn a_place_is_changed_and_what_is_missing_is_said() {
    let mut harness = with_mission(&[point(3), NewTask::Action("message")]).shown(1440.0, 900.0);
    assert_eq!(value(&harness, "Problem of task 2"), "Message: Text is missing.");
    click(&mut harness, "Task 1 P3");
    carry_out(&mut harness);
    click(&mut harness, "Place");
    harness.get_by_label("Node N9").scroll_to_me();
    harness.run_steps(8);
    click(&mut harness, "Node N9");
    carry_out(&mut harness);
    assert!(value(&harness, "Problem of task 1").contains("no edges lead there"));
    match &mission(harness.state()).tasks[0].place {
        TaskPlace::Node { request: Some(request), .. } => {
            assert_eq!(request.action, "photo", "the action stays")
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn docking_has_no_place_to_choose_and_its_form_offers_the_docks_and_a_charge() {
    let client = with_mission(&[point(2), NewTask::Action("dock"), NewTask::Action("undock")]);
    let only = client.model.site.site().and_then(|site| site.docks().next()).expect("a dock").clone();
    let only = site_model::Dock { name: "East".to_owned(), ..only };
    let mut harness = put(client, Object::Dock(only.clone())).shown(1440.0, 900.0);
    assert!(harness.query_by_label("Task 3 Out of its dock").is_some());
    click(&mut harness, "Task 2 Nearest dock");
    carry_out(&mut harness);
    assert!(harness.query_by_label("Place").is_none(), "the action says where");
    harness.get_by_label("Charge until, %").focus();
    harness.run_steps(2);
    harness.get_by_label("Charge until, %").type_text("120");
    harness.run_steps(2);
    assert!(harness.query_by_label("Charge until must be from 1 to 100\u{a0}%.").is_some());
    for _ in 0..3 {
        harness.key_press(egui::Key::Backspace);
    }
    harness.get_by_label("Charge until, %").type_text("80");
    harness.run_steps(2);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(2);
    carry_out(&mut harness);
    let of_task =
        |harness: &egui_kittest::Harness<'_, crate::test_support::TestClient>, name: &str| match &mission(
            harness.state(),
        )
        .tasks[1]
            .place
        {
            TaskPlace::ByAction { request } => request.parameters.get(name).cloned(),
            other => panic!("{other:?}"),
        };
    assert_eq!(of_task(&harness, "charge_until_percent"), Some(Parameter::Integer(80)));
    click(&mut harness, "Dock");
    click(&mut harness, &only.name);
    carry_out(&mut harness);
    assert_eq!(of_task(&harness, "dock"), Some(Parameter::Text(only.id.to_string())));
}
