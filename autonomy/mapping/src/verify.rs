//! Whether two keyframes really saw the same place, and where one then was in the other.
//!
//! A pure function of what a [`Comparison`] owns, so that it can run beside everything else: about 20 ms. The second cloud is
//! registered to the first submap from several starts; what comes out has to pass gates on fit, overlap, sight and rivals.
//! A gate passed proves nothing about places built alike: that is for `consistency`.

use crate::range_image::Occupancy;
use crate::submap::{LazySubmap, Submap};
use crate::{Edge, UncertainPose};
use geometry::{Isometry, Matrix6, Vector3, Vector6, se3, so3};
use nalgebra::{SymmetricEigen, Translation3};
use points::{GaussianMap, Surface};
use registration::{Fit, MatchingConfig, degenerate_directions, linearise, refine};
use std::sync::Arc;
use vocab::KeyframeId;

/// Points that try starts out.
const COARSE_POINTS: usize = 400;
const COARSE_STEPS: usize = 8;
const COARSE: MatchingConfig = MatchingConfig {
    gate_m: 0.25,
    kernel_width: 3.0,
    noise_m: 0.05,
    use_distributions: true,
    front_facing_only: false,
};
const FINE_STEPS: usize = 15;
const FINE: MatchingConfig = MatchingConfig {
    gate_m: 0.15,
    kernel_width: 3.0,
    noise_m: 0.02,
    use_distributions: true,
    front_facing_only: false,
};
/// Besides every guess, starts this far from it to all four sides, metres.
const ASIDE: f64 = 1.2;
/// Share of the strongest direction's information that noise and bent submaps can feign. Walls of a bare corridor, walked with
/// bad odometry and compared with themselves, were seen to reach 0.034.
const FEIGNED: f64 = 0.04;
/// Points that share one error (of map, time, motion), so count as one: as in odometry.
const CORRELATED: f64 = 10.0;
/// A direction is blind if it is known no better than this, metres.
const BLIND: f64 = 0.05;
/// What submaps and motion correction leave however many points agree: rotation (rad), translation (m).
const FLOOR: (f64, f64) = (5e-4, 0.005);
/// Share of a submap's own uncertainty that goes into the result: registration averages over it.
const SLACK: f64 = 0.5;
/// A fit is allowed by the graph up to this squared Mahalanobis distance: as in `consistency`.
const ALLOWED: f64 = 22.46;
/// Covariance that a coarse fit is granted beside the graph's: rotation (rad), translation (m).
const COARSE_DEVIATION: (f64, f64) = (0.02, 0.1);
/// A point lies on a surface this near, metres.
const ON_SURFACE: f32 = 0.15;
/// Two results are different places beyond this, metres and radians.
const APART: (f64, f64) = (0.5, 0.15);

/// The gates. Defaults are from the distributions in docs/maths/loops.md.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerificationConfig {
    /// Least share of one cloud that lies on the other's surfaces, and of the other one. The newer submap knows only what
    /// was walked before it, so the smaller share says less.
    pub overlap: [f64; 2],
    /// Greatest root mean square distance of those from the surfaces, metres.
    pub residual: f64,
    /// Greatest share of either cloud that stands where the other's rays went through.
    pub through: f64,
    /// Greatest share of the best fit that another, different place may reach that the graph allows just as well.
    pub rival: f64,
    /// A pair that is blind in one direction may pass if the graph knows the place to within this deviation, metres.
    pub blind: f64,
}

impl Default for VerificationConfig {
    fn default() -> Self {
        Self { overlap: [0.5, 0.25], residual: 0.06, through: 0.06, rival: 0.9, blind: 0.4 }
    }
}

/// What made somebody think of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CandidateSource {
    /// The estimates say they are near.
    Geometry,
    /// They look alike; the descriptors' distance.
    Appearance(f32),
    /// A person said so.
    Person,
}

/// A pair of keyframes to be looked at.
#[derive(Clone, Debug)]
pub struct VerificationTask {
    /// The older keyframe.
    pub from: KeyframeId,
    /// The newer one.
    pub to: KeyframeId,
    /// What looking takes.
    pub comparison: Comparison,
}

/// Two places to be compared.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Why.
    pub source: CandidateSource,
    /// Guesses of the newer one's pose in the older one.
    pub guesses: Vec<Isometry>,
    /// What the graph says of it, if it says anything.
    pub expected: Option<UncertainPose>,
    /// The older one's submap.
    pub older: Arc<LazySubmap>,
    /// The newer one's.
    pub newer: Arc<LazySubmap>,
}

