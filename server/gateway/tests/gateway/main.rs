//! The gateway between a made-up core and real clients over real sockets.

mod abuse;
mod control;
mod core_link;
mod http;
mod maps;
mod nightly;
mod runs;
mod site;
mod static_files;
mod stream;
mod support;
mod uploads;
