//! Floods of a platform, each on threads of lowest priority: the computers of attackers are others, and take no processor time from the robot's.

use super::client::Client;
use super::guarded::{GuardedPlatform, ask, bearer, connect_from, request_bytes};
use api::{Command, StreamRequest};
use std::collections::VecDeque;
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use tungstenite::Message;
use tungstenite::client::IntoClientRequest;

/// Connections that an attacker keeps open at most, of a limit of files that is 20,000 here.
const CONNECTIONS_KEPT: usize = 2_000;

/// Addresses of attackers: 127.0.0.10 and those after it. The people of the tests are at 127.0.0.2.
const ADDRESSES: u8 = 40;
const FIRST_ADDRESS: u8 = 10;

/// What an attacker does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attack {
    Nothing,
    HalfOpenConnections,
    SlowReaders,
    CommandsOfOneAccount,
    SignIns,
    Uploads,
    MalformedFrames,
    OversizeDocuments,
    CostlyQuestions,
}

impl Attack {
    pub const ALL: [Self; 9] = [
        Self::Nothing,
        Self::HalfOpenConnections,
        Self::SlowReaders,
        Self::CommandsOfOneAccount,
        Self::SignIns,
        Self::Uploads,
        Self::MalformedFrames,
        Self::OversizeDocuments,
        Self::CostlyQuestions,
    ];
}

/// An attack that goes on until it is dropped.
pub struct Flood {
    shared: Shared,
    threads: Vec<JoinHandle<()>>,
}

/// What the threads of an attack share.
#[derive(Clone)]
struct Shared {
    is_over: Arc<AtomicBool>,
    /// What was attempted: connections, requests or messages.
    attempts: Arc<AtomicU64>,
    address: SocketAddr,
}

impl Shared {
    fn goes_on(&self) -> bool {
        !self.is_over.load(Ordering::Relaxed)
    }

    fn count(&self) -> u64 {
        self.attempts.fetch_add(1, Ordering::Relaxed)
    }

    /// One address after the other.
    fn next_address(&self) -> u8 {
        FIRST_ADDRESS + (self.count() % u64::from(ADDRESSES)) as u8
    }
}

impl Flood {
    /// Begins an attack.
    pub fn begin(attack: Attack, platform: &GuardedPlatform) -> Self {
        let shared =
            Shared { is_over: Arc::default(), attempts: Arc::default(), address: platform.address() };
        let mut flood = Self { shared, threads: Vec::new() };
        let [one, two] = platform.tokens.attackers.clone();
        match attack {
            Attack::Nothing => {}
            Attack::HalfOpenConnections => flood.spawn(1, |shared, _| half_open(shared)),
            Attack::SlowReaders => flood.spawn(1, move |shared, _| slow_readers(shared, &[&one, &two])),
            Attack::CommandsOfOneAccount => {
                flood.spawn(8, move |shared, thread| flood_of_commands(shared, &one, thread));
            }
            Attack::SignIns => flood.spawn(4, |shared, _| guess(shared)),
            Attack::Uploads => flood.spawn(4, move |shared, _| upload(shared, &one)),
            Attack::MalformedFrames => flood.spawn(4, move |shared, _| malformed(shared, &one)),
            Attack::OversizeDocuments => flood.spawn(4, move |shared, _| oversize(shared, &one)),
            Attack::CostlyQuestions => {
                let admin = platform.tokens.admin.clone();
                flood.spawn(8, move |shared, _| questions(shared, &admin));
            }
        }
        flood
    }

    fn spawn(&mut self, threads: u64, work: impl Fn(&Shared, u64) + Clone + Send + 'static) {
        for thread in 0..threads {
            let (shared, work) = (self.shared.clone(), work.clone());
            self.threads.push(thread::spawn(move || {
                // Of this thread only.
                let _ = rustix::process::nice(19);
                while shared.goes_on() {
                    work(&shared, thread);
                }
            }));
        }
    }

