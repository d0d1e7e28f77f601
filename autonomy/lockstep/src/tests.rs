//! Closed-loop tests of the whole stack: the stack reads sensors only, and the ground truth judges it.

use crate::{Lockstep, Stepper, replay};
use messages::{
    BootRecord, CancelCause, Command, CommandKind, GoalKind, GoalStatus, Input, Job, MappingState,
    MotionState, Principal, Publication, StackEffect, StopLatch,
};
use sim::{SimConfig, SiteName};
use stack::Stack;
use std::hash::{BuildHasher, RandomState};
use uuid::Uuid;
use vocab::{ClientId, CommandId, GoalId, MapId, Pose, SessionId, Span, Stamp, Twist, Vec3};

const COLUMNS: u32 = 200;

struct Scene {
    lockstep: Lockstep,
    commands: u128,
    estimate: Pose,
    motion: MotionState,
    goals: Vec<GoalStatus>,
    mapping: MappingState,
    refusals: Vec<String>,
    accepted: u32,
    saves: u32,
}

impl Scene {
    fn new(keep_log: bool) -> Self {
        let config = SimConfig { lidar_columns: COLUMNS, people: 0, ..SimConfig::new(SiteName::B1, 11) };
        Self {
            lockstep: Lockstep::new(config, Some(SessionId(Uuid::from_u128(1))), keep_log),
            commands: 0,
            estimate: Pose::IDENTITY,
            motion: MotionState::Idle,
            goals: Vec::new(),
            mapping: MappingState::Idle,
            refusals: Vec::new(),
            accepted: 0,
            saves: 0,
        }
    }

    fn command(&mut self, by: u128, kind: CommandKind) {
        self.commands += 1;
        let id = CommandId(Uuid::from_u128(self.commands));
        self.lockstep.give(Input::Command(Command { id, by: operator(by), kind }));
    }

    fn walk_to(&mut self, point: Vec3) {
        let goal = GoalId(Uuid::from_u128(self.commands + 1));
        self.command(1, CommandKind::StartGoal { goal, kind: GoalKind::WalkTo(point) });
    }

    fn run(&mut self, seconds: f64) {
        let until = self.lockstep.now() + Span::from_secs_f64(seconds);
        let (estimate, motion, mapping) = (&mut self.estimate, &mut self.motion, &mut self.mapping);
        let goals = &mut self.goals;
        let (refusals, accepted, saves) = (&mut self.refusals, &mut self.accepted, &mut self.saves);
        self.lockstep.advance(until, &mut |_, effect| match effect {
            StackEffect::Publish(Publication::Estimate(now)) => *estimate = now.map_from_base,
            StackEffect::Publish(Publication::Motion(now)) => *motion = now.clone(),
            StackEffect::Publish(Publication::Goal(update)) => goals.push(update.status.clone()),
            StackEffect::Publish(Publication::Mapping(now)) => *mapping = now.clone(),
            StackEffect::Answer { refused: Some(reason), .. } => refusals.push(reason.clone()),
            StackEffect::Answer { refused: None, .. } => *accepted += 1,
            StackEffect::StartJob { work: Job::SaveMap(_), .. } => *saves += 1,
            _ => {}
        });
    }

    fn true_position(&mut self) -> Vec3 {
        self.lockstep.simulator().truth().site_from_base.position
    }
}

fn operator(client: u128) -> Principal {
    Principal::operator(ClientId(Uuid::from_u128(client)))
}

fn distance_m(a: Vec3, b: Vec3) -> f64 {
    (a.x - b.x).hypot(a.y - b.y)
}

fn forward(speed: f64) -> CommandKind {
    CommandKind::Teleoperate(Twist { linear: Vec3::new(speed, 0.0, 0.0), angular: Vec3::default() })
}

#[test]
fn driving_by_hand_stops_half_a_second_after_the_last_command() {
    let mut scene = Scene::new(false);
    scene.run(3.0);
    let start = scene.true_position();
    for _ in 0..15 {
        scene.command(1, forward(0.6));
        scene.run(0.1);
    }
    let driven = scene.true_position();
    assert!(distance_m(start, driven) > 0.4, "moved {} m", distance_m(start, driven));
    scene.run(1.5);
    let stopped = scene.true_position();
    scene.run(1.0);
    assert!(distance_m(stopped, scene.true_position()) < 0.02, "the robot still moves");
    assert_eq!(scene.motion, MotionState::Idle);
}

