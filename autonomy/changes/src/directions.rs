//! Directions around a sensor, in coordinates that need no trigonometry, and a grid of them.
//!
//! Azimuth and elevation are angles of plane vectors. The coordinate of an angle is the part of the vector's taxicab length that lies along the second axis, counted on through the quadrants: a right
//! angle is 1, and the coordinate grows by 0.5 to 1 for each radian (docs/maths/changes.md, equation 8). So what is within an angle is within that coordinate.

use std::ops::Range;

/// More than the error of a coordinate by its single precision.
const ROUNDING: f32 = 1e-6;

/// A direction from a sensor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Direction {
    /// Coordinate of the azimuth, -2 to 2.
    pub(crate) around: f32,
    /// Coordinate of the elevation, -1 to 1.
    pub(crate) up: f32,
}

/// An offset from a sensor as a direction and distances.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bearing {
    pub(crate) direction: Direction,
    /// Distance, metres.
    pub(crate) range_m: f32,
    /// Horizontal distance, metres.
    pub(crate) level_m: f32,
}

impl Bearing {
    /// Of an offset from the sensor, metres; none at the sensor itself and of an offset that is not finite.
    pub(crate) fn of(&[x, y, z]: &[f32; 3]) -> Option<Self> {
        let level_m2 = x * x + y * y;
        let (level_m, range_m) = (level_m2.sqrt(), (level_m2 + z * z).sqrt());
        if !(range_m > 1e-3 && range_m.is_finite()) {
            return None;
        }
        let share = |part: f32, other: f32| if part == 0.0 { 0.0 } else { part / (part.abs() + other.abs()) };
        let forward = share(y, x);
        let around = match (x < 0.0, y < 0.0) {
            (false, _) => forward,
            (true, false) => 2.0 - forward,
            (true, true) => -2.0 - forward,
        };
        Some(Self { direction: Direction { around, up: share(z, level_m) }, range_m, level_m })
    }

    /// How far the coordinates of what comes within a distance of the offset, metres, are from its own at most: of the azimuth, which is infinite if that is above or below the sensor, and of the
    /// elevation.
    pub(crate) fn reach(&self, within_m: f32) -> [f32; 2] {
        // The tangent of an angle is at least the angle.
        let tangent = |distance_m: f32| {
            let adjacent = (distance_m * distance_m - within_m * within_m).max(0.0).sqrt();
            if adjacent > 0.0 { within_m / adjacent } else { f32::INFINITY }
        };
        // A coordinate grows by t² + (1 - t)² for each radian, where t is its distance from the axis, and t by no more than the angle.
        let of_coordinate = |at: f32, angle_rad: f32| {
            let from_axis = at.abs().fract();
            let growth = 1.0 - 2.0 * from_axis * (1.0 - from_axis) + 2.0 * angle_rad;
            growth.min(1.0) * angle_rad + ROUNDING
        };
        let Direction { around, up } = self.direction;
        [of_coordinate(around, tangent(self.level_m)), of_coordinate(up, tangent(self.range_m))]
    }
}

/// Cells of directions, square in the coordinates, row by row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DirectionGrid {
    side: f32,
    cells_per_unit: f32,
    columns: usize,
    rows: usize,
}

impl DirectionGrid {
    /// A grid with as many columns as fit into a full turn if each had this angle, radians.
    pub(crate) fn new(cell_rad: f64) -> Self {
        let columns = (std::f64::consts::TAU / cell_rad).ceil().max(1.0) as usize;
        // The columns fill the turn exactly, so that the last one and the first one are neighbours.
        let side = 4.0 / columns as f32;
        Self { side, cells_per_unit: columns as f32 / 4.0, columns, rows: columns.div_ceil(2) }
    }

    /// Number of columns.
    pub(crate) fn columns(&self) -> usize {
        self.columns
    }

    /// Number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// Column and row of a direction.
    pub(crate) fn cell(&self, direction: &Direction) -> (usize, usize) {
        let [column, row] =
            [direction.around + 2.0, direction.up + 1.0].map(|at| (at * self.cells_per_unit) as usize);
        (column.min(self.columns - 1), row.min(self.rows - 1))
    }

