//! Checksums of the files in a folder: `checksums.b3`, as the program `b3sum` writes and checks them (`b3sum -c checksums.b3`).
//!
//! A line for each file: its BLAKE3 in hexadecimal, two blanks, and its path in the folder. Where a file has two lines, the last one counts. A file without a
//! line of its own after damage to `checksums.b3` is found by that.

use crate::{StoreError, files, texts};
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

/// Name of the file with the checksums of its folder.
const NAME: &str = "checksums.b3";

/// Bytes that are read at once.
const BUFFER_BYTES: usize = 1 << 16;

/// The checksums of a folder's files.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Checksums {
    sums: BTreeMap<String, blake3::Hash>,
}

impl Checksums {
    /// Path of the file in a folder.
    pub fn path(folder: &Path) -> PathBuf {
        folder.join(NAME)
    }

    /// Reads them; none if the folder has none. A last line that was not written whole is left out.
    ///
    /// # Errors
    /// When the disk fails, or a line cannot be understood.
    pub fn read(folder: &Path) -> Result<Option<Self>, StoreError> {
        let path = Self::path(folder);
        let bytes = match fs::read(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            other => other.map_err(|source| StoreError::io("read", &path, source))?,
        };
        let broken = || StoreError::Broken { path: path.clone(), what: texts::BROKEN_CHECKSUMS };
        let text = String::from_utf8(bytes).map_err(|_| broken())?;
        let (whole, torn) = text.rsplit_once('\n').unwrap_or(("", &text));
        // The end of a line may be what is damaged.
        if whole.lines().map(str::len).max().is_some_and(|longest| torn.len() > longest) {
            return Err(broken());
        }
        let sums = whole.lines().map(|line| {
            let (text, name) = line.split_once("  ")?;
            let hash: blake3::Hash = text.parse().ok()?;
            // Capital digits mean the same, and are damage.
            (hash.to_hex().as_str() == text).then(|| (name.to_owned(), hash))
        });
        Ok(Some(Self { sums: sums.collect::<Option<_>>().ok_or_else(broken)? }))
    }

    /// The checksum of a file by its path in the folder.
    fn of(&self, name: &str) -> Option<&blake3::Hash> {
        self.sums.get(name)
    }

    /// Whether a file has a checksum.
    pub fn has(&self, name: &str) -> bool {
        self.of(name).is_some()
    }

    /// The names of all files with a checksum.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.sums.keys().map(String::as_str)
    }

    /// Checks a file against its checksum, if it has one. Returns its length in bytes.
    ///
    /// # Errors
    /// When it cannot be read or does not match.
    pub fn check(&self, folder: &Path, name: &str) -> Result<u64, StoreError> {
        let path = folder.join(name);
        let checksums = Self::path(folder);
        if self.has(name) && !path.exists() {
            return Err(StoreError::ListedFileMissing { path, checksums });
        }
        let (hash, bytes) = hash_file(&path)?;
        match self.of(name) {
            Some(expected) if *expected != hash => Err(StoreError::ListedChecksum { path, checksums }),
            _ => Ok(bytes),
        }
    }
}

/// Writes and syncs the checksums of these files of a folder. Replaces those of before.
pub(crate) fn write_checksums(folder: &Path, names: &[String]) -> Result<(), StoreError> {
    let mut text = String::new();
    for name in names {
        text.push_str(&line(folder, name)?);
    }
    files::replace_durably(&Checksums::path(folder), text.as_bytes())
}

/// Adds the checksum of a file that was written into a folder. It is not synced.
pub(crate) fn append_checksum(folder: &Path, name: &str) -> Result<(), StoreError> {
    let path = Checksums::path(folder);
    let line = line(folder, name)?;
    let file = OpenOptions::new().create(true).append(true).open(&path);
    file.and_then(|mut file| file.write_all(line.as_bytes()))
        .map_err(|source| StoreError::io("write", &path, source))
}

fn line(folder: &Path, name: &str) -> Result<String, StoreError> {
    let (hash, _) = hash_file(&folder.join(name))?;
    Ok(format!("{hash}  {name}\n"))
}

/// BLAKE3 of a file, and its length in bytes. Memory: a buffer of 64 kB.
pub(crate) fn hash_file(path: &Path) -> Result<(blake3::Hash, u64), StoreError> {
    let hash = || -> io::Result<_> {
        let mut file = File::open(path)?;
        let mut hasher = blake3::Hasher::new();
        let mut buffer = vec![0; BUFFER_BYTES];
        loop {
            match file.read(&mut buffer) {
                Ok(0) => return Ok((hasher.finalize(), hasher.count())),
                Ok(read) => drop(hasher.update(&buffer[..read])),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    };
    hash().map_err(|source| StoreError::io("read", path, source))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_is_that_of_b3sum() {
        let dir = tempfile::tempdir().expect("temporary directory");
        fs::write(dir.path().join("a.json"), "[]").expect("written");
        write_checksums(dir.path(), &["a.json".to_owned()]).expect("written");
        let text = fs::read_to_string(dir.path().join("checksums.b3")).expect("read");
        assert_eq!(text, format!("{}  a.json\n", blake3::hash(b"[]")));
    }

    #[test]
    fn a_changed_file_is_found_and_a_torn_line_is_left_out() {
        let dir = tempfile::tempdir().expect("temporary directory");
        for name in ["1.pcd", "2.pcd"] {
            fs::write(dir.path().join(name), name).expect("written");
            append_checksum(dir.path(), name).expect("added");
        }
        let read = || Checksums::read(dir.path());
        let sums = read().expect("read").expect("there");
        assert_eq!(sums.check(dir.path(), "2.pcd").expect("whole"), 5);
        fs::write(dir.path().join("2.pcd"), "3.pcd").expect("written");
        let error = sums.check(dir.path(), "2.pcd").expect_err("changed").to_string();
        assert!(error.contains("2.pcd"), "{error}");

        let path = dir.path().join("checksums.b3");
        let whole = fs::read(&path).expect("read");
        fs::write(&path, &whole[..whole.len() - 1]).expect("written");
        assert_eq!(read().expect("read").expect("there").names().collect::<Vec<_>>(), ["1.pcd"]);
        fs::write(&path, vec![0; whole.len()]).expect("written");
        assert_eq!(read().expect("read").expect("there"), Checksums::default());
        fs::write(&path, [b"x", whole.as_slice()].concat()).expect("written");
        assert!(read().expect_err("broken").to_string().contains("checksums.b3"));
    }
}
