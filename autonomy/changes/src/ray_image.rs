//! Which places the rays of a view went through.

use crate::ChangesConfig;
use crate::visit::SensorView;
use geometry::Vector3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Rays of a view that passed a place closely.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PassingRays {
    /// Those that ended behind it.
    pub(crate) through: usize,
    /// Those that ended near it.
    pub(crate) ended: usize,
    /// Those that ended before it. Of a view without a line of sight to the place they are not counted.
    pub(crate) blocked: usize,
}

/// The rays of a view, sorted by the cells of directions around its sensor.
#[derive(Clone)]
pub(crate) struct RayImage {
    sensor: Vector3,
    cell_rad: f64,
    columns: usize,
    rows: usize,
    /// Place in `rays` of the first ray of each cell, row by row, and their number.
    starts: Vec<u32>,
    /// Unit direction and range, metres, of each ray.
    rays: Vec<([f32; 3], f32)>,
    farthest: FarthestRanges,
}

impl RayImage {
    /// The image of a view. Its cells are as large as the mean distance between rays, but not smaller than a margin at the largest range. Linear in the points.
    pub(crate) fn new(view: &SensorView, config: &ChangesConfig) -> Self {
        let rays: Vec<(f64, f64, f64)> =
            view.points.iter().filter_map(|point| direction(&view.sensor, point)).collect();
        let cell_rad =
            ray_distance_rad(&rays, config.density_cell_rad).clamp(config.cell_rad[0], config.cell_rad[1]);
        let (columns, rows) = ((TAU / cell_rad).ceil() as usize, (PI / cell_rad).ceil() as usize);
        let mut image = Self {
            sensor: view.sensor,
            cell_rad,
            columns,
            rows,
            starts: Vec::new(),
            rays: Vec::new(),
            farthest: FarthestRanges::new(&rays, config.density_cell_rad),
        };
        let mut sorted: Vec<(usize, (f64, f64, f64))> = rays
            .into_iter()
            .map(|ray| {
                let (column, row) = image.cell(ray.0, ray.1);
                (row * columns + column, ray)
            })
            .collect();
        sorted.sort_by_key(|(cell, _)| *cell);
        let mut starts = vec![0; columns * rows + 1];
        for (cell, _) in &sorted {
            starts[cell + 1] += 1;
        }
        for cell in 0..columns * rows {
            starts[cell + 1] += starts[cell];
        }
        image.starts = starts;
        image.rays = sorted
            .into_iter()
            .map(|(_, (azimuth, elevation, range_m))| {
                let (flat, up) = (elevation.cos(), elevation.sin());
                ([flat * azimuth.cos(), flat * azimuth.sin(), up].map(|at| at as f32), range_m as f32)
            })
            .collect();
        image
    }

    fn cell(&self, azimuth: f64, elevation: f64) -> (usize, usize) {
        let column = ((azimuth + PI) / self.cell_rad) as usize;
        let row = ((elevation + FRAC_PI_2) / self.cell_rad) as usize;
        (column.min(self.columns - 1), row.min(self.rows - 1))
    }

    /// The rays that passed a place, metres, map frame, within a distance, metres. If the normal of the surface there is given, a ray went through only if it ended on
    /// one side of it: along a floor, rays pass a place closely and end on the floor farther on. Linear in the rays of the cells around its direction
    /// (docs/maths/changes.md, equation 1).
    pub(crate) fn passing(
        &self,
        place: &[f32; 3],
        normal: Option<&[f32; 3]>,
        reach_m: f64,
        config: &ChangesConfig,
    ) -> PassingRays {
        let mut passing = PassingRays::default();
        let offset = Vector3::from(place.map(f64::from)) - self.sensor;
        // Before the angles, because most views of a long walk are far away.
        if !(config.min_range_m..=config.max_range_m).contains(&offset.norm()) {
            return passing;
        }
        let Some((azimuth, elevation, range_m)) = direction(&self.sensor, place) else { return passing };
        let offset: [f32; 3] = offset.map(|at| at as f32).into();
        let margin_m = (config.free_margin_m + config.free_margin_share * range_m) as f32;
        let reach_rad = (reach_m / range_m).min(1.0);
        // Most views of a long walk have no line of sight to the place: all their rays in its direction ended before it.
        let nearest_m = (range_m * range_m - reach_m * reach_m).max(0.0).sqrt() - f64::from(margin_m);
        if self.farthest.is_nearer([azimuth, elevation], reach_rad, nearest_m) {
            return passing;
        }
        let (column, row) = self.cell(azimuth, elevation);
        let rows = (reach_rad / self.cell_rad).ceil() as usize;
        // Columns are narrower away from the horizon.
        let columns = (reach_rad / (self.cell_rad * elevation.cos().max(0.05))).ceil() as usize;
        let columns = columns.min(self.columns / 2 - 1);
        for row in row.saturating_sub(rows)..=(row + rows).min(self.rows - 1) {
            for ray in self.of_row(row, column + self.columns - columns, 2 * columns + 1) {
                self.count(ray, &offset, normal, [reach_m as f32, margin_m], config, &mut passing);
            }
        }
        passing
    }

