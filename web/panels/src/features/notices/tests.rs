//! Notices can be read and dismissed.

use crate::test_support::{TestClient, click};
use api::{ClientMessage, CommandOutcome, Event};
use client_model::{ClientCommand, ClientEffect, ClientEvent, ClientTime};

#[test]
fn a_refused_command_is_an_alert_that_can_be_dismissed() {
    let mut client = TestClient::connected();
    let mut effects = Vec::new();
    let release = ClientEvent::Command(ClientCommand::ReleaseControl);
    client.model.handle_event(ClientTime(1.0), release, &mut effects);
    let id = effects.into_iter().find_map(|effect| match effect {
        ClientEffect::Send(ClientMessage::Command { id, .. }) => Some(id),
        _ => None,
    });
    let outcome = CommandOutcome::Refused("Not now. Wait a moment.".into());
    let client = client.event(Event::CommandDone { id: id.unwrap(), outcome });
    let mut harness = client.shown(1440.0, 900.0);
    click(&mut harness, "Dismiss");
    assert!(
        harness.state().commands.iter().any(|command| matches!(command, ClientCommand::DismissNotice(_)))
    );
}
