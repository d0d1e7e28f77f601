//! Frames of the Unix sockets between processes of the platform: a message in postcard after its length, a little-endian `u32`.

use api::DecodeError;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io::{self, Read};

/// Bytes of the length before each message.
const LENGTH_BYTES: usize = 4;

/// Why bytes are no frame.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// The frame announces more bytes than its reader accepts.
    #[error("it announces a message of {bytes} bytes; the contract allows {max_bytes}")]
    TooLong {
        /// Announced length.
        bytes: usize,
        /// Largest accepted length.
        max_bytes: usize,
    },
    /// The bytes are no message of the expected type.
    #[error(transparent)]
    Malformed(#[from] DecodeError),
}

/// The message as a frame.
pub fn encode_frame(message: &impl Serialize) -> Vec<u8> {
    let mut bytes = api::encode_after(vec![0; LENGTH_BYTES], message);
    // No message is near 4 GiB, because its reader would refuse it.
    let length = (bytes.len() - LENGTH_BYTES) as u32;
    bytes[..LENGTH_BYTES].copy_from_slice(&length.to_le_bytes());
    bytes
}

/// Reads the next message; `None` at the end of the stream, also within a frame.
///
/// # Errors
/// When reading fails, or with [`io::ErrorKind::InvalidData`] and a [`FrameError`] when the bytes are no frame of at most `max_bytes`.
pub fn read_frame<T: DeserializeOwned>(reader: &mut impl Read, max_bytes: usize) -> io::Result<Option<T>> {
    let mut length = [0; LENGTH_BYTES];
    match reader.read_exact(&mut length) {
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
        other => other?,
    }
    let bytes = u32::from_le_bytes(length) as usize;
    if bytes > max_bytes {
        return Err(invalid(FrameError::TooLong { bytes, max_bytes }));
    }
    // The buffer grows with the bytes that arrive, not with the length that is announced.
    let mut body = Vec::new();
    reader.take(bytes as u64).read_to_end(&mut body)?;
    if body.len() < bytes {
        return Ok(None);
    }
    api::decode(&body).map(Some).map_err(|error| invalid(error.into()))
}

fn invalid(error: FrameError) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_read_as_they_were_written_until_the_stream_ends() {
        let mut stream = encode_frame(&(7_u32, "seven"));
        assert_eq!(stream[..4], [stream.len() as u8 - 4, 0, 0, 0]);
        stream.extend(encode_frame(&(8_u32, "eight")));
        stream.extend([9, 0]);
        let reader = &mut &stream[..];
        let mut next = || read_frame::<(u32, String)>(reader, 100).expect("frames");
        assert_eq!(next(), Some((7, "seven".to_owned())));
        assert_eq!(next(), Some((8, "eight".to_owned())));
        assert_eq!(next(), None);
        let cut = encode_frame(&"seven");
        assert_eq!(read_frame::<String>(&mut &cut[..cut.len() - 1], 100).expect("ends"), None);
    }

    #[test]
    fn long_and_malformed_frames_are_errors() {
        let frame = encode_frame(&"seven");
        for (bytes, max_bytes) in [(&frame[..], 5), (&[255; 4][..], 100), (&[1, 0, 0, 0, 255][..], 100)] {
            let error = read_frame::<String>(&mut &bytes[..], max_bytes).expect_err("no frame");
            assert_eq!(error.kind(), io::ErrorKind::InvalidData);
        }
    }
}
