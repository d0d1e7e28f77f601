//! Files of keyframe clouds in a folder: of a saved map (`clouds/`) or of a running session.
//!
//! ```text
//! NNNNNN.pcd             cloud of one keyframe in its own frame; the LiDAR's position is the PCD's viewpoint
//! viewpoints_NNNNNN.bin  clouds of virtual viewpoints, see viewpoint_clouds.rs
//! ```
//!
//! A PCD file takes precedence over a viewpoint of the same keyframe, so that a new version of an imported map can replace single clouds.

use crate::viewpoint_clouds::{self, ViewpointClouds, VisibleCloud};
use crate::{StoreError, files};
use messages::Keyframe;
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use vocab::{KeyframeId, Stamp};

/// Name of a keyframe's cloud within its folder.
pub(crate) fn cloud_name(keyframe: KeyframeId) -> String {
    format!("{:06}.pcd", keyframe.0)
}

/// Writes a keyframe's cloud (keyframe frame, metres) into `directory`, as saved maps have it. The LiDAR's position becomes the
/// viewpoint of the PCD file. The file is whole or absent; one that was there before stays as it was where it is linked elsewhere.
///
/// # Errors
/// When the disk fails.
pub fn write_cloud(directory: &Path, keyframe: &Keyframe) -> Result<(), StoreError> {
    let path = directory.join(cloud_name(keyframe.id));
    let temporary = files::temporary_path(&path);
    let cloud = &keyframe.cloud;
    let write = || {
        let mut file = BufWriter::new(File::create(&temporary)?);
        formats::pcd::write(&mut file, keyframe.lidar, &cloud.xyz, &cloud.intensity)?;
        file.into_inner().map_err(io::IntoInnerError::into_error)?.sync_data()?;
        fs::rename(&temporary, &path)
    };
    write().map_err(|source| StoreError::io("write", &path, source))
}

/// Keyframe clouds in a folder, to be read one at a time. Memory: files of viewpoints are held whole, some 20 bytes for each of their points.
#[derive(Debug)]
pub(crate) struct CloudFiles {
    directory: PathBuf,
    viewpoints: Vec<ViewpointClouds>,
}

impl CloudFiles {
    /// Opens a folder; it need not exist.
    ///
    /// # Errors
    /// When the disk fails or a file of viewpoints is broken.
    pub(crate) fn open(directory: impl Into<PathBuf>) -> Result<Self, StoreError> {
        let directory = directory.into();
        let viewpoints = viewpoint_clouds::list(&directory)?;
        let viewpoints = viewpoints.iter().map(|(first, path)| ViewpointClouds::read(path, *first));
        Ok(Self { viewpoints: viewpoints.collect::<Result<_, _>>()?, directory })
    }

    /// The cloud of a keyframe, as it was written; none when there is no file of it.
    ///
    /// # Errors
    /// When the disk fails or the file is broken.
    pub(crate) fn read(
        &self,
        keyframe: KeyframeId,
        stamp: Stamp,
    ) -> Result<Option<VisibleCloud>, StoreError> {
        match read_walked_cloud(&self.directory, keyframe, stamp)? {
            Some(cloud) => Ok(Some(cloud)),
            None => self.read_viewpoint(keyframe),
        }
    }

    /// Whether there is a cloud of this keyframe. It may be damaged.
    pub(crate) fn contains(&self, keyframe: KeyframeId) -> bool {
        self.directory.join(cloud_name(keyframe)).exists()
            || self.viewpoints.iter().any(|file| file.contains(keyframe))
    }

    fn read_viewpoint(&self, keyframe: KeyframeId) -> Result<Option<VisibleCloud>, StoreError> {
        let holder = self.viewpoints.iter().find(|file| file.contains(keyframe));
        holder.map_or(Ok(None), |file| file.cloud_of(keyframe))
    }
}

/// The cloud of a keyframe that a robot has walked to; none when there is no file of it.
///
/// # Errors
/// When the disk fails or the file is broken.
pub(crate) fn read_walked_cloud(
    directory: &Path,
    keyframe: KeyframeId,
    stamp: Stamp,
) -> Result<Option<VisibleCloud>, StoreError> {
    let path = directory.join(cloud_name(keyframe));
    let bytes = match fs::read(&path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        other => other.map_err(|source| StoreError::io("read", &path, source))?,
    };
    let (scan, _) = formats::pcd::read(&bytes)
        .and_then(|table| table.to_scan(Some(stamp)))
        .map_err(|source| StoreError::Cloud { path, source })?;
    let mut intensity = scan.intensity;
    intensity.resize(scan.xyz.len(), 0.0);
    let lidar = formats::pcd::viewpoint(&bytes).unwrap_or_default();
    Ok(Some(VisibleCloud { xyz: scan.xyz, intensity, lidar }))
}

