//! The surfaces of a visit: whether there is one near a place.

use crate::ChangesConfig;
use crate::alignment::RegionalErrors;
use crate::columns::{Columns, SIDE_M};
use crate::join::Join;
use points::hash::{CellKey, CellTable};
use points::symmetric::principal_axes;
use std::ops::Range;
use std::sync::OnceLock;

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
    /// Each block of cells with its place in `blocks`.
    index: CellTable,
    blocks: Vec<Block>,
    /// Place of the first point of each cell, in their order, and the number of points.
    starts: Vec<u32>,
    /// Of each cell the normal of the surface there, once it was asked for.
    normals: Vec<OnceLock<Option<[f32; 3]>>>,
    /// The points, sorted by block and cell within each column. A column consists of whole blocks.
    columns: Columns,
}

/// Cells with points among 4 x 4 x 4 neighbours. Of the 27 cells around a place on a surface two thirds are empty, and there are far fewer blocks than cells to look up.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    /// A bit for each cell.
    occupied: u64,
    /// Place in [`Surfaces::starts`] of its first cell; the others follow in the order of their bits.
    first: u32,
}

impl Block {
    /// Cells along an axis.
    const SIDE: i64 = 4;

    /// The block of a cell.
    fn of(cell: [i64; 3]) -> [i64; 3] {
        cell.map(|at| at.div_euclid(Self::SIDE))
    }

    /// The number of the bit of a cell in its block.
    fn bit(cell: [i64; 3]) -> u32 {
        let [x, y, z] = cell.map(|at| at.rem_euclid(Self::SIDE) as u32);
        x + 4 * y + 16 * z
    }

    /// Place in [`Surfaces::starts`] of a cell; none without points.
    fn place(&self, bit: u32) -> Option<usize> {
        let before = self.occupied & ((1 << bit) - 1);
        (self.occupied >> bit & 1 == 1).then(|| (self.first + before.count_ones()) as usize)
    }
}

impl Surfaces {
    /// The surfaces that these points are on. The side of a cell is the largest distance of the tolerance. `O(n log n)` in the points of a column.
    pub(crate) fn new(points: impl IntoIterator<Item = [f32; 3]>, tolerance: SurfaceTolerance) -> Self {
        let per_m = tolerance.cells_per_m();
        let cells = ((SIDE_M * per_m).ceil() as u32).next_multiple_of(Block::SIDE as u32) as i32;
        let mut columns = Columns::of_cells(points, per_m, cells);
        let (mut index, mut blocks, mut starts) = (CellTable::default(), Vec::new(), Vec::new());
        let mut place = 0;
        let mut keyed: Vec<(CellKey, u32, [f32; 3])> = Vec::new();
        for column in columns.each_mut() {
            keyed.clear();
            keyed.extend(column.iter().map(|point| {
                let cell = CellKey::of_point(point, per_m).cell();
                (CellKey::new(Block::of(cell)), Block::bit(cell), *point)
            }));
            keyed.sort_by_key(|(block, bit, _)| (*block, *bit));
            for of_block in keyed.chunk_by(|a, b| a.0 == b.0) {
                index.get_or_insert(of_block[0].0, blocks.len() as u32);
                let mut block = Block { occupied: 0, first: starts.len() as u32 };
                for of_cell in of_block.chunk_by(|a, b| a.1 == b.1) {
                    block.occupied |= 1 << of_cell[0].1;
                    starts.push(place);
                    place += of_cell.len() as u32;
                }
                blocks.push(block);
            }
            column.iter_mut().zip(&keyed).for_each(|(place, (_, _, point))| *place = *point);
        }
        starts.push(place);
        let normals = starts.iter().map(|_| OnceLock::new()).collect();
        Self { tolerance, index, blocks, starts, normals, columns }
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
    fn are_near_of_cells(&self, other: &Self, starts: &[u32]) -> Vec<bool> {
        let mut are_near = Vec::new();
        for ends in starts.windows(2) {
            let points = &other.points()[ends[0] as usize..ends[1] as usize];
            // A cell has a point at least.
            let mut around = self.around(CellKey::of_point(&points[0], self.tolerance.cells_per_m()));
            are_near.extend(points.iter().map(|point| around.has(point, &self.tolerance)));
        }
        are_near
    }

    fn around(&self, cell: CellKey) -> CellsAround<'_> {
        let cell = cell.cell();
        CellsAround { surfaces: self, cell, own: self.of_cell(cell), others: None }
    }

    /// Within which distance surfaces at a place are the same, metres.
    pub(crate) fn tolerance_m(&self, place: &[f32; 3]) -> f32 {
        self.tolerance.at(place)
    }

