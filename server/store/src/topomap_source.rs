//! Reads what a topological map is made from: a map's folder, and the docks in that map.

use crate::checked_json::read_checked_json;
use crate::poses::{DocksDocument, POSES_FORMAT_VERSIONS};
use crate::{CloudSelection, MapPoints, SavedMap, Store, StoreError, map_clouds};
use geometry::{Isometry, isometry_from_pose};
use messages::RobotProfile;
use std::path::Path;
use topomap::{FloorBuilder, GeneratedMap, RobotShape, TopomapConfig, TopomapInput};
use vocab::{KeyframeId, MapId, Pose, Stamp};

/// A map as [`topomap::generate`] needs it: some 10 MB for a hall of 60 m x 40 m. It is read on the lane of the disk, and the rest is a computation.
#[derive(Clone, Debug)]
pub struct TopomapSource {
    map: MapId,
    keyframes: Vec<(KeyframeId, Isometry)>,
    path: Vec<(Stamp, Isometry)>,
    docks: Vec<Isometry>,
    robot: RobotShape,
    floor: FloorBuilder,
    config: TopomapConfig,
}

impl TopomapSource {
    /// Reads the map in the folder `dir`. `docks` are poses of the base on docks. Reads one cloud at a time.
    ///
    /// # Errors
    /// When `dir` holds no map, or files in it cannot be understood.
    pub fn read(
        dir: &Path,
        docks: &[Pose],
        profile: &RobotProfile,
        config: TopomapConfig,
    ) -> Result<Self, StoreError> {
        let map = SavedMap::read(dir)?;
        let is_walked = map.summary.has_pose_graph;
        let keyframes: Vec<_> = (0..).map(KeyframeId).zip(map.poses.iter().copied()).collect();
        let mut path = Vec::new();
        if is_walked {
            path.extend(
                map.trajectory.iter().filter_map(|(stamp, pose)| Some((*stamp, isometry_from_pose(pose)?))),
            );
            if path.is_empty() {
                path.extend(map.stamps.iter().copied().zip(map.poses.iter().copied()));
            }
        }
        let robot = robot_shape(profile);
        let mut floor = FloorBuilder::new(robot, config);
        if is_walked {
            let selection = CloudSelection { spacing_m: config.voxel_m as f32, include_dynamic: false };
            for cloud in map_clouds(dir, selection)? {
                let cloud = cloud?;
                if let Some(map_from_keyframe) = isometry_from_pose(&cloud.map_from_keyframe) {
                    let stamp = map.stamps.get(cloud.keyframe.0 as usize).copied().unwrap_or_default();
                    floor.insert(stamp, &map_from_keyframe, &cloud.xyz);
                }
            }
        } else {
            // Virtual viewpoints see a part of the points only.
            floor.insert_survey(&MapPoints::from_tiles(dir)?.xyz);
        }
        let docks = docks.iter().filter_map(isometry_from_pose).collect();
        Ok(Self { map: map.summary.id, keyframes, path, docks, robot, floor, config })
    }

    /// Makes the topological map. A pure function of what was read.
    pub fn generate(self) -> GeneratedMap {
        let input = TopomapInput {
            map: self.map,
            keyframes: &self.keyframes,
            path: &self.path,
            docks: &self.docks,
            robot: self.robot,
        };
        topomap::generate(&input, self.floor, &self.config)
    }

    /// The keyframes with their poses.
    pub fn keyframes(&self) -> &[(KeyframeId, Isometry)] {
        &self.keyframes
    }

    /// The walked path of the base; empty if nobody walked.
    pub fn path(&self) -> &[(Stamp, Isometry)] {
        &self.path
    }

    /// The docks that are known of the map in the folder `dir`, if it is one of a data directory's maps. None where the list of docks is missing or
    /// cannot be read: a topological map can be made without.
    pub fn known_docks(dir: &Path) -> Vec<Pose> {
        let Ok(map) = SavedMap::read(dir) else { return Vec::new() };
        let list = dir.join("..").join("..").join("docks.json");
        let document: Result<DocksDocument, _> = read_checked_json(&list, POSES_FORMAT_VERSIONS);
        let docks = document.map(|document| document.docks).unwrap_or_default();
        docks.iter().filter(|dock| dock.map == map.summary.id).map(|dock| dock.map_from_base).collect()
    }
}

impl Store {
    /// Reads what a topological map of a saved map is made from, with the docks in it.
    ///
    /// # Errors
    /// When there is no such map, or it cannot be read.
    pub fn topomap_source(
        &self,
        map: MapId,
        profile: &RobotProfile,
        config: TopomapConfig,
    ) -> Result<TopomapSource, StoreError> {
        let docks = self.docks();
        let docks: Vec<Pose> =
            docks.iter().filter(|dock| dock.map == map).map(|dock| dock.map_from_base).collect();
        TopomapSource::read(&self.dir().map(map), &docks, profile, config)
    }
}

fn robot_shape(profile: &RobotProfile) -> RobotShape {
    RobotShape {
        radius_m: profile.footprint_radius_m,
        standing_height_m: profile.standing_height_m,
        clearance_m: profile.clearance_height_m,
        step_m: profile.step_height_m,
    }
}
