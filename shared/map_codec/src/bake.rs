//! Bakes a finished map into one additive octree.
//!
//! Every node is a cube with a grid of 128 cells a side and at most one point in each. A point belongs to the coarsest node whose
//! cell around it is free. It is dropped if an earlier point is in its cell of the finest level. The points of nodes with few points are then
//! moved into their parents, which saves the browser hundreds of small requests at the edge of the map.

use crate::cells::CellSet;
use crate::chunk::{GpuPoint, PointChunk};
use crate::encode::{MAX_COORDINATE_M, encode, intensity_unit};
use crate::octree::NodeId;
use std::collections::BTreeMap;
use vocab::Aabb;

/// Cells along each edge of a node.
const NODE_CELLS: u32 = 128;
/// Largest number of lattice steps in a cell: a node's lattice then has 65,536 along each edge.
const MAX_CELL_STEPS: f32 = 512.0;
/// Deepest level: the 128 cells of the root, halved 13 times, are 2^20 cells along the map's edge.
const MAX_LEVEL: u8 = 13;

/// Parameters of [`bake`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeConfig {
    /// Distance between points on the finest level, metres; closer points are dropped. It is increased for a
    /// map that is too large for 14 levels. Chosen: three times the noise of a LiDAR; closer points are of the same place.
    pub finest_spacing_m: f32,
    /// Greatest step of a node's lattice, metres. A node's step is its cell, halved until it is not larger than
    /// this, at most nine times. Points of coarse nodes are also drawn close up, so they need the same resolution. Its default is that of all points of the map
    /// ([`crate::POINT_RESOLUTION_M`]).
    pub resolution_m: f32,
    /// The points of nodes with fewer points are moved into their parents. Chosen: a tile of fewer costs more for its request than for its points.
    pub min_node_points: usize,
}

impl Default for BakeConfig {
    fn default() -> Self {
        Self { finest_spacing_m: 0.03, resolution_m: crate::POINT_RESOLUTION_M, min_node_points: 1000 }
    }
}

/// One encoded node of the octree.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedTile {
    /// The node. All its ancestors are tiles of the same map.
    pub node: NodeId,
    /// The smallest box around its points, metres, map frame.
    pub bounds: Aabb,
    /// Distance between points when this node and its ancestors are drawn, metres.
    pub spacing: f32,
    /// Number of points.
    pub points: u32,
    /// The encoded points, for [`crate::decode`]. Positions are in the map frame; the error of each coordinate is at most half of
    /// [`BakeConfig::resolution_m`].
    pub bytes: Vec<u8>,
}

/// Bakes a finished map.
///
/// - `xyz`: metres, map frame. Points that are not finite or beyond 1,000 km are dropped.
/// - `intensity`: sensor units; missing values count as 0.
///
/// Returns the tiles, the coarsest first, each level in the order of x, y, z; none without points. The same points in the same order give
/// the same bytes.
pub fn bake(xyz: &[[f32; 3]], intensity: &[f32], config: &BakeConfig) -> Vec<BakedTile> {
    let Some(tree) = Tree::around(xyz, config) else {
        return Vec::new();
    };
    let mut nodes = tree.distribute(xyz);
    fold_small(&mut nodes, config.min_node_points);
    let unit = intensity_unit(intensity);
    nodes
        .into_iter()
        .map(|(node, members)| {
            let spacing = tree.finest_spacing_m * f32::from(tree.max_level - node.level).exp2();
            let mut chunk = tree.chunk(node, spacing, config.resolution_m);
            chunk.intensity_unit = unit;
            chunk.points = members.iter().map(|i| lattice_point(&chunk, xyz, intensity, *i)).collect();
            BakedTile {
                node,
                bounds: chunk.bounds(),
                spacing,
                points: chunk.points.len() as u32,
                bytes: encode(&chunk),
            }
        })
        .collect()
}

/// Position and depth of the tree.
struct Tree {
    origin: [f32; 3],
    max_level: u8,
    finest_spacing_m: f32,
}

/// Indices of the points of each node; ordered by level first because [`NodeId`] is.
type Nodes = BTreeMap<NodeId, Vec<u32>>;

