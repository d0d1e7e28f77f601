//! Lines of sight through a map: which of its voxels are occupied, and the first one that a ray meets.
//!
//! Source of the traversal: Amanatides, Woo, *A Fast Voxel Traversal Algorithm for Ray Tracing*, 1987.

use crate::hash::{CellKey, CellTable};
use geometry::Vector3;

/// Parameters of [`OccupiedVoxels`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineOfSightConfig {
    /// Side of a voxel, metres. Walls of a saved map, whose points are 5 cm apart, have no holes then. Chosen: twice that.
    pub voxel_m: f32,
    /// Points that make a voxel occupied. Single ones are noise. Chosen: the least number above one.
    pub min_points: u32,
    /// Length at the camera's end of a line that is not looked at, metres: the robot itself, and people beside it when the map was made. Chosen: about the distance from
    /// the head to the edge of the body.
    pub near_m: f64,
    /// The same at the target's end: the target's own surface, and the error of a target that a person has pointed at. Chosen: as [`Self::near_m`].
    pub far_m: f64,
    /// Voxels that are kept at most; they take 16 bytes each. A hall of 60 m x 40 m has some 400,000. Chosen: 128 MB, twenty such halls.
    pub max_voxels: usize,
}

impl Default for LineOfSightConfig {
    fn default() -> Self {
        Self { voxel_m: 0.1, min_points: 2, near_m: 0.3, far_m: 0.3, max_voxels: 8_000_000 }
    }
}

/// The occupied voxels of a map.
#[derive(Clone, Debug)]
pub struct OccupiedVoxels {
    config: LineOfSightConfig,
    /// Place of each voxel in `counts`.
    index: CellTable,
    /// Points in each voxel.
    counts: Vec<u32>,
}

impl OccupiedVoxels {
    /// Without points.
    pub fn new(config: LineOfSightConfig) -> Self {
        Self { config, index: CellTable::with_capacity(0), counts: Vec::new() }
    }

    /// Adds a point, metres, map frame. Points beyond the greatest number of voxels, and those that are not finite, are left out.
    pub fn insert(&mut self, point: &[f32; 3]) {
        if !point.iter().all(|coordinate| coordinate.is_finite()) {
            return;
        }
        let key = CellKey::of_point(point, 1.0 / self.config.voxel_m);
        let found = match self.index.get(key) {
            Some(place) => place,
            None if self.counts.len() >= self.config.max_voxels => return,
            None => {
                let place = self.counts.len() as u32;
                self.counts.push(0);
                self.index.get_or_insert(key, place).0
            }
        };
        if let Some(count) = self.counts.get_mut(found as usize) {
            *count = count.saturating_add(1);
        }
    }

    /// Distance from `from` to the first occupied voxel on the way to `to`, metres; both in the map frame, metres. None: the line is free. Linear in its length.
    pub fn first_obstacle_m(&self, from: &Vector3, to: &Vector3) -> Option<f64> {
        let offset = to - from;
        let length_m = offset.norm();
        let end_m = length_m - self.config.far_m;
        if !length_m.is_finite() || end_m <= self.config.near_m {
            return None;
        }
        let direction = offset / length_m;
        let side_m = f64::from(self.config.voxel_m);
        let start = from + direction * self.config.near_m;
        let mut cell: [i64; 3] = std::array::from_fn(|axis| (start[axis] / side_m).floor() as i64);
        let step: [i64; 3] = std::array::from_fn(|axis| if direction[axis] < 0.0 { -1 } else { 1 });
        // Distance along the ray from one border to the next, and from the camera to the first one.
        let between_m: [f64; 3] = std::array::from_fn(|axis| side_m / direction[axis].abs());
        let mut next_m: [f64; 3] = std::array::from_fn(|axis| {
            let border_m = (cell[axis] + i64::from(step[axis] > 0)) as f64 * side_m;
            let along_m = (border_m - start[axis]) / direction[axis];
            // A ray along a border never reaches it.
            if along_m.is_finite() { self.config.near_m + along_m } else { f64::INFINITY }
        });
        let mut along_m = self.config.near_m;
        while along_m < end_m {
            if self.is_occupied(cell) {
                return Some(along_m);
            }
            let axis = (0..3).min_by(|a, b| next_m[*a].total_cmp(&next_m[*b])).unwrap_or(0);
            along_m = next_m[axis];
            next_m[axis] += between_m[axis];
            cell[axis] += step[axis];
        }
        None
    }

    fn is_occupied(&self, cell: [i64; 3]) -> bool {
        let count = self.index.get(CellKey::new(cell)).and_then(|place| self.counts.get(place as usize));
        count.is_some_and(|count| *count >= self.config.min_points)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall across x = 2 m, from y = -1 m to 1 m, 2 m high.
    fn wall() -> OccupiedVoxels {
        let mut voxels = OccupiedVoxels::new(LineOfSightConfig::default());
        for (y, z) in (-20..20).flat_map(|y| (0..40).map(move |z| (y, z))) {
            voxels.insert(&[2.03, y as f32 * 0.05 + 0.02, z as f32 * 0.05 + 0.02]);
        }
        voxels
    }

    fn at(x: f64, y: f64, z: f64) -> Vector3 {
        Vector3::new(x, y, z)
    }

    #[test]
    fn what_stands_between_is_found_with_its_distance_from_any_side() {
        let voxels = wall();
        let found = voxels.first_obstacle_m(&at(0.0, 0.0, 1.0), &at(4.0, 0.0, 1.0));
        assert!(found.is_some_and(|along_m| (along_m - 2.0).abs() < 0.11), "{found:?}");
        let back = voxels.first_obstacle_m(&at(4.0, 0.5, 1.5), &at(0.0, -0.5, 0.5));
        assert!(back.is_some_and(|along_m| (1.9..2.3).contains(&along_m)), "{back:?}");
    }

    #[test]
    fn past_the_edge_above_and_on_the_wall_itself_the_line_is_free() {
        let voxels = wall();
        assert_eq!(voxels.first_obstacle_m(&at(0.0, 1.2, 1.0), &at(4.0, 1.2, 1.0)), None);
        assert_eq!(voxels.first_obstacle_m(&at(0.0, 0.0, 2.5), &at(4.0, 0.0, 2.5)), None);
        assert_eq!(voxels.first_obstacle_m(&at(0.0, 0.0, 1.0), &at(2.03, 0.3, 1.0)), None, "the target");
        assert_eq!(voxels.first_obstacle_m(&at(0.0, 0.0, 1.0), &at(0.2, 0.0, 1.0)), None, "too near");
        assert_eq!(voxels.first_obstacle_m(&at(f64::NAN, 0.0, 1.0), &at(4.0, 0.0, 1.0)), None);
    }

    #[test]
    fn a_single_point_is_noise() {
        let mut voxels = OccupiedVoxels::new(LineOfSightConfig::default());
        voxels.insert(&[1.0, 0.02, 1.02]);
        voxels.insert(&[f32::NAN, 0.0, 0.0]);
        let line = (at(0.0, 0.02, 1.02), at(3.0, 0.02, 1.02));
        assert_eq!(voxels.first_obstacle_m(&line.0, &line.1), None);
        voxels.insert(&[1.01, 0.03, 1.03]);
        assert!(voxels.first_obstacle_m(&line.0, &line.1).is_some());
    }
}
