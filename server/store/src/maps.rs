//! Map versions: immutable directories that appear whole or not at all.

use crate::cloud_files::copy_cloud_files;
use crate::sessions::remove_encoded;
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

/// What a new map leaves free on the disk, bytes.
const DISK_RESERVE_BYTES: u64 = 2 << 30;

impl Store {
    /// Every saved map, newest first. A map that cannot be read is left out and logged: one bad directory must not
    /// hide the others.
    ///
    /// # Errors
    /// When the directory of maps cannot be read.
    pub fn maps(&self) -> Result<Vec<MapSummary>, StoreError> {
        let mut maps: Vec<MapSummary> = Vec::new();
        for directory in files::entries(&self.dir().maps())?.iter().filter(|path| !is_temporary(path)) {
            match files::read_json(&directory.join("map.json")) {
                Ok(summary) => maps.push(summary),
                Err(error) => tracing::error!("{} is no map: {error}", directory.display()),
            }
        }
        maps.sort_by_key(|map| (std::cmp::Reverse(map.created), map.id));
        Ok(maps)
    }

    /// The tiles of a saved map.
    ///
    /// # Errors
    /// When there is no such map, or it cannot be read.
    pub fn map_tiles(&self, map: MapId) -> Result<TileList, StoreError> {
        files::read_json(&self.dir().map_tiles(map))
    }

    /// A saved map, but for clouds and tiles.
    ///
    /// # Errors
    /// When there is no such map, or it cannot be read.
    pub fn map(&self, map: MapId) -> Result<SavedMap, StoreError> {
        SavedMap::read(&self.dir().map(map))
    }

    /// Saves a finished session as an immutable map version, with the clouds kept by [`Store::write_session_cloud`]. The version
    /// is listed only once all of it is on the disk; when saving fails the clouds stay, so that it can be tried again.
    ///
    /// # Errors
    /// When the id is taken, the session has no keyframes, or the disk fails.
    pub fn save_map(&self, finished: &FinishedMap) -> Result<MapFilesReport, StoreError> {
        let session = self.session(finished.session);
        if finished.graph.nodes.is_empty() || !session.exists() {
            return Err(StoreError::EmptySession { session: finished.session });
        }
        let temporary = self.make_room(finished.map)?;
        let clouds = temporary.join("clouds");
        rename(&session, &clouds)?;
        let written = remove_encoded(&clouds)
            .and_then(|()| self.include_extended_map(finished, &clouds))
            .and_then(|whole| write_map_files(&temporary, &self.tiles(), &whole, MapFileOptions::default()));
        self.publish(finished.map, written, || rename(&clouds, &session))
    }

    /// Adds a map that was made elsewhere: `prepare` puts its keyframes' clouds into `clouds/` in the folder that it is given, and
    /// whatever else belongs to it; `points` (map frame) are for the tiles.
    ///
    /// # Errors
    /// When the id is taken, `prepare` fails, or the disk does; nothing of it is left then.
    pub fn add_map(
        &self,
        finished: &FinishedMap,
        options: MapFileOptions,
        points: MapPoints,
        prepare: impl FnOnce(&Path) -> Result<(), StoreError>,
    ) -> Result<MapFilesReport, StoreError> {
        let temporary = self.make_room(finished.map)?;
        let written = files::make_directory(&temporary.join("clouds")).and_then(|()| prepare(&temporary));
        let written =
            written.and_then(|()| write_map_files_of(&temporary, &self.tiles(), finished, options, points));
        self.publish(finished.map, written, || Ok(()))
    }

    /// Whether the disk has room for another map as large as this one, with its tiles, and for the robot to go on recording.
    ///
    /// # Errors
    /// When the disk does not say.
    pub fn has_space_for_copy(&self, map: MapId) -> Result<bool, StoreError> {
        let folder = self.dir().map(map);
        let needed = files::bytes_below(&folder)?.saturating_mul(2).saturating_add(DISK_RESERVE_BYTES);
        Ok(files::free_bytes(&folder)? >= needed)
    }

