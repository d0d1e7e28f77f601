//! Paths through a survey that nobody walked: places spread over the walkable floor, and the cheapest paths between neighbouring ones.
//!
//! Places are chosen farthest first (Gonzalez, 1985) by the distance over the floor, so that every walkable place is near one. Neighbours are places
//! whose regions touch. Of the paths between them, a greedy spanner is kept (Althöfer, Das, Dobkin, Joseph, Soares, *On sparse spanners of weighted
//! graphs*, 1993), which is connected where the floor is.

use crate::floor::{Floor, square};
use geometry::Vector3;
use mapping::ground_surface::GroundCell;
use pathfinding::directed::dijkstra::dijkstra_reach;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

/// No cell.
const NONE: u32 = u32::MAX;
/// Edge of the blocks by which the floor below a ceiling is looked up, metres.
const CEILING_BLOCK_M: f64 = 1.0;
/// Millimetres in a metre: distances over the floor are whole millimetres, so that they are ordered.
const MM: f64 = 1e3;

/// Floor on which the middle of the robot can be.
struct Walkable {
    cells: Vec<GroundCell>,
    centres: Vec<Vector3>,
    /// For each cell: free distance to obstacles, metres, at most the inflation distance.
    clearance_m: Vec<f64>,
    /// For each cell: the cells to which one can step.
    neighbours: Vec<[u32; 8]>,
}

/// What is reached from the chosen places.
struct Reach {
    /// For each cell: its distance to the nearest place over the floor, millimetres.
    distance: Vec<u32>,
    /// For each cell: the next cell on the path to that place.
    parent: Vec<u32>,
    /// For each cell: the number of that place.
    place: Vec<u32>,
}

/// The paths: positions of the feet, metres.
pub(crate) fn survey_paths(floor: &Floor) -> Vec<Vec<Vector3>> {
    let walkable = Walkable::new(floor);
    let cover = (floor.config.survey_cover_m * MM) as u32;
    let mut reach = Reach::new(walkable.cells.len());
    let mut places = Vec::new();
    for piece in walkable.pieces(floor) {
        let piece = walkable.with_room(floor, piece);
        let mut next = piece.iter().copied().max_by(|a, b| walkable.by_room(*a, *b));
        while let Some(place) = next {
            reach.add(&walkable, floor, place, places.len() as u32);
            places.push(place);
            next = walkable.next_place(&piece, &reach, cover);
        }
    }
    let kept = spanner(connections(&walkable, &reach), places.len(), floor.config.max_survey_detour);
    kept.iter().map(|connection| walkable.trace(floor, &reach, connection)).collect()
}

impl Walkable {
    fn new(floor: &Floor) -> Self {
        let inflation_m = floor.config.survey_inflation_m;
        // The path through a narrow passage is moved to its middle later.
        let least_m = floor.robot.radius_m - floor.config.max_survey_shift_m;
        let (mut cells, mut clearance_m) = (Vec::new(), Vec::new());
        for cell in floor.cells() {
            let at = floor.centre(cell);
            let room = floor.room(&at, &at, inflation_m);
            let free_m = room.map_or(0.0, |room| room.left_m.min(room.right_m));
            // At the border of the known ground the feet have no room.
            if free_m >= least_m && floor.ground_neighbours(cell) >= floor.config.min_survey_ground_neighbours
            {
                cells.push(cell);
                clearance_m.push(free_m);
            }
        }
        let numbers: BTreeMap<GroundCell, u32> = cells.iter().copied().zip(0..).collect();
        let neighbours = cells.iter().map(|&(x, y, layer)| {
            let mut found = [NONE; 8];
            let around = square(1).filter(|offset| *offset != (0, 0));
            for (slot, (dx, dy)) in found.iter_mut().zip(around) {
                let next = floor.near(x + dx, y + dy, layer).map(|layer| (x + dx, y + dy, layer));
                *slot = next.and_then(|next| numbers.get(&next)).copied().unwrap_or(NONE);
            }
            found
        });
        let neighbours = neighbours.collect();
        let centres = cells.iter().map(|cell| floor.centre(*cell)).collect();
        Self { cells, centres, clearance_m, neighbours }
    }

