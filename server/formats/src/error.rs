//! Errors of reading a file or message: one sentence with what is wrong, where, and what to do. The details are in `texts.rs`.

use std::io;
use vocab::legible;

/// Why bytes could not be understood.
#[derive(Debug, thiserror::Error)]
pub enum FormatError {
    /// The bytes stop before the value does.
    #[error(
        "{what} is cut off at byte {at}: {missing} more byte(s) were expected; copy or record the file again"
    )]
    Truncated {
        /// What was being read.
        what: &'static str,
        /// Offset of the value in the file or message.
        at: u64,
        /// Bytes that would have been needed, at least.
        missing: u64,
    },
    /// The bytes are of another format.
    #[error("this is not {expected}: {found}")]
    WrongKind {
        /// With its article: "a PCD file".
        expected: &'static str,
        /// What is there instead, and what to do.
        found: String,
    },
    /// The bytes contradict the format or themselves.
    #[error("{what} at {place}: {problem}")]
    Malformed {
        /// What was being read.
        what: &'static str,
        /// Byte, line or field.
        place: String,
        /// What is wrong and, where that helps, what to do.
        problem: String,
    },
    /// Correct, but not supported by this reader.
    #[error("{what} is not supported; {remedy}")]
    Unsupported {
        /// What is not supported.
        what: String,
        /// What to do about it.
        remedy: &'static str,
    },
    /// The file could not be read at all.
    #[error("the file could not be read: {0}")]
    Io(#[from] io::Error),
    /// The database could not be read, with what SQLite says. That can quote any text of the file, so it is made legible, and is no source.
    #[error("the SQLite database could not be read: {0}; if it was cut off, record or copy it again")]
    Database(String),
}

/// Characters of SQLite's error that ours shows, at most.
const MAX_SHOWN_DATABASE_ERROR_CHARS: usize = 200;

impl From<rusqlite::Error> for FormatError {
    fn from(error: rusqlite::Error) -> Self {
        Self::Database(legible(&error.to_string(), MAX_SHOWN_DATABASE_ERROR_CHARS))
    }
}

impl FormatError {
    /// A contradiction at a byte offset.
    pub(crate) fn at_byte(what: &'static str, at: u64, problem: impl Into<String>) -> Self {
        Self::Malformed { what, place: format!("byte {at}"), problem: problem.into() }
    }

    /// A contradiction in a line of text, counted from 1.
    pub(crate) fn at_line(what: &'static str, line: usize, problem: impl Into<String>) -> Self {
        Self::Malformed { what, place: format!("line {line}"), problem: problem.into() }
    }
}
