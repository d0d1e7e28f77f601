//! Failure of a command: one sentence and an exit code.

use crate::texts;
use ports::error_with_causes;
use std::error::Error;
use std::fmt::{self, Display};
use std::path::Path;
use std::process::ExitCode;
use vocab::legible;

/// Characters of the error of an input file that the sentence shows, at most. It can quote any text of the file.
const MAX_SHOWN_REASON_CHARS: usize = 600;

/// One sentence for people, with the kind of failure.
#[derive(Debug)]
pub enum Failure {
    /// Bad usage or unreadable input: exit code 2.
    Usage(String),
    /// Any other failure: exit code 1.
    Failed(String),
    /// Another process of this program has printed the sentence.
    Reported {
        /// Whether the failure is [`Self::Usage`].
        usage: bool,
    },
}

impl Failure {
    /// Failure by bad usage or unreadable input.
    pub fn usage(reason: impl Into<Box<dyn Error>>) -> Self {
        Self::Usage(error_with_causes(&*reason.into()))
    }

    /// Any other failure.
    pub fn failed(reason: impl Into<Box<dyn Error>>) -> Self {
        Self::Failed(error_with_causes(&*reason.into()))
    }

    /// Failure by an input file that is missing or of another kind.
    pub fn unreadable(path: &Path, error: impl Error) -> Self {
        let reason = legible(&error_with_causes(&error), MAX_SHOWN_REASON_CHARS);
        Self::Usage(texts::could_not_be_read(path, &reason))
    }

    /// The exit code of the process.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Usage(_) | Self::Reported { usage: true } => ExitCode::from(2),
            Self::Failed(_) | Self::Reported { usage: false } => ExitCode::from(1),
        }
    }

    /// The sentence, unless it was printed already.
    pub fn sentence(&self) -> Option<&str> {
        match self {
            Self::Usage(sentence) | Self::Failed(sentence) => Some(sentence),
            Self::Reported { .. } => None,
        }
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.sentence().unwrap_or_default())
    }
}
