//! Files that actions have gathered, such as pictures and spectra: immutable, named by the BLAKE3 of their bytes. Nothing removes them: they are what a site was
//! inspected for. So a new one is refused where the disk is nearly full.

use crate::checksums::hash_file;
use crate::{Store, StoreError, StoredDataReport, files, texts};
use std::fs;
use std::ops::ControlFlow;
use std::path::PathBuf;
use vocab::BlobHash;

/// Limits of stored files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlobsConfig {
    /// Largest file, bytes. A cloud of 60 s of a large scanner has some 600 MB and is thinned before. Chosen: above the 48 MB of the largest thinned cloud.
    pub max_bytes: u64,
    /// Free space that they leave for everything else, bytes. Half of what recordings leave, so that recordings stop first. Chosen: half a gigabyte, enough for the
    /// ledger and a map.
    pub min_free_bytes: u64,
}

impl Default for BlobsConfig {
    fn default() -> Self {
        Self { max_bytes: 64 << 20, min_free_bytes: 512 << 20 }
    }
}

/// Why a file was not stored.
#[derive(Debug, thiserror::Error)]
pub enum BlobError {
    /// It is too long.
    #[error("{}", texts::blob_too_long(*bytes, *max_bytes))]
    TooLong {
        /// Its length.
        bytes: u64,
        /// The limit.
        max_bytes: u64,
    },
    /// The disk is nearly full.
    #[error("{}", texts::DISK_NEARLY_FULL)]
    DiskFull,
    /// The disk fails.
    #[error(transparent)]
    Store(#[from] StoreError),
}

impl Store {
    /// Stores a file. When this returns, it survives a power cut; it is whole or absent at any time. Bytes that are there already are not written again.
    ///
    /// # Errors
    /// When it is too long, the disk is nearly full, or the disk fails.
    pub fn put_blob(&self, bytes: &[u8], config: &BlobsConfig) -> Result<BlobHash, BlobError> {
        let length = bytes.len() as u64;
        if length > config.max_bytes {
            return Err(BlobError::TooLong { bytes: length, max_bytes: config.max_bytes });
        }
        let hash = BlobHash(*blake3::hash(bytes).as_bytes());
        let path = self.dir().blob(hash);
        // One that is damaged is written again.
        if fs::read(&path).is_ok_and(|existing| existing == bytes) {
            return Ok(hash);
        }
        if files::free_bytes(self.dir().root())? < config.min_free_bytes.saturating_add(length) {
            return Err(BlobError::DiskFull);
        }
        if let Some(directory) = path.parent() {
            files::make_directory(directory)?;
            if path.is_dir() {
                files::put_aside(&path)?;
            }
            files::replace_durably(&path, bytes)?;
            files::sync_directory(&self.dir().blobs())?;
        }
        Ok(hash)
    }

    /// Stores points (metres) as a PCD file, as [`Self::put_blob`]. `viewpoint`: position of the sensor. Returns its length too.
    ///
    /// # Errors
    /// When it is too long, the disk is nearly full, or the disk fails.
    pub fn put_cloud_blob(
        &self,
        viewpoint: [f32; 3],
        xyz: &[[f32; 3]],
        intensity: &[f32],
        config: &BlobsConfig,
    ) -> Result<(BlobHash, u64), BlobError> {
        let mut bytes = Vec::new();
        formats::pcd::write(&mut bytes, viewpoint, xyz, intensity)
            .map_err(|source| StoreError::io("write", &self.dir().blobs(), source))?;
        Ok((self.put_blob(&bytes, config)?, bytes.len() as u64))
    }

    /// Removes what was being written when the last process was killed.
    pub(crate) fn remove_half_written_blobs(&self) -> Result<(), StoreError> {
        for directory in self.blob_directories()? {
            let entries = files::entries(&directory)?;
            entries
                .iter()
                .filter(|path| files::is_temporary(path))
                .try_for_each(|path| files::remove_file(path))?;
        }
        Ok(())
    }

    /// Compares every stored file with its name.
    pub(crate) fn check_blobs(
        &self,
        report: &mut dyn StoredDataReport,
    ) -> Result<ControlFlow<()>, StoreError> {
        for directory in self.blob_directories()? {
            for path in files::entries(&directory)? {
                let Some(name) = path.file_name().and_then(|name| name.to_str()) else { continue };
                if files::is_temporary(&path) || name.contains(".damaged") {
                    continue;
                }
                let read = match (name.parse::<BlobHash>(), hash_file(&path)) {
                    (Ok(named), Ok((hash, bytes))) => {
                        if *hash.as_bytes() != named.0 {
                            report.on_damage(StoreError::Checksum { path });
                        }
                        bytes
                    }
                    (Err(_), _) => {
                        report.on_damage(StoreError::Broken { path, what: texts::NO_BLOB_NAME });
                        0
                    }
                    (Ok(_), Err(error)) => {
                        report.on_damage(error);
                        0
                    }
                };
                if report.on_read(read).is_break() {
                    return Ok(ControlFlow::Break(()));
                }
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    fn blob_directories(&self) -> Result<Vec<PathBuf>, StoreError> {
        Ok(files::entries(&self.dir().blobs())?.into_iter().filter(|path| path.is_dir()).collect())
    }
}

#[cfg(test)]
#[path = "blobs_tests.rs"]
mod tests;
