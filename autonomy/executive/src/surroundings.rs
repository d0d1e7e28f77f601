//! The ground round the robot as it has been seen: what walking by itself needs.

use geometry::Isometry;
use messages::RobotProfile;
use navigation::{ElevationMap, RobotShape};
use vocab::{Span, Stamp};

/// Parameters of [`Surroundings`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurroundingsConfig {
    /// Side of a terrain cell, metres.
    pub cell_size_m: f64,
    /// Points farther than this are not inserted into the terrain, metres.
    pub range_max_m: f64,
    /// The ground counts as seen for this time after a scan: slow LiDARs turn twice a second.
    pub sight_timeout: Span,
}

impl Default for SurroundingsConfig {
    fn default() -> Self {
        Self { cell_size_m: 0.1, range_max_m: 12.0, sight_timeout: Span::from_millis(1_200) }
    }
}

/// ElevationMap in odometry's frame, in which nothing jumps unless odometry begins anew.
#[derive(Debug)]
pub struct Surroundings {
    config: SurroundingsConfig,
    terrain: ElevationMap,
    /// When the ground was seen last.
    seen: Option<Stamp>,
}

impl Surroundings {
    /// Nothing seen yet, for a robot of this profile.
    pub fn new(config: SurroundingsConfig, profile: &RobotProfile) -> Self {
        let shape = RobotShape {
            radius: profile.footprint_radius_m,
            standing_height: profile.standing_height_m,
            clearance: profile.clearance_height_m,
            step: profile.step_height_m,
        };
        Self { config, terrain: ElevationMap::new(config.cell_size_m, shape), seen: None }
    }

    /// Inserts a scan. `points` and the `sensor` that saw them in the base frame, metres.
    pub fn insert_scan(
        &mut self,
        at: Stamp,
        odom_from_base: &Isometry,
        sensor: [f32; 3],
        points: &[[f32; 3]],
    ) {
        self.seen = Some(at);
        self.terrain.insert_scan(odom_from_base, sensor, points, self.config.range_max_m);
    }

    /// Forgets everything: the frame is another one from now on.
    pub fn clear(&mut self) {
        self.terrain = ElevationMap::new(self.terrain.cell_size(), *self.terrain.shape());
        self.seen = None;
    }

    /// Where the robot can walk, odometry's frame.
    pub fn terrain(&self) -> &ElevationMap {
        &self.terrain
    }

    /// Whether the ground was seen lately.
    pub fn sees_ground(&self, at: Stamp) -> bool {
        self.seen.is_some_and(|seen| at - seen <= self.config.sight_timeout)
    }
}
