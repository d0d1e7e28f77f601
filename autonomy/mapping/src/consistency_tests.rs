//! Loops that bend the map and loops that must not.

use super::*;
use crate::testing::{at, edge};
use crate::verify::CandidateSource;

/// Deviations of odometry's edges, radians and metres a step.
const STEP: (f64, f64) = (1e-3, 5e-3);
/// Of loops.
const LOOP: (f64, f64) = (3e-3, 0.02);

fn verified(edge: Edge) -> VerifiedPair {
    let evidence = Evidence {
        source: CandidateSource::Geometry,
        score: 0.9,
        overlap: [0.9; 2],
        residual: 0.02,
        through: [0.01; 2],
        rival: 0.0,
        blind: 0,
        grip: 0.1,
        moved: (0.1, 0.01),
        surprise: None,
    };
    VerifiedPair { edge, evidence, rejection: None }
}

/// A consistency that walked along poses with steps of those deviations.
fn walked(poses: &[Isometry], step: (f64, f64)) -> LoopConsistencyCheck {
    let mut consistency = LoopConsistencyCheck::new(ConsistencyConfig::default());
    for (index, pair) in (0..).zip(poses.windows(2)) {
        consistency.add_keyframe(&edge(index, index + 1, pair[0].inverse() * pair[1], step));
    }
    consistency
}

/// Straight on for 50 m, and back 1 m beside.
fn there_and_back() -> Vec<Isometry> {
    let there = (0..50).map(|i| at(f64::from(i), 0.0, 0.0));
    let back = (0..50).rev().map(|i| at(f64::from(i), 1.0, std::f64::consts::PI));
    there.chain(back).collect()
}

fn accepted(decisions: &[Decision]) -> usize {
    decisions.iter().filter(|d| d.verdict == Verdict::Accepted).count()
}

#[test]
fn a_loop_where_the_graph_expects_it_is_accepted_and_makes_it_surer() {
    let poses = there_and_back();
    let mut consistency = walked(&poses, STEP);
    let deviation = |consistency: &LoopConsistencyCheck| {
        consistency.reach(KeyframeId(0))[99].map_or(f64::NAN, |way| way.translation_std_m())
    };
    let before = deviation(&consistency);
    let right = edge(0, 99, poses[0].inverse() * poses[99], LOOP);
    let decisions = consistency.evaluate(&verified(right));
    assert_eq!(decisions.iter().map(|d| d.verdict).collect::<Vec<_>>(), [Verdict::Accepted]);
    assert!(deviation(&consistency) < 0.3 * before, "{before} {}", deviation(&consistency));
    // A person may take it back, but not the walk.
    assert!(
        consistency.remove_loop(KeyframeId(0), KeyframeId(99))
            && !consistency.remove_loop(KeyframeId(4), KeyframeId(5))
    );
    assert!((deviation(&consistency) - before).abs() < 1e-12);
}

#[test]
fn a_rejected_pair_is_reported_with_its_reason() {
    let poses = there_and_back();
    let mut consistency = walked(&poses, STEP);
    let mut pair = verified(edge(0, 99, poses[0].inverse() * poses[99], LOOP));
    pair.rejection = Some(RejectionReason::FreeSpaceViolation);
    assert_eq!(
        consistency.evaluate(&pair)[0].verdict,
        Verdict::Rejected(RejectionReason::FreeSpaceViolation)
    );
    assert_eq!(consistency.waiting(), 0);
}

/// Two rooms built alike: every loop between them is off by the same 30 m, so all of them agree with each other.
#[test]
fn rooms_built_alike_stay_apart_however_many_loops_agree() {
    for step in [STEP, (3e-3, 0.05), (0.01, 0.3)] {
        let poses: Vec<Isometry> = (0..60).map(|i| at(f64::from(i), 0.0, 0.0)).collect();
        let mut consistency = walked(&poses, step);
        let before = consistency.reach(KeyframeId(5))[35];
        let mut decisions = Vec::new();
        for i in 0..12 {
            // What registration says: the robot is where it was 30 m before.
            decisions.extend(consistency.evaluate(&verified(edge(
                5 + i,
                35 + i,
                Isometry::identity(),
                LOOP,
            ))));
        }
        assert_eq!(accepted(&decisions), 0, "{step:?}");
        assert_eq!(consistency.reach(KeyframeId(5))[35], before, "the graph is as it was");
        // A person says no to one and yes to another: neither waits on.
        let waiting = consistency.waiting();
        assert!(
            consistency.remove_loop(KeyframeId(5), KeyframeId(35))
                && !consistency.remove_loop(KeyframeId(5), KeyframeId(35))
        );
        assert!(consistency.accept(&edge(6, 36, Isometry::identity(), LOOP)));
        assert_eq!(consistency.waiting(), waiting - 2);
        assert_ne!(consistency.reach(KeyframeId(5))[35], before);
    }
}

