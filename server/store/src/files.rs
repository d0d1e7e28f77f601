//! Files that are complete or absent, and directories that remember them after a power cut.

use crate::StoreError;
use serde::{Serialize, de::DeserializeOwned};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Makes a directory and those above it; being there already is fine.
pub fn make_directory(path: &Path) -> Result<(), StoreError> {
    fs::create_dir_all(path).map_err(|source| StoreError::io("make", path, source))
}

/// Writes a file through a buffer, and hands it to the disk.
pub fn write_durably(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), StoreError> {
    let write = || {
        let mut file = BufWriter::new(File::create(path)?);
        content(&mut file)?;
        file.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()
    };
    write().map_err(|source| StoreError::io("write", path, source))
}

/// Writes a document as JSON and hands it to the disk.
///
/// # Errors
/// When the disk does.
pub fn write_json<T: Serialize>(path: &Path, document: &T) -> Result<(), StoreError> {
    let bytes = serde_json::to_vec_pretty(document)
        .map_err(|source| StoreError::Document { path: path.to_owned(), source })?;
    write_durably(path, |file| file.write_all(&bytes))
}

/// Reads a JSON document.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, StoreError> {
    let bytes = fs::read(path).map_err(|source| StoreError::io("read", path, source))?;
    serde_json::from_slice(&bytes).map_err(|source| StoreError::Document { path: path.to_owned(), source })
}

/// Writes a file that others may be reading: they find all of it or nothing. It is not handed to the disk.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let temporary = path.with_extension("part");
    fs::write(&temporary, bytes)
        .and_then(|()| fs::rename(&temporary, path))
        .map_err(|source| StoreError::io("write", path, source))
}

/// As [`replace`], for what has to survive a power cut.
pub fn replace_durably(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let temporary = path.with_extension("part");
    write_durably(&temporary, |file| file.write_all(bytes))?;
    fs::rename(&temporary, path).map_err(|source| StoreError::io("write", path, source))?;
    path.parent().map_or(Ok(()), sync_directory)
}

/// Removes a file; being gone already is fine.
pub fn remove_file(path: &Path) -> Result<(), StoreError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(StoreError::io("remove", path, error)),
        _ => Ok(()),
    }
}

/// Hands a file that was written before to the disk.
pub fn sync_file(path: &Path) -> Result<(), StoreError> {
    File::open(path).and_then(|file| file.sync_all()).map_err(|source| StoreError::io("write", path, source))
}

/// Hands the names in a directory to the disk.
pub fn sync_directory(path: &Path) -> Result<(), StoreError> {
    // On Unix a directory is handed over as a file is.
    sync_file(path)
}

/// Paths in a directory, by name; none when it does not exist.
pub fn entries(path: &Path) -> Result<Vec<PathBuf>, StoreError> {
    let reading = |source| StoreError::io("read", path, source);
    let directory = match fs::read_dir(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other.map_err(reading)?,
    };
    let mut paths = directory
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<io::Result<Vec<_>>>()
        .map_err(reading)?;
    paths.sort();
    Ok(paths)
}

/// Removes a directory with all in it; being gone already is fine.
pub fn remove_directory(path: &Path) -> Result<(), StoreError> {
    match fs::remove_dir_all(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(StoreError::io("remove", path, error)),
        _ => Ok(()),
    }
}

/// Free space on the disk that holds a directory, bytes.
///
/// # Errors
/// When the disk does not say.
pub fn free_bytes(directory: &Path) -> Result<u64, StoreError> {
    let disk =
        rustix::fs::statvfs(directory).map_err(|error| StoreError::io("read", directory, error.into()))?;
    Ok(disk.f_bavail.saturating_mul(disk.f_frsize))
}

/// Bytes of all files in a directory and those below it.
///
/// # Errors
/// When the disk does.
pub fn bytes_below(directory: &Path) -> Result<u64, StoreError> {
    entries(directory)?.iter().try_fold(0, |sum, path| {
        let about = fs::symlink_metadata(path).map_err(|source| StoreError::io("read", path, source))?;
        Ok(sum + if about.is_dir() { bytes_below(path)? } else { about.len() })
    })
}
