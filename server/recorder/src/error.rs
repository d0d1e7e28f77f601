//! Errors of opening, reading and writing recordings. Each is one sentence with the remedy.

use formats::FormatError;
use std::path::PathBuf;
use vocab::Stamp;

/// Why a recording could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The file does not exist or may not be read.
    #[error("{} could not be opened: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// Not a recording of a known kind.
    #[error("{} is not a recording: {problem}", path.display())]
    NotARecording {
        /// The file or folder.
        path: PathBuf,
        /// The kind of file that it is, and the remedy.
        problem: String,
    },
    /// A recording of a known kind, but unreadable.
    #[error("{} could not be read: {source}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// The error.
        source: FormatError,
    },
    /// A recording without usable topics.
    #[error("{} holds nothing to work with: {problem}", path.display())]
    Nothing {
        /// The file or folder.
        path: PathBuf,
        /// The missing content.
        problem: String,
    },
    /// The caller asked for a topic that the recording does not have.
    #[error("topic '{topic}' is not in {}; the topics are: {present}", path.display())]
    NoSuchTopic {
        /// The file or folder.
        path: PathBuf,
        /// The topic that was asked for.
        topic: String,
        /// The topics that exist.
        present: String,
    },
    /// The caller asked for a topic whose messages cannot have that role.
    #[error("topic '{topic}' holds {type_name}, which cannot serve as {purpose}; choose another topic")]
    WrongTopicType {
        /// The topic that was asked for.
        topic: String,
        /// Type of its messages.
        type_name: String,
        /// The role that it was chosen for.
        purpose: String,
    },
}

/// A problem within a recording. Reading continues after it if possible.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file could not be read.
    #[error("{} could not be read: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A part of the file is damaged; its messages are lost.
    #[error("{} is damaged at byte {at}: {problem}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Offset of the part in the file, bytes.
        at: u64,
        /// The damage.
        problem: String,
    },
    /// A damaged file of a scan folder or a damaged bag.
    #[error("{} could not be read: {source}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// The error.
        source: FormatError,
    },
    /// A message that could not be decoded; other messages of its topic may be readable.
    #[error("the message on '{topic}' logged at {:.3} s could not be read: {source}", at.secs_f64())]
    Message {
        /// Its topic.
        topic: String,
        /// When it was logged.
        at: Stamp,
        /// The error.
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
        /// Time by which its own stamp is before the previous one, s.
        by: f64,
    },
    /// A scan without a usable point; it is left out.
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
        /// Number of its points.
        points: usize,
    },
    /// The recording does not hold the inputs of a stack, so it cannot be replayed.
    #[error("this recording has no '{}' channel, so it can be mapped but not replayed", crate::topics::INPUT)]
    NotAJournal,
    /// A later segment of a run: the state of the stack at its start is not known.
    #[error(
        "{} is segment {segment} of its run, and a replay begins with segment 0; give the folder of the run, or map this \
         segment",
        path.display()
    )]
    NotFromBoot {
        /// The file.
        path: PathBuf,
        /// Its number.
        segment: String,
    },
    /// Inputs are missing between two segments of a run.
    #[error(
        "inputs are missing before {segment} of run {run} (segments were removed for space, or recording paused), so the \
         run can be replayed up to there only"
    )]
    MissingInputs {
        /// The run.
        run: String,
        /// The first segment after the gap.
        segment: String,
    },
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
    /// The file could not be created.
    #[error("{} could not be created: {source}", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// Writing failed, most likely because the disk is full.
    #[error("the recording {} could not be written: {source}; check the space on the disk", path.display())]
    Mcap {
        /// The file.
        path: PathBuf,
        /// Error of the MCAP library.
        source: mcap::McapError,
    },
    /// An input could not be encoded.
    #[error("an input could not be encoded for the recording: {0}")]
    Encode(#[from] postcard::Error),
}
