//! A fake gateway.

use api::{Command, CoreMessage, Event, GatewayMessage};
use site_model::Edit;
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use uuid::Uuid;
use vocab::{ClientId, CommandId};

/// Limit of all waits, far longer than any of them takes.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// The client in whose name commands are sent.
pub const CLIENT: ClientId = ClientId(Uuid::from_u128(1));

/// Whoever commands the robot: a gateway at the core, or a client of the platform.
pub trait CommandSender {
    /// Sends a command and waits until it is accepted.
    fn command(&mut self, command: Command);
    /// Reads events until `wanted` accepts one.
    fn event<T>(&mut self, wanted: impl FnMut(&Event) -> Option<T>) -> T;
    /// Sends an edit of the site.
    fn edit(&mut self, edit: Edit);
}

impl CommandSender for FakeGateway {
    fn command(&mut self, command: Command) {
        Self::command(self, command);
    }

    fn event<T>(&mut self, wanted: impl FnMut(&Event) -> Option<T>) -> T {
        Self::event(self, wanted)
    }

    fn edit(&mut self, edit: Edit) {
        self.send(&GatewayMessage::Edit { by: CLIENT.into(), edit });
    }
}

/// A connection to a core.
pub struct FakeGateway {
    stream: UnixStream,
    /// Texts of all notices read so far. A notice may arrive before or after the state that it belongs to.
    notices: Vec<String>,
}

/// Number of the next command. Ids are unique over all connections, because a repeated command has no effect.
static COMMANDS: AtomicU64 = AtomicU64::new(1);

impl FakeGateway {
    /// Waits until the core listens, and connects.
    pub fn connect(socket: &Path) -> Self {
        until("the core listens", || Self::try_connect(socket))
    }

    /// Connects, if the core listens.
    pub fn try_connect(socket: &Path) -> Option<Self> {
        let stream = UnixStream::connect(socket).ok()?;
        stream.set_read_timeout(Some(PATIENCE)).expect("settable");
        let mut gateway = Self { stream, notices: Vec::new() };
        gateway.send(&GatewayMessage::Hello { version: api::VERSION });
        Some(gateway)
    }

    /// The same connection, to send while another thread reads.
    pub fn another_sender(&self) -> Self {
        Self { stream: self.stream.try_clone().expect("a second handle"), notices: Vec::new() }
    }

    /// Sends a message.
    pub fn send(&mut self, message: &GatewayMessage) {
        let body = api::encode(message);
        self.stream.write_all(&(body.len() as u32).to_le_bytes()).expect("written");
        self.stream.write_all(&body).expect("written");
    }

    /// Sends a command and waits until it is accepted.
    pub fn command(&mut self, command: Command) {
        assert_eq!(self.outcome(command), api::CommandOutcome::Accepted);
    }

    /// Sends a command.
    pub fn send_command(&mut self, command: Command) -> CommandId {
        let id = CommandId(Uuid::from_u128(COMMANDS.fetch_add(1, Ordering::Relaxed).into()));
        self.send(&GatewayMessage::Command { id, by: CLIENT.into(), command });
        id
    }

    /// Sends a command and waits for its outcome.
    pub fn outcome(&mut self, command: Command) -> api::CommandOutcome {
        let id = self.send_command(command);
        self.event(|event| match event {
            Event::CommandDone { id: done, outcome } if *done == id => Some(outcome.clone()),
            _ => None,
        })
    }

    /// The next message.
    pub fn message(&mut self) -> CoreMessage {
        self.next_message().expect("the core is running")
    }

    /// The next message; none when the core has ended.
    pub fn next_message(&mut self) -> Option<CoreMessage> {
        let mut length = [0; 4];
        self.stream.read_exact(&mut length).ok()?;
        let mut body = vec![0; u32::from_le_bytes(length) as usize];
        self.stream.read_exact(&mut body).ok()?;
        Some(api::decode(&body).expect("a message"))
    }

    /// Reads events until `wanted` accepts one.
    pub fn event<T>(&mut self, mut wanted: impl FnMut(&Event) -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            assert!(start.elapsed() < PATIENCE, "the event did not arrive within the limit");
            let CoreMessage::Event { event, .. } = self.message() else { continue };
            if let Event::Notice(notice) = &event {
                self.notices.push(notice.text.clone());
            }
            if let Some(found) = wanted(&event) {
                return found;
            }
        }
    }

    /// Waits for a notice with this text in it, unless it was read already.
    pub fn notice(&mut self, part: &str) {
        if !self.notices.iter().any(|text| text.contains(part)) {
            self.event(|event| match event {
                Event::Notice(notice) if notice.text.contains(part) => Some(()),
                _ => None,
            });
        }
    }
}

/// Waits for a condition.
pub fn until<T>(what: &str, mut condition: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = condition() {
            return found;
        }
        assert!(start.elapsed() < PATIENCE, "did not happen within the limit: {what}");
        // A pause between checks, so that they leave the CPU to the core.
        std::thread::sleep(Duration::from_millis(5));
    }
}
