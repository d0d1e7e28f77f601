//! Tests of the whole odometry: on simulated walks with ground truth, on real recordings, and on faulty input.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "tests stop at what they did not expect, print measured figures and read recordings"
)]

mod faulty;
mod recorded;
mod simulated;
mod support;
