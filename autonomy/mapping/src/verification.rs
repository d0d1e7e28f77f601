//! Verification of a pair of keyframes: whether both saw the same place, and the pose of one in the other (docs/maths/loops.md, section 5 and equations 7 to 9).
//!
//! A pure function of what a [`Comparison`] owns, so that it can run in a job: about 20 ms. The newer cloud is registered to the older submap
//! from several starts. The result has to pass gates on overlap, residual, free space, runner-up and degeneracy. These gates cannot tell
//! places apart that are built alike; that is done by `consistency`.

use crate::range_image::Occupancy;
use crate::registration_floor::RegistrationFloor;
use crate::submap::{LazySubmap, Submap};
use crate::uncertain_pose::{CHI_SQUARED_6_999, diagonal_covariance};
use crate::vertical::RelativeTilt;
use crate::{PoseCertaintyConfig, PoseGraphEdge, UncertainPose};
use geometry::{Isometry, Matrix6, Vector3, se3, so3};
use nalgebra::{SymmetricEigen, Translation3};
use points::Surface;
use registration::{
    Fit, GaussNewtonConfig, MatchingConfig, ScanInformationConfig, WidthSchedule, degenerate_directions,
    gauss_newton, linearise_from_viewpoint, refine_from_viewpoint, score_from_viewpoint,
};
use std::sync::Arc;
use vocab::KeyframeId;

/// Parameters of [`compare`]. The gates are from the distributions in docs/maths/loops.md.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerificationConfig {
    /// Least share of one cloud that lies on the other's surfaces, for the better of both directions. Source: docs/maths/loops.md, section 5: right pairs have 0.93 in
    /// the median.
    pub min_overlap_better: f64,
    /// The same for the worse direction. Less, because the newer submap knows only what was walked before it. Source: docs/maths/loops.md, section 5: right pairs have
    /// 0.85 in the median, and 0.26 in the worst hundredth.
    pub min_overlap_worse: f64,
    /// Greatest root mean square distance of those points from the surfaces, metres. Source: docs/maths/loops.md, section 5: right pairs have 0.030 m in the median, and
    /// 0.056 in the worst hundredth.
    pub max_residual_m: f64,
    /// Greatest share of either cloud that stands in free space of the other. Source: docs/maths/loops.md, section 5: below 0.04 for right pairs without added drift;
    /// wrong ones have 0.035 in the median.
    pub max_free_space_violation: f64,
    /// Greatest score of another, different pose that the graph allows as well, as a share of the best score. Chosen: of places that repeat, another pose has nearly the
    /// same score (docs/maths/loops.md, section 8).
    pub max_runner_up_ratio: f64,
    /// A pair that is degenerate in one direction may pass if the graph knows its pose to this standard deviation, metres. Its default is that of
    /// [`PoseCertaintyConfig`].
    pub max_degenerate_std_m: f64,
    /// Number of points of the coarse registration from each start. Chosen: a seventh of a cloud, for time.
    pub coarse_points: usize,
    /// Gauss-Newton steps of the coarse registration. Chosen: the kernel narrows over them; more cost time.
    pub coarse_steps: usize,
    /// Matching of the coarse registration. Surfaces have sides here and below: the two faces of an inner wall are 10 to 20 cm apart, and so within
    /// the gates.
    pub coarse: MatchingConfig,
    /// Iteration of the fine registration.
    pub fine_iteration: GaussNewtonConfig,
    /// Matching of the fine registration.
    pub fine: MatchingConfig,
    /// Besides each guess, the registration starts at this distance from it to all four sides, metres. Chosen: half of
    /// [`crate::candidates::CandidateConfig::max_offset_m`], from which the coarse registration converges.
    pub start_offset_m: f64,
    /// Directions of translation with a smaller share of the strongest direction's information are not observed. Noise and deformed submaps of
    /// a bare corridor, walked with bad odometry and compared with itself, reached 0.034.
    pub min_conditioning: f64,
    /// Number of neighbouring points that share one error (of map, time and motion) and count as one, as in odometry. Its default is that of odometry.
    pub correlated_points: f64,
    /// Standard deviation of the relative tilt of two keyframes by odometry with an IMU, radians. Its default is that of
    /// registrations ([`RegistrationFloor`]): motion correction and local map leave it, and gravity keeps it from growing along the walk.
    pub tilt_std_rad: f64,
    /// A direction with a larger standard deviation is degenerate, metres. Chosen: ten times the least deviation of a registration.
    pub max_observed_std_m: f64,
    /// Standard deviation that submaps and motion correction leave however many points agree: rotation, radians. Its default is that of registrations
    /// ([`RegistrationFloor`]).
    pub floor_rotation_std_rad: f64,
    /// The same for translation, metres. Its default is that of registrations ([`RegistrationFloor`]).
    pub floor_translation_std_m: f64,
    /// Share of the submaps' own covariance that is added to the result. Registration averages over it. Chosen: half; with none, loops of bent submaps count too much,
    /// with all, too little.
    pub submap_covariance_share: f64,
    /// Standard deviation of a coarse registration when it is compared with the graph: rotation, radians. Chosen: about a degree, which the fine registration corrects.
    pub coarse_rotation_std_rad: f64,
    /// The same for translation, metres. Chosen: less than its gate, so that the fine registration converges.
    pub coarse_translation_std_m: f64,
    /// A point at most this far from a surface lies on it, metres. Chosen: as the gate of the fine registration.
    pub surface_distance_m: f32,
    /// Two results farther apart than this are different poses, metres. Chosen: far more than the error of a registration, and less than half of the distance at which
    /// things repeat (1.2 m, [`PoseCertaintyConfig`]).
    pub distinct_m: f64,
    /// The same for rotation, radians. Chosen: 9 degrees, far more than the error of a registration.
    pub distinct_rad: f64,
}

