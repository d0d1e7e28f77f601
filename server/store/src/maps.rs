//! Map versions: immutable directories. Each is complete or does not exist.

use crate::checksums::{Checksums, append_checksum};
use crate::cloud_files::copy_cloud_files;
use crate::map_document::MapDocument;
use crate::map_folder_files::files_with_checksum;
use crate::map_folders::{DamagedMap, MapFolders, is_temporary};
use crate::sessions::link_clouds;
use crate::{
    MapFileOptions, MapFilesReport, MapPoints, SavedMap, Store, StoreError, files, write_map_files,
    write_map_files_of,
};
use api::{MapSummary, TileList};
use geometry::{Isometry, isometry_from_pose};
use messages::FinishedMap;
use std::borrow::Cow;
use std::fs;
use std::path::{Path, PathBuf};
use vocab::{KeyframeId, MapId};

/// The saved maps, and the folders that cannot be listed.
#[derive(Debug, Default)]
pub struct MapList {
    /// Every map that can be read, newest first.
    pub maps: Vec<MapSummary>,
    /// The others, in the order of their folders' names.
    pub damaged: Vec<DamagedMap>,
}

impl Store {
    /// Every saved map that can be read, newest first. The others are in [`Store::damaged_maps`], so that one of them does not hide the rest.
    ///
    /// # Errors
    /// When the directory of maps cannot be read.
    pub fn maps(&self) -> Result<Vec<MapSummary>, StoreError> {
        Ok(self.list_maps()?.maps)
    }

    /// [`Self::maps`] and [`Self::damaged_maps`], with each file read once.
    ///
    /// # Errors
    /// When the directory of maps cannot be read.
    pub fn list_maps(&self) -> Result<MapList, StoreError> {
        let MapFolders { readable, mut damaged } = self.map_folders()?;
        let mut maps: Vec<_> = readable.into_iter().map(|map| map.summary).collect();
        maps.sort_by_key(|map| (std::cmp::Reverse(map.created), map.id));
        damaged.sort_by(|a, b| a.folder.cmp(&b.folder));
        Ok(MapList { maps, damaged })
    }

    /// Folders of maps whose list entry or tile list cannot be read, with what is wrong. Nothing of them is removed.
    ///
    /// # Errors
    /// When the directory of maps cannot be read.
    pub fn damaged_maps(&self) -> Result<Vec<DamagedMap>, StoreError> {
        Ok(self.map_folders()?.damaged)
    }

    /// Reads the list entry and the tile list of every saved map.
    fn map_folders(&self) -> Result<MapFolders, StoreError> {
        MapFolders::read(&self.dir().maps())
    }

    /// The tiles of a saved map.
    ///
    /// # Errors
    /// When there is no such map, or it cannot be read.
    pub fn map_tiles(&self, map: MapId) -> Result<TileList, StoreError> {
        files::read_json(&self.dir().map_tiles(map))
    }

    /// A saved map without clouds and tiles.
    ///
    /// # Errors
    /// When there is no such map, or it cannot be read.
    pub fn map(&self, map: MapId) -> Result<SavedMap, StoreError> {
        SavedMap::read(&self.dir().map(map))
    }

    /// Saves a finished session as an immutable map version, with the clouds kept by [`Store::write_session_cloud`]. The version
    /// is listed once all of it is on the disk. The session's files stay until [`Store::discard_session`], so that nothing is lost if saving fails or is
    /// interrupted.
    ///
    /// # Errors
    /// When the id is taken, the session has no keyframes, or the disk fails.
    pub fn save_map(&self, finished: &FinishedMap) -> Result<MapFilesReport, StoreError> {
        self.save_session(finished, link_clouds)
    }

    /// As [`Self::save_map`]; `prepare` gets the session's folder and that of the map's clouds, and makes the clouds.
    pub(crate) fn save_session(
        &self,
        finished: &FinishedMap,
        prepare: impl FnOnce(&Path, &Path) -> Result<(), StoreError>,
    ) -> Result<MapFilesReport, StoreError> {
        let session = self.session(finished.session);
        if finished.graph.nodes.is_empty() || !session.exists() {
            return Err(StoreError::EmptySession { session: finished.session });
        }
        let _adding = self.lock_map_change();
        let temporary = self.create_staging_directory(finished.map)?;
        let clouds = temporary.join("clouds");
        let written = self
            .mark_as_saving(finished.session, finished.map)
            .and_then(|()| prepare(&session, &clouds))
            .and_then(|()| self.include_extended_map(finished, &clouds))
            .and_then(|whole| write_map_files(&temporary, &self.tiles(), &whole, MapFileOptions::default()));
        self.publish(finished.map, written)
    }

    /// Adds a map that no session made. `prepare` gets the map's folder; it writes the keyframes' clouds into `clouds/`, and other files of the map. `points`
    /// (map frame) are for the tiles.
    ///
    /// # Errors
    /// When the id is taken, `prepare` fails, or the disk fails. Nothing is left of the map then.
    pub fn add_map(
        &self,
        finished: &FinishedMap,
        options: MapFileOptions,
        points: MapPoints,
        prepare: impl FnOnce(&Path) -> Result<(), StoreError>,
    ) -> Result<MapFilesReport, StoreError> {
        let _adding = self.lock_map_change();
        let temporary = self.create_staging_directory(finished.map)?;
        let written = files::make_directory(&temporary.join("clouds")).and_then(|()| prepare(&temporary));
        let written =
            written.and_then(|()| write_map_files_of(&temporary, &self.tiles(), finished, options, points));
        self.publish(finished.map, written)
    }

