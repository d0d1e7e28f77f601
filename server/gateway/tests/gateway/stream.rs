//! The stream socket: newest scan, credits, pauses.

use crate::support::{Gateway, TestCore, TestSocket, soon};
use api::{CoreMessage, MAX_UNACKNOWLEDGED, ScanFrame, StreamRequest};
use gateway::Limits;
use std::time::Duration;
use vocab::{Pose, Stamp};

async fn open(gateway: &Gateway, max_hz: f32) -> TestSocket {
    let mut socket = gateway.socket(api::STREAM_PATH).await;
    socket.send(&StreamRequest::Open { version: api::VERSION, max_hz }).await;
    socket
}

async fn send_scan(core: &mut TestCore, number: i64) {
    let points = vec![number as u8; 1000];
    core.send(&CoreMessage::Scan { stamp: Stamp::from_nanos(number), map_from_base: Pose::IDENTITY, points })
        .await;
}

async fn frame(socket: &mut TestSocket) -> ScanFrame {
    socket.next().await.expect("a scan")
}

#[tokio::test]
async fn four_frames_without_acknowledgement_then_the_newest() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    let mut reader = open(&gateway, 1000.0).await;
    let mut witness = open(&gateway, 1000.0).await;
    core.listeners((0, 2)).await;
    for number in 1..=20 {
        send_scan(&mut core, number).await;
        // The witness acknowledges everything, so once it has a scan the gateway has offered it to all.
        let seen = frame(&mut witness).await;
        assert_eq!(
            (seen.sequence, seen.stamp, &seen.points[..2]),
            (number as u64, Stamp::from_nanos(number), &[number as u8; 2][..])
        );
        witness.send(&StreamRequest::Acknowledge { sequence: seen.sequence }).await;
        if number as u64 <= MAX_UNACKNOWLEDGED {
            assert_eq!(frame(&mut reader).await.stamp, seen.stamp);
        }
    }
    reader.send(&StreamRequest::Acknowledge { sequence: 1 }).await;
    let next = frame(&mut reader).await;
    assert_eq!(
        (next.sequence, next.stamp),
        (5, Stamp::from_nanos(20)),
        "numbers go on, scans between are gone"
    );
}

#[tokio::test]
async fn a_paused_stream_gets_nothing_until_it_resumes() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    let mut paused = open(&gateway, 0.0).await;
    let mut witness = open(&gateway, 1000.0).await;
    core.listeners((0, 1)).await;
    send_scan(&mut core, 1).await;
    frame(&mut witness).await;
    paused.send(&StreamRequest::Open { version: api::VERSION, max_hz: 1000.0 }).await;
    core.listeners((0, 2)).await;
    send_scan(&mut core, 2).await;
    let first = frame(&mut paused).await;
    assert_eq!(first.sequence, 1);
}

#[tokio::test]
async fn a_rate_is_an_upper_bound() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    let mut slow = open(&gateway, 4.0).await;
    let mut witness = open(&gateway, 1000.0).await;
    core.listeners((0, 2)).await;
    let start = std::time::Instant::now();
    let feed = async {
        for number in 1.. {
            send_scan(&mut core, number).await;
            let sequence = frame(&mut witness).await.sequence;
            witness.send(&StreamRequest::Acknowledge { sequence }).await;
        }
    };
    let read = async {
        for _ in 0..4 {
            let sequence = frame(&mut slow).await.sequence;
            slow.send(&StreamRequest::Acknowledge { sequence }).await;
        }
    };
    tokio::select! { () = feed => {}, () = read => {} }
    assert!(
        start.elapsed() >= Duration::from_millis(740),
        "{:?} for the first and three more",
        start.elapsed()
    );
}

#[tokio::test]
async fn nonsense_closes_the_stream() {
    let gateway = Gateway::start().await;
    for request in [
        StreamRequest::Open { version: api::VERSION + 1, max_hz: 1.0 },
        StreamRequest::Acknowledge { sequence: 0 },
        StreamRequest::Acknowledge { sequence: 1 },
    ] {
        let mut socket = gateway.socket(api::STREAM_PATH).await;
        socket.send(&request).await;
        socket.ended().await;
    }
    let mut socket = open(&gateway, 1.0).await;
    socket.send(&StreamRequest::Acknowledge { sequence: 1 }).await;
    socket.ended().await;
}

#[tokio::test]
async fn a_quiet_stream_lives_as_long_as_it_answers_pings() {
    let silence = Duration::from_secs(1);
    let gateway = Gateway::start_with(Limits { silence, ..Limits::default() }).await;
    let mut core = gateway.core().await;
    let mut alive = open(&gateway, 10.0).await;
    let mut dead = open(&gateway, 10.0).await;
    core.listeners((0, 2)).await;
    // Reading is what answers pings; the dead one does not read.
    let gone = soon("the dead stream's end", core.listeners((0, 1)));
    tokio::select! { () = gone => {}, frame = alive.next::<ScanFrame>() => panic!("{frame:?}") }
    send_scan(&mut core, 1).await;
    assert_eq!(frame(&mut alive).await.stamp, Stamp::from_nanos(1));
    dead.ended().await;
}