/// Copies clouds into another folder whose keyframes count from `first` on. Files that are there already are kept. Keyframes without a cloud have none there
/// either.
///
/// # Errors
/// When the disk fails.
pub(crate) fn copy_cloud_files(
    from: &Path,
    to: &Path,
    keyframes: impl IntoIterator<Item = KeyframeId>,
    first: u32,
) -> Result<(), StoreError> {
    copy_viewpoint_files(from, to, first)?;
    for keyframe in keyframes {
        let source = from.join(cloud_name(keyframe));
        let target = to.join(cloud_name(KeyframeId(keyframe.0 + first)));
        if target.exists() {
            continue;
        }
        match fs::copy(&source, &target) {
            // The cloud is that of a virtual viewpoint, or the keyframe has none.
            Err(error) if error.kind() == io::ErrorKind::NotFound && !source.exists() => {}
            copied => drop(copied.map_err(|error| StoreError::io("write", &target, error))?),
        }
    }
    Ok(())
}

/// Which keyframes are virtual viewpoints whose clouds lie in a shared file.
#[derive(Debug, Default)]
pub struct VirtualKeyframes {
    ranges: Vec<std::ops::Range<u32>>,
}

impl VirtualKeyframes {
    /// Whether this keyframe is one.
    pub fn contains(&self, keyframe: KeyframeId) -> bool {
        self.ranges.iter().any(|range| range.contains(&keyframe.0))
    }
}

/// Copies the clouds of virtual viewpoints between folders of clouds, their keyframes counted from `first` on; says which keyframes of `from` they are.
///
/// # Errors
/// When the disk fails or a file is broken.
pub fn copy_viewpoint_files(from: &Path, to: &Path, first: u32) -> Result<VirtualKeyframes, StoreError> {
    let mut copied = VirtualKeyframes::default();
    for (keyframe, path) in viewpoint_clouds::list(from)? {
        let count = ViewpointClouds::read(&path, keyframe)?.len();
        copied.ranges.push(keyframe.0..keyframe.0.saturating_add(count));
        let target = to.join(viewpoint_clouds::file_name(KeyframeId(keyframe.0 + first)));
        if !target.exists() {
            fs::copy(&path, &target).map_err(|error| StoreError::io("write", &target, error))?;
            files::sync_file(&target)?;
        }
    }
    Ok(copied)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CloudViewpoint, MapPoints, write_viewpoint_clouds};
    use geometry::Isometry;
    use messages::Cloud;
    use std::sync::Arc;
    use uuid::Uuid;
    use vocab::{Pose, SessionId};

    fn keyframe(number: u32, x: f32) -> Keyframe {
        Keyframe {
            session: SessionId(Uuid::nil()),
            id: KeyframeId(number),
            stamp: Stamp::EPOCH,
            map_from_keyframe: Pose::IDENTITY,
            cloud: Arc::new(Cloud { xyz: vec![[x, 1.0, 2.0]], intensity: vec![5.0] }),
            lidar: [0.0, 0.0, 0.3],
        }
    }

    /// Keyframes 0 to 2 see the points 0 to 2 of a row, one each.
    fn write_row(directory: &Path) {
        let cloud =
            MapPoints { xyz: (1..4).map(|x| [x as f32, 0.0, 0.0]).collect(), intensity: vec![1.0; 3] };
        let visible = [vec![0], vec![1], vec![2]];
        let viewpoints = visible.into_iter().map(|visible| CloudViewpoint {
            cloud_from_base: Isometry::identity(),
            lidar: [0.0; 3],
            visible,
        });
        write_viewpoint_clouds(directory, KeyframeId(0), &cloud, viewpoints).expect("written");
    }

    /// First coordinate of the only point that a keyframe sees.
    fn x(directory: &Path, number: u32) -> Option<f32> {
        let files = CloudFiles::open(directory).expect("opened");
        let cloud = files.read(KeyframeId(number), Stamp::EPOCH).expect("read")?;
        Some(cloud.xyz[0][0])
    }

    #[test]
    fn a_file_of_its_own_takes_precedence_over_a_viewpoint() {
        let folder = tempfile::tempdir().expect("temporary directory");
        write_row(folder.path());
        write_cloud(folder.path(), &keyframe(1, 9.0)).expect("written");
        let seen: Vec<Option<f32>> = (0..4).map(|number| x(folder.path(), number)).collect();
        assert_eq!(seen, [Some(1.0), Some(9.0), Some(3.0), None]);
    }

    #[test]
    fn copied_clouds_count_from_another_number_on() {
        let [from, to] = [(); 2].map(|()| tempfile::tempdir().expect("temporary directory"));
        write_row(from.path());
        write_cloud(from.path(), &keyframe(1, 9.0)).expect("written");
        write_cloud(from.path(), &keyframe(3, 8.0)).expect("written");
        let all = || (0..4).map(KeyframeId);
        copy_cloud_files(from.path(), to.path(), all(), 10).expect("copied");
        let seen: Vec<Option<f32>> = (10..14).map(|number| x(to.path(), number)).collect();
        assert_eq!(seen, [Some(1.0), Some(9.0), Some(3.0), Some(8.0)]);
        assert_eq!(x(to.path(), 0), None);
        // It is no error to copy a cloud again, or a keyframe without a cloud.
        copy_cloud_files(from.path(), to.path(), all(), 10).expect("copied");
        copy_cloud_files(from.path(), to.path(), [KeyframeId(4)], 0).expect("a keyframe without a cloud");
    }
}
