//! A* over the terrain grid, eight neighbours, then straightened by line of sight.

use crate::{CellIndex, Terrain};
use geometry::Vector3;
use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

/// Cells examined before giving up: 1,000 m² at 10 cm, some 50 ms.
const MOST_CELLS: usize = 100_000;
/// Ground never seen costs this many times what known ground costs.
const UNKNOWN_COST: f64 = 3.0;
/// Cells this close to an obstacle beyond the robot's own radius cost more, so that paths keep away, metres.
const COMFORT: f64 = 0.3;
const COMFORT_COST: f64 = 1.5;
/// How far round a blocked start or goal a free cell is looked for, metres.
const NUDGE: f64 = 0.8;

/// Why there is no path; the texts are for people.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanError {
    /// Something stands at the goal.
    GoalBlocked,
    /// The robot stands in an obstacle.
    StartBlocked,
    /// Nowhere through.
    NoWay,
    /// Too far for a plan of this kind.
    TooFar,
}

impl std::fmt::Display for PlanError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::GoalBlocked => "Something stands at that point. Choose a free place on the floor.",
            Self::StartBlocked => {
                "The robot is too close to an obstacle to plan a way. Drive it clear by hand first."
            }
            Self::NoWay => {
                "No free way to that point is known yet. Drive closer by hand, or choose another point."
            }
            Self::TooFar => "That point is too far away for one walk. Choose a nearer one on the way.",
        })
    }
}

impl std::error::Error for PlanError {}

/// A way from `from` to `to` (map frame, metres) as corner points, the first at `from`, the last at or next to `to`.
///
/// Cost grows with the number of cells nearer to the start than the goal is, at most [`MOST_CELLS`].
pub fn plan(terrain: &Terrain, from: &Vector3, to: &Vector3) -> Result<Vec<Vector3>, PlanError> {
    let mut search = Search::new(terrain);
    let start = search.nearest_free(terrain.index(from.x, from.y)).ok_or(PlanError::StartBlocked)?;
    let goal = search.nearest_free(terrain.index(to.x, to.y)).ok_or(PlanError::GoalBlocked)?;
    let cells = search.run(start, goal)?;
    let mut path = search.path(from, &cells);
    if let Some(last) = path.last_mut().filter(|_| goal == terrain.index(to.x, to.y)) {
        *last = Vector3::new(to.x, to.y, last.z);
    }
    Ok(path)
}

/// Neighbours of a cell.
const AROUND: [(i32, i32); 8] = [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)];

/// Cheapest costs found so far, in cells, each with the cell that they came from.
pub(crate) type Reached = BTreeMap<CellIndex, (f64, CellIndex)>;

pub(crate) struct Search<'a> {
    terrain: &'a Terrain,
    /// Cost factor of the cells asked for so far; `None` where the robot cannot stand.
    free: BTreeMap<CellIndex, Option<f64>>,
}

#[derive(PartialEq)]
struct Open {
    estimate: f64,
    cell: CellIndex,
}

impl Eq for Open {}

