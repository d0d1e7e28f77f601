//! Compares loops with the ground truth.

use crate::ROTATION_TOLERANCE_RAD;
use geometry::{Isometry, Matrix6, Vector3, so3};
use mapping::{Decision, UncertainPose, Verdict};
use messages::{EdgeKind, GraphEdge, LoopDecision, LoopVerdict};
use nalgebra::SymmetricEigen;
use sim::SimulatedSite;

/// Greatest horizontal distance between the two positions of a revisit, metres.
const MAX_REVISIT_DISTANCE_M: f64 = 2.0;
/// Greatest vertical distance between them, metres.
const MAX_REVISIT_HEIGHT_M: f64 = 0.6;
/// Least distance walked between them, metres.
const MIN_REVISIT_WALKED_M: f64 = 15.0;
/// A revisit is closed if a loop was accepted within this distance of walking, metres. Loops are made every 2 m.
const CLOSED_WITHIN_M: f64 = 3.0;
/// A loop with a greater translation error is wrong, metres; or with a greater rotation error than [`ROTATION_TOLERANCE_RAD`].
const MAX_TRANSLATION_ERROR_M: f64 = 0.3;

/// The decision on a pair of keyframes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Outcome {
    Accepted,
    Held,
    Rejected,
    Dropped,
}

/// A pair of keyframes with its relative pose and the decision on it.
#[derive(Clone, Copy, Debug)]
pub struct JudgedLoop {
    /// Index of the older keyframe.
    pub from: usize,
    /// Index of the newer keyframe.
    pub to: usize,
    /// Pose of the newer keyframe in the older one.
    pub from_from_to: Isometry,
    /// Information matrix of that pose.
    pub information: Matrix6,
    /// The decision.
    pub outcome: Outcome,
}

impl From<&Decision> for JudgedLoop {
    fn from(decision: &Decision) -> Self {
        Self {
            from: decision.edge.from.0 as usize,
            to: decision.edge.to.0 as usize,
            from_from_to: decision.edge.from_from_to,
            information: decision.edge.information,
            outcome: match decision.verdict {
                Verdict::Accepted => Outcome::Accepted,
                Verdict::Held => Outcome::Held,
                Verdict::Rejected(_) => Outcome::Rejected,
                Verdict::Dropped => Outcome::Dropped,
            },
        }
    }
}

impl JudgedLoop {
    /// Makes it from a published decision and the edges of the graph. A pair that is not an edge has no information matrix. `None` if its pose is
    /// invalid.
    pub fn from_decision(decision: &LoopDecision, edges: &[GraphEdge]) -> Option<Self> {
        let pair = (decision.task.from, decision.task.to);
        let edge = edges.iter().find(|edge| edge.kind == EdgeKind::Loop && (edge.from, edge.to) == pair);
        let information = edge.map_or([[0.0; 6]; 6], |edge| edge.information);
        Some(Self {
            from: decision.task.from.0 as usize,
            to: decision.task.to.0 as usize,
            from_from_to: geometry::isometry_from_pose(&decision.from_from_to)?,
            information: Matrix6::from_fn(|row, column| information[row][column]),
            outcome: match decision.verdict {
                LoopVerdict::Accepted => Outcome::Accepted,
                LoopVerdict::Held => Outcome::Held,
                LoopVerdict::Rejected => Outcome::Rejected,
                LoopVerdict::Dropped => Outcome::Dropped,
            },
        })
    }

    /// The error of the relative pose.
    fn pose_error(&self, truth: &[Isometry]) -> Isometry {
        (truth[self.from].inverse() * truth[self.to]).inverse() * self.from_from_to
    }
}

/// The score of a walk.
#[derive(Clone, Debug, Default)]
pub struct Score {
    /// Number of keyframes.
    pub keyframes: usize,
    /// Number of revisits.
    pub revisits: usize,
    /// Number of closed revisits.
    pub closed: usize,
    /// Number of accepted loops.
    pub accepted: usize,
    /// Number of wrong ones among them.
    pub wrong: usize,
    /// Number of pairs that wait for a decision.
    pub held: usize,
    /// Number of rejected pairs.
    pub rejected: usize,
    /// Root mean square error of the right accepted loops, metres.
    pub translation_rmse_m: f64,
    /// Root mean square error of their rotations, radians.
    pub rotation_rmse_rad: f64,
    /// Mean normalised estimation error squared (NEES) of the right loops by their own information; 6 for consistent covariances.
    pub nees: f64,
}

