//! Looks for damage in what is stored: reads the ledger, every file of the maps, their tiles, the clouds of interrupted sessions and what actions have gathered, and
//! compares it with its checksum. Nothing is changed.

use crate::checked_json::read_checked_json;
use crate::checksums::{Checksums, hash_file};
use crate::map_document::MapDocument;
use crate::map_folder_files::files_with_checksum;
use crate::map_folders::MapFolders;
use crate::recovered_sessions::SessionRecoveryConfig;
use crate::sessions::is_cloud;
use crate::uploads::NOTE_FORMAT_VERSIONS;
use crate::{SavedMap, Store, StoreError, files, texts};
use api::TileHash;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::Path;
use vocab::SessionId;

/// Who gets what is found.
pub trait StoredDataReport {
    /// A file is damaged. The error names it.
    fn on_damage(&mut self, error: StoreError);

    /// This number of bytes was read. `Break` ends the check.
    fn on_read(&mut self, bytes: u64) -> ControlFlow<()>;
}

impl Store {
    /// Reads all maps that can be listed, their tiles, files that actions have gathered, and these sessions, none of which runs. Maps of programs that wrote no checksums are
    /// read too, but only damage that makes a file unreadable is found in them. Time: that of reading everything. Memory: the hashes of all tiles.
    ///
    /// # Errors
    /// When the directory of maps cannot be read.
    pub fn check_stored_data(
        &self,
        sessions: &[SessionId],
        report: &mut dyn StoredDataReport,
    ) -> Result<(), StoreError> {
        if self.check_ledger(report).is_break() {
            return Ok(());
        }
        let mut tiles = BTreeSet::new();
        for directory in [self.dir().maps(), self.dir().bin()] {
            for map in MapFolders::read(&directory)?.readable {
                if check_map(&directory.join(map.summary.id.to_string()), report).is_break() {
                    return Ok(());
                }
                tiles.extend(map.tiles.tiles.iter().map(|tile| tile.hash));
            }
        }
        self.check_upload_notes(report)?;
        for session in sessions {
            if check_session(&self.session(*session), report).is_break() {
                return Ok(());
            }
        }
        for tile in tiles {
            if self.check_tile(tile, report).is_break() {
                return Ok(());
            }
        }
        // The last thing to be read, so that nothing is left to break off.
        let _ = self.check_blobs(report)?;
        Ok(())
    }

    fn check_upload_notes(&self, report: &mut dyn StoredDataReport) -> Result<(), StoreError> {
        let uploads = files::entries(&self.dir().uploads())?;
        for note in uploads.iter().filter(|path| path.extension().is_some_and(|ending| ending == "json")) {
            let read = read_checked_json::<serde::de::IgnoredAny>(note, NOTE_FORMAT_VERSIONS);
            // It may have been removed meanwhile.
            if let Err(error) = read
                && note.exists()
            {
                report.on_damage(error);
            }
        }
        Ok(())
    }

    fn check_tile(&self, tile: TileHash, report: &mut dyn StoredDataReport) -> ControlFlow<()> {
        let path = self.dir().tile(tile);
        match hash_file(&path) {
            Ok((hash, bytes)) => {
                if *hash.as_bytes() != tile.0 {
                    report.on_damage(StoreError::Checksum { path });
                }
                report.on_read(bytes)
            }
            Err(error) => {
                report.on_damage(error);
                report.on_read(0)
            }
        }
    }
}

/// Checks the files of a map. One that is removed or moved meanwhile is not damaged.
fn check_map(folder: &Path, report: &mut dyn StoredDataReport) -> ControlFlow<()> {
    let on_damage = |error, report: &mut dyn StoredDataReport| {
        if folder.join("map.json").exists() {
            report.on_damage(error);
        }
    };
    let sums = match Checksums::read(folder) {
        Ok(Some(sums)) => sums,
        Ok(None) if MapDocument::is_older_than_checksums(folder) => {
            if let Err(error) = SavedMap::read(folder) {
                on_damage(error, report);
            }
            return ControlFlow::Continue(());
        }
        Ok(None) => {
            let (path, what) = (Checksums::path(folder), texts::CHECKSUMS_MISSING);
            on_damage(StoreError::Broken { path, what }, report);
            return ControlFlow::Continue(());
        }
        Err(error) => {
            on_damage(error, report);
            return ControlFlow::Continue(());
        }
    };
    let mut names: BTreeSet<String> = sums.names().map(str::to_owned).collect();
    match files_with_checksum(folder) {
        Ok(found) => names.extend(found),
        Err(error) => on_damage(error, report),
    }
    for name in names {
        let read = match sums.check(folder, &name) {
            Ok(bytes) => bytes,
            Err(error) => {
                on_damage(error, report);
                0
            }
        };
        if !sums.has(&name) {
            // Either of the two may be the damaged one.
            let (path, what) = (Checksums::path(folder), texts::CHECKSUM_LACKS_FILE);
            on_damage(StoreError::Broken { path, what }, report);
        }
        report.on_read(read)?;
    }
    ControlFlow::Continue(())
}

/// Checks the clouds of an interrupted session.
fn check_session(folder: &Path, report: &mut dyn StoredDataReport) -> ControlFlow<()> {
    let sums = match Checksums::read(folder) {
        Ok(Some(sums)) => sums,
        // Of a program that wrote none.
        Ok(None) => return ControlFlow::Continue(()),
        Err(error) => {
            report.on_damage(error);
            Checksums::default()
        }
    };
    let clouds = files::entries(folder).unwrap_or_default();
    let clouds = clouds.iter().filter(|path| is_cloud(path)).filter_map(|path| path.file_name()?.to_str());
    let mut names: BTreeSet<&str> = sums.names().collect();
    names.extend(clouds);
    let without: Vec<&str> = names.iter().copied().filter(|name| !sums.has(name)).collect();
    // The checksums of the last clouds may not have been written any more.
    let last = sums.names().max().unwrap_or_default();
    let lacks_earlier = !last.is_empty() && without.iter().any(|name| *name < last);
    if lacks_earlier || without.len() >= SessionRecoveryConfig::default().min_clouds_without_keyframe {
        let (path, what) = (Checksums::path(folder), texts::CHECKSUM_LACKS_FILE);
        report.on_damage(StoreError::Broken { path, what });
    }
    for name in names {
        let read = sums.check(folder, name).unwrap_or_else(|error| {
            // A person may have saved or discarded the session meanwhile.
            if folder.exists() {
                report.on_damage(error);
            }
            0
        });
        report.on_read(read)?;
    }
    ControlFlow::Continue(())
}

#[cfg(test)]
#[path = "stored_data_check_tests.rs"]
mod tests;