/// Why a pair is no loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RejectionReason {
    /// No start led anywhere.
    NoFit,
    /// Too little of one lies on the other.
    Overlap,
    /// What lies on the other lies badly.
    Residual,
    /// Rays of one went through surfaces of the other.
    FreeSpaceViolation,
    /// Another place fits as well.
    Ambiguous,
    /// Blind in some direction and nothing else to hold it there.
    Degenerate,
}

/// What speaks for and against a pair: to be recorded and shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Why the pair was looked at.
    pub source: CandidateSource,
    /// Fit of the whole cloud, 0 to 1.
    pub score: f64,
    /// Share of the newer cloud on surfaces of the older submap, and the reverse.
    pub overlap: [f64; 2],
    /// Root mean square distance from the surfaces, metres.
    pub residual: f64,
    /// Share of the newer cloud through which the older one's rays went, and the reverse.
    pub through: [f64; 2],
    /// Fit of the best different place, as a share of this one's.
    pub rival: f64,
    /// Directions of translation that the pair cannot see, 0 to 3.
    pub blind: usize,
    /// Information about the weakest direction as a share of that about the strongest: up to 0.03 in a bare corridor, whose
    /// walls are never quite flat.
    pub grip: f64,
    /// How far the result is from the nearest guess, metres and radians.
    pub moved: (f64, f64),
    /// Squared Mahalanobis distance from what the graph expected, where it expected anything.
    pub surprise: Option<f64>,
}

/// What came of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComparisonResult {
    /// Pose of the newer place in the older one.
    pub pose: Isometry,
    /// Its inverse covariance, `[rotation; translation]`.
    pub information: Matrix6,
    /// What speaks for and against it.
    pub evidence: Evidence,
    /// What is wrong, or nothing.
    pub rejection: Option<RejectionReason>,
}

/// A pair looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerifiedPair {
    /// The relative pose found, with its information: as an edge of the graph.
    pub edge: Edge,
    /// What speaks for and against it.
    pub evidence: Evidence,
    /// What is wrong, or nothing.
    pub rejection: Option<RejectionReason>,
}

/// Appearance at a pair of keyframes, see [`compare`].
pub fn verify(task: &VerificationTask, gates: &VerificationConfig) -> VerifiedPair {
    VerifiedPair::new(task.from, task.to, &compare(&task.comparison, gates))
}

impl VerifiedPair {
    /// What came of comparing two keyframes.
    pub fn new(from: KeyframeId, to: KeyframeId, compared: &ComparisonResult) -> Self {
        let edge = Edge { from, to, from_from_to: compared.pose, information: compared.information };
        Self { edge, evidence: compared.evidence, rejection: compared.rejection }
    }
}

/// Appearance at two places. Total: without points or guesses it gives [`RejectionReason::NoFit`].
pub fn compare(comparison: &Comparison, gates: &VerificationConfig) -> ComparisonResult {
    let Comparison { source, guesses, expected, .. } = comparison;
    let (older, newer) = (comparison.older.get(), comparison.newer.get());
    let fits = try_starts(older, newer, guesses);
    let Some((best, rivals)) = choose(&fits, expected.as_ref(), gates) else { return no_fit(comparison) };
    let (pose, information, grip) = settle(&older.map, &newer.points, &best.map_from_body);
    let blind: Vec<Vector3> =
        degenerate_directions(&(information / CORRELATED), BLIND).into_iter().flatten().collect();
    let information = with_floor(&pose, &(information / CORRELATED), older.slack + newer.slack);

    let back = pose.inverse();
    let (forth_overlap, residual) = overlap(&older.map, &newer.points, &pose);
    let (back_overlap, _) = overlap(&newer.map, &older.points, &back);
    let rival = rivals
        .iter()
        .filter(|other| different(&pose, &other.map_from_body, &blind))
        .map(|other| other.score / best.score.max(1e-9))
        .fold(0.0, f64::max);
    let measured = UncertainPose::from_information(pose, &information);
    let evidence = Evidence {
        source: *source,
        score: registration::score(&older.map, &newer.points, &pose, &FINE),
        overlap: [forth_overlap, back_overlap],
        residual,
        through: [seen_through(older, &newer.points, &pose), seen_through(newer, &older.points, &back)],
        rival,
        blind: blind.len(),
        grip,
        moved: nearest(guesses, &pose),
        surprise: expected.and_then(|expected| expected.distance_squared(&measured)),
    };
    ComparisonResult { pose, information, rejection: rejection(&evidence, comparison, gates), evidence }
}

fn no_fit(comparison: &Comparison) -> ComparisonResult {
    ComparisonResult {
        pose: comparison.guesses.first().copied().unwrap_or_else(Isometry::identity),
        information: Matrix6::zeros(),
        evidence: Evidence {
            source: comparison.source,
            score: 0.0,
            overlap: [0.0; 2],
            residual: 0.0,
            through: [0.0; 2],
            rival: 0.0,
            blind: 3,
            grip: 0.0,
            moved: (0.0, 0.0),
            surprise: None,
        },
        rejection: Some(RejectionReason::NoFit),
    }
}

