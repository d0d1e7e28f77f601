//! The elevation map around the robot, which autonomous walking needs.

use geometry::Isometry;
use messages::{RobotProfile, SpeedLimits};
use navigation::{ElevationMap, GroundZones, MotionGuard, MotionGuardConfig, RobotShape};
use vocab::{Span, Stamp};

/// Parameters of [`Surroundings`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurroundingsConfig {
    /// Side of a elevation map cell, metres. Chosen: a quarter of the radius of the footprint (0.38 m). Smaller cells have no point in many sweeps, larger ones close
    /// doorways.
    pub cell_size_m: f64,
    /// Points farther than this are not inserted into the elevation map, metres. Chosen: twice the length of the parts in which routes are walked, 6 m. Farther away, the
    /// rings of a LiDAR on the floor are metres apart.
    pub max_range_m: f64,
    /// The ground counts as seen for this time after a scan. The slowest LiDARs scan twice a second. Chosen: two of their scans and a margin.
    pub sight_timeout: Span,
}

impl Default for SurroundingsConfig {
    fn default() -> Self {
        Self { cell_size_m: 0.1, max_range_m: 12.0, sight_timeout: Span::from_millis(1_200) }
    }
}

/// Elevation map in the odometry frame. That frame does not jump unless odometry restarts.
#[derive(Debug)]
pub struct Surroundings {
    config: SurroundingsConfig,
    elevation_map: ElevationMap,
    /// Time at which the ground was last seen.
    seen: Option<Stamp>,
}

impl Surroundings {
    /// An empty map, for a robot of this profile.
    pub fn new(config: SurroundingsConfig, profile: &RobotProfile) -> Self {
        let shape = RobotShape {
            radius_m: profile.footprint_radius_m,
            standing_height_m: profile.standing_height_m,
            clearance_m: profile.clearance_height_m,
            step_m: profile.step_height_m,
        };
        Self { config, elevation_map: ElevationMap::new(config.cell_size_m, shape), seen: None }
    }

    /// Inserts a scan. `points`, and the `sensor` position from which they were seen, are in the base frame, metres.
    pub fn insert_scan(
        &mut self,
        at: Stamp,
        odom_from_base: &Isometry,
        sensor: [f32; 3],
        points: &[[f32; 3]],
    ) {
        self.seen = Some(at);
        self.elevation_map.insert_scan(odom_from_base, sensor, points, self.config.max_range_m);
    }

    /// Replaces the areas with rules.
    pub fn set_zones(&mut self, zones: GroundZones) {
        self.elevation_map.set_zones(zones);
    }

    /// Removes everything, because the odometry frame has changed.
    pub fn clear(&mut self) {
        self.elevation_map = ElevationMap::new(self.elevation_map.cell_size_m(), *self.elevation_map.shape());
        self.seen = None;
    }

    /// The elevation map, odometry frame.
    pub fn elevation_map(&self) -> &ElevationMap {
        &self.elevation_map
    }

    /// What the obstacles around the robot allow.
    pub(crate) fn guard(
        &self,
        config: MotionGuardConfig,
        odom_from_base: &Isometry,
        limits: &SpeedLimits,
    ) -> MotionGuard {
        let position = odom_from_base.translation.vector;
        MotionGuard::new(
            config,
            &self.elevation_map,
            &position,
            limits.forward_m_s.hypot(limits.sideways_m_s),
        )
    }

    /// Whether the ground was seen lately.
    pub fn sees_ground(&self, at: Stamp) -> bool {
        self.seen.is_some_and(|seen| at - seen <= self.config.sight_timeout)
    }
}
