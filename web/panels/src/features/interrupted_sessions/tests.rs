//! The question about an interrupted session.

use crate::screens;
use crate::test_support::{TestClient, click};
use api::{Event, InterruptedSession};
use client_model::ClientCommand;
use egui_kittest::kittest::Queryable;
use uuid::Uuid;
use vocab::{SessionId, Stamp};

const SESSION: SessionId = SessionId(Uuid::from_u128(4));

fn client(keyframes: u32) -> TestClient {
    let at = Stamp::from_parts(1_700_000_000, 0);
    let session = InterruptedSession { session: SESSION, at, keyframes, distance_m: 40.0, extends: None };
    let event = Event::InterruptedSessions(vec![session]);
    TestClient::connected().event(Event::Maps(Vec::new())).event(event).on(screens::MAP)
}

#[test]
fn an_interrupted_session_can_be_resumed_saved_and_discarded() {
    for (button, resume) in [("Go on mapping", true), ("Save interrupted map", false)] {
        let mut harness = client(37).shown(1440.0, 900.0);
        harness.get_by_label_contains("37 keyframes");
        click(&mut harness, button);
        let name = "Map 1".to_owned();
        let command = ClientCommand::SaveInterruptedSession { session: SESSION, name, resume };
        assert!(harness.state().emitted(&command), "{:?}", harness.state().commands);
    }
    let mut harness = client(37).shown(1440.0, 900.0);
    let discard = ClientCommand::DiscardInterruptedSession(SESSION);
    click(&mut harness, "Discard interrupted map");
    assert!(!harness.state().emitted(&discard));
    click(&mut harness, "Discard it for good");
    assert!(harness.state().emitted(&discard));
}

#[test]
fn a_damaged_session_can_only_be_discarded() {
    let mut harness = client(0).shown(1440.0, 900.0);
    click(&mut harness, "Save interrupted map");
    click(&mut harness, "Go on mapping");
    assert!(harness.state().commands.is_empty(), "{:?}", harness.state().commands);
}
