//! Writes the robot's pose in the map in use and the docks to disk. At the next start the robot is looked for there.

use crate::jobs::known_map;
use geometry::isometry_from_pose;
use messages::{DegradationReason, Estimate, LocalisationState, PoseInMap};
use std::sync::Arc;
use std::time::{Duration, Instant};
use store::Store;
use vocab::{MapId, Pose};

/// Parameters of [`PosePersistence`].
///
/// The search at a start covers 1 m and 20 degrees round the written pose (`GlobalLocaliserConfig::prior_offsets_m`). A robot whose core dies walks 0.23 m and turns by 0.2 rad before
/// it stands. What is left is how far it may have moved since the write.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PosePersistenceConfig {
    /// Time after which the pose is written, however little it has changed. Chosen: few writes for the disk, and a pose that is 2 s old at most.
    pub write_period: Duration,
    /// Distance after which it is written, metres. Chosen: with the 0.23 m, below 1 m.
    pub write_distance_m: f64,
    /// Rotation after which it is written, radians. Chosen: with the 0.2 rad, 20 degrees.
    pub write_angle_rad: f64,
    /// Shortest time between two writes of a robot that moves. Each waits for the disk. Chosen: at walking speed the robot needs 0.5 s for [`Self::write_distance_m`].
    pub moving_period: Duration,
}

impl Default for PosePersistenceConfig {
    fn default() -> Self {
        Self {
            write_period: Duration::from_secs(2),
            write_distance_m: 0.5,
            write_angle_rad: 0.15,
            moving_period: Duration::from_millis(100),
        }
    }
}

/// Follows the published state of localisation and writes pose and docks.
pub struct PosePersistence {
    config: PosePersistenceConfig,
    store: Arc<Store>,
    /// The map in which the robot is localised, with nothing against the pose but that it was not confirmed since the start.
    localised_map: Option<MapId>,
    /// The map that is being read.
    loading: Option<MapId>,
    /// The pose written last, and when.
    written: Option<(Instant, PoseInMap)>,
    /// Whether the last write failed, which is logged once.
    is_failing: bool,
}

impl PosePersistence {
    /// Writes to this store.
    pub fn new(config: PosePersistenceConfig, store: Arc<Store>) -> Self {
        Self { config, store, localised_map: None, loading: None, written: None, is_failing: false }
    }

    /// Updates the state of localisation. The written pose stays while the robot relocalises and when the map cannot be read, because that can be mended. It is
    /// deleted when the robot leaves the map.
    pub fn set_localisation(&mut self, state: &LocalisationState) {
        self.localised_map = match state {
            LocalisationState::Localised {
                map,
                degradation: None | Some(DegradationReason::Unconfirmed),
            } => Some(*map),
            _ => None,
        };
        let loading = match state {
            LocalisationState::Loading { map } => Some(*map),
            _ => None,
        };
        let was_loading = std::mem::replace(&mut self.loading, loading);
        // Somebody may also have left the map while it was being read.
        if *state == LocalisationState::Idle && was_loading.is_none_or(|map| self.is_readable(map)) {
            self.written = None;
            self.write(None);
        }
    }

    /// Writes the pose if the robot is localised, and the pose has changed since the last write by much, or at all and that is long ago.
    pub fn update(&mut self, now: Instant, estimate: &Estimate) {
        let Some(map) = self.localised_map else { return };
        let pose = PoseInMap { map, map_from_base: estimate.map_from_base };
        let config = &self.config;
        let is_due = self.written.is_none_or(|(at, last)| {
            let has_moved = last.map != map || has_moved(&last.map_from_base, &pose.map_from_base, config);
            (now >= at + config.write_period && last != pose)
                || (now >= at + config.moving_period && has_moved)
        });
        if is_due {
            self.written = Some((now, pose));
            self.write(Some(&pose));
        }
    }

    /// Writes the docks.
    pub fn save_docks(&self, docks: &[PoseInMap]) {
        if let Err(error) = self.store.save_docks(docks) {
            tracing::warn!("the docks cannot be saved: {error}");
        }
    }

    /// Reads the whole map: some 20 us for each of its keyframes.
    fn is_readable(&self, map: MapId) -> bool {
        known_map(&self.store.dir().map(map)).is_ok()
    }

    fn write(&mut self, pose: Option<&PoseInMap>) {
        let saved = self.store.save_last_pose(pose);
        if let Err(error) = &saved
            && !self.is_failing
        {
            tracing::warn!("the robot's pose cannot be saved: {error}");
        }
        self.is_failing = saved.is_err();
    }
}

/// Whether a pose is far enough from the one that was written. A pose that is none counts as far.
fn has_moved(written: &Pose, now: &Pose, config: &PosePersistenceConfig) -> bool {
    let (Some(written), Some(now)) = (isometry_from_pose(written), isometry_from_pose(now)) else {
        return true;
    };
    let motion = written.inverse() * now;
    motion.translation.vector.norm() >= config.write_distance_m
        || motion.rotation.angle() >= config.write_angle_rad
}

#[cfg(test)]
#[path = "pose_persistence_tests.rs"]
mod tests;
