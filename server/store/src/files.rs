//! Files that are complete or absent, also after a power cut.

use crate::StoreError;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Creates a directory and its parents; no error if it exists.
pub fn make_directory(path: &Path) -> Result<(), StoreError> {
    fs::create_dir_all(path).map_err(|source| StoreError::io("make", path, source))
}

/// Writes a file through a buffer and syncs it.
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

/// Writes a document as JSON and syncs it.
///
/// # Errors
/// When the disk fails.
pub fn write_json<T: Serialize>(path: &Path, document: &T) -> Result<(), StoreError> {
    let bytes = serde_json::to_vec_pretty(document).map_err(|error| StoreError::document(path, &error))?;
    write_durably(path, |file| file.write_all(&bytes))
}

/// Reads a JSON document.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, StoreError> {
    let bytes = fs::read(path).map_err(|source| StoreError::io("read", path, source))?;
    serde_json::from_slice(&bytes).map_err(|error| StoreError::document(path, &error))
}

/// The version of a JSON document. Documents of programs up to November 2026 that have none count as 1.
#[derive(Deserialize)]
struct FormatVersion {
    #[serde(default = "first_format_version")]
    format_version: u32,
}

/// Version of a document that has none.
pub fn first_format_version() -> u32 {
    1
}

/// Reads a JSON document that has a `format_version`. The version is read first, so that a document of a later program is recognised whatever else it holds.
///
/// # Errors
/// When it is missing, damaged, or of a later version than `newest`.
pub fn read_versioned<T: DeserializeOwned>(path: &Path, newest: u32) -> Result<T, StoreError> {
    let bytes = fs::read(path).map_err(|source| StoreError::io("read", path, source))?;
    if let Ok(FormatVersion { format_version }) = serde_json::from_slice(&bytes) {
        check_version(path, format_version, newest)?;
    }
    serde_json::from_slice(&bytes).map_err(|error| StoreError::document(path, &error))
}

/// Rejects to replace a document that a later program wrote. One that is missing or cannot be read may be replaced.
///
/// # Errors
/// When the document in this place has a later version than `newest`.
pub fn check_replaceable(path: &Path, newest: u32) -> Result<(), StoreError> {
    match read_versioned::<serde::de::IgnoredAny>(path, newest) {
        Err(error @ StoreError::LaterVersion { .. }) => Err(error),
        _ => Ok(()),
    }
}

/// Rejects a document that a later program wrote.
///
/// # Errors
/// When `version` is greater than `newest`.
pub fn check_version(path: &Path, version: u32, newest: u32) -> Result<(), StoreError> {
    if version > newest {
        return Err(StoreError::LaterVersion { path: path.to_owned(), version, newest });
    }
    Ok(())
}

/// Ending of the names of files that are being written.
const TEMPORARY_SUFFIX: &str = "part";

/// Whether a file was being written when its process was killed.
pub fn is_temporary(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == TEMPORARY_SUFFIX)
}

/// Under this name a file is written before it gets its own: `NAME.part`. It differs from the name that every other file has while it is written.
pub fn temporary_path(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{name}.{TEMPORARY_SUFFIX}"))
}

/// Replaces a file that others may be reading: they find the old or the new content. It is not synced: after a power cut it may be the old one, or damaged.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let temporary = temporary_path(path);
    fs::write(&temporary, bytes)
        .and_then(|()| fs::rename(&temporary, path))
        .map_err(|source| StoreError::io("write", path, source))
}

/// As [`replace`], and synced, so that it survives a power cut.
pub fn replace_durably(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let temporary = temporary_path(path);
    write_durably(&temporary, |file| file.write_all(bytes))?;
    fs::rename(&temporary, path).map_err(|source| StoreError::io("write", path, source))?;
    path.parent().map_or(Ok(()), sync_directory)
}

/// Renames a file that cannot be read to `NAME.damaged`, or `NAME.damaged-2` and so on where that exists, so that its place can be written again and nothing
/// is lost. Returns the new path.
///
/// # Errors
/// When the disk fails.
pub fn put_aside(path: &Path) -> Result<PathBuf, StoreError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let candidate = |number: u32| match number {
        1 => path.with_file_name(format!("{name}.damaged")),
        number => path.with_file_name(format!("{name}.damaged-{number}")),
    };
    // At least one of more names than files can exist is free.
    let free = (1..=u32::MAX).map(candidate).find(|candidate| fs::symlink_metadata(candidate).is_err());
    let free = free.unwrap_or_else(|| candidate(1));
    fs::rename(path, &free).map_err(|source| StoreError::io("rename", path, source))?;
    Ok(free)
}

