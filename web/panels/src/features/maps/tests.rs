//! Saved maps: viewing, using and extending one, localising in it.

use crate::screens;
use crate::test_support::{TestClient, click, map};
use api::{Event, Localisation};
use client_model::ClientCommand;
use egui_kittest::kittest::Queryable;
use vocab::MapId;

/// A client on the Map screen with the saved maps `Hall` and `Cellar`, and the identity of `Cellar`.
fn hall_and_cellar() -> (TestClient, MapId) {
    let (hall, cellar) = (map(9, "Hall"), map(8, "Cellar"));
    let id = cellar.id;
    (TestClient::connected().event(Event::Maps(vec![hall, cellar])).on(screens::MAP), id)
}

#[test]
fn saved_maps_can_be_viewed_by_name() {
    let (client, cellar) = hall_and_cellar();
    let mut harness = client.shown(1440.0, 900.0);
    click(&mut harness, "View Cellar");
    assert!(harness.state().emitted(&ClientCommand::ViewMap(Some(cellar))));
}

#[test]
fn the_viewed_map_can_be_used() {
    let (client, cellar) = hall_and_cellar();
    let mut harness = client.command(ClientCommand::ViewMap(Some(cellar))).shown(1440.0, 900.0);
    assert!(harness.query_by_label("Use Hall").is_none(), "Hall is not viewed");
    click(&mut harness, "Use Cellar");
    assert!(harness.state().emitted(&ClientCommand::UseMap(cellar)));
}

#[test]
fn the_map_in_use_can_be_left() {
    let (client, cellar) = hall_and_cellar();
    let localised = Event::Localisation(Localisation::Localised { map: cellar, degradation: None });
    let client = client.event(localised).command(ClientCommand::ViewMap(Some(cellar)));
    let mut harness = client.shown(1440.0, 900.0);
    assert!(harness.query_by_label("Use Cellar").is_none(), "Cellar is in use");
    click(&mut harness, "Leave Cellar");
    assert!(harness.state().emitted(&ClientCommand::LeaveMap));
}

#[test]
fn the_viewed_map_can_be_extended() {
    let (client, cellar) = hall_and_cellar();
    let mut harness = client.command(ClientCommand::ViewMap(Some(cellar))).shown(1440.0, 900.0);
    assert!(harness.query_by_label("Extend Hall").is_none(), "Hall is not viewed");
    click(&mut harness, "Extend Cellar");
    assert!(harness.state().emitted(&ClientCommand::ExtendMap(cellar)));
}

#[test]
fn a_robot_without_pose_can_be_told_to_relocalise_or_be_given_its_pose() {
    let (client, cellar) = hall_and_cellar();
    let lost = Event::Localisation(Localisation::Relocalising { map: cellar, hypotheses: 2 });
    let client = client.event(lost).command(ClientCommand::ViewMap(Some(cellar)));
    let mut harness = client.shown(1440.0, 900.0);
    click(&mut harness, "Relocalise");
    click(&mut harness, "Set the pose");
    let client = harness.state();
    assert!(
        client.emitted(&ClientCommand::Relocalise) && client.emitted(&ClientCommand::PickPose(true)),
        "{:?}",
        client.commands
    );
}
