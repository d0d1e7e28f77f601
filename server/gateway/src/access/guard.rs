//! What stands before every handler: the name of the server, the origin of the page, and the privilege table.

use super::identity::{TcpConnection, is_for_reserved_places, scope};
use super::{AccessGate, Identity, texts};
use crate::app::App;
use crate::problem::{ProblemResponse, RefusedHere};
use crate::security;
use crate::tls::trust;
use api::access::{Endpoint, HttpMethod};
use axum::Extension;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::sync::Arc;

/// Answers only requests for a name of this server. A connection at a reserved place ends after its request, unless that opens a socket.
pub(crate) async fn known_host(
    State(app): State<Arc<App>>,
    Extension(connection): Extension<TcpConnection>,
    request: Request,
    next: Next,
) -> Response {
    let mut response = answer_known_host(&app, connection, request, next).await;
    if connection.reserved.is_some() && response.status() != StatusCode::SWITCHING_PROTOCOLS {
        response.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
    }
    response
}

async fn answer_known_host(app: &App, connection: TcpConnection, request: Request, next: Next) -> Response {
    let host = single(request.headers(), header::HOST);
    let access = &app.hub.access;
    let Some(host) = host.filter(|host| access.hosts.allows(host, connection.local)) else {
        let nobody = Identity::nobody(None, connection.peer);
        access.journal.refused(&nobody, texts::UNDER_OTHER_NAME, texts::UNKNOWN_HOST);
        return ProblemResponse::new(StatusCode::MISDIRECTED_REQUEST, texts::UNKNOWN_HOST).into_response();
    };
    if connection.lacks_tls && !trust::is_shown_without_tls(request.uri().path()) {
        if request.headers().contains_key(header::AUTHORIZATION) {
            let by = access.identify(request.headers(), &connection);
            access.journal.refused(&by, texts::WITHOUT_TLS, texts::NEEDS_TLS);
        }
        return encrypted_address(host, &request);
    }
    let is_certified_by_site = app.encryption.as_ref().is_some_and(|own| own.authority().is_none());
    let mut response = next.run(request).await;
    if connection.is_tls && is_certified_by_site {
        // Not with the robot's own authority: a browser would let nobody past a warning that a new authority causes.
        response
            .headers_mut()
            .insert(header::STRICT_TRANSPORT_SECURITY, HeaderValue::from_static(security::TLS_ONLY));
    }
    response
}

/// Sends a browser to the same address over TLS. Programs are told, because most would not send their secret again, and should not have sent it.
fn encrypted_address(host: &str, request: &Request) -> Response {
    let path = request.uri().path_and_query().map_or("/", |path| path.as_str());
    let is_page = request.method() == axum::http::Method::GET && !path.starts_with("/api/");
    match HeaderValue::try_from(format!("https://{host}{path}")) {
        Ok(address) if is_page => {
            (StatusCode::PERMANENT_REDIRECT, [(header::LOCATION, address)]).into_response()
        }
        _ => ProblemResponse::new(StatusCode::FORBIDDEN, texts::NEEDS_TLS).into_response(),
    }
}

/// The value of a header that is there once.
fn single(headers: &HeaderMap, name: header::HeaderName) -> Option<&str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next()?.to_str().ok()?;
    values.next().is_none().then_some(value)
}

/// Lets a request through to the handler of this endpoint if it comes from a page of this server or from a program, and from somebody who may use it.
pub(crate) async fn guard(
    State((app, endpoint)): State<(Arc<App>, Endpoint)>,
    Extension(connection): Extension<TcpConnection>,
    mut request: Request,
    next: Next,
) -> Response {
    let headers = request.headers();
    // A browser enforces nothing itself for WebSockets, whatever page opens them.
    let is_socket = matches!(endpoint, Endpoint::Control | Endpoint::Stream);
    let changes_something = endpoint.method() != HttpMethod::Get;
    if (is_socket || changes_something) && !security::is_same_origin(headers, connection.is_tls)
        || security::is_cross_site(headers)
    {
        let by = app.hub.access.identify(headers, &connection);
        app.hub.access.journal.refused(&by, texts::request_to(endpoint), crate::texts::FOREIGN_ORIGIN);
        return ProblemResponse::new(StatusCode::FORBIDDEN, crate::texts::FOREIGN_ORIGIN).into_response();
    }
    if connection.reserved.is_some() && !is_for_reserved_places(endpoint) {
        return ProblemResponse::unavailable(crate::texts::TOO_MANY_CONNECTIONS).into_response();
    }
    let access = &app.hub.access;
    let identity = access.identify(headers, &connection);
    if !endpoint.privilege().admits(identity.role) {
        return not_admitted(access, endpoint, &identity).into_response();
    }
    if let (Some(place), Some(_)) = (connection.reserved, identity.role) {
        app.reserved_places.serve(place);
    }
    request.extensions_mut().insert(identity.clone());
    let path = request.uri().path().to_owned();
    let response = scope(&identity, next.run(request)).await;
    note_outcome(access, endpoint, &identity, &path, &response);
    response
}

/// Answers somebody who may not use an endpoint, and notes it for the audit log.
fn not_admitted(access: &AccessGate, endpoint: Endpoint, identity: &Identity) -> ProblemResponse {
    let Some(role) = identity.role else {
        if !access.is_complete() {
            return ProblemResponse::unavailable(texts::ACCOUNTS_NOT_KNOWN);
        }
        let is_presented = identity.caller.credential.is_some();
        let reason = if is_presented { texts::NOT_VALID } else { texts::SIGN_IN_FIRST };
        access.journal.refused(identity, texts::request_to(endpoint), reason);
        return ProblemResponse::new(StatusCode::UNAUTHORIZED, texts::SIGN_IN_FIRST)
            .with_header(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
    };
    let detail = texts::role_refused(role, endpoint.privilege());
    access.journal.refused(identity, texts::request_to(endpoint), detail.clone());
    ProblemResponse::new(StatusCode::FORBIDDEN, detail)
}

/// Notes what the core does not see itself: changes that a handler has refused before it asked the core, and files that go in or out.
fn note_outcome(access: &AccessGate, endpoint: Endpoint, by: &Identity, path: &str, response: &Response) {
    if let Some(RefusedHere(reason)) = response.extensions().get() {
        if endpoint.method() != HttpMethod::Get {
            access.journal.refused(by, texts::request_to(endpoint), reason.clone());
        }
    } else if response.status().is_success() && matches!(endpoint, Endpoint::Upload | Endpoint::DownloadRun) {
        access.journal.done(by, format!("{} {path}", endpoint.method()));
    }
}
