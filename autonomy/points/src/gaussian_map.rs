//! A hashed map of surfaces: running Gaussians in cubes that are subdivided where the surface is not flat.
//!
//! Root cubes are stored in a hash table. Each one holds the running mean and covariance of its points. A cube whose points lie on a plane
//! represents that plane and is not subdivided. Points off the plane are passed to its eight children. A wall is thus one large, well-averaged
//! plane. Its pipes and its other side are small cells beside it. A person who walks past does not change it. Means are stored relative to the
//! centre of their cube, so that `f32` is exact to a micrometre anywhere on the site.
//!
//! Sources: planes at the coarsest flat level, Yuan et al., *VoxelMap*, RA-L 2022; incremental Gaussians in a hash table, Koide et
//! al., *Voxelized GICP*, ICRA 2021. Parameters and their use: docs/maths/odometry.md, section "Local map".

use crate::hash::{CellKey, CellTable};
use crate::symmetric::{Symmetric3, principal_axes};

/// Parameters of a [`GaussianMap`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianMapConfig {
    /// Edge of a root cube, metres. Source: the method is that of VoxelMap (Yuan and others, 2022); chosen: walls and floors of rooms fill such cubes.
    pub root_size_m: f64,
    /// Number of subdivisions: 3 gives leaves of an eighth of the root's edge. Chosen: 0.25 m; smaller leaves have too few points of a sparse LiDAR.
    pub max_depth: u8,
    /// Number of further subdivisions for points on the other side of a leaf's plane: the two faces of a thin sheet, such as the tread of a stair,
    /// then are two surfaces. Without them, the face that is seen first is the only one. Source: docs/benchmarks/sites.md: 17.4 mm with it and 18.8 mm without it.
    pub other_side_depth: u8,
    /// A cube whose points have a larger standard deviation about their plane is not flat, metres. Chosen: three times the noise of a LiDAR.
    pub plane_thickness_m: f32,
    /// A cube that is already classified as a plane remains one up to this multiple of `plane_thickness_m` (hysteresis). Chosen: half more, so that noise does not change
    /// the class of a cube.
    pub plane_hysteresis: f32,
    /// Least standard deviation along the middle principal axis of a plane, as a share of the cube's edge. Points of a single
    /// LiDAR ring lie on a line, whose normal is noise. Chosen: 16 cm of a root cube, which is wider than a ring.
    pub min_plane_width_share: f32,
    /// Least ratio of the standard deviations along the middle axis and along the normal of a plane. Chosen: flatter than a beam or a cable.
    pub min_plane_aspect: f32,
    /// Least standard deviation along the middle principal axis of a distribution, as a share of the cube's edge. Chosen: half of [`Self::min_plane_width_share`],
    /// because no normal is taken from it.
    pub min_distribution_width_share: f32,
    /// Points farther from a plane than this many of its standard deviations do not belong to it. Chosen: one right point in thousands is farther off.
    pub outlier_deviations: f32,
    /// Points nearer to a plane than this always belong to it, metres. Chosen: as [`Self::plane_thickness_m`].
    pub min_outlier_distance_m: f32,
    /// Points that a cube needs before it is classified. Chosen: a plane has three; of fewer, its covariance is noise.
    pub min_points: u16,
    /// Cap on the number of points in a running mean, so that the mean can still follow changes. Chosen as a round number: with more, moved things stay for longer; with
    /// less, means are noisier.
    pub max_points: u16,
    /// A cube is classified again when its number of points has grown by 1 / this value (at least 1). Chosen: a class seldom changes by less; it bounds the time of an
    /// insertion.
    pub reclassify_growth_divisor: u16,
    /// A cube is classified again after at least this many new points. Chosen for the same reason.
    pub min_reclassify_growth: u16,
    /// A plane at the cap of its points is classified again when the number of points inserted into the whole map is a multiple of
    /// this (at least 1). Chosen for the same reason.
    pub full_plane_reclassify_interval: u32,
    /// Offset of the grid from the map's origin, metres. Floors and walls often lie at round coordinates. The offset keeps them away
    /// from the borders of cubes, where a surface is split between two cubes. Chosen: no multiple of 5 cm.
    pub grid_offset_m: [f64; 3],
}

impl GaussianMapConfig {
    /// For the thinned clouds of keyframes, which have fewer points in a cube than scans have.
    pub fn for_thinned_clouds() -> Self {
        Self { min_points: 6, ..Self::default() }
    }