    /// Takes in a map that another process has written to `from`, on the same disk, with its tiles in `from/tiles`.
    ///
    /// # Errors
    /// When it is there already, is none, or the disk fails; nothing of it is left here then.
    pub fn adopt_map(&self, from: &Path) -> Result<MapSummary, StoreError> {
        let summary: MapSummary = files::read_json(&from.join("map.json"))?;
        let place = self.dir().map(summary.id);
        if place.exists() {
            return Err(StoreError::MapExists { id: summary.id });
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
        rename(from, &place)?;
        files::sync_directory(&self.dir().maps())?;
        Ok(summary)
    }

    /// Where a map is put together: an empty directory that is not listed.
    fn make_room(&self, map: MapId) -> Result<PathBuf, StoreError> {
        if self.dir().map(map).exists() {
            return Err(StoreError::MapExists { id: map });
        }
        let temporary = self.staging_directory(map);
        files::remove_directory(&temporary)?;
        files::make_directory(&temporary)?;
        Ok(temporary)
    }

    fn staging_directory(&self, map: MapId) -> PathBuf {
        self.dir().maps().join(format!(".{map}"))
    }

    /// Lists a map that was written whole. Where it was not, `recover` takes out of its directory what must not be lost, and the
    /// rest is removed.
    fn publish(
        &self,
        map: MapId,
        written: Result<MapFilesReport, StoreError>,
        recover: impl FnOnce() -> Result<(), StoreError>,
    ) -> Result<MapFilesReport, StoreError> {
        let temporary = self.staging_directory(map);
        match written.and_then(|report| rename(&temporary, &self.dir().map(map)).map(|()| report)) {
            Ok(report) => {
                files::sync_directory(&self.dir().maps())?;
                Ok(report)
            }
            Err(error) => {
                recover()?;
                files::remove_directory(&temporary)?;
                Err(error)
            }
        }
    }

    /// A finished map with the trajectory, decisions and metres of the map that it goes on from, and in `clouds` whatever of that one's
    /// is missing because it could not be copied before.
    fn include_extended_map<'a>(
        &self,
        finished: &'a FinishedMap,
        clouds: &Path,
    ) -> Result<Cow<'a, FinishedMap>, StoreError> {
        let Some(map) = finished.extends else { return Ok(Cow::Borrowed(finished)) };
        let before = self.map(map)?;
        let keyframes = (0..before.poses.len() as u32).map(KeyframeId);
        copy_cloud_files(&before.path.join("clouds"), clouds, keyframes, 0)?;
        let mut whole = finished.clone();
        let now = finished.graph.nodes.iter().zip(&before.poses).map(|(node, pose)| {
            // A pose that is none was never one of the graph's.
            isometry_from_pose(&node.map_from_keyframe).unwrap_or(*pose)
        });
        let now: Vec<Isometry> = now.collect();
        whole.trajectory = before.moved(&now).chain(whole.trajectory).collect();
        whole.decisions.splice(0..0, before.decisions);
        whole.distance += before.summary.distance;
        Ok(Cow::Owned(whole))
    }

    pub(crate) fn remove_half_written_maps(&self) -> Result<(), StoreError> {
        let maps = files::entries(&self.dir().maps())?;
        maps.iter().filter(|path| is_temporary(path)).try_for_each(|path| files::remove_directory(path))
    }
}

fn is_temporary(path: &Path) -> bool {
    path.file_name().is_none_or(|name| name.as_encoded_bytes().starts_with(b"."))
}

fn rename(from: &Path, to: &PathBuf) -> Result<(), StoreError> {
    fs::rename(from, to).map_err(|source| StoreError::io("write", to, source))
}

#[cfg(test)]
#[path = "maps_tests.rs"]
mod tests;
