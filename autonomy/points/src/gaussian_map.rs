//! A hashed map of surfaces: running Gaussians in cubes that halve where the surface is not flat.
//!
//! Root cubes live in a hash table. Each holds the running mean and covariance of its points; where these lie on a
//! plane the cube *is* that plane and grows no further, and only points off the plane go down to its eight halves.
//! So a wall is one large, well-averaged plane, its pipes and the other side of it are small cells beside it, and
//! a person who walks past leaves the wall as it was. Means are kept relative to the centre of their cube, so that
//! `f32` is exact to a micrometre anywhere on the site.
//!
//! The idea of planes at the coarsest flat level is from Yuan et al., *VoxelMap*, RA-L 2022; incremental Gaussians in a
//! hash table from Koide et al., *Voxelized GICP*, ICRA 2021.

use crate::hash::{CellKey, CellTable};
use crate::symmetric::{Symmetric3, principal_axes};

/// How a map divides space and what it calls flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianMapConfig {
    /// Edge of a root cube, metres.
    pub root_size_m: f64,
    /// How often a cube may be halved: 3 means leaves of an eighth of the root.
    pub max_depth: u8,
    /// Standard deviation of points about a plane above which a cube is not flat, metres.
    pub plane_thickness_m: f32,
    /// Points that a cube needs before its shape is judged.
    pub min_points: u16,
    /// Weight of the past: a running mean never counts more points than this, so that it can still follow.
    pub max_points: u16,
}

impl GaussianMapConfig {
    /// The root cube that holds a point (map frame, metres), counted along each axis.
    #[inline]
    pub fn root_cell(&self, point: &[f64; 3]) -> [i64; 3] {
        let per_metre = 1.0 / self.root_size_m;
        std::array::from_fn(|axis| floor((point[axis] + GRID_SHIFT[axis]) * per_metre))
    }
}

impl Default for GaussianMapConfig {
    fn default() -> Self {
        Self { root_size_m: 2.0, max_depth: 3, plane_thickness_m: 0.03, min_points: 8, max_points: 1_000 }
    }
}

/// What the map knows near a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// A flat piece.
    Plane {
        /// Unit normal, map frame; towards those who saw it, or of arbitrary sign where nobody said.
        normal: [f32; 3],
        /// Distance of the query point from the plane along the normal, metres.
        distance: f32,
        /// Variance of the map's points about the plane, square metres.
        variance: f32,
    },
    /// A cell whose points fill space, lie on an edge, or are few.
    Distribution {
        /// Query point minus the cell's mean, metres.
        offset: [f32; 3],
        /// Covariance of the map's points in the cell, square metres.
        covariance: Symmetric3,
    },
}

/// What a cube's points look like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Too few points, or points on a line.
    Unknown,
    Plane,
    Distribution,
}

/// One cube; fills one cache line.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Of the points, relative to the cube's centre.
    mean: [f32; 3],
    covariance: Symmetric3,
    normal: [f32; 3],
    /// Variance along the normal.
    thickness: f32,
    /// Octet of the halves plus one; 0 while there are none.
    children: u32,
    count: u16,
    /// Count at which the shape is judged again.
    classify_at_count: u16,
    kind: Kind,
}

impl Node {
    const EMPTY: Self = Self {
        mean: [0.0; 3],
        covariance: [0.0; 6],
        normal: [0.0; 3],
        thickness: 0.0,
        children: 0,
        count: 0,
        classify_at_count: 0,
        kind: Kind::Unknown,
    };

    #[inline]
    fn distance(&self, local: &[f32; 3]) -> f32 {
        (0..3).map(|axis| self.normal[axis] * (local[axis] - self.mean[axis])).sum()
    }

    /// Whether the plane shows its other side in a direction.
    #[inline]
    fn faces_away(&self, facing: Option<[f32; 3]>) -> bool {
        facing.is_some_and(|facing| (0..3).map(|axis| self.normal[axis] * facing[axis]).sum::<f32>() < 0.0)
    }

    /// Welford's update, with the count capped.
    #[inline]
    fn add(&mut self, local: &[f32; 3], config: &GaussianMapConfig) {
        self.count = (self.count + 1).min(config.max_points);
        let weight = 1.0 / f32::from(self.count);
        let delta: [f32; 3] = std::array::from_fn(|axis| local[axis] - self.mean[axis]);
        for axis in 0..3 {
            self.mean[axis] += delta[axis] * weight;
        }
        let keep = 1.0 - weight;
        let gain = keep * weight;
        let mut index = 0;
        for row in 0..3 {
            for column in row..3 {
                self.covariance[index] = keep * self.covariance[index] + gain * delta[row] * delta[column];
                index += 1;
            }
        }
    }

