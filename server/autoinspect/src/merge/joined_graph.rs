//! Joins the graphs of several maps to one.

use crate::failure::Failure;
use crate::texts;
use factors::{BatchConfig, Between, FactorGraph, Key, Prior, Value, Values, optimise};
use geometry::{Isometry, Matrix6, isometry_from_pose, pose_from_isometry};
use mapping::{MapAlignment, OptimiserConfig, PoseGraphEdge};
use messages::{EdgeKind, FinishedMap, GraphEdge, GraphNode, LoopDecision, PoseGraph, RevisitCounts};
use std::sync::Arc;
use store::SavedMap;
use uuid::Uuid;
use vocab::{KeyframeId, MapId, SessionId, Stamp};

/// Parameters of [`JoinedGraph`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JoinedGraphConfig {
    /// Information of the prior on the first keyframe's pose (1/rad² and 1/m²), so that the first map's frame is kept. Its default is that of the session's graph
    /// ([`mapping::OptimiserConfig`]).
    pub origin_information: f64,
    /// Added to the information of every edge (1/rad² and 1/m²): a standard deviation of 1 km. It keeps the poses of every walk connected. Its default is that of the
    /// session's graph ([`mapping::OptimiserConfig`]).
    pub min_information: f64,
}

impl Default for JoinedGraphConfig {
    fn default() -> Self {
        let OptimiserConfig { origin_information, min_odometry_information, .. } = OptimiserConfig::default();
        Self { origin_information, min_information: min_odometry_information }
    }
}

/// Keyframes and edges of all maps so far, one map after the other.
#[derive(Debug, Default)]
pub struct JoinedGraph {
    config: JoinedGraphConfig,
    poses: Vec<Isometry>,
    edges: Vec<GraphEdge>,
    decisions: Vec<LoopDecision>,
    /// For each joined map in order: its index, and the number of its first keyframe.
    firsts: Vec<(usize, u32)>,
}

impl JoinedGraph {
    /// Starts with a map of the list, whose frame is kept.
    pub fn begin(&mut self, index: usize, map: &SavedMap) {
        self.append(index, map, &Isometry::identity());
    }

    /// Adds another map of the list, which was aligned with the joined ones, and optimises the graph.
    pub fn add(&mut self, index: usize, map: &SavedMap, joint: &MapAlignment) -> Result<(), Failure> {
        let first = self.append(index, map, &joint.first_from_second);
        self.edges.extend(joint.links.iter().map(|link| link_of(link, first)));
        self.settle().map_err(|error| Failure::failed(texts::unreadable_input(&map.path, &error)))
    }

    /// Poses of the keyframes.
    pub fn poses(&self) -> &[Isometry] {
        &self.poses
    }

    /// For each joined map in order: its index, and the number of its first keyframe.
    pub fn firsts(&self) -> &[(usize, u32)] {
        &self.firsts
    }

    fn append(&mut self, index: usize, map: &SavedMap, first_from_map: &Isometry) -> u32 {
        let first = self.poses.len() as u32;
        let on = |id: KeyframeId| KeyframeId(id.0 + first);
        self.firsts.push((index, first));
        self.poses.extend(map.poses.iter().map(|pose| first_from_map * pose));
        self.edges.extend(map.edges.iter().map(|edge| GraphEdge {
            from: on(edge.from),
            to: on(edge.to),
            ..*edge
        }));
        self.decisions.extend(map.decisions.iter().cloned().map(|mut decision| {
            (decision.task.from, decision.task.to) = (on(decision.task.from), on(decision.task.to));
            decision
        }));
        first
    }

    fn settle(&mut self) -> Result<(), String> {
        let text = |error: &dyn std::fmt::Display| error.to_string();
        let (mut values, mut graph) = (Values::default(), FactorGraph::default());
        let keys: Vec<Key> = self.poses.iter().map(|pose| values.insert(Value::Pose(*pose))).collect();
        let Some(origin) = self.poses.first() else { return Ok(()) };
        let prior = Prior::new(keys[0], origin, &(Matrix6::identity() * self.config.origin_information))
            .map_err(|e| text(&e))?;
        graph.add(prior, &values).map_err(|e| text(&e))?;
        for edge in &self.edges {
            let (from, to) = (keys[edge.from.0 as usize], keys[edge.to.0 as usize]);
            let measured = isometry_from_pose(&edge.from_from_to).ok_or(texts::MAP_EDGE_NO_POSE)?;
            let information = Matrix6::from_fn(|row, column| edge.information[row][column])
                + Matrix6::identity() * self.config.min_information;
            let factor = Between::new(from, to, &measured, &information).map_err(|e| text(&e))?;
            graph.add(factor, &values).map_err(|e| text(&e))?;
        }
        let solved = optimise(&graph, &values, &BatchConfig::default()).map_err(|e| text(&e))?.values;
        for (pose, key) in self.poses.iter_mut().zip(keys) {
            *pose = *solved.pose(key).map_err(|e| text(&e))?;
        }
        Ok(())
    }

    /// The map to be written. `maps`: the list.
    pub fn finish(self, maps: &[SavedMap], name: &str) -> FinishedMap {
        let stamps = self.firsts.iter().flat_map(|(index, _)| &maps[*index].stamps);
        let nodes = self.poses.iter().zip(stamps).zip(0..).map(|((pose, stamp), id)| GraphNode {
            id: KeyframeId(id),
            stamp: *stamp,
            map_from_keyframe: pose_from_isometry(pose),
        });
        let nodes: Vec<GraphNode> = nodes.collect();
        // One walk after the other, even if their times overlap.
        let mut walks: Vec<_> = self.firsts.iter().map(|(index, first)| (&maps[*index], *first)).collect();
        walks.sort_by_key(|(map, _)| map.trajectory.first().map(|(stamp, _)| *stamp));
        let trajectory =
            walks.iter().flat_map(|(map, first)| map.moved_trajectory(&self.poses[*first as usize..]));
        let trajectory = trajectory.collect();
        let newest = maps.iter().map(|map| map.summary.created).max().unwrap_or(Stamp::EPOCH);
        FinishedMap {
            // The id is computed from the maps, so the same maps give the same id.
            map: MapId(Uuid::from_u128(
                maps.iter().fold(1, |id: u128, map| id.rotate_left(1) ^ map.summary.id.0.as_u128()),
            )),
            name: name.to_owned(),
            session: SessionId(Uuid::nil()),
            extends: None,
            at: newest,
            distance_m: maps.iter().map(|map| map.summary.distance_m).sum(),
            graph: Arc::new(PoseGraph { revision: 1, nodes, edges: self.edges }),
            trajectory,
            degenerate: Vec::new(),
            decisions: self.decisions,
            unverified: 0,
            revisits: RevisitCounts::default(),
        }
    }
}

fn link_of(link: &PoseGraphEdge, first: u32) -> GraphEdge {
    GraphEdge {
        from: link.from,
        to: KeyframeId(link.to.0 + first),
        kind: EdgeKind::Loop,
        from_from_to: pose_from_isometry(&link.from_from_to),
        information: std::array::from_fn(|row| std::array::from_fn(|column| link.information[(row, column)])),
    }
}
