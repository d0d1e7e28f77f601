//! Elevation map: a grid of ground heights and obstacles of all ground that the robot has seen.
//!
//! The map is 2.5-dimensional: one ground height for each cell. On a site with several floors a cell forgets the other floor as soon as
//! the robot sees the cell from this floor. Memory: 12 bytes a cell, 1.2 kB for each square metre seen.
//!
//! An obstacle is removed in two cases. In the first case, the robot sees ground at the obstacle's position: a person has walked on. In the second
//! case, rays pass through the obstacle: the robot saw it while it was carried, at a wrong pose. The second case is needed because a robot sees no
//! ground beside itself.

use crate::cell_index::{CellIndex, floor};
use crate::elevation_map_config::{ElevationMapConfig, MAX_SLICES};
use crate::lowest_beams::LowestBeams;
use crate::scan_cells::{CellHits, ScanCells};
use crate::zones::GroundZones;
use geometry::{Isometry, Vector3};
use nalgebra::Point3;
use points::{FreeSpaceImage, Occupancy};
use std::collections::BTreeMap;

/// Cells along the side of a block. Blocks are allocated whole.
const BLOCK_CELLS: i32 = 64;
/// The robot's shape as navigation needs it, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotShape {
    /// Radius of the circle in which the robot can turn.
    pub radius_m: f64,
    /// Height of the base over the ground.
    pub standing_height_m: f64,
    /// Height above the ground that must be free of obstacles.
    pub clearance_m: f64,
    /// Highest step that the robot climbs.
    pub step_m: f64,
}

/// A robot for tests. Real shapes come from the robot's profile.
#[cfg(test)]
impl Default for RobotShape {
    fn default() -> Self {
        Self { radius_m: 0.38, standing_height_m: 0.55, clearance_m: 0.95, step_m: 0.22 }
    }
}

/// One cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Lowest surface seen, metres; NaN while unknown.
    ground: f32,
    /// Confidence that an obstacle stands here.
    obstacle: i8,
    /// Period in which a scan last saw the obstacle, counted from 0 again after 256 periods.
    seen_in: u8,
    /// Slices above the ground in which the obstacle was seen, the lowest slice in the lowest bit.
    slices: u16,
    /// Where in the cell the obstacle was seen, from the corner with the lowest coordinates, in units of 1/256 of the side.
    obstacle_at: [u8; 2],
    /// Number of obstacle cells within the robot's radius. It is kept up to date so that planning reads one cell only.
    obstacles_near: u16,
}

/// The middle of a cell.
const MIDDLE: [u8; 2] = [128; 2];
const UNKNOWN: Cell =
    Cell { ground: f32::NAN, obstacle: 0, seen_in: 0, slices: 0, obstacle_at: MIDDLE, obstacles_near: 0 };

impl Cell {
    /// Height of the ground, metres, if it was ever seen.
    pub fn ground(&self) -> Option<f64> {
        self.ground.is_finite().then(|| f64::from(self.ground))
    }

    /// The slices that rays of a scan passed through. The cell's centre is `distance` metres from the robot. `clears_thin`: also those that appear too thin.
    ///
    /// Neighbouring slices belong to one object. The object is removed as a whole if a ray passed through it and no ray met it, since its
    /// foot may be out of sight.
    fn slices_seen_through(
        &self,
        config: &ElevationMapConfig,
        seen: &SeenScan,
        centre: [f64; 2],
        distance: f64,
        clears_thin: bool,
    ) -> u16 {
        let lowest = config.slice(if self.ground.is_finite() { self.ground } else { seen.foot });
        let occupancy_at_edge = |edge: u32| {
            let height = (lowest + i64::from(edge)) as f64 * config.slice_height_m;
            let point = seen.base_from_map * Point3::new(centre[0], centre[1], height);
            seen.view.classify(&point.coords.map(|c| c as f32).into())
        };
        let single_slice_height = if self.obstacle < config.trace_confidence {
            config.trace_height_m
        } else {
            config.single_slice_height_m
        };
        let mut removed = 0;
        for (first, count) in runs(self.slices) {
            let height = f64::from(count - 1) * config.slice_height_m + single_slice_height;
            if config.min_clearable_angle_rad * distance > height && !clears_thin {
                continue;
            }
            // Rays are tested at the edges between the object's slices: its outer edges may lie beside the object.
            let mut through = false;
            let mut stands = false;
            if count == 1 {
                // A single slice has outer edges only. The object is somewhere between them.
                let edges = [occupancy_at_edge(first), occupancy_at_edge(first + 1)];
                through = edges == [Occupancy::Free; 2];
            }
            for edge in first + 1..first + count {
                match occupancy_at_edge(edge) {
                    Occupancy::Free => through = true,
                    Occupancy::Occupied | Occupancy::Occluded => stands = true,
                    Occupancy::Unobserved => {}
                }
                if stands {
                    break;
                }
            }
            if through && !stands {
                removed |= ((1_u32 << (first + count)) - (1 << first)) as u16;
            }
        }
        removed
    }
}

