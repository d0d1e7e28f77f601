//! A grid of ground heights and obstacles round everywhere the robot has looked.
//!
//! 2.5-dimensional: one ground height per cell. On a site with several floors a cell forgets the other floor as soon as
//! the robot sees it again from this one. Memory: 12 bytes a cell, 1.2 kB a square metre seen.
//!
//! An obstacle is forgotten where the ground is seen in its place, and where rays go through it: people leave, and what a robot saw
//! while it was carried stands nowhere. Beside itself a robot sees no ground, so that the first is not enough.

use geometry::{Isometry, Vector3};
use nalgebra::Point3;
use points::range_image::{Occupancy, RangeImage};
use std::collections::BTreeMap;

/// Cells along a block's side; blocks are allocated whole.
const BLOCK: i32 = 64;
/// Count at which a cell is an obstacle, the most that it remembers, and what one sighting adds.
const OBSTACLE_AT: i8 = 2;
const OBSTACLE_MOST: i8 = 12;
const OBSTACLE_SEEN: i8 = 3;
/// Of obstacles it is kept in which slices of this height they were seen, metres, counted from the one that holds the ground.
const SLICE: f64 = 0.125;
/// Rays speak of what looks so thick from the robot, radians: the beams of a LiDAR are up to 2 degrees apart. What was seen in one slice
/// alone may be as thin as the second, metres, if it was seen more often than twice or so; else people who walk leave such traces.
const THICK: f64 = 0.04;
const THIN: f64 = 0.03;
const TRACE: (i8, f64) = (7, 0.12);
/// What is seen so little above the lowest beams, metres, and so much more for each metre, hangs there as far as is known: its foot is out of
/// sight.
const FOOTLESS: (f64, f64) = (0.12, 0.04);
/// Directions in which that is told apart.
const SECTORS: usize = 16;
/// Ground rises by so much at most, metres for each metre: steep stairs.
const STEEPEST: f64 = 0.9;
/// Ground that is higher than a step leads up from some that is so many cells away at most: a tread.
const BESIDE: i32 = 3;
/// Rays of a scan that are asked at most.
const RAYS: usize = 30_000;
/// Slices under the robot's feet in which something is looked for: three metres.
const BELOW: i64 = 24;
/// A ground height farther than this from what was known is another floor, metres.
const OTHER_FLOOR: f32 = 1.2;

/// What the terrain must know of the robot, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotShape {
    /// Radius of the circle that the robot turns in.
    pub radius: f64,
    /// Height of the base over the ground.
    pub standing_height: f64,
    /// Everything from the ground up to here must be free.
    pub clearance: f64,
    /// Highest step it takes.
    pub step: f64,
}

impl Default for RobotShape {
    fn default() -> Self {
        Self { radius: 0.38, standing_height: 0.55, clearance: 0.95, step: 0.22 }
    }
}

/// Index of a cell: x and y in cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CellIndex {
    /// Along x.
    pub x: i32,
    /// Along y.
    pub y: i32,
}

/// One cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Lowest surface seen, metres; NaN while unknown.
    ground: f32,
    /// Confidence that something stands here.
    obstacle: i8,
    /// In which slices over the ground it was seen, the lowest first.
    slices: u16,
    /// Obstacle cells within the robot's radius: kept up to date so that planning asks one cell only.
    near: u16,
}

const UNKNOWN: Cell = Cell { ground: f32::NAN, obstacle: 0, slices: 0, near: 0 };

impl Cell {
    /// Height of the ground, metres, if it was ever seen.
    pub fn ground(&self) -> Option<f64> {
        self.ground.is_finite().then(|| f64::from(self.ground))
    }

    /// Whether something stands here.
    pub fn is_obstacle(&self) -> bool {
        self.obstacle >= OBSTACLE_AT
    }

