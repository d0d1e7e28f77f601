//! Conversion between the types of `mapping` and the plain messages of the log and the clients.

use crate::loop_texts;
use geometry::{
    Isometry, Matrix6, isometry_from_pose, isometry_from_unit_pose, pose_from_isometry, vec_to_plain,
};
use mapping::{
    AlignmentError, CandidateSource, ComparisonResult, GraphChanges, LoopOutcome, LoopRecord, MapAlignment,
    MapSearchFix, PairEvidence, PoseGraphEdge, QueuedComparison, RejectionReason, Session, UncertainPose,
    Verdict, VerificationConfig,
};
use messages::{
    ComparedRevisit, EdgeKind, GraphDelta, GraphEdge, GraphNode, Job, LoopDecision, LoopEvidence,
    LoopRejection, LoopSource, LoopTask, LoopVerdict, MapQuality, MapSearchOutcome, PlaceComparison,
    PoseCorrection, PoseGraph, RevisitTask, SurveyReason, SurveyTarget, VerifiedLoop,
};
use vocab::{Pose, SessionId};

/// What a comparison is about.
#[derive(Clone, Copy, Debug)]
pub(crate) enum ComparisonTask {
    Loop(LoopTask),
    Revisit(RevisitTask),
}

impl ComparisonTask {
    pub fn new(session: SessionId, queued: &QueuedComparison) -> Self {
        match *queued {
            QueuedComparison::Pair { from, to, source, guess } => {
                let (source, guess) = (source_to_plain(source), pose_from_isometry(&guess));
                Self::Loop(LoopTask { session, from, to, source, guess })
            }
            QueuedComparison::Revisit { waypoint, stamp, keyframe, guess } => {
                let guess = pose_from_isometry(&guess);
                Self::Revisit(RevisitTask { session, waypoint, stamp, keyframe, guess })
            }
        }
    }

    /// The job that compares.
    pub fn job(self) -> Job {
        match self {
            Self::Loop(task) => Job::VerifyLoop(task),
            Self::Revisit(task) => Job::CompareRevisit(task),
        }
    }

    /// Its result.
    pub fn result(self, result: &ComparisonResult) -> PlaceComparison {
        match self {
            Self::Loop(task) => PlaceComparison::Loop(Box::new(verified_to_plain(&task, result))),
            Self::Revisit(task) => PlaceComparison::Revisit(Box::new(compared_to_plain(&task, result))),
        }
    }
}

/// The result of comparing a pair.
fn verified_to_plain(task: &LoopTask, result: &ComparisonResult) -> VerifiedLoop {
    VerifiedLoop {
        task: *task,
        from_from_to: pose_from_isometry(&result.pose),
        information: rows(&result.information),
        evidence: evidence_to_plain(&result.evidence),
        rejection: result.rejection.map(rejection_to_plain),
    }
}

/// The result of comparing a revisit.
fn compared_to_plain(task: &RevisitTask, result: &ComparisonResult) -> ComparedRevisit {
    ComparedRevisit {
        task: *task,
        keyframe_from_base: pose_from_isometry(&result.pose),
        information: rows(&result.information),
        evidence: evidence_to_plain(&result.evidence),
        rejection: result.rejection.map(rejection_to_plain),
    }
}

/// The result of comparing a pair; `None` if its pose is not finite.
pub(crate) fn verified_from_plain(plain: &VerifiedLoop) -> Option<ComparisonResult> {
    Some(ComparisonResult {
        pose: isometry_from_pose(&plain.from_from_to)?,
        information: from_rows(&plain.information),
        evidence: evidence_from_plain(&plain.evidence, plain.task.source),
        rejection: plain.rejection.map(rejection_from_plain),
    })
}

/// The result of comparing a revisit; `None` if its pose is not finite.
pub(crate) fn compared_from_plain(plain: &ComparedRevisit) -> Option<ComparisonResult> {
    Some(ComparisonResult {
        pose: isometry_from_pose(&plain.keyframe_from_base)?,
        information: from_rows(&plain.information),
        evidence: evidence_from_plain(&plain.evidence, LoopSource::Geometry),
        rejection: plain.rejection.map(rejection_from_plain),
    })
}

