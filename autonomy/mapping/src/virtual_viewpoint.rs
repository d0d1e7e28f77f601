//! Virtual viewpoints: keyframes for a point cloud that no robot has walked.
//!
//! A cloud without its viewpoints contains neither free space nor occlusions, and localisation needs both. So the ground is found
//! ([`crate::ground_surface`]), viewpoints are spread over it, and from each viewpoint only the points nearest in their direction are kept. This uses
//! a depth image in which near points cover as many pixels as a surface would. Katz, Tal and Basri, *Direct visibility of point sets*, SIGGRAPH 2007,
//! solve the same problem with another method.

use crate::ground_surface::{GroundCell, GroundConfig, GroundSurface};
use crate::packed_indices::PackedIndices;
use geometry::{Isometry, Rotation, Vector3};
use std::collections::BTreeMap;

/// Parameters of [`find_viewpoints`] and [`find_up_axis`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewpointConfig {
    /// Least distance between viewpoints, metres. Chosen: half more than the distance of keyframes, because viewpoints lie in an area and not along a path.
    pub spacing_m: f32,
    /// Height of the base above the ground, metres. Chosen: that of a quadruped.
    pub base_height_m: f32,
    /// Height of the LiDAR above the base, metres. Chosen: that of a quadruped.
    pub lidar_height_m: f32,
    /// Range of the LiDAR, metres. Chosen: farther points are few at the density of a thinned cloud.
    pub range_m: f32,
    /// Least range of the LiDAR, metres. Chosen: as of common LiDARs.
    pub min_range_m: f32,
    /// Lowest and highest elevation of the LiDAR's rays, radians from level. Source: those of an XT-32.
    pub elevations_rad: [f32; 2],
    /// Edge of a pixel of the depth image, radians. Chosen: 1.5 degrees; at 3 m a point of [`Self::point_width_m`] fills one.
    pub pixel_rad: f32,
    /// Width of the surface that a point stands for, metres. Neighbours of a thinned cloud are nearly this far apart.
    pub point_width_m: f32,
    /// Limit of that width in the depth image, pixels to each side. Chosen: it bounds the cost of points within 0.4 m.
    pub max_point_pixels: i32,
    /// A point is occluded if it lies farther behind the nearest point in its direction than this, metres, ... Chosen: the thickness of a wall.
    pub occlusion_margin_m: f32,
    /// ... plus this share of the nearest point's range. Chosen: surfaces seen at a slant reach as far behind their nearest point within a pixel.
    pub occlusion_share: f32,
    /// Edge of the squares by which points are looked up, metres. Chosen: a viewpoint looks up some hundred squares at [`Self::range_m`].
    pub block_m: f32,
    /// An axis other than z points up only if it has this many times as much ground. Chosen: large walls have less ground than floors; other programs' clouds with z up
    /// are far more common.
    pub up_axis_ratio: f64,
}

impl Default for ViewpointConfig {
    /// For a quadruped with an XT-32.
    fn default() -> Self {
        Self {
            spacing_m: 1.5,
            base_height_m: 0.5,
            lidar_height_m: 0.3,
            range_m: 30.0,
            min_range_m: 0.3,
            elevations_rad: [-16.0_f32, 15.0].map(f32::to_radians),
            pixel_rad: 0.026,
            point_width_m: 0.08,
            max_point_pixels: 8,
            occlusion_margin_m: 0.2,
            occlusion_share: 0.04,
            block_m: 5.0,
            up_axis_ratio: 1.5,
        }
    }
}

/// A viewpoint.
#[derive(Clone, Debug, PartialEq)]
pub struct VirtualViewpoint {
    /// Pose of the base: level, heading along x.
    pub map_from_base: Isometry,
    /// Indices of the points that are visible from there.
    pub visible: PackedIndices,
}

/// Viewpoints and the straight connections between neighbouring ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VirtualViewpoints {
    /// In a fixed order.
    pub viewpoints: Vec<VirtualViewpoint>,
    /// Pairs of viewpoints with ground all along the line between them, the smaller number first.
    pub connections: Vec<[usize; 2]>,
}

/// An axis of a cloud.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the axes")]
pub enum Axis {
    X,
    Y,
    Z,
}