impl Default for VerificationConfig {
    fn default() -> Self {
        Self {
            min_overlap_better: 0.5,
            min_overlap_worse: 0.25,
            max_residual_m: 0.06,
            max_free_space_violation: 0.06,
            max_runner_up_ratio: 0.9,
            max_degenerate_std_m: PoseCertaintyConfig::default().max_std_m,
            coarse_points: 400,
            coarse_steps: 8,
            coarse: MatchingConfig { front_facing_only: true, ..MatchingConfig::coarse() },
            fine_iteration: GaussNewtonConfig {
                max_iterations: 15,
                min_step: 1e-4,
                initial_width: 1.0,
                schedule: WidthSchedule::Linear,
                relative_damping: 1e-7,
                absolute_damping: 1e-9,
            },
            fine: MatchingConfig { front_facing_only: true, ..MatchingConfig::fine() },
            start_offset_m: 1.2,
            min_conditioning: 0.04,
            correlated_points: ScanInformationConfig::default().correlated_points,
            tilt_std_rad: RegistrationFloor::default().rotation_std_rad,
            max_observed_std_m: 0.05,
            floor_rotation_std_rad: RegistrationFloor::default().rotation_std_rad,
            floor_translation_std_m: RegistrationFloor::default().translation_std_m,
            submap_covariance_share: 0.5,
            coarse_rotation_std_rad: 0.02,
            coarse_translation_std_m: 0.1,
            surface_distance_m: 0.15,
            distinct_m: 0.5,
            distinct_rad: 0.15,
        }
    }
}

/// Why a pair was proposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CandidateSource {
    /// The estimates put the keyframes close together.
    Geometry,
    /// They look alike; the distance of their scan contexts.
    Appearance(f32),
    /// A person proposed it.
    Person,
}

/// A pair of keyframes to be verified.
#[derive(Clone, Debug)]
pub struct VerificationTask {
    /// The older keyframe.
    pub from: KeyframeId,
    /// The newer one.
    pub to: KeyframeId,
    /// The data of the comparison.
    pub comparison: Comparison,
}

/// Two places to be compared, with all data that takes.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Why it was proposed.
    pub source: CandidateSource,
    /// Guesses of the newer place's pose in the older one.
    pub guesses: Vec<Isometry>,
    /// The same pose as the graph knows it, if it does.
    pub expected: Option<UncertainPose>,
    /// The vertical at both places, if odometry measured it.
    pub tilt: Option<RelativeTilt>,
    /// Submap of the older place.
    pub older: Arc<LazySubmap>,
    /// Submap of the newer place.
    pub newer: Arc<LazySubmap>,
}

