//! Why a recording could not be opened, read or written: one sentence each, with what to do.

use formats::FormatError;
use std::path::PathBuf;
use vocab::Stamp;

/// Why a recording could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Nothing there, or no right to read it.
    #[error("{} could not be opened: {source}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Not a recording of a known kind.
    #[error("{} is not a recording: {problem}", path.display())]
    NotARecording {
        /// Which file or folder.
        path: PathBuf,
        /// What it is instead, and what to do.
        problem: String,
    },
    /// A recording of a known kind, but unreadable.
    #[error("{} could not be read: {source}", path.display())]
    Format {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        source: FormatError,
    },
    /// A recording without anything to map from.
    #[error("{} holds nothing to work with: {problem}", path.display())]
    Nothing {
        /// Which file or folder.
        path: PathBuf,
        /// What was looked for.
        problem: String,
    },
    /// The caller asked for a topic that is not there.
    #[error("topic '{topic}' is not in {}; the topics are: {present}", path.display())]
    NoSuchTopic {
        /// Which file or folder.
        path: PathBuf,
        /// What was asked for.
        topic: String,
        /// What there is.
        present: String,
    },
    /// The caller asked for a topic whose messages cannot serve that purpose.
    #[error("topic '{topic}' holds {type_name}, which cannot serve as {purpose}; choose another topic")]
    WrongTopicType {
        /// What was asked for.
        topic: String,
        /// What it holds.
        type_name: String,
        /// What it was to be used for.
        purpose: String,
    },
}

/// Something wrong within a recording. Reading goes on after it where it can.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file could not be read.
    #[error("{} could not be read: {source}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A piece of the file is broken; what it held is lost.
    #[error("{} is damaged at byte {at}: {problem}", path.display())]
    Damaged {
        /// Which file.
        path: PathBuf,
        /// Where the piece begins.
        at: u64,
        /// What is wrong with it.
        problem: String,
    },
    /// A file of a scan folder or a bag that is broken.
    #[error("{} could not be read: {source}", path.display())]
    Format {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        source: FormatError,
    },
    /// A message that could not be understood; the others of its topic may be fine.
    #[error("the message on '{topic}' logged at {:.3} s could not be read: {source}", at.secs_f64())]
    Message {
        /// Its topic.
        topic: String,
        /// When it was logged.
        at: Stamp,
        /// What is wrong.
        source: FormatError,
    },
    /// A measurement older than the one before it on the same topic; it is left out.
    #[error(
        "'{topic}' goes back in time by {by:.3} s at {:.3} s, so this message is left out; check the clock of the \
         recording machine",
        at.secs_f64()
    )]
    Backward {
        /// Its topic.
        topic: String,
        /// When it was logged.
        at: Stamp,
        /// How far back its own stamp goes, seconds.
        by: f64,
    },
    /// A scan of which nothing is left; it is left out.
    #[error(
        "the scan on '{topic}' at {:.3} s has no usable point ({points} were not finite or had no return), so it is left \
         out; check that the LiDAR sees anything",
        at.secs_f64()
    )]
    EmptyScan {
        /// Its topic.
        topic: String,
        /// When it was logged.
        at: Stamp,
        /// Points it had.
        points: usize,
    },
    /// Asked to replay a recording that does not hold what the stack was told.
    #[error("this recording has no '{}' channel, so it can be mapped but not replayed", crate::topics::INPUT)]
    NotAJournal,
    /// The journal was written by another version of the platform.
    #[error(
        "the journal was written with schema '{found}' but this program reads '{}'; use the version that wrote it",
        crate::topics::INPUT_SCHEMA
    )]
    OtherJournalVersion {
        /// Schema name in the file.
        found: String,
    },
}

/// Why a recording could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The file could not be made.
    #[error("{} could not be created: {source}", path.display())]
    Create {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The disk refused, most likely because it is full.
    #[error("the recording {} could not be written: {source}; check the space on the disk", path.display())]
    Mcap {
        /// Which file.
        path: PathBuf,
        /// What went wrong.
        source: mcap::McapError,
    },
    /// An input could not be encoded.
    #[error("an input could not be encoded for the recording: {0}")]
    Encode(#[from] postcard::Error),
}
