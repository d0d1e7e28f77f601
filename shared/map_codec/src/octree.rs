//! Ids of octree nodes.

use serde::{Deserialize, Serialize};
use vocab::Aabb;

/// A node of an octree: level 0 is the root, and each level halves the edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct NodeId {
    /// Depth, 0 for the root.
    pub level: u8,
    /// Index along x, in edges of this level.
    pub x: u32,
    /// Index along y.
    pub y: u32,
    /// Index along z.
    pub z: u32,
}

impl NodeId {
    /// The root node.
    pub const ROOT: Self = Self { level: 0, x: 0, y: 0, z: 0 };

    /// The parent node; `None` for the root.
    pub fn parent(self) -> Option<Self> {
        let level = self.level.checked_sub(1)?;
        Some(Self { level, x: self.x >> 1, y: self.y >> 1, z: self.z >> 1 })
    }

    /// The cube of this node, given the least corner and edge of the root in metres.
    pub fn cube(self, root_origin: [f32; 3], root_edge: f32) -> Aabb {
        let edge = root_edge / f32::from(self.level).exp2();
        let place = [self.x, self.y, self.z];
        let min = std::array::from_fn(|axis| root_origin[axis] + place[axis] as f32 * edge);
        Aabb { min, max: min.map(|c: f32| c + edge) }
    }
}
