//! What a sensor saw from one place, as an image of ranges: enough to say of any point whether it stands where a ray went
//! through.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

/// Columns of 2 degrees.
const COLUMNS: usize = 180;
/// Rows of 3 degrees from [`BOTTOM`] up: 48 degrees either way, more than a spinning LiDAR for robots sees.
const ROWS: usize = 32;
const ROW: f32 = 3.0 * PI / 180.0;
const BOTTOM: f32 = -48.0 * PI / 180.0;
/// A ray passed through a point if it ended so much farther: metres, and a share of the range for slanting surfaces.
const MARGIN: (f32, f32) = (0.3, 0.05);

/// What an image says of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occupancy {
    /// All rays near the point's direction ended well behind it: nothing stands there.
    Free,
    /// A ray ended near it.
    Occupied,
    /// Something stood before it.
    Occluded,
    /// No ray went that way.
    Unobserved,
}

/// Nearest range in each cell of directions about a sensor, in the axes of the base. 11.5 kB.
#[derive(Clone, Debug, PartialEq)]
pub struct RangeImage {
    sensor: [f32; 3],
    /// Centimetres, rounded down; 0 where nothing returned.
    cells: Arc<[u16]>,
}

impl RangeImage {
    /// Of a motion-corrected cloud (base frame, metres) seen from `sensor` (base frame). Points that are not finite or
    /// out of the image are skipped.
    pub fn new<'a>(xyz: impl IntoIterator<Item = &'a [f32; 3]>, sensor: [f32; 3]) -> Self {
        let mut cells = vec![0_u16; COLUMNS * ROWS];
        for point in xyz {
            let Some((column, row, range)) = direction(point, &sensor) else { continue };
            let cell = &mut cells[row * COLUMNS + column];
            let centimetres = (range * 100.0).clamp(1.0, f32::from(u16::MAX)) as u16;
            if *cell == 0 || centimetres < *cell {
                *cell = centimetres;
            }
        }
        Self { sensor, cells: cells.into() }
    }

    /// From what [`Self::cells`] gave; none if that is not of the right size.
    pub fn from_cells(cells: Arc<[u16]>, sensor: [f32; 3]) -> Option<Self> {
        (cells.len() == COLUMNS * ROWS).then_some(Self { sensor, cells })
    }

    /// Row by row the nearest range in each cell, centimetres; 0 where nothing returned.
    pub fn cells(&self) -> &Arc<[u16]> {
        &self.cells
    }

    /// Where the sensor is, base frame, metres.
    pub fn sensor(&self) -> [f32; 3] {
        self.sensor
    }

    /// What the image says of a point, base frame, metres.
    pub fn classify(&self, point: &[f32; 3]) -> Occupancy {
        let Some(around) = self.around(point) else { return Occupancy::Unobserved };
        if around.range < around.nearest - around.margin {
            Occupancy::Free
        } else if around.range <= around.nearest + around.margin {
            Occupancy::Occupied
        } else {
            Occupancy::Occluded
        }
    }

    /// As [`Self::look`], but at the edge of what the sensor sees, above or below, it says that nothing was seen: where rays went on either
    /// side, whatever is thicker than they are apart would have been met.
    pub fn classify_interior(&self, point: &[f32; 3]) -> Occupancy {
        let is_seen = |row: usize, column: usize| self.cells[row * COLUMNS + column] != 0;
        let inside = direction(point, &self.sensor).is_some_and(|(column, row, _)| {
            (1..ROWS - 1).contains(&row) && is_seen(row - 1, column) && is_seen(row + 1, column)
        });
        if inside { self.classify(point) } else { Occupancy::Unobserved }
    }

    /// Whether the sensor saw what a point, base frame, metres, lies on: surfaces near its direction lie both before and
    /// behind it, or at it. Kinder than [`Self::look`] to walls seen at a slant.
    pub fn observes(&self, point: &[f32; 3]) -> bool {
        self.around(point).is_some_and(|around| {
            (around.nearest - around.margin..=around.farthest + around.margin).contains(&around.range)
        })
    }

    /// None where no ray went near the point.
    fn around(&self, point: &[f32; 3]) -> Option<Around> {
        let (column, row, range) = direction(point, &self.sensor)?;
        if self.cells[row * COLUMNS + column] == 0 {
            return None;
        }
        // The neighbours' nearest too: a thin thing or an edge may lie just beside the cell that the point falls into.
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
        let [nearest, farthest] = [nearest, farthest].map(|cell| f32::from(cell) * 0.01);
        Some(Around { range, nearest, farthest, margin: MARGIN.0 + MARGIN.1 * range })
    }
}

/// A point's range, those of the nearest and farthest cell about it, and how much they may differ, metres.
struct Around {
    range: f32,
    nearest: f32,
    farthest: f32,
    margin: f32,
}

/// Column, row and range of a point seen from the sensor.
#[inline]
fn direction(point: &[f32; 3], sensor: &[f32; 3]) -> Option<(usize, usize, f32)> {
    let [x, y, z] = [0, 1, 2].map(|axis| point[axis] - sensor[axis]);
    let level = (x * x + y * y).sqrt();
    let range = (level * level + z * z).sqrt();
    // Not finite, or in the sensor itself.
    if !(range > 0.05 && range < 1e4) {
        return None;
    }
    let row = ((z.atan2(level) - BOTTOM) / ROW).floor();
    if !(0.0..ROWS as f32).contains(&row) {
        return None;
    }
    let column = ((y.atan2(x) + PI) * (COLUMNS as f32 / TAU)) as usize;
    Some((column.min(COLUMNS - 1), row as usize, range))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall 6 m ahead, 8 m wide, with a pole 4 cm thick 3 m ahead.
    fn seen() -> RangeImage {
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
    fn what_stands_where_rays_went_through_is_told_from_what_was_met_or_hidden() {
        let image = seen();
        assert_eq!(image.classify(&[4.0, 1.5, 0.5]), Occupancy::Free);
        assert_eq!(image.classify(&[5.9, 1.5, 0.5]), Occupancy::Occupied);
        assert_eq!(image.classify(&[9.0, 1.5, 0.5]), Occupancy::Occluded);
        assert_eq!(image.classify(&[-4.0, 0.0, 0.5]), Occupancy::Unobserved);
        assert!(
            image.observes(&[5.9, 1.5, 0.5])
                && !image.observes(&[9.0, 1.5, 0.5])
                && !image.observes(&[4.0, 1.5, 0.5])
        );
        assert!(!image.observes(&[-4.0, 0.0, 0.5]) && image.observes(&[6.0, 0.05, 0.5]), "beside the pole");
        assert_eq!(image.classify_interior(&[4.0, 1.5, 0.5]), Occupancy::Free);
        let top = [3.0, 1.5, 1.15];
        assert_eq!(
            (image.classify(&top), image.classify_interior(&top)),
            (Occupancy::Free, Occupancy::Unobserved),
            "the highest ray"
        );
        // The pole protects itself and what is beside it.
        assert_eq!(image.classify(&[3.0, 0.05, 0.5]), Occupancy::Occupied);
    }

    #[test]
    fn broken_points_say_nothing() {
        let image = RangeImage::new(&[[f32::NAN; 3], [f32::INFINITY, 0.0, 0.0], [0.0, 0.0, 50.0]], [0.0; 3]);
        assert_eq!(image.classify(&[1.0, 0.0, 0.0]), Occupancy::Unobserved);
        assert_eq!(image.classify(&[f32::NAN, 0.0, 0.0]), Occupancy::Unobserved);
    }
}