/// Slices counted anew from a ground that is `lower` slices lower.
fn shift_slices(slices: u16, lower: i64) -> u16 {
    let by = lower.unsigned_abs().min(MAX_SLICES as u64 - 1) as u32;
    if lower >= 0 { slices << by } else { slices >> by }
}

/// Runs of neighbouring bits that are set: the first bit of each run and the run's length.
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

/// The elevation map.
#[derive(Clone, Debug)]
pub struct ElevationMap {
    config: ElevationMapConfig,
    cell_size_m: f64,
    shape: RobotShape,
    blocks: BTreeMap<(i32, i32), Vec<Cell>>,
    /// What the newest scan saw. It is kept to reuse its memory.
    scan_cells: ScanCells,
    /// Number of scans so far.
    scans: u32,
    zones: GroundZones,
}

/// What the rays of a scan passed through, and the height of the ground on which the robot stands.
struct SeenScan {
    view: FreeSpaceImage,
    base_from_map: Isometry,
    foot: f32,
}

impl ElevationMap {
    /// An empty map of square cells with a side of `cell_size_m` metres.
    pub fn new(cell_size_m: f64, shape: RobotShape) -> Self {
        Self::with_config(ElevationMapConfig::default(), cell_size_m, shape)
    }

    /// As [`Self::new`], with other parameters.
    pub fn with_config(config: ElevationMapConfig, cell_size_m: f64, shape: RobotShape) -> Self {
        let (blocks, scan_cells, zones) = (BTreeMap::new(), ScanCells::default(), GroundZones::default());
        Self { config, cell_size_m, shape, blocks, scan_cells, scans: 0, zones }
    }

    /// The areas with rules, in the frame of this map.
    pub fn zones(&self) -> &GroundZones {
        &self.zones
    }

    /// Replaces them.
    pub fn set_zones(&mut self, zones: GroundZones) {
        self.zones = zones;
    }

    /// Side of a cell, metres.
    pub fn cell_size_m(&self) -> f64 {
        self.cell_size_m
    }

    /// The shape of the robot for which cells are free.
    pub fn shape(&self) -> &RobotShape {
        &self.shape
    }

    /// The cell that holds a point.
    pub fn index(&self, x: f64, y: f64) -> CellIndex {
        CellIndex { x: floor(x / self.cell_size_m), y: floor(y / self.cell_size_m) }
    }

    /// Centre of a cell, metres.
    pub fn centre(&self, index: CellIndex) -> (f64, f64) {
        ((f64::from(index.x) + 0.5) * self.cell_size_m, (f64::from(index.y) + 0.5) * self.cell_size_m)
    }

    /// The content of a cell.
    pub fn cell(&self, index: CellIndex) -> Cell {
        let (block, offset) = locate(index);
        self.blocks.get(&block).map_or(UNKNOWN, |cells| cells[offset])
    }

    /// Whether an obstacle stands in a cell.
    pub fn is_obstacle(&self, index: CellIndex) -> bool {
        self.holds_obstacle(&self.cell(index))
    }

    fn holds_obstacle(&self, cell: &Cell) -> bool {
        cell.obstacle >= self.config.obstacle_min
    }

    /// The number of the present period of scans.
    fn period(&self) -> u8 {
        // Numbers of periods are compared, so they may begin anew.
        (self.scans / self.config.scans_per_period.max(1)) as u8
    }

    /// A copy of the map as it would be if nothing stood within `reach_m` of `position` that no scan has seen in this period or the one before. A robot does not see what is
    /// low or high beside it: what people left there stays until the robot looks from farther away. Linear in the size of the map; for rare questions.
    pub fn without_unseen(&self, position: &Vector3, reach_m: f64) -> Self {
        let mut seen = self.clone();
        let period = self.period();
        let [low, high] = [-reach_m, reach_m].map(|reach| self.index(position.x + reach, position.y + reach));
        let cells = (low.x..=high.x).flat_map(|x| (low.y..=high.y).map(move |y| CellIndex { x, y }));
        for index in cells {
            let cell = self.cell(index);
            let (x, y) = self.centre(index);
            let is_near = (x - position.x).hypot(y - position.y) <= reach_m;
            if is_near && self.holds_obstacle(&cell) && period.wrapping_sub(cell.seen_in) > 1 {
                seen.set_obstacle(index, 0);
            }
        }
        seen
    }

