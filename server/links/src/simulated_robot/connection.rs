//! The robot's socket and the connected core. One core at a time; a new one replaces the old one once it has greeted.
//!
//! A thread accepts cores and exchanges greetings. For each core one thread reads its requests and another one writes the robot's messages. Both end when the connection is
//! closed.

use super::config::SimulatedRobotConfig;
use crate::protocol::{MAX_REQUEST_BYTES, PROTOCOL_VERSION, RobotIdentity, RobotMessage, RobotRequest};
use crate::texts;
use crossbeam_channel::{Receiver, Sender, TryRecvError};
use messages::Drive;
use ports::{ActionCall, SimulatedFault, encode_frame, read_frame};
use std::fs;
use std::io::{self, BufReader, BufWriter, Write};
use std::net::Shutdown;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;
use vocab::{ActionCallId, CommandId, Stamp};

/// Requests of a core that the simulation has not taken yet.
#[derive(Default)]
pub(super) struct PendingRequests {
    /// The latest one.
    pub(super) drive: Option<Drive>,
    /// With the number of each request.
    pub(super) faults: Vec<(CommandId, SimulatedFault)>,
    /// In the order in which they came.
    pub(super) actions: Vec<ActionCommand>,
}

/// What is asked about actions.
pub(super) enum ActionCommand {
    Start(ActionCall),
    Cancel(ActionCallId),
}

/// A connected core.
pub(super) struct CoreConnection {
    /// The queue to the thread that writes.
    pub(super) messages: Sender<RobotMessage>,
    shared: Arc<SharedConnection>,
}

/// What the threads of a connection share. They do not hold the sending end of the queue: the thread that writes ends with it.
struct SharedConnection {
    stream: UnixStream,
    requests: Mutex<PendingRequests>,
    is_closed: AtomicBool,
}

impl CoreConnection {
    pub(super) fn take_requests(&self) -> PendingRequests {
        std::mem::take(&mut *self.shared.requests())
    }

    pub(super) fn close(&self) {
        self.shared.close();
    }
}

impl SharedConnection {
    fn requests(&self) -> std::sync::MutexGuard<'_, PendingRequests> {
        self.requests.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends both threads, also if they wait for the socket.
    fn close(&self) {
        self.is_closed.store(true, Ordering::Release);
        // The other end may have closed it.
        let _ = self.stream.shutdown(Shutdown::Both);
    }
}

/// Holds the connected core, for the simulation.
#[derive(Clone, Default)]
pub(super) struct CoreSlot(Arc<SlotState>);

#[derive(Default)]
struct SlotState {
    core: Mutex<Option<Arc<CoreConnection>>>,
    /// The robot's clock, nanoseconds.
    clock: AtomicI64,
}

impl CoreSlot {
    /// The connected core. Publishes the robot's clock for the identity.
    pub(super) fn connected(&self, now: Stamp) -> Option<Arc<CoreConnection>> {
        self.0.clock.store(now.nanos(), Ordering::Relaxed);
        let mut core = self.core();
        if core.as_ref().is_some_and(|core| core.shared.is_closed.load(Ordering::Acquire)) {
            *core = None;
        }
        core.clone()
    }

    fn core(&self) -> std::sync::MutexGuard<'_, Option<Arc<CoreConnection>>> {
        self.0.core.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now(&self) -> Stamp {
        Stamp::from_nanos(self.0.clock.load(Ordering::Relaxed))
    }

    /// Closes the connection of the old core.
    fn replace(&self, core: Option<CoreConnection>) {
        let old = std::mem::replace(&mut *self.core(), core.map(Arc::new));
        if let Some(old) = old {
            old.close();
        }
    }
}

/// The listening socket. Dropping it closes the connection and removes the socket.
pub(super) struct Listener {
    path: PathBuf,
    listener: UnixListener,
    is_ending: Arc<AtomicBool>,
    slot: CoreSlot,
    thread: Option<JoinHandle<()>>,
}

/// What the accepting thread needs.
struct Acceptor {
    identity: RobotIdentity,
    hello_timeout: Duration,
    max_queued_messages: usize,
    max_pending_requests: usize,
    slot: CoreSlot,
    is_ending: Arc<AtomicBool>,
}

impl Listener {
    /// Starts to listen. A socket left over at the path is replaced: the lock beside it ensures that no other robot uses it.
    pub(super) fn start(config: &SimulatedRobotConfig, identity: RobotIdentity) -> io::Result<Self> {
        let path = config.socket.clone();
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let listener = UnixListener::bind(&path)?;
        let for_shutdown = listener.try_clone()?;
        let (slot, is_ending) = (CoreSlot::default(), Arc::<AtomicBool>::default());
        slot.connected(identity.now);
        let acceptor = Acceptor {
            identity,
            hello_timeout: config.hello_timeout,
            max_queued_messages: config.max_queued_messages,
            max_pending_requests: config.max_pending_requests,
            slot: slot.clone(),
            is_ending: Arc::clone(&is_ending),
        };
        let thread =
            thread::Builder::new().name("robot-accept".to_owned()).spawn(move || acceptor.run(&listener))?;
        Ok(Self { path, listener: for_shutdown, is_ending, slot, thread: Some(thread) })
    }

