//! The certificate authority of this robot for people who have to trust it: its certificate, the fingerprint to compare, and a code that leads a phone here. They are
//! shown over plain http too, because a browser that does not trust the authority yet shows nothing else without a warning.

use super::authority::Authority;
use crate::access::texts;
use crate::app::App;
use crate::documents::Answer;
use crate::json_response::json;
use crate::problem::ProblemResponse;
use crate::schemas::ProblemDocument;
use axum::extract::State;
use axum::http::{HeaderMap, header};
use axum::response::IntoResponse;
use qrcode::QrCode;
use qrcode::render::svg;
use ring::digest::{SHA256, digest};
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;
use tokio_rustls::rustls::pki_types::CertificateDer;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use utoipa::ToSchema;

/// The page that explains it, and what it loads.
const PAGE: [&str; 5] = ["/trust.html", "/trust.js", "/look.css", "/people.css", "/icons/autoinspect.svg"];

/// What is answered over plain http although the server speaks TLS: what says nothing about the robot.
const INTERFACE: [&str; 4] = [
    api::paths::AUTHORITY_PATH,
    api::paths::AUTHORITY_CERTIFICATE_PATH,
    api::paths::TRUST_CODE_PATH,
    api::paths::HEALTH_PATH,
];

/// Whether a path is answered over plain http although the server speaks TLS.
pub(crate) fn is_shown_without_tls(path: &str) -> bool {
    PAGE.contains(&path) || INTERFACE.contains(&path)
}

/// The certificate authority of this robot.
#[derive(Serialize, ToSchema)]
#[schema(as = Authority)]
pub(crate) struct AuthorityDocument {
    /// SHA-256 of its certificate, hexadecimal, in pairs with colons between them, as browsers and systems show it.
    sha256: String,
}

fn authority(app: &App) -> Result<&Authority, ProblemResponse> {
    let authority = app.encryption.as_ref().and_then(super::Encryption::authority);
    authority.ok_or_else(|| ProblemResponse::not_found(texts::NO_AUTHORITY))
}

/// The fingerprint of the robot's own certificate authority.
#[utoipa::path(get, path = api::paths::AUTHORITY_PATH, tag = "access", operation_id = "getAuthority",
    responses(
        (status = 200, body = AuthorityDocument, description = "The fingerprint"),
        (status = 404, body = ProblemDocument, description = "The server has no authority of its own", content_type = "application/problem+json"),
    ))]
pub(crate) async fn about(State(app): State<Arc<App>>) -> Answer {
    let sha256 = fingerprint(authority(&app)?.certificate_der());
    Ok(json(AuthorityDocument { sha256 }))
}

/// The certificate of the robot's own authority, to be trusted by browsers and programs.
#[utoipa::path(get, path = api::paths::AUTHORITY_CERTIFICATE_PATH, tag = "access", operation_id = "getAuthorityCertificate",
    responses(
        (status = 200, body = String, description = "The certificate in PEM format", content_type = "application/x-x509-ca-cert"),
        (status = 404, body = ProblemDocument, description = "The server has no authority of its own", content_type = "application/problem+json"),
    ))]
pub(crate) async fn certificate(State(app): State<Arc<App>>) -> Answer {
    let head = [
        (header::CONTENT_TYPE, "application/x-x509-ca-cert"),
        (header::CONTENT_DISPOSITION, "attachment; filename=\"autoinspect-authority.crt\""),
        (header::CACHE_CONTROL, "no-cache"),
    ];
    Ok((head, authority(&app)?.certificate_pem().to_owned()).into_response())
}

/// A QR code of the address of the page that explains how to trust the authority.
#[utoipa::path(get, path = api::paths::TRUST_CODE_PATH, tag = "access", operation_id = "getTrustCode",
    responses(
        (status = 200, body = String, description = "The code as a picture", content_type = "image/svg+xml"),
        (status = 404, body = ProblemDocument, description = "The server has no authority of its own", content_type = "application/problem+json"),
    ))]
pub(crate) async fn code(State(app): State<Arc<App>>, headers: HeaderMap) -> Answer {
    authority(&app)?;
    // It was checked to be a name of this server.
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or_default();
    let code = QrCode::new(format!("http://{host}/trust.html"))
        .map_err(|_| ProblemResponse::malformed(texts::UNKNOWN_HOST))?;
    let picture = code.render::<svg::Color<'_>>().min_dimensions(200, 200).build();
    let head = [(header::CONTENT_TYPE, "image/svg+xml"), (header::CACHE_CONTROL, "no-cache")];
    Ok((head, picture).into_response())
}

/// SHA-256 of a certificate, as browsers show it.
pub(crate) fn fingerprint(certificate: &[u8]) -> String {
    let pairs: Vec<_> =
        digest(&SHA256, certificate).as_ref().iter().map(|byte| format!("{byte:02X}")).collect();
    pairs.join(":")
}

/// SHA-256 of the certificate of the authority in this folder, as browsers show it; `None` while there is none.
pub fn authority_fingerprint(folder: &Path) -> Option<String> {
    let certificate = CertificateDer::from_pem_file(folder.join("authority.pem")).ok()?;
    Some(fingerprint(&certificate))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fingerprint_is_in_pairs_with_colons() {
        let text = fingerprint(b"abc");
        // FIPS 180-4, example of SHA-256.
        assert!(text.starts_with("BA:78:16:BF:8F:01:CF:EA:41:41:40:DE"), "{text}");
        assert_eq!(text.len(), 32 * 3 - 1);
    }
}
