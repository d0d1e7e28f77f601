//! Compaction of the journal of a running session: decisions on loops that newer ones have replaced go.
//!
//! A robot that walks over known ground compares the same keyframes again and again. All other records are kept: the graph grows with the site, and a pose
//! after a scan is a pose of the trajectory.

use crate::session_records::{Frame, HEADER_BYTES, SessionRecord, encode, header, read_record};
use crate::{StoreError, files};
use messages::LoopDecision;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, BufReader, Seek, SeekFrom, Write};
use std::path::Path;
use vocab::KeyframeId;

/// The keyframes of a decision.
pub(crate) fn pair(decision: &LoopDecision) -> (KeyframeId, KeyframeId) {
    (decision.task.from, decision.task.to)
}

/// Number of decisions in a journal.
///
/// # Errors
/// When the disk fails.
pub(crate) fn count_decisions(path: &Path) -> Result<usize, StoreError> {
    let mut count = 0;
    let counted = for_each_record(path, |_, record| {
        count += usize::from(matches!(record, SessionRecord::LoopDecided(_)));
        Ok(())
    });
    counted.map(|()| count).map_err(|source| StoreError::io("read", path, source))
}

/// Writes a journal anew with the last decision on each of the newest `max_decisions` pairs of keyframes. A crash leaves the old one or the new one.
///
/// # Errors
/// When the disk fails. The old one is then as it was.
pub(crate) fn compact(path: &Path, max_decisions: usize) -> Result<(), StoreError> {
    let mut newest = BTreeMap::new();
    let found = for_each_record(path, |offset, record| {
        if let SessionRecord::LoopDecided(decision) = record {
            newest.insert(pair(decision), offset);
        }
        Ok(())
    });
    found.map_err(|source| StoreError::io("read", path, source))?;
    let offsets: BTreeSet<u64> = newest.into_values().collect();
    let kept: BTreeSet<u64> = offsets.into_iter().rev().take(max_decisions).collect();
    let temporary = files::temporary_path(path);
    files::write_durably(&temporary, |file| {
        file.write_all(&header())?;
        for_each_record(path, |offset, record| match record {
            SessionRecord::LoopDecided(_) if !kept.contains(&offset) => Ok(()),
            record => file.write_all(&encode(record)?),
        })
    })?;
    fs::rename(&temporary, path).map_err(|source| StoreError::io("write", path, source))?;
    path.parent().map_or(Ok(()), files::sync_directory)
}

/// Calls `act` with every whole record and its offset.
fn for_each_record(
    path: &Path,
    mut act: impl FnMut(u64, &SessionRecord) -> io::Result<()>,
) -> io::Result<()> {
    let mut file = File::open(path)?;
    let end = file.metadata()?.len();
    let mut offset = file.seek(SeekFrom::Start(HEADER_BYTES))?;
    let mut reader = BufReader::new(file);
    while let Frame::Record(record, bytes) = read_record(&mut reader, end.saturating_sub(offset))? {
        act(offset, &record)?;
        offset += bytes;
    }
    Ok(())
}

/// Keeps the last decision on each of the newest `max_decisions` pairs.
pub(crate) fn keep_newest(decisions: &mut Vec<LoopDecision>, max_decisions: usize) {
    let mut pairs = BTreeSet::new();
    decisions.reverse();
    decisions.retain(|decision| pairs.insert(pair(decision)));
    decisions.truncate(max_decisions);
    decisions.reverse();
}
