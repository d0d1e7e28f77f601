//! Where to walk when one does not know where one is: a little way, to ground that has been seen and where one has not been.

use crate::planner::{Search, trace};
use crate::{CellIndex, Terrain};
use geometry::Vector3;
use std::cmp::Reverse;

/// A shorter walk shows nothing new, metres.
const LEAST: f64 = 1.0;

/// A way from `from` to the place within `radius` that is farthest from all of `been` (all in the terrain's frame, metres), on ground that
/// was seen and is comfortable to stand on; none where there is none. The way leads over such ground where it can: next to itself a
/// robot may have seen nothing.
///
/// Cost grows with the ground within `radius` and with `been`.
pub fn roam(terrain: &Terrain, from: &Vector3, been: &[Vector3], radius: f64) -> Option<Vec<Vector3>> {
    let mut search = Search::new(terrain);
    let start = search.nearest_free(terrain.index(from.x, from.y))?;
    let reached = search.reach(start, radius / terrain.cell_size());
    let been: Vec<CellIndex> = been.iter().map(|place| terrain.index(place.x, place.y)).collect();
    let apart = |a: CellIndex, b: CellIndex| i64::from(a.x - b.x).pow(2) + i64::from(a.y - b.y).pow(2);
    let new = |cell: CellIndex| been.iter().map(|&place| apart(cell, place)).min().unwrap_or(i64::MAX);
    let least = (LEAST / terrain.cell_size()).powi(2) as i64;
    let mut goals: Vec<CellIndex> =
        reached.keys().copied().filter(|&cell| apart(cell, start) >= least).collect();
    goals.sort_by_key(|&cell| Reverse(new(cell)));
    let is_known = |cell: &CellIndex| terrain.cell(*cell).ground().is_some();
    let goal = goals
        .into_iter()
        .find(|cell| is_known(cell) && search.factor(*cell).is_some_and(|factor| factor <= 1.0 + 1e-9))?;
    let cells = trace(&reached, start, goal);
    Some(search.path(from, &cells))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planner::tests::terrain;

    /// A room with a way out to the right.
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

    #[test]
    fn it_walks_to_where_it_has_not_been_and_stays_on_ground_that_was_seen() {
        let (terrain, from, _) = terrain(ROOM.trim_matches('\n'));
        let Some(first) = roam(&terrain, &from, &[from], 3.0) else { panic!("no room") };
        let end = first[first.len() - 1];
        assert!((2.5..3.1).contains(&(end - from).xy().norm()) && end.x > from.x + 2.0, "{first:?}");
        let Some(second) = roam(&terrain, &end, &[from, end], 3.0) else { panic!("no room") };
        assert!(second[second.len() - 1].x > end.x + 2.0, "{second:?}");
        for pair in first.windows(2).chain(second.windows(2)) {
            for step in 0..=20 {
                let at = pair[0].lerp(&pair[1], f64::from(step) / 20.0);
                assert!(terrain.cell(terrain.index(at.x, at.y)).ground().is_some());
            }
        }
    }

    #[test]
    fn put_down_where_it_sees_no_ground_about_itself_it_walks_to_where_it_does() {
        let (terrain, from, _) =
            terrain("........\n........\n..    ..\n..    ..\n.. S  ..\n..    ..\n........\n........");
        let way = roam(&terrain, &from, &[from], 2.0);
        let end =
            way.as_ref().and_then(|way| way.last()).map(|end| terrain.cell(terrain.index(end.x, end.y)));
        assert!(end.is_some_and(|end| end.ground().is_some()), "{way:?}");
    }

    #[test]
    fn where_there_is_no_room_it_stays() {
        let (terrain, from, _) = terrain("#####\n#...#\n#.S.#\n#...#\n#####");
        assert_eq!(roam(&terrain, &from, &[from], 3.0), None);
    }
}
