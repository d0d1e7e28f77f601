//! The Unix socket between core and gateway. The frames are those of [`ports::encode_frame`].
//!
//! One gateway is connected at a time; a new one replaces it. A gateway that sends invalid messages or speaks another version is disconnected.
//! So is one that does not read: by [`StatePublisher`] when its queue is full, or when a write takes longer than
//! [`GatewayLinkConfig::write_timeout`].

use crate::access::{AccessDirectory, AccountInbox, audit_texts};
use crate::clock::{CalendarTime, RobotClock};
use crate::control_loop::LoopRequest;
use crate::convert::{self, RoutedCommand};
use crate::imports::{ImportQueue, ImportRequest};
use crate::interrupted_sessions::SessionRequest;
use crate::jobs::{DiskJob, Jobs};
use crate::lease_arbiter::{LeaseArbiter, LeaseDecision};
use crate::ledger::{EditRequest, LedgerInbox, refusal_reason};
use crate::state_publisher::StatePublisher;
use crate::stored_data::StoredDataRequest;
use crate::texts;
use crate::topomap_generation::{TopomapGenerator, TopomapRequest};
use api::access::{command_privilege, edit_privilege, query_privilege};
use api::{
    AuditNote, Caller, CoreMessage, EditDone, EditOutcome, EditRefusal, Event, GatewayMessage,
    MAX_AUDIT_NOTES, MAX_MESSAGE_BYTES,
};
use crossbeam_channel::{Sender, TrySendError};
use messages::{Command, CommandKind, Principal};
use std::fs;
use std::io::{self, BufReader, Write};
use std::net::Shutdown;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use watchdog::{Heartbeat, Watchdog};

/// Parameters of the [`GatewayLink`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GatewayLinkConfig {
    /// Longest time for one write to the gateway. Chosen: a gateway that lives reads at once; then it is disconnected and gets a snapshot when it connects again.
    pub write_timeout: Duration,
    /// A thread that handles one message for longer hangs. Chosen: as the control loop's (`THREAD_LIMITS`).
    pub thread_limit: Duration,
}

impl Default for GatewayLinkConfig {
    fn default() -> Self {
        Self { write_timeout: Duration::from_secs(5), thread_limit: Duration::from_secs(60) }
    }
}

/// The listening socket and its threads. Dropping it closes the connection and removes the socket.
pub struct GatewayLink {
    path: PathBuf,
    listener: UnixListener,
    is_ending: Arc<AtomicBool>,
    accept_thread: Option<JoinHandle<()>>,
}

/// Shared by the threads.
#[derive(Clone)]
struct Shared {
    config: GatewayLinkConfig,
    state_publisher: Arc<StatePublisher>,
    stops: Sender<Command>,
    commands: Sender<LoopRequest>,
    imports: ImportQueue,
    jobs: Jobs,
    topomap: TopomapGenerator,
    ledger: Arc<LedgerInbox>,
    access: Arc<AccessDirectory>,
    accounts: Arc<AccountInbox>,
    lease: Arc<LeaseArbiter>,
    clock: Arc<RobotClock>,
    is_ending: Arc<AtomicBool>,
    watchdog: Watchdog,
}

impl Shared {
    /// Puts what the gateway has refused or done itself into the audit log.
    fn note(&self, AuditNote { by, request, refused, count }: &AuditNote) {
        let Some(audit) = self.state_publisher.audit() else { return };
        let principal = self.access.principal(by).ok();
        let mut outcome = refused
            .as_ref()
            .map_or_else(|| audit_texts::DONE.to_owned(), |reason| audit_texts::refused_because(reason));
        if principal.is_none()
            && let Some(owner) = self.access.former_owner(by)
        {
            outcome.push_str(&audit_texts::with_old_credential_of(&owner));
        }
        audit.note(principal, by.address, request, &outcome, *count);
    }

    /// Puts a refusal of the core into the audit log.
    fn note_refused(&self, by: &Caller, request: &str, reason: &str) {
        let refused = Some(reason.to_owned());
        self.note(&AuditNote { by: *by, request: request.to_owned(), refused, count: 1 });
    }

