//! Ground on which a robot can stand, found in a point cloud: level surfaces with enough free height above.
//!
//! The cloud is cut into columns and layers. A layer is ground if the next occupied layer above is high enough, and most neighbouring columns
//! have ground at nearly the same height. Stairs are ground. Tables and shelves are not, because ground has to be connected over some square
//! metres. Roofs and the upper sides of ceilings are not either: they have nothing above and other ground below.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Parameters of [`GroundSurface::find`]. Heights are counted in layers of `layer_m`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundConfig {
    /// Edge of a column, metres. Chosen: half the width that the feet of a robot need, and points of a map (0.05 m apart) fill a column.
    pub column_m: f32,
    /// Height of a layer, metres. Chosen: half a step of stairs, so that a step is two layers ([`Self::step_layers`]).
    pub layer_m: f32,
    /// Free layers required above the ground: a robot's height and a margin, 1.2 m.
    pub headroom_layers: i32,
    /// Occupied layers directly above the ground that still count as the ground's own noise. Chosen: the noise of a LiDAR lies on both sides of the border of a layer.
    pub noise_layers: i32,
    /// Greatest height difference of ground in neighbouring columns: a step of stairs, 0.2 m.
    pub step_layers: i32,
    /// Of eight neighbouring columns, how many must have ground. Chosen: the edge of a floor has five; a floor with holes loses viewpoints with more.
    pub min_neighbours: usize,
    /// A connected piece of ground is a roof if at least this share of it has nothing above and other ground below. Chosen as a round number: with more, roofs with
    /// chimneys and cables above count as ground; with less, mezzanines that are open above are lost.
    pub roof_share: f64,
    /// Least height of a roof above the ground below it, 1.5 m. Chosen: less than a storey and more than furniture.
    pub storey_layers: i32,
    /// Least size of a connected piece of ground: 4 m². Chosen: tables and tops of machines are smaller.
    pub min_columns: usize,
}

impl Default for GroundConfig {
    fn default() -> Self {
        Self {
            column_m: 0.2,
            layer_m: 0.1,
            headroom_layers: 12,
            noise_layers: 1,
            step_layers: 2,
            min_neighbours: 6,
            roof_share: 0.7,
            storey_layers: 15,
            min_columns: 100,
        }
    }
}

impl GroundConfig {
    /// Column and layer of a point.
    pub fn locate(&self, [x, y, z]: [f32; 3]) -> ((i32, i32), i32) {
        let [x, y] = [x, y].map(|c| (c / self.column_m).floor() as i32);
        ((x, y), (z / self.layer_m).floor() as i32)
    }

    /// Centre of a ground cell, metres.
    pub fn centre(&self, (x, y, layer): GroundCell) -> [f32; 3] {
        let [x, y] = [x, y].map(|c| (c as f32 + 0.5) * self.column_m);
        [x, y, (layer as f32 + 0.5) * self.layer_m]
    }
}

/// Column (x, y) and layer of a piece of ground.
pub type GroundCell = (i32, i32, i32);

/// All ground of a cloud.
#[derive(Debug)]
pub struct GroundSurface {
    config: GroundConfig,
    /// For each column: the layers of its ground, ascending.
    layers: BTreeMap<(i32, i32), Vec<i32>>,
}

