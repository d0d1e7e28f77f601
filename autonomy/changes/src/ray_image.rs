//! Which places the rays of a view went through.

use crate::ChangesConfig;
use crate::directions::{Bearing, Direction, DirectionGrid};
use crate::visit::SensorView;
use geometry::Vector3;
use std::ops::{AddAssign, Range};

/// More than the error of a distance within the largest range by single precision, metres.
const ROUNDING_M: f32 = 1e-3;

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

impl AddAssign for PassingRays {
    fn add_assign(&mut self, other: Self) {
        self.through += other.through;
        self.ended += other.ended;
        self.blocked += other.blocked;
    }
}

/// So many farthest ranges are looked at before the rays themselves. Chosen: near places have few rays that end before them.
const MOST_CELLS: usize = 100;

/// A sphere, metres, map frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sphere {
    centre: [f32; 3],
    radius_m: f32,
}

impl Sphere {
    /// Around these places: that around the smallest box along the axes, so not the smallest one. One without places is at the origin.
    pub(crate) fn around<'a>(places: impl Iterator<Item = &'a [f32; 3]>) -> Self {
        let ends = places.fold(None, |ends: Option<[[f32; 3]; 2]>, place| {
            let [least, most] = ends.unwrap_or([*place; 2]);
            let end = |of: [f32; 3], choose: fn(f32, f32) -> f32| {
                std::array::from_fn(|axis| choose(of[axis], place[axis]))
            };
            Some([end(least, f32::min), end(most, f32::max)])
        });
        let [least, most] = ends.unwrap_or_default();
        let half: [f32; 3] = std::array::from_fn(|axis| (most[axis] - least[axis]) / 2.0);
        let radius_m = dot(&half, &half).sqrt() + ROUNDING_M;
        Self { centre: std::array::from_fn(|axis| least[axis] + half[axis]), radius_m }
    }
}

/// The rays of a view, sorted by the cells of directions around its sensor.
#[derive(Clone)]
pub(crate) struct RayImage {
    sensor: Vector3,
    grid: DirectionGrid,
    /// First row of the grid with rays.
    first_row: usize,
    /// Place in `rays` of the first ray of each cell, row by row from the first one with rays, and their number.
    starts: Vec<u32>,
    rays: Vec<Ray>,
    farthest: FarthestRanges,
}

/// A ray: its unit direction and its range, metres.
pub(crate) type Ray = ([f32; 3], f32);

impl RayImage {
    /// The image of a view. Its cells are as large as the mean distance between rays, but not smaller than a margin at the largest range. Linear in the points.
    pub(crate) fn new(view: &SensorView, config: &ChangesConfig) -> Self {
        let rays: Vec<(Direction, Ray)> = view
            .points
            .iter()
            .filter_map(|point| {
                let offset = offset(point, &view.sensor);
                let Bearing { direction, range_m, .. } = Bearing::of(&offset)?;
                Some((direction, (offset.map(|at| at / range_m), range_m)))
            })
            .collect();
        let distance_rad = ray_distance_rad(&rays, config.density_cell_rad);
        let cell_rad = distance_rad.clamp(config.cell_rad[0], config.cell_rad[1]);
        let grid = DirectionGrid::new(cell_rad);
        let cells: Vec<(usize, usize)> = rays.iter().map(|(direction, _)| grid.cell(direction)).collect();
        let first_row = cells.iter().map(|(_, row)| *row).min().unwrap_or(0);
        let rows = cells.iter().map(|(_, row)| row + 1 - first_row).max().unwrap_or(0);
        let of_cell = |(column, row): &(usize, usize)| (row - first_row) * grid.columns() + column;
        let mut starts = vec![0_u32; grid.columns() * rows + 1];
        for cell in &cells {
            starts[of_cell(cell) + 1] += 1;
        }
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut next = starts.clone();
        let mut sorted: Vec<Ray> = vec![([0.0; 3], 0.0); rays.len()];
        for (cell, (_, ray)) in cells.iter().zip(&rays) {
            let place = &mut next[of_cell(cell)];
            sorted[*place as usize] = *ray;
            *place += 1;
        }
        Self {
            sensor: view.sensor,
            grid,
            first_row,
            starts,
            rays: sorted,
            farthest: FarthestRanges::new(&rays, config.sight_cell_rad),
        }
    }

