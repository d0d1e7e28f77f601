//! Files that actions have gathered, over HTTP: pictures, spectra, point clouds. Their names are the BLAKE3 of their bytes, so they never change.

use crate::app::App;
use crate::documents::{Answer, AnyPath, OCTETS};
use crate::files::respond_named;
use crate::problem::ProblemResponse;
use crate::schemas::ProblemDocument;
use crate::texts;
use axum::extract::{Path as UrlPath, State};
use axum::http::HeaderMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tokio::fs::File;
use tokio::io::AsyncReadExt;
use vocab::BlobHash;

/// First bytes of the kinds of files that actions gather, and what they are. Nothing that a browser would run is among them.
const KINDS: [(&[u8], &str); 4] = [
    (b"\xff\xd8\xff", "image/jpeg"),
    (b"\x89PNG\r\n\x1a\n", "image/png"),
    (b"# .PCD", "application/vnd.pcd"),
    (b"{", "application/json"),
];
/// Bytes that are looked at.
const KIND_BYTES: usize = 8;

/// A file that an action has gathered.
#[utoipa::path(get, path = api::paths::BLOB_PATH, tag = "runs", operation_id = "getBlob",
    params(
        ("hash" = String, Path, description = "BLAKE3 of the file's bytes, 64 hexadecimal digits, as the result of an action names it"),
        ("Range" = Option<String>, Header, description = "One range of bytes, such as `bytes=0-1023`"),
    ),
    responses(
    (status = 200, content_type = "image/jpeg", description = "Its bytes, with the type that they have: image/jpeg, image/png, application/json, application/vnd.pcd or application/octet-stream; they never change"),
    (status = 206, content_type = "image/jpeg", description = "The part of its bytes that was asked for"),
    (status = 304, description = "Unchanged since the client's copy"),
    (status = 400, body = ProblemDocument, content_type = "application/problem+json", description = "The hash is malformed"),
    (status = 404, body = ProblemDocument, content_type = "application/problem+json", description = "No such file"),
    (status = 416, body = ProblemDocument, content_type = "application/problem+json", description = "The file has no such part; `Content-Range` says how long it is"),
))]
pub(crate) async fn blob(State(app): State<Arc<App>>, hash: AnyPath, headers: HeaderMap) -> Answer {
    let name = file_name(hash.ok().map(|UrlPath(text)| text))?;
    let file = blob_path(&app.data_dir, &name);
    let content_type = kind(&file).await.unwrap_or(OCTETS);
    respond_named(&file, &name, content_type, true, &headers, || texts::no_blob(&name)).await
}

/// Where the file of a hash is, of 64 hexadecimal digits.
pub(crate) fn blob_path(data_dir: &Path, hash: &str) -> PathBuf {
    data_dir.join("blobs").join(hash.get(..2).unwrap_or_default()).join(hash)
}

/// Name of the file of a hash. It is made from the parsed hash, so that a path holds hexadecimal digits only.
///
/// # Errors
/// When the text is no hash.
pub(crate) fn file_name(hash: Option<String>) -> Result<String, ProblemResponse> {
    let hash: Option<BlobHash> = hash.and_then(|text| text.parse().ok());
    let malformed = || ProblemResponse::malformed(texts::BLOB_HASH_MALFORMED);
    hash.map(|hash| hash.to_string()).ok_or_else(malformed)
}

/// What a file is, by its first bytes.
async fn kind(path: &Path) -> io::Result<&'static str> {
    // A directory or a pipe is no file, and is not opened.
    if !tokio::fs::metadata(path).await?.is_file() {
        return Ok(OCTETS);
    }
    let mut start = Vec::new();
    File::open(path).await?.take(KIND_BYTES as u64).read_to_end(&mut start).await?;
    let known = KINDS.into_iter().find(|(first, _)| start.starts_with(first));
    Ok(known.map_or(OCTETS, |(_, kind)| kind))
}
