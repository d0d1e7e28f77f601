//! LZF decompression, as PCD's `binary_compressed` uses it.
//!
//! A control byte below 32 starts a literal run of one more byte than it says; any other carries a length in its
//! upper three bits (7: one more byte follows) and a distance in its lower five and the next byte.
//! Source: liblzf 3.6, "lzf.h".

use crate::FormatError;

/// Decompresses `input` into exactly `length` bytes.
///
/// # Errors
/// When the input refers before its start, ends early or yields another length. Allocates no more than the
/// input can yield: a run of 3 bytes makes at most 264.
pub fn decompress(input: &[u8], length: usize) -> Result<Vec<u8>, FormatError> {
    let broken = |at: usize, problem: &str| FormatError::at_byte("LZF data", at as u64, problem);
    if length > input.len().saturating_mul(264) {
        return Err(broken(0, "the stated size is larger than the data can unpack to"));
    }
    let mut out = Vec::with_capacity(length);
    let mut at = 0;
    let next = |at: &mut usize| {
        let byte = input.get(*at).copied().ok_or_else(|| broken(*at, "the data is cut off"))?;
        *at += 1;
        Ok::<_, FormatError>(usize::from(byte))
    };
    while at < input.len() {
        let control = next(&mut at)?;
        if control < 32 {
            let run = input.get(at..at + control + 1).ok_or_else(|| broken(at, "the data is cut off"))?;
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
                .ok_or_else(|| broken(at, "a reference precedes the start"))?;
            // Source and target may overlap, so byte by byte.
            for i in start..start + run + 2 {
                out.push(out[i]);
            }
        }
        if out.len() > length {
            return Err(broken(at, "it unpacks to more than the stated size"));
        }
    }
    if out.len() != length {
        return Err(broken(at, "it unpacks to less than the stated size"));
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