    /// Waits until there were this many attempts, and does something meanwhile.
    pub fn wait_for_attempts(&self, attempts: u64, mut meanwhile: impl FnMut()) {
        let start = Instant::now();
        while self.attempts() < attempts && !self.threads.is_empty() {
            assert!(start.elapsed() < Duration::from_secs(120), "the attack is too slow to be one");
            meanwhile();
            thread::sleep(Duration::from_millis(5));
        }
    }

    /// Attempts so far.
    pub fn attempts(&self) -> u64 {
        self.shared.attempts.load(Ordering::Relaxed)
    }
}

impl Drop for Flood {
    fn drop(&mut self) {
        self.shared.is_over.store(true, Ordering::Relaxed);
        self.threads.drain(..).for_each(|thread| {
            let _ = thread.join();
        });
    }
}

/// Opens connections and sends nothing, or the beginning of a head.
fn half_open(shared: &Shared) {
    let mut held = VecDeque::new();
    while shared.goes_on() {
        let last = shared.next_address();
        if let Ok(mut stream) = connect_from(last, shared.address) {
            if held.len() % 2 == 0 {
                let _ = stream.write_all(b"GET / HTTP/1.1\r\nhost: local");
            }
            held.push_back(stream);
        }
        if held.len() > CONNECTIONS_KEPT {
            held.pop_front();
        }
    }
}

/// Opens sockets of every kind and requests of long answers, and reads nothing.
fn slow_readers(shared: &Shared, tokens: &[&str]) {
    let mut held: VecDeque<TcpStream> = VecDeque::new();
    while shared.goes_on() {
        let last = shared.next_address();
        let number = shared.attempts.load(Ordering::Relaxed);
        let token = tokens[(number / 3) as usize % tokens.len()];
        let reader = match number % 3 {
            0 => Client::connect(last, shared.address, token, number)
                .and_then(|mut client| client.socket().get_ref().try_clone()),
            1 => stream_socket(last, shared.address, token),
            _ => connect_from(last, shared.address).and_then(|mut stream| {
                let path = ["/", "/api/v1/openapi.json", "/api/v1/site"][(number / 3) as usize % 3];
                let request = request_bytes("GET", path, &bearer(token), b"").repeat(8);
                stream.write_all(&request).map(|()| stream)
            }),
        };
        held.extend(reader);
        if held.len() > CONNECTIONS_KEPT {
            held.pop_front();
        }
    }
}

fn stream_socket(last: u8, address: SocketAddr, token: &str) -> std::io::Result<TcpStream> {
    let stream = connect_from(last, address)?;
    let mut request =
        format!("ws://{address}{}", api::STREAM_PATH).into_client_request().map_err(std::io::Error::other)?;
    request
        .headers_mut()
        .insert("authorization", format!("Bearer {token}").parse().map_err(std::io::Error::other)?);
    let copy = stream.try_clone()?;
    let (mut socket, _) =
        tungstenite::client(request, stream).map_err(|error| std::io::Error::other(error.to_string()))?;
    let open = StreamRequest::Open { version: api::VERSION, max_hz: 60.0 };
    socket.send(Message::Binary(api::encode(&open).into())).map_err(std::io::Error::other)?;
    // The socket is dropped without a farewell; the connection stays.
    Ok(copy)
}

/// Sends commands over three sockets as fast as they are taken.
fn flood_of_commands(shared: &Shared, token: &str, thread: u64) {
    let mut clients = Vec::new();
    for socket in 0..3 {
        let name = 100 + 3 * thread + socket;
        clients.extend(Client::connect(FIRST_ADDRESS, shared.address, token, name));
    }
    while shared.goes_on() {
        for client in &mut clients {
            for _ in 0..20 {
                shared.count();
                if client.command(Command::LeaveMap).is_err() {
                    return;
                }
            }
            // What comes is read, so that the sockets stay open.
            client.socket().get_ref().set_read_timeout(Some(Duration::from_millis(1))).expect("settable");
            for _ in 0..200 {
                match client.read() {
                    Ok(Some(_)) => {}
                    Ok(None) => break,
                    Err(_) => return,
                }
            }
        }
    }
}