#[test]
fn where_the_graph_is_vague_three_loops_must_agree() {
    let poses = there_and_back();
    let mut consistency = walked(&poses, (0.01, 0.1));
    // The truth is half a deviation off.
    let truth = |i: u32| {
        let newer = 99 - i;
        let moved = poses[newer as usize].translation.vector + Vector3::new(0.3, 0.4, 0.0);
        let pose = Isometry::from_parts(moved.into(), poses[newer as usize].rotation);
        verified(edge(i, newer, poses[i as usize].inverse() * pose, LOOP))
    };
    // One that is wrong by 4 m agrees with the vague graph as well, but with no other.
    let mut wrong = truth(2);
    wrong.edge.from_from_to.translation.vector.x += 4.0;
    assert_eq!(consistency.evaluate(&wrong)[0].verdict, Verdict::Held);
    assert_eq!(consistency.evaluate(&truth(0))[0].verdict, Verdict::Held);
    // The same place once more is no support.
    assert_eq!(accepted(&consistency.evaluate(&truth(1))), 0);
    let decisions = consistency.evaluate(&truth(3));
    assert_eq!(accepted(&decisions), 3, "{decisions:?}");
    assert!(decisions.iter().all(|d| d.edge != wrong.edge && d.agreeing >= 3));
    assert_eq!(consistency.waiting(), 1, "the wrong one still waits");
    // And will be dropped one day.
    assert_ne!(consistency.evaluate(&wrong)[0].verdict, Verdict::Accepted);
}

#[test]
fn a_slip_that_odometry_did_not_notice_is_mended_by_many_loops_from_far_apart() {
    let poses = there_and_back();
    let mut consistency = walked(&poses, STEP);
    // The robot slipped by half a metre at the turn; odometry claims a few centimetres.
    let slipped = |i: u32| {
        let newer = (99 - i) as usize;
        let moved = poses[newer].translation.vector + Vector3::new(0.0, 0.5, 0.0);
        let pose = Isometry::from_parts(moved.into(), poses[newer].rotation);
        verified(edge(i, 99 - i, poses[i as usize].inverse() * pose, LOOP))
    };
    let mut found = 0;
    let mut needed = 0;
    for i in (0..40).rev().step_by(2) {
        found += accepted(&consistency.evaluate(&slipped(i)));
        needed += u32::from(found == 0);
    }
    assert!(needed >= 9, "held until they are 18 m apart: {needed}");
    assert!(found >= 10, "{found} accepted");
}

#[test]
fn garbage_is_held_and_the_oldest_dropped() {
    let mut consistency = walked(&there_and_back(), STEP);
    let mut dropped = 0;
    for i in 0..90 {
        let mut pair = verified(edge(i % 40, 99 - i % 40, at(f64::NAN, 0.0, 0.0), LOOP));
        pair.edge.information[(0, 0)] = f64::NAN;
        let decisions = consistency.evaluate(&pair);
        assert_eq!(accepted(&decisions), 0);
        dropped += decisions.iter().filter(|d| d.verdict == Verdict::Dropped).count();
    }
    assert_eq!((consistency.waiting(), dropped), (WAITING, 90 - WAITING));
    let unknown = verified(edge(7, 4_000, Isometry::identity(), LOOP));
    assert_eq!(accepted(&consistency.evaluate(&unknown)), 0, "a keyframe that is not there");
    assert!(!consistency.accept(&unknown.edge) && consistency.reach(KeyframeId(0)).len() == 100);
}
