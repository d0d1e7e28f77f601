//! How far the position can be trusted, and relocalising a robot whose pose is not known.

use crate::screens;
use crate::test_support::{TestClient, click, map, value};
use api::{DegradationReason, Estimate, Event, Localisation};
use client_model::ClientCommand;
use vocab::Covariance6;

/// A client whose robot reported this state of localisation, and a position of this standard deviation in each axis, metres.
fn reported(localisation: Localisation, sigma_m: f64) -> TestClient {
    let mut covariance = Covariance6::default();
    for axis in 3..6 {
        covariance.0[axis][axis] = sigma_m * sigma_m;
    }
    let estimate = Estimate { covariance, ..Estimate::default() };
    let client = TestClient::connected().event(Event::Maps(vec![map(8, "Cellar")]));
    client.event(Event::Localisation(localisation)).event(Event::Estimate(estimate))
}

#[test]
fn the_position_says_how_far_it_can_be_trusted() {
    let map = map(8, "Cellar").id;
    let localised = |degradation| Localisation::Localised { map, degradation };
    let mismatch = localised(Some(DegradationReason::MapMismatch));
    for (localisation, sigma_m, expected) in [
        (localised(None), 0.02, "Localised"),
        (localised(None), 2.0, "Position uncertain"),
        (mismatch, 0.02, "Position uncertain"),
        (Localisation::Relocalising { map, hypotheses: 3 }, 0.02, "Relocalising"),
    ] {
        let harness = reported(localisation, sigma_m).shown(1440.0, 900.0);
        let shown = value(&harness, "Position");
        assert!(shown.starts_with(expected), "{shown} for {localisation:?}");
    }
    let before = TestClient::connected().shown(1440.0, 900.0);
    assert_eq!(value(&before, "Position"), "No position yet");
}

#[test]
fn the_map_in_use_says_what_speaks_against_the_pose() {
    let map = map(8, "Cellar").id;
    let degradation = Some(DegradationReason::LidarBlind);
    let harness = reported(Localisation::Localised { map, degradation }, 0.02).shown(1440.0, 900.0);
    assert_eq!(value(&harness, "Localisation"), "Uncertain: the LiDAR sees nothing");
}

#[test]
fn a_robot_that_relocalises_can_be_sent_to_walk_for_it() {
    let map = map(8, "Cellar").id;
    let client = reported(Localisation::Relocalising { map, hypotheses: 0 }, 0.02);
    let client = client.on(screens::MAP).command(ClientCommand::ViewMap(Some(map)));
    let mut harness = client.shown(1440.0, 1200.0);
    click(&mut harness, "Relocalise");
    assert!(harness.state().emitted(&ClientCommand::Relocalise));
    click(&mut harness, "Leave Cellar");
    assert!(harness.state().emitted(&ClientCommand::LeaveMap));
}

#[test]
fn setting_the_pose_shows_what_to_do_until_escape_is_pressed() {
    let client = TestClient::connected().command(ClientCommand::PickPose(true));
    let mut harness = client.shown(1440.0, 900.0);
    assert!(value(&harness, "Message").starts_with("Press the floor where the robot stands"));
    harness.key_press(egui::Key::Escape);
    harness.run_steps(2);
    assert!(harness.state().emitted(&ClientCommand::PickPose(false)));
}
