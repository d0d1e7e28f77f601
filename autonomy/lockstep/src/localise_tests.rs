//! Localisation in a saved map: from standstill, from a given pose, while walking among people, after losing the pose.

use crate::day::{Day, FIRST, first};
use crate::{JobPace, replay};
use geometry::Vector3;
use messages::{
    BootRecord, CommandKind, DegradationReason, GoalKind, Input, JobDone, JobResult, LocalisationState,
    MotionState, PoseHypothesis, PoseInMap, RelocalisationResponse, Sensor,
};
use scan_codec::PreparationConfig;
use sim::{ScheduledFault, SiteName, Start};
use stack::Stack;
use std::sync::Arc;
use vocab::{MapId, Pose, Quat, SessionId, Span, Twist, Vec3};

const LOCALISED: LocalisationState = LocalisationState::Localised { map: FIRST, degradation: None };

fn another_day(start: Start, seed: u64) -> Day {
    let mut day = Day::among(6, start, seed, None);
    day.lockstep.keep_map(Arc::clone(&first().0));
    day
}

fn at([x, y]: [f64; 2], yaw: f64) -> Start {
    Start { position: Vec3::new(x, y, 0.0), yaw }
}

#[test]
fn a_robot_switched_on_in_its_map_localises_and_keeps_its_pose_among_people() {
    let origin = first().2;
    let start = at([29.0, 21.5], -1.5);
    let mut day = another_day(start, 14);
    day.command(CommandKind::Localise { map: FIRST, at: None });
    day.run(0.5);
    assert!(
        matches!(day.localisation, LocalisationState::Relocalising { map: FIRST, .. }),
        "{:?}",
        day.localisation
    );
    day.run(2.5);
    assert_eq!(day.localisation, LOCALISED);
    assert!(day.error(&origin) < 0.05, "{} m", day.error(&origin));
    let (mut squares, mut worst, mut count) = (0.0, 0.0_f64, 0.0);
    for leg in [[29.0, 17.2], [21.0, 17.2], [21.0, 23.0], [18.2, 23.5]].windows(2) {
        day.drive(at(leg[0], 0.0), &leg[1..]);
        let error = day.error(&origin);
        (squares, worst, count) = (squares + error * error, worst.max(error), count + 1.0);
        assert_eq!(day.localisation, LOCALISED);
    }
    assert!((squares / count).sqrt() < 0.03 && worst < 0.05, "{} {worst}", (squares / count).sqrt());
    let again = replay(day.lockstep.log().iter().cloned(), &mut Stack::new());
    assert_eq!(again.hex(), day.lockstep.digest().hex());
}

#[test]
fn a_roughly_given_pose_is_refined() {
    let origin = first().2;
    let start = at([21.0, 17.2], 0.0);
    let mut day = another_day(start, 15);
    let position = Vec3::new(start.position.x - origin.x + 0.4, start.position.y - origin.y - 0.3, 0.0);
    let orientation = Quat { x: 0.0, y: 0.0, z: 0.05, w: (1.0 - 0.05_f64 * 0.05).sqrt() };
    day.command(CommandKind::Localise { map: FIRST, at: Some(Pose { position, orientation }) });
    day.run(2.0);
    assert_eq!(day.localisation, LOCALISED);
    assert!(day.error(&origin) < 0.05, "{} m", day.error(&origin));
}

/// A point on the outer ring of the torus, at this angle from the x axis, degrees. Its octants look alike.
fn on_the_ring(degrees: f64) -> [f64; 2] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [16.1 * cos, 16.1 * sin]
}

