//! Texts of notices, by key.

pub(super) const DISMISS: &str = "Dismiss";

pub(super) fn repetitions(times: u32) -> String {
    format!("{times} times")
}