    /// Whether the disk has space for a second map as large as this one with its tiles, and for further recordings.
    ///
    /// # Errors
    /// When the system does not say.
    pub fn has_space_for_copy(&self, map: MapId) -> Result<bool, StoreError> {
        let folder = self.dir().map(map);
        let needed = files::bytes_below(&folder)?.saturating_mul(2).saturating_add(api::DISK_RESERVE_BYTES);
        Ok(files::free_bytes(&folder)? >= needed)
    }

    /// Moves a map into this data directory that another process has written to `from` on the same disk, with its tiles in `from/tiles`.
    ///
    /// # Errors
    /// When it exists already, is no map, or the disk fails. Nothing is left of it in the data directory then.
    pub fn adopt_map(&self, from: &Path) -> Result<MapSummary, StoreError> {
        let summary = MapDocument::read(&from.join("map.json"))?.summary;
        let _adding = self.lock_map_change();
        let place = self.dir().map(summary.id);
        if place.exists() {
            return Err(StoreError::MapExists { id: summary.id });
        }
        if self.dir().binned_map(summary.id).exists() {
            return Err(StoreError::MapInBin { id: summary.id });
        }
        let tiles = from.join("tiles");
        for path in files::entries(&tiles)?
            .iter()
            .map(|directory| files::entries(directory))
            .collect::<Result<Vec<_>, _>>()?
            .concat()
        {
            self.tiles().adopt(&path)?;
        }
        files::remove_directory(&tiles)?;
        // The other process has written its report after the checksums.
        for name in files_with_checksum(from)? {
            if !Checksums::read(from)?.is_some_and(|sums| sums.has(&name)) {
                append_checksum(from, &name)?;
            }
        }
        files::sync_file(&Checksums::path(from))?;
        rename(from, &place)?;
        files::sync_directory(&self.dir().maps())?;
        Ok(summary)
    }

    /// Creates an empty directory in which a map is written before it is listed.
    fn create_staging_directory(&self, map: MapId) -> Result<PathBuf, StoreError> {
        if self.dir().map(map).exists() {
            return Err(StoreError::MapExists { id: map });
        }
        if self.dir().binned_map(map).exists() {
            return Err(StoreError::MapInBin { id: map });
        }
        let temporary = self.staging_directory(map);
        files::remove_directory(&temporary)?;
        files::make_directory(&temporary)?;
        Ok(temporary)
    }

    fn staging_directory(&self, map: MapId) -> PathBuf {
        self.dir().maps().join(format!(".{map}"))
    }

    /// Lists a map that was written completely. If writing failed, what was written is removed.
    fn publish(
        &self,
        map: MapId,
        written: Result<MapFilesReport, StoreError>,
    ) -> Result<MapFilesReport, StoreError> {
        let temporary = self.staging_directory(map);
        match written.and_then(|report| rename(&temporary, &self.dir().map(map)).map(|()| report)) {
            Ok(report) => {
                files::sync_directory(&self.dir().maps())?;
                Ok(report)
            }
            Err(error) => {
                files::remove_directory(&temporary)?;
                Err(error)
            }
        }
    }

    /// Adds the trajectory, decisions and distance of the map that `finished` extends, and copies those of its clouds that are not in `clouds` yet because
    /// copying failed before.
    fn include_extended_map<'a>(
        &self,
        finished: &'a FinishedMap,
        clouds: &Path,
    ) -> Result<Cow<'a, FinishedMap>, StoreError> {
        let Some(map) = finished.extends else { return Ok(Cow::Borrowed(finished)) };
        let base_map = self.map(map)?;
        let keyframes = (0..base_map.poses.len() as u32).map(KeyframeId);
        copy_cloud_files(&base_map.path.join("clouds"), clouds, keyframes, 0)?;
        let mut whole = finished.clone();
        let poses = finished.graph.nodes.iter().zip(&base_map.poses).map(|(node, pose)| {
            // The optimiser writes valid poses only; an invalid one came from elsewhere.
            isometry_from_pose(&node.map_from_keyframe).unwrap_or(*pose)
        });
        let poses: Vec<Isometry> = poses.collect();
        whole.trajectory = base_map.moved_trajectory(&poses).chain(whole.trajectory).collect();
        whole.decisions.splice(0..0, base_map.decisions);
        whole.distance_m += base_map.summary.distance_m;
        Ok(Cow::Owned(whole))
    }

    pub(crate) fn remove_half_written_maps(&self) -> Result<(), StoreError> {
        let maps = files::entries(&self.dir().maps())?;
        maps.iter().filter(|path| is_temporary(path)).try_for_each(|path| files::remove_directory(path))
    }
}

fn rename(from: &Path, to: &PathBuf) -> Result<(), StoreError> {
    fs::rename(from, to).map_err(|source| StoreError::io("write", to, source))
}

#[cfg(test)]
#[path = "maps_tests.rs"]
pub(crate) mod tests;