    /// Edge of the finest cube of a surface that is seen from one side, metres.
    pub fn leaf_size_m(&self) -> f64 {
        self.root_size_m / f64::from(1_u32 << self.max_depth)
    }

    /// Integer coordinates of the root cube that holds a point (map frame, metres).
    #[inline]
    pub fn root_cell(&self, point: &[f64; 3]) -> [i64; 3] {
        let per_metre = 1.0 / self.root_size_m;
        std::array::from_fn(|axis| floor((point[axis] + self.grid_offset_m[axis]) * per_metre))
    }
}

impl Default for GaussianMapConfig {
    fn default() -> Self {
        Self {
            root_size_m: 2.0,
            max_depth: 3,
            other_side_depth: 1,
            plane_thickness_m: 0.03,
            plane_hysteresis: 1.5,
            min_plane_width_share: 0.08,
            min_plane_aspect: 3.0,
            min_distribution_width_share: 0.04,
            outlier_deviations: 4.0,
            min_outlier_distance_m: 0.03,
            min_points: 8,
            max_points: 1_000,
            reclassify_growth_divisor: 4,
            min_reclassify_growth: 2,
            full_plane_reclassify_interval: 32,
            grid_offset_m: [0.317, 0.643, 0.451],
        }
    }
}

/// The surface that the map holds near a query point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// A plane.
    Plane {
        /// Unit normal, map frame. It points towards the viewpoints of the points; its sign is arbitrary for points that were
        /// inserted without a viewpoint.
        normal: [f32; 3],
        /// Distance of the query point from the plane along the normal, metres.
        distance: f32,
        /// Variance of the map's points about the plane, square metres.
        variance: f32,
    },
    /// A cell whose points fill a volume or lie on an edge.
    Distribution {
        /// Query point minus the cell's mean, metres.
        offset: [f32; 3],
        /// Covariance of the map's points in the cell, square metres.
        covariance: Symmetric3,
    },
}

/// Classification of a cube by the distribution of its points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Too few points, or points on a line.
    Unknown,
    /// The points lie on a plane.
    Plane,
    /// The points fill a volume or lie on an edge.
    Distribution,
}

/// One cube of the tree. It fills one cache line.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Mean of the points relative to the cube's centre, metres.
    mean: [f32; 3],
    covariance: Symmetric3,
    normal: [f32; 3],
    /// Variance along the normal, square metres.
    normal_variance: f32,
    /// Index of the octet of children plus one; 0 for a leaf.
    children: u32,
    count: u16,
    /// Count at which the cube is classified again.
    classify_at_count: u16,
    kind: Kind,
}

impl Node {
    const EMPTY: Self = Self {
        mean: [0.0; 3],
        covariance: [0.0; 6],
        normal: [0.0; 3],
        normal_variance: 0.0,
        children: 0,
        count: 0,
        classify_at_count: 0,
        kind: Kind::Unknown,
    };

    /// Signed distance of a point (relative to the cube's centre) from the cube's plane, metres.
    #[inline]
    fn distance(&self, local: &[f32; 3]) -> f32 {
        (0..3).map(|axis| self.normal[axis] * (local[axis] - self.mean[axis])).sum()
    }

    /// Whether the plane's normal points away from the viewer, who lies in the direction `to_viewer`.
    #[inline]
    fn faces_away(&self, to_viewer: Option<[f32; 3]>) -> bool {
        to_viewer.is_some_and(|to_viewer| {
            (0..3).map(|axis| self.normal[axis] * to_viewer[axis]).sum::<f32>() < 0.0
        })
    }

    /// Welford's update of mean and covariance, with the count capped.
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

    /// Classifies the cube by its present covariance. `size_m` is the cube's edge.
    fn classify(&mut self, size_m: f32, config: &GaussianMapConfig) {
        let growth = (self.count / config.reclassify_growth_divisor).max(config.min_reclassify_growth);
        let next = self.count + growth;
        self.classify_at_count = if next >= config.max_points { config.max_points } else { next };
        let Some(axes) = principal_axes(&self.covariance) else {
            self.kind = Kind::Unknown;
            return;
        };
        self.normal = axes.normal;
        self.normal_variance = axes.variances[0];
        let thickness_m =
            config.plane_thickness_m * if self.kind == Kind::Plane { config.plane_hysteresis } else { 1.0 };
        let middle_variance = axes.variances[1];
        let is_wide = middle_variance > (config.min_plane_width_share * size_m).powi(2)
            && middle_variance > config.min_plane_aspect * config.min_plane_aspect * self.normal_variance;
        self.kind = if is_wide && self.normal_variance < thickness_m * thickness_m {
            Kind::Plane
        } else if middle_variance > (config.min_distribution_width_share * size_m).powi(2) {
            Kind::Distribution
        } else {
            Kind::Unknown
        };
    }