#[test]
fn a_walk_reaches_its_goal_and_the_estimate_is_right() {
    let mut scene = Scene::new(false);
    scene.run(3.0);
    let start = scene.true_position();
    scene.walk_to(Vec3::new(3.0, 0.5, 0.0));
    scene.run(0.2);
    assert!(matches!(scene.motion, MotionState::Walking { .. }), "{:?} {:?}", scene.motion, scene.refusals);
    scene.run(14.0);
    assert_eq!(scene.motion, MotionState::Idle, "the robot must have arrived");
    let [accepted, running @ .., reached] = &scene.goals[..] else { panic!("no goal") };
    assert_eq!(*accepted, GoalStatus::Accepted);
    assert!(running.len() > 10 && running.iter().all(|status| matches!(status, GoalStatus::Running(_))));
    assert!(matches!(reached, GoalStatus::Succeeded(_)), "{reached:?}");
    let moved = distance_m(start, scene.true_position());
    let believed = scene.estimate.position.x.hypot(scene.estimate.position.y);
    assert!((moved - believed).abs() < 0.05, "moved {moved} m, believed {believed} m");
    assert!((believed - 3.04).abs() < 0.3, "believed {believed} m");
}

#[test]
fn stop_motion_holds_until_motion_is_allowed_and_needs_no_lease() {
    let mut scene = Scene::new(false);
    scene.run(3.0);
    scene.walk_to(Vec3::new(3.0, 0.5, 0.0));
    scene.run(2.0);
    scene.command(2, CommandKind::StopMotion);
    scene.run(1.0);
    assert!(matches!(scene.motion, MotionState::Stopped { .. }));
    let cancelled = GoalStatus::Cancelled { by: operator(2), cause: CancelCause::MotionStopped };
    assert_eq!(scene.goals.iter().filter(|status| status.is_outcome()).collect::<Vec<_>>(), [&cancelled]);
    scene.command(1, forward(0.5));
    scene.command(2, CommandKind::AllowMotion);
    scene.run(0.5);
    assert_eq!(scene.refusals.len(), 2, "{:?}", scene.refusals);
    assert!(matches!(scene.motion, MotionState::Stopped { .. }), "operator 2 does not hold the lease");
    scene.command(1, CommandKind::AllowMotion);
    scene.run(0.2);
    assert_eq!(scene.motion, MotionState::Idle);
}

#[test]
fn a_stop_of_before_the_start_holds_until_motion_is_allowed() {
    let mut scene = Scene::new(false);
    let stop_latch = Some(StopLatch { by: Some(operator(7)) });
    let boot = BootRecord { stop_latch, ..scene.lockstep.simulator().boot() };
    scene.lockstep.give(Input::Boot(Box::new(boot)));
    scene.run(2.0);
    let stopped = MotionState::Stopped { by: Some(ClientId(Uuid::from_u128(7))) };
    assert_eq!(scene.motion, stopped);
    scene.command(1, forward(0.5));
    scene.walk_to(Vec3::new(3.0, 0.5, 0.0));
    scene.run(1.0);
    assert_eq!((scene.refusals.len(), &scene.motion), (2, &stopped), "{:?}", scene.refusals);
    scene.command(1, CommandKind::AllowMotion);
    scene.run(0.2);
    assert_eq!((scene.accepted, &scene.motion), (1, &MotionState::Idle));
}

#[test]
fn a_repeated_command_is_answered_each_time_but_executed_once() {
    let mut scene = Scene::new(false);
    scene.run(3.0);
    let id = CommandId(Uuid::from_u128(77));
    let finish = CommandKind::FinishMapping { map: MapId(Uuid::from_u128(5)), name: "Hall".to_owned() };
    let command = Command { id, by: operator(1), kind: finish };
    for _ in 0..3 {
        scene.lockstep.give(Input::Command(command.clone()));
        scene.run(0.2);
    }
    assert_eq!((scene.accepted, scene.saves), (3, 1));
    assert_eq!(scene.mapping, MappingState::Idle, "the map must have been saved");
}

/// A stack whose output depends on the process it runs in, like one that iterates over a standard hash map.
struct Broken {
    stack: Stack,
    hasher: RandomState,
}

impl Stepper for Broken {
    fn step(&mut self, at: Stamp, input: Input, effects: &mut Vec<StackEffect>) {
        self.stack.step(at, input, effects);
        if effects.len() > 1 && self.hasher.hash_one(at.nanos()).is_multiple_of(2) {
            effects.reverse();
        }
    }
}

#[test]
fn a_log_replays_bit_for_bit_and_a_nondeterministic_stack_is_detected() {
    let mut scene = Scene::new(true);
    scene.run(2.5);
    scene.walk_to(Vec3::new(2.0, 0.3, 0.0));
    scene.run(2.5);
    let live = scene.lockstep.digest().hex();
    let log = scene.lockstep.log();
    assert!(scene.lockstep.digest().effects() > 100);
    assert_eq!(replay(log.iter().cloned(), &mut Stack::new()).hex(), live);

    let mut broken = Broken { stack: Stack::new(), hasher: RandomState::new() };
    assert_ne!(replay(log.iter().cloned(), &mut broken).hex(), live);
    let lost =
        log.iter().enumerate().filter(|(index, _)| *index != log.len() / 2).map(|(_, entry)| entry.clone());
    assert_ne!(replay(lost, &mut Stack::new()).hex(), live, "a lost input must change the digest");
}
