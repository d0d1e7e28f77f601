//! A file that is made while it is sent, from what the core has stored. Memory holds a few chunks of it.

use super::stored_content::CoreQueries;
use crate::access::{current_caller, on_behalf_of};
use crate::app::App;
use crate::limits::FIXED;
use crate::problem::ProblemResponse;
use crate::site::ask;
use crate::texts;
use api::{Caller, Query, QueryReply};
use axum::body::{Body, Bytes};
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use std::io::{self, Write};
use std::sync::Arc;
use tokio::runtime::Handle;
use tokio::sync::{OwnedSemaphorePermit, mpsc};

/// The right to send one such file. Few are sent at a time.
pub(crate) struct FileStream {
    app: Arc<App>,
    /// Who downloads it.
    caller: Caller,
    permit: OwnedSemaphorePermit,
}

impl FileStream {
    /// Takes the right to send a file.
    ///
    /// # Errors
    /// When too many are on their way.
    pub(crate) fn begin(app: &Arc<App>) -> Result<Self, ProblemResponse> {
        let caller = current_caller().map_err(ProblemResponse::unavailable)?;
        let busy = |_| ProblemResponse::unavailable(texts::DOWNLOADS_BUSY);
        let permit = app.downloading.clone().try_acquire_owned().map_err(busy)?;
        Ok(Self { app: app.clone(), caller, permit })
    }

    /// The response with the file that `write` makes, in a thread that may wait. It ends early, with an error of the connection, if `write` fails.
    pub(crate) fn send(
        self,
        content_type: &'static str,
        name: &str,
        write: impl FnOnce(&dyn CoreQueries, ChunkSink) -> io::Result<()> + Send + 'static,
    ) -> Response {
        let (chunks, receiver) = mpsc::channel(FIXED.max_download_chunks);
        let runtime = Handle::current();
        let Self { app, caller, permit } = self;
        tokio::task::spawn_blocking({
            let name = name.to_owned();
            move || {
                let _permit = permit;
                let core = AskedCore { app, caller, runtime: runtime.clone() };
                let sink = ChunkSink::new(chunks.clone(), runtime.clone());
                if let Err(error) = write(&core, sink) {
                    tracing::warn!(%name, %error, "a file could not be sent as a whole");
                    // The connection ends with an error, so that nobody takes the part for the whole. A client that has gone needs none.
                    let failure = chunks.send(Err(error));
                    let _ = runtime.block_on(tokio::time::timeout(FIXED.max_download_stall, failure));
                }
            }
        });
        let stream = futures_util::stream::unfold(receiver, |mut receiver| async {
            let chunk = receiver.recv().await?;
            Some((chunk, receiver))
        });
        let mut response: Response = Body::from_stream(stream).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(content_type));
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
        if let Ok(disposition) = HeaderValue::from_str(&format!("attachment; filename=\"{name}\"")) {
            headers.insert(header::CONTENT_DISPOSITION, disposition);
        }
        response
    }
}

/// The core, asked from a thread that may wait.
struct AskedCore {
    app: Arc<App>,
    /// Who downloads the file.
    caller: Caller,
    runtime: Handle,
}

impl CoreQueries for AskedCore {
    fn ask(&self, query: Query) -> io::Result<QueryReply> {
        let reply = self.runtime.block_on(on_behalf_of(self.caller, ask(&self.app, query)));
        reply.map_err(|problem| io::Error::other(problem.detail().to_owned()))
    }
}

/// Hands what is written to the response in chunks, and waits while the client does not read.
pub(crate) struct ChunkSink {
    chunks: mpsc::Sender<io::Result<Bytes>>,
    runtime: Handle,
    chunk: Vec<u8>,
    /// After a failure the writer of a file may still close it: that goes nowhere.
    has_failed: bool,
}

impl ChunkSink {
    fn new(chunks: mpsc::Sender<io::Result<Bytes>>, runtime: Handle) -> Self {
        Self { chunks, runtime, chunk: Vec::new(), has_failed: false }
    }
}

impl Write for ChunkSink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let room = FIXED.file_chunk_bytes.saturating_sub(self.chunk.len());
        let taken = bytes.len().min(room);
        self.chunk.extend_from_slice(&bytes[..taken]);
        if self.chunk.len() >= FIXED.file_chunk_bytes {
            self.flush()?;
        }
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        let chunk = Bytes::from(std::mem::take(&mut self.chunk));
        if self.has_failed || chunk.is_empty() {
            return Ok(());
        }
        let sent = tokio::time::timeout(FIXED.max_download_stall, self.chunks.send(Ok(chunk)));
        let sent = self.runtime.block_on(sent);
        self.has_failed = !matches!(sent, Ok(Ok(())));
        if self.has_failed { Err(io::Error::other(texts::DOWNLOAD_STALLED)) } else { Ok(()) }
    }
}
