//! Behaviours on a level floor, with a robot that moves exactly as commanded.

use crate::*;
use geometry::{Isometry, Vector3, so3, vec_to_plain};
use localisation::ExplorationHint;
use messages::{
    ExecutiveEvent, GoalKind, MotionState, Principal, Publication, RobotProfile, StackEffect, WaitReason,
};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{ClientId, GoalId, Span, Stamp, Twist};

pub(crate) fn shifted(x: f64, y: f64) -> Isometry {
    Isometry::translation(x, y, 0.0)
}

pub(crate) fn operator(number: u128) -> Principal {
    Principal::operator(ClientId(Uuid::from_u128(number)))
}

/// What a LiDAR sees of a room of 8 by 8 metres from its middle.
pub(crate) fn room() -> Vec<[f32; 3]> {
    let mut points: Vec<[f32; 3]> = Vec::new();
    for x in -40..=40_i8 {
        points.extend((-40..=40_i8).map(|y| [0.1 * f32::from(x), 0.1 * f32::from(y), -0.5]));
        for z in [-0.3, 0.0, 0.3] {
            let x = 0.1 * f32::from(x);
            points.extend([[x, -4.0, z], [x, 4.0, z], [-4.0, x, z], [4.0, x, z]]);
        }
    }
    points
}

/// A thin post.
pub(crate) fn post(position: &Vector3) -> impl Iterator<Item = [f32; 3]> + use<> {
    let position = *position;
    (0..20_u8).flat_map(move |z| {
        let at =
            |x: f64, y: f64| [(position.x + x) as f32, (position.y + y) as f32, 0.05 * f32::from(z) - 0.4];
        [at(0.0, 0.0), at(0.1, 0.0), at(-0.1, 0.0), at(0.0, 0.1), at(0.0, -0.1)]
    })
}

/// An executive with a robot that moves exactly as commanded, at 20 Hz.
pub(crate) struct Rig {
    pub executive: Executive,
    pub situation: Situation,
    pub now: Stamp,
    /// Points that the robot can see, odometry frame. Empty when it sees nothing.
    pub points: Vec<[f32; 3]>,
    pub motion: MotionState,
    pub effects: Vec<StackEffect>,
    goals: u128,
}

impl Rig {
    pub fn new() -> Self {
        let profile = RobotProfile { standing_height_m: 0.5, ..RobotProfile::default() };
        let frames = Frames { map_from_odom: shifted(0.0, 0.0), odom_from_base: shifted(0.0, 0.0) };
        Self {
            executive: Executive::new(ExecutiveConfig::new(&profile), &profile),
            situation: Situation {
                frames,
                is_in_saved_map: false,
                is_localised: false,
                is_pose_unconfirmed: false,
                exploration_hint: ExplorationHint::default(),
            },
            now: Stamp::EPOCH,
            points: room(),
            motion: MotionState::Idle,
            effects: Vec::new(),
            goals: 0,
        }
    }

    /// A robot that has scanned the room for a second.
    pub fn in_room(map_from_odom: Isometry) -> Self {
        let mut rig = Self::new();
        rig.situation.frames.map_from_odom = map_from_odom;
        rig.run(1.0, &|_| true);
        rig
    }

    pub fn start(&mut self, kind: GoalKind) -> Result<(), String> {
        self.goals += 1;
        let goal = (GoalId(Uuid::from_u128(self.goals)), kind, operator(1));
        self.executive.start_goal(self.now, goal, &self.situation, &mut self.effects)
    }

    pub fn walk_to(&mut self, x: f64, y: f64) -> Result<(), String> {
        self.start(GoalKind::WalkTo(vec_to_plain(&Vector3::new(x, y, -0.5))))
    }

    /// The pose in a saved map is lost.
    pub fn lose_pose(&mut self) {
        self.situation.is_in_saved_map = true;
        self.situation.is_pose_unconfirmed = true;
        self.situation.is_localised = false;
        self.fire(ExecutiveEvent::PoseLost);
    }

