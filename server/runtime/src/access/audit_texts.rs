//! What the audit log says of commands about accounts and of their outcomes, by key. English.

use accounts::AccountName;
use api::access::AccountRequest;
use std::fmt::Display;

/// It was done.
pub const DONE: &str = "done";
/// It was refused, for no other reason than its role or password.
pub const REFUSED: &str = "refused";
/// The stack accepted a command.
pub const ACCEPTED: &str = "accepted";
/// The stack has given no answer to a command.
pub const NOT_ANSWERED: &str = "not answered";
/// Somebody has signed in, or tried to, whose name is not known.
pub const SIGN_IN: &str = "sign in";
/// Somebody has changed the own password.
pub const CHANGE_OWN_PASSWORD: &str = "change own password";

/// Requests that are not told apart, because there were too many different ones.
pub const OTHER_REQUESTS: &str = "other requests";
/// Commands beyond those of an account that have an entry each.
pub const FURTHER_COMMANDS: &str = "further commands";
/// What has come of them.
pub const NOT_LISTED: &str = "not listed one by one";
/// An edit of the site.
pub const EDIT: &str = "edit";

/// How often, after an outcome.
pub fn times(count: u32) -> String {
    if count > 1 { format!(" ({count} times)") } else { String::new() }
}

/// The number of entries before this one that could not be written, after an outcome.
pub fn entries_lost(count: u64) -> String {
    format!("; {count} entries before this one are missing, because the disk has failed")
}

/// Whoever asked has presented what was a session of an account or a token before, after an outcome.
pub fn with_old_credential_of(owner: &str) -> String {
    format!(" It was a session or token of {owner}.")
}

/// The making of a map has ended.
pub fn map_made(verb: &str, name: &str) -> String {
    format!("{verb} map {name}")
}

/// What was begun has failed.
pub fn failed_because(reason: &str) -> String {
    format!("failed: {reason}")
}

/// It was refused with this reason.
pub fn refused_because(reason: &str) -> String {
    format!("refused: {reason}")
}

/// It was refused, and others that have no entry of their own were refused before.
pub fn refused_and_before(others: u32) -> String {
    match others {
        0 => REFUSED.to_owned(),
        _ => format!("refused, and {others} more before"),
    }
}

/// So many were refused since the entry before.
pub fn refused_times(count: u32) -> String {
    format!("refused {count} times")
}

/// Somebody has tried to sign in to this account.
pub fn sign_in_as(account: &dyn Display) -> String {
    format!("sign in as {account}")
}

/// The first admin was made, by the link.
pub fn make_first_admin(account: &dyn Display) -> String {
    format!("make the first admin {account}")
}

/// An account was made.
pub fn add_account(account: &dyn Display, role: &dyn Display) -> String {
    format!("add account {account} as {role}")
}

/// An account got another role.
pub fn change_account(account: &dyn Display, role: &dyn Display) -> String {
    format!("change account {account} to {role}")
}

/// An account got a new password from somebody else.
pub fn reset_password(account: &dyn Display) -> String {
    format!("reset password of {account}")
}

/// An account may sign in, or may not any more.
pub fn enable_account(account: &dyn Display, is_enabled: bool) -> String {
    let verb = if is_enabled { "enable" } else { "disable" };
    format!("{verb} account {account}")
}

/// All sessions of an account have ended.
pub fn end_sessions(account: &dyn Display) -> String {
    format!("end sessions of {account}")
}

/// An account was removed.
pub fn remove_account(account: &dyn Display) -> String {
    format!("remove account {account}")
}

/// A token was made.
pub fn add_token(name: &str, role: &dyn Display, days: u32) -> String {
    format!("make token {name} as {role} for {days} days")
}

/// A token has ended.
pub fn end_token(name: &str) -> String {
    format!("end token {name}")
}

/// A command was given on the robot's own console.
pub fn on_console(command: &str) -> String {
    format!("console: {command}")
}

/// A request about accounts. A name that is none may be a password in the wrong field, so it is left out.
pub fn request(request: &AccountRequest) -> String {
    let (what, account) = match request {
        AccountRequest::SignIn { account, .. } => (SIGN_IN, Some(account)),
        AccountRequest::SignOut => ("sign out", None),
        AccountRequest::MakeFirstAdmin(first) => ("make the first admin", Some(&first.account)),
        AccountRequest::ChangeOwnPassword { .. } => (CHANGE_OWN_PASSWORD, None),
        AccountRequest::ListAccounts => ("list accounts", None),
        AccountRequest::AddAccount { account, .. } => ("add account", Some(account)),
        AccountRequest::ChangeAccount { account, .. } => ("change account", Some(account)),
        AccountRequest::RemoveAccount { account } => ("remove account", Some(account)),
        AccountRequest::ListTokens => ("list tokens", None),
        AccountRequest::AddToken { .. } => ("make token", None),
        AccountRequest::RevokeToken(_) => ("end token", None),
    };
    match account.and_then(|account| account.parse::<AccountName>().ok()) {
        Some(account) if matches!(request, AccountRequest::SignIn { .. }) => sign_in_as(&account),
        Some(account) => format!("{what} {account}"),
        None => what.to_owned(),
    }
}
