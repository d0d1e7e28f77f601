//! The gateway between a made-up core and real clients over real sockets.

mod abuse;
mod access;
mod attacks;
mod audit_notes;
mod control;
mod core_link;
mod http;
mod maps;
mod nightly;
mod privilege_matrix;
mod reports;
mod runs;
#[allow(dead_code, reason = "other tests use the rest")]
#[path = "../../../../shared/api/tests/samples/mod.rs"]
mod samples;
mod site;
mod static_files;
mod stream;
mod support;
mod tls;
mod uploads;
