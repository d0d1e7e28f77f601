//! The Unix socket on which the gateway finds the core. Each message lies behind its length, a little-endian `u32`.
//!
//! One gateway at a time: a new one takes the place of the old. A gateway that writes nonsense or speaks another
//! version is dropped; one that does not read is dropped by [`StatePublisher`] or when a write takes longer than [`WRITE_MAX`].

use crate::control_loop::ClientRequest;
use crate::convert::{self, RoutedCommand};
use crate::imports::Imports;
use crate::state_publisher::StatePublisher;
use api::{CoreMessage, GatewayMessage, MAX_MESSAGE_BYTES};
use crossbeam_channel::Sender;
use messages::{Command, Principal};
use std::fs;
use std::io::{self, BufReader, Read, Write};
use std::net::Shutdown;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Longest time for one write to the gateway.
const WRITE_MAX: Duration = Duration::from_secs(5);

/// The listening socket and its threads. Dropping it closes all and removes the socket.
pub struct GatewayLink {
    path: PathBuf,
    ending: Arc<AtomicBool>,
    accepting: Option<JoinHandle<()>>,
}

/// What the threads share.
#[derive(Clone)]
struct Shared {
    state_publisher: Arc<StatePublisher>,
    commands: Sender<ClientRequest>,
    imports: Imports,
    ending: Arc<AtomicBool>,
}

impl GatewayLink {
    /// Begins to listen. A socket left over at this path is replaced: the data directory's lock has made sure that no
    /// other core uses it.
    pub fn listen(
        path: &Path,
        state_publisher: Arc<StatePublisher>,
        commands: Sender<ClientRequest>,
        imports: Imports,
    ) -> io::Result<Self> {
        if let Some(directory) = path.parent() {
            fs::create_dir_all(directory)?;
        }
        match fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let listener = UnixListener::bind(path)?;
        let ending = Arc::new(AtomicBool::new(false));
        let shared = Shared { state_publisher, commands, imports, ending: Arc::clone(&ending) };
        let accepting = thread::Builder::new()
            .name("gateway-accept".to_owned())
            .spawn(move || accept(&listener, &shared))?;
        Ok(Self { path: path.to_owned(), ending, accepting: Some(accepting) })
    }
}

impl Drop for GatewayLink {
    fn drop(&mut self) {
        self.ending.store(true, Ordering::Release);
        // Wakes the thread that waits for connections.
        let woken = UnixStream::connect(&self.path).is_ok();
        if let Some(accepting) = self.accepting.take().filter(|_| woken) {
            let _ = accepting.join();
        }
        let _ = fs::remove_file(&self.path);
    }
}

/// The connection being served.
struct Serving {
    stream: UnixStream,
    threads: [JoinHandle<()>; 2],
}

impl Serving {
    fn start(stream: UnixStream, shared: &Shared) -> io::Result<Self> {
        stream.set_write_timeout(Some(WRITE_MAX))?;
        let (reading, writing) = (stream.try_clone()?, stream.try_clone()?);
        let connection = shared.state_publisher.connect();
        let (for_reader, state_publisher) = (shared.clone(), Arc::clone(&shared.state_publisher));
        let reader = thread::Builder::new().name("gateway-read".to_owned()).spawn(move || {
            if let Err(error) = read_all(&reading, &for_reader) {
                tracing::warn!("the gateway's connection ends: {error}");
            }
            for_reader.state_publisher.disconnect(connection);
        })?;
        let writer = thread::Builder::new().name("gateway-write".to_owned()).spawn(move || {
            if let Err(error) = write_all(&writing, &state_publisher, connection) {
                tracing::warn!("the gateway's connection ends: {error}");
            }
            state_publisher.disconnect(connection);
            // Ends the reader too, which waits for bytes.
            let _ = writing.shutdown(Shutdown::Both);
        })?;
        Ok(Self { stream, threads: [reader, writer] })
    }

    fn end(self) {
        let _ = self.stream.shutdown(Shutdown::Both);
        for thread in self.threads {
            let _ = thread.join();
        }
    }
}

fn accept(listener: &UnixListener, shared: &Shared) {
    let mut serving: Option<Serving> = None;
    for stream in listener.incoming() {
        if let Some(old) = serving.take() {
            old.end();
        }
        if shared.ending.load(Ordering::Acquire) {
            return;
        }
        match stream.and_then(|stream| Serving::start(stream, shared)) {
            Ok(new) => serving = Some(new),
            Err(error) => tracing::error!("a gateway could not connect: {error}"),
        }
    }
}

fn write_all(mut stream: &UnixStream, state_publisher: &StatePublisher, connection: u64) -> io::Result<()> {
    while let Some(message) = state_publisher.next(connection) {
        stream.write_all(&frame(&message))?;
    }
    Ok(())
}

/// A message behind its length.
fn frame(message: &CoreMessage) -> Vec<u8> {
    let body = api::encode(message);
    let mut bytes = Vec::with_capacity(body.len() + 4);
    bytes.extend((body.len() as u32).to_le_bytes());
    bytes.extend(body);
    bytes
}

fn read_all(stream: &UnixStream, shared: &Shared) -> io::Result<()> {
    let mut reader = BufReader::new(stream);
    let mut greeted = false;
    while let Some(message) = read_message(&mut reader)? {
        match message {
            GatewayMessage::Hello { version } if version == api::VERSION => greeted = true,
            GatewayMessage::Hello { version } => {
                let text = format!("it speaks version {version} and the core {}", api::VERSION);
                return Err(io::Error::new(io::ErrorKind::InvalidData, text));
            }
            _ if !greeted => {
                return Err(io::Error::new(io::ErrorKind::InvalidData, "it did not introduce itself"));
            }
            GatewayMessage::Command { id, by, command } => {
                let request = match convert::route(command) {
                    RoutedCommand::Stack(kind) => {
                        ClientRequest::Command(Command { id, by: Principal::operator(by), kind })
                    }
                    RoutedCommand::SimulatedFault(fault) => ClientRequest::InjectFault { id, by, fault },
                    RoutedCommand::Import(import) => {
                        shared.state_publisher.answer(id, by, shared.imports.begin(import).err());
                        continue;
                    }
                    RoutedCommand::CancelImport(upload) => {
                        shared.imports.cancel(upload);
                        shared.state_publisher.answer(id, by, None);
                        continue;
                    }
                };
                if shared.commands.send(request).is_err() {
                    return Ok(());
                }
            }
            GatewayMessage::Listeners { clients: _, streams } => shared.state_publisher.set_streams(streams),
        }
    }
    Ok(())
}

/// The next message; none at the end of the stream.
fn read_message(reader: &mut impl Read) -> io::Result<Option<GatewayMessage>> {
    let mut length = [0; 4];
    match reader.read_exact(&mut length) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
        other => other?,
    }
    let length = u32::from_le_bytes(length) as usize;
    if length > MAX_MESSAGE_BYTES {
        let text = format!("a message of {length} bytes is announced; {MAX_MESSAGE_BYTES} is the most");
        return Err(io::Error::new(io::ErrorKind::InvalidData, text));
    }
    // Grows with what arrives, not with what is announced.
    let mut body = Vec::new();
    reader.take(length as u64).read_to_end(&mut body)?;
    if body.len() < length {
        return Ok(None);
    }
    api::decode(&body).map(Some).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
}
