//! Connections: opening, losing, snapshots, order of events.

use super::*;

#[test]
fn says_hello_and_is_connected_after_the_welcome() {
    let mut bench = Bench::new();
    assert_eq!(
        bench.take(),
        [ClientEffect::OpenSocket(Socket::Control), ClientEffect::OpenSocket(Socket::Stream)]
    );
    bench.apply(ClientEvent::SocketOpened(Socket::Control));
    assert_eq!(
        bench.take(),
        [ClientEffect::Send(ClientMessage::Hello { version: api::VERSION, client: ME })]
    );
    assert!(!bench.model.link.connected());
    bench.welcome();
    assert!(bench.model.link.connected());
}

#[test]
fn a_server_of_another_version_is_refused_with_a_sentence() {
    let mut bench = Bench::new();
    bench.apply(ClientEvent::SocketOpened(Socket::Control));
    bench.server(ServerMessage::Welcome { version: api::VERSION + 1, program: String::new() });
    let LinkState::Refused { reason } = bench.model.link.state() else {
        panic!("connected to another version")
    };
    assert!(reason.contains("Reload"), "{reason}");
    bench.take();
    bench.wait(60.0);
    assert!(
        !bench.take().contains(&ClientEffect::OpenSocket(Socket::Control)),
        "a refused link is not retried"
    );
}

#[test]
fn retries_wait_longer_each_time_and_say_when() {
    let mut bench = Bench::connected();
    let mut waits = Vec::new();
    for _ in 0..8 {
        lose(&mut bench);
        let &LinkState::Lost { retry_at, .. } = bench.model.link.state() else { panic!("not lost") };
        waits.push(retry_at.since(bench.now));
        bench.take();
        bench.wait(waits[waits.len() - 1] + 0.001);
        assert!(bench.take().contains(&ClientEffect::OpenSocket(Socket::Control)));
    }
    assert!(waits.windows(2).all(|pair| pair[1] >= pair[0]), "{waits:?}");
    assert!(waits[0] < 0.5 && waits[7] <= 8.0, "{waits:?}");
    assert_eq!(bench.model.link.lost_since(), Some(ClientTime(0.0)), "lost since the first loss");
}

#[test]
fn a_silent_link_is_taken_for_dead_and_opened_again() {
    let mut bench = Bench::connected();
    for _ in 0..80 {
        bench.wait(0.1);
    }
    assert!(bench.take().contains(&ClientEffect::CloseSocket(Socket::Control)));
    assert!(!bench.model.link.connected());
}

#[test]
fn a_page_that_stood_still_does_not_blame_the_link() {
    let mut bench = Bench::connected();
    bench.wait(0.5);
    bench.wait(30.0);
    assert!(bench.model.link.connected());
    for _ in 0..80 {
        bench.wait(0.1);
    }
    assert!(!bench.model.link.connected(), "but silence after it counts");
}

#[test]
fn pings_go_out_every_two_seconds() {
    let mut bench = Bench::connected();
    let mut pings = 0;
    for _ in 0..100 {
        bench.wait(0.1);
        let token = bench.model.pending.len() as u64;
        bench.server(ServerMessage::Pong { token, now: Stamp::EPOCH });
        let is_ping =
            |effect: &&ClientEffect| matches!(effect, ClientEffect::Send(ClientMessage::Ping { .. }));
        pings += bench.take().iter().filter(is_ping).count();
    }
    assert!((4..=5).contains(&pings), "{pings} pings in ten seconds");
}

#[test]
fn a_reconnection_replaces_the_state_by_the_snapshot() {
    let mut bench = Bench::connected();
    bench.event(api::Event::Tiles(TilesChanged {
        reset: true,
        added: vec![tile(1, 0, 0.0, 10), tile(2, 0, 4.0, 20)],
    }));
    bench.event(api::Event::Control(Control { owner: Some(ME), name: "me".into() }));
    lose(&mut bench);
    assert!(bench.model.has_control(), "what was known stays until something newer comes");
    bench.wait(1.0);
    bench.connect();
    bench.event(api::Event::Tiles(TilesChanged { reset: true, added: vec![tile(3, 0, 0.0, 5)] }));
    bench.event(api::Event::Control(Control::default()));
    assert_eq!(bench.model.live.tiles.points(), 5);
    assert!(!bench.model.has_control());
}

#[test]
fn events_out_of_order_are_ignored_and_gaps_lead_to_a_new_connection() {
    let mut bench = Bench::connected();
    bench.event(api::Event::Estimate(estimate_at(1.0, 1.0)));
    bench.event(api::Event::Estimate(estimate_at(2.0, 2.0)));
    bench.server(ServerMessage::Event { sequence: 1, event: api::Event::Estimate(estimate_at(1.0, 1.0)) });
    let x = bench.model.robot.estimate.as_ref().map(|e| e.value.map_from_base.position.x);
    assert_eq!(x, Some(2.0));
    assert!(bench.model.link.connected());
    bench.server(ServerMessage::Event { sequence: 9, event: api::Event::Maps(Vec::new()) });
    assert!(bench.take().contains(&ClientEffect::CloseSocket(Socket::Control)));
    assert_eq!(bench.model.maps, None, "nothing after a gap is believed");
}
