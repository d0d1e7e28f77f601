//! Attacks by somebody on the network, each with what has to come of it. `cargo xtask test security` runs them, and those of `access`.

use crate::abuse::resident_bytes;
use crate::access::{welcomed_with, with_access, with_limited_access};
use crate::support::{Gateway, PATIENCE, TestCore, TestSocket, client_id, lease, raise_file_limit, soon};
use api::access::{AccountReply, Secret};
use api::{
    ClientMessage, Command, Control, CoreMessage, Event, GatewayMessage, LeaseToken, Role, ServerMessage,
};
use gateway::Limits;
use std::time::{Duration, Instant};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};
use tokio_tungstenite::tungstenite::Message;
use vocab::{CommandId, Stamp};

fn stop(number: u128) -> ClientMessage {
    ClientMessage::Command { id: CommandId(uuid::Uuid::from_u128(number)), command: Command::StopMotion }
}

/// Who the core is told has pressed Stop.
async fn client_that_stops(core: &mut TestCore) -> vocab::ClientId {
    loop {
        if let GatewayMessage::Command { by, command: Command::StopMotion, .. } = core.command().await {
            return by.client;
        }
    }
}

#[tokio::test]
async fn an_id_that_was_heard_gives_nobody_the_lease() {
    let (gateway, mut core) = with_access().await;
    let mut holder = welcomed_with(&gateway, "admin", lease(1)).await;
    holder.send(&stop(1)).await;
    let owner = client_that_stops(&mut core).await;
    core.publish(Event::Control(Control { owner: Some(owner), name: "ada".into(), request: None })).await;
    // Everybody hears the id of the holder; the thief presents it as its own secret.
    let mut thief = welcomed_with(&gateway, "operator", lease(2)).await;
    let heard = thief
        .find(|event| match event {
            Event::Control(control) => control.owner,
            _ => None,
        })
        .await;
    assert_eq!(heard, owner);
    let mut thief = welcomed_with(&gateway, "operator", LeaseToken(heard.0)).await;
    thief.send(&stop(2)).await;
    assert_ne!(client_that_stops(&mut core).await, owner);
    gateway.stop().await;
}

#[tokio::test]
async fn a_stolen_secret_is_worth_nothing_without_the_account() {
    let (gateway, mut core) = with_access().await;
    let mut clients = Vec::new();
    for secret in ["admin", "operator"] {
        let mut socket = welcomed_with(&gateway, secret, lease(1)).await;
        socket.send(&stop(clients.len() as u128)).await;
        clients.push(client_that_stops(&mut core).await);
    }
    assert_ne!(clients[0], clients[1]);
    assert!(!clients.contains(&client_id(1)), "and without any account it is another one still");
    gateway.stop().await;
}

#[tokio::test]
async fn a_flood_of_one_account_does_not_delay_the_stop_of_another() {
    let (gateway, mut core) = with_access().await;
    let mut flooding = Vec::new();
    for number in 0..8 {
        let mut socket = welcomed_with(&gateway, "operator", lease(100 + number)).await;
        flooding.push(tokio::spawn(async move {
            for id in 0.. {
                let id = CommandId(uuid::Uuid::from_u64_pair(number as u64, id));
                socket.send(&ClientMessage::Command { id, command: Command::LeaveMap }).await;
            }
        }));
    }
    let mut viewer = welcomed_with(&gateway, "viewer", lease(1)).await;
    for number in 0..10 {
        let pressed = Instant::now();
        viewer.send(&stop(1_000 + number)).await;
        client_that_stops(&mut core).await;
        let took = pressed.elapsed();
        assert!(took < Duration::from_millis(200), "it took {took:?}");
    }
    flooding.into_iter().for_each(|task| task.abort());
    gateway.stop().await;
}

/// The core accepts the next command, which is to stop, or lets the next person in.
async fn answer_one(core: &mut TestCore) {
    match core.command().await {
        GatewayMessage::Command { id, by, command: Command::StopMotion } => {
            let event = Event::CommandDone { id, outcome: api::CommandOutcome::Accepted };
            core.send(&CoreMessage::Event { to: Some(by.client), event }).await;
        }
        GatewayMessage::Account { number, .. } => {
            let (secret, expires) = (Secret::new("5ec7e7"), Stamp::from_nanos(i64::MAX));
            let reply = AccountReply::SignedIn { secret, account: "ada".into(), role: Role::Admin, expires };
            core.send(&CoreMessage::AccountReply { number, result: Ok(reply) }).await;
        }
        other => panic!("another: {other:?}"),
    }
}