/// Whether [`put_aside`] has put a file of this path aside.
pub fn was_put_aside(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    fs::symlink_metadata(path.with_file_name(format!("{name}.damaged"))).is_ok()
}

/// The file that [`put_aside`] has put aside last of this path, if it has.
pub fn last_put_aside(path: &Path) -> Option<PathBuf> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let exists = |path: &PathBuf| fs::symlink_metadata(path).is_ok();
    let later = |number: u32| path.with_file_name(format!("{name}.damaged-{number}"));
    let first = Some(path.with_file_name(format!("{name}.damaged"))).filter(exists)?;
    (2..=u32::MAX).map(later).take_while(exists).last().or(Some(first))
}

/// Removes a file; no error if it does not exist.
pub fn remove_file(path: &Path) -> Result<(), StoreError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(StoreError::io("remove", path, error)),
        _ => Ok(()),
    }
}

/// Removes a file, so that it does not come back after a power cut; no error if it does not exist.
pub fn remove_file_durably(path: &Path) -> Result<(), StoreError> {
    match fs::remove_file(path) {
        Ok(()) => path.parent().map_or(Ok(()), sync_directory),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(StoreError::io("remove", path, error)),
    }
}

/// Syncs a file that was written before.
pub fn sync_file(path: &Path) -> Result<(), StoreError> {
    File::open(path).and_then(|file| file.sync_all()).map_err(|source| StoreError::io("write", path, source))
}

/// Syncs the names in a directory.
pub fn sync_directory(path: &Path) -> Result<(), StoreError> {
    // On Unix a directory is synced like a file.
    sync_file(path)
}

/// Paths in a directory, sorted by name; none if it does not exist.
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

/// Removes a directory with its content; no error if it does not exist.
pub fn remove_directory(path: &Path) -> Result<(), StoreError> {
    match fs::remove_dir_all(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(StoreError::io("remove", path, error)),
        _ => Ok(()),
    }
}

/// Removes a directory with its content, so that a crash leaves it whole or under its hidden name, which [`remove_half_removed`] removes. No error if it
/// does not exist.
pub fn remove_directory_at_once(path: &Path) -> Result<(), StoreError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let hidden = path.with_file_name(format!(".{name}"));
    remove_directory(&hidden)?;
    match fs::rename(path, &hidden) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(source) => Err(StoreError::io("remove", path, source)),
        Ok(()) => remove_directory(&hidden),
    }
}

/// Removes the hidden directories in this one.
pub fn remove_half_removed(directory: &Path) -> Result<(), StoreError> {
    let is_hidden = |path: &&PathBuf| {
        path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b".")) && path.is_dir()
    };
    entries(directory)?.iter().filter(is_hidden).try_for_each(|path| remove_directory(path))
}

/// Free space on the disk that holds a directory, bytes.
///
/// # Errors
/// When the system does not say.
pub fn free_bytes(directory: &Path) -> Result<u64, StoreError> {
    let disk =
        rustix::fs::statvfs(directory).map_err(|error| StoreError::io("read", directory, error.into()))?;
    Ok(disk.f_bavail.saturating_mul(disk.f_frsize))
}

/// Size of the disk of a directory, bytes.
///
/// # Errors
/// When the system does not say.
pub fn disk_bytes(directory: &Path) -> Result<u64, StoreError> {
    let disk =
        rustix::fs::statvfs(directory).map_err(|error| StoreError::io("read", directory, error.into()))?;
    Ok(disk.f_blocks.saturating_mul(disk.f_frsize))
}

/// Whether a file was written before `now - age`. One whose time is unknown or in the future counts as new.
pub fn is_older_than(path: &Path, age: Duration, now: SystemTime) -> bool {
    let modified = fs::symlink_metadata(path).and_then(|about| about.modified());
    modified.is_ok_and(|modified| now.duration_since(modified).is_ok_and(|elapsed| elapsed > age))
}

/// Bytes of all files in a directory and those below it.
///
/// # Errors
/// When the disk fails.
pub fn bytes_below(directory: &Path) -> Result<u64, StoreError> {
    entries(directory)?.iter().try_fold(0, |sum, path| {
        let about = fs::symlink_metadata(path).map_err(|source| StoreError::io("read", path, source))?;
        Ok(sum + if about.is_dir() { bytes_below(path)? } else { about.len() })
    })
}