/// Why a pair is not a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum RejectionReason {
    /// The registration did not converge from any start.
    NoFit,
    /// Too little of one cloud lies on the other.
    Overlap,
    /// The points that lie on the other cloud are too far from its surfaces.
    Residual,
    /// One scan looked through surfaces of the other.
    FreeSpaceViolation,
    /// Another pose fits as well.
    Ambiguous,
    /// Some direction is not observed, and the graph does not know it either.
    Degenerate,
}

/// The figures on which a pair is decided. They are recorded and shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairEvidence {
    /// Why the pair was proposed.
    pub source: CandidateSource,
    /// Registration score of the whole cloud, 0 to 1.
    pub score: f64,
    /// Share of the newer cloud on surfaces of the older submap, and the reverse.
    pub overlap: [f64; 2],
    /// Root mean square distance of those points from the surfaces, metres.
    pub residual_m: f64,
    /// Share of the newer cloud that stands in free space of the older one, and the reverse.
    pub free_space_violation: [f64; 2],
    /// Score of the best different pose, as a share of this one's.
    pub runner_up_ratio: f64,
    /// Number of directions of translation that are not observed, 0 to 3.
    pub degenerate_directions: usize,
    /// Information of the weakest direction of translation as a share of the strongest. Up to 0.03 in a bare corridor, whose walls are never
    /// quite flat.
    pub conditioning: f64,
    /// Distance of the result from the nearest guess, metres.
    pub correction_m: f64,
    /// Rotation between them, radians.
    pub correction_rad: f64,
    /// Squared Mahalanobis distance from the pose that the graph expected, if it expected one.
    pub mahalanobis_squared: Option<f64>,
}

impl PairEvidence {
    /// Without any figures.
    pub fn empty(source: CandidateSource) -> Self {
        Self {
            source,
            score: 0.0,
            overlap: [0.0; 2],
            residual_m: 0.0,
            free_space_violation: [0.0; 2],
            runner_up_ratio: 0.0,
            degenerate_directions: 0,
            conditioning: 0.0,
            correction_m: 0.0,
            correction_rad: 0.0,
            mahalanobis_squared: None,
        }
    }
}

/// Result of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComparisonResult {
    /// Pose of the newer place in the older one.
    pub pose: Isometry,
    /// Its inverse covariance, `[rotation; translation]`.
    pub information: Matrix6,
    /// The figures on which it is decided.
    pub evidence: PairEvidence,
    /// Why it is rejected, if it is.
    pub rejection: Option<RejectionReason>,
}

/// A verified pair of keyframes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerifiedPair {
    /// The relative pose found, as an edge of the graph.
    pub edge: PoseGraphEdge,
    /// The figures on which it is decided.
    pub evidence: PairEvidence,
    /// Why it is rejected, if it is.
    pub rejection: Option<RejectionReason>,
}

/// Verifies a pair of keyframes, see [`compare`].
pub fn verify(task: &VerificationTask, gates: &VerificationConfig) -> VerifiedPair {
    VerifiedPair::new(task.from, task.to, &compare(&task.comparison, gates))
}

impl VerifiedPair {
    /// From the result of comparing two keyframes.
    pub fn new(from: KeyframeId, to: KeyframeId, compared: &ComparisonResult) -> Self {
        let edge = PoseGraphEdge { from, to, from_from_to: compared.pose, information: compared.information };
        Self { edge, evidence: compared.evidence, rejection: compared.rejection }
    }
}

