//! From scan to scan: odometry's motion carries the pose, the known surfaces correct it.

use crate::localisation_map::LocalisationMap;
use crate::localisation_monitor::{LocalisationMonitor, LocalisationStatus, PoseEvidence};
use geometry::{Isometry, Matrix6, Vector6, se3};
use mapping::UncertainPose;
use registration::{MatchingConfig, linearise, shrink_eigenvalues};
use std::sync::Arc;
use vocab::Stamp;

/// Fewer points than this say nothing.
const MIN_POINTS: usize = 60;
/// How points are matched once the pose is nearly right: the map is made of thinned clouds.
const MATCHING: MatchingConfig = MatchingConfig {
    gate_m: 0.1,
    kernel_width: 3.0,
    noise_m: 0.015,
    use_distributions: true,
    front_facing_only: true,
};
/// Gauss-Newton steps at most, and the length of one that ends them: radians and metres.
const ITERATIONS: usize = 8;
const RESTING: f64 = 1e-4;
/// The first looks are so much wider, by how far off the prediction may be, metres.
const WIDENED: [(f64, f32); 3] = [(0.02, 1.0), (0.06, 2.0), (f64::INFINITY, 4.0)];
/// Points that share one error (of the map, of time, of motion) and so count as one: as in odometry.
const CORRELATED: f64 = 10.0;
/// Share of the strongest direction's information that noise alone can fake in a blind one.
const FEIGNED: f64 = 1e-3;
/// What odometry adds to the doubt: radians and metres a scan, for each metre walked, for each radian turned.
const STILL: (f64, f64) = (1e-4, 5e-4);
const WALKED: (f64, f64) = (1e-3, 0.01);
const TURNED: (f64, f64) = (5e-3, 2e-3);
/// The doubt that no number of scans takes away, since neighbouring scans see the same errors of the map: radians and metres. It is
/// told, and not carried on.
const FLOOR: (f64, f64) = (1e-3, 6e-3);

/// A scan that odometry has freed of its motion.
#[derive(Clone, Copy, Debug)]
pub struct DownsampledScan<'a> {
    /// Of the pose.
    pub stamp: Stamp,
    /// By odometry.
    pub odom_from_base: Isometry,
    /// Of that, `[rotation; translation]`.
    pub covariance: Matrix6,
    /// Some thousands of points, spread evenly, base frame, metres.
    pub points: &'a [[f32; 3]],
}

/// Where the robot is in the known map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackedPose {
    /// The base.
    pub map_from_base: UncertainPose,
    /// How far that can be believed.
    pub trust: LocalisationStatus,
    /// Why.
    pub evidence: PoseEvidence,
}

/// Keeps the pose in a known map.
#[derive(Clone, Debug)]
pub struct PoseTracker {
    guide: Arc<LocalisationMap>,
    map_from_base: UncertainPose,
    /// Odometry's pose and covariance at the last scan.
    last: (Isometry, Option<Matrix6>),
    judge: LocalisationMonitor,
}

impl PoseTracker {
    /// Begins where the base is said to be, by somebody who may be so wrong, at a moment of odometry, with odometry's covariance then if
    /// that is known.
    pub fn new(
        guide: Arc<LocalisationMap>,
        map_from_base: UncertainPose,
        odom_from_base: &Isometry,
        covariance: Option<Matrix6>,
    ) -> Self {
        Self {
            guide,
            map_from_base,
            last: (*odom_from_base, covariance),
            judge: LocalisationMonitor::default(),
        }
    }

    /// Where odometry's frame is in the map.
    pub fn map_from_odom(&self) -> Isometry {
        self.map_from_base.pose * self.last.0.inverse()
    }

    /// The base at the last scan.
    pub fn map_from_base(&self) -> &UncertainPose {
        &self.map_from_base
    }

