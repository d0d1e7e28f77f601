//! Who may use the gateway: sessions in cookies, tokens of programs, and the names under which the server may be reached.
//!
//! The core publishes which sessions and tokens are valid. A request is looked up in that list, and costs no question to the core. [`guard`] asks the privilege table
//! (`api::access`) before each handler; the core asks it again for all that is forwarded.

pub(crate) mod audit;
mod cookies;
mod documents;
pub(crate) mod guard;
pub(crate) mod handlers;
mod hosts;
mod identity;
mod journal;
mod known;
pub(crate) mod texts;

pub(crate) use hosts::HostList;
pub use identity::socket_client;
pub(crate) use identity::{Identity, TcpConnection, current_caller, on_behalf_of};
pub(crate) use journal::AccessJournal;
pub(crate) use known::AccessGate;

use std::net::IpAddr;

/// Who may use a gateway, and under which names.
#[derive(Clone, Debug, Default)]
pub struct AccessConfig {
    /// Whether whoever reaches the server is an admin. The gateway then listens on this computer only. Given by `--demo`.
    pub is_demo: bool,
    /// Names under which it may be reached, besides those of this computer. Given by `--allow-host`.
    pub allowed_hosts: Vec<String>,
}

/// Whether an address belongs to this computer only.
pub(crate) fn is_loopback(address: IpAddr) -> bool {
    address.to_canonical().is_loopback()
}
