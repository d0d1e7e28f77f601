//! What outlives a process: tiles, map versions, the clouds of the running session, and room for recordings.
//!
//! One [`Store`] owns a data directory (a lock file sees to that); the gateway only reads in it. Whatever carries a
//! final name is complete: things are written under a temporary name, handed to the disk, and then renamed. What a
//! crash leaves half-written is removed when the store is next opened.

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
pub use recordings::{RecordingSpace, Recordings};
pub use saved::SavedMap;
pub use tiles::TileFiles;
pub use viewpoint_clouds::{Viewpoint, visible_points, write_viewpoint_clouds};

use messages::PlaceInMap;
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
    /// Opens a data directory, making it if need be, and removes what a crash left half-written: unlisted maps,
    /// clouds of sessions that ended with their process, and tiles that no map names.
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
            // A damaged map must not keep the robot from starting; its neighbours' tiles are only left over.
            tracing::error!("tiles without a map were not removed: {error}");
        }
        Ok(store)
    }

    /// Where things lie.
    pub fn dir(&self) -> &DataDir {
        &self.dir
    }

    /// The tiles of this directory.
    pub fn tiles(&self) -> TileFiles {
        TileFiles::new(self.dir.tiles())
    }

    /// Where the robot was last known to be, if that map is still there. What cannot be read is as if it had never been.
    pub fn last_place(&self) -> Option<PlaceInMap> {
        let path = self.dir.place();
        if !path.exists() {
            return None;
        }
        match files::read_json::<PlaceInMap>(&path) {
            Ok(place) => Some(place).filter(|place| self.dir.map_summary(place.map).exists()),
            Err(error) => {
                tracing::warn!("where the robot was is not known any more: {error}");
                None
            }
        }
    }

    /// Keeps where the robot is, for when it is switched on again; or forgets it.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn save_last_place(&self, place: Option<&PlaceInMap>) -> Result<(), StoreError> {
        let path = self.dir.place();
        let Some(place) = place else { return files::remove_file(&path) };
        let bytes = serde_json::to_vec(place)
            .map_err(|source| StoreError::Document { path: path.clone(), source })?;
        files::replace(&path, &bytes)
    }

    /// Docks of the saved maps. What cannot be read is as if it had never been; docks of maps that are gone are left out.
    pub fn docks(&self) -> Vec<PlaceInMap> {
        let path = self.dir.docks();
        if !path.exists() {
            return Vec::new();
        }
        let mut docks = files::read_json::<Vec<PlaceInMap>>(&path).unwrap_or_else(|error| {
            tracing::warn!("where docks are is not known any more: {error}");
            Vec::new()
        });
        docks.retain(|dock| self.dir.map_summary(dock.map).exists());
        docks
    }

    /// Keeps where docks are, for when the robot is switched on again.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn save_docks(&self, docks: &[PlaceInMap]) -> Result<(), StoreError> {
        let path = self.dir.docks();
        let bytes = serde_json::to_vec(docks)
            .map_err(|source| StoreError::Document { path: path.clone(), source })?;
        files::replace_durably(&path, &bytes)
    }

    /// The recordings of this directory.
    pub fn recordings(&self) -> Recordings {
        Recordings::new(self.dir.recordings())
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