    /// Takes in the next scan. Costs eight looks at its points at most, and one at every keyframe's place.
    pub fn track(&mut self, scan: &DownsampledScan) -> TrackedPose {
        let predicted = self.carry(scan);
        let fitted = (scan.points.len() >= MIN_POINTS).then(|| fit(&self.guide, &predicted, scan.points));
        let mut evidence = PoseEvidence { seen: scan.points.len(), ..PoseEvidence::default() };
        if let Some(fitted) = fitted {
            self.map_from_base = fitted.map_from_base;
            (evidence.matched, evidence.mapped) = (fitted.matched, fitted.mapped);
            evidence.sightings = self.guide.sightings(&fitted.map_from_base.pose, scan.points);
        } else {
            self.map_from_base = predicted;
        }
        let UncertainPose { pose, covariance } = self.map_from_base;
        let map_from_base = UncertainPose { pose, covariance: covariance + floor() };
        evidence.deviation = map_from_base.translation_std_m();
        let trust = self.judge.judge(scan.stamp, &evidence);
        TrackedPose { map_from_base, trust, evidence }
    }

    /// The pose moved on by what odometry saw since the last scan, and its doubt grown by as much as odometry's and by what the way
    /// itself is worth.
    fn carry(&mut self, scan: &DownsampledScan) -> UncertainPose {
        let (before, known) = std::mem::replace(&mut self.last, (scan.odom_from_base, Some(scan.covariance)));
        let moved = before.inverse() * scan.odom_from_base;
        let (walked, turned) = (moved.translation.vector.norm(), moved.rotation.angle());
        let by_way = |still: f64, per_metre: f64, per_radian: f64| {
            (still + per_metre * walked + per_radian * turned).powi(2)
        };
        let grown = (scan.covariance - known.unwrap_or(scan.covariance)).diagonal();
        let [turn_grown, place_grown] = [0, 3].map(|first| grown.fixed_rows::<3>(first).max().max(0.0));
        let turn = by_way(STILL.0, WALKED.0, TURNED.0) + turn_grown;
        let place = by_way(STILL.1, WALKED.1, TURNED.1) + place_grown;
        let covariance = Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, place, place, place));
        self.map_from_base.then(&UncertainPose { pose: moved, covariance })
    }
}

struct Fitted {
    map_from_base: UncertainPose,
    /// Share of the points on known surfaces, and of those that have any about.
    matched: f64,
    mapped: f64,
}

/// The pose on which prediction and surfaces agree best.
fn fit(guide: &LocalisationMap, predicted: &UncertainPose, points: &[[f32; 3]]) -> Fitted {
    let prior = predicted.information();
    let deviation = predicted.translation_std_m();
    let mut widen = WIDENED.iter().find(|(limit, _)| deviation <= *limit).map_or(1.0, |(_, wide)| *wide);
    let squares: f64 = points.iter().map(|p| p.iter().map(|c| f64::from(c * c)).sum::<f64>()).sum();
    let arm = (squares / points.len().max(1) as f64).sqrt().max(0.5);
    let mut pose = predicted.pose;
    let (mut information, mut matched, mut mapped) = (Matrix6::zeros(), 0.0, 0.0);
    for _ in 0..ITERATIONS {
        let options = MatchingConfig {
            gate_m: MATCHING.gate_m * widen,
            kernel_width: MATCHING.kernel_width * widen,
            ..MATCHING
        };
        let at = linearise(guide.surfaces(), points, &pose, &options);
        let seen = shrink_eigenvalues(&at.information, &at.gradient, arm, FEIGNED);
        information = seen.information / CORRELATED;
        [matched, mapped] = [at.inliers, at.matched].map(|count| count as f64 / points.len().max(1) as f64);
        let off = se3::local(&predicted.pose, &pose);
        let Some(factor) = (information + prior).cholesky() else { break };
        let step: Vector6 = factor.solve(&-(seen.gradient / CORRELATED + prior * off));
        if !step.iter().all(|c| c.is_finite()) {
            break;
        }
        pose = se3::retract(&pose, &step);
        if widen <= 1.0 && step.norm() < RESTING {
            break;
        }
        widen = (widen * 0.5).max(1.0);
    }
    let covariance = (information + prior).cholesky().map_or(predicted.covariance, |factor| factor.inverse());
    let covariance = (covariance + covariance.transpose()) * 0.5;
    Fitted { map_from_base: UncertainPose { pose, covariance }, matched, mapped }
}

fn floor() -> Matrix6 {
    let (turn, place) = (FLOOR.0 * FLOOR.0, FLOOR.1 * FLOOR.1);
    Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, place, place, place))
}
