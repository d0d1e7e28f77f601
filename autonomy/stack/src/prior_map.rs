//! Saved maps that a session extends or localises in: from the log's plain data to the types of the libraries, and back.
//!
//! That conversion takes longer than a step may: a pure function of the map, which the shell runs on the compute lane ([`MapPreparation`]). It hands
//! the result over before the step that gets the map ([`crate::Stack::supply_prepared_map`]). The log does not hold it. Where nothing was handed
//! over, as in a replay, the step prepares the map by itself, with the same result.

use crate::mapping_messages as plain;
use crate::texts;
use geometry::isometry_from_pose;
use localisation::{GlobalLocaliser, LocalisationMap};
use mapping::{
    KeyframeDescriptor, KeyframeDescriptorParts, LoopClosing, LoopClosingConfig, MapKeyframe, MapMatcher,
    MapSearch, MapSearchConfig, OptimiserConfig, PoseGraph, PoseGraphEdge, PoseGraphNode,
};
use messages::{EdgeKind, GraphEdge, GraphNode, JobDone, JobResult, PriorKeyframe, PriorMap};
use std::sync::Arc;
use vocab::{KeyframeId, MapId, Pose};

/// How a saved map is prepared for the part of the stack that waits for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MapPreparation {
    /// For a session that extends it.
    Extension {
        /// Position of the LiDAR, base frame, metres.
        sensor: [f32; 3],
    },
    /// To localise in it.
    Localisation,
}

/// A saved map as the stack uses it.
#[derive(Debug)]
pub struct PreparedMap {
    preparation: MapPreparation,
    source: Arc<PriorMap>,
    form: MapForm,
}

/// What was made of the map, or why it cannot be used.
#[derive(Debug)]
enum MapForm {
    Extension(Result<Box<BaseMap>, String>),
    Localisation(Result<Arc<GlobalLocaliser>, String>),
}

/// The finished map that a session extends.
#[derive(Debug)]
pub(crate) struct BaseMap {
    pub map: MapId,
    pub graph: PoseGraph,
    pub loops: Box<LoopClosing>,
    pub search: Box<MapSearch>,
}

impl MapPreparation {
    /// Prepares the map that a job has read: a pure function of both. None if the job has read none. Linear in the map but for the ordering of its graph.
    pub fn run(self, done: &JobDone) -> Option<PreparedMap> {
        let (JobResult::MapExtension(Ok(source)) | JobResult::Localisation(Ok(source))) = &done.result else {
            return None;
        };
        let form = match self {
            Self::Extension { sensor } => MapForm::Extension(BaseMap::new(source, sensor).map(Box::new)),
            Self::Localisation => MapForm::Localisation(localiser(source)),
        };
        Some(PreparedMap { preparation: self, source: Arc::clone(source), form })
    }
}

impl PreparedMap {
    /// Whether this is what the preparation would make of the map.
    fn is_of(&self, preparation: MapPreparation, source: &Arc<PriorMap>) -> bool {
        self.preparation == preparation && Arc::ptr_eq(&self.source, source)
    }

    /// The map for a session that extends it, seen from `sensor`. Prepared here if `supplied` is not it.
    ///
    /// # Errors
    /// A sentence for people.
    pub(crate) fn extension(
        supplied: Option<Self>,
        source: &Arc<PriorMap>,
        sensor: [f32; 3],
    ) -> Result<Box<BaseMap>, String> {
        match supplied.filter(|it| it.is_of(MapPreparation::Extension { sensor }, source)) {
            Some(Self { form: MapForm::Extension(map), .. }) => map,
            _ => BaseMap::new(source, sensor).map(Box::new),
        }
    }

    /// The map to localise in. Prepared here if `supplied` is not it.
    ///
    /// # Errors
    /// A sentence for people.
    pub(crate) fn localiser(
        supplied: Option<Self>,
        source: &Arc<PriorMap>,
    ) -> Result<Arc<GlobalLocaliser>, String> {
        match supplied.filter(|it| it.is_of(MapPreparation::Localisation, source)) {
            Some(Self { form: MapForm::Localisation(localiser), .. }) => localiser,
            _ => localiser(source),
        }
    }
}

impl BaseMap {
    fn new(source: &PriorMap, sensor: [f32; 3]) -> Result<Self, String> {
        let prior = DecodedPriorMap::decode(source)?;
        let search = MapSearch::new(MapSearchConfig::default(), prior.matcher());
        let DecodedPriorMap { map, nodes, keyframes, edges, loops } = prior;
        let graph = PoseGraph::resume(nodes, edges, loops, OptimiserConfig::default());
        let mut graph = graph.map_err(|error| texts::map_not_extendable(&error))?;
        let loops = LoopClosing::resume(LoopClosingConfig::default(), sensor, &keyframes, &mut graph);
        Ok(Self { map, graph, loops: Box::new(loops), search: Box::new(search) })
    }
}

