//! The Unix socket on which the gateway finds the core. Each message lies behind its length, a little-endian `u32`.
//!
//! One gateway at a time: a new one takes the place of the old. A gateway that writes nonsense or speaks another
//! version is dropped; one that does not read is dropped by [`Board`] or when a write takes longer than [`WRITE_MAX`].

use crate::board::Board;
use crate::control_loop::Asked;
use crate::convert::{self, Aside};
use crate::imports::Imports;
use api::{CoreMessage, GatewayMessage, MAX_MESSAGE_BYTES};
use crossbeam_channel::Sender;
use messages::Command;
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
    board: Arc<Board>,
    commands: Sender<Asked>,
    imports: Imports,
    ending: Arc<AtomicBool>,
}

impl GatewayLink {
    /// Begins to listen. A socket left over at this path is replaced: the data directory's lock has made sure that no
    /// other core uses it.
    pub fn listen(
        path: &Path,
        board: Arc<Board>,
        commands: Sender<Asked>,
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
        let shared = Shared { board, commands, imports, ending: Arc::clone(&ending) };
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
        let connection = shared.board.connect();
        let (for_reader, board) = (shared.clone(), Arc::clone(&shared.board));
        let reader = thread::Builder::new().name("gateway-read".to_owned()).spawn(move || {
            if let Err(error) = read_all(&reading, &for_reader) {
                tracing::warn!("the gateway's connection ends: {error}");
            }
            for_reader.board.disconnect(connection);
        })?;
        let writer = thread::Builder::new().name("gateway-write".to_owned()).spawn(move || {
            if let Err(error) = write_all(&writing, &board, connection) {
                tracing::warn!("the gateway's connection ends: {error}");
            }
            board.disconnect(connection);
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

fn write_all(mut stream: &UnixStream, board: &Board, connection: u64) -> io::Result<()> {
    while let Some(message) = board.next(connection) {
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
            GatewayMessage::Command { id, by, order } => {
                let asked = match convert::order(order) {
                    Ok(order) => Asked::Command(Command { id, by, order }),
                    Err(Aside::Mishap(mishap)) => Asked::Mishap { id, by, mishap },
                    Err(Aside::Import(wanted)) => {
                        shared.board.answer(id, by, shared.imports.begin(wanted).err());
                        continue;
                    }
                    Err(Aside::CancelImport(upload)) => {
                        shared.imports.cancel(upload);
                        shared.board.answer(id, by, None);
                        continue;
                    }
                };
                if shared.commands.send(asked).is_err() {
                    return Ok(());
                }
            }
            GatewayMessage::Listeners { clients: _, streams } => shared.board.set_streams(streams),
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