    /// The rays that passed a place, metres, map frame, within a distance, metres. If the normal of the surface there is given, a ray went through only if it ended on
    /// one side of it: along a floor, rays pass a place closely and end on the floor farther on. Linear in the rays of the cells around its direction
    /// (docs/maths/changes.md, equation 1).
    pub(crate) fn passing(
        &self,
        place: &[f32; 3],
        normal: &dyn Fn() -> Option<[f32; 3]>,
        reach_m: f64,
        config: &ChangesConfig,
    ) -> PassingRays {
        let mut passing = PassingRays::default();
        let offset = offset(place, &self.sensor);
        let squared_m2 = dot(&offset, &offset);
        let [min_m, max_m] = [config.min_range_m, config.max_range_m].map(|range_m| range_m as f32);
        // Before the direction, because most views of a long walk are far away.
        if !(min_m * min_m..=max_m * max_m).contains(&squared_m2) {
            return passing;
        }
        let Some(bearing) = Bearing::of(&offset) else { return passing };
        let margin_m = config.free_margin_m as f32 + config.free_margin_share as f32 * bearing.range_m;
        let reach_m = reach_m as f32;
        let reach = bearing.reach(reach_m);
        // Most views of a long walk have no line of sight to the place: all their rays in its direction ended before it.
        let nearest_m = (squared_m2 - reach_m * reach_m).max(0.0).sqrt() - margin_m;
        if self.farthest.are_nearer(&bearing.direction, reach, nearest_m) {
            return passing;
        }
        // Most rays of the cells pass farther away. The difference of squares is not exact, by less than a thousandth of a square metre within the largest range.
        let least_m2 = squared_m2 - reach_m * reach_m - 1e-3;
        for rays in self.window(bearing.direction, reach) {
            for ray in rays {
                let at_m = dot(&ray.0, &offset);
                if at_m * at_m >= least_m2 {
                    count(ray, at_m, &offset, normal, [reach_m, margin_m], config, &mut passing);
                }
            }
        }
        passing
    }

    /// Whether no ray comes near any place in a sphere, or all that do end before it. Then no ray went through one of these places, and none ended there; but it may be so too where this says no.
    /// Linear in the cells of the farthest ranges.
    pub(crate) fn is_out_of_sight(&self, sphere: &Sphere, reach_m: f64, config: &ChangesConfig) -> bool {
        let Some(bearing) = Bearing::of(&offset(&sphere.centre, &self.sensor)) else { return false };
        let max_m = config.max_range_m as f32;
        if bearing.range_m - sphere.radius_m > max_m {
            return true;
        }
        let reach_m = sphere.radius_m + reach_m as f32;
        let margin_m = config.free_margin_m as f32 + config.free_margin_share as f32 * max_m;
        let nearest_m = bearing.range_m - reach_m - margin_m;
        nearest_m > 0.0 && self.farthest.are_nearer(&bearing.direction, bearing.reach(reach_m), nearest_m)
    }

    /// The rays of the cells of all directions whose coordinates differ from those of a direction by at most this much, in slices: a loop over slices takes half of the time of a chained iterator.
    fn window(&self, direction: Direction, reach: [f32; 2]) -> impl Iterator<Item = &[Ray]> {
        let (rows, first, columns) = self.grid.window(&direction, reach);
        let all = self.grid.columns();
        let with_rays = self.first_row..self.first_row + (self.starts.len() - 1) / all;
        let rows = rows.start.max(with_rays.start)..rows.end.min(with_rays.end);
        let end = (first + columns).min(all);
        let beyond = (first + columns - end).min(first);
        let slice = move |row: usize, columns: Range<usize>| {
            let [from, to] = [columns.start, columns.end]
                .map(|column| self.starts[(row - self.first_row) * all + column] as usize);
            &self.rays[from..to]
        };
        // After the last column comes the first one; mostly a window ends before it.
        let wrapped = if beyond > 0 { rows.clone() } else { 0..0 };
        rows.map(move |row| slice(row, first..end)).chain(wrapped.map(move |row| slice(row, 0..beyond)))
    }

