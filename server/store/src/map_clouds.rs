//! The keyframe clouds of a map, one at a time, thinned and without people: memory holds a few keyframes, and 22 bytes for
//! each point kept.

use crate::people::Passage;
use crate::sessions::cloud_name;
use crate::{StoreError, files};
use map_codec::{LevelSplitter, SplitOptions};
use mapping::view::RangeImage;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use vocab::{KeyframeId, Pose, Stamp};

/// A keyframe of a map and where it is now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
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
pub struct Wanted {
    /// One point in each cell of this size, the one that was seen first, metres; every point where it is 0.
    pub spacing: f32,
    /// Also points of people and whatever else the keyframes around looked through.
    pub moving: bool,
}

/// Reads a map's clouds in the order of its graph. A keyframe without a file, or whose pose is none, is passed over.
#[derive(Debug)]
pub struct MapClouds {
    clouds: PathBuf,
    places: std::vec::IntoIter<Place>,
    /// None where every point is wanted.
    splitter: Option<LevelSplitter>,
    /// None where also what moves is wanted.
    passage: Option<Passage>,
}

/// The clouds of the map in the folder `dir`, as `autoinspect map --out` and a data directory's `maps/` have them.
///
/// # Errors
/// When `dir` holds no graph or one that cannot be understood.
pub fn map_clouds(dir: &Path, wanted: Wanted) -> Result<MapClouds, StoreError> {
    let graph: api::Graph = files::read_json(&dir.join("graph.json"))?;
    let places = graph.nodes.iter().map(|node| Place {
        id: node.id,
        stamp: node.stamp,
        map_from_keyframe: node.map_from_keyframe,
    });
    Ok(MapClouds::new(dir.join("clouds"), places.collect(), wanted))
}

/// As [`map_clouds`], each with the place of the LiDAR that saw it, keyframe's frame, metres. Nothing but the graph's keyframes
/// with files is left out or thinned.
///
/// # Errors
/// As for [`map_clouds`].
pub fn map_clouds_and_sensors(
    dir: &Path,
) -> Result<impl Iterator<Item = Result<(MapCloud, [f32; 3]), StoreError>>, StoreError> {
    let mut clouds = map_clouds(dir, Wanted { spacing: 0.0, moving: true })?;
    let places: Vec<Place> = clouds.places.by_ref().collect();
    Ok(places.into_iter().filter_map(move |place| clouds.read(&place).transpose()))
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
    pub(crate) fn new(clouds: PathBuf, places: Vec<Place>, wanted: Wanted) -> Self {
        // One level and one submap: a cell is taken once, wherever it is seen from.
        let splitter = (wanted.spacing > 0.0).then(|| {
            LevelSplitter::new(SplitOptions {
                spacings: vec![wanted.spacing],
                submap_keyframes_max: u32::MAX,
                submap_cells_max: usize::MAX,
            })
        });
        let passage = (!wanted.moving).then(Passage::default);
        Self { clouds, places: places.into_iter(), splitter, passage }
    }

    /// A keyframe's cloud as its file has it, and where its LiDAR was; none when there is no file.
    fn read(&self, place: &Place) -> Result<Option<(MapCloud, [f32; 3])>, StoreError> {
        let path = self.clouds.join(cloud_name(place.id));
        let bytes = match fs::read(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            other => other.map_err(|source| StoreError::io("read", &path, source))?,
        };
        let (scan, _) = formats::pcd::read(&bytes)
            .and_then(|table| table.to_scan(Some(place.stamp)))
            .map_err(|source| StoreError::Cloud { path, source })?;
        let mut intensity = scan.intensity;
        intensity.resize(scan.xyz.len(), 0.0);
        let cloud = MapCloud {
            keyframe: place.id,
            map_from_keyframe: place.map_from_keyframe,
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
        while !self.passage.as_ref().is_some_and(Passage::is_ready) {
            let Some(place) = self.places.next() else {
                break;
            };
            let (cloud, lidar) = match self.read(&place) {
                Ok(None) => continue,
                Ok(Some(read)) => read,
                Err(error) => return Some(Err(error)),
            };
            if self.passage.is_none() {
                return Some(Ok(self.thin(cloud)));
            }
            // A witness with all it saw, although the map needs little of it.
            let view = RangeImage::new(&cloud.xyz, lidar);
            let cloud = self.thin(cloud);
            self.passage.as_mut()?.enter(cloud, view);
        }
        self.passage.as_mut()?.leave().map(Ok)
    }
}
