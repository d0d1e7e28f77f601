//! The whole stack on generated sites: short walks over the stairs of buildings that no value was tuned on, and recovery in their maps on another
//! day.

use crate::day::{Day, FIRST};
use geometry::{Isometry, Vector3, aligned_rmse, isometry_from_pose, vec_from_plain};
use messages::{CommandKind, GoalKind, LocalisationState, LoopVerdict, MotionState, PriorMap};
use sim::{GroundTruth, RouteFollower, ScheduledFault, SimulatedSite, SiteName, Start};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{SessionId, Span, Stamp, Vec3};

/// Greatest root mean square error of the keyframes' positions, metres: that of one pass over the stairs with a tenth of the LiDAR's columns.
/// `cargo xtask bench sites` holds ten-minute maps to 1 cm.
const MAX_RMSE_M: f64 = 0.05;
/// State of a robot that knows its pose.
const LOCALISED: LocalisationState = LocalisationState::Localised { map: FIRST, degradation: None };
/// Greatest error of an accepted loop's translation, metres.
const MAX_LOOP_ERROR_M: f64 = 0.3;
/// A claimed position is wrong if it is farther than this from the truth, metres.
const POSITION_TOLERANCE_M: f64 = 0.2;
/// Limit of the duration of a recovery, seconds.
const MAX_RECOVERY_S: f64 = 20.0;

/// Maps a generated site on its short route, among two people, and compares poses and loops with the ground truth.
#[track_caller]
fn check_short_walk(seed: u64) {
    let name = SiteName::Generated(seed);
    let Some(route) = SimulatedSite::new(name).route("short").cloned() else { panic!("no such route") };
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
    assert!(rmse < MAX_RMSE_M, "seed {seed}: {:.1} mm RMSE of {} keyframes", 1e3 * rmse, pairs.len());
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
        assert!(off.norm() < MAX_LOOP_ERROR_M, "seed {seed}: a wrong loop: {decision:?}");
    }
    let Some(prior_map) = day.lockstep.map(FIRST).cloned() else { panic!("not kept") };
    check_recovery(seed, prior_map, &pairs);
}

/// Covers the LiDAR of a robot that is localised on another day, and carries it away. Each time it knows its pose again in time.
///
/// - `pairs`: true positions of the map's keyframes, and their positions in the map.
#[track_caller]
fn check_recovery(seed: u64, prior_map: Arc<PriorMap>, pairs: &[(Vector3, Vector3)]) {
    let Some(alignment) = geometry::umeyama(pairs, false) else { panic!("seed {seed}: no alignment") };
    let site = Arc::new(SimulatedSite::new(SiteName::Generated(seed)).on_another_day(5, 0.25));
    let start = site.start();
    let mut day = Day::on(Arc::clone(&site), 3, start, seed + 100, None);
    day.lockstep.keep_map(prior_map);
    day.command(CommandKind::Localise { map: FIRST, at: None });
    let wait = |day: &mut Day, what: &str| {
        let since = day.lockstep.now();
        loop {
            day.run(0.1);
            let map_from_base = isometry_from_pose(&day.estimate).unwrap_or_else(Isometry::identity);
            let found = (alignment.truth_from_estimate * map_from_base).translation.vector;
            let error_m = (found - day.true_position()).norm();
            if day.localisation == LOCALISED && error_m < POSITION_TOLERANCE_M {
                return;
            }
            if matches!(day.localisation, LocalisationState::Relocalising { .. })
                && day.motion == MotionState::Idle
            {
                day.start_goal(GoalKind::Relocalise);
            }
            let waited_s = (day.lockstep.now() - since).secs_f64();
            assert!(
                waited_s < MAX_RECOVERY_S,
                "seed {seed}, {what}: {error_m} m off, {:?}",
                day.localisation
            );
        }
    };
    wait(&mut day, "switched on");
    let from = day.lockstep.simulator().elapsed();
    let until = from + Span::from_millis(5_000);
    day.lockstep.simulator().inject_fault(ScheduledFault::BlindLidar { from, until });
    day.run(5.0);
    wait(&mut day, "covered");
    let here = day.true_position();
    let away = |place: &Vector3| (place - here).xy().norm();
    let places = pairs.iter().map(|pair| pair.0).filter(|place| (place.z - here.z).abs() < 0.2);
    let Some(place) = places.max_by(|a, b| away(a).total_cmp(&away(b))) else {
        panic!("seed {seed}: no place")
    };
    assert!(away(&place) > 5.0, "seed {seed}: the robot is carried {} m only", away(&place));
    let there = Start { position: Vec3::new(place.x, place.y, place.z), yaw: 2.0 };
    day.lockstep.simulator().carry(there, Span::from_millis(10_000));
    day.run(10.0);
    wait(&mut day, "carried");
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

mod nightly {
    use super::check_short_walk;

    #[test]
    fn all_benchmarked_sites_are_mapped_over_their_stairs() {
        for seed in (0..20).filter(|seed| ![2, 17].contains(seed)) {
            check_short_walk(seed);
        }
    }
}