fn rejection(
    evidence: &Evidence,
    comparison: &Comparison,
    gates: &VerificationConfig,
) -> Option<RejectionReason> {
    let worst = |pair: [f64; 2]| pair[0].max(pair[1]);
    let [a, b] = evidence.overlap;
    if a.max(b) < gates.overlap[0] || a.min(b) < gates.overlap[1] {
        return Some(RejectionReason::Overlap);
    }
    if evidence.residual > gates.residual {
        return Some(RejectionReason::Residual);
    }
    if worst(evidence.through) > gates.through {
        return Some(RejectionReason::FreeSpaceViolation);
    }
    if evidence.rival > gates.rival {
        return Some(RejectionReason::Ambiguous);
    }
    // A blind direction keeps what was guessed, without information. Only the graph's guess means anything there.
    let known = comparison.expected.is_some_and(|expected| expected.translation_std_m() <= gates.blind);
    let held = evidence.blind == 1 && comparison.source == CandidateSource::Geometry && known;
    (evidence.blind > 0 && !held).then_some(RejectionReason::Degenerate)
}

/// Coarse fits from all starts, best first.
fn try_starts(older: &Submap, newer: &Submap, guesses: &[Isometry]) -> Vec<Fit> {
    let stride = newer.points.len().div_ceil(COARSE_POINTS).max(1);
    let few: Vec<[f32; 3]> = newer.points.iter().step_by(stride).copied().collect();
    if few.is_empty() || older.map.is_empty() {
        return Vec::new();
    }
    let mut fits: Vec<Fit> = guesses
        .iter()
        .filter(|guess| guess.to_homogeneous().iter().all(|c| c.is_finite()))
        .flat_map(|guess| {
            [(0.0, 0.0), (ASIDE, 0.0), (-ASIDE, 0.0), (0.0, ASIDE), (0.0, -ASIDE)].map(|(x, y)| {
                let moved = guess.translation.vector + Vector3::new(x, y, 0.0);
                Isometry::from_parts(Translation3::from(moved), guess.rotation)
            })
        })
        .map(|start| refine(&older.map, &few, &start, &COARSE, COARSE_STEPS))
        .collect();
    // Stable, so that of equals the earlier start comes first.
    fits.sort_by(|a, b| b.score.total_cmp(&a.score));
    fits
}

/// Gauss-Newton on all points in the directions that they see. Gives the pose, the information there and its grip.
fn settle(map: &GaussianMap, points: &[[f32; 3]], start: &Isometry) -> (Isometry, Matrix6, f64) {
    let mut pose = *start;
    let (mut information, mut grip) = (Matrix6::zeros(), 0.0);
    for _ in 0..FINE_STEPS {
        let at = linearise(map, points, &pose, &FINE);
        let seen = seen_part(&at.information);
        grip = seen.grip;
        information = seen.kept * at.information * seen.kept;
        let damped = information + Matrix6::identity() * (at.information.trace() * 1e-7 + 1e-9);
        let Some(factor) = damped.cholesky() else { break };
        let step: Vector6 = factor.solve(&-(seen.kept * at.gradient));
        if !step.iter().all(|c| c.is_finite()) {
            break;
        }
        pose = se3::retract(&pose, &step);
        if step.norm() < 1e-4 {
            break;
        }
    }
    (pose, information, grip)
}

/// What of an information is more than feigned.
struct SeenPart {
    /// Projection that drops the directions of translation that are not seen.
    kept: Matrix6,
    /// Information about the weakest direction of translation as a share of that about the strongest.
    grip: f64,
}

/// Appearance at translations only: gravity keeps tilt, and how much of a turn about a corridor's axis is seen depends on its width.
fn seen_part(information: &Matrix6) -> SeenPart {
    let eigen = SymmetricEigen::new(information.fixed_view::<3, 3>(3, 3).into_owned());
    let greatest = eigen.eigenvalues.max().max(f64::MIN_POSITIVE);
    let mut kept = Matrix6::identity();
    for (value, direction) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value < FEIGNED * greatest {
            let mut drop = kept.fixed_view_mut::<3, 3>(3, 3);
            drop -= direction * direction.transpose();
        }
    }
    SeenPart { kept, grip: (eigen.eigenvalues.min() / greatest).max(0.0) }
}