#[test]
fn a_wrong_pose_at_a_place_that_looks_alike_is_not_accepted() {
    // The robot starts along x, so that the map has the site's heading.
    let ring = |from: i32, to: i32| (from..=to).step_by(5).map(|degrees| on_the_ring(f64::from(degrees)));
    let start = at(on_the_ring(-90.0), 0.0);
    let mut day = Day::on(SiteName::Torus, 0, start, 31, Some(SessionId(uuid::Uuid::from_u128(1))));
    day.run(1.0);
    let origin = day.true_position();
    day.drive(start, &ring(-85, 40).collect::<Vec<_>>());
    day.finish(FIRST);
    let Some(prior_map) = day.lockstep.map(FIRST).cloned() else { panic!("not kept") };

    let start = at(on_the_ring(-45.0), 0.5);
    let mut day = Day::on(SiteName::Torus, 2, start, 32, None);
    day.lockstep.keep_map(prior_map);
    let [x, y] = on_the_ring(0.0);
    let half = (0.5 + 45.0_f64.to_radians()) / 2.0;
    let wrong = Pose {
        position: Vec3::new(x - origin.x, y - origin.y, 0.0),
        orientation: Quat { x: 0.0, y: 0.0, z: half.sin(), w: half.cos() },
    };
    day.command(CommandKind::Localise { map: FIRST, at: Some(wrong) });
    for tenth in 0..40 {
        day.run(0.1);
        let error = day.error(&origin);
        assert!(day.localisation != LOCALISED || error < 0.1, "{error} m off after {tenth}");
    }
    day.drive(start, &[on_the_ring(-41.0), on_the_ring(-36.0)]);
    assert_eq!(day.localisation, LOCALISED);
    assert!(day.error(&origin) < 0.1, "{} m", day.error(&origin));
}

#[test]
fn a_better_fitting_pose_makes_localisation_undecided_until_one_is_rejected() {
    let origin = first().2;
    let start = at([29.0, 21.5], -1.5);
    let mut day = another_day(start, 21);
    day.command(CommandKind::Localise { map: FIRST, at: None });
    day.run(3.0);
    assert_eq!(day.localisation, LOCALISED);
    let found_by = day.asked.take();
    assert!(found_by.is_some());
    // Jobs take 5 s, so that the test can give its own result first.
    day.lockstep.pace_jobs(JobPace { ticks: 100, newest_first: false });
    for _ in 0..40 {
        if day.asked.is_none() {
            push(&mut day, 0.8, 0.0, 2);
        }
    }
    let Some((job, task)) = day.asked.take() else { panic!("no periodic check was requested") };
    assert_eq!(day.localisation, LOCALISED);
    let map_from_base = Pose { position: Vec3::new(1.0, 1.0, 0.0), ..day.estimate };
    let own = PoseHypothesis { map_from_base: day.estimate, fit: 0.5, violation_share: 0.0 };
    let hypotheses = vec![PoseHypothesis { map_from_base, fit: 0.99, violation_share: 0.0 }, own];
    let result = JobResult::Relocalisation(Ok(RelocalisationResponse { task, hypotheses }));
    day.lockstep.give(Input::JobDone(JobDone { number: job.number, result }));
    day.run(0.2);
    let undecided = LocalisationState::Relocalising { map: FIRST, hypotheses: 2 };
    assert!(day.localisations.contains(&undecided), "{:?}", day.localisations);
    day.lockstep.pace_jobs(JobPace::default());
    day.run(8.0);
    assert_eq!(day.localisation, LOCALISED);
    assert!(day.error(&origin) < 0.05, "{} m", day.error(&origin));
}

/// Thins the sweeps of a standing robot to a quarter. At full resolution they keep four times as many points as this.
fn thin(mut day: Day) -> Day {
    let config = PreparationConfig { max_standing_points: 1_700, ..PreparationConfig::default() };
    day.lockstep.prepare_scans(config);
    day
}

/// Number of sweeps with points, but with fewer than a sweep of a robot that walks has.
fn thinned_sweeps(day: &Day) -> usize {
    let is_thinned = |input: &Input| match input {
        Input::Sensor(Sensor::Scan(scan)) => (1..=1_700).contains(&scan.xyz.len()),
        _ => false,
    };
    day.lockstep.log().iter().filter(|(_, input)| is_thinned(input)).count()
}

