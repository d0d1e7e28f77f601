//! Known ground: what is kept of walks over it, and where the robot is then.

use super::*;
use crate::testing::{SENSOR, World, at, edge, ring, ring_poses, room, scan};
use crate::{Decision, KeyframeDescriptor, LoopConfig, MapKeyframe, Step, Verdict, compare, verify};
use geometry::{Matrix6, se3};

/// A robot whose odometry turns too far by `bias` radians a waypoint.
struct Robot {
    world: World,
    finder: LoopFinder,
    bias: f64,
    /// Of every waypoint, truly.
    walked: Vec<Isometry>,
    /// Of every keyframe, truly.
    keyframes: Vec<Isometry>,
    decisions: Vec<Decision>,
    ties: Vec<(u64, RevisitResult)>,
}

impl Robot {
    fn new(world: World, bias: f64) -> Self {
        Self {
            world,
            finder: LoopFinder::new(LoopConfig::default()),
            bias,
            walked: Vec::new(),
            keyframes: Vec::new(),
            decisions: Vec::new(),
            ties: Vec::new(),
        }
    }

    /// Walks to the next waypoint.
    fn ground(&mut self, pose: &Isometry) -> Novelty {
        let step = self.walked.last().map(|last| {
            let way = last.inverse() * pose * at(0.0, 0.0, self.bias);
            let measured = edge(0, 1, way, (2e-3, 0.01));
            Step { pose: measured.from_from_to, information: measured.information }
        });
        let number = self.walked.len();
        self.walked.push(*pose);
        let stamp = Stamp::from_parts(number as i64, 0);
        let cloud = scan(&self.world, pose, number as u64);
        self.finder.add_waypoint(&Waypoint { stamp, map_from_base: *pose, step }, &cloud, SENSOR)
    }

    /// As [`Self::ground`]; hands over what is to be compared with a visit.
    fn arrive(&mut self, pose: &Isometry) -> Option<Revisit> {
        match self.ground(pose) {
            Novelty::Keyframe { edge, tasks } => {
                assert_eq!(edge.is_some(), !self.keyframes.is_empty());
                self.keyframes.push(*pose);
                for task in tasks {
                    let verified = verify(&task, &self.finder.config().gates);
                    self.decisions.extend(self.finder.evaluate(&verified));
                }
                None
            }
            Novelty::Revisit(visit) => visit,
            Novelty::Unlocalised(number) => panic!("lost at waypoint {number}"),
        }
    }

    /// As [`Self::arrive`], and compares at once.
    fn walk(&mut self, pose: &Isometry) {
        if let Some(visit) = self.arrive(pose) {
            let tied = self.tie(&visit);
            self.ties.push((visit.number, tied));
        }
    }

    fn tie(&mut self, visit: &Revisit) -> RevisitResult {
        let compared = compare(&visit.comparison, &self.finder.config().gates);
        self.finder.complete_revisit(visit.number, &compared)
    }

    fn true_error(&self, anchor: KeyframeId, waypoint: usize, found: &Isometry) -> f64 {
        let truth = self.keyframes[anchor.0 as usize].inverse() * self.walked[waypoint];
        (truth.inverse() * found).translation.vector.norm()
    }
}

