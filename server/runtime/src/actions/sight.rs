//! Checks in the saved map in use whether something stands between the camera and its target.

use geometry::Vector3;
use site_model::LineOfSight;
use std::sync::Arc;
use store::{LineOfSightConfig, OccupiedVoxels, Store};
use vocab::MapId;

/// The occupied voxels of one saved map, the last one that was asked for.
pub struct SightChecker {
    store: Arc<Store>,
    config: LineOfSightConfig,
    /// None of the map: it cannot be read.
    read: Option<(MapId, Option<OccupiedVoxels>)>,
}

impl SightChecker {
    /// Has read no map.
    pub fn new(store: Arc<Store>) -> Self {
        Self { store, config: LineOfSightConfig::default(), read: None }
    }

    /// Reads a map, if it is not the one that was read last. A hall takes a fraction of a second.
    pub fn prepare(&mut self, map: MapId) -> Option<&OccupiedVoxels> {
        if self.read.as_ref().is_none_or(|(read, _)| *read != map) {
            let voxels = self.store.occupied_voxels(map, self.config);
            if let Err(error) = &voxels {
                tracing::warn!("lines of sight are not checked in the map {map}: {error}");
            }
            self.read = Some((map, voxels.ok()));
        }
        self.read.as_ref()?.1.as_ref()
    }

    /// What a map shows between a camera and its target, both metres in the map frame. None if the map cannot be read.
    pub fn check(&mut self, map: MapId, [camera, target]: [Vector3; 2]) -> Option<LineOfSight> {
        let voxels = self.prepare(map)?;
        let distance_m = (target - camera).norm();
        let obstacle_at_m = voxels.first_obstacle_m(&camera, &target);
        distance_m.is_finite().then_some(LineOfSight { distance_m, obstacle_at_m })
    }
}