    fn next_to(&self, cell: u32) -> impl Iterator<Item = u32> + '_ {
        self.neighbours[cell as usize].iter().copied().filter(|next| *next != NONE)
    }

    /// Orders cells by their room; the first of equals is the greatest.
    fn by_room(&self, a: u32, b: u32) -> std::cmp::Ordering {
        let room = |cell: u32| (self.clearance_m[cell as usize] * 10.0) as u32;
        room(a).cmp(&room(b)).then(b.cmp(&a))
    }

    /// Connected pieces that are large enough and no ceilings, the largest first, each in the order of its cells.
    fn pieces(&self, floor: &Floor) -> Vec<Vec<u32>> {
        let mut waiting: BTreeSet<u32> = (0..self.cells.len() as u32).collect();
        let mut pieces = Vec::new();
        while let Some(first) = waiting.pop_first() {
            let mut piece = vec![first];
            let mut index = 0;
            while let Some(cell) = piece.get(index).copied() {
                piece.extend(self.next_to(cell).filter(|next| waiting.remove(next)));
                index += 1;
            }
            if piece.len() as f64 * floor.cell_area_m2() >= floor.config.min_survey_piece_m2 {
                piece.sort_unstable();
                pieces.push(piece);
            }
        }
        pieces.sort_by_key(|piece| (Reverse(piece.len()), piece[0]));
        self.without_ceilings(floor, pieces)
    }

    /// Leaves out ceilings. A scanner in a hall sees them from below, so they are level surfaces with nothing above, like ground. `pieces`: the largest first.
    fn without_ceilings(&self, floor: &Floor, pieces: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
        let config = &floor.config;
        let block = |at: &Vector3| [at.x, at.y].map(|c| (c / CEILING_BLOCK_M).floor() as i32);
        let reach = (config.ceiling_reach_m / CEILING_BLOCK_M).ceil() as i32;
        // The lowest floor of the pieces that are kept, by blocks.
        let mut lowest: BTreeMap<[i32; 2], f64> = BTreeMap::new();
        let mut kept = Vec::new();
        for piece in pieces {
            let mut found: BTreeMap<[i32; 2], f64> = BTreeMap::new();
            let mut lower_around = |[x, y]: [i32; 2]| {
                *found.entry([x, y]).or_insert_with(|| {
                    let blocks = square(reach).filter_map(|(dx, dy)| lowest.get(&[x + dx, y + dy]));
                    blocks.copied().fold(f64::INFINITY, f64::min)
                })
            };
            let is_above = |cell: &&u32| {
                let at = &self.centres[**cell as usize];
                floor.is_open(self.cells[**cell as usize])
                    && lower_around(block(at)) <= at.z - config.min_ceiling_height_m
            };
            let above = piece.iter().filter(is_above).count();
            if above as f64 >= config.ceiling_share * piece.len() as f64 {
                continue;
            }
            for cell in &piece {
                let at = &self.centres[*cell as usize];
                lowest.entry(block(at)).and_modify(|low| *low = at.z.min(*low)).or_insert(at.z);
            }
            kept.push(piece);
        }
        kept
    }

    /// The cells on which the robot can turn. The others are only passed, in the middle of narrow passages.
    fn with_room(&self, floor: &Floor, mut cells: Vec<u32>) -> Vec<u32> {
        let least_m = floor.robot.radius_m + floor.config.voxel_m / 2.0;
        cells.retain(|cell| self.clearance_m[*cell as usize] >= least_m);
        cells
    }

    /// The place to add: among the cells that are nearly the farthest from all places, the one with the most room.
    fn next_place(&self, piece: &[u32], reach: &Reach, cover: u32) -> Option<u32> {
        let distance = |cell: u32| reach.distance[cell as usize];
        let farthest = piece.iter().map(|cell| distance(*cell)).max()?;
        if farthest <= cover {
            return None;
        }
        let least = (farthest / 4 * 3).max(cover);
        let far = piece.iter().copied().filter(|cell| distance(*cell) >= least);
        far.max_by(|a, b| self.by_room(*a, *b).then(distance(*a).cmp(&distance(*b))))
    }

    /// Cost of a step, millimetres.
    fn cost(&self, floor: &Floor, from: u32, to: u32) -> u32 {
        let is_tight = self.clearance_m[to as usize] < floor.config.survey_inflation_m;
        let factor = if is_tight { floor.config.survey_tight_cost } else { 1.0 };
        ((self.centres[from as usize] - self.centres[to as usize]).norm() * factor * MM) as u32
    }

    /// The path of a connection, in the middle of narrow passages.
    fn trace(&self, floor: &Floor, reach: &Reach, connection: &Connection) -> Vec<Vector3> {
        let half = |cell: u32| {
            std::iter::successors(Some(cell), |at| {
                Some(reach.parent[*at as usize]).filter(|next| *next != NONE)
            })
        };
        let mut cells: Vec<u32> = half(connection.border[0]).collect();
        cells.reverse();
        cells.extend(half(connection.border[1]));
        let feet: Vec<Vector3> = cells.iter().map(|cell| self.centres[*cell as usize]).collect();
        let centred = (0..feet.len()).map(|index| {
            let (before, after) = (feet[index.saturating_sub(1)], feet[(index + 1).min(feet.len() - 1)]);
            self.centre(floor, feet[index], &before, &after)
        });
        centred.collect()
    }

    /// A place of a path, moved sideways to where there is the same room on both sides.
    fn centre(&self, floor: &Floor, at: Vector3, before: &Vector3, after: &Vector3) -> Vector3 {
        let inflation_m = floor.config.survey_inflation_m;
        let Some(along) = (after - before).xy().try_normalize(1e-6) else { return at };
        let half = Vector3::new(along.x, along.y, 0.0) * floor.config.survey_room_half_length_m;
        let Some(room) = floor.room(&(at - half), &(at + half), inflation_m) else { return at };
        let max_m = floor.config.max_survey_shift_m;
        let shift_m = ((room.left_m - room.right_m) / 2.0).clamp(-max_m, max_m);
        at + Vector3::new(-along.y, along.x, 0.0) * shift_m
    }
}

