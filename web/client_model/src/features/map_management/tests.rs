//! Renaming, deleting with undo, and the bin.

use crate::testing::*;
use crate::*;
use api::{BinnedMap, Command, CommandOutcome, Event, MapSummary};
use uuid::Uuid;
use vocab::{CommandId, MapId, Stamp};

const MAP: MapId = MapId(Uuid::from_u128(3));

fn hall() -> MapSummary {
    MapSummary {
        id: MAP,
        name: "Hall".into(),
        created: Stamp::EPOCH,
        distance_m: 1.0,
        keyframes: 2,
        points: 3,
        bytes: 4,
        has_pose_graph: true,
    }
}

fn binned() -> BinnedMap {
    BinnedMap { id: MAP, name: "Hall".into(), bytes: 4, kept_until: None, time_left: None, problem: None }
}

/// A client that has the saved map on the screen.
fn viewing() -> TestClient {
    let mut client = TestClient::connected();
    client.event(Event::Maps(vec![hall()]));
    client.event(Event::BinnedMaps(Vec::new()));
    client.command(ClientCommand::ViewMap(Some(MAP)));
    client.take_effects();
    client
}

/// Deletes the map; returns the id of the command.
fn delete(client: &mut TestClient) -> CommandId {
    client.command(ClientCommand::DeleteMap(MAP));
    let sent = client.take_effects();
    let [ClientEffect::Send(api::ClientMessage::Command { id, command: Command::DeleteMap(MAP) })] = sent[..]
    else {
        panic!("{sent:?}")
    };
    id
}

fn server_deletes(client: &mut TestClient, id: CommandId) {
    client.event(Event::Maps(Vec::new()));
    client.event(Event::BinnedMaps(vec![binned()]));
    client.event(Event::CommandDone { id, outcome: CommandOutcome::Accepted });
}

#[test]
fn a_map_is_renamed() {
    let mut client = viewing();
    client.command(ClientCommand::RenameMap { map: MAP, name: "Cellar".into() });
    assert_eq!(client.take_commands(), [Command::RenameMap { map: MAP, name: "Cellar".into() }]);
}

#[test]
fn a_deletion_is_on_show_for_a_while_and_the_map_leaves_the_screen() {
    let mut client = viewing();
    let id = delete(&mut client);
    assert_eq!(client.model.map_management.deletion(), None, "the server has not done it");
    server_deletes(&mut client, id);
    let deletion = client.model.map_management.deletion().expect("on show");
    assert_eq!((deletion.map, deletion.name.as_str()), (MAP, "Hall"));
    assert_eq!(client.model.viewed_map(), None);
    assert!(client.model.notices().visible().is_empty(), "the deletion says it");
    client.wait(30.0);
    assert_eq!(client.model.map_management.deletion(), None);
    assert_eq!(client.model.map_management.bin(), [binned()]);
}

#[test]
fn a_deletion_is_undone_once_by_its_button_or_the_keys() {
    for by_key in [false, true] {
        let mut client = viewing();
        let id = delete(&mut client);
        server_deletes(&mut client, id);
        client.take_effects();
        client.command(if by_key { ClientCommand::Undo } else { ClientCommand::RestoreMap(MAP) });
        assert_eq!(client.take_commands(), [Command::RestoreMap(MAP)]);
        client.command(ClientCommand::Undo);
        assert_eq!(client.take_commands(), []);
        client.event(Event::Maps(vec![hall()]));
        client.event(Event::BinnedMaps(Vec::new()));
        assert_eq!(client.model.map_management.deletion(), None);
    }
}

#[test]
fn a_refused_deletion_leaves_nothing_to_undo() {
    let mut client = viewing();
    let id = delete(&mut client);
    let outcome = CommandOutcome::Refused("The robot uses this map.".into());
    client.event(Event::CommandDone { id, outcome });
    client.command(ClientCommand::Undo);
    assert_eq!(client.take_commands(), []);
    assert_eq!((client.model.map_management.deletion(), client.model.viewed_map()), (None, Some(MAP)));
    assert_eq!(client.model.notices().visible()[0].text, "The robot uses this map.");
}

#[test]
fn a_map_that_another_client_deletes_leaves_the_screen_with_a_sentence() {
    let mut client = viewing();
    client.event(Event::Maps(Vec::new()));
    client.event(Event::BinnedMaps(vec![binned()]));
    assert_eq!(client.model.viewed_map(), None);
    assert!(client.model.notices().visible()[0].text.contains("bin"));
}