    /// Positions of the obstacles in the cells from `low` to `high`, both included, metres, in a fixed order. In each cell it is the middle of what scans saw there, so
    /// that the face of a wall is known to a centimetre or two although a cell is larger.
    pub fn obstacles_between(&self, low: CellIndex, high: CellIndex) -> Vec<[f64; 2]> {
        let ((first, _), (last, _)) = (locate(low), locate(high));
        let blocks = self.blocks.range((first.0, i32::MIN)..=(last.0, i32::MAX));
        let mut found = Vec::new();
        for (block, cells) in blocks.filter(|((_, y), _)| (first.1..=last.1).contains(y)) {
            let corner = CellIndex { x: block.0 * BLOCK_CELLS, y: block.1 * BLOCK_CELLS };
            // The part of the block that is asked for.
            let columns = (low.x - corner.x).max(0)..(high.x - corner.x + 1).min(BLOCK_CELLS);
            for row in (low.y - corner.y).max(0)..(high.y - corner.y + 1).min(BLOCK_CELLS) {
                for column in columns.clone() {
                    let cell = &cells[(row * BLOCK_CELLS + column) as usize];
                    if self.holds_obstacle(cell) {
                        found.push(self.obstacle_position(corner.x + column, corner.y + row, cell));
                    }
                }
            }
        }
        found
    }

    fn obstacle_position(&self, x: i32, y: i32, cell: &Cell) -> [f64; 2] {
        let along =
            |index: i32, at: u8| (f64::from(index) + (f64::from(at) + 0.5) / 256.0) * self.cell_size_m;
        [along(x, cell.obstacle_at[0]), along(y, cell.obstacle_at[1])]
    }

    /// Inserts a motion-corrected scan: `points` in the base frame, metres, at `map_from_base`, seen from `sensor` (base frame, metres). Points
    /// farther than `range` metres are ignored. Cost: linear in the points, n log n in the cells seen, linear in the ground within range.
    pub fn insert_scan(
        &mut self,
        map_from_base: &Isometry,
        sensor: [f32; 3],
        points: &[[f32; 3]],
        range: f64,
    ) {
        let origin = map_from_base.translation.vector;
        let foot = (origin.z - self.shape.standing_height_m) as f32;
        let beams = self.collect_hits(map_from_base, sensor, points, range);
        let scan_cells = std::mem::take(&mut self.scan_cells);
        let step = self.shape.step_m;
        for (index, hits) in scan_cells.seen() {
            let (x, y) = self.centre(index);
            let distance = ((x - origin.x).powi(2) + (y - origin.y).powi(2)).sqrt();
            let max_rise = (step + self.config.max_slope * distance)
                .min(f64::from(self.config.floor_separation_m)) as f32;
            let (margin, slope) = (self.config.footless_margin_m, self.config.footless_margin_slope);
            let foot_seen_from = beams.height(x, y) + margin + slope * distance;
            let may_hang = hits.lowest > foot && f64::from(hits.lowest) < foot_seen_from;
            let rise = (hits.lowest - foot).abs();
            // The neighbours of most cells need not be asked.
            let is_ground = rise < step as f32
                || (rise < max_rise && !may_hang && self.has_lower_neighbour(index, hits.lowest));
            self.update_cell(index, &hits, foot, is_ground);
        }
        self.scan_cells = scan_cells;
        // An odd stride, so that every beam of a LiDAR is used in turn.
        let stride = points.len().div_ceil(self.config.max_rays) | 1;
        let view =
            FreeSpaceImage::new(points.iter().step_by(stride), sensor, self.ground_test(map_from_base));
        let seen = SeenScan { view, base_from_map: map_from_base.inverse(), foot };
        self.scans = self.scans.wrapping_add(1);
        self.clear_seen_through(&seen, [origin.x, origin.y], range);
        self.mark_ground_under_robot(map_from_base, foot);
    }

