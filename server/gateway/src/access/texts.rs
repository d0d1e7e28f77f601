//! Sentences for people about access, by key. English.

use api::access::Endpoint;
use api::{Privilege, Role};

/// The host of a request is no name of this server.
pub(crate) const UNKNOWN_HOST: &str = "This server is not known under the name in this address. Use its address, or start it with --allow-host NAME.";
/// A request came over plain http to a server that speaks TLS.
pub(crate) const NEEDS_TLS: &str = "This server is reached over https only. Ask for the same address with https://; what was sent just now could be read on the way.";
/// This server has no certificate authority of its own.
pub(crate) const NO_AUTHORITY: &str = "This server has no certificate authority of its own, so there is none to trust. Start it with --tls auto for one.";
/// Something needs an account.
pub(crate) const SIGN_IN_FIRST: &str =
    "Nobody has signed in, or the session has ended. Sign in, or send a token in the Authorization header.";
/// Somebody presents a session or token that is not valid: it has ended, or there has never been one.
pub(crate) const NOT_VALID: &str =
    "The session or token is not valid: it has ended, or is not one of this server.";
/// What the audit log says is asked, where too many different requests are refused.
pub(crate) const OTHER_REQUESTS: &str = "other requests";
/// Why they are not told apart.
pub(crate) const TOO_MANY_KINDS: &str = "Too many different requests were refused to list each.";
/// What the audit log says of a request under a name that is none of the server's.
pub(crate) const UNDER_OTHER_NAME: &str = "a request under another name of the server";
/// What the audit log says of a secret that was sent over plain http.
pub(crate) const WITHOUT_TLS: &str = "a request with a token over plain http";
/// What the audit log says of a socket that got no place.
pub(crate) const CONTROL_PLACE: &str = "a place among the control sockets";
/// What the audit log says of an edit that the gateway has refused.
pub(crate) const EDIT: &str = "edit";
/// The core has not yet said who may use the platform.
pub(crate) const ACCOUNTS_NOT_KNOWN: &str =
    "The robot's core has not said yet who may use the platform. Try again in a few seconds.";
/// Something was to be forwarded that nobody asks for: a mistake of the program.
pub(crate) const NOBODY_ASKS: &str = "This was asked by nobody, so it is not done. Report this.";
/// A socket is closed because its session has ended, or may do something else now.
pub(crate) const SESSION_ENDED: &str = "The session has ended, or its role has changed. Sign in again.";
/// A document about accounts could not be understood.
pub(crate) const ACCOUNT_MALFORMED: &str =
    "The document cannot be understood: it needs the fields that the description of the interface lists.";
/// An id of a token is malformed.
pub(crate) const TOKEN_ID_MALFORMED: &str =
    "The id of a token has 64 hexadecimal digits. Look at the list of tokens.";
/// A name of an account cannot be understood.
pub(crate) const ACCOUNT_NAME_MALFORMED: &str =
    "The name of the account in the path is not UTF-8. Encode it.";

/// Somebody may not do something that needs a greater role.
pub(crate) fn role_refused(role: Role, privilege: Privilege) -> String {
    format!("This needs the role {privilege}, and you are signed in as {role}. Ask an admin for it.")
}
/// A change of an account has none or several fields.
pub(crate) const ONE_CHANGE: &str =
    "The document has to have exactly one of role, password, is_enabled and end_sessions.";
/// The audit log was asked for in a format that there is not.
pub(crate) const FORMAT_UNKNOWN: &str = "The format is json or csv. Leave it out for JSON.";

/// What the audit log says of a request to an endpoint.
pub(crate) fn request_to(endpoint: Endpoint) -> String {
    format!("{} {}", endpoint.method(), endpoint.path())
}
