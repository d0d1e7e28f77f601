//! Points near a place in square columns, so that the floor under a place and obstacles along a line are found without a look at all points.
//!
//! Columns are made once, linear in the points; after that the floor under a place costs the points of about 20 columns, and a line those of about 20 columns a
//! metre. A line of 12 m over a dense cloud takes less than 0.2 ms (test `a_long_line_over_a_dense_cloud_is_quick`).

use glam::{DVec2, DVec3};

/// Parameters of [`PointColumns`]. What makes an obstacle is as in the generation of topological maps (`topomap::TopomapConfig`), so that an edge that a person draws is
/// judged like one that is made from the map. The robot's size, step and clearance are told by the robot; the defaults hold until they have come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColumnsConfig {
    /// Side of a column, m. Chosen: half a column of the ground of topological maps.
    pub column_m: f64,
    /// Largest area that columns cover along each side, m. Chosen: 640,000 columns, which bounds the memory; edges are far shorter.
    pub max_side_m: f64,
    /// Half the width of the robot's body, m. Source: the robots of `topomap::TopomapConfig::half_width_share`.
    pub half_width_m: f64,
    /// Height of a step that the robot climbs, m: lower things are no obstacles. Chosen: as two layers of `mapping::ground_surface::GroundConfig`.
    pub step_m: f64,
    /// Height of the robot, m: things above it are no obstacles. Chosen: the height of a common legged robot.
    pub clearance_m: f64,
    /// Points within [`Self::section_m`] that make an obstacle. One or two are noise.
    pub min_obstacle_points: u32,
    /// Length of line over which points are counted, m. Chosen: two columns.
    pub section_m: f64,
    /// Length at both ends of a line that is not looked at, m: a node may be close to what is inspected from it. Chosen: about half the width of a robot.
    pub end_margin_m: f64,
    /// Radius around a place within which points tell its floor, m. Chosen: a place between two rings of a LiDAR has points within it.
    pub floor_radius_m: f64,
    /// Greatest difference between a floor and the height that it is looked for at, m. Less than a table or a storey.
    pub floor_reach_m: f64,
    /// Thickness of a floor: noise of a LiDAR and unevenness, m. Source: the layers of `mapping::ground_surface::GroundConfig`.
    pub floor_thickness_m: f64,
    /// Points that make a floor. Chosen: as for obstacles.
    pub min_floor_points: usize,
}

impl Default for ColumnsConfig {
    fn default() -> Self {
        Self {
            column_m: 0.1,
            max_side_m: 80.0,
            half_width_m: 0.25,
            step_m: 0.2,
            clearance_m: 0.8,
            min_obstacle_points: 3,
            section_m: 0.2,
            end_margin_m: 0.25,
            floor_radius_m: 0.2,
            floor_reach_m: 0.45,
            floor_thickness_m: 0.1,
            min_floor_points: 3,
        }
    }
}

/// The first thing that stands in a corridor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstruction {
    /// Its distance from the beginning of the line, m.
    pub along_m: f64,
}

/// Heights of points by columns.
#[derive(Clone, Debug, Default)]
pub struct PointColumns {
    config: ColumnsConfig,
    /// Corner with the smallest coordinates, m, map frame.
    min: DVec2,
    /// Number of columns along x and y.
    size: [usize; 2],
    /// Where the heights of each column begin, and one more.
    starts: Vec<u32>,
    /// Heights of all points, column by column, m, map frame.
    heights: Vec<f32>,
}

impl PointColumns {
    /// Of the points between two corners, which `for_each_point` visits twice: once to count, once to store.
    pub(crate) fn new(
        config: ColumnsConfig,
        corners: [DVec2; 2],
        for_each_point: impl Fn(&mut dyn FnMut(DVec3)),
    ) -> Self {
        let [min, max] = corners;
        let side = |length: f64| ((length.clamp(0.0, config.max_side_m)) / config.column_m).ceil() as usize;
        let extent = if min.is_finite() && max.is_finite() { max - min } else { DVec2::ZERO };
        let size = [side(extent.x), side(extent.y)];
        let mut columns =
            Self { config, min, size, starts: vec![0; size[0] * size[1] + 1], heights: Vec::new() };
        let mut counts = vec![0_u32; size[0] * size[1]];
        for_each_point(&mut |point| {
            if let Some(column) = columns.column(point.truncate()) {
                counts[column] += 1;
            }
        });
        for (column, count) in counts.iter().enumerate() {
            columns.starts[column + 1] = columns.starts[column] + count;
        }
        let mut next = columns.starts.clone();
        let mut heights = vec![0.0; columns.starts[counts.len()] as usize];
        for_each_point(&mut |point| {
            if let Some(column) = columns.column(point.truncate()) {
                heights[next[column] as usize] = point.z as f32;
                next[column] += 1;
            }
        });
        columns.heights = heights;
        columns
    }

