//! Keyframe clouds of the running mapping session, on disk so that memory does not grow with the walk.
//!
//! They are `sessions/<session>/NNNNNN.pcd` in their keyframe's own frame, as in a saved map: saving links them into the map. `NNNNNN.scan` holds the same
//! cloud encoded for clients, a fifth of the size. Beside them is the journal of the session. All stay until the map is on the disk, or a person discards
//! the session.

use crate::checksums::append_checksum;
use crate::cloud_files::{cloud_name, read_walked_cloud, write_cloud};
use crate::map_cloud::{CloudSelection, MapCloud};
use crate::map_clouds::{copy_clouds, map_clouds};
use crate::{Store, StoreError, files, viewpoint_clouds};
use messages::{Cloud, Keyframe};
use std::fs;
use std::path::{Path, PathBuf};
use vocab::{KeyframeId, MapId, SessionId, Stamp};

/// Ending of the names of clouds that are encoded for clients.
const ENCODED_SUFFIX: &str = "scan";

fn write_encoded(
    directory: &Path,
    keyframe: KeyframeId,
    xyz: &[[f32; 3]],
    intensity: &[f32],
) -> Result<(), StoreError> {
    let bytes = map_codec::encode_scan(xyz, intensity, map_codec::POINT_RESOLUTION_M);
    files::replace(&directory.join(cloud_name(keyframe)).with_extension(ENCODED_SUFFIX), &bytes)
}

/// Whether a file of a session holds clouds as saved maps have them.
pub(crate) fn is_cloud(path: &Path) -> bool {
    keyframe_of(path).is_some() || viewpoint_clouds::is_viewpoint_file(path)
}

/// The keyframe whose cloud a file holds, by its name.
pub(crate) fn keyframe_of(path: &Path) -> Option<KeyframeId> {
    let name = path.file_name()?.to_str()?;
    name.strip_suffix(".pcd")?.parse().ok().map(KeyframeId)
}

/// Makes the clouds of a session those of a map as well, without their bytes being written again where the file system can do that.
pub(crate) fn link_clouds(session: &Path, clouds: &Path) -> Result<(), StoreError> {
    files::make_directory(clouds)?;
    for path in files::entries(session)?.iter().filter(|path| is_cloud(path)) {
        let target = clouds.join(path.file_name().unwrap_or_default());
        let linked = fs::hard_link(path, &target).or_else(|_| fs::copy(path, &target).map(drop));
        linked.map_err(|source| StoreError::io("write", &target, source))?;
    }
    Ok(())
}

impl Store {
    /// Writes the cloud of a keyframe. It stays until its session is saved or discarded.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn write_session_cloud(&self, keyframe: &Keyframe) -> Result<(), StoreError> {
        let directory = self.session(keyframe.session);
        files::make_directory(&directory)?;
        write_cloud(&directory, keyframe)?;
        append_checksum(&directory, &cloud_name(keyframe.id))?;
        write_encoded(&directory, keyframe.id, &keyframe.cloud.xyz, &keyframe.cloud.intensity)
    }

    /// The cloud of a keyframe as [`Self::write_session_cloud`] wrote it; none when there is no file of it.
    ///
    /// # Errors
    /// When the disk fails or the file is broken.
    pub fn session_cloud(
        &self,
        session: SessionId,
        keyframe: KeyframeId,
        stamp: Stamp,
    ) -> Result<Option<Cloud>, StoreError> {
        let cloud = read_walked_cloud(&self.session(session), keyframe, stamp)?;
        Ok(cloud.map(|cloud| Cloud { xyz: cloud.xyz, intensity: cloud.intensity }))
    }

    /// Copies the clouds of a saved map into a session that extends it.
    ///
    /// # Errors
    /// When the disk fails, or the map cannot be read.
    pub fn copy_map_clouds_to_session(&self, map: MapId, session: SessionId) -> Result<(), StoreError> {
        let (from, directory) = (self.dir().map(map), self.session(session));
        files::make_directory(&directory)?;
        copy_clouds(&from, &directory, 0)?;
        for path in files::entries(&directory)?.iter().filter(|path| is_cloud(path)) {
            append_checksum(&directory, &path.file_name().unwrap_or_default().to_string_lossy())?;
        }
        for cloud in map_clouds(&from, CloudSelection::ALL)? {
            let MapCloud { keyframe, xyz, intensity, .. } = cloud?;
            write_encoded(&directory, keyframe, &xyz, &intensity)?;
        }
        Ok(())
    }

    /// Removes the files of a session.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn discard_session(&self, session: SessionId) -> Result<(), StoreError> {
        files::remove_directory_at_once(&self.session(session))
    }

    /// Removes what a crash has left of sessions that were being removed.
    pub(crate) fn remove_half_removed_sessions(&self) -> Result<(), StoreError> {
        files::remove_half_removed(&self.dir().sessions())
    }

    pub(crate) fn session(&self, session: SessionId) -> PathBuf {
        self.dir().sessions().join(session.to_string())
    }
}