    /// The rays of `columns` cells of a row, from the cell `first` on. After the last cell of the row comes its first one.
    fn of_row(&self, row: usize, first: usize, columns: usize) -> impl Iterator<Item = &([f32; 3], f32)> {
        let first = first % self.columns;
        let end = (first + columns).min(self.columns);
        let beyond = (first + columns - end).min(first);
        let of = |from: usize, to: usize| {
            let start = row * self.columns;
            &self.rays[self.starts[start + from] as usize..self.starts[start + to] as usize]
        };
        of(first, end).iter().chain(of(0, beyond))
    }

    /// All rays that come within a distance of a place, metres, map frame, and some others: unit direction and range, metres. Linear in the rays of the cells around its direction.
    pub(crate) fn rays_near(&self, place: &Vector3, within_m: f64) -> impl Iterator<Item = &([f32; 3], f32)> {
        let offset = place - self.sensor;
        let distance_m = offset.norm();
        let (rows, columns, middle) = if distance_m <= within_m {
            (0..self.rows, self.columns, 0)
        } else {
            let (azimuth, elevation) =
                (offset.y.atan2(offset.x), (offset.z / distance_m).clamp(-1.0, 1.0).asin());
            let reach_rad = (within_m / distance_m).asin();
            let (column, row) = self.cell(azimuth, elevation);
            let rows = (reach_rad / self.cell_rad).ceil() as usize;
            let cosine = (elevation.abs() + reach_rad).cos().max(0.05);
            let columns = 2 * (reach_rad / (self.cell_rad * cosine)).ceil() as usize + 1;
            let columns = columns.min(self.columns);
            let first = column + self.columns - columns / 2;
            (row.saturating_sub(rows)..(row + rows + 1).min(self.rows), columns, first)
        };
        rows.flat_map(move |row| self.of_row(row, middle, columns))
    }

    /// Place of the sensor, metres, map frame.
    pub(crate) fn sensor(&self) -> &Vector3 {
        &self.sensor
    }

    /// Counts a ray if it passed the place at an offset from the sensor.
    fn count(
        &self,
        (along, range_m): &([f32; 3], f32),
        offset: &[f32; 3],
        normal: Option<&[f32; 3]>,
        [reach_m, margin_m]: [f32; 2],
        config: &ChangesConfig,
        passing: &mut PassingRays,
    ) {
        let at_m: f32 = (0..3).map(|axis| along[axis] * offset[axis]).sum();
        let beside: f32 = (0..3).map(|axis| (offset[axis] - along[axis] * at_m).powi(2)).sum();
        if beside > reach_m * reach_m {
            return;
        }
        let behind_m = |normal: &[f32; 3]| {
            (0..3).map(|axis| normal[axis] * (along[axis] * range_m - offset[axis])).sum::<f32>().abs()
        };
        if *range_m > at_m + margin_m {
            let crossed = normal.is_none_or(|normal| behind_m(normal) > config.free_margin_m as f32);
            passing.through += usize::from(crossed);
        } else if *range_m >= at_m - margin_m {
            passing.ended += 1;
        } else {
            passing.blocked += 1;
        }
    }
}

/// The farthest range of the rays of a view in each direction.
#[derive(Clone)]
struct FarthestRanges {
    side_rad: f64,
    columns: usize,
    rows: usize,
    /// Greatest range of the rays of each cell and of those around it, metres, row by row.
    ranges_m: Vec<f32>,
}

