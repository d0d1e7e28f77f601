//! Things that stand free on level ground, found in the cells of a visit's surfaces.
//!
//! The heights at which most of the cells around are occupied are level: floors. Cells with points above a floor, up to the height of a loose thing, are seen from above; those beside each other are one
//! thing. What reaches farther than a loose thing does is a part of the building.

use crate::ChangesConfig;
use crate::clusters::{join, root_of};
use crate::surfaces::Surfaces;
use points::hash::{CellKey, CellTable};
use std::collections::BTreeMap;
use std::ops::Range;

/// A thing that stands free.
#[derive(Clone, Default)]
pub(crate) struct StandingThing {
    /// Its points that are at least [`ChangesConfig::standing_clearance_m`] above the ground.
    pub(crate) points: Vec<[f32; 3]>,
    /// Mean height of the ground under them, metres.
    pub(crate) ground_m: f64,
}

/// Each thing that stands free, in the order of the grid. Linear in the cells, and in the points of floors.
pub(crate) fn standing_things(surfaces: &Surfaces, config: &ChangesConfig) -> Vec<StandingThing> {
    let marks = Marks::of(surfaces, config);
    let roots = marks.roots();
    let mut sizes = vec![Size::default(); marks.of_grid.len()];
    for (cell, root) in marks.of_grid.iter().zip(&roots) {
        sizes[*root].add([cell[0], cell[1]]);
    }
    for (mark, points) in &marks.cells {
        let above = marks.above(*mark, &surfaces.points()[points.clone()]).count();
        sizes[roots[*mark as usize]].add_points(above, marks.grounds_m[*mark as usize]);
    }
    let most_cells = (2.0 * config.turned_reach_m / f64::from(surfaces.cell_side_m())) as i64;
    let thing = |size: &Size| {
        let is_loose = size.reach() <= most_cells && size.points >= config.min_points;
        is_loose.then(|| StandingThing {
            points: Vec::with_capacity(size.points),
            ground_m: size.grounds_m / size.points as f64,
        })
    };
    let mut things: Vec<Option<StandingThing>> = sizes.iter().map(thing).collect();
    for (mark, points) in &marks.cells {
        if let Some(thing) = &mut things[roots[*mark as usize]] {
            thing.points.extend(marks.above(*mark, &surfaces.points()[points.clone()]));
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
    /// Sum over them of the heights of the ground under them, metres.
    grounds_m: f64,
}

impl Size {
    fn add(&mut self, at: [i64; 2]) {
        let [least, most] = self.ends.unwrap_or([at; 2]);
        let end = |of: [i64; 2], choose: fn(i64, i64) -> i64| [0, 1].map(|axis| choose(of[axis], at[axis]));
        self.ends = Some([end(least, i64::min), end(most, i64::max)]);
    }

    fn add_points(&mut self, count: usize, ground_m: f64) {
        self.points += count;
        self.grounds_m += count as f64 * ground_m;
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
    /// Height of the ground of each of them, metres.
    grounds_m: Vec<f64>,
    clearance_m: f64,
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
        let mut marks = Self { clearance_m: config.standing_clearance_m, ..Self::default() };
        for (column, cells) in surfaces.cells_of_columns() {
            let cells: Vec<([i64; 3], Range<usize>)> = cells.collect();
            let floors = floors(&levels(column, &heights, config), &cells, surfaces.points());
            for (cell, points) in cells {
                let below = floors.iter().rev().find(|floor| floor.level <= cell[2]);
                let Some(floor) = below.filter(|floor| cell[2] - floor.level <= highest) else { continue };
                let is_above = |point: &[f32; 3]| marks.is_above(point, floor.height_m);
                if surfaces.points()[points.clone()].iter().any(is_above) {
                    marks.add([cell[0], cell[1], floor.level], floor.height_m, points);
                }
            }
        }
        marks
    }

    fn add(&mut self, mark: [i64; 3], ground_m: f64, points: Range<usize>) {
        let (place, is_new) = self.table.get_or_insert(CellKey::new(mark), self.of_grid.len() as u32);
        if is_new {
            self.of_grid.push(mark);
            self.grounds_m.push(ground_m);
        }
        self.cells.push((place, points));
    }

    /// Whether a point is not of the ground at this height, metres.
    fn is_above(&self, point: &[f32; 3], ground_m: f64) -> bool {
        f64::from(point[2]) >= ground_m + self.clearance_m
    }

    /// Those of the points of a cell that are not of the ground.
    fn above<'a>(&'a self, mark: u32, points: &'a [[f32; 3]]) -> impl Iterator<Item = [f32; 3]> + use<'a> {
        let ground_m = self.grounds_m[mark as usize];
        points.iter().filter(move |point| self.is_above(point, ground_m)).copied()
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

/// A level surface of a column.
struct Floor {
    /// Its lower one of two cells.
    level: i64,
    /// Mean height of its points, metres.
    height_m: f64,
}

/// The floors of a column at these levels of which it has points. Linear in these points, and in the cells for each level.
fn floors(levels: &[i64], cells: &[([i64; 3], Range<usize>)], points: &[[f32; 3]]) -> Vec<Floor> {
    let of_level = |level: &i64| {
        let own = cells.iter().filter(|(cell, _)| (*level..=level + 1).contains(&cell[2]));
        let heights_m =
            own.flat_map(|(_, of_cell)| &points[of_cell.clone()]).map(|point| f64::from(point[2]));
        let (count, sum_m) = heights_m.fold((0_usize, 0.0), |(count, sum_m), at_m| (count + 1, sum_m + at_m));
        (count > 0).then(|| Floor { level: *level, height_m: sum_m / count as f64 })
    };
    levels.iter().filter_map(of_level).collect()
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
                    thing.points.iter().all(|point| place.holds(&Vector3::from(point.map(f64::from)), 0.03))
                })
                .count()
        };
        assert_eq!([is_of(&free), is_of(&on_it), is_of(&leans)], [1, 1, 0]);
        let is_of_wall = |point: &[f32; 3]| point[0].abs() > 5.9 || point[1].abs() > 3.9;
        assert!(things.iter().flat_map(|thing| &thing.points).all(|point| !is_of_wall(point)));
    }
}
