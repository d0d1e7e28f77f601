//! Where a scan may have been taken, told by the outline of what stands on the floor and nothing else.
//!
//! Each level of the map is a small picture from above of all that stands there. The scan's own outline is laid over it at every spot
//! near a keyframe and in every heading, and what covers most is worth a closer look. That misses nothing that looks may miss, such as a
//! place some metres off the lane in which the map was walked. Heights count from the floor that the scan itself sees, so that a map can be
//! used by a robot that is taller than the one that walked it.

use crate::bit_grid::{BitCounters, BitGrid, each};
use crate::localisation_map::LocalisationMap;
use geometry::{Isometry, Rotation, Vector3, so3};
use nalgebra::Translation3;
use std::cmp::Reverse;
use std::f64::consts::TAU;

/// Edge of a cell, metres.
const CELL: f64 = 0.4;
/// What stands between these heights over the floor counts, metres: walls and racks, but neither floor nor roof.
const BAND: (f64, f64) = (0.4, 2.0);
/// A base is so high over its floor if its scan does not show that: a quadruped's.
const USUAL: f64 = 0.5;
/// The floor is looked for so far below the base, metres, in slices of this, and within this range.
const BELOW: (f64, f64) = (0.15, 2.45);
const SLICE: f64 = 0.1;
const AROUND: f64 = 8.0;
/// It is where most points are, if they are as many, and such a share of those around.
const FLOOR_POINTS: usize = 20;
const FLOOR_SHARE: f64 = 0.05;
/// Keyframes of one level lie within this of its first one, metres.
const LEVEL: f64 = 1.0;
/// Spots are the middles of cells so near to a keyframe, metres.
const NEAR: f64 = 5.0;
/// Headings tried.
const HEADINGS: usize = 72;
/// The outline's points are within this range, metres, and so many at most.
const RANGE: (f64, f64) = (0.8, 15.0);
const POINTS: usize = 120;
/// Of two poses as near as that, metres and radians, a fit from the better one finds what the other would.
const BESIDE: (f64, f64) = (0.85, 0.2);
/// Spots that do not cover so many of the first of them are given up.
const FIRST: usize = 24;
const HOPEFUL: u8 = 12;

/// The levels of a map.
#[derive(Clone, Debug, Default)]
pub(crate) struct CorrelativeMatcher(Vec<Level>);

#[derive(Clone, Debug)]
struct Level {
    /// Of the floor.
    floor: f64,
    /// Cells in which something stands, or beside which.
    stands: BitGrid,
    /// Cells where the robot may be.
    spots: BitGrid,
}

/// A heading at a spot of a level.
#[derive(Clone, Copy, Debug)]
struct ScoredCell {
    /// Points of the outline that something covers.
    covered: u8,
    heading: u8,
    level: u16,
    spot: [i32; 2],
}

/// A pose of the base that covers much.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MatchCandidate {
    pub map_from_base: Isometry,
}

impl CorrelativeMatcher {
    /// Of a known map. Linear in its points.
    pub fn new(guide: &LocalisationMap) -> Self {
        let mut order: Vec<&Isometry> = guide.keyframes().iter().map(|(pose, _)| pose).collect();
        order.sort_by(|a, b| a.translation.z.total_cmp(&b.translation.z));
        let mut heights: Vec<f64> = Vec::new();
        for pose in order {
            if heights.last().is_none_or(|height| pose.translation.z - height > LEVEL) {
                heights.push(pose.translation.z);
            }
        }
        Self(heights.iter().filter_map(|height| Level::new(guide, *height)).collect())
    }

    /// Poses of a base that is turned like `level_from_base` but for its heading and sees `points` (base frame, metres), the best
    /// first and none beside another. Linear in the area walked: some millisecond for 100 m².
    pub fn search(
        &self,
        points: &[[f32; 3]],
        level_from_base: &Rotation,
        most: usize,
    ) -> Vec<MatchCandidate> {
        let over_floor = over_floor(points, level_from_base).unwrap_or(USUAL);
        let outline = outline(points, level_from_base, over_floor);
        if outline.len() < FIRST {
            return Vec::new();
        }
        // From the middle of the base's cell.
        let steps = |metres: f64| (metres / CELL + 0.5).floor() as i64;
        let turned: Vec<Vec<[i64; 2]>> = (0..HEADINGS)
            .map(|heading| {
                let (sin, cos) = angle(heading).sin_cos();
                outline.iter().map(|[x, y]| [cos * x - sin * y, sin * x + cos * y].map(steps)).collect()
            })
            .collect();
        let mut laid = Vec::new();
        for (number, level) in self.0.iter().enumerate() {
            level.lay(number as u16, &turned, &mut laid);
        }
        // Stable: of equals the first.
        laid.sort_by_key(|one| Reverse(one.covered));
        apart(
            laid.iter().map(|one| {
                let [x, y] = one.spot.map(|cell| middle(i64::from(cell)));
                let place = Translation3::new(x, y, self.0[usize::from(one.level)].floor + over_floor);
                let turn = so3::exp(&(Vector3::z() * angle(usize::from(one.heading)))) * level_from_base;
                MatchCandidate { map_from_base: Isometry::from_parts(place, turn) }
            }),
            most,
        )
    }
}