    /// All rays that come within a distance of a place, metres, map frame, and some others: unit direction and range, metres. Linear in the rays of the cells around its direction.
    pub(crate) fn rays_near(&self, place: &Vector3, within_m: f64) -> impl Iterator<Item = &Ray> {
        let bearing = Bearing::of(&(place - self.sensor).map(|at| at as f32).into());
        let all = (Direction { around: 0.0, up: 0.0 }, [f32::INFINITY; 2]);
        let (direction, reach) =
            bearing.map_or(all, |bearing| (bearing.direction, bearing.reach(within_m as f32)));
        self.window(direction, reach).flatten()
    }

    /// Place of the sensor, metres, map frame.
    pub(crate) fn sensor(&self) -> &Vector3 {
        &self.sensor
    }
}

/// Counts a ray if it passed the place at an offset from the sensor. `at_m` is the length of the offset along the ray, metres.
fn count(
    (along, range_m): &Ray,
    at_m: f32,
    offset: &[f32; 3],
    normal: &dyn Fn() -> Option<[f32; 3]>,
    [reach_m, margin_m]: [f32; 2],
    config: &ChangesConfig,
    passing: &mut PassingRays,
) {
    let beside: f32 = (0..3).map(|axis| (offset[axis] - along[axis] * at_m).powi(2)).sum();
    if beside > reach_m * reach_m {
        return;
    }
    let behind_m = |normal: &[f32; 3]| {
        (0..3).map(|axis| normal[axis] * (along[axis] * range_m - offset[axis])).sum::<f32>().abs()
    };
    if *range_m > at_m + margin_m {
        let crossed = normal().is_none_or(|normal| behind_m(&normal) > config.free_margin_m as f32);
        passing.through += usize::from(crossed);
    } else if *range_m >= at_m - margin_m {
        passing.ended += 1;
    } else {
        passing.blocked += 1;
    }
}

/// From the sensor to a point, metres.
fn offset(point: &[f32; 3], sensor: &Vector3) -> [f32; 3] {
    std::array::from_fn(|axis| (f64::from(point[axis]) - sensor[axis]) as f32)
}

fn dot(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    (0..3).map(|axis| a[axis] * b[axis]).sum()
}

/// The farthest range of the rays of a view in each direction.
#[derive(Clone)]
struct FarthestRanges {
    grid: DirectionGrid,
    /// Greatest range of the rays of each cell, metres, row by row; zero without rays.
    ranges_m: Vec<f32>,
}

impl FarthestRanges {
    /// Of these rays, in cells of this angle, radians. Linear in the rays and the cells.
    fn new(rays: &[(Direction, Ray)], cell_rad: f64) -> Self {
        let grid = DirectionGrid::new(cell_rad);
        let mut ranges_m = vec![0.0_f32; grid.columns() * grid.rows()];
        for (direction, (_, range_m)) in rays {
            let (column, row) = grid.cell(direction);
            let cell = &mut ranges_m[row * grid.columns() + column];
            *cell = cell.max(*range_m);
        }
        Self { grid, ranges_m }
    }

    /// Whether all rays whose coordinates differ from those of a direction by at most this much are known to be shorter than a range, metres. Not asked of more than [`MOST_CELLS`] cells.
    fn are_nearer(&self, direction: &Direction, reach: [f32; 2], range_m: f32) -> bool {
        let (rows, first, columns) = self.grid.window(direction, reach);
        if rows.len() * columns > MOST_CELLS {
            return false;
        }
        let all = self.grid.columns();
        let beyond = (first + columns).saturating_sub(all);
        let are_nearer = |of_row: &[f32], columns: Range<usize>| {
            // All of them, without a branch for each.
            of_row[columns].iter().fold(0.0, |farthest_m: f32, at_m| farthest_m.max(*at_m)) < range_m
        };
        for row in rows {
            let of_row = &self.ranges_m[row * all..(row + 1) * all];
            if !are_nearer(of_row, first..first + columns - beyond) || !are_nearer(of_row, 0..beyond) {
                return false;
            }
        }
        true
    }
}

