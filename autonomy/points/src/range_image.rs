//! The ranges that a sensor measured from one pose, as an image over directions. It tells for any point whether the sensor's rays passed through
//! it (free-space check).

use crate::angle::atan2;
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

/// Columns of the image, 2 degrees each. Part of the format of saved images.
const COLUMNS: usize = 180;
/// Rows of the image, 3 degrees each from [`BOTTOM_RAD`] up: 48 degrees up and down, more than a spinning LiDAR for robots covers.
/// Part of the format of saved images.
const ROWS: usize = 32;
const ROW_RAD: f32 = 3.0 * PI / 180.0;
const BOTTOM_RAD: f32 = -48.0 * PI / 180.0;
/// Number of points that are projected together.
const PROJECTION_BLOCK: usize = 16;
/// Cells store ranges in centimetres, rounded down. Part of the format of saved images.
const UNITS_PER_METRE: f32 = 100.0;
const METRES_PER_UNIT: f32 = 0.01;

/// Parameters of the free-space check.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeImageConfig {
    /// A ray passed through a point if it ended at least this distance behind the point, metres. Chosen: cells of 2 by 3 degrees hold surfaces at several ranges; smaller
    /// movements are not seen (docs/maths/localisation.md).
    pub free_space_margin_m: f32,
    /// Additional margin as a share of the point's range, for surfaces that are seen at a slant. Chosen: within a cell of 3 degrees, a surface at a slant of 45 degrees
    /// changes its range by 5 %.
    pub free_space_margin_share: f32,
    /// Points nearer to the sensor than this lie in the sensor itself and are skipped, metres. Chosen: the radius of a LiDAR's housing.
    pub min_range_m: f32,
    /// Points farther away than this are skipped, metres. Chosen: farther than any LiDAR sees.
    pub max_range_m: f32,
}

impl Default for RangeImageConfig {
    fn default() -> Self {
        Self { free_space_margin_m: 0.3, free_space_margin_share: 0.05, min_range_m: 0.05, max_range_m: 1e4 }
    }
}

/// Result of the free-space check of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occupancy {
    /// All rays near the point's direction ended well behind the point, so nothing is there.
    Free,
    /// A ray ended near the point.
    Occupied,
    /// The rays ended before the point.
    Occluded,
    /// No ray returned from that direction.
    Unobserved,
}

/// Nearest range in each cell of directions around a sensor. The axes are parallel to those of the base.
#[derive(Clone, Debug, PartialEq)]
pub struct RangeImage {
    config: RangeImageConfig,
    sensor: [f32; 3],
    /// Ranges in centimetres. 0 where no ray returned.
    cells: Arc<[u16]>,
}

impl RangeImage {
    /// Bytes that the cells of an image take: 11.5 kB.
    pub const BYTES: usize = COLUMNS * ROWS * size_of::<u16>();

