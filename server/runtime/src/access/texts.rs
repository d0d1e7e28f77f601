//! Sentences for people about accounts, by key. English.

use api::{Privilege, Role};
use std::time::Duration;

/// Somebody who has not signed in asks for something that needs it, or the session has ended.
pub const NOT_SIGNED_IN: &str =
    "Nobody has signed in here, or the session has ended. Sign in, then try again.";
/// Name and password do not fit. Which of them is wrong is not told.
pub const WRONG_PASSWORD: &str =
    "Name or password is wrong. After a typing error try again; an admin can set a new password.";
/// Whoever wants to change the password has mistyped the present one.
pub const WRONG_CURRENT_PASSWORD: &str = "The present password is wrong. Type it again.";
/// The link that makes the first admin is an old one.
pub const WRONG_LINK: &str = "This link does not work any more. Take the one that the robot's console shows: autoinspect account link.";
/// Too many attempts to sign in wait.
pub const SIGN_IN_BUSY: &str = "Too many try to sign in at the moment. Try again in a few seconds.";
/// Accounts are of no use where nobody signs in.
pub const NO_ACCOUNTS_IN_DEMO: &str =
    "This is a demonstration, in which nobody signs in. Start the platform without --demo to use accounts.";
/// An account of this name does not exist.
pub const NO_ACCOUNT: &str = "There is no account of this name. Look at the list of accounts.";
/// A token of this id does not exist.
pub const NO_TOKEN: &str = "There is no such token any more. Look at the list of tokens.";
/// The last admin may not be removed, disabled or demoted.
pub const LAST_ADMIN: &str = "This is the only admin. Make another one first.";

/// Somebody may not do something that needs a greater role.
pub fn role_refused(role: Role, privilege: Privilege) -> String {
    format!("This needs the role {privilege}, and you are signed in as {role}. Ask an admin for it.")
}

/// Too many wrong passwords came from one address, or for one account.
pub fn too_many_failures(wait: Duration) -> String {
    format!("Too many wrong passwords. Try again in {} s.", wait.as_secs() + 1)
}

/// A name or password that is not accepted; the reason is a clause.
pub fn not_acceptable(reason: &str) -> String {
    let mut sentence = format!("Not accepted: {reason}");
    if !sentence.ends_with('.') {
        sentence.push('.');
    }
    sentence
}

/// Name or time of a token is not accepted.
pub fn token_not_acceptable(max_days: u32) -> String {
    format!("A token needs a name, and is valid for 1 to {max_days} days.")
}

/// Second account of a name.
pub fn account_exists(account: &str) -> String {
    format!("There is an account {account} already. Choose another name.")
}

/// The limit on accounts or tokens is reached.
pub fn too_many_accounts(max: usize) -> String {
    format!("There are {max} already, the most that are possible. Remove some first.")
}

/// Accounts could not be written for this reason, a clause.
pub fn accounts_not_written(reason: &str) -> String {
    format!("Nothing was changed: {}. Try again.", reason.trim_end_matches('.'))
}

/// Accounts could not be read for this reason, a clause.
pub fn accounts_not_read(reason: &str) -> String {
    format!("Changes of accounts are not seen: {reason}. Those who were signed in stay so.")
}

/// The file with the link could not be written or removed.
pub fn first_admin_link_not_written(error: &std::io::Error) -> String {
    format!("The link that makes the first admin could not be written or removed: {error}.")
}