    /// The slices of what rays of a scan went through, the middle of the cell being so far from the robot. What was seen in neighbouring
    /// slices is one thing, and gone as a whole if a ray went through it and none met anything: its foot may be out of sight.
    fn seen_through(&self, seen: &Seen, at: [f64; 2], distance: f64) -> u16 {
        let lowest = slice(if self.ground.is_finite() { self.ground } else { seen.foot });
        let look = |edge: u32| {
            let height = (lowest + i64::from(edge)) as f64 * SLICE;
            let point = seen.base_from_map * Point3::new(at[0], at[1], height);
            seen.view.classify_interior(&point.coords.map(|c| c as f32).into())
        };
        let thin = if self.obstacle < TRACE.0 { TRACE.1 } else { THIN };
        let mut gone = 0;
        for (first, count) in runs(self.slices) {
            if THICK * distance > f64::from(count - 1) * SLICE + thin {
                continue;
            }
            // Between its slices; at its own edges there may be nothing any more.
            let mut through = false;
            let mut stands = false;
            if count == 1 {
                // Somewhere in it.
                let sights = [look(first), look(first + 1)];
                through = sights == [Occupancy::Free; 2];
            }
            for edge in first + 1..first + count {
                match look(edge) {
                    Occupancy::Free => through = true,
                    Occupancy::Occupied | Occupancy::Occluded => stands = true,
                    Occupancy::Unobserved => {}
                }
                if stands {
                    break;
                }
            }
            if through && !stands {
                gone |= ((1_u32 << (first + count)) - (1 << first)) as u16;
            }
        }
        gone
    }
}

/// The slice that holds a height, counted from zero.
fn slice(height: f32) -> i64 {
    (f64::from(height) / SLICE).floor() as i64
}

/// Slices as they are counted from a slice that is so much lower.
fn raised(slices: u16, lower: i64) -> u16 {
    let by = lower.unsigned_abs().min(15) as u32;
    if lower >= 0 { slices << by } else { slices >> by }
}

/// How many slices from the one that holds the ground there are up to so high over it.
fn slices_up_to(ground: f32, height: f32) -> i64 {
    (f64::from(ground + height) / SLICE).ceil() as i64 - slice(ground)
}

/// The slices under so high over the ground.
fn low_slices(ground: f32, height: f32) -> u16 {
    !(u16::MAX << slices_up_to(ground, height).clamp(0, 15))
}

/// Tangents of the lowest beams that met anything, by the direction in the map: a robot that leans sees the ground nearer on one side.
struct LowestBeams {
    eye: Vector3,
    /// What is nearer than this is the robot itself, metres.
    least: f64,
    tangents: [f64; SECTORS],
}

impl LowestBeams {
    fn new(eye: &Vector3, radius: f64) -> Self {
        Self { eye: *eye, least: radius + 0.1, tangents: [0.0; SECTORS] }
    }

    /// One met something there, as seen from the base's `origin` in the map's axes.
    fn met(&mut self, off: &nalgebra::Vector3<f32>, origin: &Vector3) {
        let off = off.cast::<f64>() + origin - self.eye;
        let away = off.xy().norm();
        if away > self.least {
            let tangent = &mut self.tangents[sector(off.x, off.y)];
            *tangent = tangent.min(off.z / away);
        }
    }

    /// How low the beams reach there, map's axes.
    fn height(&self, x: f64, y: f64) -> f64 {
        let (x, y) = (x - self.eye.x, y - self.eye.y);
        self.eye.z + self.tangents[sector(x, y)] * x.hypot(y)
    }
}

fn sector(x: f64, y: f64) -> usize {
    let turns = y.atan2(x) / std::f64::consts::TAU + 0.5;
    ((turns * SECTORS as f64) as usize).min(SECTORS - 1)
}

/// The first of neighbouring bits that are set, and their number.
fn runs(mut bits: u16) -> impl Iterator<Item = (u32, u32)> {
    std::iter::from_fn(move || {
        (bits != 0).then(|| {
            let first = bits.trailing_zeros();
            let count = (bits >> first).trailing_ones();
            bits &= !(((1_u32 << (first + count)) - (1 << first)) as u16);
            (first, count)
        })
    })
}

/// The grid.
#[derive(Clone, Debug)]
pub struct Terrain {
    cell_size: f64,
    shape: RobotShape,
    blocks: BTreeMap<(i32, i32), Vec<Cell>>,
    /// Reused between scans: the heights seen per cell touched.
    touched: BTreeMap<CellIndex, Touch>,
}

