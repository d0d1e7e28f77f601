//! An operator at a running platform: a client's control socket that sends commands and edits, and reads what becomes of them.

use crate::fake_gateway::{CommandSender, PATIENCE};
use api::{ClientMessage, Command, CommandOutcome, Event, LeaseToken, ServerMessage};
use site_model::Edit;
use std::io;
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};
use tungstenite::{Message, WebSocket};
use uuid::Uuid;
use vocab::CommandId;

/// Time after which a ping is due; the server closes without one for 10 s.
const PING_PERIOD: Duration = Duration::from_secs(1);

/// The client.
pub struct Operator {
    socket: WebSocket<TcpStream>,
    pinged: Instant,
    commands: u128,
}

impl Operator {
    /// Opens the socket.
    pub fn connect(address: SocketAddr) -> Self {
        let stream = TcpStream::connect(address).expect("a connection");
        stream.set_nodelay(true).expect("settable");
        let url = format!("ws://{address}{}", api::CONTROL_PATH);
        let (socket, _) = tungstenite::client(url, stream).expect("a WebSocket");
        socket.get_ref().set_read_timeout(Some(Duration::from_millis(200))).expect("settable");
        let mut operator = Self { socket, pinged: Instant::now(), commands: 0 };
        let lease = LeaseToken(Uuid::from_u128(0x0b));
        operator.send(&ClientMessage::Hello { version: api::VERSION, lease });
        operator
    }

    fn send(&mut self, message: &ClientMessage) {
        self.socket.send(Message::Binary(api::encode(message).into())).expect("written");
    }

    /// The next message, if one comes soon.
    fn read(&mut self) -> Option<ServerMessage> {
        if self.pinged.elapsed() >= PING_PERIOD {
            self.pinged = Instant::now();
            self.send(&ClientMessage::Ping { token: 1 });
        }
        match self.socket.read() {
            Ok(Message::Binary(bytes)) => Some(api::decode(&bytes).expect("a message")),
            Ok(_) => None,
            Err(tungstenite::Error::Io(error))
                if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) =>
            {
                None
            }
            Err(error) => panic!("the socket broke: {error}"),
        }
    }
}

impl CommandSender for Operator {
    fn event<T>(&mut self, mut wanted: impl FnMut(&Event) -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            assert!(start.elapsed() < PATIENCE, "the event did not arrive within the limit");
            if let Some(ServerMessage::Event { event, .. }) = self.read()
                && let Some(found) = wanted(&event)
            {
                return found;
            }
        }
    }

    fn command(&mut self, command: Command) {
        self.commands += 1;
        let id = CommandId(Uuid::from_u128(0x0b00 + self.commands));
        self.send(&ClientMessage::Command { id, command });
        let outcome = self.event(|event| match event {
            Event::CommandDone { id: done, outcome } if *done == id => Some(outcome.clone()),
            _ => None,
        });
        assert_eq!(outcome, CommandOutcome::Accepted);
    }

    fn edit(&mut self, edit: Edit) {
        self.send(&ClientMessage::Edit(edit));
    }
}
