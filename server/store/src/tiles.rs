//! Tiles as files named by the BLAKE3 of their bytes.

use crate::{Store, StoreError, files, texts};
use api::{TileHash, TileList};
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

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
        if !path.exists() {
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
        files::sync_directory(directory)
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
    /// Removes tiles of a session that has ended, except those that belong to a saved map too.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn remove_session_tiles(&self, tiles: &[TileHash]) -> Result<(), StoreError> {
        let referenced = self.tiles_referenced_by_maps()?;
        tiles.iter().filter(|hash| !referenced.contains(hash)).try_for_each(|hash| self.tiles().remove(*hash))
    }

    /// Removes every tile that no saved map refers to, and temporary files beside them.
    pub(crate) fn remove_unreferenced_tiles(&self) -> Result<(), StoreError> {
        let referenced = self.tiles_referenced_by_maps()?;
        for directory in files::entries(&self.dir().tiles())? {
            for path in files::entries(&directory)? {
                let hash: Option<TileHash> =
                    path.file_name().and_then(|name| name.to_str()).and_then(|name| name.parse().ok());
                if !hash.is_some_and(|hash| referenced.contains(&hash)) {
                    fs::remove_file(&path).map_err(|source| StoreError::io("remove", &path, source))?;
                }
            }
        }
        Ok(())
    }

    fn tiles_referenced_by_maps(&self) -> Result<BTreeSet<TileHash>, StoreError> {
        let mut referenced = BTreeSet::new();
        for map in self.maps()? {
            let list: TileList = files::read_json(&self.dir().map_tiles(map.id))?;
            referenced.extend(list.tiles.iter().map(|tile| tile.hash));
        }
        Ok(referenced)
    }
}
