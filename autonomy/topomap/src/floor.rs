//! The floor of a map and the obstacles on it, on all storeys, from the clouds of its keyframes.
//!
//! Ground is found by [`mapping::ground_surface`]; the ground on which the robot has walked is added, because a LiDAR does not see the ground
//! beside itself. Obstacles are the points between step height and clearance above ground.

use crate::TopomapConfig;
use geometry::{Isometry, Vector3};
use mapping::ground_surface::{GroundCell, GroundConfig, GroundSurface};
use nalgebra::Point3;
use navigation::RobotShape;
use std::collections::BTreeMap;
use vocab::Stamp;

/// Edge of the squares by which obstacles are looked up, metres.
const OBSTACLE_BLOCK_M: f64 = 0.5;
/// Bits of each coordinate of a voxel's key: 52 km at 5 cm.
const KEY_BITS: u32 = 21;

/// When something was seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct SeenInterval {
    first: Stamp,
    last: Stamp,
}

/// Collects the clouds of a map, one at a time. Memory: 24 bytes for each cell of [`TopomapConfig::voxel_m`] that was seen.
#[derive(Clone, Debug)]
pub struct FloorBuilder {
    config: TopomapConfig,
    robot: RobotShape,
    /// Keys with the time at which they were seen.
    voxels: Vec<(u64, SeenInterval)>,
    /// Number of voxels that are sorted.
    sorted: usize,
}

impl FloorBuilder {
    /// An empty one.
    pub fn new(robot: RobotShape, config: TopomapConfig) -> Self {
        Self { config, robot, voxels: Vec::new(), sorted: 0 }
    }

    /// Adds a keyframe's cloud (keyframe frame, metres) with its time, best without moving objects and one point in each cell of [`TopomapConfig::voxel_m`].
    /// Linear in the points.
    pub fn insert(&mut self, stamp: Stamp, map_from_keyframe: &Isometry, xyz: &[[f32; 3]]) {
        let range_squared = self.config.max_range_m.powi(2) as f32;
        for point in xyz {
            // False for coordinates that are not finite.
            if point.iter().map(|c| c * c).sum::<f32>() < range_squared {
                let at = map_from_keyframe * Point3::from(point.map(f64::from));
                self.voxels.extend(
                    self.key(&at.coords).map(|key| (key, SeenInterval { first: stamp, last: stamp })),
                );
            }
        }
        if self.voxels.len() > 2 * self.sorted + 1_000_000 {
            self.sort();
        }
    }

    /// Adds the points of a survey that nobody walked, map frame, metres. Linear in the points.
    pub fn insert_survey(&mut self, xyz: &[[f32; 3]]) {
        for point in xyz.iter().filter(|point| point.iter().all(|c| c.is_finite())) {
            let key = self.key(&Vector3::from(point.map(f64::from)));
            self.voxels
                .extend(key.map(|key| (key, SeenInterval { first: Stamp::EPOCH, last: Stamp::EPOCH })));
        }
        self.sort();
    }

    fn sort(&mut self) {
        self.voxels.sort_unstable();
        self.voxels.dedup_by(|(key, seen), (kept_key, kept)| {
            let is_same = key == kept_key;
            if is_same {
                kept.last = kept.last.max(seen.last);
            }
            is_same
        });
        self.sorted = self.voxels.len();
    }

    fn key(&self, at: &Vector3) -> Option<u64> {
        let half = 1_i64 << (KEY_BITS - 1);
        let mut key = 0;
        for axis in 0..3 {
            let cell = (at[axis] / self.config.voxel_m).floor() as i64 + half;
            if !(0..2 * half).contains(&cell) {
                return None;
            }
            key = key << KEY_BITS | cell as u64;
        }
        Some(key)
    }

    /// The middle of a voxel, metres.
    fn centre(&self, key: u64) -> [f32; 3] {
        let half = 1_i64 << (KEY_BITS - 1);
        [2, 1, 0].map(|shift| {
            let cell = (key >> (shift * KEY_BITS)) as i64 & (2 * half - 1);
            (((cell - half) as f64 + 0.5) * self.config.voxel_m) as f32
        })
    }

