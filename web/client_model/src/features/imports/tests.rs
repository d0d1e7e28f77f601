//! Uploading a file and making a map of it.

use crate::testing::*;
use crate::*;
use api::Command;
use uuid::Uuid;
use vocab::{MapId, UploadId};

#[test]
fn a_file_that_was_chosen_is_sent_and_becomes_a_map_unless_it_is_given_up() {
    let mut client = TestClient::connected();
    let upload = UploadId(Uuid::from_u128(4));
    client.command(ClientCommand::ImportMap { frame: None });
    assert!(client.take_effects().contains(&ClientEffect::OpenFileDialog));
    client.apply(ClientEvent::UploadStarted { upload, file: "north.wing.laz".into() });
    client.apply(ClientEvent::UploadProgress { upload, share: 0.25 });
    assert_eq!(client.model.imports.upload().map(|it| it.share), Some(0.25));
    client.apply(ClientEvent::UploadFinished { upload, result: Ok(()) });
    assert_eq!(
        client.take_commands(),
        [Command::ImportMap { upload, name: "north.wing".into(), frame: None }]
    );
    assert_eq!(client.model.imports.upload(), None);

    let (name, stage) = ("north.wing".to_owned(), api::ImportStage::ComputingViewpoints);
    client.event(api::Event::Import(api::Import::Running { upload, name, stage, share: 0.5 }));
    client.command(ClientCommand::CancelImport);
    assert_eq!(client.take_commands(), [Command::CancelImport(upload)]);

    let frame = Some(MapId(Uuid::from_u128(7)));
    client.command(ClientCommand::ImportMap { frame });
    client.apply(ClientEvent::UploadStarted { upload, file: ".laz".into() });
    assert_eq!(client.model.imports.upload().map(|it| it.frame), Some(frame));
    assert_eq!(client.model.imports.upload().map(Upload::map_name), Some(".laz"));
    client.command(ClientCommand::CancelImport);
    assert!(client.take_effects().contains(&ClientEffect::CancelUpload(upload)));
    client.apply(ClientEvent::UploadFinished { upload, result: Err("late".into()) });
    assert!(
        client.take_commands().is_empty() && client.model.notices().visible().is_empty(),
        "nobody waits for it"
    );
}

#[test]
fn a_file_that_could_not_be_imported_can_be_tried_again_or_deleted() {
    let mut client = TestClient::connected();
    let (upload, frame) = (UploadId(Uuid::from_u128(4)), Some(MapId(Uuid::from_u128(7))));
    let stored = api::StoredUpload {
        upload,
        name: Some("Wing".into()),
        frame,
        bytes: 5,
        problem: Some("It is ambiguous.".into()),
        kept_until: None,
    };
    client.event(api::Event::Uploads(vec![stored.clone()]));
    assert_eq!(client.model.imports.stored().collect::<Vec<_>>(), [&stored]);
    client.command(ClientCommand::RetryImport(upload));
    client.command(ClientCommand::DeleteUpload(upload));
    let again = Command::ImportMap { upload, name: "Wing".into(), frame };
    assert_eq!(client.take_commands(), [again, Command::DeleteUpload(upload)]);
    let (name, stage) = ("Wing".to_owned(), api::ImportStage::Reading);
    client.event(api::Event::Import(api::Import::Running { upload, name, stage, share: 0.5 }));
    assert_eq!(client.model.imports.stored().count(), 0, "it is being imported");
}
