//! Dynamic points of a keyframe: people, doors and trolleys that other keyframes looked through.
//!
//! The keyframes nearby vote on each voxel of the cloud: their rays either ended there, or went through. A voxel with more votes for free
//! space than for a surface was occupied for a short time only. At most [`DynamicPointsConfig::max_voters`] range images are asked for each
//! point. Source of the idea: Kim and Kim, *Remove, then Revert*, IROS 2020 (range images compared with each other); Schmid et al.,
//! *Dynablox*, RA-L 2023 (voxels that were free are never static).

use crate::range_image::{Occupancy, RangeImage};
use geometry::Isometry;
use points::hash::{CellKey, CellTable};

/// Parameters of [`dynamic_points`] and [`static_points`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicPointsConfig {
    /// Greatest number of keyframes that vote. Enough to detect people who stand still for half a minute. Chosen: three quarters of the keyframes within
    /// [`Self::max_walk_distance_m`]; the time is in proportion.
    pub max_voters: usize,
    /// Keyframes farther away along the walk than this have no vote, metres. Chosen: as the submaps' ([`crate::SubmapConfig::radius_m`]).
    pub max_walk_distance_m: f64,
    /// Edge of the voxels that are decided on as a whole, metres. About the width of a limb. Chosen: smaller ones have too few points for a majority; larger ones remove
    /// what stands beside a person.
    pub voxel_m: f32,
    /// Least number of free-space votes for a dynamic voxel. Chosen: one may be an error of a range image. docs/maths/loops.md, section 12, has the shares that are
    /// removed.
    pub min_free_votes: u32,
    /// Least number of surface votes for a static voxel. Chosen: one more than [`Self::min_free_votes`], because a point that is added to a map stays.
    pub min_surface_votes: u32,
}

impl Default for DynamicPointsConfig {
    fn default() -> Self {
        Self {
            max_voters: 12,
            max_walk_distance_m: 8.0,
            voxel_m: 0.2,
            min_free_votes: 2,
            min_surface_votes: 3,
        }
    }
}

/// Indices of the dynamic points of a cloud (base frame, metres). `others` are range images of other keyframes with their poses in the
/// cloud's base; only the first `max_voters` are asked. Linear in points times voters, 30 ns each.
pub fn dynamic_points(
    xyz: &[[f32; 3]],
    others: &[(Isometry, &RangeImage)],
    config: &DynamicPointsConfig,
) -> Vec<u32> {
    select_points(xyz, others, config, |votes| votes.is_dynamic(config))
}

/// Indices of the static points: enough other keyframes saw a surface there, and none looked through. Otherwise as [`dynamic_points`].
pub fn static_points(
    xyz: &[[f32; 3]],
    others: &[(Isometry, &RangeImage)],
    config: &DynamicPointsConfig,
) -> Vec<u32> {
    select_points(xyz, others, config, |votes| votes.is_static(config))
}

fn select_points(
    xyz: &[[f32; 3]],
    others: &[(Isometry, &RangeImage)],
    config: &DynamicPointsConfig,
    is_selected: impl Fn(&Votes) -> bool,
) -> Vec<u32> {
    let mut table = CellTable::default();
    let voxel_of = |table: &mut CellTable, point: &[f32; 3]| {
        let next = table.len() as u32;
        let cell = CellKey::new(point.map(|c| (c / config.voxel_m).floor() as i64));
        table.get_or_insert(cell, next).0 as usize
    };
    let voxels: Vec<usize> = xyz.iter().map(|point| voxel_of(&mut table, point)).collect();
    let mut votes = vec![Votes::default(); table.len()];
    for (base_from_other, view) in others.iter().take(config.max_voters) {
        let other_from_base = base_from_other.inverse();
        let rotation = other_from_base.rotation.to_rotation_matrix().into_inner().map(|v| v as f32);
        let translation = other_from_base.translation.vector.map(|v| v as f32);
        for (point, &voxel) in xyz.iter().zip(&voxels) {
            let moved = rotation * nalgebra::Vector3::from(*point) + translation;
            votes[voxel].add_point(view.classify(&[moved.x, moved.y, moved.z]));
        }
        votes.iter_mut().for_each(Votes::finish_keyframe);
    }
    let selected: Vec<bool> = votes.iter().map(is_selected).collect();
    (0..xyz.len() as u32).filter(|&point| selected[voxels[point as usize]]).collect()
}

/// Votes on one voxel.
#[derive(Clone, Copy, Debug, Default)]
struct Votes {
    /// Points of the voxel that the keyframe being asked looked through.
    free_points: u32,
    /// Points of the voxel that it saw as a surface.
    surface_points: u32,
    /// Keyframes that voted for free space.
    free: u32,
    /// Keyframes that voted for a surface.
    surface: u32,
}

impl Votes {
    fn add_point(&mut self, occupancy: Occupancy) {
        match occupancy {
            Occupancy::Free => self.free_points += 1,
            Occupancy::Occupied => self.surface_points += 1,
            Occupancy::Occluded | Occupancy::Unobserved => {}
        }
    }

