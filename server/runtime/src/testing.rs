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

/// Saves a walk of 20 m along x over a floor, with a wall on its right. From the eleventh keyframe on, poses are shifted to the left by this, metres.
pub fn save_corridor(store: &Store, map: MapId, shift_m: f64) {
    let session = SessionId(Uuid::from_u128(800 + map.0.as_u128()));
    let mut xyz = Vec::new();
    for (x, y) in (-30..=30_i16).flat_map(|x| (-20..=20_i16).map(move |y| (x, y))) {
        xyz.push([0.1 * f32::from(x), 0.1 * f32::from(y), -0.55]);
    }
    // The wall.
    for (x, z) in (-60..=60_i16).flat_map(|x| (-10..=20_i16).map(move |z| (x, z))) {
        xyz.push([0.05 * f32::from(x), -1.97, 0.05 * f32::from(z)]);
    }
    let cloud = Arc::new(Cloud { intensity: vec![10.0; xyz.len()], xyz });
    let nodes: Vec<GraphNode> = (0..=20_u32)
        .map(|id| GraphNode {
            id: KeyframeId(id),
            stamp: Stamp::from_parts(i64::from(id), 0),
            map_from_keyframe: Pose {
                position: Vec3::new(f64::from(id), if id > 10 { shift_m } else { 0.0 }, 0.55),
                ..Pose::IDENTITY
            },
        })
        .collect();
    for node in &nodes {
        let GraphNode { id, stamp, map_from_keyframe } = *node;
        let cloud = Arc::clone(&cloud);
        let keyframe = Keyframe { session, id, stamp, map_from_keyframe, cloud, lidar: [0.0; 3] };
        store.write_session_cloud(&keyframe).expect("written");
    }
    let finished = FinishedMap {
        map,
        name: "Corridor".to_owned(),
        session,
        extends: None,
        at: Stamp::from_parts(100, 0),
        distance_m: 20.0,
        trajectory: nodes.iter().map(|node| (node.stamp, node.map_from_keyframe)).collect(),
        graph: Arc::new(PoseGraph { revision: 1, nodes, edges: Vec::new() }),
        degenerate: Vec::new(),
        decisions: Vec::new(),
        unverified: 0,
        revisits: RevisitCounts::default(),
    };
    store.save_map(&finished).expect("saved");
}
