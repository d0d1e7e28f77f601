//! The whole stack on generated sites: short walks over the stairs of buildings that no value was tuned on.

use crate::day::{Day, FIRST};
use geometry::{Vector3, aligned_rmse, isometry_from_pose, vec_from_plain};
use messages::LoopVerdict;
use sim::{GroundTruth, RouteFollower, Site, SiteName};
use uuid::Uuid;
use vocab::{SessionId, Stamp};

/// Greatest root mean square error of the keyframes' positions, metres: that of one pass over the stairs with a tenth of the LiDAR's columns.
/// `cargo xtask bench sites` holds ten-minute maps to 1 cm.
const RMSE_MAX_M: f64 = 0.05;
/// Greatest error of an accepted loop's translation, metres.
const LOOP_ERROR_MAX_M: f64 = 0.3;

/// Maps a generated site on its short route, among two people, and compares poses and loops with the ground truth.
#[track_caller]
fn check_short_walk(seed: u64) {
    let name = SiteName::Generated(seed);
    let Some(route) = Site::new(name).route("short").cloned() else { panic!("no such route") };
    let session = Some(SessionId(Uuid::from_u128(1)));
    let mut day = Day::on(name, 2, route.start, seed, session);
    let (mut walker, mut track) = (RouteFollower::new(route), Vec::new());
    while let Some(drive) = walker.drive(&day.lockstep.simulator().truth()) {
        day.lockstep.simulator().command(drive);
        day.run(0.1);
        track.extend(day.lockstep.simulator().take_ground_truth());
    }
    let finished = day.finish(FIRST);
    let highest = track.iter().map(|truth| truth.site_from_base.position.z).fold(f64::NEG_INFINITY, f64::max);
    assert!(highest > 3.0, "seed {seed}: the robot did not climb the stairs");
    let pairs: Vec<(Vector3, Vector3)> = (finished.graph.nodes.iter())
        .map(|node| (position_at(&track, node.stamp), vec_from_plain(node.map_from_keyframe.position)))
        .collect();
    let rmse = aligned_rmse(&pairs).unwrap_or(f64::NAN);
    assert!(rmse < RMSE_MAX_M, "seed {seed}: {:.1} mm RMSE of {} keyframes", 1e3 * rmse, pairs.len());
    for decision in finished.decisions.iter().filter(|one| one.verdict == LoopVerdict::Accepted) {
        let pose = |id| {
            let node = finished.graph.nodes.iter().find(|node| node.id == id);
            node.and_then(|node| isometry_from_pose(&node.map_from_keyframe))
        };
        let (Some(from), Some(to)) = (pose(decision.task.from), pose(decision.task.to)) else {
            panic!("seed {seed}: a loop of no keyframes: {decision:?}")
        };
        // The graph is within the bar above, so it serves as truth for the larger limit.
        let off: Vector3 =
            (from.inverse() * to).translation.vector - vec_from_plain(decision.from_from_to.position);
        assert!(off.norm() < LOOP_ERROR_MAX_M, "seed {seed}: a wrong loop: {decision:?}");
    }
}

/// True position of the base at an instant, interpolated.
fn position_at(track: &[GroundTruth], stamp: Stamp) -> Vector3 {
    let after = track.partition_point(|truth| truth.stamp < stamp).clamp(1, track.len() - 1);
    let [(from, before), (to, then)] = [after - 1, after]
        .map(|index| (track[index].stamp, vec_from_plain(track[index].site_from_base.position)));
    let share = (stamp - from).secs_f64() / (to - from).secs_f64();
    before + (then - before) * share.clamp(0.0, 1.0)
}

#[test]
fn a_generated_spine_is_mapped_over_its_stairs() {
    check_short_walk(2);
}

#[test]
fn a_generated_ring_is_mapped_over_its_stairs() {
    check_short_walk(17);
}
