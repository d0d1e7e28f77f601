//! Files as responses: streamed, with validators, and precompressed where a `.br` or `.gz` lies beside them.

use crate::byte_range::ByteRange;
use crate::limits::FIXED;
use crate::problem::ProblemResponse;
use crate::texts;
use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use futures_util::Stream;
use std::fs::Metadata;
use std::io::{self, Read, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;
use tokio::fs::File;
use tokio::io::AsyncSeekExt;

/// The client may keep the file for ever.
pub(crate) const IMMUTABLE: &str = "public, max-age=31536000, immutable";
/// The client may keep the file, but asks each time whether it has changed; the usual answer is 304.
pub(crate) const REVALIDATE: &str = "no-cache";

/// How a file is served.
pub(crate) struct FileResponseOptions<'a> {
    pub(crate) content_type: &'static str,
    pub(crate) cache_control: &'static str,
    /// Strong validator without quotes; made of time and length if `None`.
    pub(crate) etag: Option<&'a str>,
    /// Whether a client may ask for a part of it.
    pub(crate) has_ranges: bool,
}

/// The file at `path`, or `None` if there is none.
pub(crate) async fn respond(
    path: &Path,
    request: &HeaderMap,
    serving: FileResponseOptions<'_>,
) -> Result<Option<Response>, ProblemResponse> {
    let chosen = choose(path, request).await.map_err(|error| not_read(path, &error))?;
    let Some(EncodedFile { mut file, metadata, encoding }) = chosen else { return Ok(None) };
    let etag = match serving.etag {
        Some(name) => format!("\"{name}\""),
        None => validator(&metadata),
    };
    let mut response = Response::new(Body::empty());
    let headers = response.headers_mut();
    if let Ok(etag) = HeaderValue::from_str(&etag) {
        headers.insert(header::ETAG, etag);
    }
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static(serving.cache_control));
    headers.insert(header::VARY, HeaderValue::from_static("accept-encoding"));
    if is_known(request, &etag) {
        *response.status_mut() = StatusCode::NOT_MODIFIED;
        return Ok(Some(response));
    }
    let length = metadata.len();
    let range = if serving.has_ranges && encoding.is_none() {
        headers.insert(header::ACCEPT_RANGES, HeaderValue::from_static("bytes"));
        ByteRange::of(request, length, &etag)
    } else {
        ByteRange::Whole
    };
    let (first, count) = match range {
        ByteRange::Whole => (0, length),
        ByteRange::Part { first, last } => (first, last - first + 1),
        ByteRange::Unsatisfiable => return Ok(Some(unsatisfiable(length))),
    };
    if let ByteRange::Part { first, last } = range
        && let Ok(content_range) = HeaderValue::from_str(&format!("bytes {first}-{last}/{length}"))
    {
        headers.insert(header::CONTENT_RANGE, content_range);
    }
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(serving.content_type));
    headers.insert(header::CONTENT_LENGTH, HeaderValue::from(count));
    if let Some(encoding) = encoding {
        headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static(encoding));
    }
    if let ByteRange::Part { .. } = range {
        *response.status_mut() = StatusCode::PARTIAL_CONTENT;
        file.seek(SeekFrom::Start(first)).await.map_err(|error| not_read(path, &error))?;
    }
    // `take`, because a file that grows meanwhile must not outgrow the length just promised.
    *response.body_mut() = Body::from_stream(chunks(file, count).await);
    Ok(Some(response))
}

/// The next `count` bytes of a file, or fewer if it ends before; each chunk is read when the connection asks for it. A reader that reads nothing keeps no buffer of the file
/// beyond what the connection holds, which is why this is not `ReaderStream` of tokio-util: that one keeps two more chunks for each reader.
async fn chunks(file: File, count: u64) -> impl Stream<Item = io::Result<Bytes>> {
    futures_util::stream::try_unfold((file.into_std().await, count), |(file, left)| async move {
        if left == 0 {
            return Ok(None);
        }
        let read = tokio::task::spawn_blocking(move || {
            let limit = left.min(FIXED.file_chunk_bytes as u64);
            let mut chunk = Vec::with_capacity(usize::try_from(limit).unwrap_or(FIXED.file_chunk_bytes));
            (&file).take(limit).read_to_end(&mut chunk).map(|_| (Bytes::from(chunk), file))
        });
        let (chunk, file) = read.await.map_err(io::Error::other)??;
        let left = left - chunk.len() as u64;
        Ok((!chunk.is_empty()).then_some((chunk, (file, left))))
    })
}

/// A file that never changes, because it is named by its content. `name`, from a parsed id, is its strong validator; `missing`: a sentence for a file that is not there.
pub(crate) async fn respond_named(
    path: &Path,
    name: &str,
    content_type: &'static str,
    has_ranges: bool,
    request: &HeaderMap,
    missing: impl FnOnce() -> String,
) -> Result<Response, ProblemResponse> {
    let serving =
        FileResponseOptions { content_type, cache_control: IMMUTABLE, etag: Some(name), has_ranges };
    let found = respond(path, request, serving).await?;
    found.ok_or_else(|| ProblemResponse::not_found(missing()))
}