    /// Tells of points in the base frame, metres, whether they are of the ground that is known in their cells.
    fn ground_test(&self, map_from_base: &Isometry) -> impl Fn(&[f32; 3]) -> bool + '_ {
        let rotation = map_from_base.rotation.to_rotation_matrix().cast::<f32>();
        let origin = map_from_base.translation.vector;
        let height_m = (self.config.ground_share_of_step * self.shape.step_m) as f32;
        move |point| {
            let turned = rotation * nalgebra_point(point);
            let (x, y) = (f64::from(turned[0]) + origin.x, f64::from(turned[1]) + origin.y);
            // Not true of unknown ground, which is not a number.
            turned[2] + origin.z as f32 <= self.cell(self.index(x, y)).ground + height_m
        }
    }

    /// Sorts a scan's points into `self.scan_cells`; returns the lowest beams.
    fn collect_hits(
        &mut self,
        map_from_base: &Isometry,
        sensor: [f32; 3],
        points: &[[f32; 3]],
        range: f64,
    ) -> LowestBeams {
        let rotation = map_from_base.rotation.to_rotation_matrix().cast::<f32>();
        let origin = map_from_base.translation.vector;
        let foot = (origin.z - self.shape.standing_height_m) as f32;
        let ceiling = foot + self.shape.clearance_m as f32 + self.config.floor_separation_m;
        // Of the robot on the ground where it is now. Treads and obstacles of stairs are beside it by some centimetres at most.
        let body_heights = foot + self.shape.step_m as f32..foot + self.shape.clearance_m as f32;
        let lowest_slice = self.config.slice(foot) - self.config.slices_below_feet;
        let sensor_in_map = map_from_base * Point3::from(sensor.map(f64::from));
        let mut beams =
            LowestBeams::new(&sensor_in_map.coords, self.shape.radius_m + self.config.self_margin_m);
        let range_squared = (range * range) as f32;
        let mut scan_cells = std::mem::take(&mut self.scan_cells);
        scan_cells.restart(self.index(origin.x, origin.y), (range / self.cell_size_m).ceil() as i32 + 1);
        for point in points {
            if point[0] * point[0] + point[1] * point[1] > range_squared {
                continue;
            }
            let turned = rotation * nalgebra_point(point);
            let z = turned[2] + origin.z as f32;
            beams.insert(&turned, &origin);
            if z > ceiling || z < foot - self.config.max_depth_m {
                continue;
            }
            let (x, y) = (f64::from(turned[0]) + origin.x, f64::from(turned[1]) + origin.y);
            let index = self.index(x, y);
            let bit = u32::try_from(self.config.slice(z) - lowest_slice).ok();
            let slices = bit.and_then(|bit| 1_u64.checked_shl(bit)).unwrap_or(0);
            let body = body_heights.contains(&z).then(|| {
                let within = |at: f64, index: i32| (at / self.cell_size_m - f64::from(index)) as f32;
                [within(x, index.x), within(y, index.y)]
            });
            scan_cells.insert(index, z, slices, body);
        }
        scan_cells.sort();
        self.scan_cells = scan_cells;
        beams
    }

    /// Whether ground beside a cell is known from which one step leads up to `height`. Stairs have such ground. A bag that hangs from a person's
    /// shoulder has none.
    fn has_lower_neighbour(&self, index: CellIndex, height: f32) -> bool {
        let (step, reach) = (self.shape.step_m as f32, self.config.tread_cells);
        let is_one_step_away = |dx: i32, dy: i32| {
            let ground = self.cell(CellIndex { x: index.x + dx, y: index.y + dy }).ground;
            (ground - step..=ground + step).contains(&height)
        };
        (-reach..=reach).any(|dx| (-reach..=reach).any(|dy| is_one_step_away(dx, dy)))
    }

    /// Decreases the confidence of the obstacles within `range` of `position` that rays of a scan passed through.
    fn clear_seen_through(&mut self, seen: &SeenScan, position: [f64; 2], range: f64) {
        let [low, high] =
            [-range, range].map(|reach| locate(self.index(position[0] + reach, position[1] + reach)).0);
        let is_near =
            |block: (i32, i32)| (low.0..=high.0).contains(&block.0) && (low.1..=high.1).contains(&block.1);
        let overhead = f64::from(seen.foot) + self.shape.clearance_m;
        let is_turn_of_thin = self.scans.is_multiple_of(self.config.thin_cleared_scans.max(1));
        let mut cleared: Vec<(CellIndex, u16)> = Vec::new();
        for (block, cells) in self.blocks.iter().filter(|(block, _)| is_near(**block)) {
            for (offset, cell) in cells.iter().enumerate().filter(|(_, cell)| self.holds_obstacle(cell)) {
                let index = at_offset(*block, offset);
                let (x, y) = self.centre(index);
                let distance = ((x - position[0]).powi(2) + (y - position[1]).powi(2)).sqrt();
                // What the scan saw in the cell itself is inserted already.
                let is_seen =
                    self.scan_cells.get(index).is_some_and(|hits| f64::from(hits.lowest) < overhead);
                if distance > range || is_seen {
                    continue;
                }
                let clears_thin = is_turn_of_thin && distance >= self.config.thin_cleared_from_m;
                let slices = cell.slices_seen_through(&self.config, seen, [x, y], distance, clears_thin);
                if slices != 0 {
                    cleared.push((index, slices));
                }
            }
        }
        for (index, slices) in cleared {
            let cell = self.cell_mut(index);
            let obstacle = cell.obstacle;
            if slices == cell.slices {
                self.set_obstacle(index, obstacle - 1);
            } else {
                // Another object stands in the same cell.
                cell.slices &= !slices;
            }
        }
    }

    /// Marks the ground under the robot as known. The LiDAR does not see it, but the robot stands on it.
    fn mark_ground_under_robot(&mut self, map_from_base: &Isometry, foot: f32) {
        let position = map_from_base.translation.vector;
        let reach = (self.shape.radius_m / self.cell_size_m).ceil() as i32;
        let centre = self.index(position.x, position.y);
        for offset in disc(reach) {
            let index = CellIndex { x: centre.x + offset.x, y: centre.y + offset.y };
            let floor_separation = self.config.floor_separation_m;
            let cell = self.cell_mut(index);
            if !cell.ground.is_finite() || (cell.ground - foot).abs() > floor_separation {
                cell.ground = foot;
                self.set_obstacle(index, 0);
            }
        }
    }

    /// Updates a cell with the heights that a scan saw in it. The robot's feet are at the height `foot`. `is_ground` tells whether
    /// the lowest point is low enough to be ground, given the feet and the neighbouring cells. An obstacle known in this cell can still rule it out.
    fn update_cell(&mut self, index: CellIndex, hits: &CellHits, foot: f32, mut is_ground: bool) {
        let (config, period) = (self.config, self.period());
        let (step, clearance) = (self.shape.step_m as f32, self.shape.clearance_m as f32);
        let cell = self.cell_mut(index);
        let is_other_floor = cell.ground.is_finite()
            && (cell.ground - hits.lowest).abs() > config.floor_separation_m
            && (hits.lowest - foot).abs() < (cell.ground - foot).abs();
        let mut obstacle = cell.obstacle;
        if is_other_floor {
            cell.ground = f32::NAN;
            cell.slices = 0;
            obstacle = 0;
        }
        // A hanging object gives no information about the ground. The same holds for a wall whose foot is out of sight.
        if !is_ground && hits.lowest > foot && cell.ground > hits.lowest {
            // An object stands lower than the assumed ground, so the assumption was wrong.
            cell.slices = shift_slices(cell.slices, config.slice(cell.ground) - config.slice(foot));
            cell.ground = f32::NAN;
        }
        let above_foot = (config.slice(hits.lowest) - config.slice(foot)).clamp(0, MAX_SLICES - 1);
        if cell.ground.is_nan() && cell.slices & !(u16::MAX << above_foot) != 0 {
            // An obstacle is known below this surface.
            is_ground = false;
        }
        if is_ground && (cell.ground.is_nan() || cell.ground > hits.lowest) {
            let before = if cell.ground.is_nan() { foot } else { cell.ground };
            let lower = config.slice(before) - config.slice(hits.lowest);
            cell.slices = shift_slices(cell.slices, lower);
            cell.ground = hits.lowest;
            if cell.slices == 0 && lower > 0 {
                // The obstacle is too far above the new ground to be in the robot's way.
                obstacle = 0;
            }
        }
        let ground = if cell.ground.is_finite() { cell.ground } else { foot };
        let body = blocked_slices(&config, hits, ground, foot, step, clearance);
        if hits.highest > ground + step && body != 0 {
            cell.slices |= body;
            cell.seen_in = period;
            let seen_at = hits.body_at().unwrap_or(MIDDLE);
            cell.obstacle_at = match cell.obstacle >= config.obstacle_min {
                true => blend(cell.obstacle_at, seen_at),
                false => seen_at,
            };
            obstacle = (obstacle + config.obstacle_increment).min(config.obstacle_max);
        } else if hits.lowest < ground + step {
            obstacle = (obstacle - 1).max(0);
        }
        self.set_obstacle(index, obstacle);
    }

    /// Sets a cell's obstacle confidence. If the cell becomes or ceases to be an obstacle, the counts of the cells around it follow.
    fn set_obstacle(&mut self, index: CellIndex, obstacle: i8) {
        let obstacle_min = self.config.obstacle_min;
        let cell = self.cell_mut(index);
        let was_obstacle = cell.obstacle >= obstacle_min;
        cell.obstacle = obstacle;
        let is_obstacle = cell.obstacle >= obstacle_min;
        if was_obstacle && !is_obstacle {
            cell.slices = 0;
        }
        if was_obstacle == is_obstacle {
            return;
        }
        let reach = (self.shape.radius_m / self.cell_size_m).floor() as i32;
        for offset in disc(reach) {
            let near = CellIndex { x: index.x + offset.x, y: index.y + offset.y };
            let count = &mut self.cell_mut(near).obstacles_near;
            *count = if is_obstacle { count.saturating_add(1) } else { count.saturating_sub(1) };
        }
    }

    fn cell_mut(&mut self, index: CellIndex) -> &mut Cell {
        let (block, offset) = locate(index);
        let cells =
            self.blocks.entry(block).or_insert_with(|| vec![UNKNOWN; (BLOCK_CELLS * BLOCK_CELLS) as usize]);
        &mut cells[offset]
    }

    /// Whether the robot could stand in a cell, because no obstacle is within its radius. Constant time.
    pub fn is_free(&self, index: CellIndex) -> bool {
        self.cell(index).obstacles_near == 0
    }
}

