//! The changes of a map that follow from accepted changes of the scene.

use crate::map_version::{AddedPoint, MapEdit};
use changes::{AcceptedChanges, AcceptedChangesConfig, ObservedChange, Visit};
use geometry::{Isometry, Vector3};
use mapping::map_changes::transform_to_map;
use store::SavedMap;

/// The edit of a map.
pub struct AcceptedEdit<'a> {
    saved: &'a SavedMap,
    accepted: AcceptedChanges,
    /// The points of the map near changes.
    known: Vec<[f32; 3]>,
}

impl<'a> AcceptedEdit<'a> {
    /// Of this map, by the visits that found the changes.
    pub fn new(saved: &'a SavedMap, changes: &[ObservedChange], visits: &[Visit]) -> Self {
        let accepted = AcceptedChanges::new(changes, visits, AcceptedChangesConfig::default());
        Self { saved, accepted, known: Vec::new() }
    }

    /// The keyframe nearest to a sensor.
    fn nearest_keyframe(&self, sensor: &Vector3) -> Option<usize> {
        let distance = |pose: &Isometry| (pose.translation.vector - sensor).norm();
        let poses = self.saved.poses.iter().enumerate();
        poses.min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b))).map(|(number, _)| number)
    }
}

impl MapEdit for AcceptedEdit<'_> {
    fn removed(&self, map_from_keyframe: &Isometry, xyz: &[[f32; 3]]) -> Vec<u32> {
        let is_gone = |point: &[f32; 3]| self.accepted.is_gone(&in_map(map_from_keyframe, point));
        (0..).zip(xyz).filter(|(_, point)| is_gone(point)).map(|(number, _)| number).collect()
    }

    fn keep(&mut self, map_from_keyframe: &Isometry, xyz: &[[f32; 3]]) {
        let places = xyz.iter().map(|point| in_map(map_from_keyframe, point));
        self.known.extend(places.filter(|place| self.accepted.is_near_change(place)));
    }

    fn added(&mut self) -> Vec<AddedPoint> {
        let added = self.accepted.added(std::mem::take(&mut self.known));
        let added = added.into_iter().filter_map(|point| {
            Some(AddedPoint {
                in_map: Vector3::from(point.place.map(f64::from)),
                // Clouds of runs have none.
                intensity: 0.0,
                nearest_keyframe: self.nearest_keyframe(&point.sensor)?,
            })
        });
        added.collect()
    }
}

fn in_map(map_from_keyframe: &Isometry, point: &[f32; 3]) -> [f32; 3] {
    transform_to_map(map_from_keyframe, point).map(|at| at as f32).into()
}
