//! The two WebSockets: what they say becomes events, effects become messages.

use crate::browser;
use crate::inbox::{InboundMessage, Inbox};
use client_model::{ClientEvent, Socket};
use wasm_bindgen::JsCast;
use wasm_bindgen::prelude::Closure;
use web_sys::{BinaryType, CloseEvent, MessageEvent, WebSocket};

/// Both sockets; each is opened anew after every loss.
pub(crate) struct SocketConnections {
    inbox: Inbox,
    control: Option<Connection>,
    stream: Option<Connection>,
}

/// One opened socket. Its callbacks live as long as it does; dropping it silences and closes it.
struct Connection {
    socket: WebSocket,
    _opened: Closure<dyn FnMut()>,
    _closed: Closure<dyn FnMut(CloseEvent)>,
    _message: Closure<dyn FnMut(MessageEvent)>,
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.socket.set_onopen(None);
        self.socket.set_onclose(None);
        self.socket.set_onmessage(None);
        // A socket that is closed already cannot be closed again; that is no concern here.
        let _ = self.socket.close();
    }
}

impl SocketConnections {
    pub(crate) fn new(inbox: Inbox) -> Self {
        Self { inbox, control: None, stream: None }
    }

    fn slot(&mut self, which: Socket) -> &mut Option<Connection> {
        match which {
            Socket::Control => &mut self.control,
            Socket::Stream => &mut self.stream,
        }
    }

    /// Opens a socket, closing the one before.
    pub(crate) fn open(&mut self, which: Socket) {
        let connection = Connection::open(which, &self.inbox);
        if connection.is_none() {
            self.inbox.leave(InboundMessage::Event(ClientEvent::SocketClosed {
                socket: which,
                jitter: browser::random_unit(),
            }));
        }
        *self.slot(which) = connection;
    }

    /// Closes a socket without an event.
    pub(crate) fn close(&mut self, which: Socket) {
        *self.slot(which) = None;
    }

    /// Sends bytes, if the socket is open; else its closing is on its way as an event.
    pub(crate) fn send(&mut self, which: Socket, bytes: &[u8]) {
        if let Some(connection) = self.slot(which)
            && connection.socket.ready_state() == WebSocket::OPEN
        {
            // Refused only when the socket is not open, which was looked at.
            let _ = connection.socket.send_with_u8_array(bytes);
        }
    }
}

impl Connection {
    fn open(which: Socket, inbox: &Inbox) -> Option<Self> {
        let path = match which {
            Socket::Control => api::CONTROL_PATH,
            Socket::Stream => api::STREAM_PATH,
        };
        let socket = WebSocket::new(&browser::socket_url(path)?).ok()?;
        socket.set_binary_type(BinaryType::Arraybuffer);
        let opened = {
            let inbox = inbox.clone();
            Closure::<dyn FnMut()>::new(move || {
                inbox.leave(InboundMessage::Event(ClientEvent::SocketOpened(which)))
            })
        };
        let closed = {
            let inbox = inbox.clone();
            Closure::<dyn FnMut(CloseEvent)>::new(move |_| {
                inbox.leave(InboundMessage::Event(ClientEvent::SocketClosed {
                    socket: which,
                    jitter: browser::random_unit(),
                }));
            })
        };
        let message = {
            let inbox = inbox.clone();
            Closure::<dyn FnMut(MessageEvent)>::new(move |event: MessageEvent| {
                inbox.leave(InboundMessage::Event(event_of(which, &event)));
            })
        };
        socket.set_onopen(Some(opened.as_ref().unchecked_ref()));
        socket.set_onclose(Some(closed.as_ref().unchecked_ref()));
        socket.set_onmessage(Some(message.as_ref().unchecked_ref()));
        Some(Self { socket, _opened: opened, _closed: closed, _message: message })
    }
}

fn event_of(which: Socket, event: &MessageEvent) -> ClientEvent {
    let Ok(buffer) = event.data().dyn_into::<js_sys::ArrayBuffer>() else {
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
