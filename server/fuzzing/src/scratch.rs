//! Bytes as a file, for readers that open a path.

use std::fs;
use std::path::Path;
use tempfile::TempDir;

thread_local! {
    /// A folder for each thread, because tests run in several. `TMPDIR` should name one in memory for a fuzzer.
    static FOLDER: TempDir = tempfile::tempdir().expect("a temporary folder can be made");
}

/// Writes `bytes` to a file of this name and calls `read` with its path.
///
/// # Panics
/// When the file cannot be written.
pub(crate) fn with_file<T>(name: &str, bytes: &[u8], read: impl FnOnce(&Path) -> T) -> T {
    with_folder(|folder| {
        let path = folder.join(name);
        fs::write(&path, bytes).expect("a temporary file can be written");
        read(&path)
    })
}

/// Calls `act` with this thread's folder.
pub(crate) fn with_folder<T>(act: impl FnOnce(&Path) -> T) -> T {
    FOLDER.with(|folder| act(folder.path()))
}