/// The axis that points up or down: the one across which the largest connected piece of ground lies, z if in doubt. Three times the cost of
/// finding the ground.
pub fn find_up_axis(xyz: &[[f32; 3]], config: &ViewpointConfig) -> Axis {
    let ground = |turn: fn(&[f32; 3]) -> [f32; 3]| {
        let turned: Vec<[f32; 3]> = xyz.iter().map(turn).collect();
        GroundSurface::find(&turned, GroundConfig::default()).largest_piece() as f64
    };
    let [x, y, z] =
        [ground(|[x, y, z]| [*y, *z, *x]), ground(|[x, y, z]| [*x, -*z, *y]), ground(|point| *point)];
    match (x > config.up_axis_ratio * z, y > config.up_axis_ratio * z) {
        (true, _) if x > y => Axis::X,
        (_, true) => Axis::Y,
        _ => Axis::Z,
    }
}

/// Finds viewpoints in a thinned cloud (some 0.1 m between points, z up) and the points visible from each: some thousands of points, all held
/// at once. Linear in the viewpoints times the points within range. `progress` is called with the share of viewpoints done.
pub fn find_viewpoints(
    xyz: &[[f32; 3]],
    config: &ViewpointConfig,
    progress: &mut dyn FnMut(f64),
) -> VirtualViewpoints {
    let grid = GroundConfig::default();
    let ground = GroundSurface::find(xyz, grid);
    let cells = spread(&ground, &grid, config.spacing_m);
    let blocks = PointBlocks::new(xyz, config.block_m);
    let mut image = DepthImage::new(*config);
    let mut viewpoints = Vec::with_capacity(cells.len());
    for (index, cell) in cells.iter().enumerate() {
        let [x, y, ground_z] = grid.centre(*cell);
        let base = [x, y, ground_z + config.base_height_m];
        let lidar = [x, y, base[2] + config.lidar_height_m];
        let visible = image.visible_points(xyz, &blocks, lidar);
        let position = Vector3::from(base.map(f64::from));
        let map_from_base = Isometry::from_parts(position.into(), Rotation::identity());
        viewpoints.push(VirtualViewpoint { map_from_base, visible });
        progress((index + 1) as f64 / cells.len() as f64);
    }
    VirtualViewpoints { viewpoints, connections: connections(&ground, &grid, &cells, config.spacing_m) }
}

/// Ground cells at least `spacing_m` apart, those with much free ground around them first.
fn spread(ground: &GroundSurface, grid: &GroundConfig, spacing_m: f32) -> Vec<GroundCell> {
    let mut waiting: Vec<(usize, GroundCell)> =
        ground.cells().map(|cell| (ground.clearance(cell), cell)).collect();
    waiting.sort_by_key(|(clearance, cell)| (std::cmp::Reverse(*clearance), *cell));
    let mut chosen = Vec::new();
    let mut near: BTreeMap<(i32, i32), Vec<GroundCell>> = BTreeMap::new();
    let square =
        |cell: &GroundCell| [cell.0, cell.1].map(|c| (c as f32 * grid.column_m / spacing_m).floor() as i32);
    for (_, cell) in waiting {
        let [i, j] = square(&cell);
        let is_taken = (i - 1..=i + 1).flat_map(|i| (j - 1..=j + 1).map(move |j| (i, j))).any(|at| {
            near.get(&at)
                .is_some_and(|others| others.iter().any(|other| distance_m(grid, &cell, other) < spacing_m))
        });
        if !is_taken {
            near.entry((i, j)).or_default().push(cell);
            chosen.push(cell);
        }
    }
    chosen.sort_unstable();
    chosen
}

fn distance_m(grid: &GroundConfig, a: &GroundCell, b: &GroundCell) -> f32 {
    let ([ax, ay, az], [bx, by, bz]) = (grid.centre(*a), grid.centre(*b));
    ((ax - bx).powi(2) + (ay - by).powi(2) + (az - bz).powi(2)).sqrt()
}

/// Pairs of neighbours with ground all along the line between them. Neighbours are at most twice the spacing apart.
fn connections(
    ground: &GroundSurface,
    grid: &GroundConfig,
    cells: &[GroundCell],
    spacing_m: f32,
) -> Vec<[usize; 2]> {
    let reach_m = 2.0 * spacing_m;
    let square =
        |cell: &GroundCell| [cell.0, cell.1].map(|c| (c as f32 * grid.column_m / reach_m).floor() as i32);
    let mut squares: BTreeMap<[i32; 2], Vec<usize>> = BTreeMap::new();
    for (index, cell) in cells.iter().enumerate() {
        squares.entry(square(cell)).or_default().push(index);
    }
    let mut found = Vec::new();
    for (first, a) in cells.iter().enumerate() {
        let [i, j] = square(a);
        let near = (i - 1..=i + 1).flat_map(|i| (j - 1..=j + 1).map(move |j| [i, j]));
        let others = near.filter_map(|at| squares.get(&at)).flatten().filter(|second| **second > first);
        for &second in others {
            let b = cells[second];
            if distance_m(grid, a, &b) <= reach_m && ground.is_walkable(*a, b) {
                found.push([first, second]);
            }
        }
    }
    found.sort_unstable();
    found
}

