//! A client of the DevTools protocol: calls with their responses, and the events that arrive in between.
//! `docs/decisions/devtools-client.md` explains why it is written by hand.

use std::collections::VecDeque;
use std::net::TcpStream;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

/// Longest wait for a response. On a busy machine a page may compute for 60 s.
const ANSWER_LIMIT: Duration = Duration::from_secs(90);

/// An open connection to a browser.
pub struct DevTools {
    socket: WebSocket<TcpStream>,
    calls: u64,
    events: VecDeque<DevtoolsEvent>,
}

/// A message of the browser that is not a response.
#[derive(Debug)]
pub struct DevtoolsEvent {
    pub method: String,
    pub params: Value,
}

impl DevTools {
    /// Connects to the browser that listens at `port` under `path`.
    pub fn connect(port: u16, path: &str) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        let (socket, _) = tungstenite::client(format!("ws://127.0.0.1:{port}{path}"), stream).unwrap();
        Self { socket, calls: 0, events: VecDeque::new() }
    }

    /// Calls `method` in `session` (a page) or, without one, in the browser itself; fails with the error of the browser.
    #[track_caller]
    pub fn call(&mut self, session: Option<&str>, method: &str, params: Value) -> Value {
        self.try_call(session, method, params).unwrap_or_else(|error| panic!("{method}: {error}"))
    }

    /// [`Self::call`] for calls that may fail.
    pub fn try_call(&mut self, session: Option<&str>, method: &str, params: Value) -> Result<Value, String> {
        self.calls += 1;
        let id = self.calls;
        let mut call = json!({ "id": id, "method": method, "params": params });
        if let Some(session) = session {
            call["sessionId"] = session.into();
        }
        self.socket.send(Message::text(call.to_string())).map_err(|error| error.to_string())?;
        let deadline = Instant::now() + ANSWER_LIMIT;
        loop {
            let mut message = self.receive(deadline).ok_or("no answer")?;
            if message["id"] == id {
                let error = message["error"]["message"].as_str().map(str::to_owned);
                return error.map_or_else(|| Ok(message["result"].take()), Err);
            }
            self.keep(message);
        }
    }

    /// The events since the last call of this function.
    pub fn take_events(&mut self) -> Vec<DevtoolsEvent> {
        self.events.drain(..).collect()
    }

    fn keep(&mut self, mut message: Value) {
        if let Some(method) = message["method"].as_str() {
            let method = method.to_owned();
            self.events.push_back(DevtoolsEvent { method, params: message["params"].take() });
        }
    }

    /// The next message; `None` after the deadline.
    fn receive(&mut self, deadline: Instant) -> Option<Value> {
        loop {
            let left = deadline.checked_duration_since(Instant::now()).filter(|left| !left.is_zero())?;
            self.socket.get_ref().set_read_timeout(Some(left)).unwrap();
            match self.socket.read() {
                Ok(Message::Text(text)) => return Some(serde_json::from_str(&text).unwrap()),
                Ok(_) => {}
                Err(tungstenite::Error::Io(_)) => return None,
                Err(error) => panic!("the browser closed the connection: {error}"),
            }
        }
    }
}