/// The first ones that are no neighbours of those before: what stands close would else take all that is looked at.
fn apart(all: impl IntoIterator<Item = MatchCandidate>, most: usize) -> Vec<MatchCandidate> {
    let mut chosen: Vec<MatchCandidate> = Vec::new();
    for one in all {
        if chosen.len() == most {
            break;
        }
        if !chosen.iter().any(|other| one.is_beside(other)) {
            chosen.push(one);
        }
    }
    chosen
}

impl MatchCandidate {
    fn is_beside(&self, other: &Self) -> bool {
        let [a, b] = [self, other].map(|cover| &cover.map_from_base);
        (a.translation.vector - b.translation.vector).norm() <= BESIDE.0
            && a.rotation.angle_to(&b.rotation) <= BESIDE.1
    }
}

impl Level {
    fn new(guide: &LocalisationMap, height: f64) -> Option<Self> {
        let own = |pose: &Isometry| (0.0..=LEVEL).contains(&(pose.translation.z - height));
        let mut stands: Vec<[i64; 2]> = Vec::new();
        let mut floors: Vec<f64> = Vec::new();
        for (pose, place) in guide.keyframes().iter().filter(|(pose, _)| own(pose)) {
            let points: Vec<[f32; 3]> = place.points().collect();
            let seen = over_floor(&points, &pose.rotation);
            floors.extend(seen.map(|over_floor| pose.translation.z - over_floor));
            let turn = pose.rotation.to_rotation_matrix();
            for point in points {
                let offset = turn * Vector3::from(point.map(f64::from));
                if (BAND.0..=BAND.1).contains(&(offset.z + seen.unwrap_or(USUAL))) {
                    let at = offset + pose.translation.vector;
                    stands.push([at.x, at.y].map(cell));
                }
            }
        }
        floors.sort_by(f64::total_cmp);
        let floor = floors.get(floors.len() / 2).copied().unwrap_or(height - USUAL);
        if stands.is_empty() {
            return None;
        }
        let beside =
            |at: [i64; 2]| [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)].map(|(x, y)| [at[0] + x, at[1] + y]);
        stands.sort_unstable();
        stands.dedup();
        let stands = BitGrid::of(&stands.into_iter().flat_map(beside).collect::<Vec<_>>());
        let near: Vec<Vector3> = guide
            .keyframes()
            .iter()
            .map(|(pose, _)| pose.translation.vector)
            .filter(|at| (at.z - height).abs() <= LEVEL)
            .collect();
        Some(Self { floor, stands, spots: BitGrid::of(&spots(&near)) })
    }

    /// Lays an outline over every spot in every heading, and notes the two headings at each that cover most, as far as any is worth it,
    /// apart from each other.
    fn lay(&self, level: u16, turned: &[Vec<[i64; 2]>], laid: &mut Vec<ScoredCell>) {
        for ([x, y], spots) in self.spots.words() {
            let mut best = [Best::default(); 64];
            for (heading, outline) in turned.iter().enumerate() {
                let (first, rest) = outline.split_at(FIRST.min(outline.len()));
                let mut counts = BitCounters::default();
                first.iter().for_each(|at| counts.add(self.stands.run([x + at[0], y + at[1]])));
                let hopeful = counts.at_least(HOPEFUL) & spots;
                if hopeful != 0 {
                    rest.iter().for_each(|at| counts.add(self.stands.run([x + at[0], y + at[1]])));
                    each(hopeful).for_each(|bit| best[bit as usize].note(counts.get(bit), heading as u8));
                }
            }
            for bit in each(spots) {
                let spot = [x as i32, y as i32 + bit as i32];
                let of = |(covered, heading)| ScoredCell { covered, heading, level, spot };
                laid.extend(best[bit as usize].0.into_iter().flatten().map(of));
            }
        }
    }
}