    /// Decides the kind anew. `size` is the cube's edge.
    fn classify(&mut self, size: f32, config: &GaussianMapConfig) {
        let grown = self.count + (self.count / 4).max(2);
        self.classify_at_count = if grown >= config.max_points { config.max_points } else { grown };
        let Some(principal_axes) = principal_axes(&self.covariance) else {
            self.kind = Kind::Unknown;
            return;
        };
        self.normal = principal_axes.normal;
        self.thickness = principal_axes.variances[0];
        // A plane already held is given up only when clearly thicker, so that cells do not flicker.
        let limit = config.plane_thickness_m * if self.kind == Kind::Plane { 1.5 } else { 1.0 };
        // Points of a single ring lie on a line, whose normal is whatever noise says.
        let wide = principal_axes.variances[1] > (0.08 * size).powi(2)
            && principal_axes.variances[1] > 9.0 * self.thickness;
        self.kind = if wide && self.thickness < limit * limit {
            Kind::Plane
        } else if principal_axes.variances[1] > (0.04 * size).powi(2) {
            Kind::Distribution
        } else {
            Kind::Unknown
        };
    }
}

#[derive(Clone, Copy, Debug)]
struct Root {
    key: CellKey,
    node: Node,
}

/// A hashed map of running Gaussians. All positions are in the map's frame, metres.
#[derive(Clone, Debug)]
pub struct GaussianMap {
    config: GaussianMapConfig,
    table: CellTable,
    roots: Vec<Root>,
    octets: Vec<[Node; 8]>,
    /// Octets that removed cubes gave back.
    free: Vec<u32>,
    /// Inserted points since the last one at full count was judged, for a cheap regular second look.
    turn: u32,
}

/// Grid origin: off any round number, because floors and walls like those and a surface on the border of
/// two cubes is split between them.
const GRID_SHIFT: [f64; 3] = [0.317, 0.643, 0.451];

impl GaussianMap {
    /// An empty map.
    pub fn new(config: GaussianMapConfig) -> Self {
        Self {
            config,
            table: CellTable::default(),
            roots: Vec::new(),
            octets: Vec::new(),
            free: Vec::new(),
            turn: 0,
        }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.table.clear();
        self.roots.clear();
        self.octets.clear();
        self.free.clear();
    }

    /// The settings it was made with.
    pub fn config(&self) -> &GaussianMapConfig {
        &self.config
    }

    /// Number of root cubes held.
    pub fn len(&self) -> usize {
        self.roots.len()
    }

    /// Whether nothing was inserted yet.
    pub fn is_empty(&self) -> bool {
        self.roots.is_empty()
    }

    /// Bytes held, without the allocator's own.
    pub fn bytes(&self) -> usize {
        self.roots.capacity() * size_of::<Root>() + self.octets.capacity() * size_of::<[Node; 8]>()
    }

    /// Adds a point.
    pub fn insert(&mut self, point: &[f64; 3]) {
        self.insert_facing(point, None);
    }

    /// Adds a point that was seen from a place (map frame, metres): both sides of a thin wall become surfaces of their own, of which
    /// [`Self::find_surface_facing`] finds the right one.
    pub fn insert_from_viewpoint(&mut self, point: &[f64; 3], from: &[f64; 3]) {
        self.insert_facing(point, Some(viewing_direction(point, from)));
    }

    fn insert_facing(&mut self, point: &[f64; 3], facing: Option<[f32; 3]>) {
        let (key, mut local) = self.locate(point);
        let (root, fresh) = self.table.get_or_insert(key, self.roots.len() as u32);
        if fresh {
            self.roots.push(Root { key, node: Node::EMPTY });
        }
        self.turn = self.turn.wrapping_add(1);
        let mut place = NodeRef::Root(root);
        let mut size = self.config.root_size_m as f32;
        for level in 0..=self.config.max_depth {
            let (turn, config) = (self.turn, self.config);
            let node = self.node_mut(place);
            if node.kind == Kind::Plane && (is_outlier(node, &local) || node.faces_away(facing)) {
                // Something else in front of or behind a known plane, or its other side.
            } else {
                node.add(&local, &config);
                let due = if node.count >= config.max_points {
                    node.kind != Kind::Plane || turn % 32 == 0
                } else {
                    node.count >= node.classify_at_count
                };
                if node.count >= config.min_points && due {
                    node.classify(size, &config);
                    if node.faces_away(facing) {
                        node.normal = node.normal.map(|axis| -axis);
                    }
                }
                if node.kind == Kind::Plane {
                    return;
                }
            }
            if level == self.config.max_depth {
                return;
            }
            place = self.child_or_new(place, descend_to_child(&mut local, &mut size));
        }
    }

