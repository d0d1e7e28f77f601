//! Load on a whole platform, with figures: fifty clients over TLS, and the control loop under a flood of sign-ins.

use super::client::Client;
use super::floods::{Attack, Flood};
use super::guarded::{GuardedPlatform, connect_from};
use api::{ClientMessage, ScanFrame, ServerMessage, StreamRequest};
use std::io;
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use tungstenite::Message;
use tungstenite::client::IntoClientRequest;

const CLIENTS: u64 = 50;
const DURATION: Duration = Duration::from_secs(20);
const PING_PERIOD: Duration = Duration::from_millis(200);

/// Longest median time of a message there and back.
const LAG_LIMIT: Duration = Duration::from_millis(100);

/// Most that gateway and core may take more with all clients than with one, cores.
const CORES_LIMIT: f64 = 1.0;

/// The time over which the processor time of the control loop is counted: it ticks every 50 ms, so that one holds the steps of at most one tick.
const WINDOW: Duration = Duration::from_millis(20);

/// A window in which the watching thread itself was late is not counted.
const WINDOW_LIMIT: Duration = Duration::from_millis(30);

/// Name of the core's thread that steps the stack.
const CONTROL_THREAD: &str = "control";

type TlsStream = StreamOwned<ClientConnection, TcpStream>;

/// Trusts the robot's own authority, and nothing else.
fn trust(data: &Path) -> Arc<ClientConfig> {
    let mut roots = RootCertStore::empty();
    let authority = CertificateDer::from_pem_file(data.join("tls/authority.pem")).expect("a certificate");
    roots.add(authority).expect("trusted");
    let builder = ClientConfig::builder_with_provider(Arc::new(default_provider()));
    let builder = builder.with_safe_default_protocol_versions().expect("versions");
    Arc::new(builder.with_root_certificates(roots).with_no_client_auth())
}

fn encrypted(stream: TcpStream, trust: &Arc<ClientConfig>) -> TlsStream {
    let name = ServerName::try_from("localhost").expect("a name");
    StreamOwned::new(ClientConnection::new(Arc::clone(trust), name).expect("a connection"), stream)
}

/// Processor time of these processes, seconds.
fn cpu_seconds(processes: [u32; 2]) -> f64 {
    let of = |process: u32| {
        let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
        let fields: Vec<f64> = stat
            .rsplit(')')
            .next()
            .unwrap_or_default()
            .split(' ')
            .filter_map(|field| field.parse().ok())
            .collect();
        // User and system time are fields 14 and 15 of the line, in ticks of 10 ms; 3 is not a number.
        fields.get(10..12).map_or(0.0, |times| (times[0] + times[1]) / 100.0)
    };
    processes.into_iter().map(of).sum()
}

/// Pings over an encrypted control socket until it is over. Returns the times there and back.
fn ping(
    platform: &GuardedPlatform,
    trust: &Arc<ClientConfig>,
    token: &str,
    name: u64,
    is_over: &AtomicBool,
) -> Vec<Duration> {
    let address = platform.address();
    let stream = connect_from(3, address).expect("a connection");
    let waiting = stream.try_clone().expect("a second handle");
    let url = format!("wss://localhost:{}{}", address.port(), api::CONTROL_PATH);
    let mut client = Client::over(encrypted(stream, trust), &url, token, name).expect("a socket");
    waiting.set_read_timeout(Some(Duration::from_millis(20))).expect("settable");
    let (mut times, mut sent) = (Vec::new(), None);
    let mut due = Instant::now();
    while !is_over.load(Ordering::Relaxed) {
        if sent.is_none() && Instant::now() >= due {
            client.send(&ClientMessage::Ping { token: 1 }).expect("sent");
            sent = Some(Instant::now());
        }
        if let Some(ServerMessage::Pong { .. }) = client.read().expect("the socket stays open")
            && let Some(sent) = sent.take()
        {
            times.push(sent.elapsed());
            due = Instant::now() + PING_PERIOD;
        }
    }
    times
}

/// Reads scans over an encrypted stream socket until it is over. Returns their number.
fn watch(
    platform: &GuardedPlatform,
    trust: &Arc<ClientConfig>,
    token: &str,
    is_over: &AtomicBool,
) -> io::Result<u64> {
    let address = platform.address();
    let stream = connect_from(3, address)?;
    let waiting = stream.try_clone()?;
    let url = format!("wss://localhost:{}{}", address.port(), api::STREAM_PATH);
    let mut request = url.into_client_request().map_err(io::Error::other)?;
    request
        .headers_mut()
        .insert("authorization", format!("Bearer {token}").parse().map_err(io::Error::other)?);
    let (mut socket, _) = tungstenite::client(request, encrypted(stream, trust))
        .map_err(|error| io::Error::other(error.to_string()))?;
    waiting.set_read_timeout(Some(Duration::from_millis(100)))?;
    let send = |socket: &mut tungstenite::WebSocket<TlsStream>, request: &StreamRequest| {
        socket.send(Message::Binary(api::encode(request).into())).map_err(io::Error::other)
    };
    send(&mut socket, &StreamRequest::Open { version: api::VERSION, max_hz: 10.0 })?;
    let mut scans = 0;
    while !is_over.load(Ordering::Relaxed) {
        if let Ok(Message::Binary(bytes)) = socket.read() {
            let frame: ScanFrame = api::decode(&bytes).map_err(io::Error::other)?;
            send(&mut socket, &StreamRequest::Acknowledge { sequence: frame.sequence })?;
            scans += 1;
        }
    }
    Ok(scans)
}

/// What came of some clients.
struct Served {
    /// Median time of each client.
    medians: Vec<Duration>,
    scans: u64,
    /// Cores that gateway and core took.
    cores: f64,
}

