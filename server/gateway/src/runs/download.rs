//! A run with all that it has gathered, as one ZIP archive. It is made while it is sent, so memory holds a few chunks and one page of results.

use super::archive::{Archive, CoreQueries};
use super::run_id;
use crate::access::{current_caller, on_behalf_of};
use crate::app::App;
use crate::documents::{Answer, AnyPath};
use crate::limits::FIXED;
use crate::problem::ProblemResponse;
use crate::problem_schemas::QueryProblems;
use crate::schemas::ProblemDocument;
use crate::site::ask;
use crate::texts;
use api::{Caller, Query, QueryReply};
use axum::body::{Body, Bytes};
use axum::extract::State;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use std::io::{self, Write};
use std::sync::Arc;
use tokio::runtime::Handle;
use tokio::sync::mpsc;

/// All of a run: its record, attempts, results, readings as a table, and files.
#[utoipa::path(get, path = api::paths::RUN_DOWNLOAD_PATH, tag = "missions", operation_id = "downloadRun",
    params(("run" = String, Path, format = Uuid, description = "The run's id")),
    responses(
        (status = 200, content_type = "application/zip", description = "A ZIP archive: run.json, steps.json, results.json, readings.csv and files/. It ends early, with an error of the connection, if the core or the disk fails meanwhile"),
        (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such run"),
        QueryProblems
    ))]
pub(crate) async fn download(State(app): State<Arc<App>>, run: AnyPath) -> Answer {
    let run = run_id(run)?;
    let caller = current_caller().map_err(ProblemResponse::unavailable)?;
    let busy = |_| ProblemResponse::unavailable(texts::DOWNLOADS_BUSY);
    let permit = app.downloading.clone().try_acquire_owned().map_err(busy)?;
    let QueryReply::Runs(found) = ask(&app, Query::Run(run)).await? else {
        return Err(ProblemResponse::unavailable(texts::CORE_LOST_BEFORE_ANSWER));
    };
    let stored = found.into_iter().next().ok_or_else(|| ProblemResponse::not_found(texts::no_run(run)))?;
    let site = app.hub.site();
    let archive = Archive::new(stored, site, &app.data_dir);
    let disposition = format!("attachment; filename=\"{}.zip\"", archive.name());
    let (chunks, receiver) = mpsc::channel(FIXED.max_download_chunks);
    let runtime = Handle::current();
    tokio::task::spawn_blocking(move || {
        let _permit = permit;
        let core = AskedCore { app, caller, runtime: runtime.clone() };
        let sink = ChunkSink {
            chunks: chunks.clone(),
            runtime: runtime.clone(),
            chunk: Vec::new(),
            has_failed: false,
        };
        if let Err(error) = archive.write(&core, sink) {
            tracing::warn!(%run, %error, "a run could not be sent as a whole");
            // The connection ends with an error, so that nobody takes the part for the whole. A client that has gone needs none.
            let failure = chunks.send(Err(error));
            let _ = runtime.block_on(tokio::time::timeout(FIXED.max_download_stall, failure));
        }
    });
    let stream = futures_util::stream::unfold(receiver, |mut receiver| async {
        let chunk = receiver.recv().await?;
        Some((chunk, receiver))
    });
    let mut response: Response = Body::from_stream(stream).into_response();
    let headers = response.headers_mut();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/zip"));
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    if let Ok(disposition) = HeaderValue::from_str(&disposition) {
        headers.insert(header::CONTENT_DISPOSITION, disposition);
    }
    Ok(response)
}

/// The core, asked from a thread that may wait.
struct AskedCore {
    app: Arc<App>,
    /// Who downloads the run.
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
struct ChunkSink {
    chunks: mpsc::Sender<io::Result<Bytes>>,
    runtime: Handle,
    chunk: Vec<u8>,
    /// After a failure the writer of the archive still closes it: that goes nowhere.
    has_failed: bool,
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