    /// What the map knows at a point: the first plane on the way down that the point is `gate` metres or less away
    /// from, else the nearest plane met, else the finest cell with enough points.
    pub fn find_surface(&self, point: &[f64; 3], gate: f32) -> Option<Surface> {
        self.surface_of(point, gate, None)
    }

    /// As [`Self::surface`], but for planes that turn their other side to whoever looks from there (map frame, metres). Of maps whose
    /// points were added with [`Self::insert_from_viewpoint`].
    pub fn find_surface_facing(&self, point: &[f64; 3], from: &[f64; 3], gate: f32) -> Option<Surface> {
        self.surface_of(point, gate, Some(viewing_direction(point, from)))
    }

    fn surface_of(&self, point: &[f64; 3], gate: f32, facing: Option<[f32; 3]>) -> Option<Surface> {
        let (key, local) = self.locate(point);
        let mut best = BestSurface::default();
        if let Some(root) = self.table.get(key) {
            self.search_root(root, local, gate, facing, &mut best);
            if best.within {
                return best.surface;
            }
        }
        // A surface near the border may have been filed next door.
        let half = self.config.root_size_m as f32 / 2.0;
        for axis in 0..3 {
            if half - local[axis].abs() > gate {
                continue;
            }
            let side = if local[axis] > 0.0 { 1 } else { -1 };
            let mut cell = key.cell();
            cell[axis] += side;
            if let Some(root) = self.table.get(CellKey::new(cell)) {
                let mut there = local;
                there[axis] -= side as f32 * self.config.root_size_m as f32;
                self.search_root(root, there, gate, facing, &mut best);
                if best.within {
                    break;
                }
            }
        }
        best.surface
    }

    /// Forgets every root cube whose centre is farther than `radius` from `centre`, horizontally or vertically.
    pub fn retain_within(&mut self, centre: &[f64; 3], radius: f64) {
        let mut index = 0;
        while index < self.roots.len() {
            let key = self.roots[index].key;
            let cube = self.centre(key);
            let far = (0..3).any(|axis| (cube[axis] - centre[axis]).abs() > radius);
            if !far {
                index += 1;
                continue;
            }
            self.free_octet(self.roots[index].node.children);
            self.table.remove(key);
            self.roots.swap_remove(index);
            if let Some(moved) = self.roots.get(index) {
                self.table.remove(moved.key);
                self.table.get_or_insert(moved.key, index as u32);
            }
        }
    }

    /// Every plane and filled cell: mean position and unit normal (zero for filled cells), map frame.
    pub fn surfels(&self) -> Vec<([f64; 3], [f32; 3])> {
        let mut out = Vec::new();
        for root in &self.roots {
            self.collect(&root.node, self.centre(root.key), self.config.root_size_m, &mut out);
        }
        out
    }

    fn collect(&self, node: &Node, centre: [f64; 3], size: f64, out: &mut Vec<([f64; 3], [f32; 3])>) {
        let mean = || std::array::from_fn(|axis| centre[axis] + f64::from(node.mean[axis]));
        match node.kind {
            Kind::Plane => out.push((mean(), node.normal)),
            Kind::Distribution if node.children == 0 => out.push((mean(), [0.0; 3])),
            Kind::Distribution | Kind::Unknown => {}
        }
        if let Some(octet) = node.children.checked_sub(1) {
            for (index, child) in self.octets[octet as usize].iter().enumerate() {
                let step = |axis: usize| if index >> axis & 1 == 1 { size / 4.0 } else { -size / 4.0 };
                self.collect(child, std::array::from_fn(|axis| centre[axis] + step(axis)), size / 2.0, out);
            }
        }
    }

    fn search_root(
        &self,
        root: u32,
        mut local: [f32; 3],
        gate: f32,
        facing: Option<[f32; 3]>,
        best: &mut BestSurface,
    ) {
        let mut node = &self.roots[root as usize].node;
        let mut size = self.config.root_size_m as f32;
        loop {
            match node.kind {
                Kind::Plane if node.faces_away(facing) => {}
                Kind::Plane => {
                    let distance = node.distance(&local);
                    best.consider_plane(node, distance, gate);
                    if best.within {
                        return;
                    }
                }
                Kind::Distribution => best.consider_distribution(node, &local),
                Kind::Unknown => {}
            }
            let Some(octet) = node.children.checked_sub(1) else { return };
            node = &self.octets[octet as usize][descend_to_child(&mut local, &mut size)];
        }
    }