    /// Turns the points counted for one keyframe into its vote, by majority.
    fn finish_keyframe(&mut self) {
        self.free += u32::from(self.free_points > self.surface_points);
        self.surface += u32::from(self.surface_points > 0 && self.surface_points >= self.free_points);
        (self.free_points, self.surface_points) = (0, 0);
    }

    fn is_dynamic(&self, config: &DynamicPointsConfig) -> bool {
        self.free >= config.min_free_votes && self.free > self.surface
    }

    fn is_static(&self, config: &DynamicPointsConfig) -> bool {
        self.surface >= config.min_surface_votes && self.free == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Vector3;

    /// A room 10 m x 8 m seen from `x`, with somebody standing at `person` or nobody.
    fn room(x: f64, person: Option<[f64; 2]>) -> Vec<[f32; 3]> {
        let mut points = Vec::new();
        for column in 0..720 {
            for row in -16..=16 {
                let (sin, cos) = (f64::from(column) * std::f64::consts::TAU / 720.0).sin_cos();
                let tangent = (f64::from(row) * 1.0_f64.to_radians()).tan();
                let wall = |at: f64, along: f64| if along.abs() > 1e-9 { at / along } else { f64::INFINITY };
                let mut range = [wall(5.0 - x, cos), wall(-5.0 - x, cos), wall(4.0, sin), wall(-4.0, sin)]
                    .into_iter()
                    .filter(|r| *r > 0.0)
                    .fold(f64::INFINITY, f64::min);
                if let Some([px, py]) = person {
                    // A post 0.4 m thick.
                    let (dx, dy) = (px - x, py);
                    let along = dx * cos + dy * sin;
                    let off = (dx * sin - dy * cos).abs();
                    if along > 0.0 && off < 0.2 {
                        range = range.min(along - (0.04 - off * off).sqrt());
                    }
                }
                points.push([range * cos, range * sin, range * tangent].map(|c| c as f32));
            }
        }
        points
    }

    #[test]
    fn somebody_who_leaves_is_dropped_and_the_room_stays() {
        let cloud = room(0.0, Some([2.0, 1.0]));
        let images: Vec<(Isometry, RangeImage)> = (1..5)
            .map(|k| {
                let x = 0.4 * f64::from(k);
                let pose = Isometry::new(Vector3::new(x, 0.0, 0.0), Vector3::zeros());
                (pose, RangeImage::new(&room(x, None), [0.0; 3]))
            })
            .collect();
        let others: Vec<(Isometry, &RangeImage)> = images.iter().map(|(pose, view)| (*pose, view)).collect();
        let dropped = dynamic_points(&cloud, &others, &DynamicPointsConfig::default());
        let is_person = |p: &[f32; 3]| (p[0] - 2.0).hypot(p[1] - 1.0) < 0.25;
        let persons = cloud.iter().filter(|p| is_person(p)).count();
        let right = dropped.iter().filter(|&&i| is_person(&cloud[i as usize])).count();
        assert!(persons > 150 && right * 100 >= persons * 95, "{right} of {persons}");
        assert!((dropped.len() - right) * 1000 < cloud.len(), "{} of the room", dropped.len() - right);
        // One vote is not enough, and without votes there is no decision.
        assert!(
            dynamic_points(&cloud, &others[..1], &DynamicPointsConfig::default()).is_empty()
                && dynamic_points(&cloud, &[], &DynamicPointsConfig::default()).is_empty()
        );
    }

    #[test]
    fn somebody_who_stays_is_part_of_the_room() {
        let person = Some([2.0, 1.0]);
        let images: Vec<(Isometry, RangeImage)> = (1..5)
            .map(|k| {
                let x = 0.3 * f64::from(k);
                let pose = Isometry::new(Vector3::new(x, 0.0, 0.0), Vector3::zeros());
                (pose, RangeImage::new(&room(x, person), [0.0; 3]))
            })
            .collect();
        let others: Vec<(Isometry, &RangeImage)> = images.iter().map(|(pose, view)| (*pose, view)).collect();
        let cloud = room(0.0, person);
        assert!(dynamic_points(&cloud, &others, &DynamicPointsConfig::default()).len() * 1000 < cloud.len());
        let standing = static_points(&cloud, &others, &DynamicPointsConfig::default()).len();
        assert!(standing * 10 > cloud.len() * 9, "{standing} of {}", cloud.len());
        assert!(
            static_points(&cloud, &others[..2], &DynamicPointsConfig::default()).is_empty(),
            "two are too few"
        );
        let left: Vec<_> = images
            .iter()
            .map(|(pose, _)| (*pose, RangeImage::new(&room(pose.translation.x, None), [0.0; 3])))
            .collect();
        let left: Vec<(Isometry, &RangeImage)> = left.iter().map(|(pose, view)| (*pose, view)).collect();
        let is_person = |i: &u32| {
            let [x, y, _] = cloud[*i as usize];
            (x - 2.0).hypot(y - 1.0) < 0.25
        };
        assert!(!static_points(&cloud, &left, &DynamicPointsConfig::default()).iter().any(is_person));
    }
}
