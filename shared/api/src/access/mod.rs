//! Who may do what, and how people and programs show who they are.
//!
//! The privilege table is code: [`Endpoint`] has the paths of the HTTP interface, [`command_privilege`] the commands, [`edit_privilege`] the documents that are
//! edited, and so on. Each is a `match` over all variants, so that nothing new compiles without a row. The gateway asks the table before it does or forwards
//! anything, and the core asks it again. `docs/guide/security.md` prints it.
//!
//! Whoever signs in gets a secret of 256 random bits, in a cookie or as a token. The server keeps its BLAKE3 only, the [`CredentialId`]. The core publishes the ids
//! that are valid to the gateway ([`AccessState`]), so that a request costs no round trip and a revocation takes effect at once.

mod accounts;
mod endpoints;
mod lease;
mod privileges;
mod secret;

pub use accounts::{
    AccountChange, AccountRefusal, AccountRefusalKind, AccountReply, AccountRequest, AccountSummary,
    FirstAdmin, KNOWN_BROWSER_TIME, MAX_TOKEN_DAYS, TokenSummary,
};
pub use endpoints::{Endpoint, HttpMethod};
pub use lease::{ClientIdentity, LeaseToken};
pub use privileges::{
    Privilege, account_privilege, command_privilege, edit_privilege, event_privilege, message_privilege,
    object_privilege, query_privilege,
};
pub use secret::Secret;
pub use vocab::{Role, RoleError};

use serde::{Deserialize, Serialize};
use std::net::IpAddr;
use vocab::{ClientId, Stamp};

vocab::content_hash! {
    /// A session or a token as the server keeps it: the BLAKE3 of its secret. Whoever knows it cannot sign in with it.
    CredentialId,
    /// Text that names no session and no token.
    CredentialIdError,
    "a session or token is named by 64 hexadecimal digits"
}

/// Who sends something to the core, as the gateway saw it. The core looks the credential up itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Caller {
    /// Browser tab or program.
    pub client: ClientId,
    /// With what it has signed in; none: not at all.
    pub credential: Option<CredentialId>,
    /// The address from which it came; none: from this computer, without a network.
    pub address: Option<IpAddr>,
}

impl From<ClientId> for Caller {
    /// Somebody at this computer who has not signed in.
    fn from(client: ClientId) -> Self {
        Self { client, credential: None, address: None }
    }
}

/// A session or token that is valid.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Grant {
    /// Which.
    pub credential: CredentialId,
    /// Whose it is; of a token its name.
    pub account: String,
    /// What it may do.
    pub role: Role,
    /// When it ends at the latest, by calendar time.
    pub expires: Stamp,
}

/// Who may use the platform now. Replaces the one before.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct AccessState {
    /// Whether there is no admin yet: the first one is made by a link that the robot's console shows.
    pub needs_first_admin: bool,
    /// All valid sessions and tokens.
    pub grants: Vec<Grant>,
}
