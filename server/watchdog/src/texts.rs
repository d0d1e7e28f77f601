//! Clauses that say what a process did, by key. Clients show them as the cause of a restart. English.

use std::time::Duration;

/// A thread panicked.
pub(crate) fn panicked(thread: &str, message: &str) -> String {
    format!("panicked in its thread {thread}: {message}")
}

/// A thread gave no heartbeat.
pub(crate) fn silent(thread: &str, silence: Duration) -> String {
    format!("did not answer in its thread {thread} for {} s", silence.as_secs())
}

/// A thread ended although nobody asked it to.
pub(crate) fn ended(thread: &str) -> String {
    format!("lost its thread {thread}")
}