impl FarthestRanges {
    /// Of these rays (azimuth, elevation, range), in cells of this side, radians. Linear in the rays and the cells.
    fn new(rays: &[(f64, f64, f64)], side_rad: f64) -> Self {
        let (columns, rows) = ((TAU / side_rad).floor() as usize, (PI / side_rad).floor() as usize);
        let mut ranges = Self { side_rad: TAU / columns as f64, columns, rows, ranges_m: Vec::new() };
        let mut of_cells = vec![0.0_f32; columns * rows];
        for (azimuth, elevation, range_m) in rays {
            let (column, row) = ranges.cell(*azimuth, *elevation);
            let cell = &mut of_cells[row * columns + column];
            *cell = cell.max(*range_m as f32);
        }
        let around = |cell: usize| {
            let (row, column) = (cell / columns, cell % columns);
            let rows = row.saturating_sub(1)..=(row + 1).min(rows - 1);
            rows.flat_map(|row| {
                [columns - 1, 0, 1].map(|step| of_cells[row * columns + (column + step) % columns])
            })
            .fold(0.0, f32::max)
        };
        ranges.ranges_m = (0..of_cells.len()).map(around).collect();
        ranges
    }

    fn cell(&self, azimuth: f64, elevation: f64) -> (usize, usize) {
        let column = ((azimuth + PI) / self.side_rad) as usize;
        let row = ((elevation + FRAC_PI_2) / PI * self.rows as f64) as usize;
        (column.min(self.columns - 1), row.min(self.rows - 1))
    }

    /// Whether all rays within `reach_rad` of a direction (azimuth, elevation) are known to be shorter than a range, metres.
    fn is_nearer(&self, [azimuth, elevation]: [f64; 2], reach_rad: f64, range_m: f64) -> bool {
        // Columns are narrower away from the horizon.
        let is_within = reach_rad <= self.side_rad * (elevation.abs() + reach_rad).cos();
        let (column, row) = self.cell(azimuth, elevation);
        is_within && f64::from(self.ranges_m[row * self.columns + column]) < range_m
    }
}

/// Azimuth and elevation (radians) and range (metres) of a point from a sensor; none at the sensor itself.
fn direction(sensor: &Vector3, point: &[f32; 3]) -> Option<(f64, f64, f64)> {
    let offset = Vector3::from(point.map(f64::from)) - sensor;
    let range_m = offset.norm();
    (range_m > 1e-3 && range_m.is_finite())
        .then(|| (offset.y.atan2(offset.x), (offset.z / range_m).clamp(-1.0, 1.0).asin(), range_m))
}

