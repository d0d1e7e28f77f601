//! Sentences for people about access, by key. English.

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