    /// Whether a point at a distance from an established plane does not belong to it.
    #[inline]
    fn is_outlier(&self, distance: f32, config: &GaussianMapConfig) -> bool {
        let deviations_squared = config.outlier_deviations * config.outlier_deviations;
        let min_squared = config.min_outlier_distance_m * config.min_outlier_distance_m;
        distance.powi(2) > (deviations_squared * self.normal_variance).max(min_squared)
    }
}

/// A root cube and its cell in the grid.
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
    /// Indices of octets that are free again after their cube was removed.
    free: Vec<u32>,
    /// Number of points inserted so far, modulo 2³².
    insertions: u32,
}

impl GaussianMap {
    /// An empty map.
    pub fn new(config: GaussianMapConfig) -> Self {
        Self {
            config,
            table: CellTable::default(),
            roots: Vec::new(),
            octets: Vec::new(),
            free: Vec::new(),
            insertions: 0,
        }
    }

    /// Removes all cubes.
    pub fn clear(&mut self) {
        self.table.clear();
        self.roots.clear();
        self.octets.clear();
        self.free.clear();
    }

    /// The parameters of the map.
    pub fn config(&self) -> &GaussianMapConfig {
        &self.config
    }

    /// Sets [`GaussianMapConfig::plane_thickness_m`], metres. It holds for cubes that are classified from now on.
    pub fn set_plane_thickness(&mut self, thickness_m: f32) {
        self.config.plane_thickness_m = thickness_m;
    }

    /// Number of root cubes held.
    pub fn len(&self) -> usize {
        self.roots.len()
    }

    /// Whether nothing was inserted yet.
    pub fn is_empty(&self) -> bool {
        self.roots.is_empty()
    }

    /// Bytes of heap memory held by the cubes.
    pub fn bytes(&self) -> usize {
        self.roots.capacity() * size_of::<Root>() + self.octets.capacity() * size_of::<[Node; 8]>()
    }

    /// Adds a point.
    pub fn insert(&mut self, point: &[f64; 3]) {
        self.insert_facing(point, None);
    }

    /// Adds a point that was observed from a viewpoint (map frame, metres). The two sides of a thin wall become two surfaces, of
    /// which [`Self::find_surface_facing`] finds the one that faces the viewer.
    pub fn insert_from_viewpoint(&mut self, point: &[f64; 3], viewpoint: &[f64; 3]) {
        self.insert_facing(point, Some(direction_to(point, viewpoint)));
    }

    fn insert_facing(&mut self, point: &[f64; 3], to_viewer: Option<[f32; 3]>) {
        let (key, mut local) = self.locate(point);
        let (root, is_new) = self.table.get_or_insert(key, self.roots.len() as u32);
        if is_new {
            self.roots.push(Root { key, node: Node::EMPTY });
        }
        self.insertions = self.insertions.wrapping_add(1);
        let (insertions, config) = (self.insertions, self.config);
        let mut node_ref = NodeRef::Root(root);
        let mut size_m = config.root_size_m as f32;
        let deepest = config.max_depth + config.other_side_depth;
        for level in 0..=deepest {
            let node = self.node_mut(node_ref);
            // A point in front of an established plane, behind it, or on its other side goes to a child.
            let is_elsewhere = node.kind == Kind::Plane
                && (node.is_outlier(node.distance(&local), &config) || node.faces_away(to_viewer));
            if !is_elsewhere {
                node.add(&local, &config);
                let is_due = if node.count >= config.max_points {
                    node.kind != Kind::Plane || insertions % config.full_plane_reclassify_interval == 0
                } else {
                    node.count >= node.classify_at_count
                };
                if node.count >= config.min_points && is_due {
                    node.classify(size_m, &config);
                    if node.faces_away(to_viewer) {
                        node.normal = node.normal.map(|axis| -axis);
                    }
                }
                if node.kind == Kind::Plane {
                    return;
                }
            }
            let is_other_side = node.kind == Kind::Plane && node.faces_away(to_viewer);
            if level == deepest || (level >= config.max_depth && !is_other_side) {
                return;
            }
            node_ref = self.child_or_new(node_ref, descend_to_child(&mut local, &mut size_m));
        }
    }

