//! Entry points for the fuzzer: readers of files that this crate keeps to itself.

use crate::session_journal::{RecoveredJournal, ScanPoses, journal_of};
use crate::viewpoint_clouds::ViewpointClouds;
use crate::{StoreError, keyframe_descriptors};
use std::io;
use std::path::Path;
use vocab::KeyframeId;

/// Reads the content of a `places.bin`; returns the number of keyframes.
pub fn read_keyframe_descriptors(bytes: &[u8]) -> Option<usize> {
    keyframe_descriptors::parse(bytes).map(|descriptors| descriptors.len())
}

/// Reads the content of a file of viewpoints, and the cloud of each; returns their number.
///
/// # Errors
/// When the file or a viewpoint is damaged.
pub fn read_viewpoint_clouds(bytes: &[u8]) -> Result<u32, StoreError> {
    let clouds = ViewpointClouds::parse(Path::new("viewpoints.bin"), KeyframeId(0), bytes.to_vec())?;
    for keyframe in 0..clouds.len() {
        clouds.cloud_of(KeyframeId(keyframe))?;
    }
    Ok(clouds.len())
}

/// Reads the journal of a session with the poses after scans; returns the number of these.
///
/// # Errors
/// When the file cannot be read, or a later program wrote it.
pub fn read_session_journal(path: &Path) -> Result<usize, StoreError> {
    Ok(RecoveredJournal::read(path, ScanPoses::Wanted)?.trajectory().len())
}

/// A journal of a session with these records, which need not be valid.
///
/// # Errors
/// When a record is longer than 4 GB.
pub fn session_journal_of(records: &[&[u8]]) -> io::Result<Vec<u8>> {
    journal_of(records)
}
