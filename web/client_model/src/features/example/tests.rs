//! Asking for the example, and what an operator sees of it.

use crate::testing::*;
use crate::*;
use api::{Command, CommandOutcome, Event, Import, ImportStage};
use uuid::Uuid;
use vocab::{MapId, UploadId};

const MAP: MapId = MapId(Uuid::from_u128(3));

fn asked(client: &mut TestClient) -> UploadId {
    client.command(ClientCommand::MakeExample { time_zone: "Europe/London".to_owned() });
    let commands = client.take_commands();
    let [Command::MakeExample { upload, time_zone }] = &commands[..] else { panic!("{commands:?}") };
    assert_eq!(time_zone, "Europe/London");
    *upload
}

fn running(upload: UploadId, stage: ImportStage, share: f32) -> Event {
    Event::Import(Import::Running { upload, name: "Example hall".to_owned(), stage, share })
}

#[test]
fn who_has_asked_for_the_example_is_shown_it_when_it_is_ready_and_others_are_not() {
    let (mut client, mut other) = (TestClient::connected(), TestClient::connected());
    let upload = asked(&mut client);
    for client in [&mut client, &mut other] {
        client.event(running(upload, ImportStage::Walking, 0.25));
        assert_eq!(client.model.example.progress(), Some((ImportStage::Walking, 0.25)));
        client.event(running(upload, ImportStage::Writing, 0.0));
        assert_eq!(client.model.example.progress(), Some((ImportStage::Writing, 0.0)));
        client.event(Event::Import(Import::Done { upload, map: MAP }));
        assert_eq!(client.model.example.progress(), None);
    }
    assert_eq!((client.model.example.ready(), other.model.example.ready()), (Some(MAP), None));
    client.command(ClientCommand::DismissExample);
    assert_eq!(client.model.example.ready(), None);
}

#[test]
fn imports_of_files_are_not_the_example() {
    let mut client = TestClient::connected();
    client.event(running(UploadId(Uuid::from_u128(9)), ImportStage::Writing, 0.5));
    assert_eq!(client.model.example.progress(), None);
}

#[test]
fn a_failure_is_told_and_what_was_cancelled_is_none() {
    let mut client = TestClient::connected();
    let upload = asked(&mut client);
    let failed = |upload| {
        let reason = "It was cancelled.".to_owned();
        Event::Import(Import::Failed { upload, name: "Example hall".to_owned(), reason })
    };
    client.event(running(upload, ImportStage::Walking, 0.0));
    client.event(failed(upload));
    assert_eq!(client.model.example.failure(), Some("It was cancelled."));
    let upload = asked(&mut client);
    assert_eq!(client.model.example.failure(), None, "it is tried again");
    client.event(running(upload, ImportStage::Walking, 0.0));
    client.command(ClientCommand::CancelExample);
    assert_eq!(client.take_commands(), [Command::CancelImport(upload)]);
    client.event(failed(upload));
    assert_eq!((client.model.example.failure(), client.model.example.is_asked_for()), (None, false));
}

#[test]
fn a_request_that_is_refused_is_not_waited_for() {
    let mut client = TestClient::connected();
    client.command(ClientCommand::MakeExample { time_zone: "UTC".to_owned() });
    assert!(client.model.example.is_asked_for());
    let id = client
        .take_effects()
        .into_iter()
        .find_map(|effect| match effect {
            ClientEffect::Send(api::ClientMessage::Command { id, .. }) => Some(id),
            _ => None,
        })
        .expect("it was sent");
    let outcome = CommandOutcome::Refused("Another map is being imported.".to_owned());
    client.event(Event::CommandDone { id, outcome });
    assert!(!client.model.example.is_asked_for());
}
