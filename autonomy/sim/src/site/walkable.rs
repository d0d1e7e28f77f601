//! The floor of a site that a robot can reach on its feet, and a round over it. For sites whose makers did not say where to walk.

use crate::bvh::Bvh;
use crate::route::{SiteRoute, Start};
use geometry::{Vector3, vec_from_plain};
use pathfinding::directed::dijkstra::dijkstra;
use std::collections::BTreeMap;

/// Parameters of [`WalkableFloor`] and of its round.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WalkableConfig {
    /// Distance between neighbouring cells, metres. Doors of 0.9 m need 0.3 m or less.
    pub(crate) cell_m: f64,
    /// Greatest number of cells: 20,000 square metres. Chosen: larger than the sites that are simulated; it bounds the time.
    pub(crate) max_cells: usize,
    /// Greatest difference in height between neighbours, metres: two steps of stairs. Chosen: neighbours are a step of stairs apart, or two at the diagonal.
    pub(crate) max_rise_m: f64,
    /// Distance from obstacles that the round keeps where it can, metres. Less than the height at which it is checked, 0.6 m, so that the edges of
    /// a floor's triangles are no obstacles. Chosen: about one and a half times the radius of the robot.
    pub(crate) inflation_m: f64,
    /// Cost of a cell that is nearer to an obstacle, relative to others. Chosen: a detour of six cells is preferred to one of these.
    pub(crate) tight_cost: u32,
    /// Floor within this distance of the round counts as seen, metres. Chosen: the rings of the LiDAR on the floor are dense within it.
    pub(crate) seen_m: f64,
    /// Greatest distance of a shortcut from the path that it replaces, metres. Chosen: half of [`Self::seen_m`], so that what was near the path is still seen; without it a round of a hall
    /// without walls inside would be the way back to its start only.
    pub(crate) shortcut_m: f64,
    /// The round turns back after this length, metres: ten minutes of walking. Chosen: at the usual speed of 0.7 m/s.
    pub(crate) max_length_m: f64,
}

impl Default for WalkableConfig {
    fn default() -> Self {
        Self {
            cell_m: 0.3,
            max_cells: 220_000,
            max_rise_m: 0.36,
            inflation_m: 0.55,
            tight_cost: 6,
            seen_m: 4.0,
            shortcut_m: 2.0,
            max_length_m: 420.0,
        }
    }
}

/// Heights above the floor and radii of the spheres that must be free, metres: body and mast of the robot, with a margin.
const HULL: [(f64, f64); 2] = [(0.60, 0.40), (0.85, 0.32)];
/// A surface stops horizontal motion if its normal is at least this steep, as in `locomotion`.
const WALL_LEVEL: f64 = 0.3;
/// Start of the probes for the floor above the neighbour's, metres.
const PROBE_HEIGHT_M: f64 = 0.45;

/// A place where the robot can stand.
#[derive(Clone, Copy, Debug)]
struct Cell {
    position: Vector3,
    is_tight: bool,
}

/// The floor that can be reached from a start.
#[derive(Clone, Debug, Default)]
pub(crate) struct WalkableFloor {
    cells: Vec<Cell>,
    /// Cells by their column and row, counted from the start, with all floors.
    index: BTreeMap<(i32, i32), Vec<u32>>,
    origin: Vector3,
    cell_m: f64,
}

impl WalkableFloor {
    /// Finds the floor among the solids of `bvh` that can be reached from `start`.
    pub(crate) fn new(bvh: &Bvh, start: &Start, config: &WalkableConfig) -> Self {
        let origin = vec_from_plain(start.position);
        let mut floor = Self { origin, cell_m: config.cell_m, ..Self::default() };
        floor.try_add(bvh, (0, 0), origin.z, config);
        let mut next = 0;
        while next < floor.cells.len() && floor.cells.len() < config.max_cells {
            let (at, height) = (floor.column_row(&floor.cells[next].position), floor.cells[next].position.z);
            for (x, y) in [(1, 0), (0, 1), (-1, 0), (0, -1)] {
                floor.try_add(bvh, (at.0 + x, at.1 + y), height, config);
            }
            next += 1;
        }
        floor
    }

