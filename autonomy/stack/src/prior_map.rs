//! Saved maps that a session extends or localises in: from the log's plain data to the types of the libraries, and back.

use crate::mapping_messages as plain;
use geometry::isometry_from_pose;
use mapping::{Edge, KeyframeDescriptor, KeyframeDescriptorParts, MapKeyframe, MapMatcher, Node};
use messages::{EdgeKind, GraphEdge, GraphNode, PriorKeyframe, PriorMap};
use vocab::{KeyframeId, MapId, Pose};

/// What is kept of a keyframe's cloud (keyframe's frame, metres, seen from `lidar`) for sessions that use its map. None
/// if the pose is invalid. Costs what [`KeyframeDescriptor::new`] does.
pub fn encode_prior_keyframe(
    map_from_keyframe: &Pose,
    xyz: &[[f32; 3]],
    lidar: [f32; 3],
) -> Option<PriorKeyframe> {
    let rotation = isometry_from_pose(map_from_keyframe)?.rotation;
    let parts = KeyframeDescriptor::of_cloud(xyz, &rotation, lidar).parts();
    Some(PriorKeyframe { lidar, points: parts.points, ranges: parts.ranges, views: parts.views })
}

/// A saved map in the types of the libraries.
#[derive(Debug)]
pub(crate) struct DecodedPriorMap {
    /// The map's version.
    pub map: MapId,
    /// Poses of the keyframes.
    pub nodes: Vec<Node>,
    /// What is kept of each keyframe's scan, in the order of the nodes.
    pub keyframes: Vec<MapKeyframe>,
    /// Edges between consecutive keyframes.
    pub edges: Vec<Edge>,
    /// Loop closures.
    pub loops: Vec<Edge>,
}

impl DecodedPriorMap {
    /// Converts a map.
    ///
    /// # Errors
    /// A sentence for people, if its parts do not belong together.
    pub fn decode(plain: &PriorMap) -> Result<Self, String> {
        Self::convert(plain).ok_or_else(|| crate::texts::PRIOR_MAP_INCONSISTENT.to_owned())
    }

    fn convert(plain: &PriorMap) -> Option<Self> {
        let count = plain.keyframes.len();
        if count == 0 || count != plain.graph.nodes.len() {
            return None;
        }
        let nodes = plain.graph.nodes.iter().enumerate().map(|(index, node)| convert_node(index, node));
        let nodes: Vec<Node> = nodes.collect::<Option<_>>()?;
        let keyframes = nodes.iter().zip(&plain.keyframes).map(|(node, place)| {
            let PriorKeyframe { lidar, points, ranges, views } = place.clone();
            let descriptor =
                KeyframeDescriptor::from_parts(KeyframeDescriptorParts { points, ranges, views }, lidar)?;
            Some(MapKeyframe { map_from_keyframe: node.map_from_keyframe, descriptor })
        });
        let keyframes = keyframes.collect::<Option<_>>()?;
        let of_kind = |kind| {
            let edges = plain.graph.edges.iter().filter(move |edge| edge.kind == kind);
            edges.map(|edge| convert_edge(edge, count)).collect::<Option<Vec<Edge>>>()
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

/// A node; none if its number is not its index or its pose is invalid.
fn convert_node(index: usize, node: &GraphNode) -> Option<Node> {
    let map_from_keyframe = isometry_from_pose(&node.map_from_keyframe)?;
    (node.id.0 as usize == index).then_some(Node { id: node.id, stamp: node.stamp, map_from_keyframe })
}

/// An edge; none if it is no measurement between two of the map's keyframes.
fn convert_edge(edge: &GraphEdge, keyframes: usize) -> Option<Edge> {
    let from_from_to = isometry_from_pose(&edge.from_from_to)?;
    let known = |id: KeyframeId| (id.0 as usize) < keyframes;
    let information = plain::from_rows(&edge.information);
    let sound = known(edge.from)
        && known(edge.to)
        && edge.from != edge.to
        && information.iter().all(|entry| entry.is_finite());
    sound.then_some(Edge { from: edge.from, to: edge.to, from_from_to, information })
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::PoseGraph;
    use vocab::Vec3;

    /// Two keyframes a metre apart, with an edge between them.
    fn map() -> PriorMap {
        let cloud: Vec<[f32; 3]> =
            (0..400_u16).map(|step| [f32::from(step % 20) * 0.3, f32::from(step / 20) * 0.3, -0.5]).collect();
        let pose = |x: f64| Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::IDENTITY };
        let node = |id: u32| GraphNode {
            id: KeyframeId(id),
            map_from_keyframe: pose(f64::from(id)),
            stamp: vocab::Stamp::EPOCH,
        };
        let edge = GraphEdge {
            from: KeyframeId(0),
            to: KeyframeId(1),
            kind: EdgeKind::Odometry,
            from_from_to: pose(1.0),
            information: [[1.0; 6]; 6],
        };
        let keyframes = (0..2).filter_map(|id| encode_prior_keyframe(&pose(f64::from(id)), &cloud, [0.0; 3]));
        PriorMap {
            map: MapId(uuid::Uuid::from_u128(1)),
            graph: PoseGraph { revision: 1, nodes: vec![node(0), node(1)], edges: vec![edge] },
            keyframes: keyframes.collect(),
        }
    }

    #[test]
    fn a_map_is_converted_with_its_keyframes_and_edges() {
        let decoded = DecodedPriorMap::decode(&map());
        let counts =
            decoded.map(|map| (map.nodes.len(), map.keyframes.len(), map.edges.len(), map.loops.len()));
        assert_eq!(counts, Ok((2, 2, 1, 0)));
    }

    #[test]
    fn a_map_whose_parts_do_not_belong_together_is_refused() {
        let refused = |change: fn(&mut PriorMap)| {
            let mut map = map();
            change(&mut map);
            DecodedPriorMap::decode(&map).is_err()
        };
        assert!(!refused(|_| {}));
        assert!(refused(|map| map.keyframes.clear()));
        assert!(refused(|map| drop(map.keyframes.pop())));
        assert!(refused(|map| map.graph.nodes[1].id = KeyframeId(7)));
        assert!(refused(|map| map.graph.nodes[0].map_from_keyframe.position.x = f64::NAN));
        assert!(refused(|map| map.graph.edges[0].to = KeyframeId(2)));
        assert!(refused(|map| map.graph.edges[0].to = KeyframeId(0)));
        assert!(refused(|map| map.graph.edges[0].information[2][3] = f64::INFINITY));
    }
}
