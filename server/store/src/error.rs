//! Errors of the store: one sentence each.

use std::io;
use std::path::{Path, PathBuf};
use vocab::{MapId, SessionId, legible};

/// Why something could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The disk or a permission.
    #[error("could not {action} {}", path.display())]
    Io {
        /// The action: "read", "write".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// The system's error.
        #[source]
        source: io::Error,
    },
    /// Another process has the data directory open.
    #[error("{} is in use by another AutoInspect; stop that one or choose another directory", dir.display())]
    InUse {
        /// The data directory.
        dir: PathBuf,
    },
    /// Map versions are immutable.
    #[error("map {id} is already saved")]
    MapExists {
        /// The version.
        id: MapId,
    },
    /// A map of this id was deleted and is kept.
    #[error("map {id} is in the bin; restore it, or delete it there for good")]
    MapInBin {
        /// The map.
        id: MapId,
    },
    /// A map that does not exist.
    #[error("there is no saved map {id}")]
    NoSuchMap {
        /// The map.
        id: MapId,
    },
    /// A map that was deleted for good, or restored.
    #[error("map {id} is not in the bin")]
    NotInBin {
        /// The map.
        id: MapId,
    },
    /// A session without keyframes cannot be saved.
    #[error("session {session} has no keyframes; let the robot see something before saving")]
    EmptySession {
        /// The session.
        session: SessionId,
    },
    /// A cloud, graph or trajectory that this store wrote cannot be read.
    #[error("could not understand {}", path.display())]
    Cloud {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        #[source]
        source: formats::FormatError,
    },
    /// A file of a map is damaged or contradicts the others.
    #[error("{} {what}; make the map again", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// What is wrong: the middle of the sentence.
        what: &'static str,
    },
    /// A file and its checksum in another file contradict each other.
    #[error("{} does not match its checksum in {}, so one of both is damaged", path.display(), checksums.display())]
    ListedChecksum {
        /// The file.
        path: PathBuf,
        /// The file with its checksum.
        checksums: PathBuf,
    },
    /// A file with a checksum in another file is not there.
    #[error("{} is missing, or {}, which lists it, is damaged", path.display(), checksums.display())]
    ListedFileMissing {
        /// The file.
        path: PathBuf,
        /// The file with its checksum.
        checksums: PathBuf,
    },
    /// A file has changed since this store wrote it.
    #[error("{} does not match its checksum, so it is damaged", path.display())]
    Checksum {
        /// The file.
        path: PathBuf,
    },
    /// A document that a later program wrote.
    #[error("{} has version {version} and this program reads up to {newest}; update AutoInspect", path.display())]
    LaterVersion {
        /// The file.
        path: PathBuf,
        /// Its version.
        version: u32,
        /// The newest version that this program reads.
        newest: u32,
    },
    /// SQLite reports an error.
    #[error("could not use {}", path.display())]
    Database {
        /// The file.
        path: PathBuf,
        /// What SQLite says.
        #[source]
        source: rusqlite::Error,
    },
    /// The ledger is damaged.
    #[error("{} {what}", path.display())]
    Ledger {
        /// The file.
        path: PathBuf,
        /// What is wrong: the rest of the sentence.
        what: &'static str,
    },
    /// A row of the ledger is whole, and this program does not understand it.
    #[error("{} holds a row that this program does not understand; update AutoInspect", path.display())]
    LedgerRow {
        /// The file.
        path: PathBuf,
    },
    /// A document that this store wrote cannot be read.
    #[error("could not understand {}: {problem}", path.display())]
    Document {
        /// The file.
        path: PathBuf,
        /// What the JSON reader says. That can quote any text of the file, so it is made legible, and is no source.
        problem: String,
    },
}

/// Characters of the JSON reader's error that ours shows, at most.
const MAX_SHOWN_JSON_ERROR_CHARS: usize = 200;

impl StoreError {
    pub(crate) fn io(action: &'static str, path: &Path, source: io::Error) -> Self {
        Self::Io { action, path: path.to_owned(), source }
    }

    pub(crate) fn document(path: &Path, error: &serde_json::Error) -> Self {
        let problem = legible(&error.to_string(), MAX_SHOWN_JSON_ERROR_CHARS);
        Self::Document { path: path.to_owned(), problem }
    }
}
