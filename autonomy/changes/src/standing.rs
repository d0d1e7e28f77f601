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

/// The points above the ground of each thing that stands free, in the order of the grid. Cells whose lower side is less than a cell above the ground are left out: a floor is not quite flat. Linear in the cells.
pub(crate) fn standing_things(surfaces: &Surfaces, config: &ChangesConfig) -> Vec<Vec<[f32; 3]>> {
    let marks = Marks::of(surfaces, config);
    let roots = marks.roots();
    let mut sizes = vec![Size::default(); marks.of_grid.len()];
    for (cell, root) in marks.of_grid.iter().zip(&roots) {
        sizes[*root].add([cell[0], cell[1]]);
    }
    for (mark, points) in &marks.cells {
        sizes[roots[*mark as usize]].points += points.len();
    }
    let most_cells = (2.0 * config.turned_reach_m / f64::from(surfaces.cell_side_m())) as i64;
    let mut things: Vec<Option<Vec<[f32; 3]>>> = sizes
        .iter()
        .map(|size| {
            let is_loose = size.reach() <= most_cells && size.points >= config.min_points_of_others;
            is_loose.then(|| Vec::with_capacity(size.points))
        })
        .collect();
    for (mark, points) in marks.cells {
        if let Some(thing) = &mut things[roots[mark as usize]] {
            thing.extend_from_slice(&surfaces.points()[points]);
        }
    }
    things.into_iter().flatten().collect()
}

/// What a thing takes of the grid.
#[derive(Clone, Default)]
struct Size {
    /// Least and most place along both axes.
    ends: Option<[[i64; 2]; 2]>,
    points: usize,
}

impl Size {
    fn add(&mut self, at: [i64; 2]) {
        let [least, most] = self.ends.unwrap_or([at; 2]);
        let end = |of: [i64; 2], choose: fn(i64, i64) -> i64| [0, 1].map(|axis| choose(of[axis], at[axis]));
        self.ends = Some([end(least, i64::min), end(most, i64::max)]);
    }

    /// Cells along its longer side.
    fn reach(&self) -> i64 {
        self.ends.map_or(0, |[least, most]| 1 + (most[0] - least[0]).max(most[1] - least[1]))
    }
}

/// Where something stands on the ground, seen from above.
#[derive(Default)]
struct Marks {
    table: CellTable,
    /// Place in the grid, and height of the ground, in cells.
    of_grid: Vec<[i64; 3]>,
    /// Each cell above the ground: its mark, and the places of its points among those of the visit.
    cells: Vec<(u32, Range<usize>)>,
}

impl Marks {
    fn of(surfaces: &Surfaces, config: &ChangesConfig) -> Self {
        let heights = surfaces.cells_of_columns().map(|(column, cells)| {
            let heights: Vec<i64> = cells.map(|([_, _, z], _)| z).collect();
            (column, Heights::of(&heights))
        });
        let heights: BTreeMap<[i32; 2], Heights> = heights.collect();
        let highest = (config.standing_height_m / f64::from(surfaces.cell_side_m())) as i64;
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

    fn add(&mut self, mark: [i64; 3], points: Range<usize>) {
        let (place, is_new) = self.table.get_or_insert(CellKey::new(mark), self.of_grid.len() as u32);
        if is_new {
            self.of_grid.push(mark);
        }
        self.cells.push((place, points));
    }

    /// For each mark the first one of those that are beside each other, again and again. The ground of neighbours may be a cell higher or lower.
    fn roots(&self) -> Vec<usize> {
        let mut parents: Vec<usize> = (0..self.of_grid.len()).collect();
        for (mark, [x, y, level]) in self.of_grid.iter().enumerate() {
            // The others are the same pairs.
            for [x, y] in [[x + 1, *y], [x - 1, y + 1], [*x, y + 1], [x + 1, y + 1]] {
                for level in level - 1..=level + 1 {
                    if let Some(other) = self.table.get(CellKey::new([x, y, level])) {
                        join(&mut parents, mark, other as usize);
                    }
                }
            }
        }
        (0..self.of_grid.len()).map(|mark| root_of(&mut parents, mark)).collect()
    }
}

/// Number of occupied cells at each height.
#[derive(Default)]
struct Heights {
    /// The lowest height, in cells.
    lowest: i64,
    counts: Vec<u32>,
}

impl Heights {
    /// Of cells at these heights.
    fn of(heights: &[i64]) -> Self {
        let (Some(lowest), Some(highest)) = (heights.iter().min(), heights.iter().max()) else {
            return Self::default();
        };
        let mut counts = vec![0; (highest - lowest) as usize + 1];
        heights.iter().for_each(|z| counts[(z - lowest) as usize] += 1);
        Self { lowest: *lowest, counts }
    }

    /// The sum of several.
    fn sum<'a>(all: impl Iterator<Item = &'a Self> + Clone) -> Self {
        let filled = all.filter(|heights| !heights.counts.is_empty());
        let ends = |heights: &Self| [heights.lowest, heights.lowest + heights.counts.len() as i64 - 1];
        let lowest = filled.clone().map(|heights| ends(heights)[0]).min();
        let highest = filled.clone().map(|heights| ends(heights)[1]).max();
        let (Some(lowest), Some(highest)) = (lowest, highest) else { return Self::default() };
        let mut counts = vec![0; (highest - lowest) as usize + 1];
        for heights in filled {
            let first = (heights.lowest - lowest) as usize;
            counts[first..].iter_mut().zip(&heights.counts).for_each(|(sum, count)| *sum += count);
        }
        Self { lowest, counts }
    }
}

/// Heights of the level surfaces in a column and in those around it, in cells, ascending: the lower one of two cells. Linear in the range of heights.
fn levels([x, y]: [i32; 2], heights: &BTreeMap<[i32; 2], Heights>, config: &ChangesConfig) -> Vec<i64> {
    let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [x + dx, y + dy]));
    let sum = Heights::sum(around.filter_map(|column| heights.get(&column)));
    // A surface may be on both sides of a border of cells.
    let pairs: Vec<u32> =
        (0..sum.counts.len()).map(|at| sum.counts[at] + sum.counts.get(at + 1).unwrap_or(&0)).collect();
    let least = config.level_share * f64::from(pairs.iter().copied().max().unwrap_or(0));
    let is_level = |at: &usize| {
        let count = pairs[*at];
        let is_more = at.checked_sub(1).is_none_or(|below| count > pairs[below]);
        f64::from(count) >= least && is_more && pairs.get(at + 1).is_none_or(|above| count >= *above)
    };
    (0..pairs.len()).filter(is_level).map(|at| sum.lowest + at as i64).collect()
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
