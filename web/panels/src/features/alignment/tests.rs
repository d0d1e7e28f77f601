//! Aligning one saved map to another: by picked points and without any.

use crate::screens;
use crate::test_support::{TestClient, click, map, value};
use api::Event;
use client_model::ClientCommand;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use uuid::Uuid;
use vocab::{MapId, Vec3};

const HALL: MapId = MapId(Uuid::from_u128(9));
const CELLAR: MapId = MapId(Uuid::from_u128(8));
const HALL_TO_CELLAR: ClientCommand = ClientCommand::AlignMap { map: HALL, reference: Some(CELLAR) };

/// The Map screen with the saved maps `Hall` and `Cellar`, after these commands.
fn after<'a>(commands: &[ClientCommand]) -> Harness<'a, TestClient> {
    let client = TestClient::connected().event(Event::Maps(vec![map(9, "Hall"), map(8, "Cellar")]));
    let client = commands.iter().cloned().fold(client, TestClient::command);
    client.on(screens::MAP).shown(1440.0, 1200.0)
}

fn pick(x: f64, y: f64) -> ClientCommand {
    ClientCommand::AddAlignmentPoint(Vec3::new(x, y, 0.0))
}

#[test]
fn the_viewed_map_can_be_aligned_to_any_other_map() {
    let mut harness = after(&[ClientCommand::ViewMap(Some(HALL))]);
    click(&mut harness, "Align Hall");
    let without_reference = ClientCommand::AlignMap { map: HALL, reference: None };
    assert!(harness.state().emitted(&without_reference));
    let mut harness = after(&[without_reference]);
    assert!(harness.query_by_label("Onto Hall").is_none(), "not to itself");
    click(&mut harness, "Onto Cellar");
    assert!(harness.state().emitted(&HALL_TO_CELLAR));
    after(&[HALL_TO_CELLAR]).get_by_label("Align by what both look like");
}

#[test]
fn points_that_agree_align_and_points_that_contradict_do_not() {
    let mut commands = vec![HALL_TO_CELLAR, pick(0.0, 0.0), pick(5.0, 5.0), pick(4.0, 0.0), pick(5.0, 9.0)];
    let mut harness = after(&commands);
    assert_eq!(value(&harness, "Points picked in both"), "2");
    assert_eq!(value(&harness, "They agree to"), "1 mm");
    click(&mut harness, "Align by the points");
    click(&mut harness, "Look at Cellar");
    let client = harness.state();
    assert!(
        client.emitted(&ClientCommand::StartAlignment)
            && client.emitted(&ClientCommand::ViewMap(Some(CELLAR))),
        "{:?}",
        client.commands
    );
    commands.extend([pick(0.0, 3.0), pick(5.0, 19.0)]);
    let mut harness = after(&commands);
    harness.get_by_label_contains("contradict each other");
    click(&mut harness, "Align by the points");
    assert!(!harness.state().emitted(&ClientCommand::StartAlignment), "these points contradict each other");
}