    /// The image of a motion-corrected cloud (base frame, metres) seen from `sensor` (base frame, metres), with the default
    /// parameters. Points that are not finite or outside the image are skipped.
    pub fn new<'a>(xyz: impl IntoIterator<Item = &'a [f32; 3]>, sensor: [f32; 3]) -> Self {
        Self::choosing(u16::min, xyz, sensor)
    }

    /// As [`Self::new`], with the farthest range in each cell.
    pub(crate) fn of_farthest<'a>(xyz: impl IntoIterator<Item = &'a [f32; 3]>, sensor: [f32; 3]) -> Self {
        Self::choosing(u16::max, xyz, sensor)
    }

    /// The image in which each cell has what `choose` takes of two ranges.
    fn choosing<'a>(
        choose: impl Fn(u16, u16) -> u16,
        xyz: impl IntoIterator<Item = &'a [f32; 3]>,
        sensor: [f32; 3],
    ) -> Self {
        let config = RangeImageConfig::default();
        let mut cells = vec![0_u16; COLUMNS * ROWS];
        let mut points = xyz.into_iter();
        // Blocks of points without a branch among them are computed several at a time.
        let mut block = [[f32::NAN; 3]; PROJECTION_BLOCK];
        loop {
            let mut filled = 0;
            for (slot, point) in block.iter_mut().zip(&mut points) {
                *slot = *point;
                filled += 1;
            }
            let mut directions = [Direction::default(); PROJECTION_BLOCK];
            for (direction, point) in directions.iter_mut().zip(&block) {
                *direction = Direction::of(point, &sensor);
            }
            for direction in &directions[..filled] {
                let Some((column, row)) = direction.cell(&config) else { continue };
                let cell = &mut cells[row * COLUMNS + column];
                let centimetres =
                    (direction.range_m * UNITS_PER_METRE).clamp(1.0, f32::from(u16::MAX)) as u16;
                *cell = if *cell == 0 { centimetres } else { choose(*cell, centimetres) };
            }
            if filled < PROJECTION_BLOCK {
                break;
            }
        }
        Self { config, sensor, cells: cells.into() }
    }

    /// An image from the cells that [`Self::cells`] returned; `None` if their number is wrong.
    pub fn from_cells(cells: Arc<[u16]>, sensor: [f32; 3]) -> Option<Self> {
        let config = RangeImageConfig::default();
        (cells.len() == COLUMNS * ROWS).then_some(Self { config, sensor, cells })
    }

    /// The nearest range in each cell, row by row, centimetres. 0 where no ray returned.
    pub fn cells(&self) -> &Arc<[u16]> {
        &self.cells
    }

    /// Position of the sensor, base frame, metres.
    pub fn sensor(&self) -> [f32; 3] {
        self.sensor
    }

    /// Classifies a point (base frame, metres).
    pub fn classify(&self, point: &[f32; 3]) -> Occupancy {
        let Some(near) = self.neighbourhood(point) else { return Occupancy::Unobserved };
        if near.range_m < near.nearest_m - near.margin_m {
            Occupancy::Free
        } else if near.range_m <= near.nearest_m + near.margin_m {
            Occupancy::Occupied
        } else {
            Occupancy::Occluded
        }
    }

    /// Whether the sensor observed the surface at a point (base frame, metres): the ranges near its direction include the point's
    /// own, within the margin. More tolerant than [`Self::classify`] of walls seen at a slant.
    pub fn observes(&self, point: &[f32; 3]) -> bool {
        self.neighbourhood(point).is_some_and(|near| {
            (near.nearest_m - near.margin_m..=near.farthest_m + near.margin_m).contains(&near.range_m)
        })
    }

    /// The ranges near a point's direction; `None` where no ray returned from its own cell.
    fn neighbourhood(&self, point: &[f32; 3]) -> Option<Neighbourhood> {
        let (column, row, range_m) = self.project(point)?;
        if self.cells[row * COLUMNS + column] == 0 {
            return None;
        }
        let (nearest_m, farthest_m) = self.ranges_about(column, row)?;
        Some(Neighbourhood { range_m, nearest_m, farthest_m, margin_m: self.margin_m(range_m) })
    }

    /// Column, row and range of a point seen from the sensor; `None` outside the image.
    pub(crate) fn project(&self, point: &[f32; 3]) -> Option<(usize, usize, f32)> {
        let direction = Direction::of(point, &self.sensor);
        direction.cell(&self.config).map(|(column, row)| (column, row, direction.range_m))
    }

    /// The margin of the comparison with a point at this range, metres.
    pub(crate) fn margin_m(&self, range_m: f32) -> f32 {
        self.config.free_space_margin_m + self.config.free_space_margin_share * range_m
    }

    /// The range in a cell, metres; `None` where no ray returned, and outside the image.
    pub(crate) fn range_at(&self, column: usize, row: usize) -> Option<f32> {
        let cell = *self.cells.get(row * COLUMNS + column)?;
        (cell != 0).then(|| f32::from(cell) * METRES_PER_UNIT)
    }

    /// Nearest and farthest range in a cell and the eight about it, metres: a thin object or an edge may lie just beside the cell of a point. `None` where no ray returned.
    pub(crate) fn ranges_about(&self, column: usize, row: usize) -> Option<(f32, f32)> {
        let (mut nearest, mut farthest) = (u16::MAX, 0);
        for row in row.saturating_sub(1)..=(row + 1).min(ROWS - 1) {
            for step in [COLUMNS - 1, 0, 1] {
                let cell = self.cells[row * COLUMNS + (column + step) % COLUMNS];
                if cell != 0 {
                    nearest = nearest.min(cell);
                    farthest = farthest.max(cell);
                }
            }
        }
        let [nearest_m, farthest_m] = [nearest, farthest].map(|cell| f32::from(cell) * METRES_PER_UNIT);
        (farthest != 0).then_some((nearest_m, farthest_m))
    }
}

