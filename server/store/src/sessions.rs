//! Keyframe clouds of the running mapping session, on disk so that memory does not grow with the walk.
//!
//! They are `sessions/<session>/NNNNNN.pcd` in their keyframe's own frame, as in a saved map: saving moves the directory. `NNNNNN.scan` holds the same cloud
//! encoded for clients, a fifth of the size; it is removed when the map is saved. Sessions of a process that has ended are removed when the store is
//! opened.

use crate::cloud_files::{cloud_name, write_cloud};
use crate::map_cloud::{CloudSelection, MapCloud};
use crate::map_clouds::{copy_clouds, map_clouds};
use crate::{Store, StoreError, files};
use messages::Keyframe;
use std::path::{Path, PathBuf};
use vocab::{KeyframeId, MapId, SessionId};

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

/// Removes the clouds that are encoded for clients from a session's directory.
pub(crate) fn remove_encoded(session: &Path) -> Result<(), StoreError> {
    let encoded = |path: &&PathBuf| path.extension().is_some_and(|extension| extension == ENCODED_SUFFIX);
    files::entries(session)?.iter().filter(encoded).try_for_each(|path| files::remove_file(path))
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
        write_encoded(&directory, keyframe.id, &keyframe.cloud.xyz, &keyframe.cloud.intensity)
    }

    /// Copies the clouds of a saved map into a session that extends it.
    ///
    /// # Errors
    /// When the disk fails, or the map cannot be read.
    pub fn copy_map_clouds_to_session(&self, map: MapId, session: SessionId) -> Result<(), StoreError> {
        let (from, directory) = (self.dir().map(map), self.session(session));
        files::make_directory(&directory)?;
        copy_clouds(&from, &directory, 0)?;
        for cloud in map_clouds(&from, CloudSelection::ALL)? {
            let MapCloud { keyframe, xyz, intensity, .. } = cloud?;
            write_encoded(&directory, keyframe, &xyz, &intensity)?;
        }
        Ok(())
    }

    /// Removes the clouds of a session.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn discard_session(&self, session: SessionId) -> Result<(), StoreError> {
        files::remove_directory(&self.session(session))
    }

    pub(crate) fn session(&self, session: SessionId) -> PathBuf {
        self.dir().root().join("sessions").join(session.to_string())
    }

    pub(crate) fn remove_all_sessions(&self) -> Result<(), StoreError> {
        let sessions = files::entries(&self.dir().root().join("sessions"))?;
        sessions.iter().try_for_each(|session| files::remove_directory(session))
    }
}