    /// The pose is found.
    pub fn find_pose(&mut self) {
        self.situation.is_in_saved_map = true;
        self.situation.is_pose_unconfirmed = false;
        self.situation.is_localised = true;
        self.fire(ExecutiveEvent::PoseFound);
    }

    pub fn fire(&mut self, event: ExecutiveEvent) {
        self.executive.handle_event(self.now, event, &self.situation, &mut self.effects);
    }

    /// One step of 50 ms. The robot cannot enter points for which `is_open` is false.
    pub fn step(&mut self, is_open: &dyn Fn(&Vector3) -> bool) {
        self.now += Span::from_millis(50);
        let odom_from_base = self.situation.frames.odom_from_base;
        if !self.points.is_empty() {
            let base_from_odom = odom_from_base.inverse();
            let points = self.points.iter().map(|point| {
                let [x, y, z] = point.map(f64::from);
                let seen =
                    base_from_odom.rotation * Vector3::new(x, y, z) + base_from_odom.translation.vector;
                [seen.x as f32, seen.y as f32, seen.z as f32]
            });
            let points = points.collect::<Vec<_>>();
            self.executive.surroundings().insert_scan(self.now, &odom_from_base, [0.0; 3], &points);
        }
        self.executive.update(self.now, &self.situation, &mut self.effects);
        self.executive.publish_changes(self.now, &self.situation.frames, &mut self.effects);
        let mut wanted = None;
        for effect in &self.effects {
            match effect {
                StackEffect::Drive(drive) => wanted = Some(drive.velocity),
                StackEffect::Publish(Publication::Motion(motion)) => self.motion = motion.clone(),
                _ => {}
            }
        }
        if let Some(velocity) = wanted {
            let turned = so3::exp(&Vector3::new(0.0, 0.0, 0.05 * velocity.angular.z));
            let moved = Vector3::new(0.05 * velocity.linear.x, 0.05 * velocity.linear.y, 0.0);
            let next = odom_from_base * Isometry::from_parts(moved.into(), turned);
            let odom_from_base = &mut self.situation.frames.odom_from_base;
            match is_open(&next.translation.vector) {
                true => *odom_from_base = next,
                false => odom_from_base.rotation = next.rotation,
            }
        }
    }

    /// Steps for this time, seconds. Returns the robot's positions.
    pub fn run(&mut self, seconds: f64, is_open: &dyn Fn(&Vector3) -> bool) -> Vec<Vector3> {
        let mut track = Vec::new();
        for _ in 0..(seconds * 20.0).round() as u32 {
            self.effects.clear();
            self.step(is_open);
            track.push(self.position());
        }
        track
    }

    pub fn position(&self) -> Vector3 {
        self.situation.frames.odom_from_base.translation.vector
    }

    fn path_end(&self) -> Vector3 {
        let path = self.executive.behaviour.as_ref().map(|behaviour| behaviour.path().to_vec());
        path.and_then(|path| path.last().copied()).unwrap_or_else(|| panic!("the robot follows no path"))
    }
}

/// End of the published path, and its least distance from a post.
fn path(rig: &Rig, post: (f64, f64)) -> ((f64, f64), f64) {
    let MotionState::Walking { path, .. } = &rig.motion else {
        panic!("the robot does not walk: {:?}", rig.motion)
    };
    let mut nearest = f64::INFINITY;
    for pair in path.windows(2) {
        for step in 0..=20 {
            let share = f64::from(step) / 20.0;
            let [x, y] = [(pair[0].x, pair[1].x), (pair[0].y, pair[1].y)].map(|(a, b)| a + share * (b - a));
            nearest = nearest.min((x - post.0).hypot(y - post.1));
        }
    }
    path.last().map(|end| ((end.x, end.y), nearest)).unwrap_or(((f64::NAN, f64::NAN), nearest))
}

