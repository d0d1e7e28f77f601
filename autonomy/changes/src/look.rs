//! Which places the rays of a look went through.

use crate::ChangesConfig;
use crate::visit::Look;
use geometry::Vector3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// What a look tells of a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Evidence {
    /// All rays near its direction ended behind it.
    Free,
    /// A ray ended near it.
    Occupied,
    /// Nothing: no rays went there, or they ended before it.
    Unknown,
}

/// The nearest range in each cell of directions around the sensor of a look.
pub(crate) struct LookImage {
    sensor: Vector3,
    cell_rad: f64,
    columns: usize,
    rows: usize,
    /// Metres; infinite where no ray returned.
    ranges: Vec<f32>,
}

impl LookImage {
    /// The image of a look. Its cells are as large as the mean distance between rays, so that nine of them hold several rays. Linear in the points.
    pub(crate) fn new(look: &Look, config: &ChangesConfig) -> Self {
        let rays: Vec<(f64, f64, f64)> =
            look.points.iter().filter_map(|point| direction(&look.sensor, point)).collect();
        let cell_rad =
            ray_distance_rad(&rays, config.density_cell_rad).clamp(config.cell_rad[0], config.cell_rad[1]);
        let (columns, rows) = ((TAU / cell_rad).ceil() as usize, (PI / cell_rad).ceil() as usize);
        let mut image = Self {
            sensor: look.sensor,
            cell_rad,
            columns,
            rows,
            ranges: vec![f32::INFINITY; columns * rows],
        };
        for (azimuth, elevation, range_m) in rays {
            let (column, row) = image.cell(azimuth, elevation);
            let nearest = &mut image.ranges[row * columns + column];
            *nearest = nearest.min(range_m as f32);
        }
        image
    }

    fn cell(&self, azimuth: f64, elevation: f64) -> (usize, usize) {
        let column = ((azimuth + PI) / self.cell_rad) as usize;
        let row = ((elevation + FRAC_PI_2) / self.cell_rad) as usize;
        (column.min(self.columns - 1), row.min(self.rows - 1))
    }

    /// What the look tells of a place, metres, map frame: constant time.
    pub(crate) fn evidence(&self, place: &[f32; 3], config: &ChangesConfig) -> Evidence {
        let Some((azimuth, elevation, range_m)) = direction(&self.sensor, place) else {
            return Evidence::Unknown;
        };
        let is_in_range = (config.range_min_m..=config.range_max_m).contains(&range_m);
        if !is_in_range || self.cell_rad * range_m > config.ray_distance_max_m {
            return Evidence::Unknown;
        }
        let (column, row) = self.cell(azimuth, elevation);
        let margin_m = config.free_margin_m + config.free_margin_share * range_m;
        let (mut returned, mut is_near, mut nearest_m) = (0, false, f64::INFINITY);
        // Whether there are rays on either side: below and above, left and right.
        let mut sides = [false; 4];
        for (vertical, row) in (row.saturating_sub(1)..=(row + 1).min(self.rows - 1)).enumerate() {
            for (horizontal, offset) in [self.columns - 1, 0, 1].into_iter().enumerate() {
                let range = f64::from(self.ranges[row * self.columns + (column + offset) % self.columns]);
                if range.is_finite() {
                    returned += 1;
                    sides[0] |= vertical == 0;
                    sides[1] |= vertical == 2;
                    sides[2] |= horizontal == 0;
                    sides[3] |= horizontal == 2;
                    is_near |= (range - range_m).abs() <= margin_m;
                    nearest_m = nearest_m.min(range);
                }
            }
        }
        if returned < config.cells_min {
            Evidence::Unknown
        } else if nearest_m > range_m + margin_m && sides == [true; 4] {
            Evidence::Free
        } else if is_near {
            Evidence::Occupied
        } else {
            Evidence::Unknown
        }
    }
}

/// Azimuth and elevation (radians) and range (metres) of a point from a sensor; none at the sensor itself.
fn direction(sensor: &Vector3, point: &[f32; 3]) -> Option<(f64, f64, f64)> {
    let offset = Vector3::from(point.map(f64::from)) - sensor;
    let range_m = offset.norm();
    (range_m > 1e-3 && range_m.is_finite())
        .then(|| (offset.y.atan2(offset.x), (offset.z / range_m).clamp(-1.0, 1.0).asin(), range_m))
}

/// Mean distance between neighbouring rays: the square root of the solid angle in which there are rays over their number.
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
    fn wall() -> LookImage {
        let points = (-60..60).flat_map(|y| (-20..20).map(move |z| [5.0, y as f32 * 0.05, z as f32 * 0.05]));
        LookImage::new(
            &Look { sensor: Vector3::zeros(), points: points.collect() },
            &ChangesConfig::default(),
        )
    }

    #[test]
    fn rays_go_through_places_before_the_wall_and_tell_nothing_of_those_behind_and_beside_it() {
        let (image, config) = (wall(), ChangesConfig::default());
        assert_eq!(image.evidence(&[3.0, 0.2, 0.1], &config), Evidence::Free);
        assert_eq!(image.evidence(&[5.0, 0.2, 0.1], &config), Evidence::Occupied);
        assert_eq!(image.evidence(&[4.95, 0.2, 0.1], &config), Evidence::Occupied);
        assert_eq!(image.evidence(&[6.0, 0.2, 0.1], &config), Evidence::Unknown, "behind");
        assert_eq!(image.evidence(&[-3.0, 0.2, 0.1], &config), Evidence::Unknown, "no rays");
        assert_eq!(image.evidence(&[0.2, 0.0, 0.0], &config), Evidence::Unknown, "the robot itself");
        assert_eq!(image.evidence(&[f32::NAN, 0.0, 0.0], &config), Evidence::Unknown);
    }
}