#[test]
fn rounds_over_known_ground_add_nothing_and_the_robot_stays_among_its_keyframes() {
    let mut robot = Robot::new(ring(), 1e-3);
    let rounds = 4;
    let mut after = Vec::new();
    for round in 0..rounds {
        for pose in ring_poses(if round == 0 { 0.0 } else { 0.25 * f64::from(round % 3) - 0.2 }) {
            robot.walk(&pose);
        }
        after.push(robot.keyframes.len());
    }
    assert!(after[0] >= 45, "{after:?}");
    assert!(after[3] <= after[0] + 6 && after[3] == after[2], "{after:?}");
    let anew: Vec<(u64, Reanchoring)> = robot
        .ties
        .iter()
        .filter_map(
            |(number, tied)| {
                if let RevisitResult::Reanchored(tie) = tied { Some((*number, *tie)) } else { None }
            },
        )
        .collect();
    // Three rounds of 50 m, a comparison every other metre.
    assert!(
        anew.len() >= 55 && anew.len() * 10 >= robot.ties.len() * 9,
        "{} of {}",
        anew.len(),
        robot.ties.len()
    );
    for (number, tie) in &anew {
        let error = robot.true_error(tie.anchor, *number as usize, &tie.anchor_from_waypoint);
        assert!(error < 0.04, "visit {number}: {error} m");
        assert_eq!(tie.since, Stamp::from_parts(*number as i64, 0));
    }
    // What is said of keyframes is true, and is said of each pair once at most.
    let mut said = Vec::new();
    for verified in anew.iter().filter_map(|(_, tie)| tie.edge) {
        let Edge { from, to, from_from_to, information } = verified.edge;
        assert!(from < to && information.cholesky().is_some(), "{verified:?}");
        let truth = robot.keyframes[from.0 as usize].inverse() * robot.keyframes[to.0 as usize];
        let error = se3::local(&truth, &from_from_to);
        assert!(error.fixed_rows::<3>(3).norm() < 0.06 && error.norm() < 0.08, "{verified:?} {error}");
        said.push((from, to));
    }
    assert!(said.len() <= after[3], "{} edges", said.len());
}

#[test]
fn behind_a_wall_is_another_place() {
    let mut world = room([-12.0, -1.2], [12.0, 1.8]);
    world.push([[-12.0, 0.2, -0.5], [12.0, 0.4, 2.5]]);
    let mut robot = Robot::new(world, 0.0);
    for x in -8..=8 {
        robot.walk(&at(f64::from(x), -0.4, 0.0));
    }
    let keyframes = robot.keyframes.len();
    assert_eq!(keyframes, 17);
    // Carried through the wall, as far as odometry is concerned: 1.4 m aside.
    for x in (-8..=8).rev() {
        robot.walk(&at(f64::from(x), 1.0, std::f64::consts::PI));
    }
    assert!(robot.keyframes.len() >= 2 * keyframes - 1, "{}", robot.keyframes.len());
}

#[test]
fn a_finished_map_is_gone_on_from_where_the_robot_is_found_in_it() {
    // Two sides of the ring, each way with its own errors.
    let poses = ring_poses(0.0);
    let mut first = Robot::new(ring(), 0.0);
    poses[..30].iter().for_each(|pose| first.walk(pose));
    assert_eq!(first.keyframes.len(), 30);
    let mut downsampler = points::Downsampler::default();
    let mut old = |(number, pose): (usize, &Isometry)| {
        let cloud = scan(&first.world, pose, number as u64);
        let place = KeyframeDescriptor::new(&cloud, &pose.rotation, SENSOR, &mut downsampler);
        MapKeyframe { map_from_keyframe: *pose, place }
    };
    let map: Vec<MapKeyframe> = poses[..30].iter().enumerate().map(&mut old).collect();
    let edges: Vec<Edge> = (1..30)
        .map(|to: u32| {
            let way = poses[to as usize - 1].inverse() * poses[to as usize];
            edge(to - 1, to, way, (2e-3, 0.01))
        })
        .collect();
    let mut robot = Robot::new(ring(), 2e-4);
    robot.finder = LoopFinder::resume(LoopConfig::default(), &map, &edges, &[]);
    robot.keyframes = poses[..30].to_vec();
    // Not known yet: nothing is kept.
    for pose in &poses[20..23] {
        assert!(matches!(robot.ground(pose), Novelty::Unlocalised(_)));
    }
    let found =
        UncertainPose { pose: poses[21].inverse() * poses[21], covariance: Matrix6::identity() * 1e-4 };
    assert_eq!(robot.finder.localise_in_map(1, KeyframeId(90), &found), None);
    let Some(now) = robot.finder.localise_in_map(1, KeyframeId(21), &found) else { panic!("not placed") };
    assert!(robot.true_error(KeyframeId(21), 2, &now) < 0.02);
    for pose in &poses[23..] {
        robot.walk(pose);
    }
    // On through the other two sides, and home.
    assert!(
        (poses.len() - 3..=poses.len() + 2).contains(&robot.keyframes.len()),
        "{}",
        robot.keyframes.len()
    );
    let closed = robot.decisions.iter().filter(|decision| decision.verdict == Verdict::Accepted);
    for decision in closed {
        let Edge { from, to, from_from_to, .. } = decision.edge;
        let truth = robot.keyframes[from.0 as usize].inverse() * robot.keyframes[to.0 as usize];
        assert!((truth.inverse() * from_from_to).translation.vector.norm() < 0.05, "{decision:?}");
    }
}

