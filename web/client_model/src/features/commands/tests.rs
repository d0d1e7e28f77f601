//! Commands: ids, repetition after a loss, answers.

use crate::testing::*;
use crate::*;
use api::{ClientMessage, Command, CommandOutcome, Control};
use vocab::Vec3;

#[test]
fn an_unanswered_order_is_repeated_under_its_id_after_a_short_loss() {
    let mut client = TestClient::connected();
    client.event(api::Event::Control(Control { owner: Some(ME), name: String::new(), request: None }));
    client.command(ClientCommand::StartMapping);
    let first = client.take_effects();
    assert!(matches!(&first[..], [ClientEffect::Send(ClientMessage::Command { .. })]), "{first:?}");
    client.lose_connection();
    client.wait(1.0);
    client.take_effects();
    client.connect();
    let again = client.take_effects();
    assert!(again.contains(&first[0]), "the same command under the same id");
    assert!(client.model.is_pending(|command| matches!(command, Command::StartMapping(_))));
}

#[test]
fn an_old_order_is_not_repeated_but_told() {
    let mut client = TestClient::connected();
    client.command(ClientCommand::WalkTo(Vec3::default()));
    client.lose_connection();
    client.wait(60.0);
    client.take_effects();
    client.connect();
    assert_eq!(client.take_commands(), []);
    let notices = client.model.notices().visible();
    assert!(
        notices.iter().any(|notice| notice.text.contains("Walking there may not have reached")),
        "{notices:?}"
    );
}

#[test]
fn a_stop_is_sent_even_an_hour_later_and_needs_no_control() {
    let mut client = TestClient::connected();
    client.event(api::Event::Control(Control { owner: Some(OTHER), name: "other".into(), request: None }));
    client.command(ClientCommand::StopMotion);
    assert_eq!(client.take_commands(), [Command::StopMotion]);
    client.lose_connection();
    client.wait(3600.0);
    client.connect();
    assert_eq!(client.take_commands(), [Command::StopMotion]);
}

#[test]
fn a_stop_without_a_link_says_that_it_did_not_arrive() {
    let mut client = TestClient::new();
    client.command(ClientCommand::StopMotion);
    assert!(client.model.notices().visible()[0].text.contains("has not reached the robot"));
    assert!(client.take_effects().contains(&ClientEffect::RequestStop), "all sockets may be taken");
}

#[test]
fn answers_end_the_waiting_and_refusals_are_told() {
    let mut client = TestClient::connected();
    client.command(ClientCommand::AllowMotion);
    let ids: Vec<_> = client
        .take_effects()
        .into_iter()
        .filter_map(|effect| match effect {
            ClientEffect::Send(ClientMessage::Command { id, .. }) => Some(id),
            _ => None,
        })
        .collect();
    assert_eq!(ids.len(), 2, "control was free, so it is taken first");
    for id in ids {
        let outcome = CommandOutcome::Refused("Not now. Wait until the robot stands.".into());
        client.event(api::Event::CommandDone { id, outcome });
    }
    assert!(!client.model.is_pending(|_| true));
    let shown = client.model.notices().visible();
    assert_eq!((shown.len(), shown[0].times), (1, 2), "the same sentence twice is one notice");
}
