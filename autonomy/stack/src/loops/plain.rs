//! Between the loop finder's types and those of the log.

use crate::mapping_phase::rows;
use geometry::{Matrix6, isometry_from_pose, pose_from_isometry};
use mapping::{Edge, Evidence, Flaw, Source, Task, Verdict, Verified};
use messages::{LoopEvidence, LoopFlaw, LoopSource, LoopTask, LoopVerdict, VerifiedLoop};
use vocab::{Pose, SessionId};

/// What is asked of a job, for the log.
pub(crate) fn task_to_plain(session: SessionId, task: &Task) -> LoopTask {
    let guess = task.guesses.first().map_or(Pose::IDENTITY, pose_from_isometry);
    LoopTask { session, from: task.from, to: task.to, source: source_to_plain(task.source), guess }
}

/// What came out, for the log.
pub(crate) fn verified_to_plain(asked: &LoopTask, verified: &Verified) -> VerifiedLoop {
    VerifiedLoop {
        task: *asked,
        from_from_to: pose_from_isometry(&verified.edge.from_from_to),
        information: rows(&verified.edge.information),
        evidence: evidence_to_plain(&verified.evidence),
        flaw: verified.flaw.map(flaw_to_plain),
    }
}

/// And back; none when its pose is not one.
pub(crate) fn verified_from_plain(plain: &VerifiedLoop) -> Option<Verified> {
    let edge = Edge {
        from: plain.task.from,
        to: plain.task.to,
        from_from_to: isometry_from_pose(&plain.from_from_to)?,
        information: Matrix6::from_fn(|row, column| plain.information[row][column]),
    };
    let evidence = evidence_from_plain(&plain.evidence, plain.task.source);
    Some(Verified { edge, evidence, flaw: plain.flaw.map(flaw_from_plain) })
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

fn source_to_plain(source: Source) -> LoopSource {
    match source {
        Source::Geometry => LoopSource::Geometry,
        Source::Appearance(distance) => LoopSource::Appearance(distance),
        Source::Person => LoopSource::Person,
    }
}

fn source_from_plain(source: LoopSource) -> Source {
    match source {
        LoopSource::Geometry => Source::Geometry,
        LoopSource::Appearance(distance) => Source::Appearance(distance),
        LoopSource::Person => Source::Person,
    }
}

fn flaw_to_plain(flaw: Flaw) -> LoopFlaw {
    match flaw {
        Flaw::NoFit => LoopFlaw::NoFit,
        Flaw::Overlap => LoopFlaw::Overlap,
        Flaw::Residual => LoopFlaw::Residual,
        Flaw::SeenThrough => LoopFlaw::SeenThrough,
        Flaw::Rival => LoopFlaw::Rival,
        Flaw::Blind => LoopFlaw::Blind,
    }
}

fn flaw_from_plain(flaw: LoopFlaw) -> Flaw {
    match flaw {
        LoopFlaw::NoFit => Flaw::NoFit,
        LoopFlaw::Overlap => Flaw::Overlap,
        LoopFlaw::Residual => Flaw::Residual,
        LoopFlaw::SeenThrough => Flaw::SeenThrough,
        LoopFlaw::Rival => Flaw::Rival,
        LoopFlaw::Blind => Flaw::Blind,
    }
}
