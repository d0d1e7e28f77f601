//! What the audit log says of commands about accounts and of their outcomes, by key. English.

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