#[test]
fn a_standing_robot_with_thinned_sweeps_notices_that_its_lidar_is_covered() {
    let mut day = thin(another_day(at([29.0, 21.5], -1.5), 17));
    day.command(CommandKind::Localise { map: FIRST, at: None });
    day.run(6.0);
    assert_eq!(day.localisation, LOCALISED);
    assert!(thinned_sweeps(&day) > 20, "{}", thinned_sweeps(&day));
    let now = day.lockstep.simulator().elapsed();
    let until = now + Span::from_millis(5_000);
    day.lockstep.simulator().inject_fault(ScheduledFault::BlindLidar { from: now, until });
    day.run(2.0);
    let dark = LocalisationState::Localised { map: FIRST, degradation: Some(DegradationReason::LidarBlind) };
    assert_eq!(day.localisation, dark);
    day.run(5.0);
    assert_eq!(day.localisation, LOCALISED);
}

#[test]
fn after_twenty_seconds_with_a_blind_lidar_the_robot_is_localised_again() {
    let origin = first().2;
    let start = at([29.0, 21.5], -1.5);
    let mut day = another_day(start, 17);
    day.command(CommandKind::Localise { map: FIRST, at: None });
    day.run(3.0);
    assert_eq!(day.localisation, LOCALISED);
    let now = day.lockstep.simulator().elapsed();
    let until = now + Span::from_millis(20_000);
    day.lockstep.simulator().inject_fault(ScheduledFault::BlindLidar { from: now, until });
    day.drive(start, &[[29.0, 17.2], [22.0, 17.2]]);
    assert!(day.lockstep.simulator().elapsed() < until);
    let dark = LocalisationState::Localised { map: FIRST, degradation: Some(DegradationReason::LidarBlind) };
    assert_eq!(day.localisation, dark);
    day.drive(at([22.0, 17.2], 0.0), &[[21.0, 17.2], [21.0, 23.0]]);
    assert!(day.lockstep.simulator().elapsed() > until);
    day.run(1.0);
    assert_eq!(day.localisation, LOCALISED);
    assert!(day.error(&origin) < 0.03, "{} m", day.error(&origin));
}

#[test]
fn a_robot_that_is_carried_away_reports_that_it_is_lost_and_relocalises() {
    is_relocalised_after_being_carried(&mut another_day(at([29.0, 17.2], 3.0), 18));
}

#[test]
fn a_standing_robot_with_thinned_sweeps_notices_that_it_is_carried_away() {
    let mut day = thin(another_day(at([29.0, 17.2], 3.0), 18));
    is_relocalised_after_being_carried(&mut day);
    assert!(thinned_sweeps(&day) > 50, "{}", thinned_sweeps(&day));
}

fn is_relocalised_after_being_carried(day: &mut Day) {
    let origin = first().2;
    day.command(CommandKind::Localise { map: FIRST, at: None });
    day.run(3.0);
    assert_eq!(day.localisation, LOCALISED);
    day.lockstep.simulator().carry(at([18.6, 23.3], 1.0), Span::from_millis(10_000));
    day.run(10.0);
    assert_ne!(day.localisation, LOCALISED);
    // Whenever the robot reports that it is localised, its error must be below 0.1 m.
    let mut again = None;
    for tenth in 0..150 {
        day.run(0.1);
        let error = day.error(&origin);
        assert!(day.localisation != LOCALISED || error < 0.1, "{error} m off after {tenth}");
        if day.localisation == LOCALISED && error < 0.05 && again.is_none() {
            again = Some(tenth);
        }
    }
    let error = day.error(&origin);
    assert!(again.is_some(), "{:?}, {error} m", day.localisation);
    assert_eq!(day.localisation, LOCALISED);
}

#[test]
fn a_robot_that_is_carried_along_a_featureless_corridor_reports_that_it_is_lost() {
    // The robot starts along x, so that the map has the site's heading.
    let start = at([-8.0, -1.5], 0.0);
    let mut day = Day::on(SiteName::Twins, 0, start, 51, Some(SessionId(uuid::Uuid::from_u128(1))));
    day.run(1.0);
    let origin = day.true_position();
    day.drive(start, &[[40.0, -1.5]]);
    day.finish(FIRST);
    let Some(prior_map) = day.lockstep.map(FIRST).cloned() else { panic!("not kept") };

    let mut day = Day::on(SiteName::Twins, 0, start, 52, None);
    day.lockstep.keep_map(prior_map);
    day.command(CommandKind::Localise { map: FIRST, at: None });
    day.run(3.0);
    day.drive(start, &[[12.0, -1.5]]);
    assert_eq!(day.localisation, LOCALISED);
    // Heading and lateral position stay the same, so every scan still fits the old pose.
    day.lockstep.simulator().carry(at([26.0, -1.5], 0.0), Span::from_millis(12_000));
    day.run(11.0);
    assert!(matches!(day.localisation, LocalisationState::Relocalising { .. }), "{:?}", day.localisation);
    for tenth in 0..100 {
        day.run(0.1);
        let error = day.error(&origin);
        assert!(day.localisation != LOCALISED || error < 0.3, "{error} m off after {tenth}");
    }
}