fn localiser(source: &PriorMap) -> Result<Arc<GlobalLocaliser>, String> {
    let keyframes = DecodedPriorMap::decode(source)?.keyframes.into_iter();
    let keyframes = keyframes.map(|keyframe| (keyframe.map_from_keyframe, keyframe.descriptor));
    let map = Arc::new(LocalisationMap::new(keyframes.collect()));
    Ok(Arc::new(GlobalLocaliser::new(map)))
}

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
struct DecodedPriorMap {
    /// The map's version.
    pub map: MapId,
    /// Poses of the keyframes.
    pub nodes: Vec<PoseGraphNode>,
    /// What is kept of each keyframe's scan, in the order of the nodes.
    pub keyframes: Vec<MapKeyframe>,
    /// Edges between consecutive keyframes.
    pub edges: Vec<PoseGraphEdge>,
    /// Loop closures.
    pub loops: Vec<PoseGraphEdge>,
}

impl DecodedPriorMap {
    /// Converts a map.
    ///
    /// # Errors
    /// A sentence for people, if its parts do not belong together.
    pub fn decode(plain: &PriorMap) -> Result<Self, String> {
        Self::convert(plain).ok_or_else(|| texts::PRIOR_MAP_INCONSISTENT.to_owned())
    }

    fn convert(plain: &PriorMap) -> Option<Self> {
        let count = plain.keyframes.len();
        if count == 0 || count != plain.graph.nodes.len() {
            return None;
        }
        let nodes = plain.graph.nodes.iter().enumerate().map(|(index, node)| convert_node(index, node));
        let nodes: Vec<PoseGraphNode> = nodes.collect::<Option<_>>()?;
        let keyframes = nodes.iter().zip(&plain.keyframes).map(|(node, place)| {
            let PriorKeyframe { lidar, points, ranges, views } = place.clone();
            let descriptor =
                KeyframeDescriptor::from_parts(KeyframeDescriptorParts { points, ranges, views }, lidar)?;
            Some(MapKeyframe { map_from_keyframe: node.map_from_keyframe, descriptor })
        });
        let keyframes = keyframes.collect::<Option<_>>()?;
        let of_kind = |kind| {
            let edges = plain.graph.edges.iter().filter(move |edge| edge.kind == kind);
            edges.map(|edge| convert_edge(edge, count)).collect::<Option<Vec<PoseGraphEdge>>>()
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
fn convert_node(index: usize, node: &GraphNode) -> Option<PoseGraphNode> {
    let map_from_keyframe = isometry_from_pose(&node.map_from_keyframe)?;
    (node.id.0 as usize == index).then_some(PoseGraphNode {
        id: node.id,
        stamp: node.stamp,
        map_from_keyframe,
    })
}

/// An edge; none if it is no measurement between two of the map's keyframes.
fn convert_edge(edge: &GraphEdge, keyframes: usize) -> Option<PoseGraphEdge> {
    let from_from_to = isometry_from_pose(&edge.from_from_to)?;
    let known = |id: KeyframeId| (id.0 as usize) < keyframes;
    let information = plain::from_rows(&edge.information);
    let sound = known(edge.from)
        && known(edge.to)
        && edge.from != edge.to
        && information.iter().all(|entry| entry.is_finite());
    sound.then_some(PoseGraphEdge { from: edge.from, to: edge.to, from_from_to, information })
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{JobId, JobOwner};
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
            graph: messages::PoseGraph { revision: 1, nodes: vec![node(0), node(1)], edges: vec![edge] },
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

    #[test]
    fn a_prepared_map_is_used_for_the_map_that_it_was_made_of() {
        let source = Arc::new(map());
        let job = |owner| JobId { owner, number: 1 };
        let done = job(JobOwner::Localisation).map_read(Arc::clone(&source));
        let prepared = || MapPreparation::Localisation.run(&done);
        let own = |prepared: &Option<PreparedMap>| match prepared {
            Some(PreparedMap { form: MapForm::Localisation(Ok(localiser)), .. }) => Arc::clone(localiser),
            other => panic!("{other:?}"),
        };
        let supplied = prepared();
        let localiser = own(&supplied);
        let used = PreparedMap::localiser(supplied, &source);
        assert!(used.is_ok_and(|used| Arc::ptr_eq(&used, &localiser)));
        // Of another map, or for a session that extends it: prepared again.
        let supplied = prepared();
        let localiser = own(&supplied);
        let again = PreparedMap::localiser(supplied, &Arc::new(map()));
        assert!(again.is_ok_and(|again| !Arc::ptr_eq(&again, &localiser)));
        assert!(PreparedMap::extension(prepared(), &source, [0.0; 3]).is_ok());
        // A map that cannot be used says so either way.
        let broken = Arc::new(PriorMap { keyframes: Vec::new(), ..map() });
        let done = job(JobOwner::MapExtension).map_read(Arc::clone(&broken));
        let supplied = MapPreparation::Extension { sensor: [0.0; 3] }.run(&done);
        let [before, within] =
            [supplied, None].map(|supplied| PreparedMap::extension(supplied, &broken, [0.0; 3]).err());
        assert!(before.is_some() && before == within, "{before:?} {within:?}");
        assert!(MapPreparation::Localisation.run(&job(JobOwner::Localisation).not_done()).is_none());
    }
}
