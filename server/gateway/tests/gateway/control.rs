//! The control socket: greeting, snapshot, changes, commands.

use crate::support::{Gateway, TestSocket, caller, client_id, lease, soon};
use api::{
    Battery, ClientMessage, Command, CommandOutcome, CoreMessage, Event, GatewayMessage, ServerMessage,
};
use gateway::Limits;
use site_model::{Edit, EditId};
use std::time::Duration;
use tokio_tungstenite::tungstenite::Message;
use vocab::{CommandId, Stamp};

fn battery(charge: f32) -> Event {
    Event::Battery(Battery { charge, ..Battery::default() })
}

fn command(number: u128, command: Command) -> ClientMessage {
    ClientMessage::Command { id: command_id(number), command }
}

fn command_id(number: u128) -> CommandId {
    CommandId(uuid::Uuid::from_u128(number))
}

async fn answer(socket: &mut TestSocket) -> (CommandId, CommandOutcome) {
    let take = |event: &Event| match event {
        Event::CommandDone { id, outcome } => Some((*id, outcome.clone())),
        _ => None,
    };
    socket.find(take).await
}

#[tokio::test]
async fn a_client_is_welcomed_and_told_everything_once_without_gaps() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    core.publish(battery(0.25)).await;
    core.publish(Event::Mapping(api::Mapping::Idle)).await;
    let mut first = gateway.client(1).await;
    first.find(|event| (*event == Event::Mapping(api::Mapping::Idle)).then_some(())).await;

    let mut second = gateway.client(2).await;
    let mut kinds = Vec::new();
    for expected in 1..=3 {
        let (sequence, event) = second.event().await;
        assert_eq!(sequence, expected);
        kinds.push(std::mem::discriminant(&event));
    }
    kinds.dedup();
    assert_eq!(kinds.len(), 3, "battery, mapping and platform, each once");
    core.publish(battery(0.5)).await;
    let (sequence, event) = second.event().await;
    assert_eq!((sequence, event), (4, battery(0.5)));
    gateway.stop().await;
}

/// Forty megabytes of graphs come while a client does not read: it gets few of them, the last among them, and every tile
/// once.
#[tokio::test]
async fn a_slow_client_gets_the_newest_and_misses_no_tile() {
    const ROUNDS: u32 = 200;
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    let mut slow = gateway.client(1).await;
    let mut witness = gateway.client(2).await;
    core.listeners((2, 0)).await;
    let feed = async {
        for round in 0..ROUNDS {
            let id = vocab::KeyframeId(round);
            let nodes = vec![api::GraphNode { id, ..api::GraphNode::default() }; 4000];
            core.publish(Event::Graph(api::Graph { nodes, ..api::Graph::default() })).await;
            let tile = api::TileEntry {
                hash: api::TileHash([0; 32]),
                anchor: api::TileAnchor::Map,
                level: 0,
                spacing_m: 1.0,
                bounds: vocab::Aabb { min: [0.0; 3], max: [1.0; 3] },
                points: round,
                bytes: 1,
            };
            core.publish(Event::Tiles(api::TilesChanged { reset: round == 0, added: vec![tile] })).await;
        }
    };
    let last = |event: &Event| match event {
        Event::Tiles(change) => change.added.iter().any(|tile| tile.points == ROUNDS - 1).then_some(()),
        _ => None,
    };
    tokio::join!(feed, witness.find(last));

    let (mut graphs, mut tiles, mut next) = (Vec::new(), Vec::new(), 1);
    while graphs.last() != Some(&(ROUNDS - 1)) || tiles.last() != Some(&(ROUNDS - 1)) {
        let (sequence, event) = slow.event().await;
        assert_eq!(sequence, next, "no gaps");
        next += 1;
        match event {
            Event::Graph(graph) => graphs.push(graph.nodes[0].id.0),
            Event::Tiles(change) => {
                assert_eq!(change.reset, tiles.is_empty(), "only the first resets");
                tiles.extend(change.added.iter().map(|tile| tile.points));
            }
            _ => {}
        }
    }
    assert!(graphs.len() < ROUNDS as usize / 2, "{} graphs", graphs.len());
    assert!(graphs.is_sorted());
    assert!(tiles.into_iter().eq(0..ROUNDS), "every tile once, in order");
}