    /// The floor. `walked` says where the robot has stood. `O(n log n)` in the voxels.
    pub(crate) fn build(mut self, walked: &[TimedPosition]) -> Floor {
        self.sort();
        let xyz: Vec<[f32; 3]> = self.voxels.iter().map(|(key, _)| self.centre(*key)).collect();
        let grid = self.ground_config();
        let surface = GroundSurface::find(&xyz, grid);
        let mut tops: BTreeMap<(i32, i32), i32> = BTreeMap::new();
        for point in &xyz {
            let (column, layer) = grid.locate(*point);
            tops.entry(column).and_modify(|top| *top = layer.max(*top)).or_insert(layer);
        }
        let mut floor = Floor {
            columns: BTreeMap::new(),
            tops,
            obstacles: BTreeMap::new(),
            grid,
            robot: self.robot,
            config: self.config,
        };
        for (x, y, layer) in surface.cells() {
            floor.columns.entry((x, y)).or_default().push(layer);
        }
        floor.add_walked(walked);
        floor.fill_holes();
        floor.fill_holes();
        let sightings = self.voxels.iter().map(|(_, seen)| *seen);
        let seen: Vec<([f32; 3], SeenInterval)> = xyz.iter().copied().zip(sightings).collect();
        floor.add_obstacles(&seen, walked);
        floor
    }

    fn ground_config(&self) -> GroundConfig {
        let config = GroundConfig::default();
        let headroom_layers = (self.robot.clearance_m / f64::from(config.layer_m)).ceil() as i32;
        GroundConfig { headroom_layers, min_neighbours: self.config.min_ground_neighbours, ..config }
    }
}

/// Ground and obstacles.
#[derive(Clone, Debug)]
pub(crate) struct Floor {
    /// For each column: the layers of its ground, ascending.
    columns: BTreeMap<(i32, i32), Vec<i32>>,
    /// For each column: the highest layer in which something was seen.
    tops: BTreeMap<(i32, i32), i32>,
    /// Points that may be in the robot's way, by squares of [`OBSTACLE_BLOCK_M`].
    obstacles: BTreeMap<(i32, i32), Vec<[f32; 3]>>,
    grid: GroundConfig,
    pub robot: RobotShape,
    pub config: TopomapConfig,
}

