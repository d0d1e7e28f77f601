//! Points sorted by the upright columns that they are in, so that those near a box are found without looking at all.

use crate::UprightBox;
use points::hash::{CellKey, CellTable};
use std::ops::Range;

/// Side of a column, metres. Chosen: about the size of an object with what is around it.
pub(crate) const SIDE_M: f32 = 1.0;
/// More than the error of a coordinate of a point within 10 km of the origin, metres.
const ROUNDING_M: f64 = 1e-3;

/// Points in columns.
pub(crate) struct Columns {
    side_m: f32,
    /// Each column with the place of its first point, in order.
    starts: Vec<([i32; 2], usize)>,
    /// Column by column.
    points: Vec<[f32; 3]>,
}

impl Columns {
    /// Columns of a metre. Linear in the points, and `O(n log n)` in the columns. The order of the points of a column stays.
    pub(crate) fn new(points: impl IntoIterator<Item = [f32; 3]>) -> Self {
        Self::of_cells(points, 1.0 / SIDE_M, 1)
    }

    /// Columns that are each of this number of cells wide, in a grid whose cells have an edge of one divided by `cells_per_m`, metres.
    pub(crate) fn of_cells(points: impl IntoIterator<Item = [f32; 3]>, cells_per_m: f32, cells: i32) -> Self {
        let mut table = CellTable::default();
        let mut columns: Vec<([i32; 2], usize)> = Vec::new();
        let mut of_points: Vec<(u32, [f32; 3])> = Vec::new();
        for point in points {
            let [x, y, _] = CellKey::of_point(&point, cells_per_m).cell();
            let column = [x, y].map(|cell| (cell as i32).div_euclid(cells));
            let key = CellKey::new([column[0].into(), column[1].into(), 0]);
            let (index, is_new) = table.get_or_insert(key, columns.len() as u32);
            if is_new {
                columns.push((column, 0));
            }
            columns[index as usize].1 += 1;
            of_points.push((index, point));
        }
        let mut order: Vec<usize> = (0..columns.len()).collect();
        order.sort_by_key(|index| columns[*index].0);
        let mut next = vec![0; columns.len()];
        let mut starts = Vec::with_capacity(columns.len());
        let mut start = 0;
        for index in order {
            let (column, count) = columns[index];
            next[index] = start;
            starts.push((column, start));
            start += count;
        }
        let mut sorted = vec![[0.0; 3]; of_points.len()];
        for (index, point) in of_points {
            let place = &mut next[index as usize];
            sorted[*place] = point;
            *place += 1;
        }
        Self { side_m: cells as f32 / cells_per_m, starts, points: sorted }
    }

    /// All points, column by column.
    pub(crate) fn points(&self) -> &[[f32; 3]] {
        &self.points
    }

    /// Each column by its place in the grid, in order, with the place of its first point.
    pub(crate) fn starts(&self) -> &[([i32; 2], usize)] {
        &self.starts
    }

    /// The points of each column, to be put into another order.
    pub(crate) fn each_mut(&mut self) -> impl Iterator<Item = &mut [[f32; 3]]> {
        let ends = self.starts.iter().skip(1).map(|(_, start)| *start).chain([self.points.len()]);
        let mut rest = self.points.as_mut_slice();
        let mut at = 0;
        ends.map(move |end| {
            let (column, after) = std::mem::take(&mut rest).split_at_mut(end - at);
            (rest, at) = (after, end);
            column
        })
    }

    /// All points whose horizontal distance from the sides of a box is at most `margin_m` metres, and some others. Linear in the columns and the points there.
    pub(crate) fn around(&self, place: &UprightBox, margin_m: f64) -> impl Iterator<Item = &[f32; 3]> {
        self.ranges_around(place, margin_m).flat_map(|range| self.points[range].iter())
    }

    /// The same points by their places among all.
    pub(crate) fn ranges_around(
        &self,
        place: &UprightBox,
        margin_m: f64,
    ) -> impl Iterator<Item = Range<usize>> {
        // The edges of columns are as exact as single precision.
        let reach_m = place.size_m[0].hypot(place.size_m[1]) / 2.0 + margin_m + ROUNDING_M;
        let column = |at_m: f64| (at_m / f64::from(self.side_m)).floor() as i32;
        let [x, y] = [place.centre_m.x, place.centre_m.y]
            .map(|middle_m| (column(middle_m - reach_m), column(middle_m + reach_m)));
        (x.0..=x.1).map(move |x| {
            // The columns of one x stand one after the other.
            let place_of = |column: [i32; 2]| {
                let index = self.starts.partition_point(|(other, _)| *other < column);
                self.starts.get(index).map_or(self.points.len(), |(_, start)| *start)
            };
            place_of([x, y.0])..place_of([x, y.1 + 1])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Vector3;

    #[test]
    fn all_points_near_a_box_are_found_and_few_of_the_others() {
        let points = (-40..40).flat_map(|x| (-40..40).map(move |y| [x as f32 * 0.25, y as f32 * 0.25, 0.0]));
        let points: Vec<[f32; 3]> = points.collect();
        let columns = Columns::new(points.iter().copied());
        let place =
            UprightBox { centre_m: Vector3::new(-0.7, 3.1, 0.2), size_m: [1.5, 0.4, 0.5], yaw_rad: 0.8 };
        let is_near = |point: &&[f32; 3]| place.holds(&Vector3::from(point.map(f64::from)), 0.3);
        let found = columns.around(&place, 0.3).filter(is_near).count();
        assert_eq!(found, points.iter().filter(is_near).count());
        assert!(found > 0 && columns.around(&place, 0.3).count() < 300);
    }
}
