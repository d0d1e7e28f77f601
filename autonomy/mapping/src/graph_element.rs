//! Nodes and edges of the pose graph, and functions that all views of it share.

use crate::UncertainPose;
use geometry::{Isometry, Matrix6, Rotation};
use vocab::{KeyframeId, Stamp};

/// A keyframe in the graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseGraphNode {
    /// Counts from 0.
    pub id: KeyframeId,
    /// Time of its creation.
    pub stamp: Stamp,
    /// Its pose in the map.
    pub map_from_keyframe: Isometry,
}

/// A measured relative pose of two keyframes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseGraphEdge {
    /// Parent keyframe.
    pub from: KeyframeId,
    /// Child keyframe.
    pub to: KeyframeId,
    /// Pose of the child in the parent.
    pub from_from_to: Isometry,
    /// Inverse covariance, `[rotation; translation]`.
    pub information: Matrix6,
}

impl PoseGraphEdge {
    /// The relative pose with its covariance.
    pub fn relative_pose(&self) -> UncertainPose {
        UncertainPose::from_information(self.from_from_to, &self.information)
    }
}

/// The pose with its rotation normalised to a unit quaternion again. The norm drifts by rounding in products of products. Inverses take the
/// norm to be one, so a pose that is computed repeatedly from its own last value would drift exponentially.
pub fn renormalised(pose: &Isometry) -> Isometry {
    let rotation = Rotation::new_normalize(pose.rotation.into_inner());
    Isometry::from_parts(pose.translation, rotation)
}

/// A keyframe's number as an index.
pub(crate) fn index(keyframe: KeyframeId) -> usize {
    keyframe.0 as usize
}

/// The number of a keyframe.
pub(crate) fn keyframe_id(index: usize) -> KeyframeId {
    KeyframeId(u32::try_from(index).unwrap_or(u32::MAX))
}