/// Fails unless motion can be stopped, and somebody can sign in, and nothing else is answered.
async fn expect_a_stop_and_a_sign_in(gateway: &Gateway, core: &mut TestCore) {
    let headers = ["authorization: Bearer viewer", "content-length: 0"];
    let pressed = Instant::now();
    let (reply, ()) =
        tokio::join!(gateway.request("POST", api::paths::STOP_PATH, &headers), answer_one(core));
    assert_eq!(reply.status, 204);
    assert!(pressed.elapsed() < Duration::from_millis(200), "it took {:?}", pressed.elapsed());
    let body = br#"{"account": "ada", "password": "correct horse battery"}"#;
    let length = format!("content-length: {}", body.len());
    let headers = [length.as_str()];
    let (reply, ()) =
        tokio::join!(gateway.send("POST", api::paths::SESSION_PATH, &headers, body), answer_one(core));
    assert_eq!((reply.status, reply.header("connection")), (200, "close"));
    gateway.get(api::paths::MAPS_PATH, &["authorization: Bearer viewer"]).await.expect_problem(503);
}

/// Opens connections from these addresses of this computer by turns, and sends nothing over any of them.
async fn half_open_connections(gateway: &Gateway, count: usize, addresses: usize) -> Vec<TcpStream> {
    let mut held = Vec::new();
    for number in 0..count {
        let socket = TcpSocket::new_v4().expect("a socket");
        let last = 2 + (number % addresses) as u8;
        socket.bind(([127, 0, 0, last], 0).into()).expect("another address of this computer");
        held.push(soon("a connection", socket.connect(gateway.address)).await.expect("a connection"));
    }
    held
}

/// Those beyond the share of the address end each other.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn ten_thousand_half_open_connections_of_one_address_keep_nobody_out() {
    raise_file_limit();
    let limits = Limits { header_timeout: 2 * PATIENCE, ..Limits::default() };
    let (gateway, _core) = with_limited_access(limits).await;
    let before = resident_bytes();
    let mut held = half_open_connections(&gateway, 10_000, 1).await;
    let reply = gateway.get(api::paths::MAPS_PATH, &["authorization: Bearer viewer"]).await;
    assert_eq!(reply.status, 200, "another address is served");
    let places = limits.connections_of_address;
    let pushed_out = &mut held[places];
    soon("an end", pushed_out.read_to_end(&mut Vec::new())).await.ok();
    let grown = resident_bytes().saturating_sub(before);
    assert!(grown < 64 << 20, "{} MB", grown >> 20);
    gateway.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn ten_thousand_half_open_connections_of_many_addresses_leave_the_stop_and_the_sign_in() {
    raise_file_limit();
    let limits = Limits { header_timeout: 2 * PATIENCE, ..Limits::default() };
    let (gateway, mut core) = with_limited_access(limits).await;
    let before = resident_bytes();
    let held = half_open_connections(&gateway, 10_000, 100).await;
    expect_a_stop_and_a_sign_in(&gateway, &mut core).await;
    let grown = resident_bytes().saturating_sub(before);
    assert!(grown < 64 << 20, "{} MB", grown >> 20);
    drop(held);
    gateway.stop().await;
}

#[tokio::test]
async fn accounts_that_take_all_connections_leave_the_stop_and_the_sign_in() {
    let limits = Limits { connections: 4, ..Limits::default() };
    let (gateway, mut core) = with_limited_access(limits).await;
    let mut seats = Vec::new();
    for number in 0..4 {
        seats.push(welcomed_with(&gateway, "operator", lease(number)).await);
    }
    expect_a_stop_and_a_sign_in(&gateway, &mut core).await;
    drop(seats);
    gateway.stop().await;
}

/// A control socket of this session, and whether it was welcomed.
async fn greeted(gateway: &Gateway, secret: &str, number: u128) -> (TestSocket, bool) {
    let header = format!("autoinspect-session={secret}");
    let mut socket = gateway.socket_with(api::CONTROL_PATH, ("cookie", &header)).await.expect("let in");
    socket.send(&ClientMessage::Hello { version: api::VERSION, lease: lease(number) }).await;
    let is_welcome = matches!(socket.message().await, ServerMessage::Welcome { .. });
    (socket, is_welcome)
}

