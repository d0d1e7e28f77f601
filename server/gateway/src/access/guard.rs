//! What stands before every handler: the name of the server, the origin of the page, and the privilege table.

use super::identity::{Connection, scope};
use super::texts;
use crate::app::App;
use crate::problem::ProblemResponse;
use crate::security;
use api::access::{Endpoint, Method};
use axum::Extension;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::sync::Arc;

/// Answers only requests for a name of this server.
pub(crate) async fn known_host(
    State(app): State<Arc<App>>,
    Extension(connection): Extension<Connection>,
    request: Request,
    next: Next,
) -> Response {
    let is_allowed = single(request.headers(), header::HOST)
        .is_some_and(|host| app.hub.access.hosts.allows(host, connection.local));
    if is_allowed {
        next.run(request).await
    } else {
        ProblemResponse::new(StatusCode::MISDIRECTED_REQUEST, texts::UNKNOWN_HOST).into_response()
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
    Extension(connection): Extension<Connection>,
    mut request: Request,
    next: Next,
) -> Response {
    let headers = request.headers();
    // A browser enforces nothing itself for WebSockets, whatever page opens them.
    let is_socket = matches!(endpoint, Endpoint::Control | Endpoint::Stream);
    let changes_something = endpoint.method() != Method::Get;
    if (is_socket || changes_something) && !security::is_same_origin(headers, connection.is_tls)
        || security::is_cross_site(headers)
    {
        return ProblemResponse::new(StatusCode::FORBIDDEN, crate::texts::FOREIGN_ORIGIN).into_response();
    }
    let access = &app.hub.access;
    let identity = access.identify(headers, &connection);
    if !endpoint.privilege().admits(identity.role) {
        return match identity.role {
            Some(role) => {
                let detail = texts::role_refused(role, endpoint.privilege());
                ProblemResponse::new(StatusCode::FORBIDDEN, detail).into_response()
            }
            None if !access.is_complete() => {
                ProblemResponse::unavailable(texts::ACCOUNTS_NOT_KNOWN).into_response()
            }
            None => ProblemResponse::new(StatusCode::UNAUTHORIZED, texts::SIGN_IN_FIRST)
                .with_header(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"))
                .into_response(),
        };
    }
    request.extensions_mut().insert(identity.clone());
    scope(&identity, next.run(request)).await
}
