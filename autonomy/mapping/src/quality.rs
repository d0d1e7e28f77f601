//! How good a map is while it is made: what of the floor was seen from near, where nobody has walked yet, and how well each keyframe
//! is known.
//!
//! Every keyframe says which square metres of floor it saw, and from how far. Floor that was only ever seen from afar, through a door
//! or across a yard, is where to walk next. Keyframes that the edges of the graph know only vaguely are where to walk again, best by
//! coming back to a place that is known well.

use crate::LoopFinder;
use crate::submap::KeyframeCloud;
use geometry::{Isometry, Rotation, Vector3};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use vocab::KeyframeId;

/// Edge of a cell of floor, metres.
const CELL: f64 = 1.0;
/// Floors lie farther above each other than this, metres.
const LEVEL: f64 = 1.5;
/// Floor seen from this near is covered, metres: a spinning LiDAR's rings are a step apart there.
const NEAR: f64 = 6.0;
/// Floor is looked for so far away, metres.
const REACH: f64 = 15.0;
/// The floor's height is read off points between these ranges, metres, in slices of this height, of which two together hold
/// this share of those points at least.
const HEIGHT_RANGE: (f64, f64) = (1.0, 5.0);
const HEIGHT_SLICE: f64 = 0.1;
const HEIGHT_SHARE: f64 = 0.06;
/// Points so near to that height are floor: metres, and a share of their range.
const FLAT: (f64, f64) = (0.15, 0.02);
/// Cells of a place that nobody has walked to lie no farther apart than so many cells, and are so many at least: a small room.
const GAP: i32 = 2;
const ROOM: usize = 10;
/// A place is walked to where most of it lies within so many cells.
const ABOUT: i32 = 4;
/// Cells of a place asked at most how much of it is about them.
const ASKED: usize = 300;
/// Keyframes known worse than this are worth another visit, metres.
const UNSURE: f64 = 0.3;
/// A keyframe that moves farther than this takes its floor along, metres.
const MOVED: f64 = 0.5;
/// Places named at most, of either kind.
const PLACES: usize = 6;

/// What is known of a map's quality.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapQuality {
    /// Floor seen from near, square metres.
    pub covered: f64,
    /// Floor seen from afar only, square metres.
    pub from_afar: f64,
    /// Of each keyframe, how far it may be off as seen from the first one: one standard deviation, metres.
    pub deviations: Vec<f32>,
    /// Where to walk, or walk again; those seen from afar first, the largest of each kind first.
    pub places: Vec<SurveyTarget>,
}

/// A place worth walking to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurveyTarget {
    /// On the floor, map frame, metres.
    pub at: Vector3,
    /// Why.
    pub why: SurveyReason,
}

/// Why a place is worth walking to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SurveyReason {
    /// So much of the floor about it was seen from afar only, square metres.
    FromAfar(f64),
    /// The keyframes about it are known so vaguely, metres.
    Unsure(f64),
}

/// Column, row and floor of a cell.
type Cell = [i32; 3];

/// The floor of a map, cell by cell, as its keyframes saw it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Coverage {
    /// How it was seen from nearest: range and height, metres.
    cells: BTreeMap<Cell, (f64, f64)>,
    /// Where each keyframe was when its floor was taken in.
    taken: Vec<Isometry>,
    /// Of the first floor seen.
    ground: Option<f64>,
}

impl Coverage {
    /// Takes in the floor of new keyframes, and of all if one has moved. `floor`: that of a keyframe, its own frame.
    fn follow(&mut self, poses: &[Isometry], floor: impl Fn(usize) -> Vec<Vector3>) {
        let shift = |(a, b): (&Isometry, &Isometry)| (a.translation.vector - b.translation.vector).norm();
        if poses.len() < self.taken.len() || self.taken.iter().zip(poses).any(|pair| shift(pair) > MOVED) {
            *self = Self::default();
        }
        for index in self.taken.len()..poses.len() {
            for seen in floor(index) {
                let range = seen.xy().norm();
                let at = poses[index] * nalgebra::Point3::from(seen);
                let ground = *self.ground.get_or_insert(at.z);
                let level = ((at.z - ground) / LEVEL).round() as i32;
                let cell = [(at.x / CELL).floor() as i32, (at.y / CELL).floor() as i32, level];
                let nearest = self.cells.entry(cell).or_insert((range, at.z));
                if range < nearest.0 {
                    *nearest = (range, at.z);
                }
            }
            self.taken.push(poses[index]);
        }
    }

    /// Square metres seen from near and from afar only.
    fn areas(&self) -> (f64, f64) {
        let near = self.cells.values().filter(|(range, _)| *range <= NEAR).count() as f64;
        (near * CELL * CELL, (self.cells.len() as f64 - near) * CELL * CELL)
    }