impl Reach {
    fn new(cells: usize) -> Self {
        Self { distance: vec![u32::MAX; cells], parent: vec![NONE; cells], place: vec![NONE; cells] }
    }

    /// Adds a place: Dijkstra's search, which ends at cells that are nearer to another place.
    fn add(&mut self, walkable: &Walkable, floor: &Floor, cell: u32, number: u32) {
        let index = cell as usize;
        (self.distance[index], self.parent[index], self.place[index]) = (0, NONE, number);
        // The search visits cells in the order of their distance, so that of a cell is final when its steps are asked for.
        dijkstra_reach(&cell, |from| self.steps(walkable, floor, *from, number)).for_each(drop);
    }

    /// The steps from a cell that bring the place nearer to the next cell than any place was, with their costs, millimetres. They are noted at once. Of equally
    /// short paths the one over the cell with the least number counts.
    fn steps(
        &mut self,
        walkable: &Walkable,
        floor: &Floor,
        from: u32,
        number: u32,
    ) -> impl Iterator<Item = (u32, u64)> + use<> {
        let mut steps = [None; 8];
        for (step, next) in steps.iter_mut().zip(walkable.next_to(from)) {
            let cost = walkable.cost(floor, from, next);
            let reached = self.distance[from as usize].saturating_add(cost);
            let (distance, parent, place) = (
                &mut self.distance[next as usize],
                &mut self.parent[next as usize],
                &mut self.place[next as usize],
            );
            if reached < *distance {
                (*distance, *parent, *place) = (reached, from, number);
                *step = Some((next, u64::from(cost)));
            } else if reached == *distance && *place == number {
                *parent = from.min(*parent);
            }
        }
        steps.into_iter().flatten()
    }
}

/// The cheapest path between two neighbouring places.
#[derive(Clone, Copy, Debug)]
struct Connection {
    cost: u32,
    places: [u32; 2],
    /// The two cells at which their regions touch on it.
    border: [u32; 2],
}

/// The cheapest path between each two places whose regions touch.
fn connections(walkable: &Walkable, reach: &Reach) -> Vec<Connection> {
    let mut best: BTreeMap<[u32; 2], Connection> = BTreeMap::new();
    for cell in 0..walkable.cells.len() as u32 {
        for next in walkable.next_to(cell).filter(|next| *next > cell) {
            let (mut border, mut places) = ([cell, next], [cell, next].map(|one| reach.place[one as usize]));
            if places[0] == places[1] || places.contains(&NONE) {
                continue;
            }
            if places[0] > places[1] {
                (border, places) = ([next, cell], [places[1], places[0]]);
            }
            let cost = border.iter().map(|one| reach.distance[*one as usize]).fold(0, u32::saturating_add);
            let found = Connection { cost, places, border };
            let known = best.entry(places).or_insert(found);
            if (found.cost, found.border) < (known.cost, known.border) {
                *known = found;
            }
        }
    }
    best.into_values().collect()
}

/// Leaves out connections that are not much shorter than the kept ones between the same places (docs/maths/topomap.md, equation 3).
fn spanner(mut connections: Vec<Connection>, places: usize, max_detour: f64) -> Vec<Connection> {
    connections.sort_by_key(|connection| (connection.cost, connection.places));
    let mut links: Vec<BTreeMap<u32, u32>> = vec![BTreeMap::new(); places];
    let mut kept = Vec::new();
    for connection in connections {
        let [a, b] = connection.places;
        let limit = (f64::from(connection.cost) * max_detour) as u32;
        if !is_within(&links, a, b, limit) {
            links[a as usize].insert(b, connection.cost);
            links[b as usize].insert(a, connection.cost);
            kept.push(connection);
        }
    }
    kept
}

/// Whether there is a path between two places that costs at most `limit`.
fn is_within(links: &[BTreeMap<u32, u32>], from: u32, to: u32, limit: u32) -> bool {
    let steps = |place: &u32| links[*place as usize].iter().map(|(next, step)| (*next, u64::from(*step)));
    dijkstra_reach(&from, steps)
        .take_while(|reached| reached.total_cost <= u64::from(limit))
        .any(|reached| reached.node == to)
}

#[cfg(test)]
#[path = "survey_tests.rs"]
mod tests;