/// A decision, with its reason for people.
pub(crate) fn decision_to_plain(
    session: SessionId,
    record: &LoopRecord,
    config: &VerificationConfig,
) -> LoopDecision {
    let pair = &record.pair;
    let task = LoopTask {
        session,
        from: pair.edge.from,
        to: pair.edge.to,
        source: source_to_plain(pair.source),
        guess: pose_from_isometry(&pair.guess),
    };
    let (verdict, by_hand) = match record.outcome {
        LoopOutcome::AcceptedByPerson => (LoopVerdict::Accepted, true),
        LoopOutcome::RejectedByPerson => (LoopVerdict::Rejected, true),
        LoopOutcome::Decided(Verdict::Accepted) => (LoopVerdict::Accepted, false),
        LoopOutcome::Decided(Verdict::Held) => (LoopVerdict::Held, false),
        LoopOutcome::Decided(Verdict::Rejected(_)) => (LoopVerdict::Rejected, false),
        LoopOutcome::Decided(Verdict::Dropped) => (LoopVerdict::Dropped, false),
    };
    LoopDecision {
        task,
        from_from_to: pose_from_isometry(&pair.edge.from_from_to),
        evidence: evidence_to_plain(&pair.evidence),
        verdict,
        by_hand,
        reason: loop_texts::reason(record, config),
    }
}

/// The outcome of a search in a finished map.
pub(crate) fn search_to_plain(found: Result<(MapAlignment, u64), AlignmentError>) -> MapSearchOutcome {
    let (alignment, first_waypoint) = match found {
        Ok(found) => found,
        Err(AlignmentError::TooFew(count)) => return MapSearchOutcome::NotFound(count as u32),
        Err(AlignmentError::Ambiguous(count, runner_up)) => {
            return MapSearchOutcome::Ambiguous(count as u32, runner_up as u32);
        }
    };
    // The newest link, because the pose follows odometry from there on.
    let Some(link) = alignment.links.iter().max_by_key(|link| link.to) else {
        return MapSearchOutcome::NotFound(0);
    };
    MapSearchOutcome::Found {
        keyframe: link.from,
        waypoint: first_waypoint + u64::from(link.to.0),
        keyframe_from_base: pose_from_isometry(&link.from_from_to),
        information: rows(&link.information),
        support: alignment.support as u32,
        runner_up_support: alignment.runner_up_support as u32,
    }
}

/// The pose that a search found, if it did.
pub(crate) fn fix_from_plain(found: &MapSearchOutcome) -> Option<MapSearchFix> {
    let MapSearchOutcome::Found { keyframe, waypoint, keyframe_from_base, information, .. } = found else {
        return None;
    };
    let pose = isometry_from_pose(keyframe_from_base)?;
    let keyframe_from_waypoint = UncertainPose::from_information(pose, &from_rows(information));
    Some(MapSearchFix { waypoint: *waypoint, keyframe: *keyframe, keyframe_from_waypoint })
}

/// The poses of all `count` keyframes, to the last bit as they were solved; none if there are others, or one is no pose.
pub(crate) fn relinearised_from_plain(poses: &[Pose], count: usize) -> Option<Vec<Isometry>> {
    if poses.len() != count {
        return None;
    }
    poses.iter().map(isometry_from_unit_pose).collect()
}

/// The pose graph of a session.
pub(crate) fn graph_to_plain(session: &Session) -> PoseGraph {
    let graph = session.graph();
    PoseGraph {
        revision: graph.revision(),
        nodes: graph.nodes().iter().map(node_to_plain).collect(),
        edges: edges_to_plain(graph.edges(), EdgeKind::Odometry)
            .chain(edges_to_plain(graph.loops(), EdgeKind::Loop))
            .collect(),
    }
}

fn edges_to_plain(edges: &[PoseGraphEdge], kind: EdgeKind) -> impl Iterator<Item = GraphEdge> {
    edges.iter().map(move |edge| GraphEdge {
        from: edge.from,
        to: edge.to,
        kind,
        from_from_to: pose_from_isometry(&edge.from_from_to),
        information: rows(&edge.information),
    })
}

/// Changes of the pose graph of a session.
pub(crate) fn changes_to_plain(session: SessionId, changes: &GraphChanges) -> GraphDelta {
    GraphDelta {
        session,
        base_revision: changes.base_revision,
        revision: changes.revision,
        nodes: changes.nodes.iter().map(node_to_plain).collect(),
        removed_loops: changes.removed_loops.clone(),
        edges: edges_to_plain(&changes.edges, EdgeKind::Odometry)
            .chain(edges_to_plain(&changes.loops, EdgeKind::Loop))
            .collect(),
    }
}