fn serve(platform: &GuardedPlatform, trust: &Arc<ClientConfig>, clients: u64) -> Served {
    let tokens = &platform.tokens;
    // Ten of each, because one account has 24 sockets at most.
    let names = [&tokens.viewer, &tokens.operator, &tokens.admin, &tokens.attackers[0], &tokens.attackers[1]];
    let processes = ["gateway", "core"].map(|role| platform.process(role));
    let is_over = AtomicBool::default();
    thread::scope(|scope| {
        let is_over = &is_over;
        let token_of = |client: u64| names[client as usize % names.len()].as_str();
        let pinging: Vec<_> = (0..clients)
            .map(|client| {
                scope.spawn(move || ping(platform, trust, token_of(client), 1_000 + client, is_over))
            })
            .collect();
        let watching: Vec<_> = (0..clients)
            .map(|client| scope.spawn(move || watch(platform, trust, token_of(client), is_over)))
            .collect();
        // Their handshakes are part of the load, so that the time begins at once.
        let (start, before) = (Instant::now(), cpu_seconds(processes));
        thread::sleep(DURATION);
        let cores = (cpu_seconds(processes) - before) / start.elapsed().as_secs_f64();
        is_over.store(true, Ordering::Relaxed);
        let medians = pinging
            .into_iter()
            .map(|thread| {
                let mut times = thread.join().expect("no panic");
                times.sort();
                *times.get(times.len() / 2).expect("it was answered")
            })
            .collect();
        let scans = watching.into_iter().map(|thread| thread.join().expect("no panic").expect("scans")).sum();
        Served { medians, scans, cores }
    })
}

/// Processor time and waiting time of a thread so far.
fn schedule_of(thread: &Path) -> Option<[Duration; 2]> {
    let text = std::fs::read_to_string(thread.join("schedstat")).ok()?;
    let mut numbers =
        text.split_whitespace().filter_map(|number| number.parse().ok()).map(Duration::from_nanos);
    Some([numbers.next()?, numbers.next()?])
}

/// The directory of the control loop's thread in /proc.
fn control_thread(core: u32) -> std::path::PathBuf {
    let tasks = std::fs::read_dir(format!("/proc/{core}/task")).expect("readable");
    tasks
        .filter_map(|task| Some(task.ok()?.path()))
        .find(|task| {
            std::fs::read_to_string(task.join("comm")).is_ok_and(|name| name.trim() == CONTROL_THREAD)
        })
        .expect("the core has this thread")
}

/// The median and the 99.9th percentile of the control loop's processor time and waiting time in one window.
fn watch_control_loop(thread: &Path) -> [[Duration; 2]; 2] {
    let mut windows = [Vec::new(), Vec::new()];
    let start = Instant::now();
    let mut last = (Instant::now(), schedule_of(thread).expect("the system counts it"));
    while start.elapsed() < 3 * DURATION {
        thread::sleep(WINDOW.saturating_sub(last.0.elapsed()));
        let now = (Instant::now(), schedule_of(thread).expect("the thread lives"));
        if now.0 - last.0 < WINDOW_LIMIT {
            for (index, windows) in windows.iter_mut().enumerate() {
                windows.push(now.1[index].saturating_sub(last.1[index]));
            }
        }
        last = now;
    }
    windows.map(|mut windows| {
        windows.sort();
        let at = |share: f64| windows[((windows.len() - 1) as f64 * share).round() as usize];
        [at(0.5), at(0.999)]
    })
}

pub mod nightly {
    use super::*;

    #[test]
    fn fifty_clients_over_tls_are_served_without_lag_and_take_less_than_a_core() {
        let platform = GuardedPlatform::start(&["--tls", "auto"]);
        let trust = trust(&platform.data());
        let one = serve(&platform, &trust, 1);
        let all = serve(&platform, &trust, CLIENTS);
        let slowest = all.medians.iter().max().copied().unwrap_or_default();
        println!(
            "{CLIENTS} clients over TLS, {} s: median time there and back of the slowest {:.1} ms (of one alone {:.1} ms); {} scans; gateway and core {:.2} cores (with one client {:.2})",
            DURATION.as_secs(),
            slowest.as_secs_f64() * 1e3,
            one.medians[0].as_secs_f64() * 1e3,
            all.scans,
            all.cores,
            one.cores,
        );
        assert!(slowest < LAG_LIMIT, "{slowest:?}");
        assert!(all.cores - one.cores < CORES_LIMIT, "{:.2} cores more", all.cores - one.cores);
    }

    #[test]
    fn a_flood_of_sign_ins_takes_no_time_from_the_control_loop() {
        let platform = GuardedPlatform::start(&[]);
        let thread = control_thread(platform.process("core"));
        let quiet = watch_control_loop(&thread);
        let flood = Flood::begin(Attack::SignIns, &platform);
        flood.wait_for_attempts(20, || {});
        let flooded = watch_control_loop(&thread);
        let attempts = flood.attempts();
        drop(flood);
        let milliseconds = |[median, rare]: [Duration; 2]| {
            format!("{:.2} ms median, {:.2} ms 99.9 %", median.as_secs_f64() * 1e3, rare.as_secs_f64() * 1e3)
        };
        println!("control loop in windows of {} ms:", WINDOW.as_millis());
        for (name, [processor, waiting]) in [("quiet", quiet), ("flooded", flooded)] {
            println!(
                "{name}: processor {}; waiting for one {}",
                milliseconds(processor),
                milliseconds(waiting)
            );
        }
        println!("{attempts} sign-ins were attempted");
        let [before, after] = [quiet[0][1], flooded[0][1]];
        assert!(
            after < before.mul_f64(1.5),
            "processor time of the rarest windows: {before:?} without, {after:?} with the flood"
        );
    }
}
