//! The keyframes of a saved map, without anything else of it.

use crate::{Store, StoreError, files};
use geometry::{Isometry, isometry_from_pose};
use vocab::{MapId, Stamp};

impl Store {
    /// Time and pose of each keyframe of a saved map, in the order of their numbers.
    ///
    /// # Errors
    /// When there is no such map, or its graph cannot be read.
    pub fn keyframe_poses(&self, map: MapId) -> Result<Vec<(Stamp, Isometry)>, StoreError> {
        let path = self.dir().map(map).join("graph.json");
        let graph: api::Graph = files::read_json(&path)?;
        let pose = |node: &api::GraphNode| Some((node.stamp, isometry_from_pose(&node.map_from_keyframe)?));
        let poses: Option<Vec<_>> = graph.nodes.iter().map(pose).collect();
        poses.ok_or(StoreError::Broken { path, what: crate::texts::INVALID_POSE })
    }
}
