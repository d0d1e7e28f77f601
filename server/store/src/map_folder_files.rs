//! The files in a map's folder: which of them have a checksum.

use crate::{StoreError, files};
use std::path::{Path, PathBuf};

/// Name of the file in the folder of a deleted map.
pub(crate) const DELETION_NAME: &str = "deleted.json";
/// Names of files in a map's folder that have no checksum in `checksums.b3`: that file itself, `map.json`, which has its own and is rewritten when the map
/// gets another name, and the reports of commands, which are for people only.
const WITHOUT_CHECKSUM: [&str; 4] = ["checksums.b3", "map.json", "summary.json", "align.json"];

/// Paths in a map's folder of the files that have a checksum, in order.
pub(crate) fn files_with_checksum(folder: &Path) -> Result<Vec<String>, StoreError> {
    let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut names = Vec::new();
    for path in files::entries(folder)? {
        match name(&path).as_str() {
            "clouds" if path.is_dir() => {
                names.extend(files::entries(&path)?.iter().map(|cloud| format!("clouds/{}", name(cloud))));
            }
            // Tiles have their hash as name.
            "tiles" if path.is_dir() => {}
            // It comes and goes with the map's place in the bin.
            other if other.starts_with(DELETION_NAME) => {}
            other if WITHOUT_CHECKSUM.contains(&other) || files::is_temporary(&path) => {}
            other => names.push(other.to_owned()),
        }
    }
    Ok(names)
}
