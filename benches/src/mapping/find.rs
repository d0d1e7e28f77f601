//! The loop finder run over a recorded walk, with the time each part takes.

use crate::walk::Recorded;
use geometry::{Isometry, Matrix6, RngTree, Vector6, se3};
use mapping::{
    Decision, Edge, LoopConfig, LoopFinder, NewKeyframe, PoseGraph, ScanPose, Session, SessionConfig, verify,
};
use std::time::Instant;

/// The LiDAR of the simulated robot, base frame, metres.
const SENSOR: [f32; 3] = [0.07, 0.005, 0.31];

/// What came out.
#[derive(Debug)]
pub struct Found {
    /// As it was after the last keyframe.
    pub finder: LoopFinder,
    /// The graph as it was then.
    pub graph: PoseGraph,
    /// Of the odometry, made worse as told.
    pub edges: Vec<Edge>,
    pub decisions: Vec<Decision>,
    /// Milliseconds a keyframe: taking it in (cloud, descriptor, search, submaps), and each verification and judgement.
    pub insert_keyframe: Vec<f64>,
    pub verify: Vec<f64>,
    pub judge: Vec<f64>,
    pub submap_bytes: usize,
}

/// Makes odometry worse: deviation per square root of a metre at strength 1, radians and metres. About 3 m over 500 m.
const DRIFT: (f64, f64) = (3e-3, 2e-2);
/// Errors of odometry are steady over stretches of about this length, metres; a random walk would crumple every submap.
const STEADY: f64 = 50.0;

/// Runs over a walk whose odometry is made worse by `drift` (0 leaves it, 1 adds [`DRIFT`]), which the edges own up to.
pub fn find(recorded: &[Recorded], drift: f64, seed: u64, config: LoopConfig) -> Found {
    let mut found = Found {
        finder: LoopFinder::new(config),
        graph: PoseGraph::default(),
        edges: edges(recorded, drift, seed),
        decisions: Vec::new(),
        insert_keyframe: Vec::new(),
        verify: Vec::new(),
        judge: Vec::new(),
        submap_bytes: 0,
    };
    let (finder, graph) = (&mut found.finder, &mut found.graph);
    for (index, keyframe) in recorded.iter().enumerate() {
        let began = Instant::now();
        let tasks = finder.add_keyframe(
            graph,
            &NewKeyframe {
                edge: index.checked_sub(1).and_then(|last| found.edges.get(last)),
                rotation: keyframe.odom_from_base.rotation,
                xyz: &keyframe.cloud,
                sensor: SENSOR,
            },
        );
        found.insert_keyframe.push(milliseconds(began));
        for task in tasks {
            let began = Instant::now();
            let verified = verify(&task, &config.verification);
            found.verify.push(milliseconds(began));
            let began = Instant::now();
            found.decisions.extend(finder.evaluate(graph, &verified));
            found.judge.push(milliseconds(began));
        }
        found.submap_bytes = found.submap_bytes.max(finder.submap_bytes());
    }
    found
}

/// The odometry's edges, as a session makes them.
fn edges(recorded: &[Recorded], drift: f64, seed: u64) -> Vec<Edge> {
    let Some(first) = recorded.first() else { return Vec::new() };
    let mut session = Session::begin(&first.odom_from_base, SessionConfig::default(), PoseGraph::default());
    for keyframe in recorded {
        session.add_scan(&ScanPose {
            stamp: keyframe.stamp,
            odom_from_base: keyframe.odom_from_base,
            scan_stamp: keyframe.stamp,
            odom_from_base_at_scan: keyframe.odom_from_base,
            covariance: keyframe.covariance,
            covariance_inflation: Matrix6::zeros(),
            is_degenerate: keyframe.degenerate,
            is_dead_reckoned: false,
        });
    }
    let mut rng = RngTree::new(seed).child("drift").rng();
    let (mut bias, mut walked) = (Vector6::zeros(), f64::INFINITY);
    let mut worsen = |edge: &Edge| {
        walked += edge.from_from_to.translation.vector.norm();
        if walked >= STEADY {
            (bias, walked) = (Vector6::from_fn(|_, _| rng.normal()), 0.0);
        }
        worsened(edge, drift, &bias)
    };
    session.graph().edges().iter().map(&mut worsen).collect()
}

/// An edge off by its share of a steady error, and the covariance of a random walk that goes as far over [`STEADY`].
fn worsened(edge: &Edge, drift: f64, bias: &Vector6) -> Edge {
    if drift == 0.0 {
        return *edge;
    }
    let length = edge.from_from_to.translation.vector.norm().max(0.2);
    // Gravity keeps roll and pitch a good deal better.
    let deviations = Vector6::new(0.1, 0.1, 1.0, 0.0, 0.0, 0.0) * (DRIFT.0 * drift * length.sqrt())
        + Vector6::new(0.0, 0.0, 0.0, 1.0, 1.0, 0.5) * (DRIFT.1 * drift * length.sqrt());
    let error = deviations.component_mul(bias) * (length / STEADY).sqrt();
    let added = Matrix6::from_diagonal(&deviations.component_mul(&deviations));
    let covariance = edge.information.try_inverse().unwrap_or_else(Matrix6::identity) + added;
    let from_from_to: Isometry = se3::retract(&edge.from_from_to, &error);
    Edge { from_from_to, information: covariance.try_inverse().unwrap_or(edge.information), ..*edge }
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
