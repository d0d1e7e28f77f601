//! Accounts without storage: names, passwords, secrets of sessions and tokens, how often somebody may try to sign in, and refusals that are counted.
//!
//! The core's thread `accounts` uses all of it (`runtime/src/access`), the gateway only [`credential_id`] and [`Repeats`], and `autoinspect account` the rest.

mod names;
mod passwords;
mod repeats;
mod secrets;
mod throttle;

pub use names::{AccountName, NameError};
pub use passwords::{HashedPassword, PasswordConfig, PasswordError, check_password, hash, verify};
pub use repeats::{RepeatConfig, Repeated, Repeats};
pub use secrets::{RandomError, credential_id, new_secret};
pub use throttle::{SignInThrottle, ThrottleConfig};