impl Floor {
    /// Every ground cell, in a fixed order.
    pub fn cells(&self) -> impl Iterator<Item = GroundCell> + '_ {
        self.columns.iter().flat_map(|((x, y), layers)| layers.iter().map(|layer| (*x, *y, *layer)))
    }

    /// Whether nothing was seen above a ground cell.
    pub fn is_open(&self, (x, y, layer): GroundCell) -> bool {
        self.tops.get(&(x, y)).is_none_or(|top| *top <= layer + self.grid.noise_layers)
    }

    /// Middle of a ground cell, metres.
    pub fn centre(&self, cell: GroundCell) -> Vector3 {
        Vector3::from(self.grid.centre(cell).map(f64::from))
    }

    /// Area of a column, square metres.
    pub fn cell_area_m2(&self) -> f64 {
        f64::from(self.grid.column_m).powi(2)
    }

    /// The layer of the ground of a column that is nearest to a layer, if one can step there.
    pub fn near(&self, x: i32, y: i32, layer: i32) -> Option<i32> {
        let layers = self.columns.get(&(x, y))?;
        let nearest = layers.iter().copied().min_by_key(|other| (other - layer).abs())?;
        ((nearest - layer).abs() <= self.grid.step_layers).then_some(nearest)
    }

    /// Of the eight columns around a ground cell, how many have ground to which one can step.
    pub fn ground_neighbours(&self, (x, y, layer): GroundCell) -> usize {
        let around = square(1).filter(|offset| *offset != (0, 0));
        around.filter(|(dx, dy)| self.near(x + dx, y + dy, layer).is_some()).count()
    }

    /// Height of the ground at a place, metres, within a step of a height.
    pub fn ground(&self, x: f64, y: f64, height: f64) -> Option<f64> {
        let (column, layer) = self.locate(x, y, height);
        let found = self.near(column.0, column.1, layer)?;
        Some((f64::from(found) + 0.5) * f64::from(self.grid.layer_m))
    }

    fn locate(&self, x: f64, y: f64, height: f64) -> ((i32, i32), i32) {
        let column_m = f64::from(self.grid.column_m);
        let column = ((x / column_m).floor() as i32, (y / column_m).floor() as i32);
        (column, (height / f64::from(self.grid.layer_m)).floor() as i32)
    }

    /// The obstacles that may be within `reach_m` of the rectangle of two corners.
    pub fn obstacles_around(
        &self,
        a: &Vector3,
        b: &Vector3,
        reach_m: f64,
    ) -> impl Iterator<Item = &[f32; 3]> {
        let block = |c: f64| (c / OBSTACLE_BLOCK_M).floor() as i32;
        let range = move |a: f64, b: f64| block(a.min(b) - reach_m)..=block(a.max(b) + reach_m);
        let rows = range(a.y, b.y);
        range(a.x, b.x)
            .flat_map(move |x| self.obstacles.range((x, *rows.start())..=(x, *rows.end())))
            .flat_map(|(_, points)| points)
    }

    /// Adds the ground on which the robot has stood, where no ground was seen at that height.
    fn add_walked(&mut self, walked: &[TimedPosition]) {
        let reach = (self.half_width_m() / f64::from(self.grid.column_m)).ceil() as i32;
        for TimedPosition { feet, .. } in walked {
            let ((x, y), layer) = self.locate(feet.x, feet.y, feet.z);
            for (dx, dy) in square(reach) {
                let centre = self.centre((x + dx, y + dy, layer));
                if (centre - feet).xy().norm() <= self.half_width_m() + f64::from(self.grid.column_m) / 2.0
                    && self.near(x + dx, y + dy, layer).is_none()
                {
                    self.add(x + dx, y + dy, layer);
                }
            }
        }
    }

    fn add(&mut self, x: i32, y: i32, layer: i32) {
        let layers = self.columns.entry((x, y)).or_default();
        if let Err(place) = layers.binary_search(&layer) {
            layers.insert(place, layer);
        }
    }

    /// Gives columns without ground that of their neighbours.
    fn fill_holes(&mut self) {
        let mut sides: BTreeMap<(i32, i32), Vec<i32>> = BTreeMap::new();
        for (x, y, layer) in self.cells() {
            for (dx, dy) in square(1) {
                if self.near(x + dx, y + dy, layer).is_none() {
                    sides.entry((x + dx, y + dy)).or_default().push(layer);
                }
            }
        }
        let step_layers = self.grid.step_layers;
        for ((x, y), mut layers) in sides {
            layers.sort_unstable();
            for group in layers.chunk_by(|a, b| b - a <= step_layers) {
                if group.len() >= self.config.min_hole_neighbours {
                    self.add(x, y, group[group.len() / 2]);
                }
            }
        }
    }

    /// Keeps the points that may be in the way of a robot on the ground of their column or of a column beside it. Points where the body of the robot has been
    /// after they were seen are gone: people, doors that were opened. So are those that were seen for a short time only, where the robot has ever been.
    fn add_obstacles(&mut self, seen: &[([f32; 3], SeenInterval)], walked: &[TimedPosition]) {
        let passes = self.passes(walked);
        let layer_m = f64::from(self.grid.layer_m);
        let top_m = self.robot.clearance_m + self.robot.step_m;
        let column_of = |point: &[f32; 3]| self.locate(f64::from(point[0]), f64::from(point[1]), 0.0).0;
        let mut obstacles: BTreeMap<(i32, i32), Vec<[f32; 3]>> = BTreeMap::new();
        let mut heights: Vec<i32> = Vec::new();
        // Voxels of a column are not in a row, because their keys are ordered by x, then y.
        let mut sorted: Vec<((i32, i32), &[f32; 3], SeenInterval)> =
            seen.iter().map(|(point, seen)| (column_of(point), point, *seen)).collect();
        sorted.sort_by_key(|(column, ..)| *column);
        for group in sorted.chunk_by(|a, b| a.0 == b.0) {
            let (x, y) = group[0].0;
            heights.clear();
            for (dx, dy) in square(self.config.obstacle_ground_columns) {
                heights.extend(self.columns.get(&(x + dx, y + dy)).into_iter().flatten());
            }
            heights.sort_unstable();
            heights.dedup();
            let passes = passes.get(&(x, y));
            for (_, point, seen) in group {
                let z = f64::from(point[2]);
                let is_obstacle = heights.iter().any(|layer| {
                    let above = z - (f64::from(*layer) + 0.5) * layer_m;
                    above > self.robot.step_m - layer_m && above < top_m
                });
                let layer = (z / layer_m).floor() as i32;
                let is_ground = self
                    .columns
                    .get(&(x, y))
                    .is_some_and(|own| own.iter().any(|one| (one - layer).abs() <= 1));
                let is_gone = || {
                    passes.is_some_and(|passes| passes.iter().any(|pass| self.has_passed(pass, point, seen)))
                };
                if is_obstacle && !is_ground && !is_gone() {
                    let block =
                        [point[0], point[1]].map(|c| (f64::from(c) / OBSTACLE_BLOCK_M).floor() as i32);
                    obstacles.entry((block[0], block[1])).or_default().push(**point);
                }
            }
        }
        self.obstacles = obstacles;
    }
}

