//! LZF decompression, as PCD's `binary_compressed` uses it.
//!
//! A control byte `c` below 32 is followed by `c + 1` literal bytes. Any other control byte is a reference to earlier output: its upper three
//! bits are the length less 2 (7: the next byte is added), its lower five bits and the next byte are the distance less 1.
//! Source: liblzf 3.6, "lzf.h".

use crate::{FormatError, texts};

/// Bytes of output per byte of input, at most: the longest reference takes 3 bytes and yields 7 + 255 + 2.
const MAX_YIELD: usize = 264;

/// Decompresses `input` into exactly `length` bytes.
///
/// # Errors
/// When the input refers to bytes before its start, ends early or yields another length. Allocates no more than the input can yield.
pub fn decompress(input: &[u8], length: usize) -> Result<Vec<u8>, FormatError> {
    let malformed = |at: usize, problem: &str| FormatError::at_byte("LZF data", at as u64, problem);
    if length > input.len().saturating_mul(MAX_YIELD) {
        return Err(malformed(0, texts::LZF_SIZE_IMPOSSIBLE));
    }
    let mut out = Vec::with_capacity(length);
    let mut at = 0;
    let next = |at: &mut usize| {
        let byte = input.get(*at).copied().ok_or_else(|| malformed(*at, texts::LZF_CUT_OFF))?;
        *at += 1;
        Ok::<_, FormatError>(usize::from(byte))
    };
    while at < input.len() {
        let control = next(&mut at)?;
        if control < 32 {
            let run = input.get(at..at + control + 1).ok_or_else(|| malformed(at, texts::LZF_CUT_OFF))?;
            out.extend_from_slice(run);
            at += control + 1;
        } else {
            let mut run = control >> 5;
            if run == 7 {
                run += next(&mut at)?;
            }
            let distance = ((control & 31) << 8) + next(&mut at)? + 1;
            let start = out
                .len()
                .checked_sub(distance)
                .ok_or_else(|| malformed(at, texts::LZF_REFERENCE_BEFORE_START))?;
            // Source and target may overlap, so byte by byte.
            for i in start..start + run + 2 {
                out.push(out[i]);
            }
        }
        if out.len() > length {
            return Err(malformed(at, texts::LZF_TOO_LONG));
        }
    }
    if out.len() != length {
        return Err(malformed(at, texts::LZF_TOO_SHORT));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_and_overlapping_references_unpack() {
        // "ab", then 6 bytes from 2 back.
        assert_eq!(decompress(&[1, b'a', b'b', 4 << 5, 1], 8).unwrap(), b"abababab");
        // A long run: 7 + 3 + 2 bytes from 1 back.
        assert_eq!(decompress(&[0, b'x', 7 << 5, 3, 0], 13).unwrap(), [b'x'; 13]);
    }

    #[test]
    fn broken_data_is_refused() {
        for (input, length) in
            [(&[1, b'a'][..], 2), (&[32, 0][..], 3), (&[0, b'x'][..], 2), (&[0, b'x'][..], usize::MAX)]
        {
            assert!(decompress(input, length).is_err(), "{input:?}");
        }
    }
}
