//! Tests of the whole product, in one binary.
//!
//! Tests that run the program use the one named by `AUTOINSPECT_BIN` (`cargo xtask test` sets it), else the newest build.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails where it cannot go on, and prints why"
)]

mod browser;
mod dependency_direction;
mod glossary;
mod support;
