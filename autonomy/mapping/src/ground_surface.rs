//! Where one can stand in a cloud of points: level ground with room over it.
//!
//! Columns of 0.2 m and layers of 0.1 m. A layer is ground if the next thing over it is 1.2 m higher or more and most neighbouring
//! columns have ground at nearly the same height. Stairs are ground; tables and shelves are not, since what counts hangs together
//! over some square metres. Nor are roofs and the upper sides of ceilings: ground with nothing over it, and other ground below.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Edge of a column and height of a layer, metres.
pub(crate) const COLUMN: f32 = 0.2;
const LAYER: f32 = 0.1;
/// Free layers over the ground: a robot's height, and a little.
const HEADROOM: i32 = 12;
/// What is so thin over the ground is the ground's own noise, layers.
const NOISE: i32 = 1;
/// Novelty in neighbouring columns may differ so much, layers: a step of stairs.
const STEP: i32 = 2;
/// Of eight neighbours, so many have to have ground.
const NEIGHBOURS: usize = 6;
/// A piece of ground of which such a share has nothing over it and other ground so many layers below it or more is a roof.
const ROOF: f64 = 0.7;
const STOREY: i32 = 15;
/// Novelty that hangs together over fewer columns is none: 4 m².
const COLUMNS_MIN: usize = 100;

/// A column and the layer of its ground.
pub(crate) type Foot = (i32, i32, i32);

/// All ground of a cloud.
#[derive(Debug, Default)]
pub(crate) struct Floors {
    /// Layers of the ground in each column, ascending.
    layers: BTreeMap<(i32, i32), Vec<i32>>,
}

impl Floors {
    /// Finds the ground. `n log n` in the points.
    pub fn find(xyz: &[[f32; 3]]) -> Self {
        let mut cells: Vec<Foot> = xyz
            .iter()
            .filter(|point| point.iter().all(|c| c.abs() < 1e7))
            .map(|[x, y, z]| {
                let [x, y] = [x, y].map(|c| (c / COLUMN).floor() as i32);
                (x, y, (z / LAYER).floor() as i32)
            })
            .collect();
        cells.sort_unstable();
        cells.dedup();
        let mut candidates: BTreeMap<(i32, i32), Vec<i32>> = BTreeMap::new();
        let mut open = BTreeSet::new();
        for column in cells.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            for (index, &(x, y, layer)) in column.iter().enumerate() {
                let free = match column.get(index + 1) {
                    None => open.insert((x, y, layer)),
                    Some(next) if next.2 - layer > NOISE => next.2 - layer > HEADROOM,
                    Some(_) => false,
                };
                if free {
                    candidates.entry((x, y)).or_default().push(layer);
                }
            }
        }
        let candidates = Self { layers: candidates };
        let steady = candidates.feet().filter(|foot| candidates.around(*foot).count() >= NEIGHBOURS);
        Self::of(steady.collect()).without_small_and_roofs(&open)
    }

    fn of(feet: Vec<Foot>) -> Self {
        let mut layers: BTreeMap<(i32, i32), Vec<i32>> = BTreeMap::new();
        for (x, y, layer) in feet {
            layers.entry((x, y)).or_default().push(layer);
        }
        Self { layers }
    }

    /// Every place to stand at, in a fixed order.
    pub fn feet(&self) -> impl Iterator<Item = Foot> + '_ {
        self.layers.iter().flat_map(|((x, y), layers)| layers.iter().map(|layer| (*x, *y, *layer)))
    }

    /// The ground of a column nearest to a height, if it is within a step of it.
    pub fn near(&self, x: i32, y: i32, layer: i32) -> Option<i32> {
        let layers = self.layers.get(&(x, y))?;
        let nearest = layers.iter().copied().min_by_key(|other| (other - layer).abs())?;
        ((nearest - layer).abs() <= STEP).then_some(nearest)
    }

    /// Neighbouring places of a place.
    fn around(&self, (x, y, layer): Foot) -> impl Iterator<Item = Foot> + '_ {
        let neighbours = (-1..=1).flat_map(|i| (-1..=1).map(move |j| (i, j))).filter(|at| *at != (0, 0));
        neighbours.filter_map(move |(i, j)| Some((x + i, y + j, self.near(x + i, y + j, layer)?)))
    }

    /// Of 25 columns about a place, how many have ground at its height.
    pub fn room(&self, (x, y, layer): Foot) -> usize {
        (-2..=2)
            .flat_map(|i| (-2..=2).map(move |j| (i, j)))
            .filter(|(i, j)| self.near(x + i, y + j, layer).is_some())
            .count()
    }

    /// Number of columns of the largest piece of ground.
    pub fn largest(&self) -> usize {
        self.pieces().iter().map(Vec::len).max().unwrap_or(0)
    }

    /// `open` are places with nothing over them.
    fn without_small_and_roofs(self, open: &BTreeSet<Foot>) -> Self {
        let mut pieces = self.pieces();
        pieces.retain(|piece| piece.len() >= COLUMNS_MIN);
        let below = |foot: &Foot| {
            self.layers.get(&(foot.0, foot.1)).is_some_and(|layers| layers[0] <= foot.2 - STOREY)
        };
        pieces.retain(|piece| {
            let roof = piece.iter().filter(|foot| open.contains(foot) && below(foot)).count();
            (roof as f64) < ROOF * piece.len() as f64
        });
        let mut feet: Vec<Foot> = pieces.into_iter().flatten().collect();
        feet.sort_unstable();
        Self::of(feet)
    }

    /// What hangs together.
    fn pieces(&self) -> Vec<Vec<Foot>> {
        let mut waiting: BTreeSet<Foot> = self.feet().collect();
        let mut pieces = Vec::new();
        while let Some(first) = waiting.pop_first() {
            let (mut piece, mut queue) = (vec![first], VecDeque::from([first]));
            while let Some(foot) = queue.pop_front() {
                for next in self.around(foot).filter(|next| waiting.remove(next)).collect::<Vec<_>>() {
                    piece.push(next);
                    queue.push_back(next);
                }
            }
            pieces.push(piece);
        }
        pieces
    }

    /// Whether one can walk straight from one place to another.
    pub fn walkable(&self, from: Foot, to: Foot) -> bool {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let steps = dx.abs().max(dy.abs()).max(1);
        let mut layer = from.2;
        (1..=steps).all(|step| {
            let along = |from: i32, by: i32| from + (f64::from(by * step) / f64::from(steps)).round() as i32;
            let found = self.near(along(from.0, dx), along(from.1, dy), layer);
            layer = found.unwrap_or(layer);
            found.is_some()
        }) && (layer - to.2).abs() <= STEP
    }
}

/// The middle of a place, on the ground, metres.
pub(crate) fn on_ground((x, y, layer): Foot) -> [f32; 3] {
    [(x as f32 + 0.5) * COLUMN, (y as f32 + 0.5) * COLUMN, (layer as f32 + 0.5) * LAYER]
}
