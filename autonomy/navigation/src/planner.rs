//! Shortest paths over the elevation map: A* to a goal, Dijkstra to everything within a radius, then straightened by line of sight.
//!
//! Source: Hart, Nilsson, Raphael, *A Formal Basis for the Heuristic Determination of Minimum Cost Paths*, 1968; the searches are those of the
//! crate `pathfinding`.

use crate::clearance_field::ClearanceField;
use crate::{CellIndex, ElevationMap, texts};
use geometry::Vector3;
use ordered_float::OrderedFloat;
use pathfinding::directed::{astar::astar, dijkstra::dijkstra_reach};
use std::collections::BTreeMap;

/// Parameters of [`plan`] and [`crate::explore`]. The values were tuned on the simulated sites.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannerConfig {
    /// Cells that a search examines at most: 1,000 m² at 10 cm, which takes some 50 ms. Chosen: more than twice the area within the range of the elevation map (12 m),
    /// and the time of a search is bounded by it.
    pub max_examined_cells: usize,
    /// Factor by which ground that was never seen costs more than known ground. Chosen: a known detour of three times the length is preferred. With more, a robot that
    /// sees no floor beside itself goes far round; with less, it cuts corners that it does not see.
    pub unknown_cost_factor: f64,
    /// Distance beyond the robot's radius within which an obstacle makes a cell cost more, metres (the inflation of Nav2's costmaps). It exceeds the room that
    /// [`crate::MotionGuard`] wants at full speed. Sensitivity: with 0.3 m, paths past people come within an arm's length; with 0.6 m, all of an aisle of 2 m costs more.
    pub inflation_m: f64,
    /// Factor by which a cell at the robot's radius from an obstacle costs more; it falls with the square of the distance. Sensitivity: 1.5 lets paths cut corners of
    /// machines, 8 makes detours of metres round a post.
    pub inflation_cost_factor: f64,
    /// Distance within which a free cell is searched for when the start or the goal is blocked, metres. Chosen: twice the radius of the footprint.
    pub free_cell_search_m: f64,
    /// Cost factors up to 1 plus this count as 1: cells without extra cost, over which a path may be straightened. Above the rounding of the
    /// factors' products and far below any extra cost.
    pub cost_factor_tolerance: f64,
}

impl Default for PlannerConfig {
    fn default() -> Self {
        Self {
            max_examined_cells: 100_000,
            unknown_cost_factor: 3.0,
            inflation_m: 0.4,
            inflation_cost_factor: 4.0,
            free_cell_search_m: 0.8,
            cost_factor_tolerance: 1e-9,
        }
    }
}

/// Why there is no path; the texts are for people.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanError {
    /// Something stands at the goal.
    GoalBlocked,
    /// The goal lies in a zone that is kept out of.
    GoalKeptOut,
    /// The robot stands in an obstacle.
    StartBlocked,
    /// Every path is blocked.
    NoPath,
    /// The search was ended after [`PlannerConfig::max_examined_cells`].
    TooFar,
}

impl std::fmt::Display for PlanError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::GoalBlocked => texts::GOAL_BLOCKED,
            Self::GoalKeptOut => texts::GOAL_KEPT_OUT,
            Self::StartBlocked => texts::START_BLOCKED,
            Self::NoPath => texts::NO_PATH,
            Self::TooFar => texts::TOO_FAR,
        })
    }
}

impl std::error::Error for PlanError {}

/// Path from `from` to `to` (map frame, metres) as corner points. The first is at `from`, the last at `to` or, if `to` is blocked, at the free cell next
/// to it.
///
/// Cost grows with the number of cells nearer to the start than the goal is, [`PlannerConfig::max_examined_cells`] at most.
///
/// # Errors
/// When the start or the goal is blocked, or no path was found.
pub fn plan(
    config: &PlannerConfig,
    elevation_map: &ElevationMap,
    from: &Vector3,
    to: &Vector3,
) -> Result<Vec<Vector3>, PlanError> {
    if elevation_map.zones().is_kept_out([to.x, to.y]) {
        return Err(PlanError::GoalKeptOut);
    }
    let mut search = GridSearch::new(*config, elevation_map);
    let start = search.nearest_free(elevation_map.index(from.x, from.y)).ok_or(PlanError::StartBlocked)?;
    let goal = search.nearest_free(elevation_map.index(to.x, to.y)).ok_or(PlanError::GoalBlocked)?;
    let cells = search.shortest_path(start, goal)?;
    let mut path = search.path(from, &cells);
    if let Some(last) = path.last_mut().filter(|_| goal == elevation_map.index(to.x, to.y)) {
        *last = Vector3::new(to.x, to.y, last.z);
    }
    Ok(path)
}

/// Offsets of a cell's neighbours.
const NEIGHBOURS: [(i32, i32); 8] = [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)];

/// Cost of a path: its length in cells, times the cost factors of its cells.
type PathCost = OrderedFloat<f64>;

