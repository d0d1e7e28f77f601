//! Two identical rooms. The walk enters the first, then the second, then the first again.

use crate::support::{Walk, walk};
use mapping::{Decision, LoopConfig, LoopFinder, NewKeyframe, PoseGraph, PoseGraphEdge, Verdict, verify};
use sim::{SiteName, SiteRoute, Start};
use std::sync::OnceLock;
use vocab::Vec3;

/// Distance between the rooms, metres.
const APART: f64 = 34.0;

fn twins() -> &'static Walk {
    static WALK: OnceLock<Walk> = OnceLock::new();
    WALK.get_or_init(|| {
        let look = |west: f64| {
            [[3.0, -1.5], [3.0, 2.4], [11.3, 2.4], [11.3, 7.0], [11.3, 2.4], [3.0, 2.4], [3.0, -1.5]]
                .map(|[x, y]| [west + x, y])
        };
        let waypoints = [look(6.0), look(6.0 + APART), look(6.0)].concat();
        let start = Start { position: Vec3::new(3.0, -1.5, 0.0), yaw: 0.0 };
        walk(SiteName::Twins, SiteRoute { name: "twice the first", start, waypoints, speed: 1.1 })
    })
}

/// Finds loops. The odometry's standard deviations are multiplied by `doubt`.
fn decide(walk: &Walk, doubt: f64) -> Vec<Decision> {
    let (mut finder, mut graph) = (LoopFinder::new(LoopConfig::default()), PoseGraph::default());
    let doubted =
        |edge: &PoseGraphEdge| PoseGraphEdge { information: edge.information / (doubt * doubt), ..*edge };
    let edges: Vec<PoseGraphEdge> = walk.edges.iter().map(doubted).collect();
    let mut decisions = Vec::new();
    for (index, keyframe) in walk.keyframes.iter().enumerate() {
        let tasks = finder.add_keyframe(
            &mut graph,
            &NewKeyframe {
                edge: index.checked_sub(1).map(|last| &edges[last]),
                rotation: keyframe.odom_from_base.rotation,
                xyz: &keyframe.cloud,
                sensor: [0.07, 0.005, 0.31],
            },
        );
        for task in tasks {
            decisions.extend(finder.evaluate(&mut graph, &verify(&task, &finder.config().verification)));
        }
    }
    decisions
}

/// True distance between the two keyframes of a decision, and the error of the decision's pose, metres.
fn truth(walk: &Walk, decision: &Decision) -> (f64, f64) {
    let [from, to] =
        [decision.edge.from, decision.edge.to].map(|k| walk.keyframes[k.0 as usize].site_from_base);
    let relative = from.inverse() * to;
    let error = relative.inverse() * decision.edge.from_from_to;
    (relative.translation.vector.norm(), error.translation.vector.norm())
}

#[test]
fn loops_are_accepted_in_the_first_room_and_none_between_the_rooms() {
    let walk = twins();
    let accepted: Vec<Decision> =
        decide(walk, 1.0).into_iter().filter(|d| d.verdict == Verdict::Accepted).collect();
    assert!(accepted.len() >= 12, "{}", accepted.len());
    for decision in &accepted {
        let (apart, error) = truth(walk, decision);
        assert!(apart < 4.0 && error < 0.03, "{apart} {error} {decision:?}");
    }
    // At least five of the loops must lie deep inside the room, not only at its door.
    let inside = |d: &&Decision| walk.keyframes[d.edge.to.0 as usize].site_from_base.translation.y > 2.0;
    assert!(accepted.iter().filter(inside).count() >= 5);
}

#[test]
fn with_uncertain_odometry_pairs_between_the_rooms_are_verified_but_not_accepted() {
    let walk = twins();
    let decisions = decide(walk, 25.0);
    let alike = |d: &&Decision| truth(walk, d).0 > 0.8 * APART;
    let taken_for_the_other = decisions.iter().filter(alike).filter(|d| d.verdict == Verdict::Held).count();
    assert!(taken_for_the_other > 0, "no pair between the rooms was held, so the test proves nothing");
    for decision in decisions.iter().filter(|d| d.verdict == Verdict::Accepted) {
        let (apart, error) = truth(walk, decision);
        assert!(apart < 6.0 && error < 0.2, "{apart} {error} {decision:?}");
    }
}
