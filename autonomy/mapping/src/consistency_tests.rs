//! Which loops may deform the map, and which may not.

use super::*;
use crate::testing::{at, edge};
use crate::verification::CandidateSource;
use vocab::Stamp;

/// Greatest number of held loops.
const MAX_HELD: usize = 64;
/// Standard deviations of odometry edges, radians and metres per step.
const STEP: (f64, f64) = (1e-3, 5e-3);
/// Standard deviations of loops, radians and metres.
const LOOP: (f64, f64) = (3e-3, 0.02);

fn verified(edge: PoseGraphEdge) -> VerifiedPair {
    let evidence = PairEvidence {
        source: CandidateSource::Geometry,
        score: 0.9,
        overlap: [0.9; 2],
        residual_m: 0.02,
        free_space_violation: [0.01; 2],
        runner_up_ratio: 0.0,
        degenerate_directions: 0,
        conditioning: 0.1,
        correction_m: 0.1,
        correction_rad: 0.01,
        mahalanobis_squared: None,
    };
    VerifiedPair { edge, evidence, rejection: None }
}

/// A graph with its consistency check.
struct Bench {
    graph: PoseGraph,
    check: LoopConsistencyCheck,
}

impl Bench {
    /// A graph along `poses`, whose steps have these standard deviations.
    fn walked(poses: &[Isometry], step: (f64, f64)) -> Self {
        let (mut graph, check) = (PoseGraph::default(), LoopConsistencyCheck::default());
        graph.add_keyframe(Stamp::EPOCH, &poses[0], None);
        for (index, pair) in (0..).zip(poses.windows(2)) {
            let relative = pair[0].inverse() * pair[1];
            graph.add_distance(relative.translation.vector.norm());
            graph.add_keyframe(Stamp::EPOCH, &pair[1], Some(&edge(index, index + 1, relative, step)));
        }
        Self { graph, check }
    }

    fn evaluate(&mut self, pair: &VerifiedPair) -> Vec<Decision> {
        self.check.evaluate(&mut self.graph, pair)
    }

    fn remove_loop(&mut self, from: u32, to: u32) -> bool {
        self.check.remove_loop(&mut self.graph, KeyframeId(from), KeyframeId(to))
    }

    fn accept(&mut self, edge: &PoseGraphEdge) -> bool {
        self.check.accept(&mut self.graph, edge)
    }

    fn poses_in(&self, keyframe: u32) -> Vec<Option<UncertainPose>> {
        self.graph.poses_in(KeyframeId(keyframe))
    }
}

/// 50 m straight ahead, and back at a lateral distance of 1 m.
fn there_and_back() -> Vec<Isometry> {
    let there = (0..50).map(|i| at(f64::from(i), 0.0, 0.0));
    let back = (0..50).rev().map(|i| at(f64::from(i), 1.0, std::f64::consts::PI));
    there.chain(back).collect()
}

fn accepted(decisions: &[Decision]) -> usize {
    decisions.iter().filter(|d| d.verdict == Verdict::Accepted).count()
}

#[test]
fn an_expected_loop_is_accepted_and_lowers_the_uncertainty() {
    let poses = there_and_back();
    let mut bench = Bench::walked(&poses, STEP);
    let deviation = |bench: &Bench| bench.poses_in(0)[99].map_or(f64::NAN, |pose| pose.translation_std_m());
    let before = deviation(&bench);
    let right = edge(0, 99, poses[0].inverse() * poses[99], LOOP);
    let decisions = bench.evaluate(&verified(right));
    assert_eq!(decisions.iter().map(|d| d.verdict).collect::<Vec<_>>(), [Verdict::Accepted]);
    assert!(deviation(&bench) < 0.3 * before, "{before} {}", deviation(&bench));
    // A person may remove the loop, but no odometry edge.
    assert!(bench.remove_loop(0, 99) && !bench.remove_loop(4, 5));
    assert!((deviation(&bench) - before).abs() < 1e-12);
}

#[test]
fn a_rejected_pair_is_reported_with_its_reason() {
    let poses = there_and_back();
    let mut bench = Bench::walked(&poses, STEP);
    let mut pair = verified(edge(0, 99, poses[0].inverse() * poses[99], LOOP));
    pair.rejection = Some(RejectionReason::FreeSpaceViolation);
    assert_eq!(bench.evaluate(&pair)[0].verdict, Verdict::Rejected(RejectionReason::FreeSpaceViolation));
    assert_eq!(bench.check.held_count(), 0);
}