    /// Places that were seen from afar only, the largest first.
    fn unvisited(&self) -> Vec<SurveyTarget> {
        let mut far: BTreeSet<Cell> =
            self.cells.iter().filter(|(_, (range, _))| *range > NEAR).map(|(cell, _)| *cell).collect();
        let mut places = Vec::new();
        while let Some(first) = far.pop_first() {
            let (mut place, mut waiting) = (Vec::new(), VecDeque::from([first]));
            while let Some(cell) = waiting.pop_front() {
                place.push(cell);
                for near in neighbours(cell, GAP) {
                    if far.remove(&near) {
                        waiting.push_back(near);
                    }
                }
            }
            if place.len() >= ROOM {
                places.push(place);
            }
        }
        // Of equals the first.
        places.sort_by_key(|place| std::cmp::Reverse(place.len()));
        places.truncate(PLACES);
        let named = places.iter().map(|place| SurveyTarget {
            at: self.middle(place),
            why: SurveyReason::FromAfar(place.len() as f64 * CELL * CELL),
        });
        named.collect()
    }

    /// That cell of a place which has most of it about it: a place may lie round what was walked, and its mean in the middle of
    /// that. Of equals the one nearest to the mean.
    fn middle(&self, place: &[Cell]) -> Vector3 {
        let at = |cell: &Cell| {
            let height = self.cells.get(cell).map_or(0.0, |(_, height)| *height);
            Vector3::new((f64::from(cell[0]) + 0.5) * CELL, (f64::from(cell[1]) + 0.5) * CELL, height)
        };
        let mean = place.iter().map(at).sum::<Vector3>() / place.len() as f64;
        let all: BTreeSet<&Cell> = place.iter().collect();
        let about = |cell: &Cell| neighbours(*cell, ABOUT).filter(|near| all.contains(near)).count();
        // A few hundred of them tell as well.
        let asked = place.iter().step_by(place.len().div_ceil(ASKED));
        let most = asked.map(|cell| (about(cell), at(cell))).max_by(|(a, here), (b, there)| {
            a.cmp(b).then((there - mean).norm().total_cmp(&(here - mean).norm()))
        });
        most.map_or(mean, |(_, at)| at)
    }
}

impl LoopFinder {
    /// How good the map is whose keyframes are at `poses`. Costs a search of the graph and a look at every cell of floor; a pass
    /// over the points of new keyframes, and of all where the map has moved.
    pub fn quality(&mut self, poses: &[Isometry]) -> MapQuality {
        let known = poses.len().min(self.clouds.len());
        let Self { coverage, clouds, levels, .. } = self;
        coverage.follow(&poses[..known], |index| floor(&clouds[index], &levels[index]));
        let reach = self.consistency().reach(KeyframeId(0));
        let deviations: Vec<f64> =
            reach.iter().map(|way| way.map_or(f64::INFINITY, |way| way.translation_std_m())).collect();
        let (covered, from_afar) = self.coverage.areas();
        let mut places = self.coverage.unvisited();
        places.extend(unsure(&deviations, &poses[..known]));
        let deviations = deviations.into_iter().map(|deviation| deviation as f32).collect();
        MapQuality { covered, from_afar, deviations, places }
    }
}

/// The floor that a keyframe saw, a point for each cell, its own frame. Empty where none is to be made out.
fn floor(cloud: &KeyframeCloud, level_from_base: &Rotation) -> Vec<Vector3> {
    let base_from_level = level_from_base.inverse();
    let points: Vec<Vector3> =
        cloud.points().map(|point| level_from_base * Vector3::from(point.map(f64::from))).collect();
    let Some(height) = floor_height(&points) else { return Vec::new() };
    let mut cells: BTreeMap<[i32; 2], Vector3> = BTreeMap::new();
    for point in &points {
        let range = point.xy().norm();
        if range <= REACH && (point.z - height).abs() <= FLAT.0 + FLAT.1 * range {
            let cell = [(point.x / CELL).floor() as i32, (point.y / CELL).floor() as i32];
            cells.entry(cell).or_insert(*point);
        }
    }
    cells.into_values().map(|point| base_from_level * point).collect()
}

/// The lowest height at which a good share of what is near lies.
fn floor_height(levelled: &[Vector3]) -> Option<f64> {
    let mut slices: BTreeMap<i32, usize> = BTreeMap::new();
    let near = |point: &&Vector3| (HEIGHT_RANGE.0..HEIGHT_RANGE.1).contains(&point.xy().norm());
    for point in levelled.iter().filter(near) {
        *slices.entry((point.z / HEIGHT_SLICE).floor() as i32).or_default() += 1;
    }
    let least = HEIGHT_SHARE * slices.values().sum::<usize>() as f64;
    let found = slices.iter().find(|(slice, count)| {
        (**count + slices.get(&(**slice + 1)).copied().unwrap_or(0)) as f64 >= least.max(1.0)
    });
    found.map(|(slice, _)| f64::from(slice + 1) * HEIGHT_SLICE)
}

fn neighbours([x, y, level]: Cell, reach: i32) -> impl Iterator<Item = Cell> {
    (-reach..=reach).flat_map(move |dx| (-reach..=reach).map(move |dy| [x + dx, y + dy, level]))
}