    /// Adds the cell if a robot that stands beside it at that height can step there.
    fn try_add(&mut self, bvh: &Bvh, at: (i32, i32), height: f64, config: &WalkableConfig) {
        if self.cell_at(at, height, config.max_rise_m).is_some() {
            return;
        }
        let over = self.origin.xy() + nalgebra::Vector2::new(f64::from(at.0), f64::from(at.1)) * self.cell_m;
        let top = height + PROBE_HEIGHT_M;
        let probe = Vector3::new(over.x, over.y, top);
        let Some((down, _)) = bvh.first_hit(&probe, &-Vector3::z(), 2.0 * PROBE_HEIGHT_M) else { return };
        let position = Vector3::new(over.x, over.y, top - down);
        let is_free = (position.z - height).abs() <= config.max_rise_m
            && HULL.iter().all(|(up, radius)| !is_touched(bvh, &position, *up, *radius));
        if is_free && self.cell_at(at, position.z, config.max_rise_m).is_none() {
            let is_tight = is_touched(bvh, &position, HULL[0].0, config.inflation_m);
            self.index.entry(at).or_default().push(self.cells.len() as u32);
            self.cells.push(Cell { position, is_tight });
        }
    }

    /// The number of the cell there, whose floor is within `tolerance` of a height.
    fn cell_at(&self, at: (i32, i32), height: f64, tolerance: f64) -> Option<u32> {
        let cells = self.index.get(&at)?;
        cells.iter().copied().find(|cell| (self.cells[*cell as usize].position.z - height).abs() <= tolerance)
    }

    fn column_row(&self, position: &Vector3) -> (i32, i32) {
        let offset = (position - self.origin) / self.cell_m;
        (offset.x.round() as i32, offset.y.round() as i32)
    }

    /// Number of cells.
    pub(crate) fn len(&self) -> usize {
        self.cells.len()
    }

