//! The map that was saved last. While the robot has not walked far since, odometry gives its pose in that map.

use crate::map_search::MapSearchFix;
use crate::pose_graph::PoseGraph;
use crate::uncertain_pose::diagonal_covariance;
use crate::{Odometer, PoseCertaintyConfig, UncertainPose};
use geometry::{Isometry, Matrix6};
use vocab::MapId;

/// Parameters of [`LastSavedMap`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LastSavedMapConfig {
    /// Standard deviation of the rotation, radians. Chosen: about a degree, far above the drift of odometry over [`Self::max_distance_m`], so that a loop can still
    /// correct it.
    pub rotation_std_rad: f64,
    /// Standard deviation of the translation, metres, ... Chosen: for the last pose of the saved map and that of the robot.
    pub translation_std_m: f64,
    /// ... plus this share of the distance walked since. Chosen: 1 %, far above the drift of the odometry in docs/benchmarks/odometry.md.
    pub translation_std_share: f64,
    /// Greatest distance walked since, metres. Chosen: with both terms above, the deviation stays below [`Self::max_std_m`].
    pub max_distance_m: f64,
    /// Greatest standard deviation, including the covariance of odometry, metres. Its default is that of [`PoseCertaintyConfig`].
    pub max_std_m: f64,
}

impl Default for LastSavedMapConfig {
    fn default() -> Self {
        Self {
            rotation_std_rad: 0.02,
            translation_std_m: 0.05,
            translation_std_share: 0.01,
            max_distance_m: 25.0,
            max_std_m: PoseCertaintyConfig::default().max_std_m,
        }
    }
}

/// A map that was saved while the robot was in it.
#[derive(Debug)]
pub struct LastSavedMap {
    config: LastSavedMapConfig,
    map: MapId,
    map_from_odom: Isometry,
    /// Distance walked since.
    walked: Odometer,
    /// The odometry's covariance then.
    covariance: Option<Matrix6>,
}

impl LastSavedMap {
    /// Saved now.
    pub fn new(config: LastSavedMapConfig, map: MapId, map_from_odom: Isometry) -> Self {
        Self { config, map, map_from_odom, walked: Odometer::default(), covariance: None }
    }

    /// Takes the odometry's pose and covariance after a scan.
    pub fn update(&mut self, odom_from_base: &Isometry, covariance: &Matrix6) {
        self.walked.move_to(&odom_from_base.translation.vector);
        self.covariance.get_or_insert(*covariance);
    }

    /// Pose of the odometry's frame in `map`, if it is this one and odometry is still good enough. `covariance` is the odometry's now.
    pub fn map_from_odom(&self, map: MapId, covariance: &Matrix6) -> Option<Isometry> {
        (self.map == map).then(|| self.base_covariance(covariance))?.map(|_| self.map_from_odom)
    }

    /// Pose of a waypoint in `map`, if it is this one and odometry is still good enough.
    pub fn locate(
        &self,
        map: MapId,
        waypoint: u64,
        odom_from_base: &Isometry,
        covariance: &Matrix6,
        graph: &PoseGraph,
    ) -> Option<MapSearchFix> {
        let covariance = (self.map == map).then(|| self.base_covariance(covariance))??;
        let (keyframe, pose) = graph.nearest(&(self.map_from_odom * odom_from_base))?;
        Some(MapSearchFix { waypoint, keyframe, keyframe_from_waypoint: UncertainPose { pose, covariance } })
    }

    /// Covariance of the base in the map; `None` if it is too large.
    fn base_covariance(&self, covariance: &Matrix6) -> Option<Matrix6> {
        let walked_m = self.walked.distance();
        // If odometry has lost tracking since, its covariance shows this.
        let before = self.covariance.unwrap_or_else(Matrix6::zeros);
        let grown = (covariance - before).diagonal();
        let [turned, moved] = [0, 3].map(|first| grown.fixed_rows::<3>(first).max().max(0.0));
        let translation_std_m = self.config.translation_std_m + self.config.translation_std_share * walked_m;
        let mut covariance = diagonal_covariance(self.config.rotation_std_rad, translation_std_m);
        for row in 0..6 {
            covariance[(row, row)] += if row < 3 { turned } else { moved };
        }
        let pose = UncertainPose { pose: Isometry::identity(), covariance };
        let is_good =
            walked_m <= self.config.max_distance_m && pose.translation_std_m() <= self.config.max_std_m;
        is_good.then_some(covariance)
    }
}
