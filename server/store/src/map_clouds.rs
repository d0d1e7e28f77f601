//! The keyframe clouds of a map, one at a time and thinned while they are read: memory holds one keyframe, and 22 bytes
//! for each point kept.

use crate::sessions::cloud_name;
use crate::{StoreError, files};
use map_codec::{LevelSplitter, SplitOptions};
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
    /// When it was made.
    pub stamp: Stamp,
    /// Where it is.
    pub map_from_keyframe: Pose,
    /// Metres, keyframe's frame.
    pub xyz: Vec<[f32; 3]>,
    /// Sensor units, one for each point.
    pub intensity: Vec<f32>,
}

/// Reads a map's clouds in the order of its graph. A keyframe without a file is passed over.
#[derive(Debug)]
pub struct MapClouds {
    clouds: PathBuf,
    places: std::vec::IntoIter<Place>,
    /// None where every point is wanted.
    splitter: Option<LevelSplitter>,
}

/// The clouds of the map in the folder `dir`, as `autoinspect map --out` and a data directory's `maps/` have them: one
/// point in each cell of `spacing` metres, the one that was seen first, or every point where `spacing` is 0.
///
/// # Errors
/// When `dir` holds no graph or one that cannot be understood.
pub fn map_clouds(dir: &Path, spacing: f32) -> Result<MapClouds, StoreError> {
    let graph: api::Graph = files::read_json(&dir.join("graph.json"))?;
    let places = graph.nodes.iter().map(|node| Place {
        id: node.id,
        stamp: node.stamp,
        map_from_keyframe: node.map_from_keyframe,
    });
    Ok(MapClouds::new(dir.join("clouds"), places.collect(), spacing))
}

impl MapClouds {
    pub(crate) fn new(clouds: PathBuf, places: Vec<Place>, spacing: f32) -> Self {
        // One level and one submap: a cell is taken once, wherever it is seen from.
        let splitter = (spacing > 0.0).then(|| {
            LevelSplitter::new(SplitOptions {
                spacings: vec![spacing],
                submap_keyframes_max: u32::MAX,
                submap_cells_max: usize::MAX,
            })
        });
        Self { clouds, places: places.into_iter(), splitter }
    }

    /// How many keyframes have not been read yet.
    pub fn left(&self) -> usize {
        self.places.len()
    }

    /// The next keyframe's cloud as its file has it; none when there is no file.
    fn read(&self, place: &Place) -> Result<Option<MapCloud>, StoreError> {
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
        Ok(Some(MapCloud {
            keyframe: place.id,
            stamp: place.stamp,
            map_from_keyframe: place.map_from_keyframe,
            xyz: scan.xyz,
            intensity,
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
        loop {
            let place = self.places.next()?;
            match self.read(&place) {
                Ok(None) => {}
                Ok(Some(cloud)) => return Some(Ok(self.thin(cloud))),
                Err(error) => return Some(Err(error)),
            }
        }
    }
}