impl GroundSurface {
    /// Finds the ground of a cloud (metres, z up). `O(n log n)` in the points.
    pub fn find(xyz: &[[f32; 3]], config: GroundConfig) -> Self {
        let mut cells: Vec<GroundCell> = xyz
            .iter()
            .filter(|point| point.iter().all(|c| c.abs() < 1e7))
            .map(|point| {
                let ((x, y), layer) = config.locate(*point);
                (x, y, layer)
            })
            .collect();
        cells.sort_unstable();
        cells.dedup();
        let mut candidates: BTreeMap<(i32, i32), Vec<i32>> = BTreeMap::new();
        let mut open = BTreeSet::new();
        for column in cells.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            for (index, &(x, y, layer)) in column.iter().enumerate() {
                let is_free = match column.get(index + 1) {
                    None => open.insert((x, y, layer)),
                    Some(next) if next.2 - layer > config.noise_layers => {
                        next.2 - layer > config.headroom_layers
                    }
                    Some(_) => false,
                };
                if is_free {
                    candidates.entry((x, y)).or_default().push(layer);
                }
            }
        }
        let candidates = Self { config, layers: candidates };
        let level =
            candidates.cells().filter(|cell| candidates.neighbours(*cell).count() >= config.min_neighbours);
        Self::from_cells(level.collect(), config).without_small_pieces_and_roofs(&open)
    }

    fn from_cells(cells: Vec<GroundCell>, config: GroundConfig) -> Self {
        let mut layers: BTreeMap<(i32, i32), Vec<i32>> = BTreeMap::new();
        for (x, y, layer) in cells {
            layers.entry((x, y)).or_default().push(layer);
        }
        Self { config, layers }
    }

    /// Every ground cell, in a fixed order.
    pub fn cells(&self) -> impl Iterator<Item = GroundCell> + '_ {
        self.layers.iter().flat_map(|((x, y), layers)| layers.iter().map(|layer| (*x, *y, *layer)))
    }

    /// Layer of the ground of a column that is nearest to a height, if it is within a step of it.
    pub fn near(&self, x: i32, y: i32, layer: i32) -> Option<i32> {
        let layers = self.layers.get(&(x, y))?;
        let nearest = layers.iter().copied().min_by_key(|other| (other - layer).abs())?;
        ((nearest - layer).abs() <= self.config.step_layers).then_some(nearest)
    }

    /// Ground cells that one can step to from a cell, in the eight neighbouring columns.
    fn neighbours(&self, (x, y, layer): GroundCell) -> impl Iterator<Item = GroundCell> + '_ {
        let neighbours = (-1..=1).flat_map(|i| (-1..=1).map(move |j| (i, j))).filter(|at| *at != (0, 0));
        neighbours.filter_map(move |(i, j)| Some((x + i, y + j, self.near(x + i, y + j, layer)?)))
    }

    /// How many of the 25 columns around a cell have ground at its height.
    pub fn clearance(&self, (x, y, layer): GroundCell) -> usize {
        (-2..=2)
            .flat_map(|i| (-2..=2).map(move |j| (i, j)))
            .filter(|(i, j)| self.near(x + i, y + j, layer).is_some())
            .count()
    }

    /// Number of columns of the largest connected piece of ground.
    pub fn largest_piece(&self) -> usize {
        self.pieces().iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Removes pieces that are too small, and roofs. `open` are cells with nothing above.
    fn without_small_pieces_and_roofs(self, open: &BTreeSet<GroundCell>) -> Self {
        let mut pieces = self.pieces();
        pieces.retain(|piece| piece.len() >= self.config.min_columns);
        let below = |cell: &GroundCell| {
            self.layers
                .get(&(cell.0, cell.1))
                .is_some_and(|layers| layers[0] <= cell.2 - self.config.storey_layers)
        };
        pieces.retain(|piece| {
            let roof = piece.iter().filter(|cell| open.contains(cell) && below(cell)).count();
            (roof as f64) < self.config.roof_share * piece.len() as f64
        });
        let mut cells: Vec<GroundCell> = pieces.into_iter().flatten().collect();
        cells.sort_unstable();
        Self::from_cells(cells, self.config)
    }

    /// Connected pieces.
    fn pieces(&self) -> Vec<Vec<GroundCell>> {
        let mut waiting: BTreeSet<GroundCell> = self.cells().collect();
        let mut pieces = Vec::new();
        while let Some(first) = waiting.pop_first() {
            let (mut piece, mut queue) = (vec![first], VecDeque::from([first]));
            while let Some(cell) = queue.pop_front() {
                for next in self.neighbours(cell).filter(|next| waiting.remove(next)).collect::<Vec<_>>() {
                    piece.push(next);
                    queue.push_back(next);
                }
            }
            pieces.push(piece);
        }
        pieces
    }

    /// Whether there is ground all along the straight line from one cell to another.
    pub fn is_walkable(&self, from: GroundCell, to: GroundCell) -> bool {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let steps = dx.abs().max(dy.abs()).max(1);
        let mut layer = from.2;
        (1..=steps).all(|step| {
            let along = |from: i32, by: i32| from + (f64::from(by * step) / f64::from(steps)).round() as i32;
            let found = self.near(along(from.0, dx), along(from.1, dy), layer);
            layer = found.unwrap_or(layer);
            found.is_some()
        }) && (layer - to.2).abs() <= self.config.step_layers
    }
}
