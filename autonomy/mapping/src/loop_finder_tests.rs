//! Tests of loop finding as a whole, in a ring of corridors around a block.

use super::*;
use crate::testing::{SENSOR, at, edge, ring, ring_poses, scan};
use crate::verify;
use std::sync::OnceLock;

/// Two rounds. The second one runs 0.3 m beside the first.
fn poses() -> Vec<Isometry> {
    [ring_poses(0.0), ring_poses(0.3)].concat()
}

struct Walked {
    decisions: Vec<Decision>,
    finder: LoopFinder,
    graph: PoseGraph,
}

/// Walks the ring. The odometry rotates too far by `bias` radians per step.
fn walk(bias: f64) -> Walked {
    let (world, poses) = (ring(), poses());
    let (mut finder, mut graph) = (LoopFinder::new(LoopConfig::default()), PoseGraph::default());
    let mut decisions = Vec::new();
    for (index, pose) in poses.iter().enumerate() {
        let step = index.checked_sub(1).map(|last| {
            let motion = poses[last].inverse() * pose * at(0.0, 0.0, bias);
            edge(last as u32, index as u32, motion, (2e-3, 0.01))
        });
        let cloud = scan(&world, pose, index as u64);
        let tasks = finder.add_keyframe(
            &mut graph,
            &NewKeyframe { edge: step.as_ref(), rotation: pose.rotation, xyz: &cloud, sensor: SENSOR },
        );
        assert!(tasks.len() <= 4, "{} pairs at once", tasks.len());
        for task in tasks {
            decisions.extend(finder.evaluate(&mut graph, &verify(&task, &finder.config().verification)));
        }
    }
    Walked { decisions, finder, graph }
}

fn walked() -> &'static Walked {
    static WALKED: OnceLock<Walked> = OnceLock::new();
    WALKED.get_or_init(|| walk(1e-3))
}

#[test]
fn loops_join_the_second_round_to_the_first_and_nothing_else() {
    let (poses, walked) = (poses(), walked());
    let mut closed = Vec::new();
    for decision in walked.decisions.iter().filter(|d| d.verdict == Verdict::Accepted) {
        let [from, to] = [decision.edge.from, decision.edge.to].map(|k| k.0 as usize);
        let error = (poses[from].inverse() * poses[to]).inverse() * decision.edge.from_from_to;
        assert!(
            error.translation.vector.norm() < 0.05 && error.rotation.angle() < 0.02,
            "{decision:?} {error}"
        );
        closed.push(to);
    }
    // After one round (50 m) there must be a loop every few metres.
    let open = (50..poses.len()).filter(|newer| !closed.iter().any(|to| to.abs_diff(*newer) <= 4)).count();
    assert!(open <= 2, "{open} keyframes far from any loop; closed {closed:?}");
    assert!(closed.iter().all(|to| *to >= 43), "{closed:?}");
}

#[test]
fn equal_walks_give_equal_bits() {
    let (once, again) = (walked(), walk(1e-3));
    assert_eq!(once.decisions, again.decisions);
    assert!(walk(2e-3).decisions != again.decisions, "another walk must give other decisions");
}

#[test]
fn a_proposed_pair_is_verified_and_unknown_keyframes_are_not() {
    let mut finder = walked().finder.clone();
    let poses = poses();
    let guess = poses[14].inverse() * poses[62];
    let task = finder.propose(&walked().graph, KeyframeId(14), KeyframeId(62), guess);
    let Some(task) = task else { panic!("both keyframes are there") };
    let found = verify(&task, &VerificationConfig::default());
    assert_eq!((found.rejection, found.evidence.source), (None, CandidateSource::Person));
    assert!(finder.propose(&walked().graph, KeyframeId(14), KeyframeId(4_000), guess).is_none());
}

#[test]
fn an_empty_ring_has_no_dynamic_points() {
    let (world, poses) = (ring(), poses());
    let cloud = scan(&world, &poses[30], 30);
    let dropped = walked().finder.dynamic_points(&walked().graph, KeyframeId(30), &cloud);
    assert!(dropped.len() * 200 < cloud.len(), "{} of {}", dropped.len(), cloud.len());
    assert!(walked().finder.dynamic_points(&walked().graph, KeyframeId(4_000), &cloud).is_empty());
}
