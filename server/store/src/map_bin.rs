//! The bin: deleted maps, which are kept for a week and can be restored.
//!
//! `bin/<map id>/` is the folder of the map as it was, and `deleted.json` in it says since when it is there. A map is moved by renaming its folder, so at
//! every moment it is whole in one place or the other. Its docks stay in `docks.json`, and its tiles count as used. A map whose files cannot be read can be moved
//! too; it stays in the bin until a person deletes it for good.

use crate::checked_json::{Versions, read_checked_json, to_checked_json};
use crate::map_document::MapDocument;
use crate::map_folder_files::DELETION_NAME;
use crate::map_folders::{MapFolder, is_temporary};
use crate::{Store, StoreError, files};
use api::{BIN_RETENTION, MapSummary};
use messages::PoseInMap;
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::time::SystemTime;
use vocab::{MapId, Stamp};

/// Versions of [`DeletionDocument`].
const DELETION_FORMAT_VERSIONS: Versions = Versions { first_checked: 2, newest: 2 };

/// `deleted.json` of a map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct DeletionDocument {
    format_version: u32,
    /// Calendar time at which the map was deleted; none if the clock was not synchronised then, and has not been since.
    #[serde(default)]
    deleted_at: Option<Stamp>,
    /// The robot's last pose, if it was in this map, and this map cannot be read. A map that can be read is deleted only after the robot has left it.
    #[serde(default)]
    last_pose: Option<PoseInMap>,
}

impl DeletionDocument {
    fn read(folder: &Path) -> Result<Self, StoreError> {
        read_checked_json(&folder.join(DELETION_NAME), DELETION_FORMAT_VERSIONS)
    }

    fn write(&self, folder: &Path) -> Result<(), StoreError> {
        let path = folder.join(DELETION_NAME);
        files::replace_durably(&path, &to_checked_json(&path, self)?)
    }
}

/// A map in the bin.
#[derive(Debug)]
pub struct BinnedMap {
    /// Which.
    pub map: MapId,
    /// Its entry in the list of maps, if that can be read.
    pub summary: Option<MapSummary>,
    /// Calendar time at which it was deleted, if that is known.
    pub deleted_at: Option<Stamp>,
    /// What is wrong with its files, if anything is; names the file. Such a map stays until a person decides.
    pub problem: Option<StoreError>,
}

impl BinnedMap {
    /// When it is deleted for good; none if nobody knows.
    pub fn kept_until(&self) -> Option<Stamp> {
        self.deleted_at.filter(|_| self.problem.is_none()).map(|deleted| deleted + BIN_RETENTION)
    }
}

impl Store {
    /// Gives a saved map another name.
    ///
    /// # Errors
    /// When there is no such map, it cannot be read, or the disk fails.
    pub fn rename_map(&self, map: MapId, name: &str) -> Result<(), StoreError> {
        if !self.dir().map(map).is_dir() {
            return Err(StoreError::NoSuchMap { id: map });
        }
        MapDocument::rename(&self.dir().map_summary(map), name)
    }

    /// Moves a saved map to the bin; it need not be readable. Does nothing if it is there already. `now` is the calendar time, if that is known. A stored pose
    /// in it goes along if the map cannot be read, and is in force again when the map is restored. In a map that can be read it is one that the robot has
    /// left, and it is removed.
    ///
    /// # Errors
    /// When there is no such map, another one of the same id is in the bin, or the disk fails.
    pub fn bin_map(&self, map: MapId, now: Option<Stamp>) -> Result<(), StoreError> {
        let _changing = self.lock_map_change();
        let (from, to) = (self.dir().map(map), self.dir().binned_map(map));
        match (from.is_dir(), to.exists()) {
            (false, true) => return Ok(()),
            (false, false) => return Err(StoreError::NoSuchMap { id: map }),
            (true, true) => return Err(StoreError::MapInBin { id: map }),
            (true, false) => {}
        }
        let is_readable = MapFolder::read(&from).is_ok();
        let stored_pose = self.stored_pose().filter(|pose| pose.map == map);
        if stored_pose.is_some() && is_readable {
            self.save_last_pose(None)?;
        }
        let last_pose = stored_pose.filter(|_| !is_readable);
        let deletion =
            DeletionDocument { format_version: DELETION_FORMAT_VERSIONS.newest, deleted_at: now, last_pose };
        // A process that is killed here leaves the map where it was, with a file that nobody reads.
        deletion.write(&from)?;
        self.move_map(&from, &to)
    }