/// Parent of each reached cell on the cheapest path from the start. The start is its own parent.
pub(crate) type Parents = BTreeMap<CellIndex, CellIndex>;

pub(crate) struct GridSearch<'a> {
    config: PlannerConfig,
    elevation_map: &'a ElevationMap,
    clearances: ClearanceField<'a>,
    /// Cost factors computed so far; `None` where the robot cannot stand.
    factors: BTreeMap<CellIndex, Option<f64>>,
}

impl<'a> GridSearch<'a> {
    pub(crate) fn new(config: PlannerConfig, elevation_map: &'a ElevationMap) -> Self {
        let clearances =
            ClearanceField::new(elevation_map, elevation_map.shape().radius_m + config.inflation_m);
        Self { config, elevation_map, clearances, factors: BTreeMap::new() }
    }

    /// Corners of a path over `cells`, the first at `from`.
    pub(crate) fn path(&mut self, from: &Vector3, cells: &[CellIndex]) -> Vec<Vector3> {
        let elevation_map = self.elevation_map;
        let corner = |cell: CellIndex| {
            let (x, y) = elevation_map.centre(cell);
            Vector3::new(x, y, elevation_map.cell(cell).ground().unwrap_or(from.z))
        };
        let mut path: Vec<Vector3> = self.straighten(cells).into_iter().map(corner).collect();
        let start = Vector3::new(from.x, from.y, path.first().map_or(from.z, |first| first.z));
        match path.first_mut().filter(|_| cells.first() == Some(&elevation_map.index(from.x, from.y))) {
            Some(first) => *first = start,
            // The robot is too near to something. It goes to the free cell next to it first.
            None => path.insert(0, start),
        }
        path
    }

    /// Factor by which a cell costs more than known ground away from obstacles; none where the robot cannot stand.
    fn cost_factor(&mut self, cell: CellIndex) -> Option<f64> {
        if let Some(&known) = self.factors.get(&cell) {
            return known;
        }
        let of_zones = self.elevation_map.zones().cost_factor(self.elevation_map.centre(cell).into());
        let factor = of_zones.and_then(|of_zones| {
            let is_unknown = self.elevation_map.cell(cell).ground().is_none();
            let unknown = if is_unknown { self.config.unknown_cost_factor } else { 1.0 };
            Some(of_zones * unknown * self.inflation(cell)?)
        });
        self.factors.insert(cell, factor);
        factor
    }

    /// Whether a cell is known ground away from obstacles.
    pub(crate) fn is_outside_inflation(&mut self, cell: CellIndex) -> bool {
        let max_factor = 1.0 + self.config.cost_factor_tolerance;
        self.cost_factor(cell).is_some_and(|factor| factor <= max_factor)
    }

    /// Factor by which a cell near obstacles costs more; none where the robot would touch one (docs/maths/navigation.md, equation 1).
    fn inflation(&mut self, cell: CellIndex) -> Option<f64> {
        if !self.elevation_map.is_free(cell) {
            return None;
        }
        let room_m = self.clearances.distance_m(cell) - self.elevation_map.shape().radius_m;
        let PlannerConfig { inflation_m, inflation_cost_factor, .. } = self.config;
        let nearness = ((inflation_m - room_m) / inflation_m).max(0.0);
        (room_m >= 0.0).then(|| 1.0 + (inflation_cost_factor - 1.0) * nearness.powi(2))
    }

    /// The free cell nearest to a cell, within [`PlannerConfig::free_cell_search_m`].
    pub(crate) fn nearest_free(&mut self, cell: CellIndex) -> Option<CellIndex> {
        let reach = (self.config.free_cell_search_m / self.elevation_map.cell_size_m()).ceil() as i32;
        let mut candidates: Vec<(i32, CellIndex)> = (-reach..=reach)
            .flat_map(|dx| (-reach..=reach).map(move |dy| (dx, dy)))
            .map(|(dx, dy)| (dx * dx + dy * dy, CellIndex { x: cell.x + dx, y: cell.y + dy }))
            .filter(|(distance, _)| *distance <= reach * reach)
            .collect();
        candidates.sort_unstable();
        candidates.into_iter().map(|(_, cell)| cell).find(|&cell| self.cost_factor(cell).is_some())
    }

    /// Cost factor of a step between neighbouring cells; none where the robot cannot take it.
    fn step_factor(&mut self, from: CellIndex, to: CellIndex) -> Option<f64> {
        let factor = self.cost_factor(to)?;
        let (Some(a), Some(b)) =
            (self.elevation_map.cell(from).ground(), self.elevation_map.cell(to).ground())
        else {
            return Some(factor);
        };
        ((a - b).abs() <= self.elevation_map.shape().step_m).then_some(factor)
    }