/// Of each stretch of keyframes that are known vaguely the worst, the worst first.
fn unsure(deviations: &[f64], poses: &[Isometry]) -> Vec<SurveyTarget> {
    let mut worst: Vec<(usize, f64)> = Vec::new();
    let mut last = None;
    for (index, deviation) in deviations.iter().copied().enumerate().take(poses.len()) {
        if deviation <= UNSURE || !deviation.is_finite() {
            continue;
        }
        match worst.last_mut() {
            Some(held) if last == index.checked_sub(1) => {
                if deviation > held.1 {
                    *held = (index, deviation);
                }
            }
            _ => worst.push((index, deviation)),
        }
        last = Some(index);
    }
    worst.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    worst.truncate(PLACES);
    let place = |(index, deviation): (usize, f64)| SurveyTarget {
        at: poses[index].translation.vector,
        why: SurveyReason::Unsure(deviation),
    };
    worst.into_iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{SENSOR, World, at, edge, room, scan};
    use crate::{LoopConfig, NewKeyframe};

    /// Two rooms of 12 m by 8 m with a door between them, floor at z = -0.5.
    fn rooms() -> World {
        let mut world = room([-12.0, -4.0], [12.0, 4.0]);
        world.push([[-0.1, -4.0, -0.5], [0.1, -1.5, 2.5]]);
        world.push([[-0.1, 1.5, -0.5], [0.1, 4.0, 2.5]]);
        world
    }

    fn walked(world: &World, poses: &[Isometry], deviation: f64) -> LoopFinder {
        let mut finder = LoopFinder::new(LoopConfig::default());
        let mut last: Option<Isometry> = None;
        for (number, pose) in (0_u32..).zip(poses) {
            let way = last.map(|last| {
                edge(number - 1, number, last.inverse() * pose, (1e-3 * deviation, 0.01 * deviation))
            });
            let xyz = scan(world, pose, u64::from(number));
            let new = NewKeyframe { edge: way.as_ref(), rotation: pose.rotation, xyz: &xyz, sensor: SENSOR };
            finder.add_keyframe(&new);
            last = Some(*pose);
        }
        finder
    }

    #[test]
    fn a_room_seen_through_its_door_is_where_to_walk() {
        let world = rooms();
        let walk: Vec<Isometry> = (0..6).map(|x| at(f64::from(x) * 1.5 - 10.5, 0.0, 0.0)).collect();
        let mut finder = walked(&world, &walk, 1.0);
        let quality = finder.quality(&walk);
        // 12 m by 8 m, and some more through the door.
        assert!((75.0..150.0).contains(&quality.covered), "{quality:?}");
        let [place] = quality.places[..] else { panic!("{quality:?}") };
        assert!(
            matches!(place.why, SurveyReason::FromAfar(area) if area >= 10.0 && area <= quality.from_afar)
        );
        assert!(place.at.x > 2.0 && (place.at.z + 0.5).abs() < 0.1, "{place:?}");

        // Walked to: nothing is left, and little is known worse.
        let mut on = walk.clone();
        on.extend((1..9).map(|x| at(f64::from(x) * 1.3 - 1.0, 0.0, 0.0)));
        let mut finder = walked(&world, &on, 1.0);
        let quality = finder.quality(&on);
        assert_eq!(quality.places, []);
        assert!(quality.covered > 150.0 && quality.from_afar < 10.0, "{quality:?}");
        assert_eq!(quality.deviations.len(), on.len());
        assert!(quality.deviations.windows(2).all(|pair| pair[0] <= pair[1]));
    }

    #[test]
    fn what_is_known_vaguely_is_where_to_walk_again() {
        let world = rooms();
        let walk: Vec<Isometry> = (0..8).map(|x| at(f64::from(x) * 1.2 - 10.0, 0.0, 0.0)).collect();
        let quality = walked(&world, &walk, 40.0).quality(&walk);
        let unsure: Vec<&SurveyTarget> =
            quality.places.iter().filter(|place| matches!(place.why, SurveyReason::Unsure(_))).collect();
        let [place] = unsure[..] else { panic!("{quality:?}") };
        assert!((place.at - walk[7].translation.vector).norm() < 1e-9, "{place:?}");
    }

    #[test]
    fn the_floor_moves_along_with_the_map() {
        let world = rooms();
        let walk: Vec<Isometry> = (0..4).map(|x| at(f64::from(x) - 8.0, 0.0, 0.0)).collect();
        let mut finder = walked(&world, &walk, 1.0);
        let before = finder.quality(&walk);
        let moved: Vec<Isometry> = walk.iter().map(|pose| at(0.0, 30.0, 0.0) * pose).collect();
        let after = finder.quality(&moved);
        assert!((before.covered - after.covered).abs() <= 4.0, "{before:?} {after:?}");
        let fresh = walked(&world, &walk, 1.0).quality(&moved);
        assert_eq!(after, fresh);
        assert_eq!(LoopFinder::new(LoopConfig::default()).quality(&[]), MapQuality::default());
    }
}