    /// The rows, and the first column and the number of columns, of all directions whose coordinates differ from those of a direction by at most this much. After the last column comes the first one.
    pub(crate) fn window(&self, direction: &Direction, reach: [f32; 2]) -> (Range<usize>, usize, usize) {
        let row = |up: f32| (((up + 1.0) * self.cells_per_unit) as usize).min(self.rows - 1);
        let rows = row(direction.up - reach[1])..row(direction.up + reach[1]) + 1;
        if 2.0 * (reach[0] + self.side) >= 4.0 {
            return (rows, 0, self.columns);
        }
        // A turn more, so that the coordinate is positive.
        let column = |around: f32| ((around + 6.0) * self.cells_per_unit) as usize;
        let (first, last) = (column(direction.around - reach[0]), column(direction.around + reach[0]));
        (rows, first % self.columns, (last + 1 - first).min(self.columns))
    }

    /// Solid angle of a cell, steradians, to the first order in its side (docs/maths/changes.md, equation 9).
    pub(crate) fn solid_angle(&self, column: usize, row: usize) -> f64 {
        let middle = |cell: usize, zero: f64| (cell as f64 + 0.5) * f64::from(self.side) - zero;
        let (around, up) = (middle(column, 2.0).abs(), middle(row, 1.0).abs().min(1.0));
        let length = |share: f64| 1.0 / share.hypot(1.0 - share);
        let azimuth = length(around.fract()).powi(2);
        let elevation = (1.0 - up) * length(up).powi(3);
        azimuth * elevation * f64::from(self.side).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{RngTree, Vector3};
    use std::f64::consts::PI;

    fn single(offset: &Vector3) -> [f32; 3] {
        offset.map(|at| at as f32).into()
    }

    fn at(azimuth: f64, elevation: f64) -> Bearing {
        let flat = elevation.cos();
        let offset = Vector3::new(flat * azimuth.cos(), flat * azimuth.sin(), elevation.sin()) * 5.0;
        Bearing::of(&single(&offset)).expect("it is five metres away")
    }

    #[test]
    fn coordinates_grow_with_the_angles_and_no_faster_than_they_do() {
        let angles: Vec<f64> = (1..2_000).map(|step| f64::from(step) / 1_000.0 * PI - PI).collect();
        for pair in angles.windows(2) {
            let step = f64::from(at(pair[1], 0.3).direction.around - at(pair[0], 0.3).direction.around);
            let angle = pair[1] - pair[0];
            assert!(step > 0.499 * angle && step <= 1.001 * angle, "{pair:?} {step}");
            let [low, high] = [pair[0] / 2.0, pair[1] / 2.0];
            let step = f64::from(at(0.7, high).direction.up - at(0.7, low).direction.up);
            assert!(step > 0.249 * angle && step <= 0.501 * angle, "{pair:?} {step}");
        }
        assert!((at(PI / 2.0, 0.0).direction.around - 1.0).abs() < 1e-12);
        assert!((at(-PI / 2.0, 0.0).direction.around + 1.0).abs() < 1e-12);
        assert!((at(1.0, PI / 2.0).direction.up - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_window_holds_all_directions_within_reach_across_the_border_too() {
        let mut rng = RngTree::new(3).child("directions").rng();
        let grid = DirectionGrid::new(0.05);
        let mut outside = 0;
        for _ in 0..20_000 {
            let offset = Vector3::new(rng.normal(), rng.normal(), rng.normal()) * 3.0;
            let near = offset + Vector3::new(rng.normal(), rng.normal(), rng.normal()) * 0.5;
            let (Some(bearing), Some(other)) = (Bearing::of(&single(&offset)), Bearing::of(&single(&near)))
            else {
                continue;
            };
            let (rows, first, columns) = grid.window(&bearing.direction, bearing.reach(0.4));
            let (column, row) = grid.cell(&other.direction);
            let is_inside =
                rows.contains(&row) && (column + grid.columns() - first) % grid.columns() < columns;
            let is_near = offset.cross(&near.normalize()).norm() <= 0.4 && offset.dot(&near) > 0.0;
            assert!(is_inside || !is_near, "{offset:?} {near:?}");
            outside += usize::from(!is_inside);
        }
        assert!(outside > 500, "{outside}");
    }

    #[test]
    fn the_cells_cover_the_sphere() {
        for cell_rad in [0.02, 0.07, 0.2] {
            let grid = DirectionGrid::new(cell_rad);
            let cells = (0..grid.rows()).flat_map(|row| (0..grid.columns()).map(move |column| (column, row)));
            let all: f64 = cells.map(|(column, row)| grid.solid_angle(column, row)).sum();
            assert!((all / (4.0 * PI) - 1.0).abs() < 0.02, "{cell_rad} {all}");
        }
    }
}