/// Compares two places. Without points or guesses the result is [`RejectionReason::NoFit`].
pub fn compare(comparison: &Comparison, config: &VerificationConfig) -> ComparisonResult {
    let Comparison { source, guesses, expected, .. } = comparison;
    let (older, newer) = (comparison.older.get(), comparison.newer.get());
    let fits = register_coarsely(older, newer, guesses, config);
    let Some((best, runners_up)) = choose(&fits, expected.as_ref(), config) else {
        return no_fit(comparison);
    };
    let FineFit { pose, information, conditioning } =
        register_finely(older, newer, &best.map_from_body, comparison.tilt.as_ref(), config);
    // Equation 8.
    let information = information / config.correlated_points;
    let degenerate: Vec<Vector3> =
        degenerate_directions(&information, config.max_observed_std_m).into_iter().flatten().collect();
    let submaps = older.mean_covariance + newer.mean_covariance;
    let information = with_covariance_floor(&pose, &information, submaps, config);

    let back = pose.inverse();
    let (forth_overlap, residual_m) = overlap(older, newer, &pose, config);
    let (back_overlap, _) = overlap(newer, older, &back, config);
    let runner_up_ratio = runners_up
        .iter()
        .filter(|other| is_distinct(&pose, &other.map_from_body, &degenerate, config))
        .map(|other| other.score / best.score.max(1e-9))
        .fold(0.0, f64::max);
    let measured = UncertainPose::from_information(pose, &information);
    let (correction_m, correction_rad) = correction(guesses, &pose);
    let evidence = PairEvidence {
        source: *source,
        score: score_from_viewpoint(&older.map, &newer.points, &newer.viewpoint, &pose, &config.fine),
        overlap: [forth_overlap, back_overlap],
        residual_m,
        free_space_violation: [
            free_space_violation(older, &newer.points, &pose),
            free_space_violation(newer, &older.points, &back),
        ],
        runner_up_ratio,
        degenerate_directions: degenerate.len(),
        conditioning,
        correction_m,
        correction_rad,
        mahalanobis_squared: expected.and_then(|expected| expected.mahalanobis_squared(&measured)),
    };
    ComparisonResult { pose, information, rejection: rejection(&evidence, comparison, config), evidence }
}

fn no_fit(comparison: &Comparison) -> ComparisonResult {
    ComparisonResult {
        pose: comparison.guesses.first().copied().unwrap_or_else(Isometry::identity),
        information: Matrix6::zeros(),
        evidence: PairEvidence { degenerate_directions: 3, ..PairEvidence::empty(comparison.source) },
        rejection: Some(RejectionReason::NoFit),
    }
}

fn rejection(
    evidence: &PairEvidence,
    comparison: &Comparison,
    config: &VerificationConfig,
) -> Option<RejectionReason> {
    let worse = |pair: [f64; 2]| pair[0].max(pair[1]);
    let [a, b] = evidence.overlap;
    if a.max(b) < config.min_overlap_better || a.min(b) < config.min_overlap_worse {
        return Some(RejectionReason::Overlap);
    }
    if evidence.residual_m > config.max_residual_m {
        return Some(RejectionReason::Residual);
    }
    if worse(evidence.free_space_violation) > config.max_free_space_violation {
        return Some(RejectionReason::FreeSpaceViolation);
    }
    if evidence.runner_up_ratio > config.max_runner_up_ratio {
        return Some(RejectionReason::Ambiguous);
    }
    // A degenerate direction keeps the value of the guess, without information. Only the graph's guess is meaningful there.
    let is_known = comparison.expected.is_some_and(|e| e.translation_std_m() <= config.max_degenerate_std_m);
    let is_held =
        evidence.degenerate_directions == 1 && comparison.source == CandidateSource::Geometry && is_known;
    (evidence.degenerate_directions > 0 && !is_held).then_some(RejectionReason::Degenerate)
}

/// Coarse registrations from all starts, best first.
fn register_coarsely(
    older: &Submap,
    newer: &Submap,
    guesses: &[Isometry],
    config: &VerificationConfig,
) -> Vec<Fit> {
    let stride = newer.points.len().div_ceil(config.coarse_points).max(1);
    let few: Vec<[f32; 3]> = newer.points.iter().step_by(stride).copied().collect();
    if few.is_empty() || older.map.is_empty() {
        return Vec::new();
    }
    let offset = config.start_offset_m;
    let mut fits: Vec<Fit> = guesses
        .iter()
        .filter(|guess| guess.to_homogeneous().iter().all(|c| c.is_finite()))
        .flat_map(|guess| {
            [(0.0, 0.0), (offset, 0.0), (-offset, 0.0), (0.0, offset), (0.0, -offset)].map(|(x, y)| {
                let moved = guess.translation.vector + Vector3::new(x, y, 0.0);
                Isometry::from_parts(Translation3::from(moved), guess.rotation)
            })
        })
        .map(|start| {
            let (matching, steps) = (&config.coarse, config.coarse_steps);
            refine_from_viewpoint(&older.map, &few, &newer.viewpoint, &start, matching, steps)
        })
        .collect();
    // Stable: of equal scores the earlier start comes first.
    fits.sort_by(|a, b| b.score.total_cmp(&a.score));
    fits
}