#[test]
fn a_loop_closure_moves_the_goal_but_not_the_obstacles() {
    let mut rig = Rig::new();
    rig.points.extend(post(&Vector3::new(1.5, 0.0, 0.0)));
    rig.situation.frames.map_from_odom = shifted(10.0, 0.0);
    rig.run(1.0, &|_| true);
    assert_eq!(rig.walk_to(13.0, 0.0), Ok(()));
    rig.run(0.05, &|_| false);
    let (end, nearest) = path(&rig, (11.5, 0.0));
    assert!((end.0 - 13.0).hypot(end.1) < 0.15 && nearest > 0.2, "{end:?} {nearest}");
    // A loop closure moves the map by 0.6 m under the robot. The next step comes before the regular replanning.
    rig.situation.frames.map_from_odom = shifted(10.0, 0.6);
    rig.run(0.05, &|_| false);
    let (end, nearest) = path(&rig, (11.5, 0.6));
    assert!((end.0 - 13.0).hypot(end.1) < 0.15 && nearest > 0.2, "{end:?} {nearest}");
}

#[test]
fn a_walk_waits_while_the_robot_sees_nothing_and_then_goes_on() {
    let mut rig = Rig::in_room(shifted(10.0, 0.0));
    assert_eq!(rig.walk_to(13.0, 0.0), Ok(()));
    rig.run(1.0, &|_| true);
    let before = rig.position();
    rig.points.clear();
    rig.run(20.0, &|_| true);
    assert!(matches!(rig.motion, MotionState::Waiting { .. }));
    let after = rig.position();
    assert!((after - before).norm() < 1.4 && after.x < 2.3, "{after}");
    rig.points = room();
    rig.run(5.0, &|_| true);
    assert_eq!(rig.motion, MotionState::Idle);
    assert!((rig.situation.frames.map_from_base().translation.x - 13.0).abs() < 0.2);
}

#[test]
fn a_robot_that_loses_its_pose_searches_on_seen_ground_and_resumes_its_goal() {
    let mut rig = Rig::in_room(shifted(10.0, 0.0));
    assert_eq!(rig.walk_to(13.0, 0.0), Ok(()));
    rig.lose_pose();
    assert!(
        rig.effects.contains(&StackEffect::Drive(messages::Drive::default())),
        "the robot must stop immediately"
    );
    let track = rig.run(2.0, &|_| true);
    assert!(
        track.iter().all(|at| at.norm() < 0.01),
        "the robot must stand first, so that its surroundings can be recognised"
    );
    let track = rig.run(20.0, &|_| true);
    assert!(matches!(rig.motion, MotionState::Relocalising { goal: Some(_) }));
    let far = track.iter().map(|at| at.norm()).fold(0.0, f64::max);
    assert!(far > 2.0 && track.iter().all(|at| at.x.abs().max(at.y.abs()) < 3.6), "{far}");
    // The found pose moves the map by 1 m.
    rig.situation.frames.map_from_odom = shifted(11.0, 0.0);
    rig.find_pose();
    rig.run(12.0, &|_| true);
    assert_eq!(rig.motion, MotionState::Idle);
    assert!(
        (rig.situation.frames.map_from_base().translation.vector - Vector3::new(13.0, 0.0, 0.0)).norm() < 0.2
    );
}

#[test]
fn a_search_without_success_ends_and_a_stopped_robot_stays_stopped() {
    let mut rig = Rig::in_room(shifted(0.0, 0.0));
    assert_eq!(rig.walk_to(3.0, 0.0), Ok(()));
    rig.lose_pose();
    rig.run(180.0, &|_| true);
    assert!(matches!(rig.motion, MotionState::Blocked { .. }), "{:?}", rig.motion);
    assert_eq!(rig.start(GoalKind::Relocalise), Ok(()));
    rig.executive.stop(rig.now, operator(1), &rig.situation, &mut rig.effects);
    rig.find_pose();
    assert!(rig.start(GoalKind::Relocalise).is_err());
    let stopped = rig.position();
    assert!(rig.run(5.0, &|_| true).iter().all(|at| (at - stopped).norm() < 1e-9));
    assert!(matches!(rig.motion, MotionState::Stopped { .. }));
}

