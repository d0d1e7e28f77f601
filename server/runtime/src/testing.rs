//! Keyframes and a saved map for tests.

use messages::{Cloud, FinishedMap, GraphNode, Keyframe, PoseGraph, RevisitCounts};
use std::sync::Arc;
use store::Store;
use uuid::Uuid;
use vocab::{KeyframeId, MapId, Pose, SessionId, Stamp, Vec3};

pub(crate) const SESSION: SessionId = SessionId(Uuid::from_u128(7));
pub(crate) const MAP: MapId = MapId(Uuid::from_u128(1));

/// A keyframe one metre further along x than the one before, in front of a wall of 400 points.
pub(crate) fn keyframe(session: SessionId, id: u32) -> Keyframe {
    let xyz: Vec<[f32; 3]> =
        (0..400_u16).map(|i| [1.0, f32::from(i % 20) * 0.1, f32::from(i / 20) * 0.1 + 0.05]).collect();
    let intensity = vec![10.0; xyz.len()];
    Keyframe {
        session,
        id: KeyframeId(id),
        stamp: Stamp::from_parts(i64::from(id), 0),
        map_from_keyframe: Pose { position: Vec3::new(f64::from(id), 0.0, 0.0), ..Pose::IDENTITY },
        cloud: Arc::new(Cloud { xyz, intensity }),
        lidar: [0.0; 3],
    }
}

/// Saves [`MAP`] with three keyframes.
pub(crate) fn save_map(store: &Store) {
    let session = SessionId(Uuid::from_u128(8));
    let keyframes: Vec<Keyframe> = (0..3).map(|id| keyframe(session, id)).collect();
    for keyframe in &keyframes {
        store.write_session_cloud(keyframe).expect("written");
    }
    let node = |keyframe: &Keyframe| GraphNode {
        id: keyframe.id,
        stamp: keyframe.stamp,
        map_from_keyframe: keyframe.map_from_keyframe,
    };
    let nodes: Vec<GraphNode> = keyframes.iter().map(node).collect();
    let finished = FinishedMap {
        map: MAP,
        name: "Hall".to_owned(),
        session,
        extends: None,
        at: Stamp::from_parts(100, 0),
        distance_m: 2.0,
        trajectory: nodes.iter().map(|node| (node.stamp, node.map_from_keyframe)).collect(),
        graph: Arc::new(PoseGraph { revision: 1, nodes, edges: Vec::new() }),
        degenerate: Vec::new(),
        decisions: Vec::new(),
        unverified: 0,
        revisits: RevisitCounts::default(),
    };
    store.save_map(&finished).expect("saved");
}
