//! All clouds of a finished session in the map frame, thinned while they are read so that memory holds one map and
//! one keyframe.

use crate::StoreError;
use crate::sessions::cloud_name;
use map_codec::{LevelSplitter, SplitOptions};
use messages::PoseGraph;
use std::fs;
use std::io;
use std::path::Path;
use vocab::Pose;

/// Points of a map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapPoints {
    /// Metres, map frame.
    pub xyz: Vec<[f32; 3]>,
    /// Sensor units, one for each point.
    pub intensity: Vec<f32>,
}

impl MapPoints {
    /// Reads the clouds of all keyframes of `graph` in `clouds`, and keeps one point in each cell of `spacing` metres,
    /// the one that was seen first. A keyframe without a file adds nothing.
    pub(crate) fn read(clouds: &Path, graph: &PoseGraph, spacing: f32) -> Result<Self, StoreError> {
        let mut points = Self::default();
        // One level and one submap: a cell is taken once, wherever it is seen from.
        let mut splitter = LevelSplitter::new(SplitOptions {
            spacings: vec![spacing],
            submap_keyframes_max: u32::MAX,
            submap_cells_max: usize::MAX,
        });
        for node in &graph.nodes {
            let path = clouds.join(cloud_name(node.id));
            let bytes = match fs::read(&path) {
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                other => other.map_err(|source| StoreError::io("read", &path, source))?,
            };
            let (scan, _) = formats::pcd::read(&bytes)
                .and_then(|table| table.to_scan(Some(node.stamp)))
                .map_err(|source| StoreError::Cloud { path: path.clone(), source })?;
            for new in splitter.push(&node.map_from_keyframe, &scan.xyz, &scan.intensity) {
                points.add(&node.map_from_keyframe, &new.xyz, &new.intensity);
            }
        }
        Ok(points)
    }

    /// Adds points given in the frame whose pose in the map is `map_from_points`; none when that is not a pose.
    fn add(&mut self, map_from_points: &Pose, xyz: &[[f32; 3]], intensity: &[f32]) {
        let Some(map_from_points) = geometry::isometry_from_pose(map_from_points) else {
            return;
        };
        self.xyz.extend(xyz.iter().map(|point| -> [f32; 3] {
            let in_map = map_from_points.rotation * geometry::Vector3::from(point.map(f64::from))
                + map_from_points.translation.vector;
            in_map.map(|coordinate| coordinate as f32).into()
        }));
        self.intensity.extend(intensity);
    }
}