/// What a scan saw, from where, and the height of the ground that the robot stands on.
struct Seen {
    view: RangeImage,
    base_from_map: Isometry,
    foot: f32,
}

#[derive(Clone, Copy, Debug)]
struct Touch {
    lowest: f32,
    highest: f32,
    /// In which slices, from [`BELOW`] under the feet on.
    slices: u64,
}

impl Terrain {
    /// An empty grid of square cells of `cell_size` metres.
    pub fn new(cell_size: f64, shape: RobotShape) -> Self {
        Self { cell_size, shape, blocks: BTreeMap::new(), touched: BTreeMap::new() }
    }

    /// Side of a cell, metres.
    pub fn cell_size(&self) -> f64 {
        self.cell_size
    }

    /// The robot that it is for.
    pub fn shape(&self) -> &RobotShape {
        &self.shape
    }

    /// The cell that holds a point.
    pub fn index(&self, x: f64, y: f64) -> CellIndex {
        CellIndex { x: (x / self.cell_size).floor() as i32, y: (y / self.cell_size).floor() as i32 }
    }

    /// Middle of a cell, metres.
    pub fn centre(&self, index: CellIndex) -> (f64, f64) {
        ((f64::from(index.x) + 0.5) * self.cell_size, (f64::from(index.y) + 0.5) * self.cell_size)
    }

    /// What is known of a cell.
    pub fn cell(&self, index: CellIndex) -> Cell {
        let (block, offset) = locate(index);
        self.blocks.get(&block).map_or(UNKNOWN, |cells| cells[offset])
    }

    /// Learns from a motion-corrected scan: `points` in the base frame, metres, at `map_from_base`, seen from `sensor` (base frame). Points
    /// farther than `range` are left out. Linear in the points, with a logarithm of the cells touched, and in the ground within range.
    pub fn observe(&mut self, map_from_base: &Isometry, sensor: [f32; 3], points: &[[f32; 3]], range: f64) {
        let rotation = map_from_base.rotation.to_rotation_matrix().cast::<f32>();
        let origin = map_from_base.translation.vector;
        let foot = (origin.z - self.shape.standing_height) as f32;
        let ceiling = foot + self.shape.clearance as f32 + OTHER_FLOOR;
        let lowest = slice(foot) - BELOW;
        let eye = map_from_base * Point3::from(sensor.map(f64::from));
        let mut beams = LowestBeams::new(&eye.coords, self.shape.radius);
        let range_squared = (range * range) as f32;
        let mut touched = std::mem::take(&mut self.touched);
        touched.clear();
        for point in points {
            if point[0] * point[0] + point[1] * point[1] > range_squared {
                continue;
            }
            let turned = rotation * nalgebra_point(point);
            let z = turned[2] + origin.z as f32;
            beams.met(&turned, &origin);
            if z > ceiling || z < foot - 3.0 {
                continue;
            }
            let index = self.index(f64::from(turned[0]) + origin.x, f64::from(turned[1]) + origin.y);
            let touch = touched.entry(index).or_insert(Touch { lowest: z, highest: z, slices: 0 });
            touch.lowest = touch.lowest.min(z);
            touch.highest = touch.highest.max(z);
            touch.slices |=
                u32::try_from(slice(z) - lowest).ok().and_then(|bit| 1_u64.checked_shl(bit)).unwrap_or(0);
        }
        for (&index, touch) in &touched {
            let (x, y) = self.centre(index);
            let away = (x - origin.x).hypot(y - origin.y);
            let rise = (self.shape.step + STEEPEST * away).min(f64::from(OTHER_FLOOR)) as f32;
            let lowest = f64::from(touch.lowest);
            let footless =
                touch.lowest > foot && lowest < beams.height(x, y) + FOOTLESS.0 + FOOTLESS.1 * away;
            let rise = if footless || !self.leads_up_to(index, touch.lowest) {
                self.shape.step as f32
            } else {
                rise
            };
            self.learn(index, touch, foot, rise);
        }
        self.touched = touched;
        // Of an odd number of points one, so that all beams of a LiDAR have their turn.
        let every = points.len().div_ceil(RAYS) | 1;
        let view = RangeImage::new(points.iter().step_by(every), sensor);
        self.look_through(
            &Seen { view, base_from_map: map_from_base.inverse(), foot },
            [origin.x, origin.y],
            range,
        );
        self.stand(map_from_base, foot);
    }