/// The slices above `ground`, metres, in which a scan saw an obstacle for the robot.
fn blocked_slices(
    config: &ElevationMapConfig,
    hits: &CellHits,
    ground: f32,
    foot: f32,
    step: f32,
    clearance: f32,
) -> u16 {
    let ground_bit = config.slice(ground) - (config.slice(foot) - config.slices_below_feet);
    let seen =
        u32::try_from(ground_bit).ok().and_then(|bit| hits.slices.checked_shr(bit)).unwrap_or(0) as u16;
    let step_slices = config.slices_up_to(ground, step);
    let low = seen & config.low_slices(ground, clearance);
    let body = low & (u16::MAX << step_slices.clamp(0, MAX_SLICES - 1));
    // An object that is higher than a step by less than a slice lies in the slice in which the step ends. Below a hanging object it looks like one
    // that is lower than a step by less than a slice.
    let grazing = low & (1 << (step_slices - 1).clamp(0, MAX_SLICES - 1));
    if body == 0 && step_slices > 1 { grazing } else { body }
}

/// A position that follows what is seen, without most of its noise.
fn blend(known: [u8; 2], seen: [u8; 2]) -> [u8; 2] {
    [0, 1].map(|axis| ((3 * u16::from(known[axis]) + u16::from(seen[axis]) + 2) / 4) as u8)
}

