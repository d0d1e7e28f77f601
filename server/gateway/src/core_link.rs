//! The gateway's side of the Unix socket to the core: connects, reconnects, and passes messages both ways.

use crate::hub::{CoreMessages, Hub};
use crate::texts;
use api::{CoreMessage, DecodeError, GatewayMessage, MAX_MESSAGE_BYTES};
use axum::body::Bytes;
use futures_util::{SinkExt, StreamExt};
use serde::Serialize;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::UnixStream;
use tokio::net::unix::{OwnedReadHalf, OwnedWriteHalf};
use tokio_util::codec::{FramedRead, FramedWrite, LengthDelimitedCodec};

/// Parameters of the link to the core.
#[derive(Clone, Copy, Debug)]
struct CoreLinkConfig {
    /// Pause before the first attempt to reconnect; it doubles with each further attempt. A core that restarts is back within a few of them. Chosen: nobody notices it.
    min_retry_pause: Duration,
    /// Longest pause between two attempts to reconnect. Chosen: people notice a second, and a core that starts takes longer.
    max_retry_pause: Duration,
    /// Longest time from connecting to the core's hello. Chosen: a core that lives answers within milliseconds; then it is connected anew.
    hello_timeout: Duration,
}

const CONFIG: CoreLinkConfig = CoreLinkConfig {
    min_retry_pause: Duration::from_millis(50),
    max_retry_pause: Duration::from_secs(1),
    hello_timeout: Duration::from_secs(5),
};

/// Why a connection to the core ended, as a clause after "The robot's core". Texts: `texts.rs`.
#[derive(Debug, thiserror::Error)]
enum CoreLinkError {
    #[error("{}", texts::core_not_reachable(.0))]
    Connect(#[source] io::Error),
    #[error("{}", texts::core_broke_connection(.0))]
    Io(#[from] io::Error),
    #[error("{}", texts::core_sent_no_message(.0))]
    Decode(#[from] DecodeError),
    #[error("{}", texts::CORE_SENDS_NO_HELLO)]
    NoHello,
    #[error("{}", texts::core_version(*.0, api::VERSION))]
    Version(u16),
}

/// Keeps the hub connected to the core at `socket`; never returns.
pub(crate) async fn run(socket: &Path, hub: &Arc<Hub>) {
    let mut retry = CONFIG.min_retry_pause;
    loop {
        let error = match connect(socket).await {
            Ok((reader, writer)) => {
                tracing::info!(socket = %socket.display(), "connected to the core");
                retry = CONFIG.min_retry_pause;
                exchange(reader, writer, hub).await
            }
            Err(error) => error,
        };
        tracing::warn!(socket = %socket.display(), "the core {error}");
        hub.core_lost(&texts::core_fault(&error));
        tokio::time::sleep(retry).await;
        retry = (2 * retry).min(CONFIG.max_retry_pause);
    }
}

type Reader = FramedRead<OwnedReadHalf, LengthDelimitedCodec>;
type Writer = FramedWrite<OwnedWriteHalf, LengthDelimitedCodec>;

/// Connects and exchanges hellos.
async fn connect(socket: &Path) -> Result<(Reader, Writer), CoreLinkError> {
    let stream = UnixStream::connect(socket).await.map_err(CoreLinkError::Connect)?;
    let (reader, writer) = stream.into_split();
    let (mut reader, mut writer) = (FramedRead::new(reader, codec()), FramedWrite::new(writer, codec()));
    write_message(&mut writer, &GatewayMessage::Hello { version: api::VERSION }).await?;
    match tokio::time::timeout(CONFIG.hello_timeout, read_message(&mut reader)).await {
        Ok(Ok(CoreMessage::Hello { version: api::VERSION })) => Ok((reader, writer)),
        Ok(Ok(CoreMessage::Hello { version })) => Err(CoreLinkError::Version(version)),
        Ok(Err(error)) => Err(error),
        Ok(Ok(_)) | Err(_) => Err(CoreLinkError::NoHello),
    }
}

/// Passes messages both ways until one way fails.
async fn exchange(mut reader: Reader, mut writer: Writer, hub: &Arc<Hub>) -> CoreLinkError {
    let mut outgoing = hub.core_connected();
    let incoming = async {
        loop {
            match read_message(&mut reader).await {
                Ok(message) => hub.apply(message),
                Err(error) => return error,
            }
        }
    };
    tokio::select! {
        error = incoming => error,
        error = write_all(&mut writer, &mut outgoing, hub) => error,
    }
}

/// Writes what waits, Stop motion first, and the clients and listeners whenever they change.
async fn write_all(writer: &mut Writer, outgoing: &mut CoreMessages, hub: &Hub) -> CoreLinkError {
    let mut listeners = hub.listeners();
    listeners.mark_changed();
    let mut present = hub.present();
    present.mark_changed();
    loop {
        let message = tokio::select! {
            Some(message) = outgoing.next() => message,
            Ok(()) = present.changed() => GatewayMessage::Clients(present.borrow_and_update().clone()),
            Ok(()) = listeners.changed() => {
                let now = *listeners.borrow_and_update();
                GatewayMessage::Listeners { clients: now.clients, streams: now.streams }
            }
        };
        if let Err(error) = write_message(writer, &message).await {
            return error.into();
        }
    }
}

/// A message after its length, 4 bytes, little endian.
fn codec() -> LengthDelimitedCodec {
    LengthDelimitedCodec::builder()
        .little_endian()
        .length_field_length(4)
        .max_frame_length(MAX_MESSAGE_BYTES)
        .new_codec()
}

async fn write_message(writer: &mut Writer, message: &impl Serialize) -> io::Result<()> {
    writer.send(Bytes::from(api::encode(message))).await
}

async fn read_message(reader: &mut Reader) -> Result<CoreMessage, CoreLinkError> {
    let body = reader.next().await.unwrap_or_else(|| Err(io::ErrorKind::UnexpectedEof.into()))?;
    Ok(api::decode(&body)?)
}
