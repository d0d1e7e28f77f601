//! The gateway: connects the robot's core with clients in browsers.
//!
//! It speaks the contract of crate `api` with both: over a Unix socket with the core, over HTTP and WebSockets with clients. It also serves the
//! client's own files and the tiles of maps. If it crashes or is flooded, the core goes on.
//!
//! Three rules hold everywhere in it:
//!
//! - Nobody waits for a client. The link to the core writes into a snapshot, and clients read from it at their own pace.
//! - Every queue has a limit. State that replaces earlier state is kept once, answers are counted, and a connection that stalls is closed.
//! - Every refusal is a sentence that says what to do.

mod access;
mod address_places;
mod alerts;
mod app;
mod blobs;
mod byte_range;
mod client_io;
mod control;
mod core_link;
mod documents;
mod edit_places;
mod example;
mod files;
mod hub;
mod json_response;
mod limits;
mod maps;
mod new_normal;
mod openapi;
mod openapi_access;
mod outbox;
mod pacer;
mod pages;
mod problem;
mod problem_schemas;
mod report;
mod reserved_places;
mod robot_clock;
mod router;
mod runs;
mod schemas;
mod security;
mod server;
mod site;
mod snapshot;
mod snapshot_site;
mod socket;
mod static_files;
mod stop;
mod stored_data;
mod stream;
mod texts;
mod tile_pages;
mod tls;
mod uploads;
mod wire;

pub use access::{AccessConfig, socket_client};
pub use limits::Limits;
pub use openapi::description;
pub use server::serve_with;
pub use tls::trust::authority_fingerprint;
pub use tls::{TlsConfig, TlsError};

use api::ProcessRestart;
use std::future::Future;
use std::net::SocketAddr;
use std::path::PathBuf;
use tokio::sync::oneshot;
use watchdog::Heartbeat;

/// Where the gateway listens, and what it serves.
#[derive(Debug)]
pub struct GatewayConfig {
    /// Address for clients; port 0 lets the system choose. Given by `--listen`.
    pub listen: SocketAddr,
    /// The core's Unix socket. It may appear later, and vanish and come back. Given by the supervisor.
    pub core_socket: PathBuf,
    /// Data directory: `maps/<id>/tiles.json`, `maps/<id>/graph.json` and `tiles/ab/<hash>` are read from it. Given by the supervisor.
    pub data_dir: PathBuf,
    /// Folder of the client's page, with the bundle in `pkg`. Given by the supervisor.
    pub static_dir: PathBuf,
    /// Who may use it, and under which names. Given by the command line.
    pub access: AccessConfig,
    /// How connections are encrypted. Given by the command line.
    pub tls: TlsConfig,
    /// Gets the address once clients can connect. Given by the caller.
    pub on_ready: Option<oneshot::Sender<SocketAddr>>,
    /// Gets heartbeats while the gateway works. Given by the caller.
    pub heartbeat: Option<Heartbeat>,
    /// Why this process was started again, if it was. Given by the supervisor.
    pub restart: Option<ProcessRestart>,
}

/// Why the gateway could not start.
#[derive(Debug, thiserror::Error)]
pub enum GatewayError {
    /// A demonstration, in which nobody signs in, is not for a network.
    #[error(
        "a demonstration needs no sign-in, so it cannot listen on {address}, which others can reach. Leave --demo out, or listen on 127.0.0.1"
    )]
    DemoOnNetwork {
        /// The address.
        address: SocketAddr,
    },
    /// Connections cannot be encrypted.
    #[error(transparent)]
    Tls(TlsError),
    /// The address cannot be listened on.
    #[error(
        "cannot listen on {address}: {source}. Choose another address, or stop the program that uses this one"
    )]
    Listen {
        /// The address.
        address: SocketAddr,
        /// What the system says.
        source: std::io::Error,
    },
}

/// Serves clients until `shutdown` completes, then closes their connections and returns within a few seconds.
///
/// # Errors
/// When the address cannot be listened on. Nothing that core or clients do ends it.
pub async fn serve(config: GatewayConfig, shutdown: impl Future<Output = ()>) -> Result<(), GatewayError> {
    serve_with(config, Limits::default(), shutdown).await
}