    /// Whether ground next to a cell is known from which one steps up to so high: stairs are, and what hangs from somebody's shoulder is not.
    fn leads_up_to(&self, index: CellIndex, height: f32) -> bool {
        let step = self.shape.step as f32;
        let is_below = |dx: i32, dy: i32| {
            let ground = self.cell(CellIndex { x: index.x + dx, y: index.y + dy }).ground;
            (ground - step..=ground + step).contains(&height)
        };
        (-BESIDE..=BESIDE).any(|dx| (-BESIDE..=BESIDE).any(|dy| is_below(dx, dy)))
    }

    /// Doubts the obstacles within `range` of `place` that rays of a scan went through.
    fn look_through(&mut self, seen: &Seen, place: [f64; 2], range: f64) {
        let [low, high] =
            [-range, range].map(|reach| locate(self.index(place[0] + reach, place[1] + reach)).0);
        let is_about =
            |block: (i32, i32)| (low.0..=high.0).contains(&block.0) && (low.1..=high.1).contains(&block.1);
        let mut through: Vec<(CellIndex, u16)> = Vec::new();
        for (block, cells) in self.blocks.iter().filter(|(block, _)| is_about(**block)) {
            for (offset, cell) in cells.iter().enumerate().filter(|(_, cell)| cell.is_obstacle()) {
                let index = at_offset(*block, offset);
                let (x, y) = self.centre(index);
                let distance = (x - place[0]).hypot(y - place[1]);
                // What it saw in the cell itself has been taken in.
                let overhead = f64::from(seen.foot) + self.shape.clearance;
                let touched =
                    self.touched.get(&index).is_some_and(|touch| f64::from(touch.lowest) < overhead);
                if distance > range || touched {
                    continue;
                }
                let gone = cell.seen_through(seen, [x, y], distance);
                if gone != 0 {
                    through.push((index, gone));
                }
            }
        }
        for (index, gone) in through {
            let cell = self.cell_mut(index);
            let obstacle = cell.obstacle;
            if gone == cell.slices {
                self.set_obstacle(index, obstacle - 1);
            } else {
                // Something else stands there.
                cell.slices &= !gone;
            }
        }
    }

    /// The ground under the robot is known: it stands on it. The LiDAR is blind there.
    fn stand(&mut self, map_from_base: &Isometry, foot: f32) {
        let centre = map_from_base.translation.vector;
        let reach = (self.shape.radius / self.cell_size).ceil() as i32;
        let middle = self.index(centre.x, centre.y);
        for dx in -reach..=reach {
            for dy in -reach..=reach {
                if dx * dx + dy * dy <= reach * reach {
                    let index = CellIndex { x: middle.x + dx, y: middle.y + dy };
                    let cell = self.cell_mut(index);
                    if !cell.ground.is_finite() || (cell.ground - foot).abs() > OTHER_FLOOR {
                        cell.ground = foot;
                        self.set_obstacle(index, 0);
                    }
                }
            }
        }
    }