impl Tree {
    /// The smallest tree that contains all usable points; `None` without usable points.
    fn around(xyz: &[[f32; 3]], config: &BakeConfig) -> Option<Self> {
        let mut bounds = Aabb::EMPTY;
        for point in xyz.iter().filter(|p| usable(p)) {
            bounds.include(*point);
        }
        let extent = (0..3).map(|axis| bounds.max[axis] - bounds.min[axis]).fold(f32::NEG_INFINITY, f32::max);
        if extent < 0.0 {
            return None;
        }
        // One cell less, so that the greatest coordinate is inside.
        let edge_of = |spacing: f32, level: u8| spacing * (NODE_CELLS - 1) as f32 * f32::from(level).exp2();
        let finest_spacing_m = config.finest_spacing_m.max(1e-3).max(extent / edge_of(1.0, MAX_LEVEL));
        let max_level = (0..MAX_LEVEL).find(|level| edge_of(finest_spacing_m, *level) > extent);
        Some(Self { origin: bounds.min, max_level: max_level.unwrap_or(MAX_LEVEL), finest_spacing_m })
    }

    /// Assigns every point to a node. Drops a point if its cell of the finest level has one already.
    fn distribute(&self, xyz: &[[f32; 3]]) -> Nodes {
        let mut occupied = vec![CellSet::default(); usize::from(self.max_level) + 1];
        let mut nodes = Nodes::new();
        for (i, point) in (0_u32..).zip(xyz).filter(|(_, p)| usable(p)) {
            let finest: [u32; 3] = std::array::from_fn(|axis| {
                ((point[axis] - self.origin[axis]) / self.finest_spacing_m) as u32
            });
            // Only the first point in a cell of the finest level is kept.
            if !occupied[usize::from(self.max_level)].insert(finest) {
                continue;
            }
            let cell_on = |level: u8| finest.map(|c| c >> (self.max_level - level));
            let coarser =
                (0..self.max_level).find(|level| occupied[usize::from(*level)].insert(cell_on(*level)));
            let level = coarser.unwrap_or(self.max_level);
            let [x, y, z] = cell_on(level).map(|c| c / NODE_CELLS);
            nodes.entry(NodeId { level, x, y, z }).or_default().push(i);
        }
        nodes
    }

    /// The node's lattice, without points.
    fn chunk(&self, node: NodeId, spacing: f32, resolution: f32) -> PointChunk {
        let divisor = (0..9_u8).map(|bits| f32::from(bits).exp2()).find(|d| spacing / d <= resolution);
        let divisor = divisor.unwrap_or(MAX_CELL_STEPS);
        let edge = self.finest_spacing_m * NODE_CELLS as f32 * f32::from(self.max_level).exp2();
        let step = spacing / divisor;
        // Lattice coordinates are the centres of the lattice's cells.
        let origin = node.cube(self.origin, edge).min.map(|c| c + 0.5 * step);
        PointChunk { origin, step, spacing, level: node.level, ..PointChunk::default() }
    }
}

fn usable(point: &[f32; 3]) -> bool {
    point.iter().all(|c| c.abs() <= MAX_COORDINATE_M)
}

fn lattice_point(chunk: &PointChunk, xyz: &[[f32; 3]], intensity: &[f32], i: u32) -> GpuPoint {
    let point = xyz[i as usize];
    let value = intensity.get(i as usize).copied().unwrap_or(0.0);
    GpuPoint {
        // At most 128 * 512 steps, and `as` saturates.
        position: std::array::from_fn(|axis| {
            ((point[axis] - chunk.origin[axis]) / chunk.step).round() as u16
        }),
        intensity: (value / chunk.intensity_unit).round() as u8,
        spare: 0,
    }
}

/// Moves the points of small leaves into their parents, deepest first, so that branches of small nodes are removed completely.
fn fold_small(nodes: &mut Nodes, min_points: usize) {
    let deepest_first: Vec<NodeId> = nodes.keys().rev().copied().collect();
    // A node is a leaf if none of its children is kept.
    let mut inner = std::collections::BTreeSet::new();
    for node in deepest_first {
        let Some(parent) = node.parent() else {
            continue;
        };
        let small = nodes.get(&node).is_some_and(|members| members.len() < min_points);
        if small && !inner.contains(&node) {
            let members = nodes.remove(&node).unwrap_or_default();
            nodes.entry(parent).or_default().extend(members);
        } else {
            inner.insert(parent);
        }
    }
}
