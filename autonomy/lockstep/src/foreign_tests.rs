//! Localisation in a map that no robot has recorded: a point cloud without viewpoints.

use crate::day::{Day, first};
use geometry::{Vector3, isometry_from_pose, pose_from_isometry};
use mapping::virtual_viewpoint::{ViewpointConfig, VirtualViewpoints, find_viewpoints};
use messages::{CommandKind, EdgeKind, GraphEdge, GraphNode, LocalisationState, PoseGraph, PriorMap};
use points::Downsampler;
use sim::Start;
use std::sync::Arc;
use uuid::Uuid;
use vocab::{KeyframeId, MapId, Stamp, Vec3};

const FOREIGN: MapId = MapId(Uuid::from_u128(9));
/// Resolution of the points in keyframes, metres.
const STEP: f32 = 0.002;

/// All points of the first day's map, downsampled to voxels of 0.1 m.
fn cloud() -> Vec<[f32; 3]> {
    let prior_map = &first().0;
    let mut all = Vec::new();
    for (node, keyframe) in prior_map.graph.nodes.iter().zip(&prior_map.keyframes) {
        let Some(pose) = isometry_from_pose(&node.map_from_keyframe) else { panic!("no pose") };
        all.extend(keyframe.points.iter().map(|point| -> [f32; 3] {
            let point = Vector3::from(point.map(|c| f64::from(f32::from(c) * STEP)));
            (pose.rotation * point + pose.translation.vector).map(|c| c as f32).into()
        }));
    }
    let mut thinned = Vec::new();
    Downsampler::default().downsample(&all, &[], 0.1, &mut thinned);
    thinned.into_iter().map(|centroid| centroid.xyz).collect()
}

/// A map of what a robot would see from virtual viewpoints in the cloud.
fn map_of(cloud: &[[f32; 3]]) -> PriorMap {
    let options = ViewpointConfig::default();
    let VirtualViewpoints { viewpoints, connections } = find_viewpoints(cloud, &options, &mut |_| {});
    let nodes = (0..).zip(&viewpoints).map(|(number, viewpoint)| GraphNode {
        id: KeyframeId(number),
        stamp: Stamp::EPOCH,
        map_from_keyframe: pose_from_isometry(&viewpoint.map_from_base),
    });
    let mut information = [[0.0; 6]; 6];
    (0..6).for_each(|index| information[index][index] = 1e4);
    let edges = connections.iter().map(|&[from, to]| GraphEdge {
        from: KeyframeId(from as u32),
        to: KeyframeId(to as u32),
        kind: EdgeKind::Odometry,
        from_from_to: pose_from_isometry(
            &(viewpoints[from].map_from_base.inverse() * viewpoints[to].map_from_base),
        ),
        information,
    });
    let keyframes = viewpoints.iter().map(|viewpoint| {
        let base = viewpoint.map_from_base.translation.vector.map(|c| c as f32);
        let about = |index: u32| std::array::from_fn(|axis| cloud[index as usize][axis] - base[axis]);
        let xyz: Vec<[f32; 3]> = viewpoint.visible.iter().map(about).collect();
        let pose = pose_from_isometry(&viewpoint.map_from_base);
        let keyframe = stack::encode_prior_keyframe(&pose, &xyz, [0.0, 0.0, options.lidar_height_m]);
        keyframe.unwrap_or_else(|| panic!("no pose"))
    });
    let graph = PoseGraph { revision: 1, nodes: nodes.collect(), edges: edges.collect() };
    PriorMap { map: FOREIGN, graph, keyframes: keyframes.collect() }
}

#[test]
fn a_robot_localises_in_an_imported_cloud_and_keeps_its_pose() {
    let origin = first().2;
    let start = Start { position: Vec3::new(29.0, 21.5, 0.0), yaw: -1.5 };
    let mut day = Day::among(6, start, 21, None);
    day.lockstep.keep_map(Arc::new(map_of(&cloud())));
    day.command(CommandKind::Localise { map: FOREIGN, at: None });
    day.run(4.0);
    let localised = LocalisationState::Localised { map: FOREIGN, degradation: None };
    assert_eq!(day.localisation, localised);
    assert!(day.error(&origin) < 0.05, "{} m", day.error(&origin));
    for leg in [[29.0, 17.2], [21.0, 17.2], [21.0, 23.0], [18.2, 23.5]].windows(2) {
        let [x, y] = leg[0];
        day.drive(Start { position: Vec3::new(x, y, 0.0), yaw: 0.0 }, &leg[1..]);
        let error = day.error(&origin);
        assert!(day.localisation == localised && error < 0.05, "{error} m, {:?}", day.localisation);
    }
}