#[tokio::test]
async fn another_version_is_refused_in_a_sentence() {
    let gateway = Gateway::start().await;
    let mut socket = gateway.socket(api::CONTROL_PATH).await;
    socket.send(&ClientMessage::Hello { version: api::VERSION + 1, lease: lease(1) }).await;
    let reason = socket.refusal().await;
    assert!(reason.contains("version") && reason.contains("Reload"), "{reason}");
}

#[tokio::test]
async fn what_is_no_message_or_out_of_turn_is_refused() {
    let gateway = Gateway::start().await;
    for message in [
        Message::Binary(vec![255; 40].into()),
        Message::Text("hello".into()),
        Message::Binary(api::encode(&ClientMessage::Ping { token: 1 }).into()),
    ] {
        let mut socket = gateway.socket(api::CONTROL_PATH).await;
        socket.send_raw(message).await;
        socket.refusal().await;
    }
    let mut socket = gateway.client(1).await;
    socket.send(&ClientMessage::Hello { version: api::VERSION, lease: lease(1) }).await;
    socket.refusal().await;
}

#[tokio::test]
async fn commands_carry_their_maker_and_answers_go_to_it_alone() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    let mut maker = gateway.client(1).await;
    let mut other = gateway.client(2).await;
    maker.find(|event| matches!(event, Event::Platform(p) if p.core_connected).then_some(())).await;
    maker.send(&command(7, Command::StopMotion)).await;
    let forwarded = core.command().await;
    let expected = GatewayMessage::Command { id: command_id(7), by: caller(1), command: Command::StopMotion };
    assert_eq!(forwarded, expected);
    let done = Event::CommandDone { id: command_id(7), outcome: CommandOutcome::Accepted };
    core.send(&CoreMessage::Event { to: Some(client_id(1)), event: done }).await;
    assert_eq!(answer(&mut maker).await, (command_id(7), CommandOutcome::Accepted));
    core.publish(battery(0.75)).await;
    let mark = |event: &Event| {
        assert!(!matches!(event, Event::CommandDone { .. }), "not for the other");
        (*event == battery(0.75)).then_some(())
    };
    other.find(mark).await;
}

#[tokio::test]
async fn pings_come_back_with_the_robots_clock() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    let now = Stamp::from_parts(1000, 0);
    let report = api::Platform { robot: "r".into(), now, ..api::Platform::default() };
    core.publish(Event::Platform(report)).await;
    let mut socket = gateway.client(1).await;
    socket.find(|event| matches!(event, Event::Platform(p) if p.robot == "r").then_some(())).await;
    for token in [u64::MAX, 3, 3] {
        socket.send(&ClientMessage::Ping { token }).await;
    }
    for expected in [u64::MAX, 3, 3] {
        let pong = loop {
            match socket.message().await {
                ServerMessage::Pong { token, now } => break (token, now),
                _ => continue,
            }
        };
        assert_eq!(pong.0, expected);
        assert!(pong.1 >= now && pong.1.parts().0 < 1003, "{pong:?}");
    }
}

#[tokio::test]
async fn a_silent_client_is_closed_and_a_pinging_one_is_not() {
    let silence = Duration::from_secs(1);
    let gateway = Gateway::start_with(Limits { silence, ..Limits::default() }).await;
    let mut silent = gateway.client(1).await;
    let mut lively = gateway.client(2).await;
    let mut ended = std::pin::pin!(silent.ended());
    // The lively one asks and reads without pause until the silent one is gone.
    loop {
        tokio::select! {
            () = &mut ended => break,
            () = async {
                lively.send(&ClientMessage::Ping { token: 0 }).await;
                lively.message().await;
            } => {}
        }
    }
    lively.send(&ClientMessage::Ping { token: 9 }).await;
    while !matches!(lively.message().await, ServerMessage::Pong { token: 9, .. }) {}
    let mut mute = gateway.socket(api::CONTROL_PATH).await;
    soon("the end of one that never says hello", mute.ended()).await;
}