/// Two identical rooms. Every loop between them is wrong by the same 30 m, so all of them agree with each other.
#[test]
fn loops_between_identical_rooms_are_never_accepted_even_if_many_agree() {
    for step in [STEP, (3e-3, 0.05), (0.01, 0.3)] {
        let poses: Vec<Isometry> = (0..60).map(|i| at(f64::from(i), 0.0, 0.0)).collect();
        let mut bench = Bench::walked(&poses, step);
        let before = bench.poses_in(5)[35];
        let mut decisions = Vec::new();
        for i in 0..12 {
            // Registration finds the robot at its pose of 30 m before.
            decisions.extend(bench.evaluate(&verified(edge(5 + i, 35 + i, Isometry::identity(), LOOP))));
        }
        assert_eq!(accepted(&decisions), 0, "{step:?}");
        assert_eq!(bench.poses_in(5)[35], before, "the graph must not change");
        // A person rejects one loop and accepts another. Neither is held any more.
        let waiting = bench.check.held_count();
        assert!(bench.remove_loop(5, 35) && !bench.remove_loop(5, 35));
        assert!(bench.accept(&edge(6, 36, Isometry::identity(), LOOP)));
        assert_eq!(bench.check.held_count(), waiting - 2);
        assert_ne!(bench.poses_in(5)[35], before);
    }
}

#[test]
fn an_uncertain_graph_needs_three_agreeing_loops() {
    let poses = there_and_back();
    let mut bench = Bench::walked(&poses, (0.01, 0.1));
    // The true pose is half a standard deviation away from the graph's.
    let truth = |i: u32| {
        let newer = 99 - i;
        let moved = poses[newer as usize].translation.vector + Vector3::new(0.3, 0.4, 0.0);
        let pose = Isometry::from_parts(moved.into(), poses[newer as usize].rotation);
        verified(edge(i, newer, poses[i as usize].inverse() * pose, LOOP))
    };
    // A loop that is wrong by 4 m also agrees with the uncertain graph, but with no other loop.
    let mut wrong = truth(2);
    wrong.edge.from_from_to.translation.vector.x += 4.0;
    assert_eq!(bench.evaluate(&wrong)[0].verdict, Verdict::Held);
    assert_eq!(bench.evaluate(&truth(0))[0].verdict, Verdict::Held);
    // A second loop at the same place is not independent support.
    assert_eq!(accepted(&bench.evaluate(&truth(1))), 0);
    let decisions = bench.evaluate(&truth(3));
    assert_eq!(accepted(&decisions), 3, "{decisions:?}");
    assert!(decisions.iter().all(|d| d.edge != wrong.edge && d.agreeing >= 3));
    assert_eq!(bench.check.held_count(), 1, "the wrong loop must still be held");
    // The wrong loop must never be accepted.
    assert_ne!(bench.evaluate(&wrong)[0].verdict, Verdict::Accepted);
}

#[test]
fn an_unnoticed_slip_is_corrected_by_many_loops_from_far_apart() {
    let poses = there_and_back();
    let mut bench = Bench::walked(&poses, STEP);
    // The robot slipped by half a metre at the turn. The odometry reports a deviation of a few centimetres.
    let slipped = |i: u32| {
        let newer = (99 - i) as usize;
        let moved = poses[newer].translation.vector + Vector3::new(0.0, 0.5, 0.0);
        let pose = Isometry::from_parts(moved.into(), poses[newer].rotation);
        verified(edge(i, 99 - i, poses[i as usize].inverse() * pose, LOOP))
    };
    let mut found = 0;
    let mut needed = 0;
    for i in (0..40).rev().step_by(2) {
        found += accepted(&bench.evaluate(&slipped(i)));
        needed += u32::from(found == 0);
    }
    assert!(needed >= 9, "loops must be held until they span 18 m: {needed}");
    assert!(found >= 10, "{found} accepted");
}

#[test]
fn invalid_loops_are_held_and_the_oldest_is_dropped() {
    let mut bench = Bench::walked(&there_and_back(), STEP);
    let mut dropped = 0;
    for i in 0..90 {
        let mut pair = verified(edge(i % 40, 99 - i % 40, at(f64::NAN, 0.0, 0.0), LOOP));
        pair.edge.information[(0, 0)] = f64::NAN;
        let decisions = bench.evaluate(&pair);
        assert_eq!(accepted(&decisions), 0);
        dropped += decisions.iter().filter(|d| d.verdict == Verdict::Dropped).count();
    }
    assert_eq!((bench.check.held_count(), dropped), (MAX_HELD, 90 - MAX_HELD));
    let unknown = verified(edge(7, 4_000, Isometry::identity(), LOOP));
    assert_eq!(accepted(&bench.evaluate(&unknown)), 0, "a loop to an unknown keyframe must not be accepted");
    assert!(!bench.accept(&unknown.edge) && bench.poses_in(0).len() == 100);
}