    /// Root cube of a point, and the point relative to its centre.
    #[inline]
    fn locate(&self, point: &[f64; 3]) -> (CellKey, [f32; 3]) {
        let cell = self.config.root_cell(point);
        let local = std::array::from_fn(|axis| {
            let middle = (cell[axis] as f64 + 0.5) * self.config.root_size_m;
            (point[axis] + GRID_SHIFT[axis] - middle) as f32
        });
        (CellKey::new(cell), local)
    }

    fn centre(&self, key: CellKey) -> [f64; 3] {
        let cell = key.cell();
        std::array::from_fn(|axis| (cell[axis] as f64 + 0.5) * self.config.root_size_m - GRID_SHIFT[axis])
    }

    #[inline]
    fn node_mut(&mut self, place: NodeRef) -> &mut Node {
        match place {
            NodeRef::Root(root) => &mut self.roots[root as usize].node,
            NodeRef::Half(octet, child) => &mut self.octets[octet as usize][child],
        }
    }

    fn child_or_new(&mut self, parent: NodeRef, child: usize) -> NodeRef {
        if let Some(octet) = self.node_mut(parent).children.checked_sub(1) {
            return NodeRef::Half(octet, child);
        }
        let octet = self.free.pop().unwrap_or(self.octets.len() as u32);
        if octet as usize == self.octets.len() {
            self.octets.push([Node::EMPTY; 8]);
        }
        self.node_mut(parent).children = octet + 1;
        NodeRef::Half(octet, child)
    }

    /// Gives an octet and all below it back.
    fn free_octet(&mut self, children: u32) {
        let Some(octet) = children.checked_sub(1) else { return };
        let nodes = std::mem::replace(&mut self.octets[octet as usize], [Node::EMPTY; 8]);
        self.free.push(octet);
        for node in nodes {
            self.free_octet(node.children);
        }
    }
}

/// Where a node is stored.
#[derive(Clone, Copy)]
enum NodeRef {
    Root(u32),
    Half(u32, usize),
}

/// The best answer to a query so far.
#[derive(Default)]
struct BestSurface {
    surface: Option<Surface>,
    /// Whether it is a plane inside the gate.
    within: bool,
}

impl BestSurface {
    fn consider_plane(&mut self, node: &Node, distance: f32, gate: f32) {
        let nearer = match self.surface {
            Some(Surface::Plane { distance: held, .. }) => distance.abs() < held.abs(),
            Some(Surface::Distribution { .. }) | None => true,
        };
        if nearer {
            self.surface = Some(Surface::Plane { normal: node.normal, distance, variance: node.thickness });
            self.within = distance.abs() <= gate;
        }
    }

    /// Finer cells come later and replace coarser ones; planes stay.
    fn consider_distribution(&mut self, node: &Node, local: &[f32; 3]) {
        if !matches!(self.surface, Some(Surface::Plane { .. })) {
            let offset = std::array::from_fn(|axis| local[axis] - node.mean[axis]);
            self.surface = Some(Surface::Distribution { offset, covariance: node.covariance });
        }
    }
}

/// From a point to where it was seen from.
#[inline]
fn viewing_direction(point: &[f64; 3], from: &[f64; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| (from[axis] - point[axis]) as f32)
}

/// Moves from a cube to the half that holds `local`; says which of the eight.
#[inline]
fn descend_to_child(local: &mut [f32; 3], size: &mut f32) -> usize {
    let quarter = *size / 4.0;
    let mut child = 0;
    for axis in 0..3 {
        let upper = local[axis] > 0.0;
        child |= usize::from(upper) << axis;
        local[axis] += if upper { -quarter } else { quarter };
    }
    *size /= 2.0;
    child
}

/// Whether a point does not belong to an established plane: four standard deviations, at least 3 cm.
#[inline]
fn is_outlier(node: &Node, local: &[f32; 3]) -> bool {
    node.distance(local).powi(2) > (16.0 * node.thickness).max(9e-4)
}

#[inline]
fn floor(value: f64) -> i64 {
    let truncated = value as i64;
    truncated - i64::from((truncated as f64) > value)
}

#[cfg(test)]
#[path = "gaussian_map_tests.rs"]
mod tests;
