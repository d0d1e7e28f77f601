//! Between the loop finder's types and those of the log.

use crate::mapping_phase::rows;
use geometry::{Isometry, Matrix6, isometry_from_pose, pose_from_isometry, vec_to_plain};
use mapping::{Compared, Evidence, Flaw, Quality, Source, Task, Verdict, Verified, Visit};
use messages::{
    ComparedVisit, LoopEvidence, LoopFlaw, LoopSource, LoopTask, LoopVerdict, MapQuality, PlaceToWalk,
    VerifiedLoop, VisitTask, WhyWalk,
};
use vocab::{Pose, SessionId, Stamp};

/// What is asked of a job, for the log.
pub(crate) fn task_to_plain(session: SessionId, task: &Task) -> LoopTask {
    let source = source_to_plain(task.comparison.source);
    LoopTask { session, from: task.from, to: task.to, source, guess: guess_of(&task.comparison.guesses) }
}

/// The same of a visit made at `stamp`.
pub(crate) fn visit_to_plain(session: SessionId, stamp: Stamp, visit: &Visit) -> VisitTask {
    let guess = guess_of(&visit.comparison.guesses);
    VisitTask { session, visit: visit.number, stamp, keyframe: visit.keyframe, guess }
}

fn guess_of(guesses: &[Isometry]) -> Pose {
    guesses.first().map_or(Pose::IDENTITY, pose_from_isometry)
}

/// What came out, for the log.
pub(crate) fn verified_to_plain(asked: &LoopTask, compared: &Compared) -> VerifiedLoop {
    VerifiedLoop {
        task: *asked,
        from_from_to: pose_from_isometry(&compared.pose),
        information: rows(&compared.information),
        evidence: evidence_to_plain(&compared.evidence),
        flaw: compared.flaw.map(flaw_to_plain),
    }
}

/// The same of a visit.
pub(crate) fn compared_to_plain(asked: &VisitTask, compared: &Compared) -> ComparedVisit {
    ComparedVisit {
        task: *asked,
        keyframe_from_base: pose_from_isometry(&compared.pose),
        information: rows(&compared.information),
        evidence: evidence_to_plain(&compared.evidence),
        flaw: compared.flaw.map(flaw_to_plain),
    }
}

/// And back; none when its pose is not one.
pub(crate) fn verified_from_plain(plain: &VerifiedLoop) -> Option<Verified> {
    let compared = Compared {
        pose: isometry_from_pose(&plain.from_from_to)?,
        information: from_rows(&plain.information),
        evidence: evidence_from_plain(&plain.evidence, plain.task.source),
        flaw: plain.flaw.map(flaw_from_plain),
    };
    Some(Verified::new(plain.task.from, plain.task.to, &compared))
}

/// And back; none when its pose is not one.
pub(crate) fn compared_from_plain(plain: &ComparedVisit) -> Option<Compared> {
    Some(Compared {
        pose: isometry_from_pose(&plain.keyframe_from_base)?,
        information: from_rows(&plain.information),
        evidence: evidence_from_plain(&plain.evidence, LoopSource::Geometry),
        flaw: plain.flaw.map(flaw_from_plain),
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

/// How good a map is, for clients.
pub(crate) fn quality_to_plain(quality: Quality) -> MapQuality {
    let place = |place: &mapping::PlaceToWalk| PlaceToWalk {
        at: vec_to_plain(&place.at),
        why: match place.why {
            mapping::WhyWalk::FromAfar(area) => WhyWalk::FromAfar(area),
            mapping::WhyWalk::Unsure(deviation) => WhyWalk::Unsure(deviation),
        },
    };
    let Quality { covered, from_afar, deviations, places } = quality;
    MapQuality { covered, from_afar, deviations, places: places.iter().map(place).collect() }
}
