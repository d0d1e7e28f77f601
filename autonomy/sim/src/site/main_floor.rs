//! Where a robot starts in a model that has neither a dock nor a start: on a floor that is worth walking on, not on a landing, a pit or a table.

use super::SimulatedSite;
use super::walkable::{WalkableConfig, WalkableFloor};
use crate::route::Start;
use geometry::Vector3;

/// Additional cost of a place by its height above the lowest surface, metres of distance from the middle for each metre. Chosen: a lower storey comes before a
/// higher one unless it is 30 m further away for a storey of 3 m.
const COST_OF_HEIGHT: f64 = 10.0;

/// How the main floor is looked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct FloorSearch {
    /// Distance between the places that are tried, metres.
    pub(super) grid_m: f64,
    /// Least area of a floor to start on, relative to the largest one of the model.
    pub(super) least_share: f64,
}

impl SimulatedSite {
    /// A start with room for the robot, and the floor that can be reached from it. `corners` are the least and greatest corner of the site.
    ///
    /// Of all floors that are as large as `search` asks, it is the one with the cheapest place: low and near the middle of the ground plan. `None` if there is
    /// no room anywhere. Each floor is explored once: the time grows with their area and the number of places.
    pub(super) fn main_floor(
        &self,
        (least, most): (Vector3, Vector3),
        search: &FloorSearch,
    ) -> Option<(Start, WalkableFloor)> {
        let walkable = WalkableConfig::default();
        let mut floors: Vec<(Start, WalkableFloor)> = Vec::new();
        for place in self.places_by_cost(least, most, search.grid_m) {
            if floors.iter().any(|(_, floor)| floor.contains(&place)) || !self.has_room(&place) {
                continue;
            }
            let start = Start { position: geometry::vec_to_plain(&place), yaw: 0.0 };
            let floor = WalkableFloor::new(&self.bvh, &start, &walkable);
            let is_full = floor.len() >= walkable.max_cells;
            floors.push((start, floor));
            // A floor that was cut off does not contain its rest, which would be explored again and again.
            if is_full {
                break;
            }
        }
        let largest = floors.iter().map(|(_, floor)| floor.len()).max()?;
        floors.into_iter().find(|(_, floor)| floor.len() as f64 >= search.least_share * largest as f64)
    }

    /// All surfaces on a grid of vertical lines, the cheapest first.
    fn places_by_cost(&self, least: Vector3, most: Vector3, grid_m: f64) -> Vec<Vector3> {
        let middle = (least + most) / 2.0;
        let cells = |axis: usize| ((most[axis] - least[axis]) / grid_m) as usize;
        let mut places = Vec::new();
        for column in 0..=cells(0) {
            for row in 0..=cells(1) {
                let [x, y] =
                    [(least.x, column), (least.y, row)].map(|(low, cell)| low + (cell as f64 + 0.5) * grid_m);
                for z in self.surfaces_below(x, y, most.z + 0.5) {
                    let place = Vector3::new(x, y, z);
                    let cost = (place - middle).xy().norm() + COST_OF_HEIGHT * (z - least.z);
                    places.push((cost, place));
                }
            }
        }
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        places.into_iter().map(|(_, place)| place).collect()
    }

    /// Heights of all surfaces on the vertical line through `x, y` below `top`, from above.
    fn surfaces_below(&self, x: f64, y: f64, top: f64) -> Vec<f64> {
        let (mut heights, mut from) = (Vec::new(), top);
        while let Some((down, _)) = self.cast_ray(&Vector3::new(x, y, from), &-Vector3::z(), 3000.0) {
            heights.push(from - down);
            from -= down + 0.01;
        }
        heights
    }
}
