//! The data directory: tiles, map versions, clouds of the running session, and disk space for recordings.
//!
//! One [`Store`] owns a data directory; a lock file keeps others out. The gateway only reads in it. A file with a final
//! name is complete: it is written under a temporary name, synced, and then renamed. Half-written files that a crash leaves
//! are removed when the store is opened again.

mod cloud_files;
mod dynamic_points;
mod error;
mod files;
mod keyframe_descriptors;
mod map_cloud;
mod map_clouds;
mod map_files;
mod map_points;
mod maps;
mod recordings;
mod robust_bounds;
mod saved;
mod sessions;
mod texts;
mod tiles;
mod viewpoint_clouds;

pub use cloud_files::{VirtualKeyframes, copy_viewpoint_files, write_cloud};
pub use error::StoreError;
pub use files::write_json;
pub use keyframe_descriptors::keyframe_descriptors;
pub use map_cloud::{CloudSelection, MapCloud};
pub use map_clouds::{MapClouds, copy_clouds, map_clouds, map_clouds_and_sensors};
pub use map_files::{MapFileOptions, MapFilesReport, write_map_files, write_map_files_of};
pub use map_points::MapPoints;
pub use recordings::{RecordingSpace, Recordings, RecordingsConfig};
pub use saved::SavedMap;
pub use tiles::TileFiles;
pub use viewpoint_clouds::{Viewpoint, visible_points, write_viewpoint_clouds};

use messages::PoseInMap;
use ports::DataDir;
use std::fs::{File, TryLockError};
use std::path::PathBuf;

/// The one writer of a data directory.
#[derive(Debug)]
pub struct Store {
    dir: DataDir,
    /// Held while the store lives; the system releases it even after a crash.
    _lock: File,
}

impl Store {
    /// Opens a data directory, creates it if necessary, and removes what a crash left: unlisted maps,
    /// clouds of sessions that ended with their process, and tiles that no map refers to.
    ///
    /// # Errors
    /// When the directory is in use by another process or cannot be written.
    pub fn open(root: impl Into<PathBuf>) -> Result<Self, StoreError> {
        let dir = DataDir::new(root);
        let run = dir.root().join("run");
        for directory in [dir.tiles(), dir.maps(), dir.recordings(), dir.root().join("sessions"), run.clone()]
        {
            files::make_directory(&directory)?;
        }
        let lock = lock(run.join("lock"), &dir)?;
        let store = Self { dir, _lock: lock };
        files::remove_directory(&store.dir.uploads())?;
        files::make_directory(&store.dir.uploads())?;
        store.remove_half_written_maps()?;
        store.remove_all_sessions()?;
        if let Err(error) = store.remove_unreferenced_tiles() {
            // A damaged map must not keep the robot from starting. Tiles that stay only take space.
            tracing::error!("tiles without a map were not removed: {error}");
        }
        Ok(store)
    }

    /// The layout of the directory.
    pub fn dir(&self) -> &DataDir {
        &self.dir
    }

    /// The tiles of this directory.
    pub fn tiles(&self) -> TileFiles {
        TileFiles::new(self.dir.tiles())
    }

    /// The robot's last known pose in a map, if that map still exists. A file that cannot be read counts as absent.
    pub fn last_pose(&self) -> Option<PoseInMap> {
        let path = self.dir.last_pose();
        if !path.exists() {
            return None;
        }
        match files::read_json::<PoseInMap>(&path) {
            Ok(pose) => Some(pose).filter(|pose| self.dir.map_summary(pose.map).exists()),
            Err(error) => {
                tracing::warn!("the robot's last pose cannot be read: {error}");
                None
            }
        }
    }

    /// Saves the robot's pose for the next start, or deletes the saved one.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn save_last_pose(&self, pose: Option<&PoseInMap>) -> Result<(), StoreError> {
        let path = self.dir.last_pose();
        let Some(pose) = pose else { return files::remove_file(&path) };
        let bytes =
            serde_json::to_vec(pose).map_err(|source| StoreError::Document { path: path.clone(), source })?;
        files::replace(&path, &bytes)
    }

    /// Docks in the saved maps, without those of maps that no longer exist. A file that cannot be read counts as empty.
    pub fn docks(&self) -> Vec<PoseInMap> {
        let path = self.dir.docks();
        if !path.exists() {
            return Vec::new();
        }
        let mut docks = files::read_json::<Vec<PoseInMap>>(&path).unwrap_or_else(|error| {
            tracing::warn!("docks cannot be read: {error}");
            Vec::new()
        });
        docks.retain(|dock| self.dir.map_summary(dock.map).exists());
        docks
    }

    /// Saves the docks for the next start.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn save_docks(&self, docks: &[PoseInMap]) -> Result<(), StoreError> {
        let path = self.dir.docks();
        let bytes = serde_json::to_vec(docks)
            .map_err(|source| StoreError::Document { path: path.clone(), source })?;
        files::replace_durably(&path, &bytes)
    }

    /// The recordings of this directory.
    pub fn recordings(&self) -> Recordings {
        Recordings::new(self.dir.recordings(), RecordingsConfig::default())
    }
}

fn lock(path: PathBuf, dir: &DataDir) -> Result<File, StoreError> {
    let file = File::create(&path).map_err(|source| StoreError::io("make", &path, source))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(StoreError::InUse { dir: dir.root().to_owned() }),
        Err(TryLockError::Error(source)) => Err(StoreError::io("lock", &path, source)),
    }
}
