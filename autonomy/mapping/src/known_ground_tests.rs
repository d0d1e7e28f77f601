//! Revisits of mapped ground: which waypoints become keyframes, and the robot's pose there.

use super::*;
use crate::testing::{SENSOR, World, at, edge, ring, ring_poses, room, scan};
use crate::{
    Decision, KeyframeDescriptor, LoopConfig, MapKeyframe, OptimiserConfig, PoseGraphNode, Verdict, compare,
    verify,
};
use geometry::{Matrix6, se3};
use vocab::Stamp;

/// A robot whose odometry rotates too far by `bias` radians per waypoint.
struct Robot {
    world: World,
    finder: LoopFinder,
    graph: PoseGraph,
    bias: f64,
    /// True pose of every waypoint.
    walked: Vec<Isometry>,
    /// True pose of every keyframe.
    keyframes: Vec<Isometry>,
    decisions: Vec<Decision>,
    results: Vec<(u64, RevisitResult)>,
}

impl Robot {
    fn new(world: World, bias: f64) -> Self {
        Self {
            world,
            finder: LoopFinder::new(LoopConfig::default()),
            graph: PoseGraph::default(),
            bias,
            walked: Vec::new(),
            keyframes: Vec::new(),
            decisions: Vec::new(),
            results: Vec::new(),
        }
    }

    /// Walks to the next waypoint.
    fn ground(&mut self, pose: &Isometry) -> Novelty {
        let step = self.walked.last().map(|last| {
            let motion = last.inverse() * pose * at(0.0, 0.0, self.bias);
            let measured = edge(0, 1, motion, (2e-3, 0.01));
            OdometryStep { pose: measured.from_from_to, information: measured.information }
        });
        let number = self.walked.len();
        self.walked.push(*pose);
        let stamp = Stamp::from_parts(number as i64, 0);
        let cloud = scan(&self.world, pose, number as u64);
        self.finder.add_waypoint(
            &mut self.graph,
            &Waypoint { stamp, map_from_base: *pose, step, vertical: None },
            &cloud,
            SENSOR,
        )
    }

    /// Like [`Self::ground`]. Verifies loops and returns the revisit to be compared.
    fn arrive(&mut self, pose: &Isometry) -> Option<Revisit> {
        match self.ground(pose) {
            Novelty::Keyframe { id, tasks } => {
                assert_eq!(id.0 as usize, self.keyframes.len());
                self.keyframes.push(*pose);
                for task in tasks {
                    let verified = verify(&task, &self.finder.config().verification);
                    self.decisions.extend(self.finder.evaluate(&mut self.graph, &verified));
                }
                None
            }
            Novelty::Revisit(revisit) => revisit,
            Novelty::Unlocalised(number) => panic!("not localised at waypoint {number}"),
        }
    }

    /// Like [`Self::arrive`], and compares immediately.
    fn walk(&mut self, pose: &Isometry) {
        if let Some(revisit) = self.arrive(pose) {
            let result = self.complete(&revisit);
            self.results.push((revisit.waypoint, result));
        }
    }

    fn complete(&mut self, revisit: &Revisit) -> RevisitResult {
        let compared = compare(&revisit.comparison, &self.finder.config().verification);
        self.finder.complete_revisit(&self.graph, revisit.waypoint, &compared)
    }

    fn true_error(&self, anchor: KeyframeId, waypoint: usize, found: &Isometry) -> f64 {
        let truth = self.keyframes[anchor.0 as usize].inverse() * self.walked[waypoint];
        (truth.inverse() * found).translation.vector.norm()
    }
}

#[test]
fn rounds_on_known_ground_add_no_keyframes_and_keep_the_pose() {
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
    let reanchored: Vec<(u64, Reanchoring)> = robot
        .results
        .iter()
        .filter_map(|(number, result)| {
            if let RevisitResult::Reanchored(reanchoring) = result {
                Some((*number, *reanchoring))
            } else {
                None
            }
        })
        .collect();
    // Three rounds of 50 m, with a comparison every other metre.
    assert!(
        reanchored.len() >= 55 && reanchored.len() * 10 >= robot.results.len() * 9,
        "{} of {}",
        reanchored.len(),
        robot.results.len()
    );
    for (number, reanchoring) in &reanchored {
        let error = robot.true_error(reanchoring.anchor, *number as usize, &reanchoring.anchor_from_waypoint);
        assert!(error < 0.04, "revisit {number}: {error} m");
        assert_eq!(reanchoring.since, Stamp::from_parts(*number as i64, 0));
    }
    // Edges between keyframes must be right, and there must be at most one per keyframe.
    let mut loops = Vec::new();
    for verified in reanchored.iter().filter_map(|(_, reanchoring)| reanchoring.edge) {
        let PoseGraphEdge { from, to, from_from_to, information } = verified.edge;
        assert!(from < to && information.cholesky().is_some(), "{verified:?}");
        let truth = robot.keyframes[from.0 as usize].inverse() * robot.keyframes[to.0 as usize];
        let error = se3::local(&truth, &from_from_to);
        assert!(error.fixed_rows::<3>(3).norm() < 0.06 && error.norm() < 0.08, "{verified:?} {error}");
        loops.push((from, to));
    }
    assert!(loops.len() <= after[3], "{} edges", loops.len());
}

