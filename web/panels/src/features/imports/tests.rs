//! Importing maps, with and without alignment to a saved map.

use crate::screens;
use crate::test_support::{TestClient, click, map, value};
use api::{Event, Import, ImportStage, StoredUpload};
use client_model::ClientCommand;
use egui_kittest::kittest::Queryable;
use uuid::Uuid;
use vocab::UploadId;

#[test]
fn an_imported_cloud_can_be_aligned_to_the_viewed_map() {
    let hall = map(1, "Hall");
    let id = hall.id;
    let client = || TestClient::connected().on(screens::MAP).event(Event::Maps(vec![hall.clone()]));
    assert!(client().shown(1440.0, 900.0).query_by_label("Import and align").is_none());
    let mut harness = client().command(ClientCommand::ViewMap(Some(id))).shown(1440.0, 900.0);
    click(&mut harness, "Import and align");
    assert!(harness.state().emitted(&ClientCommand::ImportMap { frame: Some(id) }));
}

#[test]
fn an_import_can_be_started_and_cancelled() {
    let client = || TestClient::connected().on(screens::MAP);
    let mut harness = client().event(Event::Maps(Vec::new())).shown(1440.0, 900.0);
    click(&mut harness, "Import a map");
    assert!(harness.state().emitted(&ClientCommand::ImportMap { frame: None }));

    let running = Import::Running {
        upload: UploadId(Uuid::from_u128(1)),
        name: "North wing".into(),
        stage: ImportStage::ComputingViewpoints,
        share: 0.42,
    };
    let mut harness = client().event(Event::Import(running)).shown(1440.0, 900.0);
    assert!(harness.query_by_label("Import a map").is_none());
    assert_eq!(value(&harness, "Import"), "Computing viewpoints of North wing, 42 %");
    click(&mut harness, "Cancel import");
    assert!(harness.state().emitted(&ClientCommand::CancelImport));
}

#[test]
fn a_file_that_could_not_be_imported_is_listed_with_the_reason() {
    let upload = UploadId(Uuid::from_u128(1));
    let stored = StoredUpload {
        upload,
        name: Some("North wing".into()),
        frame: None,
        bytes: 17_000_000,
        problem: Some("It is no point cloud.".into()),
        kept_until: None,
    };
    let client = TestClient::connected().on(screens::MAP).event(Event::Uploads(vec![stored]));
    let mut harness = client.event(Event::Maps(Vec::new())).shown(1440.0, 900.0);
    let shown = value(&harness, "Uploaded file North wing");
    assert_eq!(shown, "It is no point cloud. It is kept (17.0 MB).");
    click(&mut harness, "Try again with North wing");
    click(&mut harness, "Delete file North wing");
    assert!(harness.state().emitted(&ClientCommand::RetryImport(upload)));
    assert!(harness.state().emitted(&ClientCommand::DeleteUpload(upload)));
}
