//! What a robot would see from where it could stand in somebody else's cloud: the keyframes of a map that no robot has walked.
//!
//! A cloud without the places it was seen from cannot say what is free and what hides what, which is half of what localisation lives
//! on. So the ground is found ([`crate::ground_surface`]), places to stand are spread over it, and from each only those points are kept that
//! are nearest in their direction, in a picture of depth in which near points cover as much as they would as surfaces. After Katz, Tal
//! and Basri, *Direct visibility of point sets*, SIGGRAPH 2007, whose question this is; theirs is another answer.

use crate::ground_surface::{COLUMN, Floors, Foot, on_ground};
use geometry::{Isometry, Rotation, Vector3};
use std::collections::BTreeMap;

/// Edge of a pixel of the picture of depth, radians.
const PIXEL: f32 = 0.026;
/// A point covers so much, metres: neighbours of a thinned cloud are nearly as far apart.
const COVERS: f32 = 0.08;
/// Near points cover so many pixels at most, each way.
const COVERS_MAX: i32 = 8;
/// What is so much farther than the nearest in its direction is hidden: metres, and metres for each metre of distance.
const BEHIND: (f32, f32) = (0.2, 0.04);
/// Points are looked up in squares of this edge, metres.
const BLOCK: f32 = 5.0;
/// An up axis has to have so many times as much ground as z to be believed.
const CLEARLY: f64 = 1.5;

/// How to look about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewpointConfig {
    /// Places are so far apart at least, metres.
    pub spacing: f32,
    /// Height of the base over the ground, metres.
    pub base_height: f32,
    /// Height of the LiDAR over the base, metres.
    pub lidar_height: f32,
    /// How far it sees, metres.
    pub reach: f32,
    /// How far down and up it sees, radians from level.
    pub field: [f32; 2],
}

impl Default for ViewpointConfig {
    /// A quadruped with an XT-32.
    fn default() -> Self {
        let field = [-16.0_f32, 15.0].map(f32::to_radians);
        Self { spacing: 1.5, base_height: 0.5, lidar_height: 0.3, reach: 30.0, field }
    }
}

/// A place to stand at.
#[derive(Clone, Debug, PartialEq)]
pub struct VirtualViewpoint {
    /// Level, heading along x.
    pub map_from_base: Isometry,
    /// Which points are seen from there.
    pub seen: Vec<u32>,
}

/// Places to stand at, and straight ways between neighbours among them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VirtualViewpoints {
    /// In a fixed order.
    pub places: Vec<VirtualViewpoint>,
    /// Pairs of places, the smaller number first.
    pub ways: Vec<[usize; 2]>,
}

/// An axis of a cloud.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the axes")]
pub enum Axis {
    X,
    Y,
    Z,
}

/// Which axis points up (or down): the one across which most ground hangs together, z if in doubt. Thrice the cost of finding the ground.
pub fn find_up_axis(xyz: &[[f32; 3]]) -> Axis {
    let ground = |turn: fn(&[f32; 3]) -> [f32; 3]| {
        let turned: Vec<[f32; 3]> = xyz.iter().map(turn).collect();
        Floors::find(&turned).largest() as f64
    };
    let [x, y, z] =
        [ground(|[x, y, z]| [*y, *z, *x]), ground(|[x, y, z]| [*x, -*z, *y]), ground(|point| *point)];
    match (x > CLEARLY * z, y > CLEARLY * z) {
        (true, _) if x > y => Axis::X,
        (_, true) => Axis::Y,
        _ => Axis::Z,
    }
}

/// Finds places to stand at in a thinned cloud (some 0.1 m between points, z up) and what is seen from each: some thousands of points,
/// all held at once. Linear in places times the points within reach; `progress` hears the share of places done.
pub fn find_viewpoints(
    xyz: &[[f32; 3]],
    options: &ViewpointConfig,
    progress: &mut dyn FnMut(f64),
) -> VirtualViewpoints {
    let floors = Floors::find(xyz);
    let feet = spread(&floors, options.spacing);
    let blocks = Blocks::new(xyz);
    let mut picture = Picture::new(options.field);
    let mut places = Vec::with_capacity(feet.len());
    for (index, foot) in feet.iter().enumerate() {
        let [x, y, ground] = on_ground(*foot);
        let base = [x, y, ground + options.base_height];
        let eye = [x, y, base[2] + options.lidar_height];
        let seen = picture.seen(xyz, &blocks, eye, options.reach);
        let place = Vector3::from(base.map(f64::from));
        places.push(VirtualViewpoint {
            map_from_base: Isometry::from_parts(place.into(), Rotation::identity()),
            seen,
        });
        progress((index + 1) as f64 / feet.len() as f64);
    }
    VirtualViewpoints { places, ways: ways(&floors, &feet, options.spacing) }
}

/// Places so far apart, those with much room about them first.
fn spread(floors: &Floors, spacing: f32) -> Vec<Foot> {
    let mut waiting: Vec<(usize, Foot)> = floors.feet().map(|foot| (floors.room(foot), foot)).collect();
    waiting.sort_by_key(|(room, foot)| (std::cmp::Reverse(*room), *foot));
    let mut chosen = Vec::new();
    let mut near: BTreeMap<(i32, i32), Vec<Foot>> = BTreeMap::new();
    let square = |foot: &Foot| [foot.0, foot.1].map(|c| (c as f32 * COLUMN / spacing).floor() as i32);
    for (_, foot) in waiting {
        let [i, j] = square(&foot);
        let taken = (i - 1..=i + 1).flat_map(|i| (j - 1..=j + 1).map(move |j| (i, j))).any(|at| {
            near.get(&at).is_some_and(|others| others.iter().any(|other| distance(&foot, other) < spacing))
        });
        if !taken {
            near.entry((i, j)).or_default().push(foot);
            chosen.push(foot);
        }
    }
    chosen.sort_unstable();
    chosen
}