#[test]
fn driving_by_hand_is_limited_by_the_profile() {
    let mut rig = Rig::new();
    let all = vocab::Vec3::new(9.0, -9.0, 9.0);
    let wanted = Twist { linear: all, angular: all };
    assert_eq!(rig.executive.drive(rig.now, wanted, operator(1), &rig.situation, &mut rig.effects), Ok(()));
    rig.effects.clear();
    rig.step(&|_| true);
    let limited =
        Twist { linear: vocab::Vec3::new(1.2, -0.5, 0.0), angular: vocab::Vec3::new(0.0, 0.0, 1.0) };
    assert!(
        rig.effects.contains(&StackEffect::Drive(messages::Drive { velocity: limited })),
        "{:?}",
        rig.effects
    );
    let broken = Twist { linear: vocab::Vec3::new(f64::NAN, 0.0, 0.0), ..Twist::default() };
    assert!(rig.executive.drive(rig.now, broken, operator(1), &rig.situation, &mut rig.effects).is_err());
}

/// A robot in the room that searches for its pose, and the end of its first path.
fn searching() -> (Rig, Vector3) {
    let mut rig = searching_by(ExplorationHint::default());
    rig.run(3.0, &|_| true);
    let end = rig.path_end();
    (rig, end)
}

/// A robot in the room that has just started to search for its pose.
fn searching_by(hint: ExplorationHint) -> Rig {
    let mut rig = Rig::in_room(shifted(0.0, 0.0));
    rig.lose_pose();
    rig.situation.exploration_hint = hint;
    assert_eq!(rig.start(GoalKind::Relocalise), Ok(()));
    rig
}

#[test]
fn a_search_walks_round_a_new_obstacle_on_its_path() {
    let (mut rig, end) = searching();
    let obstacle = end * 0.6;
    rig.points.extend(post(&obstacle));
    let track = rig.run(15.0, &|_| true);
    let nearest = track.iter().map(|at| (at - obstacle).xy().norm()).fold(f64::INFINITY, f64::min);
    let farthest = track.iter().map(|at| at.norm()).fold(0.0, f64::max);
    assert!(nearest > 0.3 && farthest > 1.5, "{nearest} m from it, {farthest} m away");
}

#[test]
fn a_search_walks_elsewhere_when_an_unseen_obstacle_stops_it() {
    let (mut rig, end) = searching();
    let direction = end.normalize();
    let track = rig.run(30.0, &|at: &Vector3| at.dot(&direction) < 0.5);
    let farthest = track.iter().map(|at| at.norm()).fold(0.0, f64::max);
    assert!(farthest > 1.5, "{farthest} m");
}

/// Two hypotheses, and a path with two corners that distinguishes them.
fn two_hypotheses() -> ExplorationHint {
    let path = [[0.0, 0.0], [0.0, 1.5], [0.0, 3.0], [-1.5, 3.0], [-3.0, 3.0]];
    ExplorationHint {
        hypotheses: 2,
        path: Some(path.map(|[x, y]| Vector3::new(x, y, -0.5)).into_iter().collect()),
    }
}

#[test]
fn a_search_with_two_hypotheses_walks_the_distinguishing_path_without_standing() {
    let track = searching_by(two_hypotheses()).run(12.0, &|_| true);
    // First it turns in place, by 135 degrees.
    assert!(
        track[40..].windows(10).take(80).all(|part| part[0] != part[9]),
        "the robot must not stand on its path"
    );
    let near =
        |x: f64, y: f64| track.iter().map(|at| (at.x - x).hypot(at.y - y)).fold(f64::INFINITY, f64::min);
    assert!(near(-3.0, 3.0) < 0.6);
    assert!(
        track.iter().take(160).all(|at| at.x < 0.6 && at.y > -0.6),
        "the robot must follow the path directly"
    );
}

