//! Publication of a pose graph: only the changes since the last publication. The published bytes therefore grow linearly with the walk, and not with
//! its square.

use crate::graph_element::{PoseGraphEdge, PoseGraphNode, index};
use crate::graph_optimiser::KeyframePair;
use crate::pose_graph::PoseGraph;
use geometry::{Isometry, so3};

/// Parameters of [`GraphPublisher`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraphPublisherConfig {
    /// A keyframe's pose is published again once it is this far from the published one, metres. Chosen: less cannot be seen on a screen; smaller values send more bytes
    /// after each loop (docs/benchmarks/pose-graphs.md).
    pub min_translation_m: f64,
    /// The same for its rotation, radians: 5 mm at a distance of 5 m. Chosen to go with [`Self::min_translation_m`].
    pub min_rotation_rad: f64,
}

impl Default for GraphPublisherConfig {
    fn default() -> Self {
        Self { min_translation_m: 0.005, min_rotation_rad: 0.001 }
    }
}

/// Stores the published state of a graph.
#[derive(Clone, Debug, Default)]
pub struct GraphPublisher {
    config: GraphPublisherConfig,
    revision: u64,
    poses: Vec<Isometry>,
    edges: usize,
    loops: Vec<PoseGraphEdge>,
}

/// What changed in a graph since a revision.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GraphChanges {
    /// Revision that the changes apply to; 0 for an empty graph.
    pub base_revision: u64,
    /// Revision after them.
    pub revision: u64,
    /// New keyframes, and those that moved noticeably, in the order of their numbers.
    pub nodes: Vec<PoseGraphNode>,
    /// New odometry edges.
    pub edges: Vec<PoseGraphEdge>,
    /// Loops that are gone.
    pub removed_loops: Vec<KeyframePair>,
    /// New loops.
    pub loops: Vec<PoseGraphEdge>,
}

impl GraphPublisher {
    /// Nothing was published yet.
    pub fn new(config: GraphPublisherConfig) -> Self {
        Self { config, ..Self::default() }
    }

    /// The changes since the last call, or all of the graph at first. `None` if nothing changed. Linear in the graph, some nanoseconds a keyframe.
    pub fn update(&mut self, graph: &PoseGraph) -> Option<GraphChanges> {
        if self.revision == graph.revision() {
            return None;
        }
        let nodes: Vec<PoseGraphNode> =
            graph.nodes().iter().filter(|node| self.is_due(node)).copied().collect();
        for node in &nodes {
            match self.poses.get_mut(index(node.id)) {
                Some(pose) => *pose = node.map_from_keyframe,
                None => self.poses.push(node.map_from_keyframe),
            }
        }
        let (removed_loops, kept) = self.removed_loops(graph.loops());
        let changes = GraphChanges {
            base_revision: self.revision,
            revision: graph.revision(),
            nodes,
            edges: graph.edges().get(self.edges..).unwrap_or_default().to_vec(),
            removed_loops,
            loops: graph.loops()[kept..].to_vec(),
        };
        self.revision = graph.revision();
        self.edges = graph.edges().len();
        self.loops.clear();
        self.loops.extend_from_slice(graph.loops());
        Some(changes)
    }

    /// Forgets what was published, so that the next update has all of the graph. Returns whether anything was published.
    pub fn forget_published(&mut self) -> bool {
        let published = self.revision > 0;
        *self = Self::new(self.config);
        published
    }

    /// Published loops that are gone, and how many loops of the graph were published. Those come first and in their order, so that the
    /// receiver has all loops in the order of the graph. A loop that was measured again is published as a removed and an added loop.
    fn removed_loops(&self, loops: &[PoseGraphEdge]) -> (Vec<KeyframePair>, usize) {
        let mut kept = 0;
        let mut removed = Vec::new();
        for published in &self.loops {
            match loops.get(kept) {
                Some(edge) if edge == published => kept += 1,
                _ => removed.push((published.from, published.to)),
            }
        }
        (removed, kept)
    }

