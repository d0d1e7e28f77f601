//! Load on 127.0.0.1: many clients at once, and files over HTTP. The figures are printed and not judged; what fails is a gateway that stops serving:
//! `cargo test --release -p gateway --test gateway -- nightly:: --nocapture --test-threads 1`.
#![allow(clippy::print_stdout, reason = "printing is what these are for")]

use crate::support::{Gateway, Reply, TestCore, TestSocket};
use api::{CoreMessage, Event, ScanFrame, ServerMessage, StreamRequest};
use std::time::{Duration, Instant};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use vocab::{Pose, Stamp};

const CLIENTS: u32 = 16;
const DURATION: Duration = Duration::from_secs(5);
/// A full-resolution scan: 64,000 points of 1.7 bytes.
const SCAN_BYTES: usize = 110_000;

fn nanos_since(start: Instant) -> i64 {
    start.elapsed().as_nanos() as i64
}

/// Times of arrival after sending, milliseconds.
#[derive(Default)]
struct Delays(Vec<f64>);

impl Delays {
    fn add(&mut self, start: Instant, sent: Stamp) {
        self.0.push((nanos_since(start) - sent.nanos()) as f64 * 1e-6);
    }

    fn report(mut self, what: &str) {
        self.0.sort_by(f64::total_cmp);
        let at = |share: f64| {
            self.0.get(((self.0.len() - 1) as f64 * share) as usize).copied().unwrap_or(f64::NAN)
        };
        println!(
            "{what}: {} received, delay {:.2} ms median, {:.2} ms 99 %, {:.2} ms most",
            self.0.len(),
            at(0.5),
            at(0.99),
            at(1.0)
        );
    }
}

/// CPU time of this process, seconds.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<f64> = stat
        .rsplit(')')
        .next()
        .unwrap_or_default()
        .split(' ')
        .filter_map(|field| field.parse().ok())
        .collect();
    // User and system time are fields 14 and 15 of the line, in ticks of 10 ms; 3 is not a number.
    fields.get(10..12).map_or(0.0, |times| (times[0] + times[1]) / 100.0)
}

async fn feed(core: &mut TestCore, start: Instant) {
    let mut tick = tokio::time::interval(Duration::from_millis(10));
    for number in 0_u32.. {
        tick.tick().await;
        let stamp = Stamp::from_nanos(nanos_since(start));
        core.publish(Event::Estimate(api::Estimate { stamp, ..api::Estimate::default() })).await;
        if number % 10 == 0 {
            let points = vec![number as u8; SCAN_BYTES];
            core.send(&CoreMessage::Scan { stamp, map_from_base: Pose::IDENTITY, points }).await;
        }
    }
}

async fn watch_state(mut socket: TestSocket, start: Instant) -> Delays {
    let mut delays = Delays::default();
    while start.elapsed() < DURATION {
        if let ServerMessage::Event { event: Event::Estimate(estimate), .. } = socket.message().await {
            delays.add(start, estimate.stamp);
        }
    }
    delays
}

async fn watch_scans(mut socket: TestSocket, start: Instant) -> Delays {
    let mut delays = Delays::default();
    while start.elapsed() < DURATION {
        let Some(frame) = socket.next::<ScanFrame>().await else { break };
        delays.add(start, frame.stamp);
        socket.send(&StreamRequest::Acknowledge { sequence: frame.sequence }).await;
    }
    delays
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn load_of_sockets() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    let (mut controls, mut streams) = (Vec::new(), Vec::new());
    for number in 0..CLIENTS {
        controls.push(gateway.client(number.into()).await);
        let mut stream = gateway.socket(api::STREAM_PATH).await;
        stream.send(&StreamRequest::Open { version: api::VERSION, max_hz: 20.0 }).await;
        streams.push(stream);
    }
    core.listeners((CLIENTS, CLIENTS)).await;
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let controls: Vec<_> =
        controls.into_iter().map(|socket| tokio::spawn(watch_state(socket, start))).collect();
    let streams: Vec<_> =
        streams.into_iter().map(|socket| tokio::spawn(watch_scans(socket, start))).collect();
    let collect = async {
        let (mut states, mut scans) = (Delays::default(), Delays::default());
        for task in controls {
            states.0.extend(task.await.expect("no panic").0);
        }
        for task in streams {
            scans.0.extend(task.await.expect("no panic").0);
        }
        (states, scans)
    };
    let (states, scans) = tokio::select! { () = feed(&mut core, start) => panic!("the core stopped sending"), both = collect => both };
    let cores = (cpu_seconds() - cpu) / start.elapsed().as_secs_f64();
    println!(
        "{CLIENTS} clients, 100 poses/s and 10 scans/s of {SCAN_BYTES} bytes, {:.1} s:",
        DURATION.as_secs_f64()
    );
    states.report("poses");
    scans.report("scans");
    println!("CPU of gateway, made-up core and all clients: {cores:.2} cores");
}

/// Asks for `path` again and again over one connection; returns the number of answers.
async fn ask(gateway: &Gateway, path: &str, until: Instant) -> u64 {
    let mut stream = TcpStream::connect(gateway.address).await.expect("a connection");
    let request = format!("GET {path} HTTP/1.1\r\nhost: {}\r\n\r\n", gateway.address);
    let (mut answers, mut buffer) = (0, vec![0; 1 << 20]);
    while Instant::now() < until {
        stream.write_all(request.as_bytes()).await.expect("written");
        let mut filled = 0;
        loop {
            filled += stream.read(&mut buffer[filled..]).await.expect("read");
            let head = buffer[..filled].windows(4).position(|window| window == b"\r\n\r\n");
            if let Some(head) = head {
                let reply = Reply::parse(&buffer[..filled]);
                let length: usize = reply.header("content-length").parse().expect("a length");
                if filled == head + 4 + length {
                    break;
                }
            }
        }
        answers += 1;
    }
    answers
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn load_of_http() {
    let gateway = Gateway::start().await;
    let hash = "ab".repeat(32);
    gateway.write(&format!("data/tiles/ab/{hash}"), &vec![7; 50_000]);
    gateway.write("static/index.html", &[b'a'; 2000]);
    for path in ["/".to_owned(), api::paths::TILE_PATH.replace("{hash}", &hash)] {
        let (start, cpu) = (Instant::now(), cpu_seconds());
        let until = start + DURATION;
        let asking = futures_util::future::join_all((0..6).map(|_| ask(&gateway, &path, until)));
        let answers: u64 = asking.await.into_iter().sum();
        let seconds = start.elapsed().as_secs_f64();
        let cores = (cpu_seconds() - cpu) / seconds;
        println!(
            "{:.0} answers/s over 6 connections, {cores:.2} cores with the client: {path}",
            answers as f64 / seconds
        );
    }
}
