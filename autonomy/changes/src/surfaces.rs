//! The surfaces of a visit: whether there is one near a place.

use crate::ChangesConfig;
use crate::alignment::RegionalErrors;
use crate::columns::{Columns, SIDE_M};
use crate::join::Join;
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

    /// Cells of the grid of surfaces for each metre.
    fn cells_per_m(&self) -> f32 {
        1.0 / self.largest_m
    }

    /// The distance at a place, metres (docs/maths/changes.md, equation 7).
    fn at(&self, place: &[f32; 3]) -> f32 {
        self.errors.as_ref().map_or(self.least_m, |errors| self.of_deviation(errors.deviation_m(place)))
    }
}

/// Points of a visit in a grid.
pub(crate) struct Surfaces {
    tolerance: SurfaceTolerance,
    /// Each cell with its place in `starts`.
    index: CellTable,
    /// Place of the first point of each cell, in their order, and the number of points.
    starts: Vec<usize>,
    /// The points, sorted by cell within each column. A column consists of whole cells.
    columns: Columns,
}

impl Surfaces {
    /// The surfaces that these points are on. The side of a cell is the largest distance of the tolerance. `O(n log n)` in the points of a column.
    pub(crate) fn new(points: impl IntoIterator<Item = [f32; 3]>, tolerance: SurfaceTolerance) -> Self {
        let per_m = tolerance.cells_per_m();
        let mut columns = Columns::of_cells(points, per_m, (SIDE_M * per_m).ceil() as i32);
        let mut index = CellTable::default();
        let mut starts = Vec::new();
        let mut place = 0;
        let mut keyed: Vec<(CellKey, [f32; 3])> = Vec::new();
        for column in columns.each_mut() {
            keyed.clear();
            keyed.extend(column.iter().map(|point| (CellKey::of_point(point, per_m), *point)));
            keyed.sort_by_key(|(cell, _)| *cell);
            for of_cell in keyed.chunk_by(|a, b| a.0 == b.0) {
                index.get_or_insert(of_cell[0].0, starts.len() as u32);
                starts.push(place);
                place += of_cell.len();
            }
            column.iter_mut().zip(&keyed).for_each(|(place, (_, point))| *place = *point);
        }
        starts.push(place);
        Self { tolerance, index, starts, columns }
    }

    /// Whether a surface is the same as that at a place. Linear in the points of the 27 cells around.
    pub(crate) fn is_near(&self, place: &[f32; 3]) -> bool {
        self.around(CellKey::of_point(place, self.tolerance.cells_per_m())).has(place, &self.tolerance)
    }

    /// For each of the points of other surfaces of the same tolerance whether a surface is the same as that there. Linear in these points, and in those of the cells around.
    pub(crate) fn are_near(&self, other: &Self, join: &impl Join) -> Vec<bool> {
        let middle = other.starts.len() / 2;
        let (first, second) = (&other.starts[..=middle], &other.starts[middle..]);
        let (mut are_near, others) =
            join.join(|| self.are_near_of_cells(other, first), || self.are_near_of_cells(other, second));
        are_near.extend(others);
        are_near
    }

    /// The same of some cells, by the places of their first points and the one after the last.
    fn are_near_of_cells(&self, other: &Self, starts: &[usize]) -> Vec<bool> {
        let mut are_near = Vec::new();
        for ends in starts.windows(2) {
            let points = &other.points()[ends[0]..ends[1]];
            // A cell has a point at least.
            let mut around = self.around(CellKey::of_point(&points[0], self.tolerance.cells_per_m()));
            are_near.extend(points.iter().map(|point| around.has(point, &self.tolerance)));
        }
        are_near
    }

