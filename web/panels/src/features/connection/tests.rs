//! The link in the top bar, and the messages while it is lost.

use crate::test_support::{TestClient, click, value};
use api::ServerMessage;
use client_model::{ClientCommand, ClientEvent, ClientTime, Socket};

fn after(mut client: TestClient, at: f64, event: ClientEvent) -> TestClient {
    client.model.handle_event(ClientTime(at), event, &mut Vec::new());
    client
}

#[test]
fn a_connected_client_shows_the_data_rate() {
    let harness = TestClient::connected().shown(1440.0, 900.0);
    assert!(value(&harness, "Link").contains("kbit/s"), "{}", value(&harness, "Link"));
}

#[test]
fn data_that_is_not_live_shows_its_age_instead() {
    let client = TestClient::connected().event(api::Event::Estimate(api::Estimate::default()));
    let harness = after(client, 13.0, ClientEvent::Tick).shown(1440.0, 900.0);
    assert_eq!(value(&harness, "Link"), "12 s old");
}

#[test]
fn a_lost_link_says_for_how_long_and_can_be_tried_at_once() {
    let closed = ClientEvent::SocketClosed { socket: Socket::Control, jitter: 0.5 };
    let client = after(TestClient::connected(), 1.0, closed);
    let mut harness = client.shown(1440.0, 900.0);
    assert_eq!(value(&harness, "Link"), "Link lost");
    assert!(value(&harness, "Message").starts_with("Link lost 0 s ago. Next try in "));
    click(&mut harness, "Reconnect now");
    assert!(harness.state().emitted(&ClientCommand::Reconnect));
}

#[test]
fn a_server_that_refuses_says_why() {
    let reason = "This page is too old. Reload it.".to_owned();
    let message = ServerMessage::Refused { reason: reason.clone() };
    let client = after(TestClient::connected(), 1.0, ClientEvent::Server { message, bytes: 10 });
    let harness = client.shown(1440.0, 900.0);
    assert_eq!((value(&harness, "Link"), value(&harness, "Message")), ("Refused".to_owned(), reason));
}
