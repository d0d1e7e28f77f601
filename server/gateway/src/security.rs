//! Which pages may open a socket, and what a page of this server may do.

use axum::http::{HeaderMap, HeaderName, HeaderValue, header};
use axum::response::Response;

/// The page loads scripts, workers and data from this server only. WASM needs `wasm-unsafe-eval`; workers may start from
/// blobs; the canvas library sets styles on elements; no page may frame this one to lure clicks onto the robot's controls.
const CONTENT_SECURITY_POLICY: &str = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; \
    worker-src 'self' blob:; connect-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; \
    font-src 'self' data:; manifest-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Headers on every response.
const HEADERS: [(HeaderName, &str); 6] = [
    (header::CONTENT_SECURITY_POLICY, CONTENT_SECURITY_POLICY),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::X_FRAME_OPTIONS, "DENY"),
    (header::REFERRER_POLICY, "no-referrer"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
];

/// Browsers use TLS only for a year, where the site's own certificate is served (RFC 6797).
pub(crate) const TLS_ONLY: &str = "max-age=31536000";

/// Adds [`HEADERS`]. A document with a content security policy of its own, such as a report, keeps it.
pub(crate) async fn add_headers(mut response: Response) -> Response {
    let headers = response.headers_mut();
    let own_policy = headers.get(header::CONTENT_SECURITY_POLICY).cloned();
    for (name, value) in HEADERS {
        headers.insert(name, HeaderValue::from_static(value));
    }
    if let Some(policy) = own_policy {
        headers.insert(header::CONTENT_SECURITY_POLICY, policy);
    }
    response
}

/// Whether a request comes from a page of this server, or from a program, which sends no `Origin`. The host was checked before.
pub(crate) fn is_same_origin(headers: &HeaderMap, is_tls: bool) -> bool {
    let mut origins = headers.get_all(header::ORIGIN).iter();
    let (origin, more) = (origins.next(), origins.next());
    let Some(origin) = origin else { return true };
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok());
    let scheme = if is_tls { "https://" } else { "http://" };
    let authority = origin.to_str().ok().and_then(|origin| origin.strip_prefix(scheme));
    match (authority, host, more) {
        (Some(authority), Some(host), None) => !host.is_empty() && authority.eq_ignore_ascii_case(host),
        _ => false,
    }
}

/// Whether a browser says that a page of another site makes this request.
pub(crate) fn is_cross_site(headers: &HeaderMap) -> bool {
    let site = HeaderName::from_static("sec-fetch-site");
    headers.get_all(site).iter().any(|site| !matches!(site.as_bytes(), b"same-origin" | b"none"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn origins_are_compared_with_the_host() {
        let cases = [
            (vec![], Some("robot:8080"), true),
            (vec!["http://robot:8080"], Some("robot:8080"), true),
            (vec!["http://ROBOT"], Some("robot"), true),
            (vec!["https://robot"], Some("robot"), false),
            (vec!["http://[::1]:8080"], Some("[::1]:8080"), true),
            (vec!["http://robot"], Some("robot:8080"), false),
            (vec!["http://evil.example"], Some("robot:8080"), false),
            (vec!["http://robot:8080.evil.example"], Some("robot:8080"), false),
            (vec!["null"], Some("robot:8080"), false),
            (vec!["http://robot:8080"], None, false),
            (vec!["http://"], Some(""), false),
            (vec!["http://robot:8080", "http://evil.example"], Some("robot:8080"), false),
        ];
        for (origins, host, same) in cases {
            let mut headers = HeaderMap::new();
            for origin in &origins {
                headers.append(header::ORIGIN, HeaderValue::from_static(origin));
            }
            if let Some(host) = host {
                headers.insert(header::HOST, HeaderValue::from_static(host));
            }
            assert_eq!(is_same_origin(&headers, false), same, "{origins:?} {host:?}");
        }
    }
}
