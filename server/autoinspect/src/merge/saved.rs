//! A saved map as it lies in its folder.

use crate::failure::Failure;
use geometry::{Isometry, isometry_from_pose};
use messages::{EdgeKind, GraphEdge, LoopDecision};
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use vocab::{KeyframeId, Pose, Stamp};

/// What of a map is joined with others, but for its clouds. Keyframes are numbered from 0.
#[derive(Debug)]
pub struct Saved {
    pub path: PathBuf,
    pub stamps: Vec<Stamp>,
    /// Keyframes in the map.
    pub poses: Vec<Isometry>,
    pub edges: Vec<GraphEdge>,
    pub trajectory: Vec<(Stamp, Pose)>,
    pub decisions: Vec<LoopDecision>,
    pub summary: api::MapSummary,
}

impl Saved {
    /// Reads what `store::write_map_files` wrote.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        // Written last, so that what follows is complete.
        let summary = json(&path.join("map.json"))?;
        let graph: api::Graph = json(&path.join("graph.json"))?;
        let text = |name: &str| {
            let path = path.join(name);
            fs::read_to_string(&path).map_err(|error| Failure::unreadable(&path, error))
        };
        let broken = |name: &str, what: &str| {
            Failure::usage(format!("{} {what}; make the map again", path.join(name).display()))
        };
        let in_order = graph.nodes.iter().enumerate().all(|(index, node)| node.id.0 as usize == index);
        if !in_order || graph.nodes.is_empty() {
            return Err(broken("graph.json", "does not number its keyframes from 0"));
        }
        let poses = graph.nodes.iter().map(|node| isometry_from_pose(&node.map_from_keyframe));
        let poses = poses
            .collect::<Option<Vec<_>>>()
            .ok_or_else(|| broken("graph.json", "has a keyframe without a pose"))?;
        let id = |vertex: u64| {
            u32::try_from(vertex).ok().filter(|id| (*id as usize) < poses.len()).map(KeyframeId)
        };
        let read = formats::g2o::read(&text("graph.g2o")?)
            .map_err(|error| Failure::unreadable(&path.join("graph.g2o"), error))?;
        let mut odometry: BTreeSet<_> = graph.edges.into_iter().collect();
        let edges = read.edges.iter().map(|edge| {
            let (from, to) = id(edge.from).zip(id(edge.to))?;
            // Odometry comes first in the file, and a loop may lie beside it.
            let kind = if odometry.remove(&(from, to)) { EdgeKind::Odometry } else { EdgeKind::Loop };
            let (from_from_to, information) = (edge.from_from_to, edge.information);
            Some(GraphEdge { from, to, kind, from_from_to, information })
        });
        let edges = edges
            .collect::<Option<Vec<_>>>()
            .ok_or_else(|| broken("graph.g2o", "has an edge to no keyframe"))?;
        let trajectory = formats::tum::read(&text("trajectory.tum")?)
            .map_err(|error| Failure::unreadable(&path.join("trajectory.tum"), error))?;
        let stamps = graph.nodes.iter().map(|node| node.stamp).collect();
        let decisions: Vec<LoopDecision> = json(&path.join("loops.json"))?;
        let known = |id: KeyframeId| (id.0 as usize) < poses.len();
        if !decisions.iter().all(|decision| known(decision.task.from) && known(decision.task.to)) {
            return Err(broken("loops.json", "speaks of keyframes that are not there"));
        }
        Ok(Self { path: path.to_owned(), stamps, poses, edges, trajectory, decisions, summary })
    }
}

fn json<T: DeserializeOwned>(path: &Path) -> Result<T, Failure> {
    let bytes = fs::read(path).map_err(|error| Failure::unreadable(path, error))?;
    serde_json::from_slice(&bytes).map_err(|error| Failure::unreadable(path, error))
}
