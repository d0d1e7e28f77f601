//! Integers as bytes, in several classes that are compressed apart from each other.
//!
//! A small number takes one byte of the stream of its class, and a large one the byte 255 there and further bytes of the stream of escapes. Numbers of
//! a class are of similar size, so that the entropy coder of zstd (one Huffman table for each stream) comes near their entropy.

use crate::error::RangeImageError;
use crate::texts;

/// Byte that announces an escape.
const ESCAPE: u64 = 255;
/// zstd's fastest level. Noise has no repetitions that a higher one could find.
const ZSTD_LEVEL: i32 = 1;
/// Bytes before each stream: its unpacked and its packed length, each u32.
const STREAM_HEADER_LEN: usize = 8;

/// Writes numbers.
pub(crate) struct SymbolWriter {
    classes: Vec<Vec<u8>>,
    escapes: Vec<u8>,
}

impl SymbolWriter {
    pub fn new(classes: usize) -> Self {
        Self { classes: vec![Vec::new(); classes], escapes: Vec::new() }
    }

    pub fn put(&mut self, class: usize, value: i64) {
        let folded = zigzag(value);
        if folded < ESCAPE {
            self.classes[class].push(folded as u8);
            return;
        }
        self.classes[class].push(ESCAPE as u8);
        let mut rest = folded - ESCAPE;
        while rest >= 128 {
            self.escapes.push(rest as u8 | 128);
            rest >>= 7;
        }
        self.escapes.push(rest as u8);
    }

    /// Appends the streams to `out`.
    pub fn finish(self, out: &mut Vec<u8>) {
        for stream in self.classes.iter().chain([&self.escapes]) {
            pack(stream, out);
        }
    }
}

/// Reads what [`SymbolWriter`] wrote.
pub(crate) struct SymbolReader {
    classes: Vec<std::vec::IntoIter<u8>>,
    escapes: std::vec::IntoIter<u8>,
}

impl SymbolReader {
    /// Takes the streams from the start of `bytes`. No more than `symbols` numbers are expected.
    pub fn new(classes: usize, symbols: usize, bytes: &mut &[u8]) -> Result<Self, RangeImageError> {
        let classes: Result<Vec<_>, _> =
            (0..classes).map(|_| unpack(bytes, symbols).map(Vec::into_iter)).collect();
        // An escape takes at most ten bytes.
        Ok(Self { classes: classes?, escapes: unpack(bytes, symbols.saturating_mul(10))?.into_iter() })
    }

    pub fn get(&mut self, class: usize) -> Result<i64, RangeImageError> {
        let short = RangeImageError::Malformed(texts::NUMBERS_END_EARLY);
        let first = self.classes.get_mut(class).and_then(Iterator::next).ok_or(short.clone())?;
        let mut folded = u64::from(first);
        if folded == ESCAPE {
            let mut shift = 0;
            loop {
                let byte = self.escapes.next().ok_or(short.clone())?;
                if shift > 56 {
                    return Err(RangeImageError::Malformed(texts::NUMBER_TOO_LARGE));
                }
                folded = folded.saturating_add(u64::from(byte & 127) << shift);
                shift += 7;
                if byte < 128 {
                    break;
                }
            }
        }
        Ok((folded >> 1) as i64 ^ -((folded & 1) as i64))
    }
}

/// Appends a stream: its unpacked length, its packed length, and its bytes; with both lengths the same, they are not packed.
pub(crate) fn pack(stream: &[u8], out: &mut Vec<u8>) {
    let packed = zstd::bulk::compress(stream, ZSTD_LEVEL).ok().filter(|packed| packed.len() < stream.len());
    let bytes = packed.as_deref().unwrap_or(stream);
    out.extend((stream.len() as u32).to_le_bytes());
    out.extend((bytes.len() as u32).to_le_bytes());
    out.extend(bytes);
}

/// Takes a stream of at most `max_length` unpacked bytes from the start of `bytes`.
pub(crate) fn unpack(bytes: &mut &[u8], max_length: usize) -> Result<Vec<u8>, RangeImageError> {
    let short = RangeImageError::Malformed(texts::ENDS_WITHIN_STREAM);
    let (header, rest) = bytes.split_at_checked(STREAM_HEADER_LEN).ok_or(short.clone())?;
    let length =
        |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]) as usize;
    let (unpacked, packed) = (length(0), length(4));
    if unpacked > max_length {
        return Err(RangeImageError::Malformed(texts::STREAM_TOO_LONG));
    }
    let (body, rest) = rest.split_at_checked(packed).ok_or(short)?;
    *bytes = rest;
    if packed == unpacked {
        return Ok(body.to_vec());
    }
    match zstd::bulk::decompress(body, unpacked) {
        Ok(stream) if stream.len() == unpacked => Ok(stream),
        _ => Err(RangeImageError::Malformed(texts::STREAM_NOT_UNPACKED)),
    }
}

fn zigzag(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)) as u64
}