#[tokio::test]
async fn an_account_that_takes_all_its_seats_leaves_those_of_others_and_a_stop_needs_none() {
    let limits = Limits { clients: 6, clients_of_account: 4, ..Limits::default() };
    let (gateway, mut core) = with_limited_access(limits).await;
    let mut seats = Vec::new();
    for number in 0..4 {
        let (socket, is_welcome) = greeted(&gateway, "operator", number).await;
        assert!(is_welcome);
        seats.push(socket);
    }
    assert!(!greeted(&gateway, "operator", 4).await.1, "its share is taken");
    for number in 10..12 {
        let (socket, is_welcome) = greeted(&gateway, "viewer", number).await;
        assert!(is_welcome, "others have theirs");
        seats.push(socket);
    }
    assert!(!greeted(&gateway, "admin", 20).await.1, "now all are taken");
    let headers = ["authorization: Bearer viewer", "content-length: 0"];
    let (reply, ()) =
        tokio::join!(gateway.request("POST", api::paths::STOP_PATH, &headers), answer_one(&mut core));
    assert_eq!(reply.status, 204);
    gateway.stop().await;
}

#[tokio::test]
async fn a_session_that_was_planted_before_a_sign_in_is_not_the_one_that_begins() {
    let (gateway, mut core) = with_access().await;
    let body = br#"{"account": "ada", "password": "correct horse battery"}"#;
    let length = format!("content-length: {}", body.len());
    let headers = [length.as_str(), "cookie: autoinspect-session=planted"];
    let core_side = async {
        let GatewayMessage::Account { number, .. } = core.command().await else { panic!("another") };
        let (secret, expires) = (Secret::new("5ec7e7"), Stamp::from_nanos(i64::MAX));
        let reply = AccountReply::SignedIn { secret, account: "ada".into(), role: Role::Admin, expires };
        core.send(&CoreMessage::AccountReply { number, result: Ok(reply) }).await;
    };
    let (reply, ()) = tokio::join!(gateway.send("POST", api::paths::SESSION_PATH, &headers, body), core_side);
    assert!(reply.header("set-cookie").starts_with("autoinspect-session=5ec7e7;"));
    let planted = gateway.get(api::paths::MAPS_PATH, &["cookie: autoinspect-session=planted"]).await;
    assert_eq!(planted.status, 401);
    gateway.stop().await;
}

#[tokio::test]
async fn malformed_frames_end_their_own_connection_only() {
    let (gateway, _core) = with_access().await;
    let mut viewer = welcomed_with(&gateway, "viewer", lease(1)).await;
    for seed in 0..60_u64 {
        let (mut socket, _) = greeted(&gateway, "operator", 100).await;
        let hash = blake3::hash(&seed.to_le_bytes());
        // The first byte names no message, so that chance makes none.
        let mut bytes = vec![0xff];
        bytes.extend_from_slice(&hash.as_bytes()[..(seed % 32) as usize]);
        let frame = match seed % 3 {
            0 => Message::Text("{\"Command\": {}}".into()),
            _ => Message::Binary(bytes.into()),
        };
        socket.send_raw(frame).await;
        soon("the end", socket.ended()).await;
    }
    viewer.send(&ClientMessage::Ping { token: 7 }).await;
    while !matches!(viewer.message().await, ServerMessage::Pong { token: 7, .. }) {}
    gateway.stop().await;
}

#[tokio::test]
async fn a_viewer_uploads_nothing() {
    let (gateway, _core) = with_access().await;
    let path = api::paths::UPLOAD_PATH.replace("{id}", "11111111-0000-4000-8000-000000000001");
    let headers = ["authorization: Bearer viewer", "content-length: 4"];
    gateway.send("PUT", &path, &headers, b"bomb").await.expect_problem(403);
    assert!(
        !gateway.folder.path().join("data/uploads").join("11111111-0000-4000-8000-000000000001").exists()
    );
    gateway.stop().await;
}

/// Sends the head of an edit of this length, and nothing of its content.
async fn begin_edit(gateway: &Gateway, secret: &str, length: usize) -> TcpStream {
    let mut stream = TcpStream::connect(gateway.address).await.expect("a connection");
    let head = format!(
        "POST /api/v1/site/edits HTTP/1.1\r\nhost: {}\r\nauthorization: Bearer {secret}\r\ncontent-length: {length}\r\n\r\n{{",
        gateway.address
    );
    stream.write_all(head.as_bytes()).await.expect("written");
    stream
}

