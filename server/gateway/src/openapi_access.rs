//! What stands before every handler, in the description of the interface: how to sign in, and the answers to those who may not ask.

use crate::schemas::ProblemDocument;
use api::Privilege;
use api::access::{Endpoint, HttpMethod};
use utoipa::openapi::path::{Operation, PathItem};
use utoipa::openapi::security::{
    ApiKey, ApiKeyValue, Http, HttpAuthScheme, SecurityRequirement, SecurityScheme,
};
use utoipa::openapi::{Components, Content, OpenApi, Ref, RefOr, Response, ResponseBuilder};
use utoipa::{PartialSchema, ToSchema};

/// Names of the ways to sign in, in the description.
const SESSION: &str = "session";
const TOKEN: &str = "token";

/// Status and description of the answers that every handler has in common.
const MISDIRECTED: (&str, &str) = ("421", "The server is not known under the name in the address");
const UNAVAILABLE: (&str, &str) =
    ("503", "The core has not said yet who may use the platform, or too many connections are open");
const FORBIDDEN: (&str, &str) = ("403", "This needs a greater role, or a page of another site asks");
const NOT_SIGNED_IN: (&str, &str) = ("401", "Nobody has signed in, or the session has ended");

/// Adds them to all operations. Answers that an operation describes itself stay.
pub(crate) fn describe_access(description: &mut OpenApi) {
    let components = description.components.get_or_insert_with(Components::new);
    components.schemas.entry(ProblemDocument::name().into_owned()).or_insert_with(ProblemDocument::schema);
    let cookie = ApiKeyValue::with_description(
        "autoinspect-session",
        "Of a person, from POST /api/v1/session. Over TLS its name begins with __Host-.",
    );
    components.add_security_scheme(SESSION, SecurityScheme::ApiKey(ApiKey::Cookie(cookie)));
    components.add_security_scheme(TOKEN, SecurityScheme::Http(Http::new(HttpAuthScheme::Bearer)));
    for &endpoint in Endpoint::ALL {
        let operation = description
            .paths
            .paths
            .get_mut(endpoint.path())
            .and_then(|item| operation(item, endpoint.method()));
        if let Some(operation) = operation {
            describe(operation, endpoint.privilege());
        }
    }
}

fn operation(item: &mut PathItem, method: HttpMethod) -> Option<&mut Operation> {
    match method {
        HttpMethod::Get => item.get.as_mut(),
        HttpMethod::Post => item.post.as_mut(),
        HttpMethod::Put => item.put.as_mut(),
        HttpMethod::Patch => item.patch.as_mut(),
        HttpMethod::Delete => item.delete.as_mut(),
    }
}

fn describe(operation: &mut Operation, privilege: Privilege) {
    let mut answers = vec![FORBIDDEN, MISDIRECTED, UNAVAILABLE];
    if let Privilege::SignedIn(_) = privilege {
        answers.push(NOT_SIGNED_IN);
        let by = |name| SecurityRequirement::new::<_, [&str; 0], &str>(name, []);
        operation.security = Some(vec![by(SESSION), by(TOKEN)]);
    }
    for (status, description) in answers {
        operation
            .responses
            .responses
            .entry(status.to_owned())
            .or_insert_with(|| RefOr::T(problem(description)));
    }
}

fn problem(description: &str) -> Response {
    let schema = Ref::from_schema_name(ProblemDocument::name());
    ResponseBuilder::new()
        .description(description)
        .content("application/problem+json", Content::new(Some(schema)))
        .build()
}