/// Points by squares of the plane.
struct PointBlocks {
    edge_m: f32,
    points: BTreeMap<(i32, i32), Vec<u32>>,
}

impl PointBlocks {
    fn new(xyz: &[[f32; 3]], edge_m: f32) -> Self {
        let mut points: BTreeMap<(i32, i32), Vec<u32>> = BTreeMap::new();
        for (index, [x, y, _]) in (0..).zip(xyz) {
            points.entry(((x / edge_m).floor() as i32, (y / edge_m).floor() as i32)).or_default().push(index);
        }
        Self { edge_m, points }
    }

    /// All points in squares within `range_m`.
    fn around(&self, [x, y, _]: [f32; 3], range_m: f32) -> impl Iterator<Item = u32> + '_ {
        let edge_m = self.edge_m;
        let range =
            move |c: f32| ((c - range_m) / edge_m).floor() as i32..=((c + range_m) / edge_m).floor() as i32;
        range(x)
            .flat_map(move |i| self.points.range((i, *range(y).start())..=(i, *range(y).end())))
            .flat_map(|(_, points)| points.iter().copied())
    }
}

/// Range of the nearest point in every direction.
struct DepthImage {
    config: ViewpointConfig,
    width: i32,
    height: i32,
    nearest_m: Vec<f32>,
}

impl DepthImage {
    fn new(config: ViewpointConfig) -> Self {
        let [lowest, highest] = config.elevations_rad;
        let width = (std::f32::consts::TAU / config.pixel_rad).ceil() as i32;
        let height = ((highest - lowest) / config.pixel_rad).ceil().max(1.0) as i32;
        Self { config, width, height, nearest_m: vec![0.0; (width * height) as usize] }
    }

    /// Indices of the points that are not occluded as seen from `lidar`.
    fn visible_points(&mut self, xyz: &[[f32; 3]], blocks: &PointBlocks, lidar: [f32; 3]) -> PackedIndices {
        let ViewpointConfig { range_m, min_range_m, pixel_rad, elevations_rad: [lowest, _], .. } =
            self.config;
        self.nearest_m.fill(f32::INFINITY);
        let projected: Vec<(u32, i32, i32, f32)> = blocks
            .around(lidar, range_m)
            .filter_map(|index| {
                let [x, y, z] = std::array::from_fn(|axis| xyz[index as usize][axis] - lidar[axis]);
                let range = (x * x + y * y + z * z).sqrt();
                let level = (x * x + y * y).sqrt();
                let row = ((z.atan2(level) - lowest) / pixel_rad).floor() as i32;
                let is_inside = range <= range_m && range > min_range_m && (0..self.height).contains(&row);
                let column = ((y.atan2(x) + std::f32::consts::PI) / pixel_rad) as i32;
                is_inside.then_some((index, column.clamp(0, self.width - 1), row, range))
            })
            .collect();
        for (_, column, row, range) in &projected {
            let pixels =
                ((self.config.point_width_m / range / pixel_rad) as i32).min(self.config.max_point_pixels);
            for row in (row - pixels).max(0)..=(row + pixels).min(self.height - 1) {
                for column in column - pixels..=column + pixels {
                    let at = (row * self.width + column.rem_euclid(self.width)) as usize;
                    self.nearest_m[at] = self.nearest_m[at].min(*range);
                }
            }
        }
        let is_visible = |&(index, column, row, range): &(u32, i32, i32, f32)| {
            let nearest = self.nearest_m[(row * self.width + column) as usize];
            let limit = nearest + self.config.occlusion_margin_m + self.config.occlusion_share * nearest;
            (range <= limit).then_some(index)
        };
        let mut visible: Vec<u32> = projected.iter().filter_map(is_visible).collect();
        visible.sort_unstable();
        PackedIndices::new(&visible)
    }
}

#[cfg(test)]
#[path = "virtual_viewpoint_tests.rs"]
mod tests;
