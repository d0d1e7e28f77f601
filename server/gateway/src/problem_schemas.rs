//! Problems that many requests have in common, for the description of the interface.
#![allow(dead_code, reason = "described, never made: handlers answer with `ProblemResponse`")]

use crate::schemas::ProblemDocument;
use utoipa::IntoResponses;

/// Of a list that is asked from the core.
#[derive(IntoResponses)]
pub(crate) enum QueryProblems {
    /// The id or the query is malformed
    #[response(status = 400, content_type = "application/problem+json")]
    Malformed(ProblemDocument),
    /// The core is not connected, or cannot read
    #[response(status = 503, content_type = "application/problem+json")]
    Unavailable(ProblemDocument),
    /// The core has not answered yet
    #[response(status = 504, content_type = "application/problem+json")]
    NotAnswered(ProblemDocument),
}

/// Of a list of which the gateway has a copy.
#[derive(IntoResponses)]
pub(crate) enum ListProblems {
    /// The query is malformed
    #[response(status = 400, content_type = "application/problem+json")]
    Malformed(ProblemDocument),
    /// The entry that `after` names is not in the list any more
    #[response(status = 404, content_type = "application/problem+json")]
    EntryGone(ProblemDocument),
    /// The core has not sent its maps yet
    #[response(status = 503, content_type = "application/problem+json")]
    Unavailable(ProblemDocument),
}

/// Of a command with a document.
#[derive(IntoResponses)]
pub(crate) enum CommandProblems {
    /// The id or the document is malformed
    #[response(status = 400, content_type = "application/problem+json")]
    Malformed(ProblemDocument),
    /// It is not possible now; the detail says why and what to do
    #[response(status = 409, content_type = "application/problem+json")]
    Refused(ProblemDocument),
    /// The document is too long
    #[response(status = 413, content_type = "application/problem+json")]
    TooLong(ProblemDocument),
    /// The core is not connected
    #[response(status = 503, content_type = "application/problem+json")]
    Unavailable(ProblemDocument),
    /// The core has not answered yet
    #[response(status = 504, content_type = "application/problem+json")]
    NotAnswered(ProblemDocument),
}

/// Of a change of the site.
#[derive(IntoResponses)]
pub(crate) enum SiteChangeProblems {
    /// The document is too long
    #[response(status = 413, content_type = "application/problem+json")]
    TooLong(ProblemDocument),
    /// The core is not connected, or cannot write
    #[response(status = 503, content_type = "application/problem+json")]
    Unavailable(ProblemDocument),
    /// The core has not answered yet
    #[response(status = 504, content_type = "application/problem+json")]
    NotAnswered(ProblemDocument),
}

/// Of a request about accounts.
#[derive(IntoResponses)]
pub(crate) enum AccountProblems {
    /// The name or the document is malformed
    #[response(status = 400, content_type = "application/problem+json")]
    Malformed(ProblemDocument),
    /// Name or password is wrong, or nobody has signed in
    #[response(status = 401, content_type = "application/problem+json")]
    NotSignedIn(ProblemDocument),
    /// This needs a greater role, or the link is an old one
    #[response(status = 403, content_type = "application/problem+json")]
    Forbidden(ProblemDocument),
    /// There is no such account or token
    #[response(status = 404, content_type = "application/problem+json")]
    NotFound(ProblemDocument),
    /// It contradicts what there is; the detail says why and what to do
    #[response(status = 409, content_type = "application/problem+json")]
    Conflict(ProblemDocument),
    /// The document is too long
    #[response(status = 413, content_type = "application/problem+json")]
    TooLong(ProblemDocument),
    /// A name or password is not acceptable; the detail says why
    #[response(status = 422, content_type = "application/problem+json")]
    Invalid(ProblemDocument),
    /// Too many wrong passwords, or too many sign in at the moment
    #[response(status = 429, content_type = "application/problem+json")]
    Busy(ProblemDocument),
    /// The core is not connected, or cannot write
    #[response(status = 503, content_type = "application/problem+json")]
    Unavailable(ProblemDocument),
    /// The core has not answered yet
    #[response(status = 504, content_type = "application/problem+json")]
    NotAnswered(ProblemDocument),
}