/// Offsets of all cells within `reach` cells of a cell, in a fixed order.
fn disc(reach: i32) -> impl Iterator<Item = CellIndex> {
    let row = move |x: i32| (-reach..=reach).map(move |y| CellIndex { x, y });
    (-reach..=reach).flat_map(row).filter(move |cell| cell.x * cell.x + cell.y * cell.y <= reach * reach)
}

/// The cell at an offset within a block.
fn at_offset(block: (i32, i32), offset: usize) -> CellIndex {
    let (row, column) = (offset as i32 / BLOCK_CELLS, offset as i32 % BLOCK_CELLS);
    CellIndex { x: block.0 * BLOCK_CELLS + column, y: block.1 * BLOCK_CELLS + row }
}

fn nalgebra_point(point: &[f32; 3]) -> nalgebra::Vector3<f32> {
    nalgebra::Vector3::from(*point)
}

fn locate(index: CellIndex) -> ((i32, i32), usize) {
    let block = (index.x.div_euclid(BLOCK_CELLS), index.y.div_euclid(BLOCK_CELLS));
    (block, (index.y.rem_euclid(BLOCK_CELLS) * BLOCK_CELLS + index.x.rem_euclid(BLOCK_CELLS)) as usize)
}

#[cfg(test)]
#[path = "elevation_map_tests.rs"]
mod tests;