    /// Whether a keyframe is new or has moved noticeably since it was published.
    fn is_due(&self, node: &PoseGraphNode) -> bool {
        self.poses.get(index(node.id)).is_none_or(|published| {
            let moved = published.inverse() * node.map_from_keyframe;
            moved.translation.vector.norm() >= self.config.min_translation_m
                || so3::log(&moved.rotation).norm() >= self.config.min_rotation_rad
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{at, edge};
    use geometry::RngTree;
    use vocab::{KeyframeId, Stamp};

    fn walked(count: u32) -> PoseGraph {
        let mut graph = PoseGraph::default();
        for number in 0..count {
            let step = number.checked_sub(1).map(|last| edge(last, number, at(1.0, 0.0, 0.0), (1e-3, 0.01)));
            graph.add_keyframe(Stamp::EPOCH, &at(f64::from(number), 0.0, 0.0), step.as_ref());
        }
        graph
    }

    #[test]
    fn only_what_changed_is_published() {
        let (mut graph, mut publisher) = (walked(100), GraphPublisher::default());
        let first = publisher.update(&graph);
        assert!(
            first.is_some_and(|all| (all.base_revision, all.nodes.len(), all.edges.len()) == (0, 100, 99))
        );
        assert_eq!(publisher.update(&graph), None);

        let step = edge(99, 100, at(1.0, 0.0, 0.0), (1e-3, 0.01));
        graph.add_keyframe(Stamp::EPOCH, &at(100.0, 0.0, 0.0), Some(&step));
        let closed = edge(3, 90, at(0.0, 0.0, 0.0), (1e-3, 0.01));
        assert!(graph.add_loop(&closed));
        let Some(next) = publisher.update(&graph) else { panic!("nothing published") };
        assert_eq!((next.base_revision, next.revision), (100, graph.revision()));
        assert_eq!((next.nodes.len(), next.edges, next.loops), (1, vec![step], vec![closed]));

        assert!(graph.remove_loop(KeyframeId(3), KeyframeId(90)));
        let Some(next) = publisher.update(&graph) else { panic!("nothing published") };
        assert_eq!(next.removed_loops, [(KeyframeId(3), KeyframeId(90))]);
        assert!(next.nodes.is_empty() && next.edges.is_empty() && next.loops.is_empty());
    }

    #[test]
    fn small_moves_add_up_until_they_are_noticeable() {
        let (mut graph, mut publisher) = (walked(10), GraphPublisher::default());
        publisher.update(&graph);
        let mut published = 0;
        for step in 1..=10 {
            let poses: Vec<Isometry> = (0..10)
                .map(|number| {
                    at(f64::from(number), if number < 5 { 0.0 } else { 0.001 * f64::from(step) }, 0.0)
                })
                .collect();
            graph.move_keyframes(&poses);
            published += publisher.update(&graph).map_or(0, |changes| changes.nodes.len());
        }
        assert_eq!(published, 2 * 5, "every five millimetres, and only those that move");
    }

    /// A receiver's graph: poses, odometry edges and loops.
    #[derive(Default)]
    struct Receiver {
        revision: u64,
        poses: Vec<Isometry>,
        edges: Vec<PoseGraphEdge>,
        loops: Vec<PoseGraphEdge>,
    }

    impl Receiver {
        fn apply(&mut self, changes: &GraphChanges) {
            if changes.base_revision == 0 {
                *self = Self::default();
            }
            assert_eq!(changes.base_revision, self.revision);
            for node in &changes.nodes {
                match self.poses.get_mut(index(node.id)) {
                    Some(pose) => *pose = node.map_from_keyframe,
                    None => self.poses.push(node.map_from_keyframe),
                }
            }
            self.edges.extend(&changes.edges);
            self.loops.retain(|edge| !changes.removed_loops.contains(&(edge.from, edge.to)));
            self.loops.extend(&changes.loops);
            self.revision = changes.revision;
        }
    }

    #[test]
    fn a_receiver_of_all_changes_has_the_graph() {
        let mut rng = RngTree::new(7).child("graph publisher").rng();
        let mut pick = |count: u32| (rng.range(0.0, f64::from(count)) as u32).min(count - 1);
        for _ in 0..50 {
            let (mut graph, mut publisher) = (walked(1), GraphPublisher::default());
            let mut receiver = Receiver::default();
            for _ in 0..200 {
                let count = graph.next_id().0;
                let pair = (pick(count), pick(count) + 1);
                match pick(8) {
                    0..=1 => {
                        let step = edge(count - 1, count, at(1.0, 0.0, 0.0), (1e-3, 0.01));
                        graph.add_keyframe(Stamp::EPOCH, &at(f64::from(count), 0.0, 0.0), Some(&step));
                    }
                    2..=3 => {
                        let measured = at(f64::from(pick(100)), 0.0, 0.0);
                        graph.add_loop(&edge(pair.0, pair.1, measured, (1e-3, 0.01)));
                    }
                    4 => {
                        if let Some(gone) = graph.loops().get(pick(count) as usize).copied() {
                            graph.remove_loop(gone.from, gone.to);
                            // Measured anew before anything was published.
                            if pick(2) == 0 {
                                graph.add_loop(&PoseGraphEdge { from_from_to: at(0.5, 0.0, 0.0), ..gone });
                            }
                        }
                    }
                    5 => {
                        let moved_m = 0.001 * f64::from(pick(20));
                        let poses: Vec<Isometry> =
                            (0..count).map(|number| at(f64::from(number), moved_m, 0.0)).collect();
                        graph.move_keyframes(&poses);
                    }
                    6 => {
                        publisher.forget_published();
                    }
                    _ => {}
                }
                if pick(2) == 0
                    && let Some(changes) = publisher.update(&graph)
                {
                    receiver.apply(&changes);
                    assert_eq!(receiver.revision, graph.revision());
                    assert_eq!(receiver.edges, graph.edges());
                    assert_eq!(receiver.loops, graph.loops());
                    assert_eq!(receiver.poses.len(), graph.nodes().len());
                    for (pose, node) in receiver.poses.iter().zip(graph.nodes()) {
                        let moved = pose.inverse() * node.map_from_keyframe;
                        assert!(moved.translation.vector.norm() < publisher.config.min_translation_m);
                    }
                }
            }
        }
    }
}
