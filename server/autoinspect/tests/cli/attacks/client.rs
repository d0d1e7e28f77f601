//! A client with a token at the control socket: sends messages, and reads what comes.

use super::guarded::connect_from;
use api::{ClientMessage, Command, CommandOutcome, Event, LeaseToken, ServerMessage};
use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};
use uuid::Uuid;
use vocab::CommandId;

/// Longest wait for one message of a client.
const MESSAGE_LIMIT: Duration = Duration::from_millis(20);

/// Number of the next command. Ids are unique over all clients, because a repeated command has no effect.
static COMMANDS: AtomicU64 = AtomicU64::new(1);

/// Time after which a ping is due.
const PING_PERIOD: Duration = Duration::from_secs(1);

/// The client.
pub struct Client<S = TcpStream> {
    socket: WebSocket<S>,
    pinged: Instant,
}

impl Client {
    /// Opens the socket from 127.0.0.`last`, in the name of this token.
    pub fn connect(last: u8, address: SocketAddr, token: &str, name: u64) -> io::Result<Self> {
        let stream = connect_from(last, address)?;
        let client = Client::over(stream, &format!("ws://{address}{}", api::CONTROL_PATH), token, name)?;
        client.socket.get_ref().set_read_timeout(Some(MESSAGE_LIMIT))?;
        Ok(client)
    }
}

impl<S: Read + Write> Client<S> {
    /// Opens the socket over this connection, and says hello.
    pub fn over(stream: S, url: &str, token: &str, name: u64) -> io::Result<Self> {
        let mut request = url.into_client_request().map_err(io::Error::other)?;
        let header = format!("Bearer {token}").parse().map_err(io::Error::other)?;
        request.headers_mut().insert("authorization", header);
        let (socket, _) =
            tungstenite::client(request, stream).map_err(|error| io::Error::other(error.to_string()))?;
        let mut client = Self { socket, pinged: Instant::now() };
        let lease = LeaseToken(Uuid::from_u64_pair(0xa77ac, name));
        client.send(&ClientMessage::Hello { version: api::VERSION, lease })?;
        Ok(client)
    }

    pub fn socket(&mut self) -> &mut WebSocket<S> {
        &mut self.socket
    }

    pub fn send(&mut self, message: &ClientMessage) -> io::Result<()> {
        self.socket.send(Message::Binary(api::encode(message).into())).map_err(io::Error::other)
    }

    /// Takes what has come, and says now and then that it is there: the server closes a socket that is silent for 10 s.
    pub fn keep_alive(&mut self) {
        if self.pinged.elapsed() >= PING_PERIOD {
            self.pinged = Instant::now();
            self.send(&ClientMessage::Ping { token: 1 }).expect("the socket stays open");
        }
        // Events may come without an end.
        for _ in 0..20 {
            if self.read().expect("the socket stays open").is_none() {
                return;
            }
        }
    }

    /// Sends a command, and does not wait for its outcome.
    pub fn command(&mut self, command: Command) -> io::Result<CommandId> {
        let id = CommandId(Uuid::from_u64_pair(0xa77ac, COMMANDS.fetch_add(1, Ordering::Relaxed)));
        self.send(&ClientMessage::Command { id, command }).map(|()| id)
    }

    /// The next message, if one comes soon.
    pub fn read(&mut self) -> io::Result<Option<ServerMessage>> {
        match self.socket.read() {
            Ok(Message::Binary(bytes)) => api::decode(&bytes).map(Some).map_err(io::Error::other),
            Ok(Message::Close(reason)) => {
                Err(io::Error::other(format!("the server closed the socket: {reason:?}")))
            }
            Ok(_) => Ok(None),
            Err(tungstenite::Error::Io(error))
                if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) =>
            {
                Ok(None)
            }
            Err(error) => Err(io::Error::other(error)),
        }
    }

    /// Sends a command, and waits for its outcome.
    pub fn outcome(&mut self, command: Command) -> io::Result<CommandOutcome> {
        let start = Instant::now();
        let id = self.command(command)?;
        while start.elapsed() < super::guarded::ANSWER_LIMIT {
            if let Some(ServerMessage::Event { event: Event::CommandDone { id: done, outcome }, .. }) =
                self.read()?
                && done == id
            {
                return Ok(outcome);
            }
        }
        Err(io::ErrorKind::TimedOut.into())
    }
}