    /// Where the connected core is found.
    pub(super) fn core(&self) -> CoreSlot {
        self.slot.clone()
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        self.is_ending.store(true, Ordering::Release);
        // Wakes the thread that waits for connections, also if somebody has removed the socket's file.
        let is_awake = rustix::net::shutdown(&self.listener, rustix::net::Shutdown::Both).is_ok();
        if let Some(thread) = self.thread.take().filter(|_| is_awake) {
            let _ = thread.join();
        }
        self.slot.replace(None);
        let _ = fs::remove_file(&self.path);
    }
}

impl Acceptor {
    fn run(&self, listener: &UnixListener) {
        for stream in listener.incoming() {
            if self.is_ending.load(Ordering::Acquire) {
                return;
            }
            match stream.and_then(|stream| self.greet(stream)) {
                Ok(core) => self.slot.replace(Some(core)),
                Err(error) => tracing::warn!("a core could not connect: {error}"),
            }
        }
    }

    /// Exchanges greetings and starts the threads of the connection.
    fn greet(&self, mut stream: UnixStream) -> io::Result<CoreConnection> {
        stream.set_read_timeout(Some(self.hello_timeout))?;
        stream.set_write_timeout(Some(self.hello_timeout))?;
        let mut reader = BufReader::new(stream.try_clone()?);
        let hello = read_frame(&mut reader, MAX_REQUEST_BYTES)?;
        let Some(RobotRequest::Hello { version }) = hello else {
            return Err(invalid(texts::NO_GREETING.to_owned()));
        };
        stream.write_all(&encode_frame(&RobotMessage::Hello { version: PROTOCOL_VERSION }))?;
        if version != PROTOCOL_VERSION {
            return Err(invalid(texts::other_version(version, PROTOCOL_VERSION)));
        }
        let identity = RobotIdentity { now: self.slot.now(), ..self.identity.clone() };
        stream.write_all(&encode_frame(&RobotMessage::Identity(Box::new(identity))))?;
        stream.set_read_timeout(None)?;
        // The simulation closes the connection of a core that does not read.
        stream.set_write_timeout(None)?;

        let (sender, messages) = crossbeam_channel::bounded(self.max_queued_messages);
        let writing = stream.try_clone()?;
        let shared = Arc::new(SharedConnection {
            stream,
            requests: Mutex::default(),
            is_closed: AtomicBool::new(false),
        });
        let connection = CoreConnection { messages: sender, shared: Arc::clone(&shared) };
        let (for_reader, max_pending_requests) = (Arc::clone(&shared), self.max_pending_requests);
        thread::Builder::new().name("robot-read".to_owned()).spawn(move || {
            if let Err(error) = read_requests(&mut reader, &for_reader, max_pending_requests) {
                tracing::warn!("the core's connection ends: {error}");
            }
            for_reader.close();
        })?;
        thread::Builder::new().name("robot-write".to_owned()).spawn(move || {
            if let Err(error) = write_messages(writing, &messages) {
                tracing::warn!("the core's connection ends: {error}");
            }
            shared.close();
        })?;
        Ok(connection)
    }
}

/// Reads requests until the connection ends.
fn read_requests(
    reader: &mut BufReader<UnixStream>,
    shared: &SharedConnection,
    max_pending_requests: usize,
) -> io::Result<()> {
    while let Some(request) = read_frame(reader, MAX_REQUEST_BYTES)? {
        let mut pending = shared.requests();
        match request {
            RobotRequest::Drive(drive) => pending.drive = Some(drive),
            RobotRequest::InjectFault { id, fault } if pending.faults.len() < max_pending_requests => {
                pending.faults.push((id, fault));
            }
            RobotRequest::StartAction(call) if pending.actions.len() < max_pending_requests => {
                pending.actions.push(ActionCommand::Start(call));
            }
            RobotRequest::CancelAction(call) if pending.actions.len() < max_pending_requests => {
                pending.actions.push(ActionCommand::Cancel(call));
            }
            RobotRequest::StartAction(_) | RobotRequest::CancelAction(_) => {
                return Err(invalid(texts::TOO_MANY_ACTION_REQUESTS.to_owned()));
            }
            RobotRequest::InjectFault { .. } => return Err(invalid(texts::TOO_MANY_FAULTS.to_owned())),
            RobotRequest::Hello { .. } => return Err(invalid(texts::UNEXPECTED_GREETING.to_owned())),
        }
    }
    Ok(())
}

/// Writes messages until the connection ends or the queue has no sender any more.
fn write_messages(stream: UnixStream, messages: &Receiver<RobotMessage>) -> io::Result<()> {
    let mut writer = BufWriter::new(stream);
    loop {
        let message = match messages.try_recv() {
            Ok(message) => message,
            Err(TryRecvError::Disconnected) => return Ok(()),
            Err(TryRecvError::Empty) => {
                writer.flush()?;
                let Ok(message) = messages.recv() else {
                    return Ok(());
                };
                message
            }
        };
        writer.write_all(&encode_frame(&message))?;
    }
}

fn invalid(reason: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, reason)
}
