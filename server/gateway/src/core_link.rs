//! The gateway's side of the Unix socket to the core: connects, reconnects, and passes messages both ways.

use crate::hub::Hub;
use api::{CoreMessage, DecodeError, GatewayMessage, MAX_MESSAGE_BYTES};
use serde::Serialize;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt, BufReader};
use tokio::net::UnixStream;
use tokio::net::unix::{OwnedReadHalf, OwnedWriteHalf};
use tokio::sync::mpsc;

const RETRY_FIRST: Duration = Duration::from_millis(50);
const RETRY_LAST: Duration = Duration::from_secs(1);
/// Longest time from connecting to the core's hello.
const HELLO_TIMEOUT: Duration = Duration::from_secs(5);
/// Buffers larger than this are given back after a large message.
const KEPT_BUFFER_BYTES: usize = 1 << 20;

/// Why a connection to the core ended, as a clause after "The robot's core".
#[derive(Debug, thiserror::Error)]
enum CoreLinkError {
    #[error("cannot be reached: {0}")]
    Connect(#[source] io::Error),
    #[error("broke the connection: {0}")]
    Io(#[from] io::Error),
    #[error("sent what is no message: {0}")]
    Decode(#[from] DecodeError),
    #[error("does not introduce itself")]
    NoHello,
    #[error("speaks version {0} of the contract and this server version {ours}: start both from the same program", ours = api::VERSION)]
    Version(u16),
}

/// Keeps the hub connected to the core at `socket`, for ever.
pub(crate) async fn run(socket: &Path, hub: &Arc<Hub>) {
    let mut retry = RETRY_FIRST;
    loop {
        let error = match greet(socket).await {
            Ok((reader, writer)) => {
                tracing::info!(socket = %socket.display(), "connected to the core");
                retry = RETRY_FIRST;
                converse(reader, writer, hub).await
            }
            Err(error) => error,
        };
        tracing::warn!(socket = %socket.display(), "the core {error}");
        hub.core_lost(&format!("The robot's core {error}."));
        tokio::time::sleep(retry).await;
        retry = (2 * retry).min(RETRY_LAST);
    }
}

type Reader = BufReader<OwnedReadHalf>;

/// Connects and exchanges hellos.
async fn greet(socket: &Path) -> Result<(Reader, OwnedWriteHalf), CoreLinkError> {
    let stream = UnixStream::connect(socket).await.map_err(CoreLinkError::Connect)?;
    let (reader, mut writer) = stream.into_split();
    let mut reader = BufReader::with_capacity(64 << 10, reader);
    write_message(&mut writer, &GatewayMessage::Hello { version: api::VERSION }).await?;
    let mut buffer = Vec::new();
    match tokio::time::timeout(HELLO_TIMEOUT, read_message(&mut reader, &mut buffer)).await {
        Ok(Ok(CoreMessage::Hello { version: api::VERSION })) => Ok((reader, writer)),
        Ok(Ok(CoreMessage::Hello { version })) => Err(CoreLinkError::Version(version)),
        Ok(Err(error)) => Err(error),
        Ok(Ok(_)) | Err(_) => Err(CoreLinkError::NoHello),
    }
}

/// Passes messages both ways until one way fails.
async fn converse(mut reader: Reader, mut writer: OwnedWriteHalf, hub: &Arc<Hub>) -> CoreLinkError {
    let mut outgoing = hub.core_connected();
    let incoming = async {
        let mut buffer = Vec::new();
        loop {
            match read_message(&mut reader, &mut buffer).await {
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

/// Writes commands in their order, and who listens whenever that changes.
async fn write_all(
    writer: &mut OwnedWriteHalf,
    outgoing: &mut mpsc::Receiver<GatewayMessage>,
    hub: &Hub,
) -> CoreLinkError {
    let mut listeners = hub.listeners();
    listeners.mark_changed();
    loop {
        let message = tokio::select! {
            Some(command) = outgoing.recv() => command,
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

async fn write_message(writer: &mut (impl AsyncWrite + Unpin), message: &impl Serialize) -> io::Result<()> {
    let body = api::encode(message);
    let mut framed = Vec::with_capacity(4 + body.len());
    framed.extend_from_slice(&(body.len() as u32).to_le_bytes());
    framed.extend_from_slice(&body);
    writer.write_all(&framed).await
}

async fn read_message(
    reader: &mut (impl AsyncRead + Unpin),
    buffer: &mut Vec<u8>,
) -> Result<CoreMessage, CoreLinkError> {
    let mut length = [0; 4];
    reader.read_exact(&mut length).await?;
    let bytes = u32::from_le_bytes(length) as usize;
    if bytes > MAX_MESSAGE_BYTES {
        return Err(DecodeError::TooLong { bytes }.into());
    }
    buffer.clear();
    buffer.shrink_to(KEPT_BUFFER_BYTES);
    buffer.resize(bytes, 0);
    reader.read_exact(buffer).await?;
    Ok(api::decode(buffer)?)
}
