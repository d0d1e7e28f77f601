//! Why something could not be stored.

use std::io;
use std::path::{Path, PathBuf};
use vocab::{MapId, SessionId};

/// Why something could not be stored or found.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The disk or the permissions are at fault.
    #[error("could not {action} {}", path.display())]
    Io {
        /// What was tried: "read", "write".
        action: &'static str,
        /// With which file.
        path: PathBuf,
        /// What the system said.
        #[source]
        source: io::Error,
    },
    /// Another process has it open.
    #[error("{} is in use by another AutoInspect; stop that one or choose another directory", dir.display())]
    InUse {
        /// The data directory.
        dir: PathBuf,
    },
    /// Map versions are immutable.
    #[error("map {id} is already saved")]
    MapExists {
        /// Which version.
        id: MapId,
    },
    /// A session without a single keyframe cannot be saved.
    #[error("session {session} has no keyframes; let the robot see something before saving")]
    EmptySession {
        /// Which session.
        session: SessionId,
    },
    /// A cloud, graph or trajectory that this store wrote cannot be read.
    #[error("could not understand {}", path.display())]
    Cloud {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it.
        #[source]
        source: formats::FormatError,
    },
    /// The files of a map do not belong together.
    #[error("{} {what}; make the map again", path.display())]
    Broken {
        /// Which file.
        path: PathBuf,
        /// What it does.
        what: &'static str,
    },
    /// A document that this store wrote cannot be read.
    #[error("could not understand {}", path.display())]
    Document {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it.
        #[source]
        source: serde_json::Error,
    },
}

impl StoreError {
    pub(crate) fn io(action: &'static str, path: &Path, source: io::Error) -> Self {
        Self::Io { action, path: path.to_owned(), source }
    }
}
