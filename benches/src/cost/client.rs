//! A client that gets what the page gets: the control socket with all state, and the stream socket with the scans, which it acknowledges.

use anyhow::{Context, Result};
use api::{ClientMessage, Event, ScanFrame, ServerMessage, StreamRequest};
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tungstenite::{Message, WebSocket};
use uuid::Uuid;
use vocab::Stamp;

/// Scans per second that the page asks for.
const SCAN_HZ: f32 = 10.0;
/// Time after which a thread looks whether it is to end.
const READ_TIMEOUT: Duration = Duration::from_millis(200);
/// Time between two pings. The server wants one every 2 s.
const PING_PERIOD: Duration = Duration::from_millis(1_000);

/// What has come.
#[derive(Clone, Debug, Default)]
pub struct Received {
    /// Bytes of all messages.
    pub bytes: usize,
    /// Number of scans.
    pub scans: usize,
    /// Robot time over real time in each second, ascending once the client has ended.
    pub real_time_factors: Vec<f64>,
    /// Robot's clock at the newest estimate.
    robot_clock: Option<Stamp>,
}

/// A connected client.
pub struct PageClient {
    received: Arc<Mutex<Received>>,
    is_ending: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl PageClient {
    /// Opens both sockets.
    pub fn connect(address: SocketAddr) -> Result<Self> {
        let client = Self { received: Arc::default(), is_ending: Arc::default(), threads: Vec::new() };
        let mut control = open(address, api::CONTROL_PATH)?;
        let hello =
            ClientMessage::Hello { version: api::VERSION, lease: api::LeaseToken(Uuid::from_u128(1)) };
        control.send(Message::Binary(api::encode(&hello).into()))?;
        let mut stream = open(address, api::STREAM_PATH)?;
        let open = StreamRequest::Open { version: api::VERSION, max_hz: SCAN_HZ };
        stream.send(Message::Binary(api::encode(&open).into()))?;
        let (received, is_ending) = (Arc::clone(&client.received), Arc::clone(&client.is_ending));
        let ping = Some(api::encode(&ClientMessage::Ping { token: 1 }));
        let control = std::thread::spawn(move || read(control, &received, &is_ending, ping, on_state));
        let (received, is_ending) = (Arc::clone(&client.received), Arc::clone(&client.is_ending));
        let stream = std::thread::spawn(move || read(stream, &received, &is_ending, None, on_scan));
        Ok(Self { threads: vec![control, stream], ..client })
    }

    /// The robot's clock at the newest estimate.
    pub fn robot_clock(&self) -> Option<Stamp> {
        self.received.lock().unwrap_or_else(PoisonError::into_inner).robot_clock
    }

    /// Closes both sockets. Returns what has come.
    pub fn end(self) -> Received {
        self.is_ending.store(true, Ordering::Relaxed);
        for thread in self.threads {
            // A thread that panicked has received less, which the caller checks.
            let _ = thread.join();
        }
        let mut received = self.received.lock().unwrap_or_else(PoisonError::into_inner).clone();
        received.real_time_factors.sort_by(f64::total_cmp);
        received
    }
}

fn open(address: SocketAddr, path: &str) -> Result<WebSocket<TcpStream>> {
    let stream = TcpStream::connect(address)?;
    stream.set_nodelay(true)?;
    let (socket, _) = tungstenite::client(format!("ws://{address}{path}"), stream).context("no WebSocket")?;
    socket.get_ref().set_read_timeout(Some(READ_TIMEOUT))?;
    Ok(socket)
}

/// Reads until the client ends or the socket closes. `take` may answer. `ping` is sent every second.
fn read(
    mut socket: WebSocket<TcpStream>,
    received: &Mutex<Received>,
    is_ending: &AtomicBool,
    ping: Option<Vec<u8>>,
    take: fn(&[u8], &mut Received) -> Option<Vec<u8>>,
) {
    let mut pinged = Instant::now();
    while !is_ending.load(Ordering::Relaxed) {
        if let Some(ping) = ping.as_ref().filter(|_| pinged.elapsed() >= PING_PERIOD) {
            pinged = Instant::now();
            if socket.send(Message::Binary(ping.clone().into())).is_err() {
                return;
            }
        }
        let answer = match socket.read() {
            Ok(Message::Binary(content)) => {
                let mut received = received.lock().unwrap_or_else(PoisonError::into_inner);
                received.bytes += content.len();
                take(&content, &mut received)
            }
            Ok(_) => None,
            Err(tungstenite::Error::Io(error))
                if matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut) =>
            {
                None
            }
            Err(_) => return,
        };
        if let Some(answer) = answer
            && socket.send(Message::Binary(answer.into())).is_err()
        {
            return;
        }
    }
}

fn on_state(content: &[u8], received: &mut Received) -> Option<Vec<u8>> {
    match api::decode(content) {
        Ok(ServerMessage::Event { event: Event::Estimate(estimate), .. }) => {
            received.robot_clock = Some(estimate.stamp);
        }
        Ok(ServerMessage::Event { event: Event::Platform(platform), .. }) => {
            received.real_time_factors.push(platform.real_time_factor.into());
        }
        _ => {}
    }
    None
}

fn on_scan(content: &[u8], received: &mut Received) -> Option<Vec<u8>> {
    let frame: ScanFrame = api::decode(content).ok()?;
    received.scans += 1;
    Some(api::encode(&StreamRequest::Acknowledge { sequence: frame.sequence }))
}