#[tokio::test]
async fn floods_of_commands_are_refused_but_orders_to_stop_pass() {
    let gateway = Gateway::start_with(Limits { commands_per_second: 5.0, ..Limits::default() }).await;
    let mut core = gateway.core().await;
    let mut socket = gateway.client(1).await;
    socket.find(|event| matches!(event, Event::Platform(p) if p.core_connected).then_some(())).await;
    for number in 0..50 {
        socket.send(&command(number, Command::ReleaseControl)).await;
    }
    socket.send(&command(99, Command::StopMotion)).await;
    // It comes after the commands, and the stop anywhere: it has a lane of its own.
    let edit = Edit { id: EditId(uuid::Uuid::from_u128(1)), changes: Vec::new() };
    socket.send(&ClientMessage::Edit(edit)).await;
    let (mut forwarded, mut stops) = (0, 0);
    while let GatewayMessage::Command { command, .. } = core.command().await {
        if command == Command::StopMotion {
            stops += 1;
        } else {
            forwarded += 1;
        }
    }
    assert_eq!(stops, 1);
    assert!((10..20).contains(&forwarded), "{forwarded} of 50: a burst of 10, then 5 a second");
    let (_, outcome) = answer(&mut socket).await;
    assert!(matches!(outcome, CommandOutcome::Refused(reason) if reason.contains("too fast")));
}

#[tokio::test]
async fn a_client_too_many_is_refused_and_a_place_freed_is_given() {
    let gateway = Gateway::start_with(Limits { clients: 2, ..Limits::default() }).await;
    let mut core = gateway.core().await;
    let _one = gateway.client(1).await;
    let two = gateway.client(2).await;
    core.listeners((2, 0)).await;
    let mut three = gateway.socket(api::CONTROL_PATH).await;
    three.send(&ClientMessage::Hello { version: api::VERSION, lease: lease(3) }).await;
    assert!(three.refusal().await.contains("2 clients"));
    drop(two);
    core.listeners((1, 0)).await;
    gateway.client(3).await;
}

#[tokio::test]
async fn only_pages_of_this_server_may_open_sockets() {
    let gateway = Gateway::start().await;
    let own = format!("http://{}", gateway.address);
    for path in [api::CONTROL_PATH, api::STREAM_PATH] {
        assert!(gateway.socket_from(path, &own).await.is_ok());
        for foreign in ["http://evil.example", "null", "http://127.0.0.1", "https://127.0.0.1:1"] {
            assert_eq!(gateway.socket_from(path, foreign).await.err(), Some(403), "{foreign}");
        }
    }
}

#[tokio::test]
async fn stopping_closes_the_sockets() {
    let gateway = Gateway::start().await;
    let mut control = gateway.client(1).await;
    let mut stream = gateway.socket(api::STREAM_PATH).await;
    let stopped = async {
        control.ended().await;
        stream.ended().await;
    };
    tokio::join!(gateway.stop(), stopped);
}

#[tokio::test]
async fn the_core_is_told_which_clients_are_connected() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    let one = gateway.client(1).await;
    core.clients(&[client_id(1)]).await;
    // After a change of its network a client has two sockets for a while.
    let again = gateway.client(1).await;
    let mut both = [client_id(1), client_id(2)];
    both.sort();
    let two = gateway.client(2).await;
    core.clients(&both).await;
    drop(one);
    drop(two);
    core.clients(&[client_id(1)]).await;
    drop(again);
    core.clients(&[]).await;
    gateway.stop().await;
}
