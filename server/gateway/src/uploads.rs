//! Files that clients send, to become maps. They are kept until the core makes something of them, and gone with it.

use crate::app::App;
use crate::limits::{MAX_UPLOAD_BYTES, MAX_UPLOADS_KEPT, UPLOAD_DISK_SPARED};
use crate::problem::ProblemResponse;
use crate::schemas::ProblemDocument;
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
    let malformed = || ProblemResponse::malformed("An upload is named by a UUID that the client makes.");
    let id: UploadId = id.ok().and_then(|Path(id)| id.parse().ok()).ok_or_else(malformed)?;
    let length = length(request.headers())?;
    let Ok(_turn) = app.uploading.try_acquire() else {
        return Err(ProblemResponse::new(
            StatusCode::TOO_MANY_REQUESTS,
            "Another file is being sent. Wait until it is here.",
        ));
    };
    let folder = app.data_dir.join("uploads");
    make_room(&folder, length).await?;
    // From the parsed id, so that the path holds hexadecimal digits and hyphens only.
    let place = folder.join(id.to_string());
    if fs::try_exists(&place).await.unwrap_or(true) {
        return Err(ProblemResponse::new(
            StatusCode::CONFLICT,
            "A file of this id is here already. Make a new one.",
        ));
    }
    let partial = Partial { path: place.with_extension("part") };
    partial.fill(request.into_body().into_data_stream(), length, app.limits.write_stall).await?;
    fs::rename(&partial.path, &place).await.map_err(|error| disk(&error))?;
    Ok(StatusCode::CREATED)
}

/// The announced length, bytes: a file that does not fit is refused before it is sent.
fn length(headers: &HeaderMap) -> Result<u64, ProblemResponse> {
    let announced = headers.get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse().ok());
    let needed = || {
        ProblemResponse::new(
            StatusCode::LENGTH_REQUIRED,
            "The length of the file is missing: send the Content-Length header.",
        )
    };
    let length: u64 = announced.ok_or_else(needed)?;
    if length > MAX_UPLOAD_BYTES {
        let most = MAX_UPLOAD_BYTES >> 30;
        let text = format!(
            "The file is larger than {most} GiB. Thin it first, or import it on the robot's computer."
        );
        return Err(ProblemResponse::new(StatusCode::PAYLOAD_TOO_LARGE, text));
    }
    Ok(length)
}

/// Checks that few files wait and that the disk has room.
async fn make_room(folder: &FilePath, length: u64) -> Result<(), ProblemResponse> {
    fs::create_dir_all(folder).await.map_err(|error| disk(&error))?;
    let mut entries = fs::read_dir(folder).await.map_err(|error| disk(&error))?;
    let mut waiting = 0;
    while let Some(entry) = entries.next_entry().await.map_err(|error| disk(&error))? {
        waiting += usize::from(entry.path().extension().is_none());
    }
    if waiting >= MAX_UPLOADS_KEPT {
        let text = format!(
            "{waiting} files wait to be imported already. Import one, or restart the platform to be rid of them."
        );
        return Err(ProblemResponse::new(StatusCode::TOO_MANY_REQUESTS, text));
    }
    let free = rustix::fs::statvfs(folder).map(|disk| disk.f_bavail * disk.f_frsize);
    let free = free.map_err(|error| disk(&io::Error::from(error)))?;
    if free < length.saturating_add(UPLOAD_DISK_SPARED) {
        let text =
            "There is too little room on the robot's disk for this file. Delete maps or recordings first.";
        return Err(ProblemResponse::new(StatusCode::INSUFFICIENT_STORAGE, text));
    }
    Ok(())
}

fn disk(error: &io::Error) -> ProblemResponse {
    tracing::warn!(%error, "a file that was sent could not be kept");
    let status = match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => StatusCode::INSUFFICIENT_STORAGE,
        _ => StatusCode::INTERNAL_SERVER_ERROR,
    };
    ProblemResponse::new(status, "The server could not write the file to its disk.")
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
        let incomplete = || ProblemResponse::malformed("The file is incomplete. Send it again.");
        let mut came = 0;
        loop {
            let next = tokio::time::timeout(stall, body.next()).await;
            let next = next.map_err(|_| {
                ProblemResponse::new(
                    StatusCode::REQUEST_TIMEOUT,
                    "No bytes came for too long. Send the file again.",
                )
            })?;
            let Some(part) = next else { break };
            let part = part.map_err(|_| incomplete())?;
            came += part.len() as u64;
            file.write_all(&part).await.map_err(|error| disk(&error))?;
        }
        file.flush().await.map_err(|error| disk(&error))?;
        if came == length { Ok(()) } else { Err(incomplete()) }
    }
}
