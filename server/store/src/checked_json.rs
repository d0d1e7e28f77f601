//! JSON documents that detect damage: the first field is the BLAKE3 of all that follows it, so that also a wrong digit is noticed.
//!
//! ```text
//! {"checksum":"<64 hexadecimal digits>",
//!   "format_version": 2, ...
//! ```

use crate::{StoreError, files};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::fs;
use std::path::Path;

const START: &[u8] = b"{\"checksum\":\"";
const END: &[u8] = b"\",";

/// Versions of a document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Versions {
    /// The first one with a checksum.
    pub first_checked: u32,
    /// The newest one that this program reads.
    pub newest: u32,
}

/// What every document has, or has had from some version on.
#[derive(Deserialize)]
struct Header {
    #[serde(default = "files::first_format_version")]
    format_version: u32,
    checksum: Option<String>,
}

/// A document as its file's content. It has to be an object with at least one field.
pub(crate) fn to_checked_json(path: &Path, document: &impl Serialize) -> Result<Vec<u8>, StoreError> {
    let text = serde_json::to_vec_pretty(document).map_err(|error| StoreError::document(path, &error))?;
    let rest = text.strip_prefix(b"{").unwrap_or(&text);
    Ok([START, blake3::hash(rest).to_hex().as_bytes(), END, rest].concat())
}

/// Reads a document, also one of a version that had no checksum.
///
/// # Errors
/// When it is missing, damaged, or of a later version.
pub(crate) fn read_checked_json<T: DeserializeOwned>(
    path: &Path,
    versions: Versions,
) -> Result<T, StoreError> {
    let bytes = fs::read(path).map_err(|source| StoreError::io("read", path, source))?;
    let not_understood = |error| StoreError::document(path, &error);
    let header: Header = serde_json::from_slice(&bytes).map_err(not_understood)?;
    let damaged = || StoreError::Checksum { path: path.to_owned() };
    let content = content(&bytes);
    // Before the version, which may be what is damaged.
    if content.is_some_and(|(checksum, rest)| checksum != blake3::hash(rest).to_hex().as_bytes()) {
        return Err(damaged());
    }
    files::check_version(path, header.format_version, versions.newest)?;
    let is_of_version_without = header.checksum.is_none() && header.format_version < versions.first_checked;
    if content.is_none() && !is_of_version_without {
        return Err(damaged());
    }
    serde_json::from_slice(&bytes).map_err(not_understood)
}

/// The checksum and what it is of.
fn content(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let rest = bytes.strip_prefix(START)?;
    let (checksum, rest) = rest.split_at_checked(blake3::OUT_LEN * 2)?;
    Some((checksum, rest.strip_prefix(END)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Document {
        #[serde(default = "files::first_format_version")]
        format_version: u32,
        x: f64,
    }

    const VERSIONS: Versions = Versions { first_checked: 2, newest: 3 };

    #[test]
    fn every_wrong_bit_and_every_cut_is_found() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let path = dir.path().join("document.json");
        let read = |bytes: &[u8]| {
            fs::write(&path, bytes).expect("written");
            read_checked_json::<Document>(&path, VERSIONS)
        };
        let document = Document { format_version: 2, x: 0.1 + 0.2 };
        let whole = to_checked_json(&path, &document).expect("written");
        assert_eq!(read(&whole).expect("read"), document);
        for bit in 0..whole.len() * 8 {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(read(&bytes).is_err(), "bit {bit}: {}", String::from_utf8_lossy(&bytes));
        }
        for length in 0..whole.len() {
            assert!(read(&whole[..length]).is_err(), "{length} bytes");
        }
        assert_eq!(read(br#"{"x":1.5}"#).expect("an older version").x, 1.5);
        let later = read(br#"{"format_version":4,"y":1}"#).expect_err("a later version");
        assert!(matches!(later, StoreError::LaterVersion { .. }), "{later:?}");
    }
}
