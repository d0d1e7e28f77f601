//! A saved map read from disk, to be merged with others or extended.

use crate::map_document::MapDocument;
use crate::{StoreError, files, texts};
use api::MapSummary;
use formats::FormatError;
use geometry::{Isometry, isometry_from_pose, pose_from_isometry};
use messages::{EdgeKind, GraphEdge, GraphNode, LoopDecision, PoseGraph};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use vocab::{KeyframeId, Pose, Stamp};

/// The content of a map's folder except clouds and tiles. Keyframes are numbered from 0.
#[derive(Debug)]
pub struct SavedMap {
    /// Its folder.
    pub path: PathBuf,
    /// Time of each keyframe.
    pub stamps: Vec<Stamp>,
    /// Pose of each keyframe in the map.
    pub poses: Vec<Isometry>,
    /// Odometry edges and loop closures.
    pub edges: Vec<GraphEdge>,
    /// Pose of the base in the map after every scan.
    pub trajectory: Vec<(Stamp, Pose)>,
    /// Decisions on loop candidates.
    pub decisions: Vec<LoopDecision>,
    /// As in the list of maps.
    pub summary: MapSummary,
}

impl SavedMap {
    /// Reads what [`crate::write_map_files`] wrote into a folder.
    ///
    /// # Errors
    /// When a file is missing, cannot be understood, or contradicts the others.
    pub fn read(path: &Path) -> Result<Self, StoreError> {
        // Written last, so the other files are complete if it exists.
        let summary = MapDocument::read(&path.join("map.json"))?.summary;
        let graph: api::Graph = files::read_json(&path.join("graph.json"))?;
        let broken = |name: &str, what| StoreError::Broken { path: path.join(name), what };
        let in_order = graph.nodes.iter().enumerate().all(|(index, node)| node.id.0 as usize == index);
        if !in_order || graph.nodes.is_empty() {
            return Err(broken("graph.json", texts::KEYFRAMES_NOT_IN_ORDER));
        }
        let poses = graph.nodes.iter().map(|node| isometry_from_pose(&node.map_from_keyframe));
        let poses =
            poses.collect::<Option<Vec<_>>>().ok_or_else(|| broken("graph.json", texts::INVALID_POSE))?;
        let id = |vertex: u64| {
            u32::try_from(vertex).ok().filter(|id| (*id as usize) < poses.len()).map(KeyframeId)
        };
        let read = read_text(&path.join("graph.g2o"), formats::g2o::read)?;
        let mut odometry: BTreeSet<_> = graph.edges.into_iter().collect();
        let edges = read.edges.iter().map(|edge| {
            let (from, to) = id(edge.from).zip(id(edge.to))?;
            // Odometry edges come first in the file; a loop closure may join the same two keyframes.
            let kind = if odometry.remove(&(from, to)) { EdgeKind::Odometry } else { EdgeKind::Loop };
            let (from_from_to, information) = (edge.from_from_to, edge.information);
            Some(GraphEdge { from, to, kind, from_from_to, information })
        });
        let edges =
            edges.collect::<Option<Vec<_>>>().ok_or_else(|| broken("graph.g2o", texts::EDGE_TO_NOWHERE))?;
        let trajectory = read_text(&path.join("trajectory.tum"), formats::tum::read)?;
        let stamps = graph.nodes.iter().map(|node| node.stamp).collect();
        let decisions: Vec<LoopDecision> = files::read_json(&path.join("loops.json"))?;
        let known = |id: KeyframeId| (id.0 as usize) < poses.len();
        if !decisions.iter().all(|decision| known(decision.task.from) && known(decision.task.to)) {
            return Err(broken("loops.json", texts::DECISION_ON_UNKNOWN_KEYFRAMES));
        }
        Ok(Self { path: path.to_owned(), stamps, poses, edges, trajectory, decisions, summary })
    }

    /// Its pose graph, as a session has it.
    pub fn graph(&self) -> PoseGraph {
        let nodes = self.poses.iter().zip(&self.stamps).zip(0..).map(|((pose, stamp), id)| GraphNode {
            id: KeyframeId(id),
            stamp: *stamp,
            map_from_keyframe: pose_from_isometry(pose),
        });
        PoseGraph { revision: 1, nodes: nodes.collect(), edges: self.edges.clone() }
    }

    /// Its trajectory after its keyframes moved to `poses`: each pose moves with the nearest keyframe. On ground that the map shows already, that is not the
    /// newest one. Cost: poses times keyframes; a second for 100,000 poses and 2,000 keyframes.
    pub fn moved_trajectory(&self, poses: &[Isometry]) -> impl Iterator<Item = (Stamp, Pose)> {
        self.trajectory.iter().filter_map(move |(stamp, pose)| {
            let pose = isometry_from_pose(pose)?;
            let squared_distance =
                |keyframe: &Isometry| (keyframe.translation.vector - pose.translation.vector).norm_squared();
            let pairs = self.poses.iter().zip(poses);
            let (before, now) =
                pairs.min_by(|(a, _), (b, _)| squared_distance(a).total_cmp(&squared_distance(b)))?;
            Some((*stamp, pose_from_isometry(&(now * before.inverse() * pose))))
        })
    }
}

fn read_text<T>(path: &Path, read: impl FnOnce(&str) -> Result<T, FormatError>) -> Result<T, StoreError> {
    let text = fs::read_to_string(path).map_err(|source| StoreError::io("read", path, source))?;
    read(&text).map_err(|source| StoreError::Cloud { path: path.to_owned(), source })
}