/// The two headings that cover most, with how many points, apart from each other.
#[derive(Clone, Copy, Debug, Default)]
struct Best([Option<(u8, u8)>; 2]);

impl Best {
    fn note(&mut self, covered: u8, heading: u8) {
        let beats = |held: Option<(u8, u8)>| held.is_none_or(|(other, _)| covered > other);
        let beside = self.0[0].is_some_and(|(_, other)| {
            let apart = usize::from(heading.abs_diff(other));
            apart.min(HEADINGS - apart) <= HEADINGS / 12
        });
        if beats(self.0[0]) {
            if !beside {
                self.0[1] = self.0[0];
            }
            self.0[0] = Some((covered, heading));
        } else if !beside && beats(self.0[1]) {
            self.0[1] = Some((covered, heading));
        }
    }
}

/// How high a base stands over the floor that its scan shows, metres: the height at which most points are below it.
fn over_floor(points: &[[f32; 3]], level_from_base: &Rotation) -> Option<f64> {
    let turn = level_from_base.to_rotation_matrix();
    let near = points
        .iter()
        .map(|point| turn * Vector3::from(point.map(f64::from)))
        .filter(|at| (RANGE.0..=AROUND).contains(&at.xy().norm()));
    let mut around = 0_usize;
    let mut slices = [0_usize; ((BELOW.1 - BELOW.0) / SLICE) as usize + 1];
    let mut depths = Vec::new();
    for at in near {
        around += 1;
        let slice = (-at.z - BELOW.0) / SLICE;
        if slice >= 0.0 && (slice as usize) < slices.len() {
            slices[slice as usize] += 1;
            depths.push(-at.z);
        }
    }
    let fullest = (0..slices.len()).rev().max_by_key(|slice| slices[*slice])?;
    if slices[fullest] < FLOOR_POINTS || (slices[fullest] as f64) < FLOOR_SHARE * around as f64 {
        return None;
    }
    // A floor may lie on the edge between two slices.
    let middle = BELOW.0 + (fullest as f64 + 0.5) * SLICE;
    depths.retain(|depth| (depth - middle).abs() <= SLICE);
    Some(depths.iter().sum::<f64>() / depths.len() as f64)
}

/// Where the points of a scan stand about its base, level, metres: one for each cell, spread evenly.
fn outline(points: &[[f32; 3]], level_from_base: &Rotation, over_floor: f64) -> Vec<[f64; 2]> {
    let turn = level_from_base.to_rotation_matrix();
    let mut cells: Vec<[i64; 2]> = points
        .iter()
        .map(|point| turn * Vector3::from(point.map(f64::from)))
        .filter(|at| {
            (BAND.0..=BAND.1).contains(&(at.z + over_floor)) && (RANGE.0..=RANGE.1).contains(&at.xy().norm())
        })
        .map(|at| [at.x, at.y].map(cell))
        .collect();
    cells.sort_unstable();
    cells.dedup();
    // A stride by a prime mixes near and far, so that the first few already speak for all.
    let count = cells.len();
    let kept = count.min(POINTS);
    (0..kept).map(|index| cells[(index * 7919) % count.max(1)].map(middle)).collect()
}

/// Cells that are near to one of these.
fn spots(near: &[Vector3]) -> Vec<[i64; 2]> {
    let reach = (NEAR / CELL).ceil() as i64;
    let mut spots: Vec<[i64; 2]> = Vec::new();
    for at in near {
        let [x, y] = [at.x, at.y].map(cell);
        for dx in -reach..=reach {
            for dy in -reach..=reach {
                if ((dx * dx + dy * dy) as f64).sqrt() * CELL <= NEAR {
                    spots.push([x + dx, y + dy]);
                }
            }
        }
    }
    spots.sort_unstable();
    spots.dedup();
    spots
}

/// Of a cell, metres.
fn middle(cell: i64) -> f64 {
    (cell as f64 + 0.5) * CELL
}

fn cell(metres: f64) -> i64 {
    (metres / CELL).floor() as i64
}