/// Runs until the robot has ended its walk, but at most for this time, seconds.
fn until_it_stands(day: &mut Day, seconds: u32) {
    for _ in 0..seconds * 10 {
        day.run(0.1);
        if day.motion == MotionState::Idle {
            return;
        }
    }
}

#[test]
fn a_robot_that_is_carried_away_during_a_walk_relocalises_and_reaches_its_goal_by_itself() {
    let origin = first().2;
    let mut day = another_day(at([29.0, 17.2], 3.0), 18);
    day.command(CommandKind::Localise { map: FIRST, at: None });
    day.run(3.0);
    assert_eq!(day.localisation, LOCALISED);
    let goal = Vec3::new(21.5 - origin.x, 17.2 - origin.y, 0.0);
    day.start_goal(GoalKind::WalkTo(goal));
    day.run(2.0);
    assert!(matches!(day.motion, MotionState::Walking { .. }), "{:?} {:?}", day.motion, day.refusals);
    day.lockstep.simulator().carry(at([18.6, 23.3], 1.0), Span::from_millis(10_000));
    day.run(10.0);
    assert!(
        matches!(day.motion, MotionState::Relocalising { goal: Some(_) }),
        "the robot must notice that it was carried: {:?}",
        day.motion
    );
    day.start_goal(GoalKind::WalkTo(goal));
    day.run(0.1);
    assert_eq!(day.refusals.len(), 1, "a walk must be refused while the pose is unknown");
    until_it_stands(&mut day, 90);
    assert_eq!((day.motion.clone(), day.localisation), (MotionState::Idle, LOCALISED));
    let position = day.true_position() - origin;
    assert!((position.x - goal.x).hypot(position.y - goal.y) < 0.25, "{position}");
    let again = replay(day.lockstep.log().iter().cloned(), &mut Stack::new());
    assert_eq!(again.hex(), day.lockstep.digest().hex());
}

#[test]
fn a_walk_waits_while_the_lidar_is_blind_and_then_goes_on() {
    let origin = first().2;
    let mut day = another_day(at([29.0, 17.2], 3.0), 19);
    day.command(CommandKind::Localise { map: FIRST, at: None });
    day.run(3.0);
    let goal = Vec3::new(21.5 - origin.x, 17.2 - origin.y, 0.0);
    day.start_goal(GoalKind::WalkTo(goal));
    day.run(2.0);
    let now = day.lockstep.simulator().elapsed();
    day.lockstep
        .simulator()
        .inject_fault(ScheduledFault::BlindLidar { from: now, until: now + Span::from_millis(20_000) });
    day.run(3.0);
    let waits = day.true_position();
    assert!(matches!(day.motion, MotionState::Waiting { .. }), "{:?}", day.motion);
    day.run(16.5);
    assert!((day.true_position() - waits).norm() < 0.1, "the robot must not walk without seeing the ground");
    until_it_stands(&mut day, 30);
    let position = day.true_position() - origin;
    assert!((position.x - goal.x).hypot(position.y - goal.y) < 0.25, "{position}");
    assert_eq!(day.localisation, LOCALISED);
}

