//! `map.json`: the entry of a map in the list of maps.

use crate::checked_json::{Versions, read_checked_json, to_checked_json};
use crate::{StoreError, files};
use api::MapSummary;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Version of the files in a map's folder that this program writes. Greater ones were written by a later program, and are not read.
/// Version 2 has units in the names of `map.json` and `loops.json`, and version 3 has checksums; earlier ones are read too.
const MAP_FORMAT_VERSIONS: Versions = Versions { first_checked: 3, newest: 3 };

/// `map.json`: the entry in the list of maps, with the version of all files of the map.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct MapDocument {
    /// Programs up to November 2026 wrote none, which counts as 1.
    #[serde(default = "files::first_format_version")]
    format_version: u32,
    #[serde(flatten)]
    pub summary: MapSummary,
}

impl MapDocument {
    pub fn new(summary: MapSummary) -> Self {
        Self { format_version: MAP_FORMAT_VERSIONS.newest, summary }
    }

    /// Reads it.
    ///
    /// # Errors
    /// When it is missing, damaged, or of a later version.
    pub fn read(path: &Path) -> Result<Self, StoreError> {
        read_checked_json(path, MAP_FORMAT_VERSIONS)
    }

    /// Gives the map another name. All else stays as it was written, its version included.
    ///
    /// # Errors
    /// When the document is missing, damaged, or of a later version, or the disk fails.
    pub fn rename(path: &Path, name: &str) -> Result<(), StoreError> {
        Self::read(path)?;
        let mut document: serde_json::Value = files::read_json(path)?;
        document["name"] = name.into();
        if let Some(fields) = document.as_object_mut() {
            fields.remove("checksum");
        }
        files::replace_durably(path, &to_checked_json(path, &document)?)
    }

    /// Whether the map in this folder is of a version without `checksums.b3`.
    pub fn is_older_than_checksums(folder: &Path) -> bool {
        Self::read(&folder.join("map.json"))
            .is_ok_and(|document| document.format_version < MAP_FORMAT_VERSIONS.first_checked)
    }

    pub fn write(&self, path: &Path) -> Result<(), StoreError> {
        files::replace_durably(path, &to_checked_json(path, self)?)
    }
}