/// The best of the fits that the graph allows, unless one that it forbids is clearly better; and all others that count as
/// rivals: where the graph allows the best one, those that it allows too.
fn choose(
    fits: &[Fit],
    expected: Option<&UncertainPose>,
    gates: &VerificationConfig,
) -> Option<(Fit, Vec<Fit>)> {
    let allowed = |fit: &Fit| {
        let covariance = diagonal(COARSE_DEVIATION);
        let measured = UncertainPose { pose: fit.map_from_body, covariance };
        expected.is_none_or(|e| e.distance_squared(&measured).is_some_and(|squared| squared <= ALLOWED))
    };
    let top = fits.first()?;
    let best = fits.iter().find(|fit| allowed(fit) && fit.score >= gates.rival * top.score).unwrap_or(top);
    let all_count = !allowed(best);
    let rivals = fits.iter().filter(|fit| *fit != best && (all_count || allowed(fit))).copied().collect();
    Some((*best, rivals))
}

/// Covariance without correlations from deviations of rotation and translation.
fn diagonal((turn, place): (f64, f64)) -> Matrix6 {
    let (turn, place) = (turn * turn, place * place);
    Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, place, place, place))
}

/// Information after adding the covariance that no number of points takes away: of submaps in themselves, and of theirs to
/// the walk.
fn with_floor(pose: &Isometry, information: &Matrix6, slack: Matrix6) -> Matrix6 {
    let covariance =
        UncertainPose::from_information(*pose, information).covariance + diagonal(FLOOR) + slack * SLACK;
    covariance.cholesky().map_or_else(Matrix6::zeros, |factor| {
        let inverse = factor.inverse();
        (inverse + inverse.transpose()) * 0.5
    })
}

/// Share of the points that lie on a surface, and their root mean square distance from it.
fn overlap(map: &GaussianMap, points: &[[f32; 3]], map_from_body: &Isometry) -> (f64, f64) {
    let rotation = map_from_body.rotation.to_rotation_matrix();
    let (mut on, mut sum, mut flat) = (0_usize, 0.0, 0_usize);
    for point in points {
        let p = rotation * Vector3::from(point.map(f64::from)) + map_from_body.translation.vector;
        match map.find_surface(&[p.x, p.y, p.z], ON_SURFACE) {
            Some(Surface::Plane { distance, .. }) if distance.abs() <= ON_SURFACE => {
                on += 1;
                flat += 1;
                sum += f64::from(distance * distance);
            }
            Some(Surface::Distribution { offset, .. }) => {
                // Cells that are not flat are 25 cm wide: a point in one is on it.
                on += usize::from(offset.iter().map(|c| c * c).sum::<f32>() <= 4.0 * ON_SURFACE * ON_SURFACE);
            }
            Some(Surface::Plane { .. }) | None => {}
        }
    }
    (on as f64 / points.len().max(1) as f64, (sum / flat.max(1) as f64).sqrt())
}

/// Of the points that a submap's sensors could see, the share through which their rays went.
fn seen_through(submap: &Submap, points: &[[f32; 3]], submap_from_body: &Isometry) -> f64 {
    let (mut through, mut judged) = (0_usize, 0_usize);
    let views: Vec<_> = submap
        .members
        .iter()
        .step_by(2)
        .map(|(submap_from_member, cloud)| {
            let member_from_body = submap_from_member.inverse() * submap_from_body;
            let turn = member_from_body.rotation.to_rotation_matrix().into_inner().map(|v| v as f32);
            (turn, member_from_body.translation.vector.map(|v| v as f32), cloud.view())
        })
        .collect();
    for point in points.iter().step_by(2) {
        let (mut against, mut agreeing) = (0, 0);
        for (turn, shift, view) in &views {
            let moved = turn * nalgebra::Vector3::from(*point) + shift;
            match view.classify(&[moved.x, moved.y, moved.z]) {
                Occupancy::Free => against += 1,
                Occupancy::Occupied => agreeing += 1,
                Occupancy::Occluded | Occupancy::Unobserved => {}
            }
        }
        judged += usize::from(against + agreeing > 0);
        through += usize::from(against > agreeing);
    }
    through as f64 / judged.max(1) as f64
}

/// Whether two poses are different places in directions that can be seen.
fn different(a: &Isometry, b: &Isometry, blind: &[Vector3]) -> bool {
    let error = se3::local(a, b);
    let mut shift: Vector3 = error.fixed_rows::<3>(3).into_owned();
    for direction in blind {
        shift -= direction * direction.dot(&shift);
    }
    shift.norm() > APART.0 || error.fixed_rows::<3>(0).norm() > APART.1
}

fn nearest(guesses: &[Isometry], pose: &Isometry) -> (f64, f64) {
    guesses
        .iter()
        .map(|guess| {
            let moved = guess.inverse() * pose;
            (moved.translation.vector.norm(), so3::log(&moved.rotation).norm())
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or((0.0, 0.0))
}

#[cfg(test)]
#[path = "verify_tests.rs"]
mod tests;