/// Error of a loop, metres and radians. Only directions whose standard deviation is below 1 m count.
pub fn error(judged: &JudgedLoop, truth: &[Isometry]) -> (f64, f64) {
    claimed_error(&judged.pose_error(truth), &judged.information)
}

/// Size of a pose error, metres and radians, in the directions whose standard deviation is below 1 m by `information`.
pub fn claimed_error(off: &Isometry, information: &Matrix6) -> (f64, f64) {
    // In the frame of the newer base, like the covariance.
    let shift = off.rotation.inverse() * off.translation.vector;
    let measured = UncertainPose::from_information(Isometry::identity(), information);
    let eigen = SymmetricEigen::new(measured.covariance.fixed_view::<3, 3>(3, 3).into_owned());
    let known = eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter());
    let claimed = known.filter(|(variance, _)| **variance < 1.0).map(|(_, axis)| axis.dot(&shift).powi(2));
    (claimed.sum::<f64>().sqrt(), so3::log(&off.rotation).norm())
}

/// Whether a loop is wrong.
pub fn is_wrong(judged: &JudgedLoop, truth: &[Isometry]) -> bool {
    exceeds_tolerance(error(judged, truth))
}

/// Whether an error, metres and radians, is too large for a right loop.
pub fn exceeds_tolerance((translation, rotation): (f64, f64)) -> bool {
    translation > MAX_TRANSLATION_ERROR_M || rotation > ROTATION_TOLERANCE_RAD
}

/// Whether a revisit at the distance `walked` is closed by a loop at one of the distances `closed_at`, metres.
pub fn is_closed(walked: f64, closed_at: &[f64]) -> bool {
    closed_at.iter().any(|at| (at - walked).abs() <= CLOSED_WITHIN_M)
}

/// Scores the decisions of a walk.
///
/// - `truth`: true pose of the base in the site at every keyframe.
pub fn score(site: &SimulatedSite, truth: &[Isometry], decisions: &[JudgedLoop]) -> Score {
    let walked = walked(truth);
    let mut score = Score { keyframes: truth.len(), ..Score::default() };
    let mut closed_at = Vec::new();
    for judged in decisions {
        match judged.outcome {
            Outcome::Accepted => {
                score.accepted += 1;
                if is_wrong(judged, truth) {
                    score.wrong += 1;
                } else {
                    closed_at.push(walked[judged.to]);
                    score.add_error(judged, truth);
                }
            }
            Outcome::Held => score.held += 1,
            Outcome::Rejected => score.rejected += 1,
            Outcome::Dropped => {}
        }
    }
    let right = closed_at.len().max(1) as f64;
    score.translation_rmse_m = (score.translation_rmse_m / right).sqrt();
    score.rotation_rmse_rad = (score.rotation_rmse_rad / right).sqrt();
    score.nees /= right;
    for newer in revisits(site, truth) {
        score.revisits += 1;
        score.closed += usize::from(is_closed(walked[newer], &closed_at));
    }
    score
}

impl Score {
    fn add_error(&mut self, judged: &JudgedLoop, truth: &[Isometry]) {
        let (place, turn) = error(judged, truth);
        self.translation_rmse_m += place * place;
        self.rotation_rmse_rad += turn * turn;
        let relative = truth[judged.from].inverse() * truth[judged.to];
        let off = geometry::se3::local(&judged.from_from_to, &relative);
        self.nees += off.dot(&(judged.information * off));
    }
}

/// True distance walked up to each keyframe, metres.
pub fn walked(truth: &[Isometry]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut last: Option<Vector3> = None;
    truth
        .iter()
        .map(|site_from_base| {
            let place = site_from_base.translation.vector;
            sum += last.map_or(0.0, |last| (place - last).norm());
            last = Some(place);
            sum
        })
        .collect()
}

/// The keyframes that are true revisits: near an older keyframe, on its floor and in its sight.
pub fn revisits(site: &SimulatedSite, truth: &[Isometry]) -> Vec<usize> {
    let walked = walked(truth);
    let eye = |pose: &Isometry| pose.translation.vector + Vector3::z() * 0.3;
    (0..truth.len())
        .filter(|&newer| {
            (0..newer).any(|older| {
                let (a, b) = (eye(&truth[older]), eye(&truth[newer]));
                let (offset, distance) = (b - a, (b - a).norm());
                walked[newer] - walked[older] > MIN_REVISIT_WALKED_M
                    && offset.xy().norm() < MAX_REVISIT_DISTANCE_M
                    && offset.z.abs() < MAX_REVISIT_HEIGHT_M
                    && (distance < 1e-3 || site.cast_ray(&a, &(offset / distance), distance).is_none())
            })
        })
        .collect()
}