    /// The surface at a point: the first plane from the root down to which the point belongs, as [`Self::insert`] decides it, and that is `gate_m`
    /// metres or less away. Else the nearest plane on the way down, else the finest classified cell.
    ///
    /// A point that does not belong to a plane lies on another surface in front of it, such as the foot of a wall above its floor. All such points
    /// are on one side of the plane. Matched with it, they would pull the scan away from it.
    pub fn find_surface(&self, point: &[f64; 3], gate_m: f32) -> Option<Surface> {
        self.find_surface_of(point, gate_m, None)
    }

    /// As [`Self::find_surface`], without the planes that face away from a viewpoint (map frame, metres). For maps whose points were
    /// inserted with [`Self::insert_from_viewpoint`].
    pub fn find_surface_facing(
        &self,
        point: &[f64; 3],
        viewpoint: &[f64; 3],
        gate_m: f32,
    ) -> Option<Surface> {
        self.find_surface_of(point, gate_m, Some(direction_to(point, viewpoint)))
    }

    fn find_surface_of(&self, point: &[f64; 3], gate_m: f32, to_viewer: Option<[f32; 3]>) -> Option<Surface> {
        let (key, local) = self.locate(point);
        let mut best = BestSurface::default();
        if let Some(root) = self.table.get(key) {
            self.search_root(root, local, gate_m, to_viewer, &mut best);
            if best.is_settled {
                return best.surface;
            }
        }
        // A surface near the border may be stored in the neighbouring root cube.
        let half = self.config.root_size_m as f32 / 2.0;
        for axis in 0..3 {
            if half - local[axis].abs() > gate_m {
                continue;
            }
            let side = if local[axis] > 0.0 { 1 } else { -1 };
            let mut cell = key.cell();
            cell[axis] += side;
            if let Some(root) = self.table.get(CellKey::new(cell)) {
                let mut neighbour_local = local;
                neighbour_local[axis] -= side as f32 * self.config.root_size_m as f32;
                self.search_root(root, neighbour_local, gate_m, to_viewer, &mut best);
                if best.is_settled {
                    break;
                }
            }
        }
        best.surface
    }

