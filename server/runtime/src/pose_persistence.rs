//! Writes the robot's pose in the map in use and the docks to disk. At the next start the robot is localised there.

use crate::jobs::known_map;
use messages::{Estimate, LocalisationState, PoseInMap};
use std::sync::Arc;
use std::time::{Duration, Instant};
use store::Store;
use vocab::MapId;

/// Parameters of [`PosePersistence`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PosePersistenceConfig {
    /// Shortest time between two writes of the pose. A robot walks about 2 m in it, which localisation corrects at the start.
    pub write_period: Duration,
}

impl Default for PosePersistenceConfig {
    fn default() -> Self {
        Self { write_period: Duration::from_secs(2) }
    }
}

/// Follows the published state of localisation and writes pose and docks.
pub struct PosePersistence {
    config: PosePersistenceConfig,
    store: Arc<Store>,
    /// The map in which the robot is localised without degradation.
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
            LocalisationState::Localised { map, degradation: None } => Some(*map),
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

    /// Writes the pose if the robot is localised, the pose has changed and the last write is old enough.
    pub fn update(&mut self, now: Instant, estimate: &Estimate) {
        let Some(map) = self.localised_map else { return };
        let pose = PoseInMap { map, map_from_base: estimate.map_from_base };
        if self.written.is_none_or(|(at, last)| now >= at + self.config.write_period && last != pose) {
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

#[cfg(test)]
#[path = "pose_persistence_tests.rs"]
mod tests;