    /// The neighbours that can be reached from a cell, each with the cost of the step.
    fn steps(&mut self, cell: CellIndex) -> Vec<(CellIndex, PathCost)> {
        let step = |(dx, dy): (i32, i32)| {
            let next = CellIndex { x: cell.x + dx, y: cell.y + dy };
            let length = if dx != 0 && dy != 0 { std::f64::consts::SQRT_2 } else { 1.0 };
            self.step_factor(cell, next).map(|factor| (next, OrderedFloat(length * factor)))
        };
        NEIGHBOURS.into_iter().filter_map(step).collect()
    }

    /// Cheapest path over the cells, start and goal included.
    fn shortest_path(&mut self, start: CellIndex, goal: CellIndex) -> Result<Vec<CellIndex>, PlanError> {
        // The length of the straight path in eight directions: never more than the cost, because factors are 1 at least.
        let heuristic = |cell: &CellIndex| {
            let (dx, dy) = (f64::from((cell.x - goal.x).abs()), f64::from((cell.y - goal.y).abs()));
            OrderedFloat(dx.max(dy) + (std::f64::consts::SQRT_2 - 1.0) * dx.min(dy))
        };
        let max_cells = self.config.max_examined_cells;
        let mut examined = 0;
        let successors = |cell: &CellIndex| {
            examined += 1;
            if examined > max_cells { Vec::new() } else { self.steps(*cell) }
        };
        match astar(&start, successors, heuristic, |cell| *cell == goal) {
            Some((cells, _)) => Ok(cells),
            None if examined > max_cells => Err(PlanError::TooFar),
            None => Err(PlanError::NoPath),
        }
    }

    /// Everything that can be reached within `radius` cells.
    pub(crate) fn reach(&mut self, start: CellIndex, radius: f64) -> Parents {
        let is_within =
            |cell: &CellIndex| f64::from(cell.x - start.x).hypot(f64::from(cell.y - start.y)) <= radius;
        let successors = |cell: &CellIndex| {
            self.steps(*cell).into_iter().filter(|(next, _)| is_within(next)).collect::<Vec<_>>()
        };
        dijkstra_reach(&start, successors)
            .map(|reached| (reached.node, reached.parent.unwrap_or(reached.node)))
            .collect()
    }

    /// Leaves out the corners that can be skipped without a greater cost.
    fn straighten(&mut self, cells: &[CellIndex]) -> Vec<CellIndex> {
        let costs = self.costs(cells);
        let mut corners = vec![cells[0]];
        let mut at = 0;
        while at + 1 < cells.len() {
            let mut next = at + 1;
            // Doubling, then bisecting, keeps this close to linear.
            let mut stride = 1;
            let mut can_skip = |to: usize| self.is_cheap(cells[at], cells[to], costs[to] - costs[at]);
            while at + stride < cells.len() && can_skip(at + stride) {
                next = at + stride;
                stride *= 2;
            }
            let mut high = (at + stride).min(cells.len() - 1);
            while next + 1 < high {
                let middle = usize::midpoint(next, high);
                if can_skip(middle) { next = middle } else { high = middle }
            }
            if high > next && can_skip(high) {
                next = high;
            }
            corners.push(cells[next]);
            at = next;
        }
        corners
    }

    /// Cost of a path of neighbouring cells up to each of them.
    fn costs(&mut self, cells: &[CellIndex]) -> Vec<f64> {
        let mut costs = vec![0.0];
        for pair in cells.windows(2) {
            let factor = self.cost_factor(pair[1]).unwrap_or(f64::INFINITY);
            let diagonal = pair[0].x != pair[1].x && pair[0].y != pair[1].y;
            let length = if diagonal { std::f64::consts::SQRT_2 } else { 1.0 };
            costs.push(costs[costs.len() - 1] + length * factor);
        }
        costs
    }

    /// Whether the robot can walk straight from one cell to another, at this cost at most.
    fn is_cheap(&mut self, from: CellIndex, to: CellIndex, max_cost: f64) -> bool {
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let steps = dx.abs().max(dy.abs()).max(1);
        let step_length = f64::from(dx).hypot(f64::from(dy)) / f64::from(steps);
        let (mut last, mut cost) = (from, 0.0);
        (1..=steps).all(|step| {
            let along = |a: i32, b: i32| a + (f64::from((b - a) * step) / f64::from(steps)).round() as i32;
            let cell = CellIndex { x: along(from.x, to.x), y: along(from.y, to.y) };
            let Some(factor) = self.step_factor(last, cell) else { return false };
            (last, cost) = (cell, cost + step_length * factor);
            cost <= max_cost * (1.0 + self.config.cost_factor_tolerance)
        })
    }
}

/// The path from the start to `goal`, which has been reached, start and goal included.
pub(crate) fn trace(parents: &Parents, goal: CellIndex) -> Vec<CellIndex> {
    let parent = |cell: &CellIndex| parents.get(cell).copied().filter(|parent| parent != cell);
    let mut cells: Vec<CellIndex> = std::iter::successors(Some(goal), parent).collect();
    cells.reverse();
    cells
}

#[cfg(test)]
#[path = "planner_tests.rs"]
pub(crate) mod tests;
