//! Receives uploaded files, which become maps. A file goes once the core has made a map of it; one of which no map could be made is kept for a day.

use crate::app::App;
use crate::documents::Answer;
use crate::json_response::json;
use crate::limits::FIXED;
use crate::maps::{perform, stored};
use crate::problem::ProblemResponse;
use crate::schemas::{ProblemDocument, StoredUploadDocument};
use crate::texts;
use api::Command;
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

/// Ending of the name of a file that is being received.
const PARTIAL: &str = "part";

/// Stores an uploaded file.
#[utoipa::path(put, path = api::paths::UPLOAD_PATH, tag = "maps", operation_id = "upload",
    params(("id" = String, Path, format = Uuid, description = "A new id, made by the client")),
    request_body(content_type = "application/octet-stream", description = "PCD, PLY, LAS, LAZ, E57 or PTX"),
    responses(
    (status = 201, description = "Stored; the import command makes a map of it"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id is malformed, or the file is incomplete"),
    (status = 408, body = ProblemDocument, content_type = "application/problem+json", description = "No bytes came for too long"),
    (status = 409, body = ProblemDocument, content_type = "application/problem+json", description = "The id is in use, too many files wait to be imported, or they are too large together; the detail says what to do",
        example = json!({ "status": 409, "title": "Conflict", "detail": "4 files wait to be imported already. Import or delete one of them first: GET /api/v1/uploads lists them, DELETE /api/v1/uploads/{id} deletes one, and so does the page below the saved maps." })),
    (status = 411, body = ProblemDocument, content_type = "application/problem+json", description = "The Content-Length header is missing"),
    (status = 413, body = ProblemDocument, content_type = "application/problem+json", description = "Too large"),
    (status = 429, body = ProblemDocument, content_type = "application/problem+json", description = "Another file is being sent"),
    (status = 507, body = ProblemDocument, content_type = "application/problem+json", description = "The disk is nearly full; the detail says what to do"),
))]
pub(crate) async fn put(
    State(app): State<Arc<App>>,
    id: Result<Path<String>, PathRejection>,
    request: Request,
) -> Result<StatusCode, ProblemResponse> {
    let id = upload_id(id)?;
    let length = length(request.headers())?;
    let Ok(_turn) = app.uploading.try_acquire() else {
        return Err(ProblemResponse::new(StatusCode::TOO_MANY_REQUESTS, texts::UPLOAD_BUSY));
    };
    let folder = app.data_dir.join("uploads");
    check_quota(&folder, length, app.limits.uploads_bytes).await?;
    // From the parsed id, so that the path holds hexadecimal digits and hyphens only.
    let place = folder.join(id.to_string());
    if fs::try_exists(&place).await.unwrap_or(true) {
        return Err(ProblemResponse::new(StatusCode::CONFLICT, texts::UPLOAD_EXISTS));
    }
    let partial = Partial { path: place.with_extension(PARTIAL) };
    partial.fill(request.into_body().into_data_stream(), length, app.limits.write_stall).await?;
    fs::rename(&partial.path, &place).await.map_err(|error| disk(&error))?;
    let synced = async { File::open(&folder).await?.sync_all().await };
    synced.await.map_err(|error| disk(&error))?;
    Ok(StatusCode::CREATED)
}

/// Uploaded files that no map was made of yet.
#[utoipa::path(get, path = api::paths::UPLOADS_PATH, tag = "maps", operation_id = "listUploads", responses(
    (status = 200, body = [StoredUploadDocument], description = "Files that wait to be imported, or to be imported again after a failure; the oldest first. The list is made at each import and each hour"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not sent its lists yet"),
))]
pub(crate) async fn list(State(app): State<Arc<App>>) -> Answer {
    stored(&app, |data| Some(json(data.uploads?)))
}