/// Once round the ring and a little more: on known ground, with comparisons not made yet.
fn returned() -> (Robot, Vec<Revisit>) {
    let mut robot = Robot::new(ring(), 5e-4);
    ring_poses(0.0).iter().for_each(|pose| robot.walk(pose));
    let mut visits = Vec::new();
    for pose in &ring_poses(0.1)[..4] {
        visits.extend(robot.arrive(pose));
    }
    assert_eq!(visits.len(), 2);
    (robot, visits)
}

#[test]
fn results_that_come_late_change_nothing_that_is_newer() {
    let (mut robot, visits) = returned();
    let last = visits.len() - 1;
    let (RevisitResult::Reanchored(tie), newest) = (robot.tie(&visits[last]), robot.walked.len() - 1) else {
        panic!("the last visit is found again")
    };
    let error = robot.true_error(tie.anchor, newest, &tie.anchor_from_waypoint);
    assert!(error < 0.05, "{error} m, walked on since");
    assert_eq!(robot.tie(&visits[last - 1]), RevisitResult::Confirmed);
    assert_eq!(robot.tie(&visits[last]), RevisitResult::Rejected, "it is not under way any more");
}

#[test]
fn what_is_not_where_it_was_expected_is_refused() {
    let spoil: [fn(&mut ComparisonResult); 3] = [
        |compared| compared.pose.translation.vector.x += 1.5,
        |compared| compared.rejection = Some(crate::RejectionReason::Overlap),
        |compared| compared.pose.translation.vector.x = f64::NAN,
    ];
    let (robot, visits) = returned();
    let compared = compare(&visits[0].comparison, &robot.finder.config().gates);
    for spoil in spoil {
        let (mut finder, mut spoilt) = (robot.finder.clone(), compared);
        spoil(&mut spoilt);
        assert_eq!(finder.complete_revisit(visits[0].number, &spoilt), RevisitResult::Rejected, "{spoilt:?}");
    }
    assert!(matches!(
        robot.finder.clone().complete_revisit(visits[0].number, &compared),
        RevisitResult::Reanchored(_)
    ));
}

#[test]
fn ground_that_is_not_confirmed_is_mapped_anew() {
    let (mut robot, _) = returned();
    let before = robot.keyframes.len();
    // No comparison ever comes to an end.
    for pose in &ring_poses(0.1)[4..40] {
        robot.arrive(pose);
    }
    assert!(robot.keyframes.len() > before, "{before}");
}

#[test]
fn a_visit_compared_after_known_ground_was_left_is_a_loop() {
    let (mut robot, visits) = returned();
    let last = &visits[visits.len() - 1];
    let compared = compare(&last.comparison, &robot.finder.config().gates);
    // Farther aside than any keyframe overlooks.
    let before = robot.keyframes.len();
    let mut pose = robot.walked[robot.walked.len() - 1];
    while robot.keyframes.len() == before {
        pose *= at(0.1, 0.0, 0.0);
        let unconfirmed = pose;
        robot.finder.visits_unconfirmed();
        robot.arrive(&unconfirmed);
    }
    let tied = robot.finder.complete_revisit(last.number, &compared);
    let RevisitResult::Loop(verified) = tied else { panic!("{tied:?}, {compared:?}") };
    let truth = robot.keyframes[verified.edge.from.0 as usize].inverse() * robot.keyframes[before];
    let error = (truth.inverse() * verified.edge.from_from_to).translation.vector.norm();
    assert!(verified.edge.to.0 as usize == before && error < 0.05, "{verified:?} {error}");
    let decided = robot.finder.evaluate(&verified);
    assert!(decided.iter().any(|decision| decision.verdict == Verdict::Accepted), "{decided:?}");
    assert_ne!(verified.edge.information, Matrix6::zeros());
}

impl LoopFinder {
    /// As if no comparison had succeeded for long.
    fn visits_unconfirmed(&mut self) {
        if let Some(position) = &mut self.visits.position {
            position.unconfirmed = 2.0 * BELIEVED;
        }
    }
}
