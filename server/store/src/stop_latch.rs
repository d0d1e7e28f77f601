//! The stop of motion that outlives the process: `stop.json`.
//!
//! A stop must not be lifted by a damaged disk. So a file that cannot be read counts as a stop by somebody unknown, and so does a missing file beside one
//! that was put aside. A checksum detects changes that leave valid JSON.

use crate::{Store, StoreError, files, texts};
use messages::StopLatch;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Version of the document.
const STOP_FORMAT_VERSION: u32 = 1;

/// `stop.json`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StopDocument {
    format_version: u32,
    /// None while motion is allowed.
    latch: Option<StopLatch>,
    /// BLAKE3 of `latch` as JSON, hexadecimal.
    checksum: String,
}

impl StopDocument {
    fn new(latch: Option<StopLatch>) -> Result<Self, serde_json::Error> {
        let checksum = checksum(&latch)?;
        Ok(Self { format_version: STOP_FORMAT_VERSION, latch, checksum })
    }
}

fn checksum(latch: &Option<StopLatch>) -> Result<String, serde_json::Error> {
    Ok(blake3::hash(&serde_json::to_vec(latch)?).to_hex().to_string())
}

/// What the disk says of a stop of motion.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredStopLatch {
    /// The stop, if motion is stopped.
    pub latch: Option<StopLatch>,
    /// What is wrong with the file and what to do, sentences for people.
    pub problem: Option<String>,
}

impl Store {
    /// The stop of motion that was in force when the last process ended. A file that cannot be read is put aside.
    pub fn stop_latch(&self) -> StoredStopLatch {
        let path = self.dir().stop_latch();
        let unknown = Some(StopLatch { by: None });
        if !path.exists() {
            let is_lost = files::was_put_aside(&path);
            let problem = is_lost.then(|| texts::stop_latch_lost(&path));
            return StoredStopLatch { latch: unknown.filter(|_| is_lost), problem };
        }
        match read(&path) {
            Ok(latch) => StoredStopLatch { latch, problem: None },
            Err(error) => {
                let aside = files::put_aside(&path);
                StoredStopLatch { latch: unknown, problem: Some(texts::stop_latch_damaged(&error, &aside)) }
            }
        }
    }

    /// Writes whether motion is stopped, and by whom. It is on the disk when this returns.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn save_stop_latch(&self, latch: Option<&StopLatch>) -> Result<(), StoreError> {
        let path = self.dir().stop_latch();
        let bytes = StopDocument::new(latch.cloned()).and_then(|document| serde_json::to_vec(&document));
        let bytes = bytes.map_err(|error| StoreError::document(&path, &error))?;
        files::replace_durably(&path, &bytes)
    }
}

fn read(path: &Path) -> Result<Option<StopLatch>, StoreError> {
    let document: StopDocument = files::read_versioned(path, STOP_FORMAT_VERSION)?;
    let expected = checksum(&document.latch).map_err(|error| StoreError::document(path, &error))?;
    if document.checksum != expected {
        return Err(StoreError::Checksum { path: path.to_owned() });
    }
    Ok(document.latch)
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::Principal;
    use std::fs;
    use uuid::Uuid;
    use vocab::ClientId;

    fn latch() -> StopLatch {
        StopLatch { by: Some(Principal::operator(ClientId(Uuid::from_u128(7)))) }
    }

    #[test]
    fn a_stop_is_kept_until_it_is_lifted() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Store::open(dir.path()).expect("opens");
        let stored = |latch| StoredStopLatch { latch, problem: None };
        assert_eq!(store.stop_latch(), stored(None));
        store.save_stop_latch(Some(&latch())).expect("saved");
        drop(store);
        let store = Store::open(dir.path()).expect("opens");
        assert_eq!(store.stop_latch(), stored(Some(latch())));
        store.save_stop_latch(None).expect("saved");
        assert_eq!(store.stop_latch(), stored(None));
    }

    #[test]
    fn the_bytes_of_version_1_are_read() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Store::open(dir.path()).expect("opens");
        store.save_stop_latch(Some(&latch())).expect("saved");
        let golden = concat!(
            r#"{"format_version":1,"latch":{"by":{"client":"00000000-0000-0000-0000-000000000007","account":null,"role":"Operator"}},"#,
            r#""checksum":"1ad6029b6c1987ff5ea47f11222a62e8545906c48c35d6651f3b256706e5aabb"}"#
        );
        assert_eq!(fs::read_to_string(store.dir().stop_latch()).expect("written"), golden);
    }

    /// A stop has to be durable, so the file of a later program is put aside.
    #[test]
    fn a_stop_of_a_later_program_holds_and_its_file_is_kept() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Store::open(dir.path()).expect("opens");
        let later = r#"{"format_version":2,"zones":[]}"#;
        fs::write(store.dir().stop_latch(), later).expect("written");
        let StoredStopLatch { latch: read, problem } = store.stop_latch();
        assert_eq!(read, Some(StopLatch { by: None }));
        assert!(problem.is_some_and(|text| text.contains("update AutoInspect") && text.contains("stop.json.damaged")));
        store.save_stop_latch(None).expect("saved");
        assert_eq!(fs::read_to_string(dir.path().join("stop.json.damaged")).expect("kept"), later);
    }

    /// Every way of cutting the file and every single wrong bit.
    #[test]
    fn no_damage_lifts_a_stop_or_changes_who_stopped() {
        let dir = tempfile::tempdir().expect("temporary directory");
        let store = Store::open(dir.path()).expect("opens");
        store.save_stop_latch(Some(&latch())).expect("saved");
        let path = store.dir().stop_latch();
        let whole = fs::read(&path).expect("written");
        let cut = (0..whole.len()).map(|length| whole[..length].to_vec());
        let flipped = (0..whole.len() * 8).map(|bit| {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            bytes
        });
        for damaged in cut.chain(flipped).chain([vec![0; whole.len()]]) {
            fs::write(&path, &damaged).expect("written");
            let StoredStopLatch { latch: read, problem } = store.stop_latch();
            if read == Some(latch()) {
                // A wrong bit in the version, or in the case of a letter, may leave the meaning as it was.
                assert_eq!(problem, None);
                continue;
            }
            assert_eq!(read, Some(StopLatch { by: None }), "{}", String::from_utf8_lossy(&damaged));
            assert!(problem.is_some_and(|text| text.contains("stop.json")));
            let aside = dir.path().join("stop.json.damaged");
            assert_eq!(fs::read(&aside).expect("kept"), damaged);
            // The file was put aside, and the stop still holds.
            assert_eq!(store.stop_latch().latch, Some(StopLatch { by: None }));
            fs::remove_file(aside).expect("removed");
        }
    }
}