    /// Whether a place is on this floor.
    pub(crate) fn contains(&self, feet: &Vector3) -> bool {
        let (column, row) = self.column_row(feet);
        let near = |(x, y): (i32, i32)| self.cell_at((column + x, row + y), feet.z, 0.3).is_some();
        [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)].into_iter().any(near)
    }

    /// A walk from the start past all of this floor and back.
    pub(crate) fn round(&self, start: &Start, config: &WalkableConfig) -> Option<SiteRoute> {
        let mut is_seen = vec![false; self.cells.len()];
        let mut path: Vec<u32> = vec![0];
        self.see(0, &mut is_seen, config);
        let max_cells = (config.max_length_m / config.cell_m) as usize;
        while path.len() < max_cells {
            let here = *path.last()?;
            let Some(leg) = self.shortest(here, config, |cell| !is_seen[cell as usize]) else { break };
            for cell in &leg[1..] {
                self.see(*cell, &mut is_seen, config);
            }
            path.extend(&leg[1..]);
        }
        let back = self.shortest(*path.last()?, config, |cell| cell == 0)?;
        path.extend(&back[1..]);
        let waypoints = self.straighten(&path, config.shortcut_m);
        (waypoints.len() > 2).then_some(SiteRoute { name: "round", start: *start, waypoints, speed: 0.9 })
    }

    /// Marks the floor near a cell that is reached over seen or near floor.
    fn see(&self, from: u32, is_seen: &mut [bool], config: &WalkableConfig) {
        let at = self.cells[from as usize].position;
        let reach = (config.seen_m / self.cell_m) as i32;
        let (column, row) = self.column_row(&at);
        // The region that grows from the cell inside a circle: what lies behind a wall is not in it.
        let (mut region, mut next) = (vec![from], 0);
        let mut done: std::collections::BTreeSet<u32> = [from].into();
        while next < region.len() {
            let cell = region[next];
            is_seen[cell as usize] = true;
            for neighbour in self.neighbours(cell) {
                let (x, y) = self.column_row(&self.cells[neighbour as usize].position);
                let (x, y) = (x - column, y - row);
                if x * x + y * y <= reach * reach && done.insert(neighbour) {
                    region.push(neighbour);
                }
            }
            next += 1;
        }
    }

    fn neighbours(&self, cell: u32) -> impl Iterator<Item = u32> + '_ {
        let Cell { position, .. } = self.cells[cell as usize];
        let (column, row) = self.column_row(&position);
        let rise = WalkableConfig::default().max_rise_m;
        [(1, 0), (0, 1), (-1, 0), (0, -1)]
            .into_iter()
            .filter_map(move |(x, y)| self.cell_at((column + x, row + y), position.z, rise))
    }

    /// The cheapest path to the nearest cell that `is_goal`, with both ends.
    fn shortest(
        &self,
        from: u32,
        config: &WalkableConfig,
        is_goal: impl Fn(u32) -> bool,
    ) -> Option<Vec<u32>> {
        let cost = |cell: u32| if self.cells[cell as usize].is_tight { config.tight_cost } else { 1 };
        let steps = |cell: &u32| self.neighbours(*cell).map(|next| (next, cost(next))).collect::<Vec<_>>();
        dijkstra(&from, steps, |cell| is_goal(*cell)).map(|(path, _)| path)
    }

    /// The corners of a path: a stretch is straight if the robot can walk straight from its first to its last cell, and stays within `shortcut_m` metres of all of it.
    fn straighten(&self, path: &[u32], shortcut_m: f64) -> Vec<[f64; 2]> {
        let (mut corners, mut first) = (Vec::new(), 0);
        while first + 1 < path.len() {
            let mut last = first + 1;
            while last + 1 < path.len() && self.is_straight(&path[first..=last + 1], shortcut_m) {
                last += 1;
            }
            let position = self.cells[path[last] as usize].position;
            corners.push([position.x, position.y]);
            first = last;
        }
        corners
    }

    /// Whether a stretch of a path can be replaced by the straight line between its ends: it is that line, or the line lies on cells that are not tight, and within `shortcut_m` metres of all cells of
    /// the stretch. Linear in the cells.
    fn is_straight(&self, path: &[u32], shortcut_m: f64) -> bool {
        let [Some(&from), Some(&to)] = [path.first(), path.last()] else { return true };
        let [a, b] = [from, to].map(|cell| self.cells[cell as usize].position);
        let span = b - a;
        let offset = |cell: &u32| (self.cells[*cell as usize].position - a).xy();
        let is_on_line = |cell: &u32| {
            span.xy().perp(&offset(cell)).abs() <= 1e-6 * span.xy().norm()
                && offset(cell).dot(&span.xy()) >= 0.0
        };
        if path.iter().all(is_on_line) {
            return true;
        }
        let is_near = |cell: &u32| {
            let along = (offset(cell).dot(&span.xy()) / span.xy().norm_squared().max(f64::MIN_POSITIVE))
                .clamp(0.0, 1.0);
            (offset(cell) - span.xy() * along).norm() <= shortcut_m
        };
        if !path.iter().all(is_near) {
            return false;
        }
        let steps = (span.xy().norm() / (0.5 * self.cell_m)).ceil().max(1.0) as usize;
        let mut height = a.z;
        (0..=steps).all(|step| {
            let point = a + span * (step as f64 / steps as f64);
            let cell = self.cell_at(self.column_row(&point), height, 0.1);
            cell.is_some_and(|cell| {
                height = self.cells[cell as usize].position.z;
                !self.cells[cell as usize].is_tight
            })
        })
    }
}

/// Whether a wall comes within `radius` of the point `up` above a place.
fn is_touched(bvh: &Bvh, feet: &Vector3, up: f64, radius: f64) -> bool {
    let (center, mut touched) = (feet + Vector3::z() * up, false);
    bvh.near(&center, radius, |solid| {
        let clearance = solid.shape.clearance(&center);
        touched |= clearance.distance < radius && clearance.outward.xy().norm() >= WALL_LEVEL;
    });
    touched
}
