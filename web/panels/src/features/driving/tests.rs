//! Driving with the keys, and allowing motion.

use crate::test_support::{ME, TestClient, click};
use api::{Event, Motion, Platform, SpeedLimits};
use client_model::{ClientCommand, ClientEvent, ClientTime};

#[test]
fn a_stopped_robot_offers_to_allow_motion() {
    let stopped = Event::Motion(Motion::Stopped { by: Some(ME) });
    let mut harness = TestClient::connected().event(stopped).shown(1024.0, 768.0);
    click(&mut harness, "Allow motion");
    assert!(harness.state().emitted(&ClientCommand::AllowMotion));
}

/// A robot that told limits unlike those of any other.
fn with_limits() -> TestClient {
    let manual_limits = Some(SpeedLimits { forward_m_s: 0.7, sideways_m_s: 0.2, turn_rad_s: 0.6 });
    TestClient::connected().event(Event::Platform(Platform { manual_limits, ..Platform::default() }))
}

/// The velocity that is commanded while `key` is held: ahead, to the left, turning left.
fn velocity_of(client: TestClient, key: egui::Key) -> Option<(f64, f64, f64)> {
    let mut harness = client.shown(1440.0, 900.0);
    harness.key_down(key);
    harness.run_steps(2);
    harness.state().commands.iter().find_map(|command| match command {
        ClientCommand::SetVelocity(Some(twist)) => Some((twist.linear.x, twist.linear.y, twist.angular.z)),
        _ => None,
    })
}

#[test]
fn keys_drive_at_the_limits_of_the_robots_profile() {
    assert_eq!(velocity_of(with_limits(), egui::Key::W), Some((0.7, 0.0, 0.0)));
    assert_eq!(velocity_of(with_limits(), egui::Key::A), Some((0.0, 0.2, 0.0)));
    assert_eq!(velocity_of(with_limits(), egui::Key::E), Some((0.0, 0.0, -0.6)));
}

#[test]
fn a_robot_that_has_not_told_its_limits_cannot_be_driven() {
    assert_eq!(velocity_of(TestClient::connected(), egui::Key::W), None);
}

#[test]
fn the_release_of_a_key_ends_driving() {
    let mut harness = with_limits().shown(1440.0, 900.0);
    harness.key_down(egui::Key::W);
    harness.run_steps(2);

    let client = harness.state_mut();
    for command in std::mem::take(&mut client.commands) {
        client.model.handle_event(ClientTime(1.0), ClientEvent::Command(command), &mut Vec::new());
    }
    harness.key_up(egui::Key::W);
    harness.run_steps(2);
    assert!(harness.state().emitted(&ClientCommand::SetVelocity(None)), "{:?}", harness.state().commands);
}
