//! The folders of maps: which there are, and what lists each.

use crate::map_document::MapDocument;
use crate::{StoreError, files, texts};
use api::{MapSummary, TileList};
use std::path::{Path, PathBuf};

/// A folder of a map that cannot be listed.
#[derive(Debug)]
pub struct DamagedMap {
    /// The folder.
    pub folder: PathBuf,
    /// What is wrong; names the file.
    pub error: StoreError,
}

/// All folders of maps.
#[derive(Debug, Default)]
pub(crate) struct MapFolders {
    pub readable: Vec<MapFolder>,
    pub damaged: Vec<DamagedMap>,
}

impl MapFolders {
    /// Reads the list entry and the tile list of every map in a directory of maps.
    pub fn read(directory: &Path) -> Result<Self, StoreError> {
        let mut maps = Self::default();
        let folders = files::entries(directory)?;
        for folder in folders.into_iter().filter(|path| path.is_dir() && !is_temporary(path)) {
            match MapFolder::read(&folder) {
                Ok(map) => maps.readable.push(map),
                Err(error) => maps.damaged.push(DamagedMap { folder, error }),
            }
        }
        Ok(maps)
    }
}

/// What lists a map.
#[derive(Debug)]
pub(crate) struct MapFolder {
    pub summary: MapSummary,
    pub tiles: TileList,
}

impl MapFolder {
    pub fn read(folder: &Path) -> Result<Self, StoreError> {
        let path = folder.join("map.json");
        let summary = MapDocument::read(&path)?.summary;
        // Clients ask for files by the id, so a folder with another name would be listed and never found.
        if folder.file_name().is_none_or(|name| *name != *summary.id.to_string()) {
            return Err(StoreError::Broken { path, what: texts::ID_OF_ANOTHER_MAP });
        }
        Ok(Self { summary, tiles: files::read_json(&folder.join("tiles.json"))? })
    }
}

/// Whether a folder is not yet, or no longer, a map.
pub(crate) fn is_temporary(path: &Path) -> bool {
    path.file_name().is_none_or(|name| name.as_encoded_bytes().starts_with(b"."))
}
