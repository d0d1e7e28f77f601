//! The surfaces of a visit: whether there is one near a place.

use crate::ChangesConfig;
use crate::alignment::RegionalErrors;
use geometry::{Matrix3, Vector3};
use points::hash::{CellKey, CellTable};

/// Within which distance two surfaces are the same, by region: from the remaining error of the poses and the noise of the sensor.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceTolerance {
    /// Least distance, metres.
    least_m: f32,
    /// Largest distance, metres.
    largest_m: f32,
    resolution_m: f64,
    noise_m: f64,
    deviations: f64,
    errors: Option<RegionalErrors>,
}

impl SurfaceTolerance {
    /// One distance everywhere, metres.
    pub(crate) fn uniform(distance_m: f32) -> Self {
        Self {
            least_m: distance_m,
            largest_m: distance_m,
            resolution_m: 0.0,
            noise_m: 0.0,
            deviations: 0.0,
            errors: None,
        }
    }

    /// The distances for visits that are this far from each other.
    pub(crate) fn new(errors: RegionalErrors, config: &ChangesConfig) -> Self {
        let mut tolerance = Self {
            least_m: config.same_surface_m as f32,
            largest_m: config.max_same_surface_m as f32,
            resolution_m: config.resolution_m,
            noise_m: config.range_noise_m,
            deviations: config.same_surface_deviations,
            errors: None,
        };
        tolerance.largest_m = tolerance.of_deviation(errors.largest_m());
        tolerance.errors = Some(errors);
        tolerance
    }

    fn of_deviation(&self, deviation_m: f64) -> f32 {
        let deviation_m = deviation_m.hypot(self.noise_m);
        ((self.deviations * deviation_m + self.resolution_m) as f32).clamp(self.least_m, self.largest_m)
    }

    /// The distance at a place, metres (docs/maths/changes.md, equation 7).
    fn at(&self, place: &[f32; 3]) -> f32 {
        self.errors.as_ref().map_or(self.least_m, |errors| self.of_deviation(errors.deviation_m(place)))
    }
}

/// Points of a visit in a grid.
pub(crate) struct Surfaces {
    tolerance: SurfaceTolerance,
    /// First point of each cell in `points`, which are sorted by cell.
    index: CellTable,
    cells: Vec<CellKey>,
    points: Vec<[f32; 3]>,
}

impl Surfaces {
    /// The surfaces that these points are on. The side of a cell is the largest distance of the tolerance. `O(n log n)`.
    pub(crate) fn new(points: impl IntoIterator<Item = [f32; 3]>, tolerance: SurfaceTolerance) -> Self {
        let per_m = 1.0 / tolerance.largest_m;
        let mut keyed: Vec<(CellKey, [f32; 3])> =
            points.into_iter().map(|point| (CellKey::of_point(&point, per_m), point)).collect();
        keyed.sort_by_key(|(cell, _)| *cell);
        let mut index = CellTable::with_capacity(keyed.len() / 4);
        for (place, (cell, _)) in keyed.iter().enumerate() {
            if place == 0 || keyed[place - 1].0 != *cell {
                index.get_or_insert(*cell, place as u32);
            }
        }
        let (cells, points) = keyed.into_iter().unzip();
        Self { tolerance, index, cells, points }
    }

    /// Whether a surface is the same as that at a place. Linear in the points of the 27 cells around.
    pub(crate) fn is_near(&self, place: &[f32; 3]) -> bool {
        // The least distance first: most places have a surface within it.
        self.is_within(place, self.tolerance.least_m)
            || self.tolerance.largest_m > self.tolerance.least_m
                && self.is_within(place, self.tolerance.at(place))
    }

    fn is_within(&self, place: &[f32; 3], distance_m: f32) -> bool {
        let middle = self.cell_of(place);
        let square = distance_m * distance_m;
        // The cell itself first: most places have a surface there.
        let steps = [0, -1, 1];
        steps
            .into_iter()
            .flat_map(|x| steps.into_iter().flat_map(move |y| steps.map(move |z| [x, y, z])))
            .any(|offset| {
                let cell = CellKey::new(std::array::from_fn(|axis| middle[axis] + offset[axis]));
                self.of_cell(cell).iter().any(|point| squared_distance(point, place) <= square)
            })
    }

    /// Within which distance surfaces at a place are the same, metres.
    pub(crate) fn tolerance_m(&self, place: &[f32; 3]) -> f32 {
        self.tolerance.at(place)
    }

    fn cell_of(&self, place: &[f32; 3]) -> [i64; 3] {
        CellKey::of_point(place, 1.0 / self.tolerance.largest_m).cell()
    }

    /// Unit normal of the surface at a place: the direction in which the points of the 27 cells around spread least. None with fewer points than that. Linear in those points.
    pub(crate) fn normal(&self, place: &[f32; 3], min_points: f64) -> Option<[f32; 3]> {
        let middle = self.cell_of(place);
        let (mut count, mut sum, mut squares) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for offset in (-1..=1).flat_map(|x| (-1..=1).flat_map(move |y| (-1..=1).map(move |z| [x, y, z]))) {
            let cell = CellKey::new(std::array::from_fn(|axis| middle[axis] + offset[axis]));
            for point in self.of_cell(cell) {
                let at = Vector3::from_fn(|axis, _| f64::from(point[axis] - place[axis]));
                count += 1.0;
                sum += at;
                squares += at * at.transpose();
            }
        }
        if count < min_points {
            return None;
        }
        let spread = squares / count - (sum / count) * (sum / count).transpose();
        let eigen = spread.try_symmetric_eigen(1e-12, 100)?;
        let least = eigen.eigenvalues.imin();
        Some(eigen.eigenvectors.column(least).map(|at| at as f32).into())
    }

    fn of_cell(&self, cell: CellKey) -> &[[f32; 3]] {
        let Some(first) = self.index.get(cell).map(|place| place as usize) else { return &[] };
        let count = self.cells[first..].iter().take_while(|other| **other == cell).count();
        &self.points[first..first + count]
    }

    /// All points.
    pub(crate) fn points(&self) -> &[[f32; 3]] {
        &self.points
    }
}

pub(crate) fn squared_distance(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_is_near_within_the_radius_across_the_borders_of_cells() {
        let surfaces = Surfaces::new([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], SurfaceTolerance::uniform(0.15));
        assert!(surfaces.is_near(&[0.1, -0.1, 0.0]));
        assert!(!surfaces.is_near(&[0.1, -0.1, 0.1]));
        assert!(surfaces.is_near(&[1.0, 1.14, 1.0]));
        assert!(!surfaces.is_near(&[1.0, 1.16, 1.0]));
        assert!(!Surfaces::new([], SurfaceTolerance::uniform(0.15)).is_near(&[0.0; 3]));
    }
}
