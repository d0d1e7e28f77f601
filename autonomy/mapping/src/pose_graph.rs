//! The pose graph of a session: keyframes, odometry edges and loops.
//!
//! All other parts only read it. The [`OdometryChain`] and the [`CovarianceGraph`] say how well a relative pose is known, the [`GraphOptimiser`]
//! finds the poses that fit the edges best. They are views that only this file updates, together with the lists of nodes and edges.

use crate::UncertainPose;
use crate::covariance_graph::CovarianceGraph;
use crate::graph_element::{PoseGraphEdge, PoseGraphNode, index, renormalised};
use crate::graph_optimiser::{GraphError, GraphOptimiser, KeyframePair, OptimiserConfig, Relinearisation};
use crate::odometry_chain::OdometryChain;
use geometry::Isometry;
use std::collections::BTreeSet;
use vocab::{KeyframeId, Stamp};

/// Keyframes, edges and loops of one session.
#[derive(Debug, Default)]
pub struct PoseGraph {
    nodes: Vec<PoseGraphNode>,
    edges: Vec<PoseGraphEdge>,
    loops: Vec<PoseGraphEdge>,
    loop_pairs: BTreeSet<KeyframePair>,
    revision: u64,
    chain: OdometryChain,
    covariances: CovarianceGraph,
    /// None where poses follow odometry alone.
    optimiser: Option<GraphOptimiser>,
    /// Why the graph is not optimised any more.
    failure: Option<GraphError>,
}

impl PoseGraph {
    /// An empty graph that is optimised. Use [`Self::default`] for one whose poses follow odometry alone.
    pub fn new(config: OptimiserConfig) -> Self {
        Self { optimiser: Some(GraphOptimiser::new(config)), ..Self::default() }
    }

    /// The graph of a finished map. Edges between unknown keyframes are left out of the covariances. Linear in the map but for the ordering
    /// of the optimiser.
    ///
    /// # Errors
    /// When a pose or edge is not finite, or the graph cannot be solved.
    pub fn resume(
        nodes: Vec<PoseGraphNode>,
        edges: Vec<PoseGraphEdge>,
        loops: Vec<PoseGraphEdge>,
        config: OptimiserConfig,
    ) -> Result<Self, GraphError> {
        let optimiser = GraphOptimiser::resume(config, &nodes, &edges, &loops)?;
        let (mut chain, mut covariances) = (OdometryChain::default(), CovarianceGraph::default());
        let is_known = |edge: &&PoseGraphEdge| index(edge.from).max(index(edge.to)) < nodes.len();
        // For each keyframe, the edge from the newest keyframe before it.
        let mut incoming: Vec<Option<(usize, UncertainPose)>> = vec![None; nodes.len()];
        for edge in edges.iter().filter(is_known) {
            let (from, to, relative) = (index(edge.from), index(edge.to), edge.relative_pose());
            covariances.add_odometry(from, to, &relative);
            let (from, to, relative) =
                if from < to { (from, to, relative) } else { (to, from, relative.inverse()) };
            if from < to && incoming[to].is_none_or(|(before, _)| before < from) {
                incoming[to] = Some((from, relative));
            }
        }
        for edge in loops.iter().filter(is_known) {
            covariances.add_loop(index(edge.from), index(edge.to), &edge.relative_pose());
        }
        for (keyframe, edge) in incoming.iter().enumerate().skip(1) {
            let [before, here] = [keyframe - 1, keyframe].map(|index| nodes[index].map_from_keyframe);
            chain.add_distance((before.inverse() * here).translation.vector.norm());
            match edge {
                Some((from, relative)) => chain.push_from(*from, relative),
                None => chain.push_detached(&(nodes[0].map_from_keyframe.inverse() * here)),
            }
        }
        let loop_pairs = loops.iter().map(|edge| (edge.from, edge.to)).collect();
        let (optimiser, failure) = (Some(optimiser), None);
        Ok(Self { nodes, edges, loops, loop_pairs, revision: 1, chain, covariances, optimiser, failure })
    }

