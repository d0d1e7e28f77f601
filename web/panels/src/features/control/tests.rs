//! Who controls the robot, taking and releasing control.

use crate::test_support::{ME, OTHER, TestClient, click, value};
use api::{Control, ControlRequest, Event};
use client_model::ClientCommand;
use egui_kittest::kittest::Queryable;

fn controlled_by(owner: Option<vocab::ClientId>) -> TestClient {
    TestClient::connected().event(Event::Control(Control { owner, name: "Ada".into(), request: None }))
}

#[test]
fn the_top_bar_names_the_holder_and_offers_what_can_be_done() {
    for (owner, holder, button, command) in [
        (None, "nobody", "Take control", ClientCommand::TakeControl),
        (Some(ME), "You", "Release control", ClientCommand::ReleaseControl),
        (Some(OTHER), "Ada", "Take control", ClientCommand::TakeControl),
    ] {
        let mut harness = controlled_by(owner).shown(1440.0, 900.0);
        assert_eq!(value(&harness, "Control"), holder);
        click(&mut harness, button);
        assert!(harness.state().emitted(&command), "{holder}");
    }
}

#[test]
fn a_narrow_window_has_the_button_where_control_is_needed() {
    let has_button = |owner| {
        let harness = controlled_by(owner).shown(390.0, 844.0);
        harness.query_by_label("Take control").is_some()
    };
    assert!(has_button(Some(OTHER)));
    assert!(!has_button(Some(ME)));
}

#[test]
fn the_holder_is_asked_and_can_keep_control() {
    let request = |by| Some(ControlRequest { by, name: "Bob".into(), seconds_left: 5.0 });
    let lease =
        |owner, by| Event::Control(Control { owner: Some(owner), name: "Ada".into(), request: request(by) });
    let mut harness = TestClient::connected().event(lease(ME, OTHER)).shown(390.0, 844.0);
    assert!(says(&harness, "Bob asks for control"));
    click(&mut harness, "Keep control");
    assert!(harness.state().emitted(&ClientCommand::RefuseTakeOver));
    let harness = TestClient::connected().event(lease(OTHER, ME)).shown(1440.0, 900.0);
    assert!(says(&harness, "Ada has been asked for control"));
    assert!(harness.query_by_label("Keep control").is_none());
}

fn says(harness: &egui_kittest::Harness<'_, TestClient>, sentence: &str) -> bool {
    harness.query_all_by(|node| node.value().is_some_and(|text| text.contains(sentence))).count() > 0
}