    /// Removes every root cube whose centre is farther than `radius_m` from `centre` along any axis (metres).
    pub fn retain_within(&mut self, centre: &[f64; 3], radius_m: f64) {
        let mut index = 0;
        while index < self.roots.len() {
            let key = self.roots[index].key;
            let cube = self.centre(key);
            let is_far = (0..3).any(|axis| (cube[axis] - centre[axis]).abs() > radius_m);
            if !is_far {
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

    /// Every plane and every leaf distribution: mean position and unit normal (zero for distributions), map frame.
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

    /// Walks from a root cube down to the leaf that holds `local` (relative to the root's centre) and collects the best surface.
    fn search_root(
        &self,
        root: u32,
        mut local: [f32; 3],
        gate_m: f32,
        to_viewer: Option<[f32; 3]>,
        best: &mut BestSurface,
    ) {
        let mut node = &self.roots[root as usize].node;
        let mut size_m = self.config.root_size_m as f32;
        loop {
            match node.kind {
                Kind::Plane if node.faces_away(to_viewer) => {}
                Kind::Plane => {
                    best.consider_plane(node, node.distance(&local), gate_m, &self.config);
                    if best.is_settled {
                        return;
                    }
                }
                Kind::Distribution => best.consider_distribution(node, &local),
                Kind::Unknown => {}
            }
            let Some(octet) = node.children.checked_sub(1) else { return };
            node = &self.octets[octet as usize][descend_to_child(&mut local, &mut size_m)];
        }
    }

    /// Root cube of a point, and the point relative to the centre of that cube.
    #[inline]
    fn locate(&self, point: &[f64; 3]) -> (CellKey, [f32; 3]) {
        let cell = self.config.root_cell(point);
        let local = std::array::from_fn(|axis| {
            let middle = (cell[axis] as f64 + 0.5) * self.config.root_size_m;
            (point[axis] + self.config.grid_offset_m[axis] - middle) as f32
        });
        (CellKey::new(cell), local)
    }

    /// Centre of a root cube, map frame, metres.
    fn centre(&self, key: CellKey) -> [f64; 3] {
        let cell = key.cell();
        std::array::from_fn(|axis| {
            (cell[axis] as f64 + 0.5) * self.config.root_size_m - self.config.grid_offset_m[axis]
        })
    }

    #[inline]
    fn node_mut(&mut self, node_ref: NodeRef) -> &mut Node {
        match node_ref {
            NodeRef::Root(root) => &mut self.roots[root as usize].node,
            NodeRef::Child(octet, child) => &mut self.octets[octet as usize][child],
        }
    }

    /// A child of a cube; makes its octet if it has none.
    fn child_or_new(&mut self, parent: NodeRef, child: usize) -> NodeRef {
        if let Some(octet) = self.node_mut(parent).children.checked_sub(1) {
            return NodeRef::Child(octet, child);
        }
        let octet = self.free.pop().unwrap_or(self.octets.len() as u32);
        if octet as usize == self.octets.len() {
            self.octets.push([Node::EMPTY; 8]);
        }
        self.node_mut(parent).children = octet + 1;
        NodeRef::Child(octet, child)
    }

    /// Frees an octet and everything below it.
    fn free_octet(&mut self, children: u32) {
        let Some(octet) = children.checked_sub(1) else { return };
        let nodes = std::mem::replace(&mut self.octets[octet as usize], [Node::EMPTY; 8]);
        self.free.push(octet);
        for node in nodes {
            self.free_octet(node.children);
        }
    }
}

/// Where a cube is stored.
#[derive(Clone, Copy)]
enum NodeRef {
    /// Index of the root.
    Root(u32),
    /// Octet and index within it.
    Child(u32, usize),
}

/// The best surface that a query has met so far.
#[derive(Default)]
struct BestSurface {
    surface: Option<Surface>,
    /// Whether it is a plane within the gate to which the point belongs, so that no finer cell holds the point's surface.
    is_settled: bool,
}

impl BestSurface {
    fn consider_plane(&mut self, node: &Node, distance: f32, gate_m: f32, config: &GaussianMapConfig) {
        let is_nearer = match self.surface {
            Some(Surface::Plane { distance: held, .. }) => distance.abs() < held.abs(),
            Some(Surface::Distribution { .. }) | None => true,
        };
        if is_nearer {
            let variance = node.normal_variance;
            self.surface = Some(Surface::Plane { normal: node.normal, distance, variance });
        }
        self.is_settled = distance.abs() <= gate_m && !node.is_outlier(distance, config);
    }

    /// Finer cells come later and replace coarser ones. A plane is never replaced by a distribution.
    fn consider_distribution(&mut self, node: &Node, local: &[f32; 3]) {
        if !matches!(self.surface, Some(Surface::Plane { .. })) {
            let offset = std::array::from_fn(|axis| local[axis] - node.mean[axis]);
            self.surface = Some(Surface::Distribution { offset, covariance: node.covariance });
        }
    }
}

/// Vector from a point to a viewpoint, metres.
#[inline]
fn direction_to(point: &[f64; 3], viewpoint: &[f64; 3]) -> [f32; 3] {
    std::array::from_fn(|axis| (viewpoint[axis] - point[axis]) as f32)
}

/// Moves from a cube to the child that holds `local`: makes `local` relative to the child's centre, halves `size_m`, and returns
/// the index of the child.
#[inline]
fn descend_to_child(local: &mut [f32; 3], size_m: &mut f32) -> usize {
    let quarter = *size_m / 4.0;
    let mut child = 0;
    for axis in 0..3 {
        let is_upper = local[axis] > 0.0;
        child |= usize::from(is_upper) << axis;
        local[axis] += if is_upper { -quarter } else { quarter };
    }
    *size_m /= 2.0;
    child
}

/// Largest integer not above `value`, without the library call of `f64::floor`.
#[inline]
fn floor(value: f64) -> i64 {
    let truncated = value as i64;
    truncated - i64::from((truncated as f64) > value)
}

#[cfg(test)]
#[path = "gaussian_map_tests.rs"]
mod tests;