/// Mean distance between neighbouring rays: the square root of the solid angle in which there are rays over their number (docs/maths/changes.md, equation 2).
fn ray_distance_rad(rays: &[(Direction, Ray)], cell_rad: f64) -> f64 {
    let grid = DirectionGrid::new(cell_rad);
    let mut is_seen = vec![false; grid.columns() * grid.rows()];
    for (direction, _) in rays {
        let (column, row) = grid.cell(direction);
        is_seen[row * grid.columns() + column] = true;
    }
    let seen = is_seen.iter().enumerate().filter(|(_, is_seen)| **is_seen);
    let solid_angle: f64 =
        seen.map(|(cell, _)| grid.solid_angle(cell % grid.columns(), cell / grid.columns())).sum();
    (solid_angle / rays.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

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
            let PassingRays { through, ended, .. } =
                image.passing(&place, &|| None, config.ray_reach_m, &config);
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

    /// A near wall over half of the far one.
    fn two_walls(config: &ChangesConfig) -> RayImage {
        let far = (-60..60).flat_map(|y| (-20..20).map(move |z| (y, z)));
        let points = far.map(|(y, z)| {
            let scale = if y < 0 { 0.4 } else { 1.0 };
            [5.0, y as f32 * 0.05, z as f32 * 0.05].map(|at| at * scale)
        });
        RayImage::new(&SensorView { sensor: Vector3::zeros(), points: points.collect() }, config)
    }

    #[test]
    fn a_sphere_out_of_sight_has_no_place_of_which_a_ray_tells() {
        let config = ChangesConfig::default();
        let image = two_walls(&config);
        let mut rng = RngTree::new(3).child("spheres").rng();
        let (mut out, mut in_sight) = (0, 0);
        for _ in 0..600 {
            let middle = [8.0 * rng.uniform() - 1.0, 6.0 * rng.uniform() - 3.0, 2.0 * rng.uniform() - 1.0];
            let mut near = || middle.map(|at| (at + 0.6 * rng.uniform()) as f32);
            let places: Vec<[f32; 3]> = (0..20).map(|_| near()).collect();
            let tells = |place: &[f32; 3]| {
                let rays = image.passing(place, &|| None, config.ray_reach_m, &config);
                rays.through + rays.ended > 0
            };
            if image.is_out_of_sight(&Sphere::around(places.iter()), config.ray_reach_m, &config) {
                assert!(!places.iter().any(tells), "{middle:?}");
                out += 1;
            } else {
                in_sight += usize::from(places.iter().any(tells));
            }
        }
        assert!(out > 50 && in_sight > 100, "{out} {in_sight}");
        let far = Sphere::around([[30.0, 0.0, 0.0]].iter());
        assert!(image.is_out_of_sight(&far, config.ray_reach_m, &config), "beyond the largest range");
    }

    #[test]
    fn only_places_without_a_line_of_sight_are_left_out_early() {
        let config = ChangesConfig::default();
        let image = two_walls(&config);
        let mut all = image.clone();
        all.farthest.ranges_m.fill(f32::INFINITY);
        let (mut left_out, mut passed) = (0, 0);
        for x in [1.9_f32, 2.1, 2.5, 3.5, 4.9, 5.1] {
            for y in (-40..40).map(|y| y as f32 * 0.05) {
                let place = [x, y, 0.12];
                let [early, slow] =
                    [&image, &all].map(|image| image.passing(&place, &|| None, config.ray_reach_m, &config));
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
            image.passing(&place, &|| None, config.ray_reach_m, &config),
            PassingRays { through: expected, ended: 0, blocked: 0 }
        );
        assert!(expected > 10);
    }
}
