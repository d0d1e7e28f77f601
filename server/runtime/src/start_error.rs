//! Why the core could not be started.

use std::io;
use std::path::PathBuf;
use store::StoreError;

/// Why the core could not be started.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The socket for the gateway cannot be opened.
    #[error("could not listen for the gateway at {}", path.display())]
    Socket {
        /// Path of the socket.
        path: PathBuf,
        /// Error of the system.
        #[source]
        source: io::Error,
    },
    /// A thread cannot be started.
    #[error("could not start a thread")]
    Thread(#[source] io::Error),
    /// The interrupted mapping sessions cannot be listed.
    #[error("could not list the interrupted mapping sessions")]
    Sessions(#[source] StoreError),
    /// The saved maps cannot be listed.
    #[error("could not list the saved maps")]
    Maps(#[source] StoreError),
}
