//! Things that stand free on level ground, found in the cells of a visit's surfaces.
//!
//! The heights at which most of the cells around are occupied are level: floors. Cells above a floor, up to the height of a loose thing, are seen from above; those beside each other are one
//! thing. What reaches farther than a loose thing does is a part of the building.

use crate::ChangesConfig;
use crate::clusters::{join, root_of};
use crate::surfaces::Surfaces;
use points::hash::{CellKey, CellTable};
use std::collections::BTreeMap;
use std::ops::Range;

/// Number of occupied cells at each height, in cells.
type Heights = BTreeMap<i64, usize>;

/// The points above the ground of each thing that stands free, in the order of the grid. Cells whose lower side is less than a cell above the ground are left out: a floor is not quite flat. Linear in the cells.
pub(crate) fn standing_things(surfaces: &Surfaces, config: &ChangesConfig) -> Vec<Vec<[f32; 3]>> {
    let marks = Marks::of(surfaces, config);
    let groups = marks.groups();
    let side_m = f64::from(surfaces.cell_side_m());
    let is_loose = |group: &&Vec<usize>| {
        let reach = |axis: usize| {
            let at = || group.iter().map(|mark| marks.of_grid[*mark].cell[axis]);
            at().max().zip(at().min()).map_or(0, |(most, least)| most - least + 1)
        };
        reach(0).max(reach(1)) as f64 * side_m <= 2.0 * config.turned_reach_m
    };
    let points_of = |group: &Vec<usize>| -> Vec<[f32; 3]> {
        let ranges = group.iter().flat_map(|mark| marks.of_grid[*mark].points.iter().cloned());
        ranges.flat_map(|range| surfaces.points()[range].iter().copied()).collect()
    };
    let things = groups.iter().filter(is_loose).map(points_of);
    things.filter(|points| points.len() >= config.min_points_of_others).collect()
}

/// What stands on the ground at a place of the grid, seen from above.
struct Mark {
    /// Place in the grid, and height of the ground, in cells.
    cell: [i64; 3],
    /// The points of its cells, by their places among those of the visit.
    points: Vec<Range<usize>>,
}

/// Where something stands on the ground.
#[derive(Default)]
struct Marks {
    table: CellTable,
    of_grid: Vec<Mark>,
}

impl Marks {
    fn of(surfaces: &Surfaces, config: &ChangesConfig) -> Self {
        let mut heights: BTreeMap<[i32; 2], Heights> = BTreeMap::new();
        for (column, cells) in surfaces.cells_of_columns() {
            let of_column = heights.entry(column).or_default();
            cells.for_each(|([_, _, z], _)| *of_column.entry(z).or_default() += 1);
        }
        let side_m = f64::from(surfaces.cell_side_m());
        let highest = (config.standing_height_m / side_m) as i64;
        let mut marks = Self::default();
        for (column, cells) in surfaces.cells_of_columns() {
            let levels = levels(column, &heights, config);
            for (cell, points) in cells {
                // A level is two cells high.
                let below = levels.iter().rev().find(|level| **level + 1 < cell[2]);
                if let Some(level) = below.filter(|level| cell[2] - **level <= highest) {
                    marks.add([cell[0], cell[1], *level], points);
                }
            }
        }
        marks
    }

    fn add(&mut self, cell: [i64; 3], points: Range<usize>) {
        let (mark, is_new) = self.table.get_or_insert(CellKey::new(cell), self.of_grid.len() as u32);
        if is_new {
            self.of_grid.push(Mark { cell, points: Vec::new() });
        }
        self.of_grid[mark as usize].points.push(points);
    }

    /// Marks that are beside each other, by their places. The ground of neighbours may be a cell higher or lower.
    fn groups(&self) -> Vec<Vec<usize>> {
        let mut parents: Vec<usize> = (0..self.of_grid.len()).collect();
        for (mark, Mark { cell: [x, y, level], .. }) in self.of_grid.iter().enumerate() {
            // The others are the same pairs.
            for [x, y] in [[x + 1, *y], [x - 1, y + 1], [*x, y + 1], [x + 1, y + 1]] {
                for level in level - 1..=level + 1 {
                    if let Some(other) = self.table.get(CellKey::new([x, y, level])) {
                        join(&mut parents, mark, other as usize);
                    }
                }
            }
        }
        let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for mark in 0..self.of_grid.len() {
            groups.entry(root_of(&mut parents, mark)).or_default().push(mark);
        }
        groups.into_values().collect()
    }
}

/// Heights of the level surfaces in a column and in those around it, in cells, ascending: the lower one of two cells. Linear in the heights.
fn levels([x, y]: [i32; 2], heights: &BTreeMap<[i32; 2], Heights>, config: &ChangesConfig) -> Vec<i64> {
    let mut sum = Heights::new();
    for beside in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [x + dx, y + dy])) {
        for (z, count) in heights.get(&beside).into_iter().flatten() {
            *sum.entry(*z).or_default() += count;
        }
    }
    // A surface may be on both sides of a border of cells.
    let of_pair = |z: i64| [z, z + 1].iter().filter_map(|z| sum.get(z)).sum::<usize>();
    let most = sum.keys().map(|z| of_pair(*z)).max().unwrap_or(0);
    let is_level = |z: &&i64| {
        let count = of_pair(**z);
        count as f64 >= config.level_share * most as f64
            && count > of_pair(**z - 1)
            && count >= of_pair(**z + 1)
    };
    sum.keys().filter(is_level).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::UprightBox;
    use crate::room::{FINE, at, visit_with_rays};
    use crate::surfaces::SurfaceTolerance;
    use geometry::Vector3;

    #[test]
    fn things_on_the_floor_and_on_a_platform_stand_free_and_walls_and_what_leans_on_them_do_not() {
        let config = ChangesConfig::default();
        let platform = at(3.0, 1.5, [2.8, 2.6, 0.3], 0.0);
        let mut on_it = at(3.0, 1.3, [0.5, 0.4, 0.5], 0.5);
        on_it.centre_m.z += 0.3;
        let free = at(-1.0, 0.5, [0.6, 0.4, 0.7], 0.3);
        let leans = at(-3.0, 3.8, [0.5, 0.4, 0.6], 0.0);
        let visit = visit_with_rays(&[platform, on_it, free, leans], 5.0, &FINE);
        let points = visit.points_within(config.min_range_m, config.max_range_m);
        let things = standing_things(&Surfaces::new(points, SurfaceTolerance::uniform(0.09)), &config);
        let is_of = |place: &UprightBox| {
            things
                .iter()
                .filter(|thing| {
                    thing.iter().all(|point| place.holds(&Vector3::from(point.map(f64::from)), 0.03))
                })
                .count()
        };
        assert_eq!([is_of(&free), is_of(&on_it), is_of(&leans)], [1, 1, 0]);
        let is_of_wall = |point: &[f32; 3]| point[0].abs() > 5.9 || point[1].abs() > 3.9;
        assert!(things.iter().flatten().all(|point| !is_of_wall(point)));
    }
}
