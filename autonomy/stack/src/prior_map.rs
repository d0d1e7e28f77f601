//! Saved maps that a session goes on from: between the log's plain data and what the libraries take.

use crate::mapping_messages as plain;
use geometry::isometry_from_pose;
use mapping::{Edge, KeyframeDescriptor, KeyframeDescriptorParts, MapKeyframe, MapMatcher, Node};
use messages::{EdgeKind, GraphEdge, GraphNode, PriorKeyframe, PriorMap};
use vocab::{KeyframeId, MapId, Pose};

/// What is kept of a keyframe's cloud (keyframe's frame, metres, seen from `lidar`) for a session that goes on from its map. None
/// if the pose is none. Costs what [`KeyframeDescriptor::new`] does.
pub fn encode_prior_keyframe(
    map_from_keyframe: &Pose,
    xyz: &[[f32; 3]],
    lidar: [f32; 3],
) -> Option<PriorKeyframe> {
    let rotation = isometry_from_pose(map_from_keyframe)?.rotation;
    let parts = KeyframeDescriptor::of_cloud(xyz, &rotation, lidar).parts();
    Some(PriorKeyframe { lidar, points: parts.points, ranges: parts.ranges, views: parts.views })
}

/// A saved map as the libraries take it.
#[derive(Debug)]
pub(crate) struct DecodedPriorMap {
    pub map: MapId,
    pub nodes: Vec<Node>,
    pub keyframes: Vec<MapKeyframe>,
    pub edges: Vec<Edge>,
    pub loops: Vec<Edge>,
}

impl DecodedPriorMap {
    /// Reads a map.
    ///
    /// # Errors
    /// When its parts do not belong together; a sentence.
    pub fn decode(plain: &PriorMap) -> Result<Self, String> {
        Self::of(plain).ok_or_else(|| {
            "That map cannot be used, because its keyframes, edges and clouds do not belong together. Make it again.".to_owned()
        })
    }

    fn of(plain: &PriorMap) -> Option<Self> {
        let count = plain.places.len();
        if count == 0 || count != plain.graph.nodes.len() {
            return None;
        }
        let nodes = plain.graph.nodes.iter().enumerate().map(|(index, node)| node_of(index, node));
        let nodes: Vec<Node> = nodes.collect::<Option<_>>()?;
        let keyframes = nodes.iter().zip(&plain.places).map(|(node, place)| {
            let PriorKeyframe { lidar, points, ranges, views } = place.clone();
            let descriptor =
                KeyframeDescriptor::from_parts(KeyframeDescriptorParts { points, ranges, views }, lidar)?;
            Some(MapKeyframe { map_from_keyframe: node.map_from_keyframe, descriptor })
        });
        let keyframes = keyframes.collect::<Option<_>>()?;
        let of_kind = |kind| {
            let edges = plain.graph.edges.iter().filter(move |edge| edge.kind == kind);
            edges.map(|edge| edge_of(edge, count)).collect::<Option<Vec<Edge>>>()
        };
        let (edges, loops) = (of_kind(EdgeKind::Odometry)?, of_kind(EdgeKind::Loop)?);
        Some(Self { map: plain.map, nodes, keyframes, edges, loops })
    }

    /// A matcher in which the robot is searched.
    pub fn matcher(&self) -> MapMatcher {
        let mut matcher = MapMatcher::default();
        for MapKeyframe { map_from_keyframe, descriptor } in &self.keyframes {
            matcher.push(map_from_keyframe, descriptor.clone());
        }
        matcher
    }
}

fn node_of(index: usize, node: &GraphNode) -> Option<Node> {
    let map_from_keyframe = isometry_from_pose(&node.map_from_keyframe)?;
    (node.id.0 as usize == index).then_some(Node { id: node.id, stamp: node.stamp, map_from_keyframe })
}

/// None for one that is no measurement between two of so many keyframes.
fn edge_of(edge: &GraphEdge, keyframes: usize) -> Option<Edge> {
    let from_from_to = isometry_from_pose(&edge.from_from_to)?;
    let known = |id: KeyframeId| (id.0 as usize) < keyframes;
    let information = plain::from_rows(&edge.information);
    let sound = known(edge.from)
        && known(edge.to)
        && edge.from != edge.to
        && information.iter().all(|entry| entry.is_finite());
    sound.then_some(Edge { from: edge.from, to: edge.to, from_from_to, information })
}
