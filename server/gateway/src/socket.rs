//! Functions of both WebSockets: reading with a limit on silence, writing, and closing with a reason.

use crate::access::texts::SESSION_ENDED;
use crate::limits::FIXED;
use crate::texts;
use api::decode;
use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use serde::de::DeserializeOwned;
use std::time::Duration;
use tokio::time::timeout;

/// RFC 6455, 5.5: control frames carry 125 bytes, two of them the code.
const MAX_CLOSE_REASON_BYTES: usize = 123;

/// The half that writes.
pub(crate) type Outgoing = SplitSink<WebSocket, Message>;

/// Why a socket is being closed.
#[derive(Debug)]
pub(crate) enum Closing {
    /// The peer is gone; nothing can be sent to it.
    Gone,
    /// The peer sent nothing for too long.
    Silent,
    /// The server ends the connection, for the reason in this sentence.
    Refused(String),
    /// The session has ended, or its role has changed.
    SignedOut,
    /// The server stops.
    Shutdown,
}

/// Code of a close frame with which a client is told to sign in again: of those for applications (RFC 6455, 7.4.2), after the status of HTTP.
const CLOSE_CODE_SIGNED_OUT: u16 = 4401;

impl Closing {
    /// The client speaks another version of the contract.
    pub(crate) fn wrong_version(version: u16) -> Self {
        Self::Refused(texts::wrong_version(version, api::VERSION))
    }

    fn frame(&self) -> CloseFrame {
        let (code, reason) = match self {
            Self::Gone => (close_code::NORMAL, ""),
            Self::Silent => (close_code::POLICY, texts::CLOSED_FOR_SILENCE),
            Self::Refused(reason) => (close_code::POLICY, start_of(reason)),
            Self::SignedOut => (CLOSE_CODE_SIGNED_OUT, SESSION_ENDED),
            Self::Shutdown => (close_code::AWAY, texts::CLOSED_BY_SHUTDOWN),
        };
        CloseFrame { code, reason: reason.into() }
    }
}

/// As much of a sentence as fits into a close frame.
fn start_of(reason: &str) -> &str {
    &reason[..reason.floor_char_boundary(MAX_CLOSE_REASON_BYTES)]
}

/// The half that reads.
pub(crate) struct Incoming {
    stream: SplitStream<WebSocket>,
    silence: Duration,
}

impl Incoming {
    /// `silence` is the longest wait for anything from the peer.
    pub(crate) fn new(stream: SplitStream<WebSocket>, silence: Duration) -> Self {
        Self { stream, silence }
    }

    /// The next message of the contract. Pings and pongs of WebSocket itself count as signs of life.
    pub(crate) async fn message<T: DeserializeOwned>(&mut self) -> Result<T, Closing> {
        loop {
            match timeout(self.silence, self.stream.next()).await {
                Err(_) => return Err(Closing::Silent),
                Ok(None | Some(Ok(Message::Close(_)))) => return Err(Closing::Gone),
                // Too long, not UTF-8, unmasked, or the network: nothing can be read after it.
                Ok(Some(Err(error))) => {
                    tracing::debug!(%error, "a socket broke");
                    return Err(Closing::Gone);
                }
                Ok(Some(Ok(Message::Ping(_) | Message::Pong(_)))) => {}
                Ok(Some(Ok(Message::Text(_)))) => {
                    return Err(Closing::Refused(texts::MESSAGE_NOT_BINARY.to_owned()));
                }
                Ok(Some(Ok(Message::Binary(bytes)))) => {
                    return decode(&bytes)
                        .map_err(|error| Closing::Refused(texts::message_not_understood(error)));
                }
            }
        }
    }
}

/// Writes one binary message; returns once it is in the kernel's hands.
pub(crate) async fn send(sink: &mut Outgoing, bytes: Vec<u8>) -> Result<(), Closing> {
    sink.send(Message::Binary(bytes.into())).await.map_err(|error| {
        tracing::debug!(%error, "a socket broke");
        Closing::Gone
    })
}

/// Sends the reason, closes, and waits a little until the peer has read it. If the socket were closed at once with unread bytes, the kernel would
/// reset the connection and the reason would be lost.
pub(crate) async fn close(
    mut sink: Outgoing,
    mut incoming: Incoming,
    closing: Closing,
    last_message: Option<Vec<u8>>,
) {
    tracing::debug!(?closing, "closing a socket");
    if matches!(closing, Closing::Gone) {
        return;
    }
    let closing_handshake = async {
        if let Some(bytes) = last_message {
            send(&mut sink, bytes).await.ok();
        }
        sink.send(Message::Close(Some(closing.frame()))).await.ok();
        while incoming.stream.next().await.is_some_and(|message| message.is_ok()) {}
    };
    timeout(FIXED.close_timeout, closing_handshake).await.ok();
}
