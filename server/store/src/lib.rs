//! The data directory: tiles, map versions, clouds of the running session, and disk space for recordings.
//!
//! One [`Store`] owns a data directory; a lock file keeps others out. The gateway only reads in it. A file with a final
//! name is complete: it is written under a temporary name, synced, and then renamed. Half-written files that a crash leaves
//! are removed when the store is opened again.

mod background;
mod blobs;
mod checked_json;
mod checksums;
mod cloud_files;
mod dynamic_points;
mod error;
mod files;
pub mod fuzzing;
mod keyframe_descriptors;
mod keyframe_grid;
mod keyframe_poses;
mod ledger;
mod map_bin;
mod map_cloud;
mod map_clouds;
mod map_document;
mod map_files;
mod map_folder_files;
mod map_folders;
mod map_points;
mod maps;
mod poses;
mod recordings;
mod recovered_sessions;
mod robust_bounds;
mod run_clouds;
mod saved;
mod session_journal;
mod session_journal_compaction;
mod session_records;
mod sessions;
mod stop_latch;
mod stored_data_check;
mod texts;
mod tiles;
mod topomap_source;
mod uploads;
mod viewpoint_clouds;

pub use background::{ChangedSince, read_changed_since};
pub use blobs::{BlobError, BlobsConfig};
pub use cloud_files::{VirtualKeyframes, copy_viewpoint_files, write_cloud};
pub use error::StoreError;
pub use files::write_json;
pub use keyframe_descriptors::keyframe_descriptors;
pub use ledger::{
    AccountReader, Accounts, AuditEntry, EditRecord, Ledger, LedgerWriter, StoredAccount, StoredCredential,
    UnfinishedRun, VerifiedAudit, verify_ledger,
};
pub use map_bin::BinnedMap;
pub use map_cloud::{CloudSelection, MapCloud};
pub use map_clouds::{MapClouds, copy_clouds, map_clouds, map_clouds_and_sensors};
pub use map_files::{MapFileOptions, MapFilesReport, write_map_files, write_map_files_of};
pub use map_folders::DamagedMap;
pub use map_points::MapPoints;
pub use mapping::line_of_sight::{LineOfSightConfig, OccupiedVoxels};
pub use maps::MapList;
pub use recordings::{RecordedRun, RecordingSpace, Recordings, RecordingsConfig, RecordingsUse};
pub use recovered_sessions::InterruptedSessions;
pub use run_clouds::{
    RunCloud, RunCloudCause, RunCloudEntry, RunCloudsConfig, is_run_clouds_folder, read_run_clouds,
    read_run_index,
};
pub use saved::SavedMap;
pub use session_journal::SessionJournal;
pub use session_records::SessionRecord;
pub use stop_latch::StoredStopLatch;
pub use stored_data_check::StoredDataReport;
pub use tiles::TileFiles;
pub use topomap_source::TopomapSource;
pub use uploads::{ImportSpaceConfig, StoredUpload, UploadNote};
pub use viewpoint_clouds::{CloudViewpoint, visible_points, write_viewpoint_clouds};

use ports::DataDir;
use std::fs::{File, TryLockError};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::time::{Duration, Instant, SystemTime};

/// The one writer of a data directory.
#[derive(Debug)]
pub struct Store {
    dir: DataDir,
    /// Held while the store lives; the system releases it even after a crash.
    _lock: File,
    /// Many may add maps at once; unused tiles are removed while nobody does, because a new map may refer to them.
    tiles_in_use: RwLock<()>,
    /// What reading has found and nobody has been told yet.
    problems: Mutex<Vec<String>>,
}

impl Store {
    /// Opens a data directory, creates it if necessary, and removes what a crash left: unlisted maps,
    /// sessions whose map was saved, files that were being received, and tiles that no map refers to. While a map cannot be read, all tiles stay. Other
    /// sessions stay until a person decides, see [`Store::interrupted_sessions`].
    ///
    /// # Errors
    /// When the directory is in use by another process or cannot be written.
    pub fn open(root: impl Into<PathBuf>) -> Result<Self, StoreError> {
        let dir = DataDir::new(root);
        let run = dir.root().join("run");
        for directory in [
            dir.tiles(),
            dir.blobs(),
            dir.maps(),
            dir.bin(),
            dir.recordings(),
            dir.sessions(),
            dir.uploads(),
            run.clone(),
        ] {
            files::make_directory(&directory)?;
        }
        let config = OpenConfig::default();
        let lock = lock(run.join("lock"), &dir, &config)?;
        let store = Self { dir, _lock: lock, tiles_in_use: RwLock::default(), problems: Mutex::default() };
        store.end_uploads(&config);
        store.remove_temporary_files()?;
        store.remove_half_written_blobs()?;
        store.remove_half_written_maps()?;
        store.remove_leaving_maps()?;
        store.remove_half_removed_sessions()?;
        store.remove_ended_sessions()?;
        if let Err(error) = store.remove_unused_tiles(SystemTime::now()) {
            // A damaged map must not keep the robot from starting. Tiles that stay only take space.
            tracing::error!("no unused tile was removed, because not every map could be read: {error}");
        }
        Ok(store)
    }

