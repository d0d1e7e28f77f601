//! Tests of the whole product, in one binary.
//!
//! Tests run the program that `AUTOINSPECT_BIN` names (`cargo xtask test` sets it), else the newest build.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test panics on an error, and prints the reason"
)]

mod browser;
mod circles;
mod dependency_direction;
mod glossary;
mod parameters;
mod support;
