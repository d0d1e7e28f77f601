//! Accounts without storage: names, passwords, secrets of sessions and tokens, and how often somebody may try to sign in.
//!
//! The core's thread `accounts` uses all of it (`runtime/src/access`), the gateway only [`credential_id`], and `autoinspect account` the rest.

mod names;
mod passwords;
mod secrets;
mod throttle;

pub use names::{AccountName, NameError};
pub use passwords::{HashedPassword, PasswordConfig, PasswordError, check_password, hash, verify};
pub use secrets::{RandomError, credential_id, new_secret};
pub use throttle::{SignInThrottle, ThrottleConfig};
