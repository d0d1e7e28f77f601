//! Requests about accounts, sessions and tokens, from the gateway to the core.

use super::{CredentialId, Role, Secret};
use serde::{Deserialize, Serialize};
use vocab::{Span, Stamp};

/// Longest time for which a token is valid, days.
pub const MAX_TOKEN_DAYS: u32 = 366;

/// Time for which a browser that was signed in to an account is known, after its session has ended: the core remembers the session, and the browser its cookie. Chosen.
pub const KNOWN_BROWSER_TIME: Span = Span::from_millis(90 * 24 * 3_600_000);

/// What is asked of the core about accounts. `account` is the name of an account, whatever its case.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum AccountRequest {
    /// Begin a session.
    SignIn {
        /// Whose.
        account: String,
        /// Its password.
        password: Secret,
    },
    /// End the session of whoever asks.
    SignOut,
    /// Make the first admin, and begin a session.
    MakeFirstAdmin(FirstAdmin),
    /// Change the password of whoever asks. All other sessions of the account end.
    ChangeOwnPassword {
        /// The present one.
        current: Secret,
        /// The new one.
        new: Secret,
    },
    /// All accounts.
    ListAccounts,
    /// Make an account.
    AddAccount {
        /// Its name.
        account: String,
        /// What it may do.
        role: Role,
        /// Its first password.
        password: Secret,
    },
    /// Change an account.
    ChangeAccount {
        /// Which.
        account: String,
        /// How.
        change: AccountChange,
    },
    /// Remove an account. Its sessions end.
    RemoveAccount {
        /// Which.
        account: String,
    },
    /// All tokens that are valid.
    ListTokens,
    /// Make a token.
    AddToken {
        /// Its name, for people.
        name: String,
        /// What it may do.
        role: Role,
        /// For how long, days; [`MAX_TOKEN_DAYS`] at most.
        days: u32,
    },
    /// End a token.
    RevokeToken(CredentialId),
}

/// The first admin.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FirstAdmin {
    /// The secret of the link.
    pub link: Secret,
    /// Name of the account.
    pub account: String,
    /// Its password.
    pub password: Secret,
}

/// A change of an account.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum AccountChange {
    /// It may do this from now on.
    Role(Role),
    /// Its new password. Its sessions end.
    Password(Secret),
    /// Whether it may sign in. If not, its sessions end.
    IsEnabled(bool),
    /// Its sessions end.
    EndSessions,
}

/// The answer to an [`AccountRequest`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum AccountReply {
    /// It is done.
    Done,
    /// A session has begun.
    SignedIn {
        /// Its secret. Nobody else ever sees it.
        secret: Secret,
        /// Whose it is.
        account: String,
        /// What it may do.
        role: Role,
        /// When it ends at the latest, by calendar time.
        expires: Stamp,
    },
    /// All accounts.
    Accounts(Vec<AccountSummary>),
    /// All tokens.
    Tokens(Vec<TokenSummary>),
    /// A new token.
    Token {
        /// Its secret, which is shown once.
        secret: Secret,
        /// What is known of it.
        token: TokenSummary,
    },
}

/// An account, for admins.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AccountSummary {
    /// Its name.
    pub account: String,
    /// What it may do.
    pub role: Role,
    /// Whether it may sign in.
    pub is_enabled: bool,
    /// Its sessions.
    pub sessions: u32,
    /// When it was made, by calendar time.
    pub created: Stamp,
    /// When its last session began or was last used, by calendar time, to a few minutes.
    pub last_used: Option<Stamp>,
}

/// A token, for admins.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TokenSummary {
    /// Names it.
    pub id: CredentialId,
    /// Its name, for people.
    pub name: String,
    /// What it may do.
    pub role: Role,
    /// When it was made, by calendar time.
    pub created: Stamp,
    /// When it ends.
    pub expires: Stamp,
    /// When it was last used, to a few minutes.
    pub last_used: Option<Stamp>,
}

/// Why a request about accounts was not carried out.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AccountRefusal {
    /// What kind of reason it is.
    pub kind: AccountRefusalKind,
    /// One sentence for people.
    pub reason: String,
}

/// Kinds of reasons. HTTP has a status for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum AccountRefusalKind {
    /// Name or password is wrong, or nobody has signed in.
    NotSignedIn,
    /// Whoever asks may not do this.
    Forbidden,
    /// There is no such account or token.
    NotFound,
    /// It contradicts what there is, such as a second account of a name.
    Conflict,
    /// A name or password is not acceptable.
    Invalid,
    /// Too many ask at the moment.
    Busy,
    /// The disk fails.
    Unavailable,
}
