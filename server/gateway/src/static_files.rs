//! The client's own files: the page and what it loads.

use crate::app::App;
use crate::files::{FileResponseOptions, IMMUTABLE, REVALIDATE, respond};
use crate::problem::ProblemResponse;
use crate::texts;
use axum::extract::State;
use axum::http::{HeaderMap, Method, StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Hexadecimal digits in a row that make a file's name a content hash.
const HASH_DIGITS: usize = 16;

/// Answers everything that no other route answers.
pub(crate) async fn serve(
    State(app): State<Arc<App>>,
    method: Method,
    uri: Uri,
    headers: HeaderMap,
) -> Result<Response, ProblemResponse> {
    let path = uri.path();
    if path == "/api" || path.starts_with("/api/") {
        return Err(ProblemResponse::not_found(texts::no_path(path)));
    }
    if method != Method::GET && method != Method::HEAD {
        let problem = ProblemResponse::new(StatusCode::METHOD_NOT_ALLOWED, texts::FILES_ARE_READ_ONLY);
        return Ok(([("allow", "GET, HEAD")], problem).into_response());
    }
    let missing = || ProblemResponse::not_found(texts::no_file(path));
    let file = locate(&app.static_dir, path).ok_or_else(missing)?;
    let name = file.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let serving = FileResponseOptions {
        content_type: content_type(name),
        cache_control: if path.starts_with("/pkg/") && is_content_named(name) {
            IMMUTABLE
        } else {
            REVALIDATE
        },
        etag: None,
        has_ranges: false,
    };
    match respond(&file, &headers, serving).await? {
        Some(response) => Ok(response),
        None if path == "/" => Err(ProblemResponse::not_found(texts::PAGE_NOT_INSTALLED)),
        None => Err(missing()),
    }
}

/// The file that a URL path names. Only plain names are followed: nothing encoded, hidden or relative, so no path leads
/// out of the folder.
fn locate(static_dir: &Path, url_path: &str) -> Option<PathBuf> {
    let relative = match url_path.strip_prefix('/')? {
        "" => "index.html",
        relative => relative,
    };
    let mut file = static_dir.to_owned();
    for name in relative.split('/') {
        let plain = name.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'-' | b'_'));
        if !plain || name.is_empty() || name.starts_with('.') {
            return None;
        }
        file.push(name);
    }
    Some(file)
}

/// Whether the name changes whenever the content does.
fn is_content_named(name: &str) -> bool {
    name.split(|c: char| !c.is_ascii_hexdigit()).any(|run| run.len() >= HASH_DIGITS)
}

fn content_type(name: &str) -> &'static str {
    match name.rsplit('.').next() {
        Some("html") => "text/html; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("js" | "mjs") => "text/javascript; charset=utf-8",
        Some("wasm") => "application/wasm",
        Some("json") => "application/json",
        Some("webmanifest") => "application/manifest+json",
        Some("svg") => "image/svg+xml",
        Some("png") => "image/png",
        Some("ico") => "image/x-icon",
        Some("woff2") => "font/woff2",
        Some("ttf") => "font/ttf",
        Some("txt") => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::path::Component;

    #[test]
    fn only_names_with_a_hash_are_for_ever() {
        assert!(is_content_named("autoinspect_client-0123456789abcdef_bg.wasm"));
        assert!(is_content_named("autoinspect_client-0123456789abcdef.js"));
        assert!(!is_content_named("autoinspect_client_bg.wasm"));
        assert!(!is_content_named("manifest.json"));
    }

    proptest! {
        #[test]
        fn no_path_leads_out(path in "(/|\\.|%2e|%2f|\\\\|[a-c]|\\x00|~){0,24}") {
            let root = Path::new("/root");
            if let Some(file) = locate(root, &format!("/{path}")) {
                let inside = file.strip_prefix(root);
                prop_assert!(inside.is_ok());
                for component in file.components().skip(2) {
                    prop_assert!(matches!(component, Component::Normal(_)), "{file:?}");
                }
            }
        }
    }
}
