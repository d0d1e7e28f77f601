//! Errors over HTTP: RFC 9457.

use crate::site::FieldProblem;
use api::Problem;
use axum::Json;
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde_json::{Map, Value};

/// What some problems have besides.
#[derive(Debug, Default)]
struct Extension {
    errors: Vec<FieldProblem>,
    /// Further members of the document.
    members: Map<String, Value>,
    header: Option<(HeaderName, HeaderValue)>,
}

/// The document of a problem.
#[derive(Serialize)]
struct ProblemBody {
    #[serde(flatten)]
    problem: Problem,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    errors: Vec<FieldProblem>,
    #[serde(flatten)]
    members: Map<String, Value>,
}

/// Marks a response to a request that this process has refused by itself, with the sentence that says why. Of one that the core has refused the core itself knows.
#[derive(Clone, Debug)]
pub(crate) struct RefusedHere(pub(crate) String);

/// A [`Problem`] as a response.
#[derive(Debug)]
pub(crate) struct ProblemResponse {
    status: StatusCode,
    detail: String,
    extension: Option<Box<Extension>>,
    is_of_core: bool,
}

impl ProblemResponse {
    /// `detail` says what is wrong here and what to do.
    pub(crate) fn new(status: StatusCode, detail: impl Into<String>) -> Self {
        Self { status, detail: detail.into(), extension: None, is_of_core: false }
    }

    /// What is wrong and what to do.
    pub(crate) fn detail(&self) -> &str {
        &self.detail
    }

    fn extension(&mut self) -> &mut Extension {
        self.extension.get_or_insert_default()
    }

    /// Names the fields that are wrong.
    pub(crate) fn with_fields(mut self, errors: Vec<FieldProblem>) -> Self {
        self.extension().errors = errors;
        self
    }

    /// Adds the members of this object.
    pub(crate) fn with_members(mut self, members: Value) -> Self {
        if let Value::Object(members) = members {
            self.extension().members = members;
        }
        self
    }

    /// Adds a header.
    pub(crate) fn with_header(mut self, name: HeaderName, value: HeaderValue) -> Self {
        self.extension().header = Some((name, value));
        self
    }

    /// It is the answer of the core, which has noted it.
    pub(crate) fn of_core(mut self) -> Self {
        self.is_of_core = true;
        self
    }

    /// 400.
    pub(crate) fn malformed(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::BAD_REQUEST, detail)
    }

    /// 404.
    pub(crate) fn not_found(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::NOT_FOUND, detail)
    }

    /// 503: try again later.
    pub(crate) fn unavailable(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::SERVICE_UNAVAILABLE, detail)
    }
}

impl IntoResponse for ProblemResponse {
    fn into_response(self) -> Response {
        let refused = (!self.is_of_core).then(|| RefusedHere(self.detail.clone()));
        let problem = Problem {
            status: self.status.as_u16(),
            title: self.status.canonical_reason().unwrap_or("Error").to_owned(),
            detail: self.detail,
        };
        let Extension { errors, members, header } = self.extension.map(|boxed| *boxed).unwrap_or_default();
        let mut response = (self.status, Json(ProblemBody { problem, errors, members })).into_response();
        let headers = response.headers_mut();
        headers.extend(header);
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
        if self.status == StatusCode::SERVICE_UNAVAILABLE {
            headers.insert(header::RETRY_AFTER, HeaderValue::from_static("1"));
        }
        if let Some(refused) = refused {
            response.extensions_mut().insert(refused);
        }
        response
    }
}