fn angle(heading: usize) -> f64 {
    heading as f64 * TAU / HEADINGS as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// A floor so far below, a table over a part of it, and a wall.
    fn room(below: f32) -> Vec<[f32; 3]> {
        let grid = |from: i32, to: i32| (from..to).flat_map(move |x| (from..to).map(move |y| [x, y]));
        let mut points: Vec<[f32; 3]> =
            grid(-20, 20).map(|[x, y]| [0.2 * x as f32, 0.2 * y as f32, -below]).collect();
        points.extend(grid(8, 14).map(|[x, y]| [0.2 * x as f32, 0.2 * y as f32, 0.75 - below]));
        points.extend(grid(0, 25).map(|[y, z]| [4.0, 0.1 * y as f32, 0.1 * z as f32 - below]));
        points
    }

    #[test]
    fn the_floor_is_where_a_scan_shows_it_whoever_carries_the_lidar() {
        for below in [0.3_f32, 0.55, 1.4] {
            let Some(found) = over_floor(&room(below), &Rotation::identity()) else { panic!("it is there") };
            assert!((found - f64::from(below)).abs() < 0.05, "{found} of {below}");
            let turn = so3::exp(&Vector3::new(0.3, -0.2, 1.0));
            let tilted: Vec<[f32; 3]> = room(below)
                .iter()
                .map(|point| (turn.inverse() * Vector3::from(point.map(f64::from))).map(|c| c as f32).into())
                .collect();
            let Some(again) = over_floor(&tilted, &turn) else { panic!("it is there") };
            assert!((again - found).abs() < 1e-3, "{again} {found}");
        }
        assert_eq!(over_floor(&[], &Rotation::identity()), None);
        let wall: Vec<[f32; 3]> = (0..200).map(|i| [4.0, 0.02 * i as f32, 0.01 * i as f32]).collect();
        assert_eq!(over_floor(&wall, &Rotation::identity()), None);
    }

    #[test]
    fn laying_an_outline_counts_what_it_covers() {
        let mut rng = geometry::RngTree::new(6).child("outline").rng();
        let mut cells = |count: usize, reach: f64| -> Vec<[i64; 2]> {
            (0..count).map(|_| [rng.range(-reach, reach) as i64, rng.range(-reach, reach) as i64]).collect()
        };
        let (stands, spots) = (cells(6_000, 50.0), cells(300, 40.0));
        let turned: Vec<Vec<[i64; 2]>> = (0..HEADINGS).map(|_| cells(100, 20.0)).collect();
        let level = Level { floor: 0.0, stands: BitGrid::of(&stands), spots: BitGrid::of(&spots) };
        let mut laid = Vec::new();
        level.lay(2, &turned, &mut laid);

        let [stands, spots] = [stands, spots].map(|cells| cells.into_iter().collect::<BTreeSet<_>>());
        let mut slow = Vec::new();
        for spot in spots {
            let mut best = Best::default();
            for (heading, outline) in turned.iter().enumerate() {
                let covers = |points: &[[i64; 2]]| {
                    points.iter().filter(|at| stands.contains(&[spot[0] + at[0], spot[1] + at[1]])).count()
                };
                if covers(&outline[..FIRST]) >= usize::from(HOPEFUL) {
                    best.note(covers(outline) as u8, heading as u8);
                }
            }
            slow.extend(best.0.into_iter().flatten().map(|(covered, heading)| (covered, heading, spot)));
        }
        let fast = laid.iter().map(|one| (one.covered, one.heading, one.spot.map(i64::from)));
        assert!(slow.len() > 100 && laid.iter().all(|one| one.level == 2));
        assert_eq!(fast.collect::<Vec<_>>(), slow);
    }

    #[test]
    fn neighbours_do_not_crowd_out_what_is_elsewhere() {
        let cover = |x: f64, yaw: f64| {
            let turn = so3::exp(&(Vector3::z() * yaw));
            MatchCandidate { map_from_base: Isometry::from_parts(Translation3::new(x, 0.0, 0.0), turn) }
        };
        let mut all: Vec<MatchCandidate> = (0..50).map(|step| cover(0.01 * f64::from(step), 0.0)).collect();
        all.extend([cover(0.0, 1.0), cover(3.0, 0.0), cover(6.0, 0.0)]);
        let places: Vec<(f64, f64)> = apart(all, 3)
            .iter()
            .map(|cover| {
                (cover.map_from_base.translation.x, so3::log(&cover.map_from_base.rotation).z.round())
            })
            .collect();
        assert_eq!(places, [(0.0, 0.0), (0.0, 1.0), (3.0, 0.0)]);
    }
}
