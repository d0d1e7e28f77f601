//! Between the loop finder's types and those of the log.

use crate::mapping_phase::rows;
use geometry::{Isometry, Matrix6, isometry_from_pose, pose_from_isometry, vec_to_plain};
use mapping::{
    CandidateSource, ComparisonResult, Evidence, RejectionReason, Revisit, Verdict, VerificationTask,
    VerifiedPair,
};
use messages::{
    ComparedRevisit, LoopEvidence, LoopRejection, LoopSource, LoopTask, LoopVerdict, MapQuality, RevisitTask,
    SurveyReason, SurveyTarget, VerifiedLoop,
};
use vocab::{Pose, SessionId, Stamp};

/// What is asked of a job, for the log.
pub(crate) fn task_to_plain(session: SessionId, task: &VerificationTask) -> LoopTask {
    let source = source_to_plain(task.comparison.source);
    LoopTask { session, from: task.from, to: task.to, source, guess: guess_of(&task.comparison.guesses) }
}

/// The same of a visit made at `stamp`.
pub(crate) fn visit_to_plain(session: SessionId, stamp: Stamp, visit: &Revisit) -> RevisitTask {
    let guess = guess_of(&visit.comparison.guesses);
    RevisitTask { session, visit: visit.number, stamp, keyframe: visit.keyframe, guess }
}

fn guess_of(guesses: &[Isometry]) -> Pose {
    guesses.first().map_or(Pose::IDENTITY, pose_from_isometry)
}

/// What came out, for the log.
pub(crate) fn verified_to_plain(asked: &LoopTask, compared: &ComparisonResult) -> VerifiedLoop {
    VerifiedLoop {
        task: *asked,
        from_from_to: pose_from_isometry(&compared.pose),
        information: rows(&compared.information),
        evidence: evidence_to_plain(&compared.evidence),
        rejection: compared.rejection.map(rejection_to_plain),
    }
}

/// The same of a visit.
pub(crate) fn compared_to_plain(asked: &RevisitTask, compared: &ComparisonResult) -> ComparedRevisit {
    ComparedRevisit {
        task: *asked,
        keyframe_from_base: pose_from_isometry(&compared.pose),
        information: rows(&compared.information),
        evidence: evidence_to_plain(&compared.evidence),
        rejection: compared.rejection.map(rejection_to_plain),
    }
}

/// And back; none when its pose is not one.
pub(crate) fn verified_from_plain(plain: &VerifiedLoop) -> Option<VerifiedPair> {
    let compared = ComparisonResult {
        pose: isometry_from_pose(&plain.from_from_to)?,
        information: from_rows(&plain.information),
        evidence: evidence_from_plain(&plain.evidence, plain.task.source),
        rejection: plain.rejection.map(rejection_from_plain),
    };
    Some(VerifiedPair::new(plain.task.from, plain.task.to, &compared))
}

/// And back; none when its pose is not one.
pub(crate) fn compared_from_plain(plain: &ComparedRevisit) -> Option<ComparisonResult> {
    Some(ComparisonResult {
        pose: isometry_from_pose(&plain.keyframe_from_base)?,
        information: from_rows(&plain.information),
        evidence: evidence_from_plain(&plain.evidence, LoopSource::Geometry),
        rejection: plain.rejection.map(rejection_from_plain),
    })
}

pub(crate) fn from_rows(rows: &[[f64; 6]; 6]) -> Matrix6 {
    Matrix6::from_fn(|row, column| rows[row][column])
}

/// The finder's evidence but for its source, which is the task's.
pub(crate) fn evidence_to_plain(evidence: &Evidence) -> LoopEvidence {
    LoopEvidence {
        score: evidence.score,
        overlap: evidence.overlap,
        residual: evidence.residual,
        through: evidence.through,
        rival: evidence.rival,
        blind: evidence.blind as u32,
        grip: evidence.grip,
        moved: evidence.moved,
        surprise: evidence.surprise,
    }
}

fn evidence_from_plain(evidence: &LoopEvidence, source: LoopSource) -> Evidence {
    Evidence {
        source: source_from_plain(source),
        score: evidence.score,
        overlap: evidence.overlap,
        residual: evidence.residual,
        through: evidence.through,
        rival: evidence.rival,
        blind: evidence.blind as usize,
        grip: evidence.grip,
        moved: evidence.moved,
        surprise: evidence.surprise,
    }
}

pub(crate) fn verdict_to_plain(verdict: Verdict) -> LoopVerdict {
    match verdict {
        Verdict::Accepted => LoopVerdict::Accepted,
        Verdict::Held => LoopVerdict::Held,
        Verdict::Rejected(_) => LoopVerdict::Rejected,
        Verdict::Dropped => LoopVerdict::Dropped,
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

fn rejection_to_plain(rejection: RejectionReason) -> LoopRejection {
    match rejection {
        RejectionReason::NoFit => LoopRejection::NoFit,
        RejectionReason::Overlap => LoopRejection::Overlap,
        RejectionReason::Residual => LoopRejection::Residual,
        RejectionReason::FreeSpaceViolation => LoopRejection::FreeSpaceViolation,
        RejectionReason::Ambiguous => LoopRejection::Ambiguous,
        RejectionReason::Degenerate => LoopRejection::Degenerate,
    }
}

fn rejection_from_plain(rejection: LoopRejection) -> RejectionReason {
    match rejection {
        LoopRejection::NoFit => RejectionReason::NoFit,
        LoopRejection::Overlap => RejectionReason::Overlap,
        LoopRejection::Residual => RejectionReason::Residual,
        LoopRejection::FreeSpaceViolation => RejectionReason::FreeSpaceViolation,
        LoopRejection::Ambiguous => RejectionReason::Ambiguous,
        LoopRejection::Degenerate => RejectionReason::Degenerate,
    }
}

/// How good a map is, for clients.
pub(crate) fn quality_to_plain(quality: mapping::MapQuality) -> MapQuality {
    let place = |place: &mapping::SurveyTarget| SurveyTarget {
        at: vec_to_plain(&place.at),
        why: match place.why {
            mapping::SurveyReason::FromAfar(area) => SurveyReason::FromAfar(area),
            mapping::SurveyReason::Unsure(deviation) => SurveyReason::Unsure(deviation),
        },
    };
    let mapping::MapQuality { covered, from_afar, deviations, places } = quality;
    MapQuality { covered, from_afar, deviations, places: places.iter().map(place).collect() }
}
