//! Tests of the whole product, in one binary.
//!
//! What runs a program uses the one named by `AUTOINSPECT_BIN` (`cargo xtask test` sets it), else the newest build.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that cannot go on should stop there, and say so"
)]

mod browser;
mod dependency_direction;
mod support;