/// Mean distance between neighbouring rays: the square root of the solid angle in which there are rays over their number (docs/maths/changes.md, equation 2).
fn ray_distance_rad(rays: &[(f64, f64, f64)], side_rad: f64) -> f64 {
    let columns = (TAU / side_rad).ceil() as usize;
    let rows = (PI / side_rad).ceil() as usize;
    let mut is_seen = vec![false; columns * rows];
    for (azimuth, elevation, _) in rays {
        let column = (((azimuth + PI) / side_rad) as usize).min(columns - 1);
        let row = (((elevation + FRAC_PI_2) / side_rad) as usize).min(rows - 1);
        is_seen[row * columns + column] = true;
    }
    let solid_angle: f64 = (0..rows)
        .map(|row| {
            let elevation = (row as f64 + 0.5) * side_rad - FRAC_PI_2;
            let seen = is_seen[row * columns..(row + 1) * columns].iter().filter(|seen| **seen).count();
            seen as f64 * side_rad * side_rad * elevation.cos().max(0.0)
        })
        .sum();
    (solid_angle / rays.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall across x = 5 m, seen from the origin.
    fn wall() -> RayImage {
        let points = (-60..60).flat_map(|y| (-20..20).map(move |z| [5.0, y as f32 * 0.05, z as f32 * 0.05]));
        RayImage::new(
            &SensorView { sensor: Vector3::zeros(), points: points.collect() },
            &ChangesConfig::default(),
        )
    }

    #[test]
    fn rays_go_through_places_before_the_wall_and_tell_nothing_of_those_behind_and_beside_it() {
        let (image, config) = (wall(), ChangesConfig::default());
        let at = |place: [f32; 3]| {
            let PassingRays { through, ended, .. } = image.passing(&place, None, config.ray_reach_m, &config);
            (through > 0, ended > 0)
        };
        assert_eq!(at([3.0, 0.2, 0.1]), (true, false));
        assert_eq!(at([5.0, 0.2, 0.1]), (false, true));
        assert_eq!(at([4.95, 0.2, 0.1]), (false, true));
        assert_eq!(at([6.0, 0.2, 0.1]), (false, false), "behind");
        assert_eq!(at([-3.0, 0.2, 0.1]), (false, false), "no rays");
        assert_eq!(at([0.2, 0.0, 0.0]), (false, false), "the robot itself");
        assert_eq!(at([f32::NAN, 0.0, 0.0]), (false, false));
    }

    #[test]
    fn all_rays_near_a_place_are_found() {
        let mut all = 0;
        let image = wall();
        let count = |place: Vector3, within_m: f64| {
            let is_near = |(along, _): &&([f32; 3], f32)| {
                let along = Vector3::from(along.map(f64::from));
                along.dot(&place) > 0.0 && place.cross(&along).norm() <= within_m
            };
            (
                image.rays_near(&place, within_m).filter(is_near).count(),
                image.rays.iter().filter(is_near).count(),
            )
        };
        for place in [Vector3::new(3.0, 0.2, 0.1), Vector3::new(2.0, -0.9, -0.4), Vector3::new(0.3, 0.3, 0.2)]
        {
            for within_m in [0.05, 0.4, 0.8] {
                let (found, expected) = count(place, within_m);
                assert_eq!(found, expected, "{place:?} {within_m}");
                all += expected;
            }
        }
        assert!(all > 100);
        assert!(image.rays_near(&Vector3::new(3.0, 0.2, 0.1), 0.1).count() * 10 < image.rays.len());
    }

    #[test]
    fn only_places_without_a_line_of_sight_are_left_out_early() {
        let config = ChangesConfig::default();
        // A near wall over half of the far one.
        let far = (-60..60).flat_map(|y| (-20..20).map(move |z| (y, z)));
        let points = far.map(|(y, z)| {
            let scale = if y < 0 { 0.4 } else { 1.0 };
            [5.0, y as f32 * 0.05, z as f32 * 0.05].map(|at| at * scale)
        });
        let view = SensorView { sensor: Vector3::zeros(), points: points.collect() };
        let image = RayImage::new(&view, &config);
        let mut all = image.clone();
        all.farthest.ranges_m.fill(f32::INFINITY);
        let (mut left_out, mut passed) = (0, 0);
        for x in [1.9_f32, 2.1, 2.5, 3.5, 4.9, 5.1] {
            for y in (-40..40).map(|y| y as f32 * 0.05) {
                let place = [x, y, 0.12];
                let [early, slow] =
                    [&image, &all].map(|image| image.passing(&place, None, config.ray_reach_m, &config));
                assert_eq!((early.through, early.ended), (slow.through, slow.ended), "{place:?}");
                left_out += usize::from(early.blocked < slow.blocked);
                passed += usize::from(early.through > 0);
            }
        }
        assert!(left_out > 30 && passed > 30, "{left_out} {passed}");
    }

    #[test]
    fn all_rays_within_reach_are_found_and_no_others() {
        let (image, config) = (wall(), ChangesConfig::default());
        let place = [3.0_f32, 0.23, -0.31];
        let is_passing = |y: f32, z: f32| {
            let along = Vector3::new(5.0, f64::from(y), f64::from(z)).normalize();
            Vector3::from(place.map(f64::from)).cross(&along).norm() <= config.ray_reach_m
        };
        let rays = (-60..60).flat_map(|y| (-20..20).map(move |z| (y as f32 * 0.05, z as f32 * 0.05)));
        let expected = rays.filter(|(y, z)| is_passing(*y, *z)).count();
        assert_eq!(
            image.passing(&place, None, config.ray_reach_m, &config),
            PassingRays { through: expected, ended: 0, blocked: 0 }
        );
        assert!(expected > 10);
    }
}
