//! Records of a bag: a header of named fields, then data.

use crate::{FormatError, MAX_CHUNK_BYTES, texts};
use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};
use vocab::Stamp;

/// The format, for errors.
pub const WHAT: &str = "ROS 1 bag";

/// Kinds of records.
pub mod op {
    pub const MESSAGE: u8 = 2;
    pub const CHUNK: u8 = 5;
    pub const CHUNK_INFO: u8 = 6;
    pub const CONNECTION: u8 = 7;
}

/// Longest header of a record that is read, bytes.
const MAX_HEADER_BYTES: u64 = 1 << 20;

/// A record's header and the position of its data.
pub struct Record {
    fields: BTreeMap<String, Vec<u8>>,
    /// Offset of the record, for errors.
    at: u64,
    pub data_start: u64,
    pub data_length: u64,
}

impl Record {
    pub fn end(&self) -> u64 {
        self.data_start + self.data_length
    }

    pub fn op(&self) -> Option<u8> {
        self.fields.get("op")?.first().copied()
    }

    pub fn text(&self, name: &str) -> Option<String> {
        self.fields.get(name).map(|value| String::from_utf8_lossy(value).into_owned())
    }

    pub fn u32(&self, name: &str) -> Result<u32, FormatError> {
        self.array(name).map(u32::from_le_bytes)
    }

    pub fn u64(&self, name: &str) -> Result<u64, FormatError> {
        self.array(name).map(u64::from_le_bytes)
    }

    /// ROS 1 writes times as two unsigned 32-bit numbers.
    pub fn time(&self, name: &str) -> Result<Stamp, FormatError> {
        let both = self.u64(name)?;
        Ok(Stamp::from_parts(i64::from(both as u32), (both >> 32) as u32))
    }

    fn array<const N: usize>(&self, name: &str) -> Result<[u8; N], FormatError> {
        let value = self.fields.get(name).and_then(|value| value.as_slice().try_into().ok());
        value.ok_or_else(|| FormatError::at_byte(WHAT, self.at, texts::record_field_missing(name)))
    }
}

/// Reads the header of the record at `at` of a file.
pub fn read_head(file: &mut (impl Read + Seek), size: u64, at: u64) -> Result<Record, FormatError> {
    let header_length = u64::from(le_u32(&read_bytes(file, size, at, 4)?));
    if header_length > MAX_HEADER_BYTES {
        return Err(FormatError::at_byte(WHAT, at, texts::RECORD_HEADER_TOO_LONG));
    }
    let header = read_bytes(file, size, at + 4, header_length)?;
    let data_length = u64::from(le_u32(&read_bytes(file, size, at + 4 + header_length, 4)?));
    Ok(Record { fields: parse_fields(&header)?, at, data_start: at + 8 + header_length, data_length })
}

/// Reads the header of the record at `at` of an unpacked chunk.
pub fn parse_head(bytes: &[u8], at: usize) -> Result<Record, FormatError> {
    let cut = || FormatError::Truncated { what: WHAT, at: at as u64, missing: 1 };
    let rest = bytes.get(at..).ok_or_else(cut)?;
    let header_length = le_u32(rest.get(..4).ok_or_else(cut)?) as usize;
    let header = rest.get(4..).and_then(|rest| rest.get(..header_length)).ok_or_else(cut)?;
    let after = rest.get(4 + header_length..).and_then(|rest| rest.get(..4)).ok_or_else(cut)?;
    let data_start = (at + 8 + header_length) as u64;
    Ok(Record { fields: parse_fields(header)?, at: at as u64, data_start, data_length: le_u32(after).into() })
}

/// Splits `name=value` fields, each with its length in front.
pub fn parse_fields(bytes: &[u8]) -> Result<BTreeMap<String, Vec<u8>>, FormatError> {
    let mut fields = BTreeMap::new();
    let mut rest = bytes;
    while !rest.is_empty() {
        let cut =
            || FormatError::at_byte(WHAT, (bytes.len() - rest.len()) as u64, texts::RECORD_HEADER_CUT_OFF);
        let length = le_u32(rest.get(..4).ok_or_else(cut)?) as usize;
        let field = rest.get(4..).and_then(|rest| rest.get(..length)).ok_or_else(cut)?;
        let equals = field.iter().position(|byte| *byte == b'=').ok_or_else(cut)?;
        fields.insert(String::from_utf8_lossy(&field[..equals]).into_owned(), field[equals + 1..].to_vec());
        rest = &rest[4 + length..];
    }
    Ok(fields)
}

/// Reads a range of a file after checking that it is there.
pub fn read_bytes(
    file: &mut (impl Read + Seek),
    size: u64,
    at: u64,
    length: u64,
) -> Result<Vec<u8>, FormatError> {
    let end = at.saturating_add(length);
    if end > size || length > MAX_CHUNK_BYTES {
        return Err(FormatError::Truncated { what: WHAT, at, missing: end.saturating_sub(size) });
    }
    file.seek(SeekFrom::Start(at))?;
    let mut bytes = vec![0; length as usize];
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// The first four bytes as a number; callers have checked that there are four.
fn le_u32(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}
