//! Exploration by a robot whose pose is unknown: a short path over seen ground to an unvisited point.

use crate::planner::{GridSearch, PlannerConfig, trace};
use crate::{CellIndex, ElevationMap};
use geometry::Vector3;
use std::cmp::Reverse;

/// Parameters of [`explore`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExplorationConfig {
    /// Least distance from the start to the goal, metres. A nearer goal shows nothing new. Chosen: views a metre apart show nearly the same.
    pub min_distance_m: f64,
    /// Radius within which a goal is searched for, metres. It has to exceed 3 m, where the lowest beams of a LiDAR on a mast meet the ground. Chosen: a metre beyond
    /// those 3 m.
    pub radius_m: f64,
}

impl Default for ExplorationConfig {
    fn default() -> Self {
        Self { min_distance_m: 1.0, radius_m: 4.0 }
    }
}

/// Path from `from` to the cell that is farthest from all of `visited` (all in the map's frame, metres). `None` if there is no such cell. The goal
/// lies within [`ExplorationConfig::radius_m`], on ground that was seen. It lies away from obstacles if there is such a goal, and otherwise on any
/// ground where the robot can stand. The path may cross unseen ground, which costs more than known ground, because a robot may have seen no ground
/// beside itself.
///
/// Cost grows with the ground within the radius, times the number of `visited` points.
pub fn explore(
    config: &ExplorationConfig,
    planner: &PlannerConfig,
    elevation_map: &ElevationMap,
    from: &Vector3,
    visited: &[Vector3],
) -> Option<Vec<Vector3>> {
    let mut search = GridSearch::new(*planner, elevation_map);
    let start = search.nearest_free(elevation_map.index(from.x, from.y))?;
    let reached = search.reach(start, config.radius_m / elevation_map.cell_size_m());
    let visited: Vec<CellIndex> = visited.iter().map(|place| elevation_map.index(place.x, place.y)).collect();
    let distance_squared =
        |a: CellIndex, b: CellIndex| i64::from(a.x - b.x).pow(2) + i64::from(a.y - b.y).pow(2);
    let novelty = |cell: CellIndex| {
        visited.iter().map(|&place| distance_squared(cell, place)).min().unwrap_or(i64::MAX)
    };
    let min_distance_squared = (config.min_distance_m / elevation_map.cell_size_m()).powi(2) as i64;
    let mut goals: Vec<CellIndex> = reached
        .keys()
        .copied()
        .filter(|&cell| distance_squared(cell, start) >= min_distance_squared)
        .collect();
    goals.sort_by_key(|&cell| Reverse(novelty(cell)));
    let is_known = |cell: &CellIndex| elevation_map.cell(*cell).ground().is_some();
    let known: Vec<CellIndex> = goals.into_iter().filter(is_known).collect();
    let outside_inflation = known.iter().copied().find(|&cell| search.is_outside_inflation(cell));
    // In a narrow passage, or among people, all free ground may be near obstacles.
    let goal = outside_inflation.or_else(|| known.first().copied())?;
    let cells = trace(&reached, goal);
    Some(search.path(from, &cells))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planner::tests::elevation_map;

    /// A room with an exit on the right.
    const ROOM: &str = "
##########################################
#......................................###
#......................................###
#......................................###
#....................................  ###
#....S................................ ###
#......................................###
#......................................###
#......................................###
##########################################";

    fn explore_within(
        radius_m: f64,
        elevation_map: &ElevationMap,
        from: &Vector3,
        visited: &[Vector3],
    ) -> Option<Vec<Vector3>> {
        let config = ExplorationConfig { radius_m, ..ExplorationConfig::default() };
        explore(&config, &PlannerConfig::default(), elevation_map, from, visited)
    }

    #[test]
    fn the_path_leads_to_where_the_robot_has_not_been_over_ground_that_was_seen() {
        let (elevation_map, from, _) = elevation_map(ROOM.trim_matches('\n'));
        let Some(first) = explore_within(3.0, &elevation_map, &from, &[from]) else { panic!("no room") };
        let end = first[first.len() - 1];
        assert!((2.5..3.1).contains(&(end - from).xy().norm()) && end.x > from.x + 2.0, "{first:?}");
        let Some(second) = explore_within(3.0, &elevation_map, &end, &[from, end]) else { panic!("no room") };
        assert!(second[second.len() - 1].x > end.x + 2.0, "{second:?}");
        for pair in first.windows(2).chain(second.windows(2)) {
            for step in 0..=20 {
                let at = pair[0].lerp(&pair[1], f64::from(step) / 20.0);
                assert!(elevation_map.cell(elevation_map.index(at.x, at.y)).ground().is_some());
            }
        }
    }

    #[test]
    fn without_seen_ground_around_the_robot_the_path_leads_to_ground_that_was_seen() {
        let (elevation_map, from, _) =
            elevation_map("........\n........\n..    ..\n..    ..\n.. S  ..\n..    ..\n........\n........");
        let path = explore_within(2.0, &elevation_map, &from, &[from]);
        let end = path
            .as_ref()
            .and_then(|path| path.last())
            .map(|end| elevation_map.cell(elevation_map.index(end.x, end.y)));
        assert!(end.is_some_and(|end| end.ground().is_some()), "{path:?}");
    }

    #[test]
    fn in_a_passage_without_ground_away_from_obstacles_the_path_leads_along_it() {
        let (elevation_map, from, _) =
            elevation_map("############\n............\n......S.....\n............\n############");
        let Some(path) = explore_within(3.0, &elevation_map, &from, &[from]) else { panic!("no path") };
        assert!((path[path.len() - 1] - from).xy().norm() > 1.0, "{path:?}");
    }

    #[test]
    fn without_room_there_is_no_path() {
        let (elevation_map, from, _) = elevation_map("#####\n#...#\n#.S.#\n#...#\n#####");
        assert_eq!(explore_within(3.0, &elevation_map, &from, &[from]), None);
    }
}