#[tokio::test]
async fn an_operator_who_sends_edits_slowly_does_not_hold_those_of_others() {
    let (gateway, core) = with_access().await;
    let mut slow = Vec::new();
    for number in 0..40 {
        // Short and long ones.
        slow.push(begin_edit(&gateway, "operator", if number % 2 == 0 { 100 } else { 1 << 20 }).await);
    }
    let ask = async {
        let headers = ["authorization: Bearer admin", "content-length: 2"];
        gateway.send("POST", api::paths::SITE_EDITS_PATH, &headers, b"[]").await.status
    };
    let status =
        tokio::time::timeout(Duration::from_secs(10), ask).await.expect("nobody waits for the slow one");
    assert_eq!(status, 400, "it was read");
    drop((slow, core));
    gateway.stop().await;
}

/// Opens a connection from an address of this computer, asks for long answers, and reads nothing.
async fn slow_reader(gateway: &Gateway, last: u8) -> TcpStream {
    let socket = TcpSocket::new_v4().expect("a socket");
    socket.set_recv_buffer_size(4 << 10).expect("settable");
    socket.bind(([127, 0, 0, last], 0).into()).expect("an address of this computer");
    let mut stream = socket.connect(gateway.address).await.expect("a connection");
    let ask = format!("GET /long.js HTTP/1.1\r\nhost: {}\r\n\r\n", gateway.address).repeat(4);
    stream.write_all(ask.as_bytes()).await.ok();
    stream
}

/// 1,000 readers that read nothing are there at once. Those beyond the limit get a clear answer, the gateway stays small, and a viewer can still stop the robot, somebody can
/// sign in, and an operator gets a control socket.
#[tokio::test]
async fn a_thousand_slow_readers_keep_nobody_from_stop_sign_in_and_a_seat() {
    raise_file_limit();
    // They are not ended for reading nothing while the test goes on.
    let limits = Limits { write_stall: PATIENCE * 4, ..Limits::default() };
    let (gateway, mut core) = with_limited_access(limits).await;
    gateway.write("static/long.js", &vec![b' '; 4 << 20]);
    let before = resident_bytes();
    let mut readers = Vec::new();
    for number in 0..1_000_u16 {
        readers.push(slow_reader(&gateway, 10 + (number % 40) as u8).await);
    }
    let grown = resident_bytes().saturating_sub(before);
    println!("1,000 slow readers: {} MB grown", grown >> 20);
    assert!(grown < 64 << 20, "{} MB", grown >> 20);
    let stop = gateway.request(
        "POST",
        api::paths::STOP_PATH,
        &["authorization: Bearer viewer", "content-length: 0"],
    );
    let heard = async {
        let client = loop {
            if let GatewayMessage::Command { id, by, command: Command::StopMotion } = core.command().await {
                break (id, by.client);
            }
        };
        let event = Event::CommandDone { id: client.0, outcome: api::CommandOutcome::Accepted };
        core.send(&CoreMessage::Event { to: Some(client.1), event }).await;
    };
    let (answer, ()) = tokio::join!(stop, heard);
    assert_eq!(answer.status, 204);
    let body = br#"{"account": "ada", "password": "a wrong password"}"#;
    let length = format!("content-length: {}", body.len());
    let headers = ["content-type: application/json", &length];
    let sign_in = gateway.send("POST", api::paths::SESSION_PATH, &headers, body);
    let heard = async {
        loop {
            if let GatewayMessage::Account { number, .. } = core.command().await {
                let (kind, reason) = (api::access::AccountRefusalKind::NotSignedIn, "No.".to_owned());
                let result = Err(api::access::AccountRefusal { kind, reason });
                return core.send(&CoreMessage::AccountReply { number, result }).await;
            }
        }
    };
    let (answer, ()) = tokio::join!(sign_in, heard);
    assert_eq!(answer.status, 401, "the core was asked");
    let mut operator = welcomed_with(&gateway, "operator", lease(7)).await;
    operator
        .send(&ClientMessage::Command { id: CommandId(uuid::Uuid::from_u128(9)), command: Command::LeaveMap })
        .await;
    assert!(matches!(core.command().await, GatewayMessage::Command { command: Command::LeaveMap, .. }));
    // What a place beyond the limit is not for gets a clear answer.
    let refused = gateway.get(api::paths::MAPS_PATH, &["authorization: Bearer operator"]).await;
    refused.expect_problem(503);
    drop(readers);
    gateway.stop().await;
}
