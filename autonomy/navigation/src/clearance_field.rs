//! Distances from cells to the nearest obstacle in any direction, computed block by block where a search asks for them.

use crate::{CellIndex, ElevationMap};
use std::collections::BTreeMap;

/// Cells along the side of a block.
const BLOCK_CELLS: i32 = 32;

/// The distances.
pub(crate) struct ClearanceField<'a> {
    elevation_map: &'a ElevationMap,
    /// Distances up to this are computed, metres.
    reach_m: f64,
    /// Distances from the centres of the cells, metres, row by row.
    blocks: BTreeMap<(i32, i32), Vec<f32>>,
}

impl<'a> ClearanceField<'a> {
    pub(crate) fn new(elevation_map: &'a ElevationMap, reach_m: f64) -> Self {
        Self { elevation_map, reach_m, blocks: BTreeMap::new() }
    }

    /// Distance from the centre of a cell to the nearest obstacle, at most the reach, metres. Constant time, once its block is known.
    pub(crate) fn distance_m(&mut self, cell: CellIndex) -> f64 {
        let block = (cell.x.div_euclid(BLOCK_CELLS), cell.y.div_euclid(BLOCK_CELLS));
        let (elevation_map, reach_m) = (self.elevation_map, self.reach_m);
        let distances = self.blocks.entry(block).or_insert_with(|| distances(elevation_map, reach_m, block));
        let (x, y) = (cell.x.rem_euclid(BLOCK_CELLS), cell.y.rem_euclid(BLOCK_CELLS));
        f64::from(distances[(y * BLOCK_CELLS + x) as usize])
    }
}

/// The distances in a block. Linear in its obstacles, times the cells within reach of each.
fn distances(elevation_map: &ElevationMap, reach_m: f64, block: (i32, i32)) -> Vec<f32> {
    let first = CellIndex { x: block.0 * BLOCK_CELLS, y: block.1 * BLOCK_CELLS };
    let last = CellIndex { x: first.x + BLOCK_CELLS - 1, y: first.y + BLOCK_CELLS - 1 };
    let reach = (reach_m / elevation_map.cell_size_m()).ceil() as i32;
    let low = CellIndex { x: first.x - reach, y: first.y - reach };
    let high = CellIndex { x: last.x + reach, y: last.y + reach };
    let mut squared = vec![(reach_m * reach_m) as f32; (BLOCK_CELLS * BLOCK_CELLS) as usize];
    for [x, y] in elevation_map.obstacles_between(low, high) {
        let at = elevation_map.index(x, y);
        for row in (at.y - reach).max(first.y)..=(at.y + reach).min(last.y) {
            for column in (at.x - reach).max(first.x)..=(at.x + reach).min(last.x) {
                let (centre_x, centre_y) = elevation_map.centre(CellIndex { x: column, y: row });
                let distance = ((centre_x - x).powi(2) + (centre_y - y).powi(2)) as f32;
                let known = &mut squared[((row - first.y) * BLOCK_CELLS + column - first.x) as usize];
                *known = known.min(distance);
            }
        }
    }
    squared.iter_mut().for_each(|distance| *distance = distance.sqrt());
    squared
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planner::tests::elevation_map;

    #[test]
    fn distances_are_those_to_the_nearest_obstacle_in_any_direction() {
        let (elevation_map, ..) =
            elevation_map("............\n..#.........\n............\n.........#..\n............");
        let obstacles: Vec<[f64; 2]> =
            elevation_map.obstacles_between(CellIndex { x: -50, y: -50 }, CellIndex { x: 50, y: 50 });
        assert_eq!(obstacles.len(), 2, "{obstacles:?}");
        let mut field = ClearanceField::new(&elevation_map, 1.0);
        for x in -45..45 {
            for y in -45..45 {
                let cell = CellIndex { x, y };
                let centre = elevation_map.centre(cell);
                let to = |at: &[f64; 2]| (at[0] - centre.0).hypot(at[1] - centre.1);
                let nearest = obstacles.iter().map(to).fold(1.0, f64::min);
                assert!((field.distance_m(cell) - nearest).abs() < 1e-6, "{cell:?}");
            }
        }
    }
}