    /// Whether a place with this much room round it is covered.
    pub fn covers(&self, place: DVec2, room_m: f64) -> bool {
        let room = DVec2::splat(room_m);
        self.column(place - room).is_some() && self.column(place + room).is_some()
    }

    /// Height of the floor under a place, m, that is nearest to `near`; `None` where no points tell it.
    pub fn floor(&self, place: DVec2, near: f64) -> Option<f64> {
        let ColumnsConfig { floor_radius_m: radius, floor_reach_m: reach, .. } = self.config;
        let mut heights: Vec<f32> = Vec::new();
        let steps = (radius / self.config.column_m).ceil() as i32;
        for (x, y) in (-steps..=steps).flat_map(|x| (-steps..=steps).map(move |y| (x, y))) {
            let offset = DVec2::new(f64::from(x), f64::from(y)) * self.config.column_m;
            if offset.length() <= radius {
                let near_floor = |height: &&f32| (f64::from(**height) - near).abs() <= reach;
                heights.extend(self.heights_at(place + offset).iter().filter(near_floor));
            }
        }
        heights.sort_by(f32::total_cmp);
        // The layer with the most points; of two equal ones, the lower.
        let thickness = self.config.floor_thickness_m as f32;
        let (mut best, mut last) = (0..0, 0);
        for first in 0..heights.len() {
            while last < heights.len() && heights[last] <= heights[first] + thickness {
                last += 1;
            }
            if last - first > best.len() {
                best = first..last;
            }
        }
        let floor = &heights[best];
        (floor.len() >= self.config.min_floor_points).then(|| f64::from(floor[floor.len() / 2]))
    }

    /// The first thing in the corridor along a line between two places on the floor, m, map frame. The floor between them counts as straight.
    pub fn obstruction(&self, [from, to]: [DVec3; 2]) -> Option<Obstruction> {
        let config = &self.config;
        let line = (to - from).truncate();
        let length = line.length();
        let ahead = line.try_normalize()?;
        // Finer than a column, so that none is missed on a diagonal.
        let step = config.column_m * std::f64::consts::FRAC_1_SQRT_2;
        let rows = (config.half_width_m / step).floor() as i32;
        let mut counts = vec![0_u32; (length / config.section_m) as usize + 1];
        for row in -rows..=rows {
            let beside = ahead.perp() * (f64::from(row) * step);
            let mut last = None;
            let mut along = config.end_margin_m;
            while along <= length - config.end_margin_m {
                let column = self.column(from.truncate() + ahead * along + beside);
                // Neighbouring samples may be in one column.
                if let Some(column) = column.filter(|_| column != last) {
                    let floor = from.z + (to.z - from.z) * along / length;
                    let range = floor + config.step_m..floor + config.clearance_m;
                    let hits = self.heights_of(column).iter().filter(|z| range.contains(&f64::from(**z)));
                    counts[(along / config.section_m) as usize] += hits.count() as u32;
                }
                last = column;
                along += step;
            }
        }
        let section = counts.iter().position(|count| *count >= config.min_obstacle_points)?;
        Some(Obstruction { along_m: (section as f64 + 0.5) * config.section_m })
    }

    fn column(&self, place: DVec2) -> Option<usize> {
        let at = (place - self.min) / self.config.column_m;
        let is_inside =
            at.x >= 0.0 && at.y >= 0.0 && at.x < self.size[0] as f64 && at.y < self.size[1] as f64;
        is_inside.then(|| at.y as usize * self.size[0] + at.x as usize)
    }

    fn heights_of(&self, column: usize) -> &[f32] {
        &self.heights[self.starts[column] as usize..self.starts[column + 1] as usize]
    }

    fn heights_at(&self, place: DVec2) -> &[f32] {
        self.column(place).map_or(&[], |column| self.heights_of(column))
    }
}