    fn around(&self, cell: CellKey) -> CellsAround<'_> {
        CellsAround { surfaces: self, cell, own: self.of_cell(cell), others: None }
    }

    /// Within which distance surfaces at a place are the same, metres.
    pub(crate) fn tolerance_m(&self, place: &[f32; 3]) -> f32 {
        self.tolerance.at(place)
    }

    /// The points of the 26 cells beside a cell, without those that are empty.
    fn beside(&self, cell: CellKey) -> Vec<&[[f32; 3]]> {
        let middle = cell.cell();
        let steps = [0, -1, 1];
        let offsets = steps
            .into_iter()
            .flat_map(|x| steps.into_iter().flat_map(move |y| steps.map(move |z| [x, y, z])));
        let cells = offsets
            .skip(1)
            .map(|offset| CellKey::new(std::array::from_fn(|axis| middle[axis] + offset[axis])));
        cells.map(|cell| self.of_cell(cell)).filter(|points| !points.is_empty()).collect()
    }

    /// Unit normal of the surface at a place: the direction in which the points of the 27 cells around spread least. None with fewer points than that. Linear in those points.
    pub(crate) fn normal(&self, place: &[f32; 3], min_points: f64) -> Option<[f32; 3]> {
        let middle = CellKey::of_point(place, self.tolerance.cells_per_m()).cell();
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
        let Some(place) = self.index.get(cell).map(|place| place as usize) else { return &[] };
        &self.points()[self.starts[place]..self.starts[place + 1]]
    }

    /// All points.
    pub(crate) fn points(&self) -> &[[f32; 3]] {
        self.columns.points()
    }

    /// The points in columns.
    pub(crate) fn columns(&self) -> &Columns {
        &self.columns
    }
}

/// The points of a cell and of the cells around it, which are looked up when they are needed first: most places have a surface in their own cell.
struct CellsAround<'a> {
    surfaces: &'a Surfaces,
    cell: CellKey,
    own: &'a [[f32; 3]],
    others: Option<Vec<&'a [[f32; 3]]>>,
}

impl CellsAround<'_> {
    /// Whether there is a surface that is the same as that at a place in the cell.
    fn has(&mut self, place: &[f32; 3], tolerance: &SurfaceTolerance) -> bool {
        let is_within = |points: &[[f32; 3]], distance_m: f32| {
            points.iter().any(|point| squared_distance(point, place) <= distance_m * distance_m)
        };
        // The least distance first: most places have a surface within it.
        if is_within(self.own, tolerance.least_m) {
            return true;
        }
        let others = self.others.get_or_insert_with(|| self.surfaces.beside(self.cell));
        if others.iter().any(|points| is_within(points, tolerance.least_m)) {
            return true;
        }
        let distance_m = tolerance.at(place);
        distance_m > tolerance.least_m
            && (is_within(self.own, distance_m) || others.iter().any(|points| is_within(points, distance_m)))
    }
}

pub(crate) fn squared_distance(a: &[f32; 3], b: &[f32; 3]) -> f32 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::join::InTurn;
    use geometry::RngTree;

    #[test]
    fn a_surface_is_near_within_the_radius_across_the_borders_of_cells() {
        let surfaces = Surfaces::new([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], SurfaceTolerance::uniform(0.15));
        assert!(surfaces.is_near(&[0.1, -0.1, 0.0]));
        assert!(!surfaces.is_near(&[0.1, -0.1, 0.1]));
        assert!(surfaces.is_near(&[1.0, 1.14, 1.0]));
        assert!(!surfaces.is_near(&[1.0, 1.16, 1.0]));
        assert!(!Surfaces::new([], SurfaceTolerance::uniform(0.15)).is_near(&[0.0; 3]));
    }

    #[test]
    fn all_points_are_asked_at_once_as_one_after_the_other() {
        let mut rng = RngTree::new(5).child("surfaces").rng();
        let mut cloud = || -> Vec<[f32; 3]> {
            (0..4_000)
                .map(|_| [rng.normal() * 2.0, rng.normal(), 0.1 * rng.normal()].map(|at| at as f32))
                .collect()
        };
        let tolerance = SurfaceTolerance::uniform(0.09);
        let [before, after] = [cloud(), cloud()].map(|cloud| Surfaces::new(cloud, tolerance.clone()));
        let one_by_one: Vec<bool> = after.points().iter().map(|point| before.is_near(point)).collect();
        assert_eq!(before.are_near(&after, &InTurn), one_by_one);
        let is_near = |point: &[f32; 3]| {
            before.points().iter().any(|other| squared_distance(point, other) <= 0.09 * 0.09)
        };
        assert_eq!(one_by_one, after.points().iter().map(is_near).collect::<Vec<_>>());
        let near = one_by_one.iter().filter(|is_near| **is_near).count();
        assert!(near > 400 && near < 3_600, "{near}");
    }
}