    /// Keyframes in the order of their numbers.
    pub fn nodes(&self) -> &[PoseGraphNode] {
        &self.nodes
    }

    /// Odometry edges in the order of creation.
    pub fn edges(&self) -> &[PoseGraphEdge] {
        &self.edges
    }

    /// Accepted loops in the order of acceptance.
    pub fn loops(&self) -> &[PoseGraphEdge] {
        &self.loops
    }

    /// Grows with every change.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Whether there is a keyframe with this number.
    pub fn contains(&self, keyframe: KeyframeId) -> bool {
        index(keyframe) < self.nodes.len()
    }

    /// Whether two keyframes, the older one first, are connected by a loop.
    pub fn has_loop(&self, pair: KeyframePair) -> bool {
        self.loop_pairs.contains(&pair)
    }

    /// Why the graph is not optimised any more, if it is not. Poses and covariances stay valid.
    pub fn failure(&self) -> Option<&GraphError> {
        self.failure.as_ref()
    }

    /// The walk by odometry alone.
    pub fn chain(&self) -> &OdometryChain {
        &self.chain
    }

    /// The number that the next keyframe gets.
    pub fn next_id(&self) -> KeyframeId {
        KeyframeId(u32::try_from(self.nodes.len()).unwrap_or(u32::MAX))
    }

    /// Adds a distance walked, metres, before the keyframe that it leads to is added, or on known ground.
    pub fn add_distance(&mut self, distance_m: f64) {
        self.chain.add_distance(distance_m);
    }

    /// Adds a keyframe with the odometry edge that leads to it; none leads to the first. The distance walked has to be added before. A failure
    /// of the optimiser is kept, see [`Self::failure`].
    pub fn add_keyframe(
        &mut self,
        stamp: Stamp,
        map_from_keyframe: &Isometry,
        edge: Option<&PoseGraphEdge>,
    ) -> PoseGraphNode {
        let node = PoseGraphNode { id: self.next_id(), stamp, map_from_keyframe: *map_from_keyframe };
        let next = self.nodes.len();
        if let Some(edge) = edge {
            let relative = edge.relative_pose();
            let from = index(edge.from).min(next.saturating_sub(1));
            if next > 0 {
                self.chain.push_from(index(edge.from), &relative);
                self.covariances.add_odometry(from, next, &relative);
            }
        } else if let Some(first) = self.nodes.first() {
            self.chain.push_detached(&(first.map_from_keyframe.inverse() * map_from_keyframe));
        }
        self.edges.extend(edge);
        self.nodes.push(node);
        self.revision += 1;
        self.try_optimiser(|optimiser| optimiser.add_keyframe(&node, edge));
        node
    }

    /// Adds an accepted loop. [`Self::optimise`] moves the keyframes accordingly. Returns whether both keyframes exist.
    pub fn add_loop(&mut self, edge: &PoseGraphEdge) -> bool {
        if !(self.contains(edge.from) && self.contains(edge.to)) {
            return false;
        }
        self.covariances.add_loop(index(edge.from), index(edge.to), &edge.relative_pose());
        let pair = (edge.from, edge.to);
        if !self.has_loop(pair) && self.try_optimiser(|optimiser| optimiser.add_loop(edge)) {
            self.loop_pairs.insert(pair);
            self.loops.push(*edge);
            self.revision += 1;
        }
        true
    }

    /// Removes a loop. [`Self::optimise`] moves the keyframes accordingly. Returns whether there was one. Odometry edges are never removed.
    pub fn remove_loop(&mut self, from: KeyframeId, to: KeyframeId) -> bool {
        let removed = self.covariances.remove_loop(index(from), index(to));
        if self.loop_pairs.remove(&(from, to)) {
            self.loops.retain(|edge| (edge.from, edge.to) != (from, to));
            self.revision += 1;
            if let Some(optimiser) = &mut self.optimiser {
                optimiser.remove_loop((from, to));
            }
        }
        removed
    }

