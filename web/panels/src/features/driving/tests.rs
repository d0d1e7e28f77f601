//! Driving with the keys, and allowing motion.

use crate::test_support::{ME, TestClient, click};
use api::Motion;
use client_model::{ClientCommand, ClientEvent, ClientTime};

#[test]
fn a_stopped_robot_offers_to_allow_motion() {
    let stopped = api::Event::Motion(Motion::Stopped { by: Some(ME) });
    let mut harness = TestClient::connected().event(stopped).shown(1024.0, 768.0);
    click(&mut harness, "Allow motion");
    assert!(harness.state().emitted(&ClientCommand::AllowMotion));
}

#[test]
fn the_w_key_drives_ahead_and_its_release_ends_it() {
    let mut harness = TestClient::connected().shown(1440.0, 900.0);
    harness.key_down(egui::Key::W);
    harness.run_steps(2);
    let ahead = harness.state().commands.iter().any(
        |command| matches!(command, ClientCommand::SetVelocity(Some(twist)) if twist.linear.x > 0.5 && twist.linear.y == 0.0),
    );
    assert!(ahead, "{:?}", harness.state().commands);

    let client = harness.state_mut();
    for command in std::mem::take(&mut client.commands) {
        client.model.handle_event(ClientTime(1.0), ClientEvent::Command(command), &mut Vec::new());
    }
    harness.key_up(egui::Key::W);
    harness.run_steps(2);
    assert!(harness.state().emitted(&ClientCommand::SetVelocity(None)), "{:?}", harness.state().commands);
}
