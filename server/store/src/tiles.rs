//! Tiles as files named by the BLAKE3 of their bytes.

use crate::map_folders::MapFolders;
use crate::{Store, StoreError, files, texts};
use api::TileHash;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Parameters of the store of tiles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TilesConfig {
    /// Age from which a tile that no saved map refers to is removed. A day: whoever removes or restores a map by hand has that long to notice.
    pub(crate) unused_grace: Duration,
}

pub(crate) const CONFIG: TilesConfig = TilesConfig { unused_grace: Duration::from_secs(24 * 3600) };

/// A directory of tiles: `ab/<hash>`.
#[derive(Clone, Debug)]
pub struct TileFiles {
    dir: PathBuf,
}

/// Whether a tile has to survive a power cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Durability {
    /// Of a running session, which a power cut ends anyway.
    Session,
    /// Of a saved map.
    Map,
}

impl TileFiles {
    /// Tiles in `dir`, which need not exist yet.
    pub fn new(dir: impl Into<PathBuf>) -> Self {
        Self { dir: dir.into() }
    }

    /// The bytes of a tile.
    pub(crate) fn read(&self, hash: TileHash) -> Result<Vec<u8>, StoreError> {
        let path = self.path(hash);
        fs::read(&path).map_err(|source| StoreError::io("read", &path, source))
    }

    /// Writes a tile of a running session. It may be lost in a power cut.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn put(&self, bytes: &[u8]) -> Result<TileHash, StoreError> {
        self.put_with_durability(bytes, Durability::Session)
    }

    pub(crate) fn put_with_durability(
        &self,
        bytes: &[u8],
        durability: Durability,
    ) -> Result<TileHash, StoreError> {
        let hash = TileHash(*blake3::hash(bytes).as_bytes());
        let path = self.path(hash);
        let Some(directory) = path.parent() else {
            return Ok(hash);
        };
        // A power cut may have left a file with this name that lacks bytes.
        if !fs::read(&path).is_ok_and(|existing| existing == bytes) {
            files::make_directory(directory)?;
            let temporary = directory.join(format!(".{hash}"));
            File::create(&temporary)
                .and_then(|mut file| file.write_all(bytes))
                .and_then(|()| fs::rename(&temporary, &path))
                .map_err(|source| StoreError::io("write", &path, source))?;
        }
        if durability == Durability::Map {
            // A session may have written this tile before, without syncing it.
            files::sync_file(&path)?;
            files::sync_directory(directory)?;
            files::sync_directory(&self.dir)?;
        }
        Ok(hash)
    }

    /// Moves a tile's file into this directory.
    pub(crate) fn adopt(&self, from: &Path) -> Result<(), StoreError> {
        let name = from.file_name().unwrap_or_default().to_string_lossy();
        let broken = || StoreError::Broken { path: from.to_owned(), what: texts::NO_TILE_NAME };
        let hash: TileHash = name.parse().map_err(|_| broken())?;
        let path = self.path(hash);
        let Some(directory) = path.parent() else { return Ok(()) };
        files::make_directory(directory)?;
        fs::rename(from, &path).map_err(|source| StoreError::io("write", &path, source))?;
        files::sync_directory(directory)?;
        files::sync_directory(&self.dir)
    }

    fn path(&self, hash: TileHash) -> PathBuf {
        let name = hash.to_string();
        self.dir.join(&name[..2]).join(name)
    }

    /// Removes a tile; no error if it does not exist.
    fn remove(&self, hash: TileHash) -> Result<(), StoreError> {
        files::remove_file(&self.path(hash))
    }
}

impl Store {
    /// Removes tiles of a session that has ended, except those that belong to a saved map too. While a saved map cannot be read, nothing is removed.
    ///
    /// # Errors
    /// When the disk fails, or a saved map cannot be read.
    pub fn remove_session_tiles(&self, tiles: &[TileHash]) -> Result<(), StoreError> {
        let _removing = self.lock_tile_removal();
        let referenced = self.tiles_referenced_by_maps()?;
        tiles.iter().filter(|hash| !referenced.contains(hash)).try_for_each(|hash| self.tiles().remove(*hash))
    }

    /// Removes tiles, and temporary files of tiles, that no map refers to, saved or in the bin, and that were written more than
    /// [`TilesConfig::unused_grace`] ago. While such a map cannot be read, nothing is removed. Files with other names stay. Not to be called while a
    /// mapping session runs: its tiles belong to no map.
    ///
    /// # Errors
    /// When the disk fails, or a map cannot be read.
    pub fn remove_unused_tiles(&self, now: SystemTime) -> Result<(), StoreError> {
        let _removing = self.lock_tile_removal();
        let referenced = self.tiles_referenced_by_maps()?;
        for directory in files::entries(&self.dir().tiles())? {
            if !directory.is_dir() {
                continue;
            }
            for path in files::entries(&directory)? {
                let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
                let is_unused = match name.strip_prefix('.') {
                    Some(temporary) => temporary.parse::<TileHash>().is_ok(),
                    None => name.parse().is_ok_and(|hash: TileHash| !referenced.contains(&hash)),
                };
                if is_unused && files::is_older_than(&path, CONFIG.unused_grace, now) {
                    files::remove_file(&path)?;
                }
            }
        }
        Ok(())
    }

    /// The tiles of all saved maps and of those in the bin.
    fn tiles_referenced_by_maps(&self) -> Result<BTreeSet<TileHash>, StoreError> {
        let mut referenced = BTreeSet::new();
        for directory in [self.dir().maps(), self.dir().bin()] {
            let maps = MapFolders::read(&directory)?;
            if let Some(damaged) = maps.damaged.into_iter().next() {
                return Err(damaged.error);
            }
            let tiles = maps.readable.iter().flat_map(|map| &map.tiles.tiles);
            referenced.extend(tiles.map(|tile| tile.hash));
        }
        Ok(referenced)
    }
}
