//! Keyframe clouds of the running mapping session, on disk so that memory does not grow with the walk.
//!
//! They lie as `sessions/<session>/NNNNNN.pcd` in their keyframe's own frame, which is how a saved map keeps them too:
//! saving moves the directory. They are worthless once the process that ran the session is gone.

use crate::{Store, StoreError, files};
use messages::Keyframe;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use vocab::{KeyframeId, SessionId};

/// Name of a keyframe's cloud within its directory.
pub(crate) fn cloud_name(keyframe: KeyframeId) -> String {
    format!("{:06}.pcd", keyframe.0)
}

/// Writes a keyframe's cloud (keyframe frame, metres) into `directory`, as saved maps have it, with the LiDAR's place as its
/// viewpoint.
///
/// # Errors
/// When the disk does.
pub fn write_cloud(directory: &Path, keyframe: &Keyframe) -> Result<(), StoreError> {
    let path = directory.join(cloud_name(keyframe.id));
    let cloud = &keyframe.cloud;
    let write = || {
        let mut file = BufWriter::new(File::create(&path)?);
        formats::pcd::write(&mut file, keyframe.lidar, &cloud.xyz, &cloud.intensity)?;
        file.flush()
    };
    write().map_err(|source| StoreError::io("write", &path, source))
}

impl Store {
    /// Keeps the cloud of a keyframe until its session is saved or discarded.
    ///
    /// # Errors
    /// When the disk does.
    pub fn keep_cloud(&self, keyframe: &Keyframe) -> Result<(), StoreError> {
        let directory = self.session(keyframe.session);
        files::make_directory(&directory)?;
        write_cloud(&directory, keyframe)
    }

    /// Removes the clouds of a session.
    ///
    /// # Errors
    /// When the disk does.
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
