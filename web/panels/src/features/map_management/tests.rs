//! Renaming in place, deleting with undo, and the bin.

use crate::screens;
use crate::test_support::{TestClient, click, map, value};
use api::{BinnedMap, CommandOutcome, DamagedMap, Event, Localisation};
use client_model::{ClientCommand, ClientEffect};
use egui_kittest::kittest::Queryable;
use vocab::{MapId, Span, Stamp};

fn binned(number: u128, name: &str, days: i64) -> BinnedMap {
    BinnedMap {
        id: map(number, name).id,
        name: name.into(),
        bytes: 7_000_000,
        kept_until: Some(Stamp::from_parts(1_796_083_200, 0)),
        time_left: Some(Span::from_millis(days * 86_400_000 - 1)),
        problem: None,
    }
}

/// A client on the Map screen that views the saved map `Hall`.
fn viewing() -> (TestClient, MapId) {
    let hall = map(9, "Hall");
    let id = hall.id;
    let client = TestClient::connected().event(Event::Maps(vec![hall])).on(screens::MAP);
    (client.command(ClientCommand::ViewMap(Some(id))), id)
}

#[test]
fn a_map_is_renamed_where_its_name_stands() {
    let (client, hall) = viewing();
    let mut harness = client.shown(1440.0, 900.0);
    click(&mut harness, "Rename Hall");
    assert!(harness.query_by_label("View Hall").is_none() && harness.query_by_label("Close Hall").is_none());
    harness.get_by_label("New map name").focus();
    harness.run_steps(2);
    harness.get_by_label("New map name").type_text(" East ");
    harness.run_steps(2);
    click(&mut harness, "Save the name");
    let [ClientCommand::RenameMap { map, name }] = &harness.state().commands[..] else {
        panic!("{:?}", harness.state().commands)
    };
    assert_eq!(*map, hall);
    assert!(name.contains("Hall") && name.contains("East") && name.trim() == name, "{name}");
    assert!(harness.query_by_label("New map name").is_none());
}

#[test]
fn escape_keeps_the_name_and_stops_only_when_it_is_pressed_again() {
    let (client, _) = viewing();
    let mut harness = client.shown(1440.0, 900.0);
    click(&mut harness, "Rename Hall");
    harness.key_press(egui::Key::Escape);
    harness.run_steps(2);
    assert!(
        harness.query_by_label("New map name").is_none() && harness.query_by_label("Rename Hall").is_some()
    );
    let renamed = |command: &ClientCommand| matches!(command, ClientCommand::RenameMap { .. });
    assert!(!harness.state().commands.iter().any(renamed));
    assert!(!harness.state().emitted(&ClientCommand::StopMotion));
    harness.key_press(egui::Key::Escape);
    harness.run_steps(2);
    assert!(harness.state().emitted(&ClientCommand::StopMotion));
}

#[test]
fn a_map_is_deleted_and_the_deletion_can_be_undone() {
    let (client, hall) = viewing();
    let mut harness = client.shown(1440.0, 900.0);
    click(&mut harness, "Delete Hall");
    assert!(harness.state().emitted(&ClientCommand::DeleteMap(hall)));

    let (client, _) = viewing();
    let (client, effects) = client.command_with_effects(ClientCommand::DeleteMap(hall));
    let id = effects.iter().find_map(|effect| match effect {
        ClientEffect::Send(api::ClientMessage::Command { id, .. }) => Some(*id),
        _ => None,
    });
    let id = id.expect("sent");
    let client = client.event(Event::Maps(Vec::new())).event(Event::BinnedMaps(vec![binned(9, "Hall", 7)]));
    let client = client.event(Event::CommandDone { id, outcome: CommandOutcome::Accepted });
    let mut harness = client.shown(1440.0, 900.0);
    assert_eq!(value(&harness, "Message"), "Hall is in the bin, kept until 1 Dec.");
    click(&mut harness, "Undo");
    assert!(harness.state().emitted(&ClientCommand::RestoreMap(hall)));
}

#[test]
fn a_map_in_use_cannot_be_deleted_and_the_sentence_says_what_to_do() {
    let (client, hall) = viewing();
    let localised = Event::Localisation(Localisation::Localised { map: hall, degradation: None });
    let mut harness = client.event(localised).shown(1440.0, 900.0);
    click(&mut harness, "Delete Hall");
    assert!(harness.state().commands.is_empty());
    assert!(harness.query_by_label_contains("Leave it, then it can be deleted").is_some());
}

#[test]
fn the_bin_lists_maps_with_the_days_left() {
    let client = TestClient::connected().event(Event::Maps(Vec::new())).on(screens::MAP);
    let damaged = BinnedMap {
        problem: Some("It cannot be read: map.json is empty.".into()),
        time_left: None,
        ..binned(7, "0a0b", 1)
    };
    let no_clock = BinnedMap { kept_until: None, time_left: None, ..binned(6, "Attic", 1) };
    let bin = vec![binned(9, "Hall", 6), binned(8, "Cellar", 1), damaged, no_clock];
    let mut harness = client.event(Event::BinnedMaps(bin)).shown(1440.0, 1200.0);
    assert!(harness.query_by_label("Restore Hall").is_none(), "the bin is closed");
    click(&mut harness, "Bin");
    assert_eq!(value(&harness, "Deleted map Hall"), "6 days left");
    assert_eq!(value(&harness, "Deleted map Cellar"), "1 day left");
    assert!(value(&harness, "Deleted map 0a0b").contains("map.json"));
    assert!(value(&harness, "Deleted map Attic").contains("synchronised"));
    click(&mut harness, "Restore Cellar");
    assert!(harness.state().emitted(&ClientCommand::RestoreMap(map(8, "").id)));
    click(&mut harness, "Delete Hall for good");
    let deleted = ClientCommand::DeleteMapPermanently(map(9, "").id);
    assert!(!harness.state().emitted(&deleted), "it has to be confirmed");
    click(&mut harness, "Delete for good");
    assert!(harness.state().emitted(&deleted));
}

#[test]
fn a_damaged_map_can_be_moved_to_the_bin() {
    let id = map(9, "").id;
    let damaged = |folder: String| DamagedMap { folder, problem: "p".into(), remedy: "r".into() };
    let maps = vec![damaged(id.to_string()), damaged("backup".into())];
    let client = TestClient::connected().event(Event::DamagedMaps(maps)).on(screens::MAP);
    let mut harness = client.event(Event::Maps(Vec::new())).shown(1440.0, 1200.0);
    assert!(harness.query_by_label("Delete backup").is_none(), "it is no map's folder");
    click(&mut harness, &format!("Delete {id}"));
    assert!(harness.state().emitted(&ClientCommand::DeleteMap(id)));
}