    /// Moves a map back from the bin. Does nothing if it is back already.
    ///
    /// # Errors
    /// When it is not in the bin, another one of the same id is saved, or the disk fails.
    pub fn restore_map(&self, map: MapId) -> Result<(), StoreError> {
        let _changing = self.lock_map_change();
        let (from, to) = (self.dir().binned_map(map), self.dir().map(map));
        match (from.is_dir(), to.exists()) {
            (false, true) => return Ok(()),
            (false, false) => return Err(StoreError::NotInBin { id: map }),
            (true, true) => return Err(StoreError::MapExists { id: map }),
            (true, false) => {}
        }
        let deletion = DeletionDocument::read(&from);
        if let Ok(DeletionDocument { last_pose: Some(pose), .. }) = &deletion
            && !self.dir().last_pose().exists()
        {
            self.save_last_pose(Some(pose))?;
        }
        self.move_map(&from, &to)?;
        let path = to.join(DELETION_NAME);
        match deletion {
            Err(_) if path.exists() => files::put_aside(&path).map(drop),
            _ => files::remove_file(&path),
        }
    }

    /// Deletes a map in the bin for good. Does nothing if it is not there. Its tiles stay for the grace of unused tiles.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn delete_map_permanently(&self, map: MapId) -> Result<(), StoreError> {
        let folder = self.dir().binned_map(map);
        if !folder.is_dir() {
            return Ok(());
        }
        self.make_tiles_new(&folder)?;
        // A folder of this name is removed when the store is opened, so a process that is killed here leaves no half of a map.
        let leaving = self.dir().bin().join(format!(".{map}"));
        files::remove_directory(&leaving)?;
        self.move_map(&folder, &leaving)?;
        files::remove_directory(&leaving)
    }

    /// The maps in the bin, the last deleted first.
    ///
    /// # Errors
    /// When the bin cannot be read.
    pub fn binned_maps(&self) -> Result<Vec<BinnedMap>, StoreError> {
        let folders = files::entries(&self.dir().bin())?;
        let folders = folders.iter().filter(|path| path.is_dir() && !is_temporary(path));
        let mut maps: Vec<_> = folders.filter_map(|folder| read_entry(folder)).collect();
        maps.sort_by_key(|map| {
            (std::cmp::Reverse(map.deleted_at.unwrap_or(Stamp::from_nanos(i64::MAX))), map.map)
        });
        Ok(maps)
    }

    /// Deletes maps for good that have been in the bin for [`BIN_RETENTION`] at this calendar time, and notes that time for those of which it was not known when
    /// they were deleted. Maps with damaged files stay. Returns the names of the deleted ones.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn empty_bin(&self, now: Stamp) -> Result<Vec<String>, StoreError> {
        let mut deleted = Vec::new();
        for BinnedMap { map, summary, deleted_at, problem } in self.binned_maps()? {
            let (None, Some(summary)) = (problem, summary) else { continue };
            match deleted_at {
                Some(at) if now - at >= BIN_RETENTION => {
                    self.delete_map_permanently(map)?;
                    deleted.push(summary.name);
                }
                Some(_) => {}
                None => {
                    let folder = self.dir().binned_map(map);
                    let deletion = DeletionDocument::read(&folder)?;
                    DeletionDocument { deleted_at: Some(now), ..deletion }.write(&folder)?;
                }
            }
        }
        Ok(deleted)
    }

    /// Goes on removing maps that were being deleted for good when a process ended.
    pub(crate) fn remove_leaving_maps(&self) -> Result<(), StoreError> {
        let folders = files::entries(&self.dir().bin())?;
        folders.iter().filter(|path| is_temporary(path)).try_for_each(|path| files::remove_directory(path))
    }

    /// Renames the folder of a map durably.
    fn move_map(&self, from: &Path, to: &Path) -> Result<(), StoreError> {
        fs::rename(from, to).map_err(|source| StoreError::io("move", from, source))?;
        for directory in [to.parent(), from.parent()].into_iter().flatten() {
            files::sync_directory(directory)?;
        }
        Ok(())
    }

    /// Lets the grace of a map's tiles begin now.
    fn make_tiles_new(&self, folder: &Path) -> Result<(), StoreError> {
        let Ok(MapFolder { tiles, .. }) = MapFolder::read(folder) else { return Ok(()) };
        let now = SystemTime::now();
        for tile in &tiles.tiles {
            let path = self.dir().tile(tile.hash);
            match File::open(&path).and_then(|file| file.set_modified(now)) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    return Err(StoreError::io("write", &path, error));
                }
                _ => {}
            }
        }
        Ok(())
    }
}

/// The entry of a folder in the bin; none if its name is no id.
fn read_entry(folder: &Path) -> Option<BinnedMap> {
    let map = folder.file_name()?.to_str()?.parse().ok()?;
    let (deletion, files) = (DeletionDocument::read(folder), MapFolder::read(folder));
    let deleted_at = deletion.as_ref().ok().and_then(|deletion| deletion.deleted_at);
    let (summary, damage) = match files {
        Ok(MapFolder { summary, .. }) => (Some(summary), None),
        Err(error) => (MapDocument::read(&folder.join("map.json")).ok().map(|it| it.summary), Some(error)),
    };
    Some(BinnedMap { map, summary, deleted_at, problem: damage.or(deletion.err()) })
}

#[cfg(test)]
#[path = "map_bin_tests.rs"]
mod tests;
