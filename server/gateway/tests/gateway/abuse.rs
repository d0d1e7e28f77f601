//! Clients that mean harm, or are merely broken.

use crate::support::{Gateway, PATIENCE, lease, soon};
use api::{ClientMessage, CoreMessage, Event, Graph, GraphNode, ScanFrame, StreamRequest};
use gateway::Limits;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use std::time::{Duration, Instant};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::Message;
use vocab::{Pose, Stamp};

fn graph(nodes: usize) -> Event {
    Event::Graph(Graph { nodes: vec![GraphNode::default(); nodes], ..Graph::default() })
}

/// Resident memory of this process, bytes. The gateway under test runs in it.
pub fn resident_bytes() -> u64 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages: u64 = statm.split(' ').nth(1).and_then(|pages| pages.parse().ok()).unwrap_or_default();
    pages * 4096
}

/// Several hundred megabytes are offered to clients that read nothing; a client that reads is served all the while.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn clients_that_never_read_cost_little_and_are_closed() {
    let write_stall = Duration::from_secs(2);
    let silence = 2 * PATIENCE;
    let gateway = Gateway::start_with(Limits { write_stall, silence, ..Limits::default() }).await;
    let mut core = gateway.core().await;
    let mut stuck = Vec::new();
    for number in 0..8 {
        stuck.push(gateway.client(number).await);
        let mut stream = gateway.socket(api::STREAM_PATH).await;
        stream.send(&StreamRequest::Open { version: api::VERSION, max_hz: 60.0 }).await;
        stuck.push(stream);
    }
    let mut reader = gateway.client(100).await;
    core.listeners((9, 8)).await;
    let before = resident_bytes();
    let mut peak = before;
    let points = vec![0; 200_000];
    let offer = async {
        // Until all that do not read are gone; 300 kB of graph and 200 kB of scan each round, to nine and eight clients.
        for round in 0.. {
            core.publish(graph(4000)).await;
            core.publish(Event::Battery(api::Battery { charge: round as f32, ..api::Battery::default() }))
                .await;
            let scan = CoreMessage::Scan {
                stamp: Stamp::from_nanos(round),
                map_from_base: Pose::IDENTITY,
                points: points.clone(),
            };
            core.send(&scan).await;
            reader.send(&ClientMessage::Ping { token: 0 }).await;
            let current = |event: &Event| match event {
                Event::Battery(battery) => (battery.charge >= round as f32).then_some(()),
                Event::Platform(platform) if platform.clients == 1 => Some(()),
                _ => None,
            };
            reader.find(current).await;
            peak = peak.max(resident_bytes());
            if gateway.get(api::paths::HEALTH_PATH, &[]).await.json()["clients"] == 1 {
                return round;
            }
        }
        0
    };
    let rounds = soon("the end of those that do not read", offer).await;
    let grown = peak.saturating_sub(before);
    println!("{rounds} rounds, {} MB offered, {} MB grown", rounds * 17 / 2 / 2, grown >> 20);
    assert!(rounds > 5, "{rounds}");
    assert!(grown < 100 << 20, "{} MB", grown >> 20);
}

#[tokio::test]
async fn long_messages_are_not_read() {
    let gateway = Gateway::start().await;
    for path in [api::CONTROL_PATH, api::STREAM_PATH] {
        let mut socket = gateway.socket(path).await;
        socket.send_raw(Message::Binary(vec![0; 1 << 20].into())).await;
        soon("the end", socket.ended()).await;
    }
}

#[tokio::test]
async fn a_flood_of_pings_that_is_not_read_is_refused() {
    let gateway =
        Gateway::start_with(Limits { write_stall: Duration::from_secs(60), ..Limits::default() }).await;
    let mut core = gateway.core().await;
    let mut socket = gateway.client(1).await;
    core.listeners((1, 0)).await;
    // Fills the way to the client, so that pongs pile up behind it.
    let fill = async {
        loop {
            core.publish(graph(20_000)).await;
            tokio::task::yield_now().await;
        }
    };
    let flood = async {
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            socket.send(&ClientMessage::Ping { token: 0 }).await;
            let health = gateway.get(api::paths::HEALTH_PATH, &[]).await;
            if health.json()["clients"] == 0 {
                return;
            }
        }
        panic!("still there");
    };
    tokio::select! { () = fill => {}, () = flood => {} }
}

#[tokio::test]
async fn slow_heads_and_idle_connections_are_closed() {
    let header_timeout = Duration::from_millis(200);
    let gateway = Gateway::start_with(Limits { header_timeout, ..Limits::default() }).await;
    for start in ["", "GET / HTTP/1.1\r\nhost: localhost\r\nx-slow: "] {
        let mut stream = TcpStream::connect(gateway.address).await.expect("a connection");
        stream.write_all(start.as_bytes()).await.expect("written");
        let mut rest = Vec::new();
        soon("the end of a slow connection", stream.read_to_end(&mut rest)).await.ok();
    }
    let mut idle = TcpStream::connect(gateway.address).await.expect("a connection");
    idle.write_all(b"GET /api/v1/health HTTP/1.1\r\nhost: localhost\r\n\r\n").await.expect("written");
    let mut rest = Vec::new();
    soon("the end of an idle connection", idle.read_to_end(&mut rest)).await.ok();
    assert!(rest.starts_with(b"HTTP/1.1 503"));
}