#[test]
fn a_restarted_robot_is_localised_at_its_last_pose_or_at_a_new_one() {
    let origin = first().2;
    for (was, is) in [([29.3, 21.2], [29.0, 21.5]), ([21.0, 17.2], [29.0, 21.5])] {
        let mut day = another_day(at(is, -1.5), 20);
        let position = Vec3::new(was[0] - origin.x, was[1] - origin.y, 0.0);
        let orientation = Quat { x: 0.0, y: 0.0, z: (-0.75_f64).sin(), w: 0.75_f64.cos() };
        let last_pose = Some(PoseInMap { map: FIRST, map_from_base: Pose { position, orientation } });
        let boot = BootRecord { last_pose, ..day.lockstep.simulator().boot() };
        day.lockstep.give(Input::Boot(Box::new(boot)));
        day.run(8.0);
        assert_eq!(day.localisation, LOCALISED);
        assert!(day.error(&origin) < 0.05, "{} m", day.error(&origin));
    }
}

#[test]
fn localisation_in_an_absent_map_stays_idle_and_leaving_a_map_ends_it() {
    let mut day = another_day(at([29.0, 21.5], -1.5), 16);
    let absent = MapId(uuid::Uuid::from_u128(99));
    day.start_goal(GoalKind::Relocalise);
    day.run(0.2);
    assert_eq!(
        (day.motion.clone(), day.refusals.len()),
        (MotionState::Idle, 1),
        "relocalisation must be refused without a map"
    );
    day.command(CommandKind::Localise { map: absent, at: None });
    day.run(0.5);
    assert_eq!(day.localisation, LocalisationState::Idle);
    day.command(CommandKind::Localise { map: FIRST, at: None });
    day.run(0.3);
    day.command(CommandKind::LeaveMap);
    day.run(0.3);
    assert_eq!((day.localisation, day.refusals.len()), (LocalisationState::Idle, 1));
}

/// Drives by hand at a speed (m/s) and a turning rate (rad/s) for this number of tenths of a second.
fn push(day: &mut Day, forward: f64, turn: f64, tenths: u32) {
    let [linear, angular] = [Vec3::new(forward, 0.0, 0.0), Vec3::new(0.0, 0.0, turn)];
    for _ in 0..tenths {
        day.command(CommandKind::Teleoperate(Twist { linear, angular }));
        day.run(0.1);
    }
    day.run(0.5);
}

/// A map of two metres, and the robot two metres beyond its end, where the map lacks much of what the robot sees.
fn past_the_end_of_a_short_map() -> (Day, Vector3) {
    let session = Some(SessionId(uuid::Uuid::from_u128(1)));
    let mut day = Day::begin(at([29.0, 21.5], 0.0), 1, session);
    day.run(1.0);
    let origin = day.true_position();
    push(&mut day, -0.8, 0.0, 20);
    assert!(day.finish(FIRST).graph.nodes.len() >= 2);
    push(&mut day, -0.8, 0.3, 20);
    (day, origin)
}

#[test]
fn in_a_map_that_was_just_made_the_robot_is_localised_within_two_seconds() {
    let (mut day, origin) = past_the_end_of_a_short_map();
    day.command(CommandKind::Localise { map: FIRST, at: None });
    day.run(1.5);
    assert_eq!(day.localisation, LOCALISED);
    assert!(day.error(&origin) < 0.05, "{} m", day.error(&origin));
}

#[test]
fn beyond_the_end_of_a_map_the_robot_localises_after_walking() {
    let (mut day, origin) = past_the_end_of_a_short_map();
    let (truth, prior_map) =
        (day.lockstep.simulator().truth().site_from_base, day.lockstep.map(FIRST).cloned());
    let yaw = 2.0 * truth.orientation.z.atan2(truth.orientation.w);
    let mut other = Day::among(2, Start { position: Vec3 { z: 0.0, ..truth.position }, yaw }, 7, None);
    other.lockstep.keep_map(prior_map.unwrap_or_else(|| panic!("the map was not kept")));
    other.command(CommandKind::Localise { map: FIRST, at: None });
    other.run(3.0);
    let looking = LocalisationState::Relocalising { map: FIRST, hypotheses: 0 };
    assert_eq!(other.localisation, looking, "one viewpoint must not be enough");
    push(&mut other, 0.8, -0.3, 35);
    assert_eq!(other.localisation, LOCALISED);
    assert!(other.error(&origin) < 0.05, "{} m", other.error(&origin));
}