#[test]
fn a_room_behind_a_wall_is_new_ground() {
    let mut world = room([-12.0, -1.2], [12.0, 1.8]);
    world.push([[-12.0, 0.2, -0.5], [12.0, 0.4, 2.5]]);
    let mut robot = Robot::new(world, 0.0);
    for x in -8..=8 {
        robot.walk(&at(f64::from(x), -0.4, 0.0));
    }
    let keyframes = robot.keyframes.len();
    assert_eq!(keyframes, 17);
    // In the odometry frame the robot was carried 1.4 m sideways, through the wall.
    for x in (-8..=8).rev() {
        robot.walk(&at(f64::from(x), 1.0, std::f64::consts::PI));
    }
    assert!(robot.keyframes.len() >= 2 * keyframes - 1, "{}", robot.keyframes.len());
}

#[test]
fn a_finished_map_is_extended_from_the_pose_where_the_robot_localises() {
    // Two sides of the ring. Each walk has its own odometry errors.
    let poses = ring_poses(0.0);
    let mut first = Robot::new(ring(), 0.0);
    poses[..30].iter().for_each(|pose| first.walk(pose));
    assert_eq!(first.keyframes.len(), 30);
    let mut downsampler = points::Downsampler::default();
    let mut old = |(number, pose): (usize, &Isometry)| {
        let cloud = scan(&first.world, pose, number as u64);
        let descriptor = KeyframeDescriptor::new(&cloud, &pose.rotation, SENSOR, &mut downsampler);
        MapKeyframe { map_from_keyframe: *pose, descriptor }
    };
    let map: Vec<MapKeyframe> = poses[..30].iter().enumerate().map(&mut old).collect();
    let edges: Vec<PoseGraphEdge> = (1..30)
        .map(|to: u32| {
            let motion = poses[to as usize - 1].inverse() * poses[to as usize];
            edge(to - 1, to, motion, (2e-3, 0.01))
        })
        .collect();
    let mut robot = Robot::new(ring(), 2e-4);
    let nodes = (0..).zip(&poses[..30]).map(|(id, pose)| PoseGraphNode {
        id: KeyframeId(id),
        stamp: Stamp::EPOCH,
        map_from_keyframe: *pose,
    });
    let Ok(graph) = PoseGraph::resume(nodes.collect(), edges, Vec::new(), OptimiserConfig::default()) else {
        panic!("the graph was not resumed")
    };
    robot.graph = graph;
    robot.finder = LoopFinder::resume(LoopConfig::default(), &map, &mut robot.graph);
    robot.keyframes = poses[..30].to_vec();
    // The robot is not localised yet, so no keyframes are added.
    for pose in &poses[20..23] {
        assert!(matches!(robot.ground(pose), Novelty::Unlocalised(_)));
    }
    let found =
        UncertainPose { pose: poses[21].inverse() * poses[21], covariance: Matrix6::identity() * 1e-4 };
    assert_eq!(robot.finder.localise_in_map(1, KeyframeId(90), &found), None);
    let Some(now) = robot.finder.localise_in_map(1, KeyframeId(21), &found) else {
        panic!("the robot was not localised in the map")
    };
    assert!(robot.true_error(KeyframeId(21), 2, &now) < 0.02);
    for pose in &poses[23..] {
        robot.walk(pose);
    }
    // Along the other two sides and back to the start.
    assert!(
        (poses.len() - 3..=poses.len() + 2).contains(&robot.keyframes.len()),
        "{}",
        robot.keyframes.len()
    );
    let closed = robot.decisions.iter().filter(|decision| decision.verdict == Verdict::Accepted);
    for decision in closed {
        let PoseGraphEdge { from, to, from_from_to, .. } = decision.edge;
        let truth = robot.keyframes[from.0 as usize].inverse() * robot.keyframes[to.0 as usize];
        assert!((truth.inverse() * from_from_to).translation.vector.norm() < 0.05, "{decision:?}");
    }
}

