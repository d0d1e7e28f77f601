//! The keyframe clouds of a map, one at a time, thinned and without people: memory holds a few keyframes, and 22 bytes for
//! each point kept.

use crate::dynamic_points::DynamicPointFilter;
use crate::sessions::cloud_name;
use crate::{StoreError, files};
use map_codec::{LevelSplitter, SplitOptions};
use mapping::range_image::RangeImage;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use vocab::{KeyframeId, Pose, Stamp};

/// A keyframe of a map and where it is now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KeyframePose {
    pub(crate) id: KeyframeId,
    pub(crate) stamp: Stamp,
    pub(crate) map_from_keyframe: Pose,
}

/// What one keyframe adds to a map.
#[derive(Clone, Debug, PartialEq)]
pub struct MapCloud {
    /// Which keyframe.
    pub keyframe: KeyframeId,
    /// Where it is.
    pub map_from_keyframe: Pose,
    /// Metres, keyframe's frame.
    pub xyz: Vec<[f32; 3]>,
    /// Sensor units, one for each point.
    pub intensity: Vec<f32>,
}

impl MapCloud {
    /// Drops the points with these numbers, which ascend.
    pub fn drop_points(&mut self, numbers: &[u32]) {
        let keep = |len: usize| {
            let mut dropped = numbers.iter().peekable();
            (0..len as u32).map(move |number| dropped.next_if_eq(&&number).is_none())
        };
        let mut kept = keep(self.xyz.len());
        self.xyz.retain(|_| kept.next().unwrap_or(true));
        let mut kept = keep(self.intensity.len());
        self.intensity.retain(|_| kept.next().unwrap_or(true));
    }
}

/// What of a map's clouds is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudSelection {
    /// One point in each cell of this size, the one that was seen first, metres; every point where it is 0.
    pub spacing: f32,
    /// Also points of people and whatever else the keyframes around looked through.
    pub moving: bool,
}

/// Reads a map's clouds in the order of its graph. A keyframe without a file, or whose pose is none, is passed over.
#[derive(Debug)]
pub struct MapClouds {
    clouds: PathBuf,
    keyframes: std::vec::IntoIter<KeyframePose>,
    /// None where every point is wanted.
    splitter: Option<LevelSplitter>,
    /// None where also what moves is wanted.
    dynamic_filter: Option<DynamicPointFilter>,
}

/// The clouds of the map in the folder `dir`, as `autoinspect map --out` and a data directory's `maps/` have them.
///
/// # Errors
/// When `dir` holds no graph or one that cannot be understood.
pub fn map_clouds(dir: &Path, wanted: CloudSelection) -> Result<MapClouds, StoreError> {
    let graph: api::Graph = files::read_json(&dir.join("graph.json"))?;
    let keyframes = graph.nodes.iter().map(|node| KeyframePose {
        id: node.id,
        stamp: node.stamp,
        map_from_keyframe: node.map_from_keyframe,
    });
    Ok(MapClouds::new(dir.join("clouds"), keyframes.collect(), wanted))
}

/// As [`map_clouds`], each with the position of the LiDAR that saw it, keyframe's frame, metres. Nothing but the graph's keyframes
/// with files is left out or thinned.
///
/// # Errors
/// As for [`map_clouds`].
pub fn map_clouds_and_sensors(
    dir: &Path,
) -> Result<impl Iterator<Item = Result<(MapCloud, [f32; 3]), StoreError>>, StoreError> {
    let mut clouds = map_clouds(dir, CloudSelection { spacing: 0.0, moving: true })?;
    let keyframes: Vec<KeyframePose> = clouds.keyframes.by_ref().collect();
    Ok(keyframes.into_iter().filter_map(move |keyframe| clouds.read(&keyframe).transpose()))
}

/// Copies the clouds of the map in the folder `dir` into another folder, counting its keyframes from `first` on.
///
/// # Errors
/// When the disk does, or `dir` holds no graph.
pub fn copy_clouds(dir: &Path, to: &Path, first: u32) -> Result<(), StoreError> {
    let graph: api::Graph = files::read_json(&dir.join("graph.json"))?;
    for node in &graph.nodes {
        let from = dir.join("clouds").join(cloud_name(node.id));
        let to = to.join(cloud_name(KeyframeId(node.id.0 + first)));
        fs::copy(&from, &to).map_err(|source| StoreError::io("write", &to, source))?;
    }
    Ok(())
}

impl MapClouds {
    pub(crate) fn new(clouds: PathBuf, keyframes: Vec<KeyframePose>, wanted: CloudSelection) -> Self {
        // One level and one submap: a cell is taken once, wherever it is seen from.
        let splitter = (wanted.spacing > 0.0).then(|| {
            LevelSplitter::new(SplitOptions {
                spacings: vec![wanted.spacing],
                submap_keyframes_max: u32::MAX,
                submap_cells_max: usize::MAX,
            })
        });
        let dynamic_filter = (!wanted.moving).then(DynamicPointFilter::default);
        Self { clouds, keyframes: keyframes.into_iter(), splitter, dynamic_filter }
    }

    /// A keyframe's cloud as its file has it, and where its LiDAR was; none when there is no file.
    fn read(&self, keyframe: &KeyframePose) -> Result<Option<(MapCloud, [f32; 3])>, StoreError> {
        let path = self.clouds.join(cloud_name(keyframe.id));
        let bytes = match fs::read(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            other => other.map_err(|source| StoreError::io("read", &path, source))?,
        };
        let (scan, _) = formats::pcd::read(&bytes)
            .and_then(|table| table.to_scan(Some(keyframe.stamp)))
            .map_err(|source| StoreError::Cloud { path, source })?;
        let mut intensity = scan.intensity;
        intensity.resize(scan.xyz.len(), 0.0);
        let cloud = MapCloud {
            keyframe: keyframe.id,
            map_from_keyframe: keyframe.map_from_keyframe,
            xyz: scan.xyz,
            intensity,
        };
        Ok(Some((cloud, formats::pcd::viewpoint(&bytes).unwrap_or_default())))
    }

    fn thin(&mut self, cloud: MapCloud) -> MapCloud {
        let Some(splitter) = &mut self.splitter else {
            return cloud;
        };
        let new = splitter.push(&cloud.map_from_keyframe, &cloud.xyz, &cloud.intensity).pop();
        let new = new.unwrap_or_default();
        MapCloud { xyz: new.xyz, intensity: new.intensity, ..cloud }
    }
}

impl Iterator for MapClouds {
    type Item = Result<MapCloud, StoreError>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.dynamic_filter.as_ref().is_some_and(DynamicPointFilter::is_ready) {
            let Some(keyframe) = self.keyframes.next() else {
                break;
            };
            let (cloud, lidar) = match self.read(&keyframe) {
                Ok(None) => continue,
                Ok(Some(read)) => read,
                Err(error) => return Some(Err(error)),
            };
            if self.dynamic_filter.is_none() {
                return Some(Ok(self.thin(cloud)));
            }
            // A witness with all it saw, although the map needs little of it.
            let view = RangeImage::new(&cloud.xyz, lidar);
            let cloud = self.thin(cloud);
            self.dynamic_filter.as_mut()?.insert(cloud, view);
        }
        self.dynamic_filter.as_mut()?.pop().map(Ok)
    }
}