    fn note_refused_edit(&self, by: &Caller, outcome: &EditOutcome) {
        if let EditOutcome::Refused(refusal) = outcome {
            self.note_refused(by, audit_texts::EDIT, &refusal_reason(refusal.clone()));
        }
    }
}

impl GatewayLink {
    /// Starts to listen. A socket left over at this path is replaced: the lock of the data directory ensures that no other core uses it.
    pub fn listen(
        config: GatewayLinkConfig,
        path: &Path,
        state_publisher: Arc<StatePublisher>,
        stops: Sender<Command>,
        commands: Sender<LoopRequest>,
        imports: ImportQueue,
        jobs: Jobs,
        topomap: TopomapGenerator,
        ledger: Arc<LedgerInbox>,
        access: Arc<AccessDirectory>,
        accounts: Arc<AccountInbox>,
        lease: Arc<LeaseArbiter>,
        clock: Arc<RobotClock>,
        watchdog: &Watchdog,
    ) -> io::Result<Self> {
        if let Some(directory) = path.parent() {
            fs::create_dir_all(directory)?;
        }
        match fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let listener = UnixListener::bind(path)?;
        let for_shutdown = listener.try_clone()?;
        let is_ending = Arc::new(AtomicBool::new(false));
        let shared = Shared {
            config,
            state_publisher,
            stops,
            commands,
            imports,
            jobs,
            topomap,
            ledger,
            access,
            accounts,
            lease,
            clock,
            is_ending: Arc::clone(&is_ending),
            watchdog: watchdog.clone(),
        };
        let accept_thread = watchdog.spawn("gateway-accept", config.thread_limit, move |heartbeat| {
            accept(&listener, &shared, heartbeat)
        })?;
        Ok(Self {
            path: path.to_owned(),
            listener: for_shutdown,
            is_ending,
            accept_thread: Some(accept_thread),
        })
    }
}

impl Drop for GatewayLink {
    fn drop(&mut self) {
        self.is_ending.store(true, Ordering::Release);
        // Wakes the thread that waits for connections, also if somebody has removed the socket's file.
        let is_awake = rustix::net::shutdown(&self.listener, rustix::net::Shutdown::Both).is_ok();
        if let Some(thread) = self.accept_thread.take().filter(|_| is_awake) {
            let _ = thread.join();
        }
        let _ = fs::remove_file(&self.path);
    }
}

/// The connected gateway.
struct Connection {
    stream: UnixStream,
    threads: [JoinHandle<()>; 2],
}

