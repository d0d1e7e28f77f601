//! Nodes that follow their keyframes.

use geometry::{Isometry, isometry_from_pose, pose_from_isometry};
use site_model::Node;
use vocab::KeyframeId;

/// Smaller changes of a pose are rounding, metres and radians.
const SAME_M: f64 = 1e-6;
const SAME_RAD: f64 = 1e-6;

/// The nodes of `nodes` that move when the keyframes of their map get other poses (docs/maths/topomap.md, equation 4), as they are afterwards: when the map was patched, extended, or merged
/// with another. Nodes without an anchor, those whose keyframe has no pose any more, and those that stay where they are, are left out.
///
/// - `keyframe_pose`: pose of a keyframe in the new version of the map;
/// - `first`: the number that keyframe 0 of the old map has in the new one; more than 0 only for the later ones of merged maps.
///
/// Linear in the nodes.
pub fn repose_nodes<'a>(
    nodes: impl IntoIterator<Item = &'a Node>,
    keyframe_pose: impl Fn(KeyframeId) -> Option<Isometry>,
    first: u32,
) -> Vec<Node> {
    let moved = nodes.into_iter().filter_map(|node| {
        let mut anchor = node.anchor?;
        anchor.keyframe = KeyframeId(anchor.keyframe.0.checked_add(first)?);
        let keyframe_from_node = isometry_from_pose(&anchor.keyframe_from_node)?;
        let map_from_node = keyframe_pose(anchor.keyframe)? * keyframe_from_node;
        let is_moved = isometry_from_pose(&node.map_from_node).is_none_or(|before| {
            let offset = before.inverse() * map_from_node;
            offset.translation.vector.norm() > SAME_M || offset.rotation.angle() > SAME_RAD
        });
        let map_from_node = pose_from_isometry(&map_from_node);
        (is_moved || first > 0).then(|| Node { map_from_node, anchor: Some(anchor), ..node.clone() })
    });
    moved.collect()
}
