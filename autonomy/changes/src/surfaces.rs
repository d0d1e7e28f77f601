//! The surfaces of a visit: whether there is one near a place.

use geometry::{Matrix3, Vector3};
use points::hash::{CellKey, CellTable};

/// Points of a visit in a grid.
pub(crate) struct Surfaces {
    radius_m: f32,
    /// First point of each cell in `points`, which are sorted by cell.
    index: CellTable,
    cells: Vec<CellKey>,
    points: Vec<[f32; 3]>,
}

impl Surfaces {
    /// The surfaces that these points are on, for questions within this radius, metres. `O(n log n)`.
    pub(crate) fn new(points: impl IntoIterator<Item = [f32; 3]>, radius_m: f32) -> Self {
        let mut keyed: Vec<(CellKey, [f32; 3])> =
            points.into_iter().map(|point| (CellKey::of_point(&point, 1.0 / radius_m), point)).collect();
        keyed.sort_by_key(|(cell, _)| *cell);
        let mut index = CellTable::with_capacity(keyed.len() / 4);
        for (place, (cell, _)) in keyed.iter().enumerate() {
            if place == 0 || keyed[place - 1].0 != *cell {
                index.get_or_insert(*cell, place as u32);
            }
        }
        let (cells, points) = keyed.into_iter().unzip();
        Self { radius_m, index, cells, points }
    }

    /// Whether a point is within the radius of a place. Linear in the points of the 27 cells around.
    pub(crate) fn is_near(&self, place: &[f32; 3]) -> bool {
        let middle = CellKey::of_point(place, 1.0 / self.radius_m).cell();
        let square = self.radius_m * self.radius_m;
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

    /// Unit normal of the surface at a place: the direction in which the points of the 27 cells around spread least. None with fewer points than that. Linear in those points.
    pub(crate) fn normal(&self, place: &[f32; 3], min_points: f64) -> Option<[f32; 3]> {
        let middle = CellKey::of_point(place, 1.0 / self.radius_m).cell();
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
        let surfaces = Surfaces::new([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], 0.15);
        assert!(surfaces.is_near(&[0.1, -0.1, 0.0]));
        assert!(!surfaces.is_near(&[0.1, -0.1, 0.1]));
        assert!(surfaces.is_near(&[1.0, 1.14, 1.0]));
        assert!(!surfaces.is_near(&[1.0, 1.16, 1.0]));
        assert!(!Surfaces::new([], 0.15).is_near(&[0.0; 3]));
    }
}