fn distance(a: &Foot, b: &Foot) -> f32 {
    let ([ax, ay, az], [bx, by, bz]) = (on_ground(*a), on_ground(*b));
    ((ax - bx).powi(2) + (ay - by).powi(2) + (az - bz).powi(2)).sqrt()
}

/// Neighbours with ground all the way between them.
fn ways(floors: &Floors, feet: &[Foot], spacing: f32) -> Vec<[usize; 2]> {
    let reach = 2.0 * spacing;
    let square = |foot: &Foot| [foot.0, foot.1].map(|c| (c as f32 * COLUMN / reach).floor() as i32);
    let mut squares: BTreeMap<[i32; 2], Vec<usize>> = BTreeMap::new();
    for (index, foot) in feet.iter().enumerate() {
        squares.entry(square(foot)).or_default().push(index);
    }
    let mut ways = Vec::new();
    for (first, a) in feet.iter().enumerate() {
        let [i, j] = square(a);
        let near = (i - 1..=i + 1).flat_map(|i| (j - 1..=j + 1).map(move |j| [i, j]));
        let others = near.filter_map(|at| squares.get(&at)).flatten().filter(|second| **second > first);
        for &second in others {
            let b = feet[second];
            if distance(a, &b) <= reach && floors.walkable(*a, b) {
                ways.push([first, second]);
            }
        }
    }
    ways.sort_unstable();
    ways
}

/// Points by squares of the plane.
struct Blocks {
    points: BTreeMap<(i32, i32), Vec<u32>>,
}

impl Blocks {
    fn new(xyz: &[[f32; 3]]) -> Self {
        let mut points: BTreeMap<(i32, i32), Vec<u32>> = BTreeMap::new();
        for (index, [x, y, _]) in (0..).zip(xyz) {
            points.entry(((x / BLOCK).floor() as i32, (y / BLOCK).floor() as i32)).or_default().push(index);
        }
        Self { points }
    }

    /// All points in squares that are within reach.
    fn about(&self, [x, y, _]: [f32; 3], reach: f32) -> impl Iterator<Item = u32> + '_ {
        let range = move |c: f32| ((c - reach) / BLOCK).floor() as i32..=((c + reach) / BLOCK).floor() as i32;
        range(x)
            .flat_map(move |i| self.points.range((i, *range(y).start())..=(i, *range(y).end())))
            .flat_map(|(_, points)| points.iter().copied())
    }
}

/// How far the nearest point is in every direction.
struct Picture {
    /// Lowest elevation, radians.
    lowest: f32,
    width: i32,
    height: i32,
    nearest: Vec<f32>,
}

impl Picture {
    fn new([lowest, highest]: [f32; 2]) -> Self {
        let width = (std::f32::consts::TAU / PIXEL).ceil() as i32;
        let height = ((highest - lowest) / PIXEL).ceil().max(1.0) as i32;
        Self { lowest, width, height, nearest: vec![0.0; (width * height) as usize] }
    }

    /// Points that are nearest in their direction.
    fn seen(&mut self, xyz: &[[f32; 3]], blocks: &Blocks, eye: [f32; 3], reach: f32) -> Vec<u32> {
        self.nearest.fill(f32::INFINITY);
        let looks: Vec<(u32, i32, i32, f32)> = blocks
            .about(eye, reach)
            .filter_map(|index| {
                let [x, y, z] = std::array::from_fn(|axis| xyz[index as usize][axis] - eye[axis]);
                let range = (x * x + y * y + z * z).sqrt();
                let level = (x * x + y * y).sqrt();
                let row = ((z.atan2(level) - self.lowest) / PIXEL).floor() as i32;
                let inside = range <= reach && range > 0.3 && (0..self.height).contains(&row);
                let column = ((y.atan2(x) + std::f32::consts::PI) / PIXEL) as i32;
                inside.then_some((index, column.clamp(0, self.width - 1), row, range))
            })
            .collect();
        for (_, column, row, range) in &looks {
            let covers = ((COVERS / range / PIXEL) as i32).min(COVERS_MAX);
            for row in (row - covers).max(0)..=(row + covers).min(self.height - 1) {
                for column in column - covers..=column + covers {
                    let at = (row * self.width + column.rem_euclid(self.width)) as usize;
                    self.nearest[at] = self.nearest[at].min(*range);
                }
            }
        }
        let in_front = |&(index, column, row, range): &(u32, i32, i32, f32)| {
            let nearest = self.nearest[(row * self.width + column) as usize];
            (range <= nearest + BEHIND.0 + BEHIND.1 * nearest).then_some(index)
        };
        let mut seen: Vec<u32> = looks.iter().filter_map(in_front).collect();
        seen.sort_unstable();
        seen
    }
}

#[cfg(test)]
#[path = "virtual_viewpoint_tests.rs"]
mod tests;
