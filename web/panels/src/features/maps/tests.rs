//! Saved maps: viewing, using and extending one, localising in it.

use crate::screens;
use crate::test_support::{TestClient, click, map, value};
use api::{DamagedMap, Event, Localisation};
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

#[test]
fn a_damaged_map_is_listed_with_its_file_and_what_to_do() {
    let (client, _) = hall_and_cellar();
    let damaged = DamagedMap {
        folder: "0a0b".into(),
        problem: "It cannot be read: map.json is empty.".into(),
        remedy: "Copy it back from a backup.".into(),
    };
    let harness = client.event(Event::DamagedMaps(vec![damaged])).shown(1440.0, 1200.0);
    let shown = value(&harness, "Damaged map 0a0b");
    assert_eq!(shown, "It cannot be read: map.json is empty. Copy it back from a backup.");
    assert!(harness.query_by_label("View Cellar").is_some(), "the others are still listed");
    assert!(harness.query_by_label("View 0a0b").is_none());
}
