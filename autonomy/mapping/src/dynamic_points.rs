//! People, doors and trolleys: points of a keyframe that others looked through.
//!
//! Votes are cast for each voxel of the cloud by keyframes near it: its points were met by their rays, or their rays went
//! through. What was seen through more often than met was not there for long. Bounded: at most [`VOTERS`] images are asked
//! about each point. Source of the idea: Kim and Kim, *Remove, then Revert*, IROS 2020 (images of ranges against each
//! other); Schmid et al., *Dynablox*, RA-L 2023 (voxels that were free are never static).

use crate::range_image::{Occupancy, RangeImage};
use geometry::Isometry;
use points::hash::{CellKey, CellTable};

/// Keyframes asked at most: enough for people who stand for half a minute.
pub const VOTERS: usize = 12;
/// Edge of the voxels that are judged as one, metres: a limb.
const VOXEL: f32 = 0.2;
/// Least number of keyframes that must have looked through.
const LOOKED_THROUGH: u32 = 2;
/// Least number of keyframes that must have met what stands.
const MET: u32 = 3;

/// Indices of the points of a cloud (base frame, metres) that move, judged by what other keyframes saw: each with its pose
/// in the cloud's base. Only the first [`VOTERS`] are asked. Linear in points times voters, 30 ns each.
pub fn moving_points(xyz: &[[f32; 3]], others: &[(Isometry, &RangeImage)]) -> Vec<u32> {
    points_whose(xyz, others, Votes::moves)
}

/// Indices of the points that stand: others enough met them, and none looked through. Otherwise as [`moving_points`].
pub fn standing_points(xyz: &[[f32; 3]], others: &[(Isometry, &RangeImage)]) -> Vec<u32> {
    points_whose(xyz, others, Votes::stands)
}

fn points_whose(
    xyz: &[[f32; 3]],
    others: &[(Isometry, &RangeImage)],
    verdict: impl Fn(&Votes) -> bool,
) -> Vec<u32> {
    let mut table = CellTable::default();
    let voxel_of = |table: &mut CellTable, point: &[f32; 3]| {
        let next = table.len() as u32;
        table.get_or_insert(CellKey::new(point.map(|c| (c / VOXEL).floor() as i64)), next).0 as usize
    };
    let voxels: Vec<usize> = xyz.iter().map(|point| voxel_of(&mut table, point)).collect();
    let mut votes = vec![Votes::default(); table.len()];
    for (base_from_other, view) in others.iter().take(VOTERS) {
        let other_from_base = base_from_other.inverse();
        let turn = other_from_base.rotation.to_rotation_matrix().into_inner().map(|v| v as f32);
        let shift = other_from_base.translation.vector.map(|v| v as f32);
        for (point, &voxel) in xyz.iter().zip(&voxels) {
            let moved = turn * nalgebra::Vector3::from(*point) + shift;
            votes[voxel].note(view.classify(&[moved.x, moved.y, moved.z]));
        }
        votes.iter_mut().for_each(Votes::count);
    }
    let chosen: Vec<bool> = votes.iter().map(verdict).collect();
    (0..xyz.len() as u32).filter(|&point| chosen[voxels[point as usize]]).collect()
}

/// Of one voxel.
#[derive(Clone, Copy, Debug, Default)]
struct Votes {
    /// Points of the voxel by what the keyframe being asked says.
    through_now: u32,
    agrees_now: u32,
    /// Keyframes by what they said.
    through: u32,
    agrees: u32,
}

impl Votes {
    fn note(&mut self, sight: Occupancy) {
        match sight {
            Occupancy::Free => self.through_now += 1,
            Occupancy::Occupied => self.agrees_now += 1,
            Occupancy::Occluded | Occupancy::Unobserved => {}
        }
    }

    /// Each keyframe has one vote, by the majority of the voxel's points.
    fn count(&mut self) {
        self.through += u32::from(self.through_now > self.agrees_now);
        self.agrees += u32::from(self.agrees_now > 0 && self.agrees_now >= self.through_now);
        (self.through_now, self.agrees_now) = (0, 0);
    }

    fn moves(&self) -> bool {
        self.through >= LOOKED_THROUGH && self.through > self.agrees
    }

    fn stands(&self) -> bool {
        self.agrees >= MET && self.through == 0
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
        let dropped = moving_points(&cloud, &others);
        let is_person = |p: &[f32; 3]| (p[0] - 2.0).hypot(p[1] - 1.0) < 0.25;
        let persons = cloud.iter().filter(|p| is_person(p)).count();
        let right = dropped.iter().filter(|&&i| is_person(&cloud[i as usize])).count();
        assert!(persons > 150 && right * 100 >= persons * 95, "{right} of {persons}");
        assert!((dropped.len() - right) * 1000 < cloud.len(), "{} of the room", dropped.len() - right);
        // One witness is not enough, and none at all says nothing.
        assert!(moving_points(&cloud, &others[..1]).is_empty() && moving_points(&cloud, &[]).is_empty());
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
        assert!(moving_points(&cloud, &others).len() * 1000 < cloud.len());
        let standing = standing_points(&cloud, &others).len();
        assert!(standing * 10 > cloud.len() * 9, "{standing} of {}", cloud.len());
        assert!(standing_points(&cloud, &others[..2]).is_empty(), "two are too few");
        let left: Vec<_> = images
            .iter()
            .map(|(pose, _)| (*pose, RangeImage::new(&room(pose.translation.x, None), [0.0; 3])))
            .collect();
        let left: Vec<(Isometry, &RangeImage)> = left.iter().map(|(pose, view)| (*pose, view)).collect();
        let is_person = |i: &u32| {
            let [x, y, _] = cloud[*i as usize];
            (x - 2.0).hypot(y - 1.0) < 0.25
        };
        assert!(!standing_points(&cloud, &left).iter().any(is_person));
    }
}
