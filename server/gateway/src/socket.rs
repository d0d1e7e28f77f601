//! What both WebSockets share: reading with a bound on silence, writing, and saying good-bye.

use api::decode;
use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use serde::de::DeserializeOwned;
use std::time::Duration;
use tokio::time::timeout;

/// Longest time that a closing connection is kept so that the peer can read the last word.
const FAREWELL: Duration = Duration::from_secs(2);

/// RFC 6455, 5.5: control frames carry 125 bytes, two of them the code.
const MAX_CLOSE_REASON_BYTES: usize = 123;

/// The half that writes.
pub(crate) type Outgoing = SplitSink<WebSocket, Message>;

/// Why a socket is being closed.
#[derive(Debug)]
pub(crate) enum Closing {
    /// The peer is gone: nothing can be said to it.
    Gone,
    /// The peer said nothing for too long.
    Silent,
    /// The server will not go on, for the reason in this sentence.
    Refused(String),
    /// The server stops.
    Shutdown,
}

impl Closing {
    /// The client speaks another version of the contract.
    pub(crate) fn wrong_version(version: u16) -> Self {
        let ours = api::VERSION;
        Self::Refused(format!(
            "This client speaks version {version} of the contract and the server version {ours}. Reload the page to \
             get the client that fits."
        ))
    }

    fn frame(&self) -> CloseFrame {
        let (code, reason) = match self {
            Self::Gone => (close_code::NORMAL, ""),
            Self::Silent => (close_code::POLICY, "nothing was heard for too long"),
            Self::Refused(reason) => (close_code::POLICY, start_of(reason)),
            Self::Shutdown => (close_code::AWAY, "the server stops"),
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
                    return Err(Closing::Refused("Messages are binary (postcard), not text.".to_owned()));
                }
                Ok(Some(Ok(Message::Binary(bytes)))) => {
                    return decode(&bytes).map_err(|error| {
                        Closing::Refused(format!(
                            "Not understood: {error}. Reload to get the client that fits."
                        ))
                    });
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

/// Says the last word, closes, and waits a little for the peer to have read it: closing at once with bytes unread would
/// make the kernel reset the connection and the last word be lost.
pub(crate) async fn farewell(
    mut sink: Outgoing,
    mut incoming: Incoming,
    closing: Closing,
    last_word: Option<Vec<u8>>,
) {
    tracing::debug!(?closing, "closing a socket");
    if matches!(closing, Closing::Gone) {
        return;
    }
    let say = async {
        if let Some(bytes) = last_word {
            send(&mut sink, bytes).await.ok();
        }
        sink.send(Message::Close(Some(closing.frame()))).await.ok();
        while incoming.stream.next().await.is_some_and(|message| message.is_ok()) {}
    };
    timeout(FAREWELL, say).await.ok();
}