fn node_to_plain(node: &mapping::PoseGraphNode) -> GraphNode {
    GraphNode {
        id: node.id,
        stamp: node.stamp,
        map_from_keyframe: pose_from_isometry(&node.map_from_keyframe),
    }
}

/// The quality of a map whose pose graph had this revision.
pub(crate) fn quality_to_plain(revision: u64, quality: &mapping::MapQuality) -> MapQuality {
    let target = |target: &mapping::SurveyTarget| SurveyTarget {
        at: vec_to_plain(&target.position),
        why: match target.reason {
            mapping::SurveyReason::FromAfar(area_m2) => SurveyReason::FromAfar { area_m2 },
            mapping::SurveyReason::Uncertain(deviation_m) => SurveyReason::Uncertain { deviation_m },
        },
    };
    MapQuality {
        revision,
        covered_m2: quality.covered_m2,
        from_afar_m2: quality.from_afar_m2,
        deviations_m: quality.deviations_m.clone(),
        targets: quality.targets.iter().map(target).collect(),
    }
}

/// Row-major rows of a matrix.
pub(crate) fn rows(matrix: &Matrix6) -> [[f64; 6]; 6] {
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[(row, column)]))
}

/// A matrix from its rows.
pub(crate) fn from_rows(rows: &[[f64; 6]; 6]) -> Matrix6 {
    Matrix6::from_fn(|row, column| rows[row][column])
}

/// The figures without the source, which is in the task.
fn evidence_to_plain(evidence: &PairEvidence) -> LoopEvidence {
    LoopEvidence {
        score: evidence.score,
        overlap: evidence.overlap,
        residual_m: evidence.residual_m,
        free_space_violation: evidence.free_space_violation,
        runner_up_ratio: evidence.runner_up_ratio,
        degenerate_directions: evidence.degenerate_directions as u32,
        conditioning: evidence.conditioning,
        correction: PoseCorrection {
            distance_m: evidence.correction_m,
            rotation_rad: evidence.correction_rad,
        },
        mahalanobis_squared: evidence.mahalanobis_squared,
    }
}

fn evidence_from_plain(evidence: &LoopEvidence, source: LoopSource) -> PairEvidence {
    PairEvidence {
        source: source_from_plain(source),
        score: evidence.score,
        overlap: evidence.overlap,
        residual_m: evidence.residual_m,
        free_space_violation: evidence.free_space_violation,
        runner_up_ratio: evidence.runner_up_ratio,
        degenerate_directions: evidence.degenerate_directions as usize,
        conditioning: evidence.conditioning,
        correction_m: evidence.correction.distance_m,
        correction_rad: evidence.correction.rotation_rad,
        mahalanobis_squared: evidence.mahalanobis_squared,
    }
}

fn source_to_plain(source: CandidateSource) -> LoopSource {
    match source {
        CandidateSource::Geometry => LoopSource::Geometry,
        CandidateSource::Appearance(distance) => LoopSource::Appearance(distance),
        CandidateSource::Person => LoopSource::Person,
    }
}

fn source_from_plain(source: LoopSource) -> CandidateSource {
    match source {
        LoopSource::Geometry => CandidateSource::Geometry,
        LoopSource::Appearance(distance) => CandidateSource::Appearance(distance),
        LoopSource::Person => CandidateSource::Person,
    }
}

fn rejection_to_plain(reason: RejectionReason) -> LoopRejection {
    match reason {
        RejectionReason::NoFit => LoopRejection::NoFit,
        RejectionReason::Overlap => LoopRejection::Overlap,
        RejectionReason::Residual => LoopRejection::Residual,
        RejectionReason::FreeSpaceViolation => LoopRejection::FreeSpaceViolation,
        RejectionReason::Ambiguous => LoopRejection::Ambiguous,
        RejectionReason::Degenerate => LoopRejection::Degenerate,
    }
}

fn rejection_from_plain(reason: LoopRejection) -> RejectionReason {
    match reason {
        LoopRejection::NoFit => RejectionReason::NoFit,
        LoopRejection::Overlap => RejectionReason::Overlap,
        LoopRejection::Residual => RejectionReason::Residual,
        LoopRejection::FreeSpaceViolation => RejectionReason::FreeSpaceViolation,
        LoopRejection::Ambiguous => RejectionReason::Ambiguous,
        LoopRejection::Degenerate => RejectionReason::Degenerate,
    }
}

#[cfg(test)]
#[path = "mapping_messages_tests.rs"]
mod tests;
