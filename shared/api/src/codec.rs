//! Messages to bytes and back: postcard, with a bound on what is accepted.

use serde::{Serialize, de::DeserializeOwned};

/// Longest message accepted by any side, bytes. The longest that is sent is a part of a graph, a live scan or the list of maps, a few MB: tiles and graphs
/// of any size are sent in parts.
pub const MAX_MESSAGE_BYTES: usize = 32 << 20;

/// Why bytes are no message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DecodeError {
    /// Longer than [`MAX_MESSAGE_BYTES`].
    TooLong {
        /// How long it was.
        bytes: usize,
    },
    /// Not what this version of the contract expects.
    Malformed(postcard::Error),
}

impl std::fmt::Display for DecodeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooLong { bytes } => write!(f, "a message of {bytes} bytes exceeds {MAX_MESSAGE_BYTES}"),
            Self::Malformed(error) => write!(f, "a message could not be understood: {error}"),
        }
    }
}

impl std::error::Error for DecodeError {}

/// Message to bytes. Total for the types of this crate: they hold no map keys or sizes postcard refuses.
pub fn encode<T: Serialize>(message: &T) -> Vec<u8> {
    postcard::to_stdvec(message).unwrap_or_default()
}

/// As [`encode`], after the bytes of `start`.
pub fn encode_after<T: Serialize>(start: Vec<u8>, message: &T) -> Vec<u8> {
    postcard::to_extend(message, start).unwrap_or_default()
}

/// Bytes to message; every byte must be used.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, DecodeError> {
    if bytes.len() > MAX_MESSAGE_BYTES {
        return Err(DecodeError::TooLong { bytes: bytes.len() });
    }
    match postcard::take_from_bytes(bytes) {
        Ok((message, [])) => Ok(message),
        Ok(_) => Err(DecodeError::Malformed(postcard::Error::DeserializeBadEncoding)),
        Err(error) => Err(DecodeError::Malformed(error)),
    }
}
