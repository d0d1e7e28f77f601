//! Runs the loop finder over a recorded walk and measures the time of each part.

use crate::recorded_walk::RecordedKeyframe;
use benches::keyframe_policy;
use geometry::{Isometry, Matrix6, RngTree, Vector6, se3};
use mapping::{
    Decision, LoopConfig, LoopFinder, NewKeyframe, PoseGraph, PoseGraphEdge, ScanPose, Session,
    SessionConfig, verify,
};
use std::time::Instant;

/// Position of the LiDAR of the simulated robot, base frame, metres.
const LIDAR_POSITION_M: [f32; 3] = [0.07, 0.005, 0.31];

/// The results of a run.
#[derive(Debug)]
pub struct LoopFinderRun {
    /// The loop finder after the last keyframe.
    pub finder: LoopFinder,
    /// The pose graph after the last keyframe.
    pub graph: PoseGraph,
    /// Edges of the odometry, with the added drift.
    pub edges: Vec<PoseGraphEdge>,
    pub decisions: Vec<Decision>,
    /// Time of inserting each keyframe (cloud, descriptor, search, submaps), milliseconds.
    pub insert_keyframe: Vec<f64>,
    pub verify: Vec<f64>,
    pub judge: Vec<f64>,
    pub submap_bytes: usize,
}

/// Standard deviation of the added rotation drift at factor 1, rad/√m.
const ROTATION_DRIFT_RAD_PER_SQRT_M: f64 = 3e-3;
/// Standard deviation of the added translation drift at factor 1, m/√m. Both together give about 3 m over 500 m.
const TRANSLATION_DRIFT_M_PER_SQRT_M: f64 = 2e-2;
/// Distance over which the added error is constant, metres. A random walk instead would distort every submap.
const CONSTANT_ERROR_DISTANCE_M: f64 = 50.0;

/// Runs over a walk with added odometry drift, which the covariances of the edges include. `drift` is its factor: 0 adds none, 1 the constants
/// above.
pub fn find(recorded: &[RecordedKeyframe], drift: f64, seed: u64, config: LoopConfig) -> LoopFinderRun {
    let mut found = LoopFinderRun {
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
                sensor: LIDAR_POSITION_M,
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

/// The odometry edges of a mapping session.
fn edges(recorded: &[RecordedKeyframe], drift: f64, seed: u64) -> Vec<PoseGraphEdge> {
    let Some(first) = recorded.first() else { return Vec::new() };
    let mut session =
        Session::begin(&first.odom_from_base, SessionConfig::new(keyframe_policy()), PoseGraph::default());
    for keyframe in recorded {
        session.add_scan(&ScanPose {
            stamp: keyframe.stamp,
            odom_from_base: keyframe.odom_from_base,
            scan_stamp: keyframe.stamp,
            odom_from_base_at_scan: keyframe.odom_from_base,
            covariance: keyframe.covariance,
            covariance_inflation: Matrix6::zeros(),
            is_degenerate: keyframe.degenerate,
            is_gravity_measured: false,
            is_dead_reckoned: false,
        });
    }
    let mut rng = RngTree::new(seed).child("drift").rng();
    let (mut bias, mut walked) = (Vector6::zeros(), f64::INFINITY);
    let mut drifted = |edge: &PoseGraphEdge| {
        walked += edge.from_from_to.translation.vector.norm();
        if walked >= CONSTANT_ERROR_DISTANCE_M {
            (bias, walked) = (Vector6::from_fn(|_, _| rng.normal()), 0.0);
        }
        add_drift(edge, drift, &bias)
    };
    session.graph().edges().iter().map(&mut drifted).collect()
}

/// An edge with its share of a constant error. The covariance is that of a random walk that reaches the same error over
/// [`CONSTANT_ERROR_DISTANCE_M`].
fn add_drift(edge: &PoseGraphEdge, drift: f64, bias: &Vector6) -> PoseGraphEdge {
    if drift == 0.0 {
        return *edge;
    }
    let length = edge.from_from_to.translation.vector.norm().max(0.2);
    // Gravity makes roll and pitch more accurate; a tenth of the yaw error is assumed.
    let deviations = Vector6::new(0.1, 0.1, 1.0, 0.0, 0.0, 0.0)
        * (ROTATION_DRIFT_RAD_PER_SQRT_M * drift * length.sqrt())
        + Vector6::new(0.0, 0.0, 0.0, 1.0, 1.0, 0.5)
            * (TRANSLATION_DRIFT_M_PER_SQRT_M * drift * length.sqrt());
    let error = deviations.component_mul(bias) * (length / CONSTANT_ERROR_DISTANCE_M).sqrt();
    let added = Matrix6::from_diagonal(&deviations.component_mul(&deviations));
    let covariance = edge.information.try_inverse().unwrap_or_else(Matrix6::identity) + added;
    let from_from_to: Isometry = se3::retract(&edge.from_from_to, &error);
    PoseGraphEdge { from_from_to, information: covariance.try_inverse().unwrap_or(edge.information), ..*edge }
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
