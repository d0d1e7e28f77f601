//! Why connections cannot be encrypted.

use std::path::PathBuf;

/// Why connections cannot be encrypted.
#[derive(Debug, thiserror::Error)]
pub enum TlsError {
    /// A file cannot be read or written.
    #[error("{} cannot be used for TLS: {reason}. Give other files, or none", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why, a clause.
        reason: String,
    },
    /// A certificate cannot be made.
    #[error("no certificate could be made: {0}")]
    Make(String),
}