impl Ord for Open {
    /// Least estimate first; ties by cell, so that the order is total and the plan repeatable.
    fn cmp(&self, other: &Self) -> Ordering {
        other.estimate.total_cmp(&self.estimate).then_with(|| other.cell.cmp(&self.cell))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<'a> Search<'a> {
    pub(crate) fn new(terrain: &'a Terrain) -> Self {
        Self { terrain, free: BTreeMap::new() }
    }

    /// The corners of a way over `cells`, the first at `from`.
    pub(crate) fn path(&mut self, from: &Vector3, cells: &[CellIndex]) -> Vec<Vector3> {
        let terrain = self.terrain;
        let corner = |cell: CellIndex| {
            let (x, y) = terrain.centre(cell);
            Vector3::new(x, y, terrain.cell(cell).ground().unwrap_or(from.z))
        };
        let mut path: Vec<Vector3> = self.straighten(cells).into_iter().map(corner).collect();
        if let Some(first) = path.first_mut() {
            *first = Vector3::new(from.x, from.y, first.z);
        }
        path
    }

    /// How much more a cell costs than comfortable, known ground; none where the robot cannot stand.
    pub(crate) fn factor(&mut self, cell: CellIndex) -> Option<f64> {
        if let Some(&known) = self.free.get(&cell) {
            return known;
        }
        let factor = self.terrain.is_free(cell).then(|| {
            let unknown = if self.terrain.cell(cell).ground().is_none() { UNKNOWN_COST } else { 1.0 };
            unknown * if self.is_tight(cell) { COMFORT_COST } else { 1.0 }
        });
        self.free.insert(cell, factor);
        factor
    }

    fn is_tight(&self, cell: CellIndex) -> bool {
        let reach = ((self.terrain.shape().radius + COMFORT) / self.terrain.cell_size()).floor() as i32;
        [(reach, 0), (-reach, 0), (0, reach), (0, -reach)]
            .iter()
            .any(|(dx, dy)| self.terrain.cell(CellIndex { x: cell.x + dx, y: cell.y + dy }).is_obstacle())
    }

    pub(crate) fn nearest_free(&mut self, cell: CellIndex) -> Option<CellIndex> {
        let reach = (NUDGE / self.terrain.cell_size()).ceil() as i32;
        let mut candidates: Vec<(i32, CellIndex)> = (-reach..=reach)
            .flat_map(|dx| (-reach..=reach).map(move |dy| (dx, dy)))
            .map(|(dx, dy)| (dx * dx + dy * dy, CellIndex { x: cell.x + dx, y: cell.y + dy }))
            .filter(|(distance, _)| *distance <= reach * reach)
            .collect();
        candidates.sort_unstable();
        candidates.into_iter().map(|(_, cell)| cell).find(|&cell| self.factor(cell).is_some())
    }

    fn passable(&mut self, from: CellIndex, to: CellIndex) -> Option<f64> {
        let factor = self.factor(to)?;
        let (Some(a), Some(b)) = (self.terrain.cell(from).ground(), self.terrain.cell(to).ground()) else {
            return Some(factor);
        };
        ((a - b).abs() <= self.terrain.shape().step).then_some(factor)
    }

    fn run(&mut self, start: CellIndex, goal: CellIndex) -> Result<Vec<CellIndex>, PlanError> {
        let heuristic = |cell: CellIndex| {
            let (dx, dy) = (f64::from((cell.x - goal.x).abs()), f64::from((cell.y - goal.y).abs()));
            dx.max(dy) + (std::f64::consts::SQRT_2 - 1.0) * dx.min(dy)
        };
        let mut best = Reached::from([(start, (0.0, start))]);
        let mut open = BinaryHeap::from([Open { estimate: heuristic(start), cell: start }]);
        let mut examined = 0;
        while let Some(Open { estimate, cell }) = open.pop() {
            if cell == goal {
                return Ok(trace(&best, start, goal));
            }
            let cost = best[&cell].0;
            if estimate > cost + heuristic(cell) + 1e-9 {
                continue;
            }
            examined += 1;
            if examined > MOST_CELLS {
                return Err(PlanError::TooFar);
            }
            for direction in AROUND {
                let Some((next, length)) = self.step(cell, direction) else { continue };
                let next_cost = cost + length;
                if best.get(&next).is_none_or(|(known, _)| next_cost < *known) {
                    best.insert(next, (next_cost, cell));
                    open.push(Open { estimate: next_cost + heuristic(next), cell: next });
                }
            }
        }
        Err(PlanError::NoWay)
    }

    /// The neighbour in a direction with what it costs to get there, cells.
    pub(crate) fn step(&mut self, cell: CellIndex, (dx, dy): (i32, i32)) -> Option<(CellIndex, f64)> {
        let next = CellIndex { x: cell.x + dx, y: cell.y + dy };
        let factor = self.passable(cell, next)?;
        let length = if dx != 0 && dy != 0 { std::f64::consts::SQRT_2 } else { 1.0 };
        Some((next, length * factor))
    }

    /// Everywhere within `radius` cells that can be reached, over ground that was never seen as well where there is no other.
    pub(crate) fn reach(&mut self, start: CellIndex, radius: f64) -> Reached {
        let is_within =
            |cell: CellIndex| f64::from(cell.x - start.x).hypot(f64::from(cell.y - start.y)) <= radius;
        let mut best = Reached::from([(start, (0.0, start))]);
        let mut open = BinaryHeap::from([Open { estimate: 0.0, cell: start }]);
        while let Some(Open { estimate: cost, cell }) = open.pop() {
            if cost > best[&cell].0 {
                continue;
            }
            for direction in AROUND {
                let Some((next, length)) = self.step(cell, direction) else { continue };
                let cost = cost + length;
                if is_within(next) && best.get(&next).is_none_or(|(known, _)| cost < *known) {
                    best.insert(next, (cost, cell));
                    open.push(Open { estimate: cost, cell: next });
                }
            }
        }
        best
    }

    /// Leaves out corners that can be skipped without leaving comfortable, known ground.
    fn straighten(&mut self, cells: &[CellIndex]) -> Vec<CellIndex> {
        let mut corners = vec![cells[0]];
        let mut at = 0;
        while at + 1 < cells.len() {
            let mut next = at + 1;
            // Doubling, then bisecting, keeps this close to linear.
            let mut stride = 1;
            while at + stride < cells.len() && self.is_clear(cells[at], cells[at + stride]) {
                next = at + stride;
                stride *= 2;
            }
            let mut high = (at + stride).min(cells.len() - 1);
            while next + 1 < high {
                let middle = usize::midpoint(next, high);
                if self.is_clear(cells[at], cells[middle]) { next = middle } else { high = middle }
            }
            if high > next && self.is_clear(cells[at], cells[high]) {
                next = high;
            }
            corners.push(cells[next]);
            at = next;
        }
        corners
    }

    fn is_clear(&mut self, from: CellIndex, to: CellIndex) -> bool {
        let steps = (to.x - from.x).abs().max((to.y - from.y).abs()).max(1);
        let mut last = from;
        (1..=steps).all(|step| {
            let along = |a: i32, b: i32| a + (f64::from((b - a) * step) / f64::from(steps)).round() as i32;
            let cell = CellIndex { x: along(from.x, to.x), y: along(from.y, to.y) };
            let clear = self.passable(last, cell).is_some_and(|factor| factor <= 1.0 + 1e-9);
            last = cell;
            clear
        })
    }
}

pub(crate) fn trace(best: &Reached, start: CellIndex, goal: CellIndex) -> Vec<CellIndex> {
    let mut cells = vec![goal];
    let mut cell = goal;
    while cell != start {
        cell = best[&cell].1;
        cells.push(cell);
    }
    cells.reverse();
    cells
}

#[cfg(test)]
#[path = "planner_tests.rs"]
pub(crate) mod tests;