    /// Takes in what was seen of a cell, by a robot whose feet are at that height, and to which the ground rises by so much at most.
    fn learn(&mut self, index: CellIndex, touch: &Touch, foot: f32, rise: f32) {
        let (step, clearance) = (self.shape.step as f32, self.shape.clearance as f32);
        let cell = self.cell_mut(index);
        let other_floor = cell.ground.is_finite()
            && (cell.ground - touch.lowest).abs() > OTHER_FLOOR
            && (touch.lowest - foot).abs() < (cell.ground - foot).abs();
        let mut obstacle = cell.obstacle;
        if other_floor {
            cell.ground = f32::NAN;
            cell.slices = 0;
            obstacle = 0;
        }
        // Something that hangs, or a wall whose foot was not seen, says nothing of the ground.
        let mut looks_like_ground = (touch.lowest - foot).abs() < rise;
        if !looks_like_ground && touch.lowest > foot && cell.ground > touch.lowest {
            // Nor did what was taken for it: something stands lower than that.
            cell.slices = raised(cell.slices, slice(cell.ground) - slice(foot));
            cell.ground = f32::NAN;
        }
        let over_foot = (slice(touch.lowest) - slice(foot)).clamp(0, 15);
        if cell.ground.is_nan() && cell.slices & !(u16::MAX << over_foot) != 0 {
            // Something stands under it.
            looks_like_ground = false;
        }
        if looks_like_ground && (cell.ground.is_nan() || cell.ground > touch.lowest) {
            let before = if cell.ground.is_nan() { foot } else { cell.ground };
            let lower = slice(before) - slice(touch.lowest);
            cell.slices = raised(cell.slices, lower);
            cell.ground = touch.lowest;
            if cell.slices == 0 && lower > 0 {
                // What was seen is far above it.
                obstacle = 0;
            }
        }
        let ground = if cell.ground.is_finite() { cell.ground } else { foot };
        let from = slice(ground) - (slice(foot) - BELOW);
        let seen =
            u32::try_from(from).ok().and_then(|from| touch.slices.checked_shr(from)).unwrap_or(0) as u16;
        let over = slices_up_to(ground, step);
        let low = seen & low_slices(ground, clearance);
        let body = low & (u16::MAX << over.clamp(0, 15));
        // What is higher than a step by less than a slice is in the slice that the step ends in. Under something that hangs, that cannot be told
        // from what is lower by as much.
        let grazing = low & (1 << (over - 1).clamp(0, 15));
        let body = if body == 0 && over > 1 { grazing } else { body };
        let in_the_way = touch.highest > ground + step && body != 0;
        if in_the_way {
            cell.slices |= body;
            obstacle = (obstacle + OBSTACLE_SEEN).min(OBSTACLE_MOST);
        } else if touch.lowest < ground + step {
            obstacle = (obstacle - 1).max(0);
        }
        self.set_obstacle(index, obstacle);
    }

    /// Sets a cell's confidence and, if it turned into or ceased to be an obstacle, the counts round it.
    fn set_obstacle(&mut self, index: CellIndex, obstacle: i8) {
        let cell = self.cell_mut(index);
        let was = cell.is_obstacle();
        cell.obstacle = obstacle;
        let is = cell.is_obstacle();
        if was && !is {
            cell.slices = 0;
        }
        if was == is {
            return;
        }
        let reach = (self.shape.radius / self.cell_size).floor() as i32;
        for dx in -reach..=reach {
            for dy in -reach..=reach {
                if dx * dx + dy * dy <= reach * reach {
                    let near = &mut self.cell_mut(CellIndex { x: index.x + dx, y: index.y + dy }).near;
                    *near = if is { near.saturating_add(1) } else { near.saturating_sub(1) };
                }
            }
        }
    }

    fn cell_mut(&mut self, index: CellIndex) -> &mut Cell {
        let (block, offset) = locate(index);
        let cells = self.blocks.entry(block).or_insert_with(|| vec![UNKNOWN; (BLOCK * BLOCK) as usize]);
        &mut cells[offset]
    }

    /// Whether a robot could stand in a cell: no obstacle within its radius. Constant time.
    pub fn is_free(&self, index: CellIndex) -> bool {
        self.cell(index).near == 0
    }
}

/// The cell that lies there in a block.
fn at_offset(block: (i32, i32), offset: usize) -> CellIndex {
    let (row, column) = (offset as i32 / BLOCK, offset as i32 % BLOCK);
    CellIndex { x: block.0 * BLOCK + column, y: block.1 * BLOCK + row }
}

fn nalgebra_point(point: &[f32; 3]) -> nalgebra::Vector3<f32> {
    nalgebra::Vector3::from(*point)
}

fn locate(index: CellIndex) -> ((i32, i32), usize) {
    let block = (index.x.div_euclid(BLOCK), index.y.div_euclid(BLOCK));
    (block, (index.y.rem_euclid(BLOCK) * BLOCK + index.x.rem_euclid(BLOCK)) as usize)
}

#[cfg(test)]
#[path = "terrain_tests.rs"]
mod tests;
