//! Opening, losing and retrying the connection; snapshots; order of events.

use crate::testing::*;
use crate::*;
use api::{ClientMessage, Control, ServerMessage, TilesChanged};
use vocab::Stamp;

#[test]
fn says_hello_and_is_connected_after_the_welcome() {
    let mut client = TestClient::new();
    assert_eq!(
        client.take_effects(),
        [ClientEffect::OpenSocket(Socket::Control), ClientEffect::OpenSocket(Socket::Stream)]
    );
    client.apply(ClientEvent::SocketOpened(Socket::Control));
    assert_eq!(
        client.take_effects(),
        [ClientEffect::Send(ClientMessage::Hello { version: api::VERSION, lease: api::LeaseToken(ME.0) })]
    );
    assert!(!client.model.is_connected());
    client.welcome();
    assert!(client.model.is_connected());
}

#[test]
fn a_server_of_another_version_is_refused_with_a_sentence() {
    let mut client = TestClient::new();
    client.apply(ClientEvent::SocketOpened(Socket::Control));
    client.server(ServerMessage::Welcome {
        version: api::VERSION + 1,
        program: String::new(),
        you: api::ClientIdentity::in_demo(ME),
    });
    let SocketState::Refused { reason } = client.model.connection().state() else {
        panic!("connected to another version")
    };
    assert!(reason.contains("Reload"), "{reason}");
    client.take_effects();
    client.wait(60.0);
    assert!(
        !client.take_effects().contains(&ClientEffect::OpenSocket(Socket::Control)),
        "a refused link is not retried"
    );
}

#[test]
fn retries_wait_longer_each_time_and_say_when() {
    let mut client = TestClient::connected();
    let mut waits = Vec::new();
    for _ in 0..8 {
        client.lose_connection();
        let &SocketState::Lost { retry_at, .. } = client.model.connection().state() else {
            panic!("not lost")
        };
        waits.push(retry_at.since(client.now));
        client.take_effects();
        client.wait(waits[waits.len() - 1] + 0.001);
        assert!(client.take_effects().contains(&ClientEffect::OpenSocket(Socket::Control)));
    }
    assert!(waits.windows(2).all(|pair| pair[1] >= pair[0]), "{waits:?}");
    assert!(waits[0] < 0.5 && waits[7] <= 8.0, "{waits:?}");
    assert_eq!(client.model.connection().lost_since(), Some(ClientTime(0.0)), "lost since the first loss");
}

#[test]
fn a_silent_link_is_taken_for_dead_and_opened_again() {
    let mut client = TestClient::connected();
    for _ in 0..80 {
        client.wait(0.1);
    }
    assert!(client.take_effects().contains(&ClientEffect::CloseSocket(Socket::Control)));
    assert!(!client.model.is_connected());
}

#[test]
fn a_page_that_stood_still_does_not_blame_the_link() {
    let mut client = TestClient::connected();
    client.wait(0.5);
    client.wait(30.0);
    assert!(client.model.is_connected());
    for _ in 0..80 {
        client.wait(0.1);
    }
    assert!(!client.model.is_connected(), "but silence after it counts");
}

#[test]
fn pings_go_out_every_two_seconds() {
    let mut client = TestClient::connected();
    let mut pings = 0;
    for _ in 0..100 {
        client.wait(0.1);
        let token = 0;
        client.server(ServerMessage::Pong { token, now: Stamp::EPOCH });
        let is_ping =
            |effect: &&ClientEffect| matches!(effect, ClientEffect::Send(ClientMessage::Ping { .. }));
        pings += client.take_effects().iter().filter(is_ping).count();
    }
    assert!((4..=5).contains(&pings), "{pings} pings in ten seconds");
}

#[test]
fn a_reconnection_replaces_the_state_by_the_snapshot() {
    let mut client = TestClient::connected();
    client.event(api::Event::Tiles(TilesChanged {
        reset: true,
        added: vec![tile(1, 0, 0.0, 10), tile(2, 0, 4.0, 20)],
    }));
    client.event(api::Event::Control(Control { owner: Some(ME), name: "me".into(), request: None }));
    client.lose_connection();
    assert!(client.model.has_control(), "what was known stays until something newer comes");
    client.wait(1.0);
    client.connect();
    client.event(api::Event::Tiles(TilesChanged { reset: true, added: vec![tile(3, 0, 0.0, 5)] }));
    client.event(api::Event::Control(Control::default()));
    assert_eq!(client.model.live_map().tiles.points(), 5);
    assert!(!client.model.has_control());
}

#[test]
fn events_out_of_order_are_ignored_and_gaps_lead_to_a_new_connection() {
    let mut client = TestClient::connected();
    client.event(api::Event::Estimate(estimate_at(1.0, 1.0)));
    client.event(api::Event::Estimate(estimate_at(2.0, 2.0)));
    client.server(ServerMessage::Event { sequence: 1, event: api::Event::Estimate(estimate_at(1.0, 1.0)) });
    let x = client.model.robot.estimate.as_ref().map(|e| e.value.map_from_base.position.x);
    assert_eq!(x, Some(2.0));
    assert!(client.model.is_connected());
    client.server(ServerMessage::Event { sequence: 9, event: api::Event::Maps(Vec::new()) });
    assert!(client.take_effects().contains(&ClientEffect::CloseSocket(Socket::Control)));
    assert_eq!(client.model.maps().list(), None, "nothing after a gap is believed");
}