impl Connection {
    fn start(stream: UnixStream, shared: &Shared) -> io::Result<Self> {
        stream.set_write_timeout(Some(shared.config.write_timeout))?;
        let (reading, writing) = (stream.try_clone()?, stream.try_clone()?);
        let id = shared.state_publisher.connect();
        let (for_reader, state_publisher) = (shared.clone(), Arc::clone(&shared.state_publisher));
        let reader = shared.watchdog.spawn("gateway-read", shared.config.thread_limit, move |heartbeat| {
            if let Err(error) = read_all(&reading, &for_reader, heartbeat) {
                tracing::warn!("the gateway's connection ends: {error}");
            }
            for_reader.state_publisher.disconnect(id);
        })?;
        let writer =
            shared.watchdog.spawn("gateway-write", shared.config.thread_limit, move |heartbeat| {
                if let Err(error) = write_all(&writing, &state_publisher, id, heartbeat) {
                    tracing::warn!("the gateway's connection ends: {error}");
                }
                state_publisher.disconnect(id);
                // Ends the reader as well, which waits for bytes.
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

fn accept(listener: &UnixListener, shared: &Shared, heartbeat: &Heartbeat) {
    let mut connection: Option<Connection> = None;
    loop {
        let waiting = heartbeat.begin_wait();
        let stream = listener.accept().map(|(stream, _)| stream);
        drop(waiting);
        heartbeat.beat();
        if let Some(old) = connection.take() {
            old.end();
        }
        if shared.is_ending.load(Ordering::Acquire) {
            return;
        }
        match stream.and_then(|stream| Connection::start(stream, shared)) {
            Ok(new) => connection = Some(new),
            Err(error) => tracing::error!("a gateway could not connect: {error}"),
        }
    }
}

fn write_all(
    mut stream: &UnixStream,
    state_publisher: &StatePublisher,
    connection: u64,
    heartbeat: &Heartbeat,
) -> io::Result<()> {
    let next = || {
        let _waiting = heartbeat.begin_wait();
        state_publisher.next(connection)
    };
    while let Some(message) = next() {
        heartbeat.beat();
        let frame = ports::encode_frame(&message);
        if frame.len() > MAX_MESSAGE_BYTES {
            // The gateway would end the connection, get the same message again, and so on for ever.
            tracing::error!("{}", texts::message_too_long(frame.len(), MAX_MESSAGE_BYTES));
            continue;
        }
        stream.write_all(&frame)?;
    }
    Ok(())
}

fn read_all(stream: &UnixStream, shared: &Shared, heartbeat: &Heartbeat) -> io::Result<()> {
    let mut reader = BufReader::new(stream);
    let mut has_greeted = false;
    let mut next = || {
        let _waiting = heartbeat.begin_wait();
        ports::read_frame(&mut reader, MAX_MESSAGE_BYTES)
    };
    while let Some(message) = next()? {
        heartbeat.beat();
        match message {
            GatewayMessage::Hello { version } if version == api::VERSION => has_greeted = true,
            GatewayMessage::Hello { version } => {
                return Err(invalid(texts::other_version(version, api::VERSION)));
            }
            _ if !has_greeted => return Err(invalid(texts::NO_GREETING)),
            GatewayMessage::Command { id, by: caller, command } => {
                let by = caller.client;
                let principal = match shared.access.admit(&caller, command_privilege(&command)) {
                    Ok(principal) => principal,
                    Err(reason) => {
                        if let Some(audit) = shared.state_publisher.audit() {
                            let by = shared.access.principal(&caller).ok();
                            audit.refuse(by, caller.address, &format!("{command:?}"), &reason);
                        }
                        shared.state_publisher.answer(id, by, Some(reason));
                        continue;
                    }
                };
                if let Some(audit) = shared.state_publisher.audit() {
                    audit.begin(id, &principal, &caller, &command);
                }
                let request = match convert::route(in_the_name_of(&principal, command)) {
                    // A stop waits behind no other command, and does not overtake a permission that was given before it.
                    RoutedCommand::Stack(kind @ (CommandKind::StopMotion | CommandKind::AllowMotion)) => {
                        if shared.stops.send(Command { id, by: principal, kind }).is_err() {
                            return Ok(());
                        }
                        continue;
                    }
                    RoutedCommand::RefuseTakeOver => {
                        let now = shared.clock.now();
                        let refused = shared.lease.refuse(&principal, now, Instant::now()).err();
                        shared.state_publisher.answer(id, by, refused);
                        continue;
                    }
                    RoutedCommand::Stack(CommandKind::TakeControl { name }) => {
                        let kind = CommandKind::TakeControl { name: name.clone() };
                        let command = Command { id, by: principal, kind };
                        match shared.lease.request(command, name, caller, Instant::now()) {
                            LeaseDecision::Grant(command) => LoopRequest::Command(command),
                            LeaseDecision::Asked => {
                                shared.state_publisher.answer(id, by, None);
                                continue;
                            }
                            LeaseDecision::Refused(reason) => {
                                shared.state_publisher.answer(id, by, Some(reason));
                                continue;
                            }
                        }
                    }
                    RoutedCommand::Stack(kind) => LoopRequest::Command(Command { id, by: principal, kind }),
                    RoutedCommand::SimulatedFault(fault) => LoopRequest::InjectFault { id, by, fault },
                    RoutedCommand::Import(upload, name, source) => {
                        let address = caller.address;
                        let import = ImportRequest { upload, by: principal, address, name, source };
                        shared.state_publisher.answer(id, by, shared.imports.begin(import).err());
                        continue;
                    }
                    RoutedCommand::InterruptedSession(decision) => {
                        let job = DiskJob::Interrupted(SessionRequest { id, by: principal, decision });
                        if let Err(reason) = shared.jobs.start_for_person(job) {
                            shared.state_publisher.answer(id, by, Some(reason.to_owned()));
                        }
                        continue;
                    }
                    RoutedCommand::StoredData(change) => {
                        let job = DiskJob::StoredData(StoredDataRequest { id, by: principal, change });
                        if let Err(reason) = shared.jobs.start_for_person(job) {
                            shared.state_publisher.answer(id, by, Some(reason.to_owned()));
                        }
                        continue;
                    }
                    RoutedCommand::CancelImport(upload) => {
                        shared.imports.cancel(upload);
                        shared.state_publisher.answer(id, by, None);
                        continue;
                    }
                    RoutedCommand::MakeExample(upload, time_zone) => {
                        let request = ImportRequest::example(upload, principal, caller.address, time_zone);
                        shared.state_publisher.answer(id, by, shared.imports.begin(request).err());
                        continue;
                    }
                    RoutedCommand::GenerateTopomap(map, edit) => {
                        let begun =
                            shared.topomap.begin(TopomapRequest { by: principal, map, edit }, |request| {
                                shared.jobs.start_for_person(DiskJob::ReadTopomapSource(request))
                            });
                        shared.state_publisher.answer(id, by, begun.err().map(str::to_owned));
                        continue;
                    }
                };
                match shared.commands.try_send(request) {
                    Ok(()) => {}
                    Err(TrySendError::Full(_)) => {
                        shared.state_publisher.answer(id, by, Some(texts::CONTROL_LOOP_BUSY.to_owned()));
                    }
                    Err(TrySendError::Disconnected(_)) => return Ok(()),
                }
            }
            GatewayMessage::Listeners { clients: _, streams } => shared.state_publisher.set_streams(streams),
            GatewayMessage::RequestGraph => shared.state_publisher.resend_graph(),
            GatewayMessage::RequestSite => shared.state_publisher.resend_site(),
            GatewayMessage::Edit { by: caller, edit } => {
                let id = edit.id;
                let refused = |reason| EditOutcome::Refused(EditRefusal::Rejected(reason));
                let handed_in = match shared.access.admit(&caller, edit_privilege(&edit)) {
                    Ok(by) => shared.ledger.edit(EditRequest { by, address: caller.address, edit }),
                    Err(reason) => Err(refused(reason)),
                };
                if let Err(outcome) = handed_in {
                    shared.note_refused_edit(&caller, &outcome);
                    let event = Event::EditDone(EditDone { id, outcome });
                    shared.state_publisher.push(CoreMessage::Event { to: Some(caller.client), event });
                }
            }
            GatewayMessage::Query { number, by, query } => {
                let admitted = shared.access.admit(&by, query_privilege(&query));
                let asked = admitted.and_then(|_| shared.ledger.query(number, query).map_err(str::to_owned));
                if let Err(reason) = asked {
                    shared.state_publisher.push(CoreMessage::Reply { number, result: Err(reason) });
                }
            }
            GatewayMessage::Account { number, by, request } => {
                let asked = audit_texts::request(&request);
                if let Err(refusal) = shared.accounts.ask(number, by, request) {
                    shared.note_refused(&by, &asked, &refusal.reason);
                    let result = Err(refusal);
                    shared.state_publisher.push(CoreMessage::AccountReply { number, result });
                }
            }
            GatewayMessage::Audit(notes) => {
                notes.iter().take(MAX_AUDIT_NOTES).for_each(|note| shared.note(note));
            }
            GatewayMessage::Clients(clients) => shared.lease.set_clients(clients, Instant::now()),
            GatewayMessage::CredentialsUsed(credentials) => {
                shared.access.note_used(&credentials, CalendarTime::read().utc);
            }
        }
    }
    Ok(())
}

/// Whoever takes control is called by the account, not by a name of one's own choice.
fn in_the_name_of(principal: &Principal, command: api::Command) -> api::Command {
    match (command, &principal.account) {
        (api::Command::TakeControl { .. }, Some(account)) => {
            api::Command::TakeControl { name: account.clone() }
        }
        (command, _) => command,
    }
}

fn invalid(error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, error)
}
