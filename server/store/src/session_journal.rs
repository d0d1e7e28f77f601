//! The journal of a mapping session: `sessions/<session>/journal.bin`. A session that its process could not end is recovered from it and from the clouds
//! beside it.
//!
//! ```text
//! "AISJ"  format version: u32
//! records, each: length: u32, its complement: u32, first 8 bytes of the BLAKE3 of the content, content: a [`SessionRecord`] in postcard's encoding
//! ```
//!
//! Numbers are little-endian. Records are only appended; now and then the file is written anew without decisions on loops that newer ones have replaced. The last one may be torn by a crash, and is left out then. A record that does not match its
//! checksum is damage: what comes after it is not used. Changes of the graph build on each other, so where the writer had to leave records out, they are not
//! used up to the next whole graph.

use crate::cloud_files::CloudFiles;
use crate::keyframe_grid::KeyframeGrid;
use crate::session_journal_compaction::{compact, count_decisions, keep_newest};
use crate::session_records::{
    Frame, HEADER_BYTES, JOURNAL_FORMAT_VERSION, MAGIC, SessionRecord, encode, frame, header, read_record,
};
use crate::{StoreError, files};
use geometry::{isometry_from_pose, pose_from_isometry};
use messages::{LoopDecision, PoseGraph};
use std::fs::{File, OpenOptions};
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vocab::{KeyframeId, MapId, Pose, Stamp};

/// Appends to the journal of a running session. A record is handed to the system at once, so it survives the process; after [`Self::sync`] it also survives
/// a power cut.
#[derive(Debug)]
pub struct SessionJournal {
    path: PathBuf,
    file: File,
    /// Bytes of whole records.
    length: u64,
    /// Decisions on loops in it.
    decisions: usize,
    config: SessionJournalLimits,
}

/// Limits of a [`SessionJournal`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SessionJournalLimits {
    /// Decisions on loops in the file, about 6 MB. At this number it is written anew with the newest half: as many as the session itself keeps.
    pub max_decisions: usize,
}

impl Default for SessionJournalLimits {
    fn default() -> Self {
        Self { max_decisions: mapping::LoopClosingConfig::default().max_decisions }
    }
}

impl SessionJournal {
    /// Begins a journal, or goes on with one that this process has begun.
    pub(crate) fn open(path: PathBuf) -> Result<Self, StoreError> {
        Self::open_with(path, SessionJournalLimits::default())
    }

    pub(crate) fn open_with(path: PathBuf, config: SessionJournalLimits) -> Result<Self, StoreError> {
        let failed = |source| StoreError::io("write", &path, source);
        let options = OpenOptions::new().create(true).append(true).open(&path);
        let mut file = options.map_err(failed)?;
        let length = file.seek(SeekFrom::End(0)).map_err(failed)?;
        if length > 0 {
            let decisions = count_decisions(&path)?;
            return Ok(Self { path, file, length, decisions, config });
        }
        file.write_all(&header()).map_err(failed)?;
        // The names of the journal and of its session's folder.
        for directory in path.ancestors().skip(1).take(2) {
            files::sync_directory(directory)?;
        }
        Ok(Self { file, length: HEADER_BYTES, decisions: 0, config, path })
    }

    /// Appends a record. A record that could not be written whole is cut off again.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn append(&mut self, record: &SessionRecord) -> Result<(), StoreError> {
        if let SessionRecord::LoopDecided(_) = record {
            if self.decisions >= self.config.max_decisions {
                self.compact()?;
            }
            self.decisions += 1;
        }
        let bytes = encode(record).and_then(|bytes| self.file.write_all(&bytes).map(|()| bytes.len()));
        match bytes {
            Ok(bytes) => {
                self.length += bytes as u64;
                Ok(())
            }
            Err(source) => {
                // If this fails too, the record counts as torn or damaged when it is read.
                let _ = self.file.set_len(self.length);
                Err(StoreError::io("write", &self.path, source))
            }
        }
    }

    /// Writes the file anew without decisions that newer ones have replaced.
    fn compact(&mut self) -> Result<(), StoreError> {
        let kept = self.config.max_decisions / 2;
        compact(&self.path, kept)?;
        *self = Self::open_with(self.path.clone(), self.config)?;
        Ok(())
    }

    /// Waits until all records and the names of the clouds beside them are on the disk.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn sync(&self) -> Result<(), StoreError> {
        self.file.sync_data().map_err(|source| StoreError::io("write", &self.path, source))?;
        self.path.parent().map_or(Ok(()), files::sync_directory)
    }
}

/// A journal with these records, whatever they hold.
pub(crate) fn journal_of(records: &[&[u8]]) -> io::Result<Vec<u8>> {
    let mut bytes = header();
    for record in records {
        bytes.extend(frame(record)?);
    }
    Ok(bytes)
}

/// What a journal says of its session.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct RecoveredJournal {
    pub extends: Option<MapId>,
    pub distance_m: f64,
    pub graph: PoseGraph,
    /// Its keyframes, if the poses after scans are wanted.
    keyframe_grid: KeyframeGrid,
    pub decisions: Vec<LoopDecision>,
    /// Instant of the last scan.
    last_scan: Stamp,
    /// Pose of the base after each scan: its keyframe, and the pose in the frame of that keyframe.
    scan_poses: Vec<(Stamp, KeyframeId, Pose)>,
    /// Offset of the first record that is damaged. Also of the first change that does not apply to the graph, unless a whole graph followed.
    pub damaged_at: Option<u64>,
}

/// Whether the poses after scans are wanted. Each costs a search in the grid of the keyframes, see [`KeyframeGrid::nearest`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ScanPoses {
    Wanted,
    Ignored,
}