/// Deletes an uploaded file.
#[utoipa::path(delete, path = api::paths::UPLOAD_PATH, tag = "maps", operation_id = "deleteUpload",
    params(("id" = String, Path, format = Uuid, description = "Its id")),
    responses(
    (status = 204, description = "It is gone"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The id is malformed"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such file"),
    (status = 409, body = ProblemDocument, content_type = "application/problem+json", description = "It is being imported"),
    (status = 503, body = ProblemDocument, content_type = "application/problem+json", description = "The core is not connected"),
    (status = 504, body = ProblemDocument, content_type = "application/problem+json", description = "The core has not answered yet"),
))]
pub(crate) async fn delete(
    State(app): State<Arc<App>>,
    id: Result<Path<String>, PathRejection>,
) -> Result<StatusCode, ProblemResponse> {
    let id = upload_id(id)?;
    // From the parsed id, so that the path holds hexadecimal digits and hyphens only.
    if !fs::try_exists(app.data_dir.join("uploads").join(id.to_string())).await.unwrap_or(false) {
        return Err(ProblemResponse::not_found(texts::no_upload(id)));
    }
    perform(&app, Command::DeleteUpload(id)).await?;
    Ok(StatusCode::NO_CONTENT)
}

/// The upload that a path names.
fn upload_id(id: Result<Path<String>, PathRejection>) -> Result<UploadId, ProblemResponse> {
    let malformed = || ProblemResponse::malformed(texts::UPLOAD_ID_MALFORMED);
    id.ok().and_then(|Path(id)| id.parse().ok()).ok_or_else(malformed)
}

/// Removes files that an earlier gateway was receiving when it ended. To be called before a client can send one.
pub(crate) async fn remove_partial(data_dir: &FilePath) {
    let Ok(mut entries) = fs::read_dir(data_dir.join("uploads")).await else { return };
    while let Ok(Some(entry)) = entries.next_entry().await {
        if entry.path().extension().is_some_and(|ending| ending == PARTIAL)
            && let Err(error) = fs::remove_file(entry.path()).await
        {
            tracing::warn!(%error, "a file that was not received whole could not be removed");
        }
    }
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

/// Checks that not too many files wait, that they are not too large together, and that the disk has enough space.
async fn check_quota(folder: &FilePath, length: u64, max_bytes: u64) -> Result<(), ProblemResponse> {
    fs::create_dir_all(folder).await.map_err(|error| disk(&error))?;
    let mut entries = fs::read_dir(folder).await.map_err(|error| disk(&error))?;
    let (mut waiting, mut bytes) = (0, 0_u64);
    while let Some(entry) = entries.next_entry().await.map_err(|error| disk(&error))? {
        if entry.path().extension().is_none() {
            waiting += 1;
            // A file that has gone meanwhile takes nothing.
            bytes += entry.metadata().await.map_or(0, |about| about.len());
        }
    }
    let full = |text| Err(ProblemResponse::new(StatusCode::CONFLICT, text));
    if waiting >= FIXED.max_uploads_kept {
        return full(texts::too_many_uploads(waiting));
    }
    if bytes.saturating_add(length) > max_bytes {
        return full(texts::uploads_too_large(bytes, max_bytes));
    }
    check_space(folder, length)
}

/// Checks that the disk has space for this number of bytes, and for recordings.
fn check_space(folder: &FilePath, length: u64) -> Result<(), ProblemResponse> {
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
        let (mut received, mut checked) = (0, 0);
        loop {
            let next = tokio::time::timeout(stall, body.next()).await;
            let stalled = |_| ProblemResponse::new(StatusCode::REQUEST_TIMEOUT, texts::UPLOAD_STALLED);
            let next = next.map_err(stalled)?;
            let Some(part) = next else { break };
            let part = part.map_err(|_| incomplete())?;
            received += part.len() as u64;
            if received - checked >= FIXED.space_check_bytes {
                checked = received;
                check_space(&self.path, length.saturating_sub(received))?;
            }
            file.write_all(&part).await.map_err(|error| disk(&error))?;
        }
        file.flush().await.map_err(|error| disk(&error))?;
        if received != length {
            return Err(incomplete());
        }
        file.sync_all().await.map_err(|error| disk(&error))
    }
}
