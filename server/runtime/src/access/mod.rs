//! Who may use the platform: accounts, sessions and tokens.
//!
//! The ledger has them. The thread `accounts` reads them from there, checks passwords, and publishes which sessions and tokens are valid ([`api::access::AccessState`]) to
//! the gateway, so that no request waits for it. Everything that the gateway forwards names its [`Caller`](api::Caller); [`AccessDirectory`] makes the
//! [`Principal`](messages::Principal) of it, and asks the privilege table again.
//!
//! | what waits | policy |
//! | --- | --- |
//! | attempts to sign in by strangers | one for each address, [`AccountsConfig::max_strangers`] together; further ones are refused |
//! | attempts to sign in from an address or browser that has signed in to the account before | first in turn; refused beyond [`AccountsConfig::max_known`] |
//! | other requests about accounts | before those of strangers; refused beyond [`AccountsConfig::max_requests`] |

mod audit;
pub mod audit_texts;
mod directory;
mod first_admin;
mod inbox;
mod requests;
mod sessions;
#[cfg(test)]
mod tests;
mod texts;
mod worker;

pub use audit::CommandAudit;
pub use directory::AccessDirectory;
pub use inbox::AccountInbox;
pub use worker::AccessWorker;

use accounts::{PasswordConfig, ThrottleConfig};
use api::access::KNOWN_BROWSER_TIME;
use std::time::Duration;
use vocab::Span;

/// Whether people have to sign in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AccessMode {
    /// They have to.
    #[default]
    SignIn,
    /// Whoever reaches the server is an admin. The server listens on this computer only.
    Demo,
}

/// Parameters of accounts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccountsConfig {
    /// Passwords and their hashes.
    pub passwords: PasswordConfig,
    /// How often somebody may try to sign in.
    pub throttle: ThrottleConfig,
    /// Time without use after which a session ends: a shift with its breaks. OWASP ASVS 5, 7.3.1 leaves it to the site. Chosen for such a shift.
    pub session_idle: Span,
    /// Time after which a session ends in any case: a week. Chosen as a round number: less makes people sign in more often, more leaves a stolen one valid for longer.
    pub max_session: Span,
    /// Time for which a session that has ended is remembered as a browser that was signed in. It is that which clients are told ([`KNOWN_BROWSER_TIME`]).
    pub known_browser: Span,
    /// Sessions of one account. A further one ends the one that was used least lately. Chosen: more than the devices of one person.
    pub max_sessions: usize,
    /// Accounts, and tokens that are valid. Chosen: more than a site has people and programs; every client that manages them gets the whole list.
    pub max_accounts: usize,
    /// Time between two looks at the ledger for changes by others. A revocation takes effect within it. Chosen: people notice half a second hardly, and a look costs one
    /// query.
    pub poll_period: Duration,
    /// Time between two notes in the ledger of when a session was used. Chosen: 5 minutes, fine enough for [`Self::session_idle`], and few writes.
    pub note_period: Span,
    /// Attempts by strangers that wait. Chosen: each takes 50 ms and more, so that the last waits about half a second.
    pub max_strangers: usize,
    /// Attempts from known addresses and browsers that wait. Chosen: twice those of strangers, because these are people who work here.
    pub max_known: usize,
    /// Other requests that wait. Chosen: one for each client that may be connected.
    pub max_requests: usize,
    /// Longest wait for the ledger's thread. The disk may be busy with a large transaction. Chosen: disks that stall do so for some seconds.
    pub write_timeout: Duration,
    /// Time between two searches for sessions that ended long ago. Chosen: an hour; old sessions have no effect, they only take space.
    pub cleaning_period: Duration,
    /// Least time between two entries of the audit log for failed attempts to sign in: a flood of them does not fill the disk. Chosen: 86,400 entries a day at most.
    pub failure_note_period: Duration,
    /// Longest name of a token, characters. Chosen: it fits into a row of the list.
    pub max_token_name_chars: usize,
}

const HOUR: i64 = 3_600_000;

impl Default for AccountsConfig {
    fn default() -> Self {
        Self {
            passwords: PasswordConfig::default(),
            throttle: ThrottleConfig::default(),
            session_idle: Span::from_millis(12 * HOUR),
            max_session: Span::from_millis(7 * 24 * HOUR),
            known_browser: KNOWN_BROWSER_TIME,
            max_sessions: 20,
            max_accounts: 500,
            poll_period: Duration::from_millis(500),
            note_period: Span::from_millis(HOUR / 12),
            max_strangers: 8,
            max_known: 16,
            max_requests: 64,
            write_timeout: Duration::from_secs(20),
            cleaning_period: Duration::from_secs(3_600),
            failure_note_period: Duration::from_secs(1),
            max_token_name_chars: 60,
        }
    }
}