    /// Moves the keyframes to the poses that fit the edges best. Returns the correction of each keyframe's part of the map, see
    /// [`Self::move_keyframes`]; none if the graph cannot be optimised.
    pub fn optimise(&mut self) -> Option<Vec<Isometry>> {
        let optimiser = self.optimiser.as_mut().filter(|_| self.failure.is_none())?;
        match optimiser.solve() {
            Ok(poses) => Some(self.move_keyframes(&poses)),
            Err(error) => {
                self.failure = Some(error);
                None
            }
        }
    }

    /// A snapshot of the graph from which the keyframes' poses are solved once more, with every factor linearised again at the solution; none if the
    /// graph cannot be optimised. Linear in the graph, and short: factors are shared.
    pub fn relinearisation(&self) -> Option<Relinearisation> {
        let optimiser = self.optimiser.as_ref().filter(|_| self.failure.is_none())?;
        Some(optimiser.relinearisation())
    }

    /// How well relative poses are known.
    pub(crate) fn covariances(&self) -> &CovarianceGraph {
        &self.covariances
    }

    /// Runs an operation of the optimiser, if there is one, and keeps its failure. Returns whether it went well.
    fn try_optimiser(&mut self, run: impl FnOnce(&mut GraphOptimiser) -> Result<(), GraphError>) -> bool {
        let Some(optimiser) = &mut self.optimiser else { return true };
        if self.failure.is_some() {
            return false;
        }
        self.failure = run(optimiser).err();
        self.failure.is_none()
    }

    /// Sets the poses of the first keyframes in the map. Later keyframes move rigidly with the last one before them. Poses that are not finite
    /// are left out. Returns for each keyframe its correction, `new_map_from_old_map`.
    pub fn move_keyframes(&mut self, poses: &[Isometry]) -> Vec<Isometry> {
        let mut corrections = Vec::with_capacity(self.nodes.len());
        let mut last = Isometry::identity();
        for (index, node) in self.nodes.iter_mut().enumerate() {
            let found = poses.get(index).filter(|pose| pose.to_homogeneous().iter().all(|c| c.is_finite()));
            let before = node.map_from_keyframe;
            // Set exactly to the found pose, so that rounding errors do not accumulate.
            node.map_from_keyframe = renormalised(&found.copied().unwrap_or(last * before));
            if found.is_some() {
                last = renormalised(&(node.map_from_keyframe * before.inverse()));
            }
            corrections.push(last);
        }
        self.revision += 1;
        corrections
    }

    /// The best known pose of every keyframe in `from`, over odometry and loops, as a bound of its covariance.
    pub fn poses_in(&self, from: KeyframeId) -> Vec<Option<UncertainPose>> {
        self.covariances.poses_in(index(from))
    }

    /// As [`Self::poses_in`], in a frame whose pose in a keyframe is known.
    pub fn poses_in_frame(
        &self,
        from: KeyframeId,
        from_from_frame: &UncertainPose,
    ) -> Vec<Option<UncertainPose>> {
        self.covariances.poses_in_frame(index(from), from_from_frame)
    }

    /// The best known pose of one keyframe in another.
    pub fn relative_pose(&self, from: KeyframeId, to: KeyframeId) -> Option<UncertainPose> {
        self.covariances.relative_pose(index(from), index(to))
    }

    /// The keyframe nearest to a pose in the map, and that pose in it. Linear in the keyframes.
    pub fn nearest(&self, map_from_base: &Isometry) -> Option<(KeyframeId, Isometry)> {
        let poses = self.nodes.iter().map(|node| (node.id, node.map_from_keyframe.inverse() * map_from_base));
        poses.min_by(|(_, a), (_, b)| {
            a.translation.vector.norm_squared().total_cmp(&b.translation.vector.norm_squared())
        })
    }
}