/// Guesses passwords of an account that exists, and of others.
fn guess(shared: &Shared) {
    let last = shared.next_address();
    let account = ["ada", "root", "eve"][last as usize % 3];
    let body = format!("{{\"account\": \"{account}\", \"password\": \"wrong horse battery {last}\"}}");
    let request = request_bytes("POST", api::paths::SESSION_PATH, "", body.as_bytes());
    let _ = connect_from(last, shared.address).and_then(|stream| ask(stream, &request));
}

/// Uploads bytes that are no map, and breaks off half of the uploads.
fn upload(shared: &Shared, token: &str) {
    let number = shared.count();
    let id = uuid::Uuid::from_u64_pair(0xf100d, number);
    let path = api::paths::UPLOAD_PATH.replace("{id}", &id.to_string());
    let body = vec![number as u8; 4 << 20];
    let request = request_bytes("PUT", &path, &bearer(token), &body);
    let sent = if number.is_multiple_of(2) { request.len() } else { request.len() / 2 };
    if let Ok(mut stream) = connect_from(FIRST_ADDRESS, shared.address)
        && stream.write_all(&request[..sent]).is_ok()
        && sent == request.len()
    {
        let _ = stream.read(&mut [0; 256]);
        let delete = request_bytes("DELETE", &path, &bearer(token), b"");
        let _ = connect_from(FIRST_ADDRESS, shared.address).and_then(|stream| ask(stream, &delete));
    }
}

/// Sends frames and requests that are none.
fn malformed(shared: &Shared, token: &str) {
    let number = shared.count();
    let noise = blake3::hash(&number.to_le_bytes());
    let last = FIRST_ADDRESS + (number % u64::from(ADDRESSES)) as u8;
    if number.is_multiple_of(2) {
        if let Ok(mut client) = Client::connect(last, shared.address, token, 200 + number) {
            let bytes = [&[0xff], noise.as_bytes().as_slice()].concat();
            let _ = client.socket().send(Message::Binary(bytes.into()));
            let _ = client.socket().get_ref().write_all(noise.as_bytes());
            let _ = client.read();
        }
    } else if let Ok(mut stream) = connect_from(last, shared.address) {
        let _ = stream.write_all(noise.as_bytes());
        let _ = stream.write_all(b"\r\n\r\n");
        let _ = stream.read(&mut [0; 256]);
    }
}

/// Sends documents at and beyond the limits of their length.
fn oversize(shared: &Shared, token: &str) {
    let number = shared.count();
    let (path, bytes) = match number % 3 {
        0 => (api::paths::SITE_EDITS_PATH.to_owned(), 15 << 20),
        1 => (api::paths::SITE_EDITS_PATH.to_owned(), 17 << 20),
        _ => (api::paths::SITE_KIND_PATH.replace("{kind}", "asset"), 2 << 20),
    };
    let body = [b"{\"changes\": [\"".as_slice(), &vec![b'['; bytes], b"\"]}"].concat();
    let request = request_bytes("POST", &path, &bearer(token), &body);
    let last = FIRST_ADDRESS + (number % u64::from(ADDRESSES)) as u8;
    let _ = connect_from(last, shared.address).and_then(|stream| ask(stream, &request));
}

/// Asks for what takes the server most work.
fn questions(shared: &Shared, token: &str) {
    let last = shared.next_address();
    let audit = format!("{}?format=csv&containing=nobody{last}", api::paths::AUDIT_PATH);
    let path = [audit.as_str(), "/api/v1/openapi.json", "/api/v1/site", "/api/v1/runs"][last as usize % 4];
    let request = request_bytes("GET", path, &bearer(token), b"");
    let _ = connect_from(last, shared.address).and_then(|stream| ask(stream, &request));
}