impl RecoveredJournal {
    /// Reads a journal up to its end or its first damage. Memory: what the session had, and one record. Time: linear in the bytes; the keyframe of a scan
    /// pose is found in a grid, see [`KeyframeGrid::nearest`].
    ///
    /// # Errors
    /// When the disk fails.
    pub fn read(path: &Path, scan_poses: ScanPoses) -> Result<Self, StoreError> {
        let failed = |source| StoreError::io("read", path, source);
        let file = File::open(path).map_err(failed)?;
        let end = file.metadata().map_err(failed)?.len();
        let mut reader = BufReader::new(file);
        let mut recovered = Self::default();
        let mut header = [0; HEADER_BYTES as usize];
        if end < HEADER_BYTES {
            recovered.damaged_at = Some(0);
            return Ok(recovered);
        }
        reader.read_exact(&mut header).map_err(failed)?;
        let mut version = [0; 4];
        version.copy_from_slice(&header[4..]);
        let version = u32::from_le_bytes(version);
        files::check_version(path, version, JOURNAL_FORMAT_VERSION)?;
        if header[..4] != MAGIC || version == 0 {
            recovered.damaged_at = Some(0);
            return Ok(recovered);
        }
        let mut offset = HEADER_BYTES;
        loop {
            match read_record(&mut reader, end - offset).map_err(failed)? {
                Frame::End => return Ok(recovered),
                Frame::Record(record, bytes) => {
                    let is_whole_graph = matches!(record, SessionRecord::Graph(_));
                    if !recovered.add(record, scan_poses) {
                        // The writer left records out. It asks for the whole graph then.
                        recovered.damaged_at.get_or_insert(offset);
                    } else if is_whole_graph {
                        recovered.damaged_at = None;
                    }
                    offset += bytes;
                }
                Frame::Damaged => {
                    recovered.damaged_at.get_or_insert(offset);
                    return Ok(recovered);
                }
            }
        }
    }

    /// Adds a record. Returns false if it changes another graph than the one that was recorded.
    fn add(&mut self, record: SessionRecord, scan_poses: ScanPoses) -> bool {
        match record {
            SessionRecord::State { extends, distance_m } => {
                self.extends = extends;
                self.distance_m = distance_m;
            }
            SessionRecord::Graph(graph) => {
                self.graph = Arc::unwrap_or_clone(graph);
                if scan_poses == ScanPoses::Wanted {
                    self.keyframe_grid = KeyframeGrid::default();
                    self.keyframe_grid.update(&self.graph.nodes);
                }
            }
            SessionRecord::GraphDelta(delta) => {
                if !self.graph.apply(&delta) {
                    return false;
                }
                if scan_poses == ScanPoses::Wanted {
                    self.keyframe_grid.update(&delta.nodes);
                }
            }
            SessionRecord::LoopDecided(decision) => {
                let most = SessionJournalLimits::default().max_decisions;
                if self.decisions.len() >= most {
                    keep_newest(&mut self.decisions, most / 2);
                }
                self.decisions.push(decision);
            }
            SessionRecord::ScanPose { stamp, map_from_base } => {
                self.last_scan = stamp;
                if scan_poses == ScanPoses::Wanted {
                    self.scan_poses.extend(self.relative_to_nearest(stamp, &map_from_base));
                }
            }
        }
        true
    }

    /// A pose relative to the nearest keyframe, so that it moves with that keyframe.
    fn relative_to_nearest(&self, stamp: Stamp, map_from_base: &Pose) -> Option<(Stamp, KeyframeId, Pose)> {
        let nearest = self.keyframe_grid.nearest(map_from_base.position)?;
        let nearest = self.graph.nodes.get(nearest.0 as usize)?;
        let map_from_keyframe = isometry_from_pose(&nearest.map_from_keyframe)?;
        let relative = map_from_keyframe.inverse() * isometry_from_pose(map_from_base)?;
        Some((stamp, nearest.id, pose_from_isometry(&relative)))
    }

    /// Drops the last keyframes if they have no cloud: a cloud is written after the graph was recorded, and the process may have ended in between. Without its
    /// cloud, such a keyframe adds nothing to the map.
    pub fn drop_last_keyframes_without_cloud(&mut self, clouds: &CloudFiles) {
        while self.graph.nodes.last().is_some_and(|node| !clouds.contains(node.id)) {
            self.graph.nodes.pop();
        }
        let kept = self.graph.nodes.len();
        let is_kept = |id: KeyframeId| (id.0 as usize) < kept;
        self.graph.edges.retain(|edge| is_kept(edge.from) && is_kept(edge.to));
        self.decisions.retain(|decision| is_kept(decision.task.from) && is_kept(decision.task.to));
    }

    /// Instant of the last scan or keyframe. A session may be interrupted between its first keyframe and the pose of that scan.
    pub fn last(&self) -> Stamp {
        self.graph.nodes.last().map_or(self.last_scan, |node| node.stamp.max(self.last_scan))
    }

    /// Pose of the base in the map after every scan, with the last poses of the keyframes.
    pub fn trajectory(&self) -> Vec<(Stamp, Pose)> {
        let poses = self.scan_poses.iter().filter_map(|(stamp, keyframe, keyframe_from_base)| {
            let node = self.graph.nodes.get(keyframe.0 as usize)?;
            let map_from_keyframe = isometry_from_pose(&node.map_from_keyframe)?;
            let map_from_base = map_from_keyframe * isometry_from_pose(keyframe_from_base)?;
            Some((*stamp, pose_from_isometry(&map_from_base)))
        });
        poses.collect()
    }
}

#[cfg(test)]
#[path = "session_journal_tests.rs"]
mod tests;