/// Range of a point, the nearest and farthest range in the nine cells about its direction, and the margin of the comparison.
struct Neighbourhood {
    range_m: f32,
    nearest_m: f32,
    farthest_m: f32,
    margin_m: f32,
}

/// A direction from the sensor, in columns and rows of the image, and the range in that direction.
#[derive(Clone, Copy, Default)]
struct Direction {
    column: f32,
    row: f32,
    range_m: f32,
}

impl Direction {
    #[inline]
    fn of(point: &[f32; 3], sensor: &[f32; 3]) -> Self {
        let [x, y, z] = [0, 1, 2].map(|axis| point[axis] - sensor[axis]);
        let horizontal = (x * x + y * y).sqrt();
        Self {
            column: (atan2(y, x) + PI) * (COLUMNS as f32 / TAU),
            row: (atan2(z, horizontal) - BOTTOM_RAD) / ROW_RAD,
            range_m: (horizontal * horizontal + z * z).sqrt(),
        }
    }

    /// Column and row of the cell. `None` outside the image, and for what is not a number.
    #[inline]
    fn cell(&self, config: &RangeImageConfig) -> Option<(usize, usize)> {
        let is_seen = self.range_m > config.min_range_m
            && self.range_m < config.max_range_m
            && (0.0..ROWS as f32).contains(&self.row);
        is_seen.then_some(((self.column as usize).min(COLUMNS - 1), self.row as usize))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall 6 m ahead and 8 m wide, and a pole 3 m ahead and 4 cm thick.
    fn wall_and_pole() -> RangeImage {
        let mut points = Vec::new();
        for i in -100..=100 {
            for j in -15..=15 {
                points.push([6.0, i as f32 * 0.04, 0.4 + j as f32 * 0.1]);
            }
        }
        points.extend((-15..=15).flat_map(|j| [-0.01, 0.02].map(|y| [3.0, y, 0.4 + j as f32 * 0.05])));
        RangeImage::new(&points, [0.1, 0.0, 0.4])
    }

    #[test]
    fn free_occupied_occluded_and_unobserved_points_are_distinguished() {
        let image = wall_and_pole();
        assert_eq!(image.classify(&[4.0, 1.5, 0.5]), Occupancy::Free);
        assert_eq!(image.classify(&[5.9, 1.5, 0.5]), Occupancy::Occupied);
        assert_eq!(image.classify(&[9.0, 1.5, 0.5]), Occupancy::Occluded);
        assert_eq!(image.classify(&[-4.0, 0.0, 0.5]), Occupancy::Unobserved);
        assert!(image.observes(&[5.9, 1.5, 0.5]));
        assert!(!image.observes(&[9.0, 1.5, 0.5]) && !image.observes(&[4.0, 1.5, 0.5]));
        assert!(!image.observes(&[-4.0, 0.0, 0.5]) && image.observes(&[6.0, 0.05, 0.5]), "beside the pole");
        assert_eq!(image.classify(&[3.0, 1.5, 1.15]), Occupancy::Free, "the highest ray");
        // The pole counts for the cells beside it too.
        assert_eq!(image.classify(&[3.0, 0.05, 0.5]), Occupancy::Occupied);
    }

    #[test]
    fn points_that_are_not_finite_or_outside_the_image_are_skipped() {
        let image = RangeImage::new(&[[f32::NAN; 3], [f32::INFINITY, 0.0, 0.0], [0.0, 0.0, 50.0]], [0.0; 3]);
        assert_eq!(image.classify(&[1.0, 0.0, 0.0]), Occupancy::Unobserved);
        assert_eq!(image.classify(&[f32::NAN, 0.0, 0.0]), Occupancy::Unobserved);
    }
}