/// One round of the ring and four more waypoints on known ground, whose comparisons are still pending.
fn returned() -> (Robot, Vec<Revisit>) {
    let mut robot = Robot::new(ring(), 5e-4);
    ring_poses(0.0).iter().for_each(|pose| robot.walk(pose));
    let mut revisits = Vec::new();
    for pose in &ring_poses(0.1)[..4] {
        revisits.extend(robot.arrive(pose));
    }
    assert_eq!(revisits.len(), 2);
    (robot, revisits)
}

#[test]
fn late_results_do_not_change_newer_ones() {
    let (mut robot, revisits) = returned();
    let last = revisits.len() - 1;
    let (RevisitResult::Reanchored(reanchoring), newest) =
        (robot.complete(&revisits[last]), robot.walked.len() - 1)
    else {
        panic!("the last revisit was not reanchored")
    };
    let error = robot.true_error(reanchoring.anchor, newest, &reanchoring.anchor_from_waypoint);
    assert!(error < 0.05, "{error} m at the newest waypoint");
    assert_eq!(robot.complete(&revisits[last - 1]), RevisitResult::Confirmed);
    assert_eq!(
        robot.complete(&revisits[last]),
        RevisitResult::Rejected,
        "a second result of the same revisit must be rejected"
    );
}

#[test]
fn unexpected_results_are_rejected() {
    let spoil: [fn(&mut ComparisonResult); 3] = [
        |compared| compared.pose.translation.vector.x += 1.5,
        |compared| compared.rejection = Some(crate::RejectionReason::Overlap),
        |compared| compared.pose.translation.vector.x = f64::NAN,
    ];
    let (robot, revisits) = returned();
    let compared = compare(&revisits[0].comparison, &robot.finder.config().verification);
    for spoil in spoil {
        let (mut finder, mut spoilt) = (robot.finder.clone(), compared);
        spoil(&mut spoilt);
        assert_eq!(
            finder.complete_revisit(&robot.graph, revisits[0].waypoint, &spoilt),
            RevisitResult::Rejected,
            "{spoilt:?}"
        );
    }
    assert!(matches!(
        robot.finder.clone().complete_revisit(&robot.graph, revisits[0].waypoint, &compared),
        RevisitResult::Reanchored(_)
    ));
}

#[test]
fn unconfirmed_ground_is_mapped_again() {
    let (mut robot, _) = returned();
    let before = robot.keyframes.len();
    // No comparison is completed.
    for pose in &ring_poses(0.1)[4..40] {
        robot.arrive(pose);
    }
    assert!(robot.keyframes.len() > before, "{before}");
}

#[test]
fn a_revisit_compared_after_known_ground_was_left_is_a_loop() {
    let (mut robot, revisits) = returned();
    let last = &revisits[revisits.len() - 1];
    let compared = compare(&last.comparison, &robot.finder.config().verification);
    // The robot moves until it adds a keyframe.
    let before = robot.keyframes.len();
    let mut pose = robot.walked[robot.walked.len() - 1];
    while robot.keyframes.len() == before {
        pose *= at(0.1, 0.0, 0.0);
        let unconfirmed = pose;
        robot.finder.expire_confirmation();
        robot.arrive(&unconfirmed);
    }
    let result = robot.finder.complete_revisit(&robot.graph, last.waypoint, &compared);
    let RevisitResult::Loop(verified) = result else { panic!("{result:?}, {compared:?}") };
    let truth = robot.keyframes[verified.edge.from.0 as usize].inverse() * robot.keyframes[before];
    let error = (truth.inverse() * verified.edge.from_from_to).translation.vector.norm();
    assert!(verified.edge.to.0 as usize == before && error < 0.05, "{verified:?} {error}");
    let decided = robot.finder.evaluate(&mut robot.graph, &verified);
    assert!(decided.iter().any(|decision| decision.verdict == Verdict::Accepted), "{decided:?}");
    assert_ne!(verified.edge.information, Matrix6::zeros());
}

impl LoopFinder {
    /// Sets the state that arises when no comparison has succeeded for a long distance.
    fn expire_confirmation(&mut self) {
        if let Some(position) = &mut self.revisits.position {
            position.unconfirmed_m = 2.0 * self.config.revisits.max_unconfirmed_m;
        }
    }
}
