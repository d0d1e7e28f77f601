//! The keyframe clouds of a map, one at a time, thinned and without moving objects. Memory: a few keyframes, and 22 bytes for each point kept.

use crate::cloud_files::{CloudFiles, copy_cloud_files};
use crate::dynamic_points::DynamicPointFilter;
use crate::map_cloud::{CloudSelection, KeyframePose, MapCloud};
use crate::{StoreError, files};
use map_codec::{LevelSplitter, SplitConfig};
use mapping::range_image::RangeImage;
use std::path::Path;

/// Reads a map's clouds in the order of its graph. Keyframes without a cloud, or with an invalid pose, are skipped.
#[derive(Debug)]
pub struct MapClouds {
    files: CloudFiles,
    keyframes: std::vec::IntoIter<KeyframePose>,
    /// None where every point is wanted.
    splitter: Option<LevelSplitter>,
    /// None where moving objects are wanted too.
    dynamic_filter: Option<DynamicPointFilter>,
}

/// The clouds of the map in the folder `dir`, as `autoinspect map --out` and a data directory's `maps/` have them.
///
/// # Errors
/// When `dir` holds no graph, or files in it cannot be understood.
pub fn map_clouds(dir: &Path, selection: CloudSelection) -> Result<MapClouds, StoreError> {
    let graph: api::Graph = files::read_json(&dir.join("graph.json"))?;
    let keyframes = graph.nodes.iter().map(|node| KeyframePose {
        id: node.id,
        stamp: node.stamp,
        map_from_keyframe: node.map_from_keyframe,
    });
    MapClouds::open(&dir.join("clouds"), keyframes.collect(), selection)
}

/// Every point of every keyframe of the map in the folder `dir`, each cloud with the position of its LiDAR in the keyframe's frame, metres.
/// Keyframes without a cloud are skipped.
///
/// # Errors
/// As for [`map_clouds`].
pub fn map_clouds_and_sensors(
    dir: &Path,
) -> Result<impl Iterator<Item = Result<(MapCloud, [f32; 3]), StoreError>>, StoreError> {
    let clouds = keyframes_and_clouds(dir)?;
    Ok(clouds.filter_map(|read| read.map(|(_, cloud)| cloud).transpose()))
}

/// A keyframe, with its cloud and the position of its LiDAR if it has a cloud.
type KeyframeAndCloud = (KeyframePose, Option<(MapCloud, [f32; 3])>);

/// Every keyframe of the map in the folder `dir` in the order of its graph, with every point of its cloud. A keyframe has no cloud if its file was damaged, or if
/// its session was interrupted before the cloud was written.
///
/// # Errors
/// As for [`map_clouds`].
pub(crate) fn keyframes_and_clouds(
    dir: &Path,
) -> Result<impl Iterator<Item = Result<KeyframeAndCloud, StoreError>>, StoreError> {
    let mut clouds = map_clouds(dir, CloudSelection::ALL)?;
    let keyframes: Vec<KeyframePose> = clouds.keyframes.by_ref().collect();
    Ok(keyframes.into_iter().map(move |keyframe| {
        let cloud = clouds.read(&keyframe)?;
        Ok((keyframe, cloud))
    }))
}

/// Copies the clouds of the map in the folder `dir` into another folder, where its keyframes count from `first` on.
///
/// # Errors
/// When the disk fails or `dir` holds no graph.
pub fn copy_clouds(dir: &Path, to: &Path, first: u32) -> Result<(), StoreError> {
    let graph: api::Graph = files::read_json(&dir.join("graph.json"))?;
    copy_cloud_files(&dir.join("clouds"), to, graph.nodes.iter().map(|node| node.id), first)
}

impl MapClouds {
    pub(crate) fn open(
        clouds: &Path,
        keyframes: Vec<KeyframePose>,
        selection: CloudSelection,
    ) -> Result<Self, StoreError> {
        // One level and one submap: a cell is taken once, wherever it is seen from.
        let splitter = (selection.spacing_m > 0.0).then(|| {
            LevelSplitter::new(SplitConfig {
                spacings_m: vec![selection.spacing_m],
                max_submap_keyframes: u32::MAX,
                max_submap_cells: usize::MAX,
            })
        });
        let dynamic_filter = (!selection.include_dynamic).then(DynamicPointFilter::default);
        Ok(Self {
            files: CloudFiles::open(clouds)?,
            keyframes: keyframes.into_iter(),
            splitter,
            dynamic_filter,
        })
    }

    /// A keyframe's cloud as it was written, and the position of its LiDAR; none when it has no cloud.
    fn read(&self, keyframe: &KeyframePose) -> Result<Option<(MapCloud, [f32; 3])>, StoreError> {
        let read = self.files.read(keyframe.id, keyframe.stamp)?;
        Ok(read.map(|seen| {
            let cloud = MapCloud {
                keyframe: keyframe.id,
                map_from_keyframe: keyframe.map_from_keyframe,
                xyz: seen.xyz,
                intensity: seen.intensity,
            };
            (cloud, seen.lidar)
        }))
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
            // The filter votes with everything that the keyframe saw, although the map needs little of it.
            let view = RangeImage::new(&cloud.xyz, lidar);
            let cloud = self.thin(cloud);
            self.dynamic_filter.as_mut()?.insert(cloud, view);
        }
        self.dynamic_filter.as_mut()?.pop().map(Ok)
    }
}
