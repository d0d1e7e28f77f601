//! Tests of the public interface.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may stop at the first surprise and says what it skips"
)]

mod incremental;
mod jacobians;
mod laws;
mod published;
mod robust;
mod support;