/// The answer to a request for a part that the file does not have.
fn unsatisfiable(length: u64) -> Response {
    let problem = ProblemResponse::new(StatusCode::RANGE_NOT_SATISFIABLE, texts::no_such_part(length));
    let mut response = problem.into_response();
    if let Ok(content_range) = HeaderValue::from_str(&format!("bytes */{length}")) {
        response.headers_mut().insert(header::CONTENT_RANGE, content_range);
    }
    response
}

/// The answer where a file cannot be read.
pub(crate) fn not_read(path: &Path, error: &io::Error) -> ProblemResponse {
    tracing::warn!(path = %path.display(), %error, "could not read a file");
    ProblemResponse::new(StatusCode::INTERNAL_SERVER_ERROR, texts::FILE_NOT_READ)
}

struct EncodedFile {
    file: File,
    metadata: Metadata,
    encoding: Option<&'static str>,
}

/// The smallest encoding of the file that the client accepts.
async fn choose(path: &Path, request: &HeaderMap) -> io::Result<Option<EncodedFile>> {
    for (encoding, suffix) in [("br", ".br"), ("gzip", ".gz")] {
        if accepts(request, encoding)
            && let Some((file, metadata)) = open(&with_suffix(path, suffix)).await?
        {
            return Ok(Some(EncodedFile { file, metadata, encoding: Some(encoding) }));
        }
    }
    let plain = open(path).await?;
    Ok(plain.map(|(file, metadata)| EncodedFile { file, metadata, encoding: None }))
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

/// Opens a regular file; `None` for anything else and for nothing.
async fn open(path: &Path) -> io::Result<Option<(File, Metadata)>> {
    // The kind is checked before opening, because opening a pipe would wait for its writer.
    match tokio::fs::metadata(path).await {
        Ok(metadata) if metadata.is_file() => {}
        Ok(_) => return Ok(None),
        Err(error) if is_absence(&error) => return Ok(None),
        Err(error) => return Err(error),
    }
    match File::open(path).await {
        Ok(file) => {
            let metadata = file.metadata().await?;
            Ok(Some((file, metadata)))
        }
        Err(error) if is_absence(&error) => Ok(None),
        Err(error) => Err(error),
    }
}

fn is_absence(error: &io::Error) -> bool {
    use io::ErrorKind::{InvalidFilename, NotADirectory, NotFound};
    matches!(error.kind(), NotFound | NotADirectory | InvalidFilename)
}

fn validator(metadata: &Metadata) -> String {
    let modified = metadata.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
    format!("\"{:x}-{:x}\"", modified.unwrap_or_default().as_nanos(), metadata.len())
}

/// Whether the client has this version already (RFC 9110, 13.1.2: weak comparison).
fn is_known(request: &HeaderMap, etag: &str) -> bool {
    let tags = request.get_all(header::IF_NONE_MATCH).iter().filter_map(|value| value.to_str().ok());
    tags.flat_map(|tags| tags.split(','))
        .map(str::trim)
        .any(|tag| tag == "*" || tag.strip_prefix("W/").unwrap_or(tag) == etag)
}

/// Whether `Accept-Encoding` names `encoding` with a weight above zero (RFC 9110, 12.5.3).
fn accepts(request: &HeaderMap, encoding: &str) -> bool {
    let values = request.get_all(header::ACCEPT_ENCODING).iter().filter_map(|value| value.to_str().ok());
    values.flat_map(|codings| codings.split(',')).any(|coding| {
        let mut parts = coding.split(';').map(str::trim);
        let named = parts.next().is_some_and(|name| name.eq_ignore_ascii_case(encoding));
        let weight = parts.find_map(|parameter| parameter.strip_prefix("q=")?.trim().parse::<f32>().ok());
        named && weight.unwrap_or(1.0) > 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(name: header::HeaderName, value: &'static str) -> HeaderMap {
        HeaderMap::from_iter([(name, HeaderValue::from_static(value))])
    }

    #[test]
    fn encodings_are_taken_by_name_and_weight() {
        let cases = [
            ("gzip, deflate, br", true, true),
            ("gzip;q=1.0, br;q=0", true, false),
            ("GZIP; q=0.1", true, false),
            ("identity", false, false),
            ("brx, xgzip", false, false),
        ];
        for (value, gzip, br) in cases {
            let request = with(header::ACCEPT_ENCODING, value);
            assert_eq!((accepts(&request, "gzip"), accepts(&request, "br")), (gzip, br), "{value}");
        }
    }

    #[test]
    fn known_tags_are_found_in_lists() {
        let cases = [("\"a\"", true), ("\"b\", W/\"a\"", true), ("*", true), ("\"b\"", false), ("a", false)];
        for (value, known) in cases {
            assert_eq!(is_known(&with(header::IF_NONE_MATCH, value), "\"a\""), known, "{value}");
        }
    }
}