    /// The points of a cell and of the 26 beside it, without those that are empty, in the order of x, y and z.
    fn of_cells_around(&self, [x, y, z]: [i64; 3]) -> impl Iterator<Item = ([i64; 3], &[[f32; 3]])> {
        // These cells are in two blocks along each axis at most.
        let (first, last) = (Block::of([x - 1, y - 1, z - 1]), Block::of([x + 1, y + 1, z + 1]));
        let blocks: [Block; 8] = std::array::from_fn(|number| {
            let step = [number & 1, number >> 1 & 1, number >> 2].map(|step| step as i64);
            let block: [i64; 3] = std::array::from_fn(|axis| first[axis] + step[axis]);
            let is_asked = (0..3).all(|axis| block[axis] <= last[axis]);
            let place = is_asked.then(|| self.index.get(CellKey::new(block))).flatten();
            place.map_or(Block::default(), |place| self.blocks[place as usize])
        });
        let is_any = blocks.iter().any(|block| block.occupied != 0);
        let of_cell = move |cell: [i64; 3]| {
            let block = Block::of(cell);
            let [x, y, z] = [0, 1, 2].map(|axis| (block[axis] - first[axis]) as usize);
            let place = blocks[x + 2 * y + 4 * z].place(Block::bit(cell))?;
            Some((cell, self.points_of(place)))
        };
        let end = if is_any { x + 2 } else { x - 1 };
        (x - 1..end)
            .flat_map(move |x| (y - 1..=y + 1).flat_map(move |y| (z - 1..=z + 1).map(move |z| [x, y, z])))
            .filter_map(of_cell)
    }

    /// Unit normal of the surface in the cell of a place: the direction in which the points of the 27 cells around spread least. None with fewer points than that, and of a cell without points.
    /// Linear in those points when a cell is asked first; it has to be asked with the same number of points always.
    pub(crate) fn normal(&self, place: &[f32; 3], min_points: f64) -> Option<[f32; 3]> {
        let cell = CellKey::of_point(place, self.tolerance.cells_per_m()).cell();
        let index = self.place_of(cell)?;
        *self.normals[index].get_or_init(|| self.normal_around(cell, &self.points_of(index)[0], min_points))
    }

    /// The normal of the points of a cell and those around it. Products are of offsets from one of them, which are short.
    fn normal_around(&self, cell: [i64; 3], first: &[f32; 3], min_points: f64) -> Option<[f32; 3]> {
        let (mut count, mut sum, mut squares) = (0.0, [0.0; 3], [0.0; 6]);
        for (_, points) in self.of_cells_around(cell) {
            for point in points {
                let [x, y, z]: [f64; 3] = std::array::from_fn(|axis| f64::from(point[axis] - first[axis]));
                count += 1.0;
                [x, y, z].iter().zip(&mut sum).for_each(|(at, sum)| *sum += at);
                let products = [x * x, x * y, x * z, y * y, y * z, z * z];
                products.iter().zip(&mut squares).for_each(|(product, sum)| *sum += product);
            }
        }
        if count < min_points {
            return None;
        }
        let [x, y, z] = sum.map(|at| at / count);
        let of_means = [x * x, x * y, x * z, y * y, y * z, z * z];
        let spread = std::array::from_fn(|part| (squares[part] / count - of_means[part]) as f32);
        principal_axes(&spread).map(|axes| axes.normal)
    }

    /// Side of a cell, metres.
    pub(crate) fn cell_side_m(&self) -> f32 {
        self.tolerance.largest_m
    }

    /// Each column of cells by its place in the grid, in order, with its cells and their points.
    pub(crate) fn cells_of_columns(
        &self,
    ) -> impl Iterator<Item = ([i32; 2], impl Iterator<Item = ([i64; 3], Range<usize>)>)> {
        let per_m = self.tolerance.cells_per_m();
        let mut rest = self.starts.as_slice();
        let columns = self.columns.starts();
        let ends = columns.iter().skip(1).map(|(_, start)| *start).chain([self.points().len()]);
        columns.iter().zip(ends).map(move |((column, _), end)| {
            let count = rest.partition_point(|start| (*start as usize) < end);
            let of_column = &rest[..=count];
            rest = &rest[count..];
            let cells = of_column.windows(2).map(move |ends| {
                let range = ends[0] as usize..ends[1] as usize;
                (CellKey::of_point(&self.points()[range.start], per_m).cell(), range)
            });
            (*column, cells)
        })
    }

    fn of_cell(&self, cell: [i64; 3]) -> &[[f32; 3]] {
        self.place_of(cell).map_or(&[], |place| self.points_of(place))
    }

    /// Place of a cell in `starts`; none without points.
    fn place_of(&self, cell: [i64; 3]) -> Option<usize> {
        let block = self.index.get(CellKey::new(Block::of(cell)))?;
        self.blocks[block as usize].place(Block::bit(cell))
    }

    /// The points of a cell, by its place in `starts`.
    fn points_of(&self, place: usize) -> &[[f32; 3]] {
        &self.points()[self.starts[place] as usize..self.starts[place + 1] as usize]
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
    cell: [i64; 3],
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
        let others = self.others.get_or_insert_with(|| {
            let around = self.surfaces.of_cells_around(self.cell);
            around.filter(|(cell, _)| *cell != self.cell).map(|(_, points)| points).collect()
        });
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
