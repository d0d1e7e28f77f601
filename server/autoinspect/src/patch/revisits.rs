//! The changes of a map according to localised scans of later recordings.

use crate::map_version::{AddedPoint, MapEdit};
use geometry::Isometry;
use mapping::map_changes::{
    self, MapChangesConfig, OccupiedCells, RevisitScan, nearest_keyframe, removed_points, transform_to_map,
};
use store::SavedMap;

/// The edit of a map that follows from scans.
pub struct Revisits<'a> {
    saved: &'a SavedMap,
    scans: &'a [RevisitScan],
    config: MapChangesConfig,
    occupied: OccupiedCells,
}

impl<'a> Revisits<'a> {
    /// Of this map, after these scans.
    pub fn new(saved: &'a SavedMap, scans: &'a [RevisitScan]) -> Self {
        Self { saved, scans, config: MapChangesConfig::default(), occupied: OccupiedCells::default() }
    }
}

impl MapEdit for Revisits<'_> {
    fn removed(&self, map_from_keyframe: &Isometry, xyz: &[[f32; 3]]) -> Vec<u32> {
        removed_points(map_from_keyframe, xyz, self.scans, &self.config)
    }

    fn keep(&mut self, map_from_keyframe: &Isometry, xyz: &[[f32; 3]]) {
        xyz.iter().for_each(|point| self.occupied.insert(&transform_to_map(map_from_keyframe, point)));
    }

    fn added(&mut self) -> Vec<AddedPoint> {
        let mut added = Vec::new();
        for (number, scan) in self.scans.iter().enumerate() {
            let nearest = nearest_keyframe(&scan.map_from_base, &self.saved.poses, &self.config);
            let Some(nearest_keyframe) = nearest else { continue };
            let indices = map_changes::added_points(self.scans, number, &mut self.occupied);
            added.extend(indices.into_iter().map(|index| AddedPoint {
                in_map: transform_to_map(&scan.map_from_base, &scan.xyz[index as usize]),
                intensity: scan.intensity.get(index as usize).copied().unwrap_or(0.0),
                nearest_keyframe,
            }));
        }
        added
    }
}