    /// Removes what unfinished imports have left. An import whose core was killed may be writing there while it ends, so a failure is tried again and does not keep
    /// the robot from starting.
    fn end_uploads(&self, config: &OpenConfig) {
        if let Err(error) =
            config.retry(|| self.remove_unfinished_uploads(SystemTime::now()).map_err(Retry::Again))
        {
            tracing::warn!(
                "what an import has left stays until the next start: {}",
                ports::error_with_causes(&error)
            );
        }
    }

    /// Removes what was written of the documents in the directory itself when the last process was killed.
    fn remove_temporary_files(&self) -> Result<(), StoreError> {
        let entries = files::entries(self.dir.root())?;
        entries.iter().filter(|path| files::is_temporary(path)).try_for_each(|path| files::remove_file(path))
    }

    /// The layout of the directory.
    pub fn dir(&self) -> &DataDir {
        &self.dir
    }

    /// The tiles of this directory.
    pub fn tiles(&self) -> TileFiles {
        TileFiles::new(self.dir.tiles())
    }

    /// Held while a map is added, so that tiles that it refers to stay.
    pub(crate) fn lock_map_change(&self) -> RwLockReadGuard<'_, ()> {
        self.tiles_in_use.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// Held while tiles are removed.
    pub(crate) fn lock_tile_removal(&self) -> RwLockWriteGuard<'_, ()> {
        self.tiles_in_use.write().unwrap_or_else(PoisonError::into_inner)
    }

    /// What was wrong with files that were read since the last call, and what to do; sentences for people.
    pub fn take_problems(&self) -> Vec<String> {
        std::mem::take(&mut self.problems.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Adds a sentence to [`Self::take_problems`].
    pub fn note_problem(&self, text: String) {
        self.add_problem(text);
    }

    pub(crate) fn add_problem(&self, text: String) {
        self.problems.lock().unwrap_or_else(PoisonError::into_inner).push(text);
    }

    /// The recordings of this directory.
    pub fn recordings(&self) -> Recordings {
        Recordings::new(self.dir.recordings(), RecordingsConfig::default())
    }
}

/// Parameters of [`Store::open`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct OpenConfig {
    /// Longest time to wait for the last process, which was killed a moment ago and still holds the lock or writes. Chosen: the system ends a killed process within
    /// milliseconds.
    patience: Duration,
    /// Time between two attempts. Chosen: nobody notices it.
    pause: Duration,
}

impl Default for OpenConfig {
    fn default() -> Self {
        Self { patience: Duration::from_secs(1), pause: Duration::from_millis(10) }
    }
}

/// Whether another attempt may succeed.
enum Retry<E> {
    Again(E),
    Never(E),
}

impl OpenConfig {
    /// Attempts something until it succeeds or the patience is over.
    fn retry<T, E>(&self, mut attempt: impl FnMut() -> Result<T, Retry<E>>) -> Result<T, E> {
        let start = Instant::now();
        loop {
            match attempt() {
                Ok(done) => return Ok(done),
                Err(Retry::Again(_)) if start.elapsed() < self.patience => std::thread::sleep(self.pause),
                Err(Retry::Again(error) | Retry::Never(error)) => return Err(error),
            }
        }
    }
}

fn lock(path: PathBuf, dir: &DataDir, config: &OpenConfig) -> Result<File, StoreError> {
    let file = File::create(&path).map_err(|source| StoreError::io("make", &path, source))?;
    config.retry(|| match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(Retry::Again(StoreError::InUse { dir: dir.root().to_owned() })),
        Err(TryLockError::Error(source)) => Err(Retry::Never(StoreError::io("lock", &path, source))),
    })?;
    Ok(file)
}

#[cfg(test)]
#[path = "open_tests.rs"]
mod tests;