#[test]
fn a_search_stands_until_the_distinguishing_path_is_computed() {
    let track = searching_by(ExplorationHint { hypotheses: 2, path: None }).run(2.0, &|_| true);
    assert!(track.iter().all(|at| at.norm() < 0.01));
    // An empty path means that no path distinguishes the hypotheses, so the robot explores.
    let track =
        searching_by(ExplorationHint { hypotheses: 2, path: Some(Arc::from([])) }).run(8.0, &|_| true);
    assert!(track.iter().any(|at| at.norm() > 2.0));
}

#[test]
fn a_search_leaves_a_path_that_an_unseen_obstacle_blocks() {
    let mut rig = searching_by(two_hypotheses());
    rig.run(1.0, &|_| true);
    // It may choose points behind the obstacle a few times, and gives each of them up after 6 s.
    let track = rig.run(45.0, &|at: &Vector3| at.y < 1.0);
    assert!(track.iter().any(|at| at.xy().norm() > 2.0), "the robot must leave the blocked path");
}

/// A solid block of posts, odometry frame.
fn block(x_m: std::ops::RangeInclusive<i8>, y_m: std::ops::RangeInclusive<i8>) -> Vec<[f32; 3]> {
    let at = |x: i8, y: i8| post(&Vector3::new(0.1 * f64::from(x), 0.1 * f64::from(y), 0.0));
    x_m.flat_map(|x| y_m.clone().map(move |y| (x, y))).flat_map(|(x, y)| at(x, y)).collect()
}

#[test]
fn a_search_explores_when_the_distinguishing_path_is_blocked_where_the_robot_stands() {
    let path = [[0.0, 0.0], [0.75, 0.0]].map(|[x, y]| Vector3::new(x, y, -0.5));
    let mut rig = searching_by(ExplorationHint { hypotheses: 2, path: Some(path.into_iter().collect()) });
    rig.points.extend(block(5..=10, -8..=8));
    let track = rig.run(10.0, &|_| true);
    assert!(track.iter().any(|at| at.norm() > 1.0), "the robot must not wait for the block to leave");
}

#[test]
fn an_enclosed_robot_reports_that_it_waits_for_a_free_path_and_walks_when_there_is_one() {
    let mut rig = searching_by(ExplorationHint::default());
    let free = rig.points.clone();
    for side in [block(-9..=9, 8..=9), block(-9..=9, -9..=-8), block(8..=9, -7..=7), block(-9..=-8, -7..=7)] {
        rig.points.extend(side);
    }
    let track = rig.run(10.0, &|_| true);
    assert!(track.iter().all(|at| at.norm() < 0.5));
    let waits_for = |rig: &Rig| {
        rig.executive.behaviour.as_ref().and_then(|search| search.progress(&shifted(0.0, 0.0)).waits_for)
    };
    assert_eq!(waits_for(&rig), Some(WaitReason::FreePath));
    rig.points = free;
    let track = rig.run(10.0, &|_| true);
    assert_eq!(waits_for(&rig), None);
    assert!(track.iter().any(|at| at.norm() > 1.0));
}

#[test]
fn a_search_follows_a_path_again_that_was_blocked_for_a_while() {
    let mut rig = searching_by(two_hypotheses());
    rig.run(1.0, &|_| true);
    rig.run(15.0, &|at: &Vector3| at.y < 1.0);
    let track = rig.run(40.0, &|_| true);
    let to_end = track.iter().map(|at| (at.x + 3.0).hypot(at.y - 3.0)).fold(f64::INFINITY, f64::min);
    assert!(to_end < 0.6, "{to_end} m from the end of the path");
}
