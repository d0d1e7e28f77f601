//! Finds the shared test data, which is not part of the repository.

use std::path::{Path, PathBuf};

/// A folder of test data; `None`, with a printed note, if it does not exist.
pub fn folder(name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("AUTOINSPECT_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from);
    let folder = root.join(name);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: test data {} is not there; set AUTOINSPECT_DATA to its parent", folder.display());
    None
}
