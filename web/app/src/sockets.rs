//! The two WebSockets: received messages become events, and effects send messages.

use crate::browser;
use crate::inbox::Inbox;
use client_model::{ClientEvent, Socket};
use gloo_events::EventListener;
use wasm_bindgen::JsCast;
use web_sys::{BinaryType, MessageEvent, WebSocket};

/// Both sockets.
pub(crate) struct SocketConnections {
    inbox: Inbox,
    control: Option<SocketConnection>,
    stream: Option<SocketConnection>,
}

/// An open socket. Dropping it removes its listeners and closes it.
struct SocketConnection {
    socket: WebSocket,
    listeners: Vec<EventListener>,
}

impl Drop for SocketConnection {
    fn drop(&mut self) {
        self.listeners.clear();
        // Fails only for a socket that is closed already.
        let _ = self.socket.close();
    }
}

impl SocketConnections {
    /// `inbox` receives the sockets' events.
    pub(crate) fn new(inbox: Inbox) -> Self {
        Self { inbox, control: None, stream: None }
    }

    fn slot(&mut self, socket: Socket) -> &mut Option<SocketConnection> {
        match socket {
            Socket::Control => &mut self.control,
            Socket::Stream => &mut self.stream,
        }
    }

    /// Opens a socket and closes the one before.
    pub(crate) fn open(&mut self, socket: Socket) {
        let connection = SocketConnection::open(socket, &self.inbox);
        if connection.is_none() {
            self.inbox.push_event(closed(socket));
        }
        *self.slot(socket) = connection;
    }

    /// Closes a socket without an event.
    pub(crate) fn close(&mut self, socket: Socket) {
        *self.slot(socket) = None;
    }

    /// Sends bytes if the socket is open. If it is not, the event of its closing is on the way.
    pub(crate) fn send(&mut self, socket: Socket, bytes: &[u8]) {
        if let Some(connection) = self.slot(socket)
            && connection.socket.ready_state() == WebSocket::OPEN
        {
            // Fails only for a socket that is not open.
            let _ = connection.socket.send_with_u8_array(bytes);
        }
    }
}

impl SocketConnection {
    fn open(which: Socket, inbox: &Inbox) -> Option<Self> {
        let path = match which {
            Socket::Control => api::CONTROL_PATH,
            Socket::Stream => api::STREAM_PATH,
        };
        let socket = WebSocket::new(&browser::socket_url(path)?).ok()?;
        socket.set_binary_type(BinaryType::Arraybuffer);
        let listen = |kind: &'static str, event_of: fn(Socket, &web_sys::Event) -> ClientEvent| {
            let inbox = inbox.clone();
            EventListener::new(&socket, kind, move |event| inbox.push_event(event_of(which, event)))
        };
        let listeners = vec![
            listen("open", |which, _| ClientEvent::SocketOpened(which)),
            listen("close", |which, _| {
                if which == Socket::Control {
                    // The page asks the server whether the session has ended, and then people to sign in.
                    browser::dispatch("autoinspect-disconnected");
                }
                closed(which)
            }),
            listen("message", received),
        ];
        Some(Self { socket, listeners })
    }
}

fn closed(socket: Socket) -> ClientEvent {
    ClientEvent::SocketClosed { socket, jitter: browser::random_unit() }
}

fn received(which: Socket, event: &web_sys::Event) -> ClientEvent {
    let data = event.dyn_ref::<MessageEvent>().map(MessageEvent::data);
    let Some(buffer) = data.and_then(|data| data.dyn_into::<js_sys::ArrayBuffer>().ok()) else {
        return ClientEvent::DecodeFailed { socket: which };
    };
    let content = js_sys::Uint8Array::new(&buffer).to_vec();
    let bytes = content.len();
    let decoded = match which {
        Socket::Control => api::decode(&content).map(|message| ClientEvent::Server { message, bytes }),
        Socket::Stream => api::decode(&content).map(|frame| ClientEvent::Scan { frame, bytes }),
    };
    decoded.unwrap_or(ClientEvent::DecodeFailed { socket: which })
}
