//! Uploaded files, which become maps. Each is stored until the core has imported it.

use crate::app::App;
use crate::limits::FIXED;
use crate::problem::ProblemResponse;
use crate::schemas::ProblemDocument;
use crate::texts;
use axum::body::BodyDataStream;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use futures_util::StreamExt;
use std::io;
use std::path::{Path as FilePath, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use tokio::fs::{self, File};
use tokio::io::AsyncWriteExt;
use vocab::UploadId;

/// Stores an uploaded file.
#[utoipa::path(put, path = api::paths::UPLOAD_PATH, tag = "maps", operation_id = "upload",
    params(("id" = String, Path, format = Uuid, description = "A new id, made by the client")),
    request_body(content_type = "application/octet-stream", description = "PCD, PLY, LAS, LAZ, E57 or PTX"),
    responses(
    (status = 201, description = "Stored; the import command makes a map of it"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id is malformed, or the file is incomplete"),
    (status = 408, body = ProblemDocument, content_type = "application/problem+json", description = "No bytes came for too long"),
    (status = 409, body = ProblemDocument, content_type = "application/problem+json", description = "The id is in use"),
    (status = 411, body = ProblemDocument, content_type = "application/problem+json", description = "The Content-Length header is missing"),
    (status = 413, body = ProblemDocument, content_type = "application/problem+json", description = "Too large"),
    (status = 429, body = ProblemDocument, content_type = "application/problem+json", description = "Too many files wait"),
    (status = 507, body = ProblemDocument, content_type = "application/problem+json", description = "The disk is full"),
))]
pub(crate) async fn put(
    State(app): State<Arc<App>>,
    id: Result<Path<String>, PathRejection>,
    request: Request,
) -> Result<StatusCode, ProblemResponse> {
    let malformed = || ProblemResponse::malformed(texts::UPLOAD_ID_MALFORMED);
    let id: UploadId = id.ok().and_then(|Path(id)| id.parse().ok()).ok_or_else(malformed)?;
    let length = length(request.headers())?;
    let Ok(_turn) = app.uploading.try_acquire() else {
        return Err(ProblemResponse::new(StatusCode::TOO_MANY_REQUESTS, texts::UPLOAD_BUSY));
    };
    let folder = app.data_dir.join("uploads");
    check_space(&folder, length).await?;
    // From the parsed id, so that the path holds hexadecimal digits and hyphens only.
    let place = folder.join(id.to_string());
    if fs::try_exists(&place).await.unwrap_or(true) {
        return Err(ProblemResponse::new(StatusCode::CONFLICT, texts::UPLOAD_EXISTS));
    }
    let partial = Partial { path: place.with_extension("part") };
    partial.fill(request.into_body().into_data_stream(), length, app.limits.write_stall).await?;
    fs::rename(&partial.path, &place).await.map_err(|error| disk(&error))?;
    Ok(StatusCode::CREATED)
}

/// The announced length, bytes: a file that does not fit is refused before it is sent.
fn length(headers: &HeaderMap) -> Result<u64, ProblemResponse> {
    let announced = headers.get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse().ok());
    let needed = || ProblemResponse::new(StatusCode::LENGTH_REQUIRED, texts::LENGTH_MISSING);
    let length: u64 = announced.ok_or_else(needed)?;
    if length > FIXED.max_upload_bytes {
        let text = texts::upload_too_large(FIXED.max_upload_bytes >> 30);
        return Err(ProblemResponse::new(StatusCode::PAYLOAD_TOO_LARGE, text));
    }
    Ok(length)
}

/// Checks that not too many files wait and that the disk has enough space.
async fn check_space(folder: &FilePath, length: u64) -> Result<(), ProblemResponse> {
    fs::create_dir_all(folder).await.map_err(|error| disk(&error))?;
    let mut entries = fs::read_dir(folder).await.map_err(|error| disk(&error))?;
    let mut waiting = 0;
    while let Some(entry) = entries.next_entry().await.map_err(|error| disk(&error))? {
        waiting += usize::from(entry.path().extension().is_none());
    }
    if waiting >= FIXED.max_uploads_kept {
        let text = texts::too_many_uploads(waiting);
        return Err(ProblemResponse::new(StatusCode::TOO_MANY_REQUESTS, text));
    }
    let free = rustix::fs::statvfs(folder).map(|disk| disk.f_bavail * disk.f_frsize);
    let free = free.map_err(|error| disk(&io::Error::from(error)))?;
    if free < length.saturating_add(api::DISK_RESERVE_BYTES) {
        return Err(ProblemResponse::new(StatusCode::INSUFFICIENT_STORAGE, texts::DISK_TOO_FULL));
    }
    Ok(())
}

fn disk(error: &io::Error) -> ProblemResponse {
    tracing::warn!(%error, "a file that was sent could not be kept");
    let status = match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => StatusCode::INSUFFICIENT_STORAGE,
        _ => StatusCode::INTERNAL_SERVER_ERROR,
    };
    ProblemResponse::new(status, texts::FILE_NOT_WRITTEN)
}

/// A file that is being received; removed when dropped before it is complete.
struct Partial {
    path: PathBuf,
}

impl Drop for Partial {
    fn drop(&mut self) {
        // A complete file has been renamed.
        let _ = std::fs::remove_file(&self.path);
    }
}

impl Partial {
    async fn fill(
        &self,
        mut body: BodyDataStream,
        length: u64,
        stall: Duration,
    ) -> Result<(), ProblemResponse> {
        let mut file = File::create(&self.path).await.map_err(|error| disk(&error))?;
        let incomplete = || ProblemResponse::malformed(texts::UPLOAD_INCOMPLETE);
        let mut received = 0;
        loop {
            let next = tokio::time::timeout(stall, body.next()).await;
            let stalled = |_| ProblemResponse::new(StatusCode::REQUEST_TIMEOUT, texts::UPLOAD_STALLED);
            let next = next.map_err(stalled)?;
            let Some(part) = next else { break };
            let part = part.map_err(|_| incomplete())?;
            received += part.len() as u64;
            file.write_all(&part).await.map_err(|error| disk(&error))?;
        }
        file.flush().await.map_err(|error| disk(&error))?;
        if received == length { Ok(()) } else { Err(incomplete()) }
    }
}