/// Where the robot stood, and when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TimedPosition {
    /// Position of the feet, metres, map frame.
    pub feet: Vector3,
    pub stamp: Stamp,
}

impl Floor {
    /// For each column: the positions of the robot whose body may have reached into it.
    fn passes(&self, walked: &[TimedPosition]) -> BTreeMap<(i32, i32), Vec<TimedPosition>> {
        let reach = (self.swept_m() / f64::from(self.grid.column_m)).ceil() as i32;
        let mut passes: BTreeMap<(i32, i32), Vec<TimedPosition>> = BTreeMap::new();
        for position in walked {
            let ((x, y), _) = self.locate(position.feet.x, position.feet.y, 0.0);
            for (dx, dy) in square(reach) {
                passes.entry((x + dx, y + dy)).or_default().push(*position);
            }
        }
        passes
    }

    /// Half the width of the robot's body, metres.
    pub(crate) fn half_width_m(&self) -> f64 {
        self.config.half_width_share * self.robot.radius_m
    }

    /// Half the width that the robot's feet need, metres.
    pub(crate) fn half_stance_m(&self) -> f64 {
        self.config.half_stance_share * self.robot.radius_m
    }

    /// Radius around a position in which the body was: positions are [`TopomapConfig::sample_m`] apart.
    fn swept_m(&self) -> f64 {
        self.half_width_m().hypot(self.config.sample_m / 2.0)
    }

    /// Whether the body of the robot was at a point after it was seen, or at any time if it was seen for a short time only (docs/maths/topomap.md, equation 1).
    fn has_passed(&self, position: &TimedPosition, point: &[f32; 3], seen: &SeenInterval) -> bool {
        let offset = Vector3::from(point.map(f64::from)) - position.feet;
        let is_brief = (seen.last - seen.first).secs_f64() < self.config.lasting_s;
        (is_brief || position.stamp > seen.first)
            && offset.xy().norm() <= self.swept_m()
            && (0.0..=self.robot.clearance_m).contains(&offset.z)
    }
}

/// Offsets of the columns in a square, the middle included, in a fixed order.
pub(crate) fn square(reach: i32) -> impl Iterator<Item = (i32, i32)> {
    (-reach..=reach).flat_map(move |x| (-reach..=reach).map(move |y| (x, y)))
}
