//! Escape deselects.

use crate::test_support::TestClient;
use client_model::{ClientCommand, Selection};
use vocab::KeyframeId;

#[test]
fn escape_deselects_what_is_selected_and_only_that() {
    let pressed = |client: TestClient| {
        let mut harness = client.shown(1440.0, 900.0);
        harness.key_press(egui::Key::Escape);
        harness.run_steps(2);
        harness.state().emitted(&ClientCommand::Select(None))
    };
    let selected = ClientCommand::Select(Some(Selection::Keyframe(KeyframeId(3))));
    assert!(pressed(TestClient::connected().command(selected)));
    assert!(!pressed(TestClient::connected()));
}
