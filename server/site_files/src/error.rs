//! Why a site cannot be read or written.

use std::fmt;
use std::path::{Path, PathBuf};

/// A file of a site cannot be used. The text is one sentence: the file, what is wrong, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SiteFileError {
    file: PathBuf,
    reason: String,
}

impl SiteFileError {
    pub(crate) fn new(file: &Path, reason: impl Into<String>) -> Self {
        Self { file: file.to_owned(), reason: reason.into() }
    }
}

impl fmt::Display for SiteFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.file.display(), self.reason)
    }
}

impl std::error::Error for SiteFileError {}