#[tokio::test]
async fn huge_heads_are_refused() {
    let gateway = Gateway::start().await;
    let long = format!("x: {}", "a".repeat(100_000));
    let many: Vec<String> = (0..200).map(|number| format!("x-{number}: a")).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    for headers in [&[long.as_str()][..], &many[..]] {
        let mut stream = TcpStream::connect(gateway.address).await.expect("a connection");
        let head = format!("GET / HTTP/1.1\r\nhost: localhost\r\n{}\r\n\r\n", headers.join("\r\n"));
        // It may hang up in the middle of our writing.
        stream.write_all(head.as_bytes()).await.ok();
        let mut reply = Vec::new();
        soon("a reply", stream.read_to_end(&mut reply)).await.ok();
        assert!(
            reply.is_empty() || reply.starts_with(b"HTTP/1.1 431"),
            "{}",
            String::from_utf8_lossy(&reply)
        );
    }
}

#[tokio::test]
async fn a_connection_too_many_is_told_so() {
    let gateway =
        Gateway::start_with(Limits { connections: 2, reserved_connections: 0, ..Limits::default() }).await;
    let _one = gateway.client(1).await;
    let _two = gateway.client(2).await;
    let mut stream = TcpStream::connect(gateway.address).await.expect("a connection");
    let mut reply = String::new();
    soon("a reply", stream.read_to_string(&mut reply)).await.expect("text");
    let (head, body) = reply.split_once("\r\n\r\n").expect("a head");
    assert!(head.starts_with("HTTP/1.1 503 "));
    let problem: api::Problem = serde_json::from_str(body).expect("a problem");
    assert_eq!(problem.status, 503);
}

/// Whatever bytes a core sends, it is left and tried again, or waited for; clients are served meanwhile.
#[test]
fn a_core_that_raves_harms_nobody() {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("runtime");
    let gateway = runtime.block_on(Gateway::start());
    let mut runner = TestRunner::new(Config { cases: 30, ..Config::default() });
    let framed = prop::collection::vec(any::<u8>(), 0..300).prop_map(|body| {
        let mut bytes = (body.len() as u32).to_le_bytes().to_vec();
        bytes.extend(body);
        bytes
    });
    let bytes = prop_oneof![framed, prop::collection::vec(any::<u8>(), 0..300)];
    let result = runner.run(&bytes, |bytes| {
        runtime.block_on(async {
            let mut core = gateway.core().await;
            core.send_bytes(&bytes).await;
            drop(core);
        });
        Ok(())
    });
    result.expect("no case fails");
    runtime.block_on(async {
        let mut core = gateway.core().await;
        core.publish(graph(3)).await;
        let mut client = gateway.client(1).await;
        client.find(|event| (*event == graph(3)).then_some(())).await;
    });
}

/// Whatever bytes come, over TCP, over a WebSocket or from a client past its greeting: the gateway goes on.
#[test]
fn random_bytes_harm_nobody() {
    let runtime =
        tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().expect("runtime");
    let gateway = runtime.block_on(Gateway::start());
    let mut core = runtime.block_on(gateway.core());
    let mut runner = TestRunner::new(Config { cases: 200, ..Config::default() });
    let path = prop_oneof![Just(api::CONTROL_PATH), Just(api::STREAM_PATH)];
    let bytes = prop::collection::vec(any::<u8>(), 0..200);
    let result = runner.run(&(path, any::<bool>(), bytes), |(path, greeted, bytes)| {
        runtime.block_on(async {
            let mut socket = gateway.socket(path).await;
            if greeted {
                socket.send(&ClientMessage::Hello { version: api::VERSION, lease: lease(1) }).await;
            }
            socket.send_raw(Message::Binary(bytes.clone().into())).await;
            let mut raw = TcpStream::connect(gateway.address).await.expect("a connection");
            raw.write_all(&bytes).await.ok();
            // Below the message layer: bytes that are no frame.
            let tcp = socket.tcp();
            tcp.write_all(&bytes).await.ok();
        });
        Ok(())
    });
    result.expect("no case fails");
    runtime.block_on(async {
        core.publish(graph(1)).await;
        let mut client = gateway.client(2).await;
        client.find(|event| matches!(event, Event::Graph(_)).then_some(())).await;
        let mut stream = gateway.socket(api::STREAM_PATH).await;
        stream.send(&StreamRequest::Open { version: api::VERSION, max_hz: 10.0 }).await;
        core.listeners((1, 1)).await;
        core.send(&CoreMessage::Scan { stamp: Stamp::EPOCH, map_from_base: Pose::IDENTITY, points: vec![1] })
            .await;
        assert!(stream.next::<ScanFrame>().await.is_some());
        gateway.stop().await;
    });
}