/// Result of the fine registration.
struct FineFit {
    pose: Isometry,
    /// Information in the observed directions.
    information: Matrix6,
    conditioning: f64,
}

/// Gauss-Newton on all points and the vertical, in the observed directions only. The vertical is one measurement, but the information of the points
/// counts each of them, so it is scaled like theirs.
fn register_finely(
    older: &Submap,
    newer: &Submap,
    start: &Isometry,
    tilt: Option<&RelativeTilt>,
    config: &VerificationConfig,
) -> FineFit {
    let (mut information, mut conditioning) = (Matrix6::zeros(), 0.0);
    let iteration = &config.fine_iteration;
    let pose = gauss_newton(*start, &config.fine, iteration, |pose, matching| {
        let equations = linearise_from_viewpoint(&older.map, &newer.points, pose, &newer.viewpoint, matching);
        let observed = ObservedPart::new(&equations.information, config.min_conditioning);
        conditioning = observed.conditioning;
        information = observed.projection * equations.information * observed.projection;
        let mut gradient = observed.projection * equations.gradient;
        if let Some(tilt) = tilt {
            let (tilt_information, tilt_gradient) = tilt.linearise(pose, config.tilt_std_rad);
            information += tilt_information * config.correlated_points;
            gradient += tilt_gradient * config.correlated_points;
        }
        // By the information before the projection, which the degenerate directions do not reduce.
        let damping = iteration.damping(&equations.information);
        let step = GaussNewtonConfig::solve_damped(&information, &gradient, damping)?;
        Some((se3::retract(pose, &step), step.norm()))
    });
    FineFit { pose, information, conditioning }
}

/// The directions in which an information matrix is more than noise.
struct ObservedPart {
    /// Projection that removes the directions of translation that are not observed.
    projection: Matrix6,
    /// Information of the weakest direction of translation as a share of the strongest.
    conditioning: f64,
}

impl ObservedPart {
    /// Considers translations only: gravity observes roll and pitch, and how well a rotation about a corridor's axis is observed depends on the
    /// corridor's width.
    fn new(information: &Matrix6, min_conditioning: f64) -> Self {
        let eigen = SymmetricEigen::new(information.fixed_view::<3, 3>(3, 3).into_owned());
        let greatest = eigen.eigenvalues.max().max(f64::MIN_POSITIVE);
        let mut projection = Matrix6::identity();
        for (value, direction) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            if *value < min_conditioning * greatest {
                let mut block = projection.fixed_view_mut::<3, 3>(3, 3);
                block -= direction * direction.transpose();
            }
        }
        Self { projection, conditioning: (eigen.eigenvalues.min() / greatest).max(0.0) }
    }
}

/// The best of the registrations that the graph allows, unless one that it forbids is clearly better; and all others that count as runners-up.
/// If the graph allows the best one, only those that it allows count.
fn choose(
    fits: &[Fit],
    expected: Option<&UncertainPose>,
    config: &VerificationConfig,
) -> Option<(Fit, Vec<Fit>)> {
    let is_allowed = |fit: &Fit| {
        let covariance = diagonal_covariance(config.coarse_rotation_std_rad, config.coarse_translation_std_m);
        let measured = UncertainPose { pose: fit.map_from_body, covariance };
        expected.is_none_or(|e| {
            e.mahalanobis_squared(&measured).is_some_and(|squared| squared <= CHI_SQUARED_6_999)
        })
    };
    let top = fits.first()?;
    let is_chosen = |fit: &&Fit| is_allowed(fit) && fit.score >= config.max_runner_up_ratio * top.score;
    let best = fits.iter().find(is_chosen).unwrap_or(top);
    let all_count = !is_allowed(best);
    let runners_up =
        fits.iter().filter(|fit| *fit != best && (all_count || is_allowed(fit))).copied().collect();
    Some((*best, runners_up))
}

