//! Why bytes are no range image.

use thiserror::Error;

/// Why a range image cannot be decoded.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum RangeImageError {
    /// It was written by a later program.
    #[error("the range image has version {0}, which is not known; read it with a newer program")]
    Version(u8),
    /// It is damaged.
    #[error("the range image is damaged ({0}), so this scan is lost")]
    Malformed(&'static str),
}