/// The information after adding the covariance that no number of points removes (equation 9): that of motion correction, and that of the
/// submaps' own poses.
fn with_covariance_floor(
    pose: &Isometry,
    information: &Matrix6,
    submaps: Matrix6,
    config: &VerificationConfig,
) -> Matrix6 {
    let floor = diagonal_covariance(config.floor_rotation_std_rad, config.floor_translation_std_m);
    let covariance = UncertainPose::from_information(*pose, information).covariance
        + floor
        + submaps * config.submap_covariance_share;
    covariance.cholesky().map_or_else(Matrix6::zeros, |factor| {
        let inverse = factor.inverse();
        (inverse + inverse.transpose()) * 0.5
    })
}

/// Share of a keyframe's points that lie on a surface of another submap, and the root mean square distance of those on planes, metres.
fn overlap(
    submap: &Submap,
    other: &Submap,
    submap_from_other: &Isometry,
    config: &VerificationConfig,
) -> (f64, f64) {
    let rotation = submap_from_other.rotation.to_rotation_matrix();
    let translation = submap_from_other.translation.vector;
    let viewpoint = rotation * other.viewpoint + translation;
    let gate_m = config.surface_distance_m;
    let (mut on, mut sum, mut flat) = (0_usize, 0.0, 0_usize);
    for point in &other.points {
        let p = rotation * Vector3::from(point.map(f64::from)) + translation;
        match submap.map.find_surface_facing(p.as_ref(), viewpoint.as_ref(), gate_m) {
            Some(Surface::Plane { distance, .. }) if distance.abs() <= gate_m => {
                on += 1;
                flat += 1;
                sum += f64::from(distance * distance);
            }
            Some(Surface::Distribution { offset, .. }) => {
                // Cells that are not flat are 25 cm wide, so a point up to twice the gate away lies on them.
                on += usize::from(offset.iter().map(|c| c * c).sum::<f32>() <= 4.0 * gate_m * gate_m);
            }
            Some(Surface::Plane { .. }) | None => {}
        }
    }
    (on as f64 / other.points.len().max(1) as f64, (sum / flat.max(1) as f64).sqrt())
}

/// Of the points that a submap's scans could see, the share that stands in their free space. Every second scan and point is used.
fn free_space_violation(submap: &Submap, points: &[[f32; 3]], submap_from_body: &Isometry) -> f64 {
    let (mut violations, mut counted) = (0_usize, 0_usize);
    let views: Vec<_> = submap
        .members
        .iter()
        .step_by(2)
        .map(|(submap_from_member, cloud)| {
            let member_from_body = submap_from_member.inverse() * submap_from_body;
            let rotation = member_from_body.rotation.to_rotation_matrix().into_inner().map(|v| v as f32);
            (rotation, member_from_body.translation.vector.map(|v| v as f32), cloud.view())
        })
        .collect();
    for point in points.iter().step_by(2) {
        let (mut free, mut occupied) = (0, 0);
        for (rotation, translation, view) in &views {
            let moved = rotation * nalgebra::Vector3::from(*point) + translation;
            match view.classify(&[moved.x, moved.y, moved.z]) {
                Occupancy::Free => free += 1,
                Occupancy::Occupied => occupied += 1,
                Occupancy::Occluded | Occupancy::Unobserved => {}
            }
        }
        counted += usize::from(free + occupied > 0);
        violations += usize::from(free > occupied);
    }
    violations as f64 / counted.max(1) as f64
}

/// Whether two poses differ in the observed directions.
fn is_distinct(a: &Isometry, b: &Isometry, degenerate: &[Vector3], config: &VerificationConfig) -> bool {
    let error = se3::local(a, b);
    let mut shift: Vector3 = error.fixed_rows::<3>(3).into_owned();
    for direction in degenerate {
        shift -= direction * direction.dot(&shift);
    }
    shift.norm() > config.distinct_m || error.fixed_rows::<3>(0).norm() > config.distinct_rad
}

/// Distance and rotation of a result from the nearest guess, metres and radians.
fn correction(guesses: &[Isometry], pose: &Isometry) -> (f64, f64) {
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
#[path = "verification_tests.rs"]
mod tests;
