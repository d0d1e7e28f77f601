//! ComputeJob that is too long for a step, as it leaves the stack.

use crate::localisation_phase::run_work;
use crate::loops::plain;
use crate::mapping_phase::rows;
use geometry::pose_from_isometry;
use localisation::LocalisationWork;
use mapping::{AlignmentError, Comparison, MapMatcher, VerificationConfig, compare};
use messages::{JobResult, LoopTask, MapSearchOutcome, MapSearchResult, MapSearchTask, RevisitTask};
use vocab::MapId;

/// What a job takes, owned: may run anywhere and at any time. Its result goes back as `Input::JobDone`.
#[derive(Debug)]
pub struct ComputeJob(Kind);

#[derive(Debug)]
enum Kind {
    Compare { asked: Asked, comparison: Comparison, gates: VerificationConfig },
    Seek(Box<Seek>),
    Localise { map: MapId, work: Box<LocalisationWork> },
}

/// What was asked of a job.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Asked {
    Loop(LoopTask),
    Revisit(RevisitTask),
}

impl Asked {
    /// Whether it is about a pair of keyframes.
    pub fn is_pair(&self) -> bool {
        matches!(self, Self::Loop(_))
    }
}

/// A search for what was walked in a saved map.
#[derive(Debug)]
pub(crate) struct Seek {
    pub task: MapSearchTask,
    pub chart: MapMatcher,
    pub walked: MapMatcher,
    /// Number of the first waypoint of `walked`.
    pub first: u64,
    pub gates: VerificationConfig,
}

impl ComputeJob {
    pub(crate) fn new(asked: Asked, comparison: Comparison, gates: VerificationConfig) -> Self {
        Self(Kind::Compare { asked, comparison, gates })
    }

    pub(crate) fn seek(seek: Seek) -> Self {
        Self(Kind::Seek(Box::new(seek)))
    }

    pub(crate) fn localise(map: MapId, work: LocalisationWork) -> Self {
        Self(Kind::Localise { map, work: Box::new(work) })
    }

    /// Does the work: a pure function of what it owns. 5 to 25 ms for a comparison; a search makes three or more for
    /// every other metre walked.
    pub fn run(self) -> JobResult {
        match self.0 {
            Kind::Compare { asked, comparison, gates } => {
                let compared = compare(&comparison, &gates);
                match &asked {
                    Asked::Loop(asked) => {
                        JobResult::LoopVerified(Box::new(plain::verified_to_plain(asked, &compared)))
                    }
                    Asked::Revisit(asked) => {
                        JobResult::RevisitCompared(Box::new(plain::compared_to_plain(asked, &compared)))
                    }
                }
            }
            Kind::Localise { map, work } => run_work(map, &work),
            Kind::Seek(seek) => {
                let task = seek.task;
                JobResult::MapSearched(MapSearchResult { task, found: seek.run() })
            }
        }
    }
}

impl Seek {
    fn run(mut self) -> MapSearchOutcome {
        let joint = match self.chart.find(&mut self.walked, &self.gates) {
            Ok(joint) => joint,
            Err(AlignmentError::TooFew(count)) => return MapSearchOutcome::NotFound(count as u32),
            Err(AlignmentError::Ambiguous(count, rival)) => {
                return MapSearchOutcome::Ambiguous(count as u32, rival as u32);
            }
        };
        // The newest, because odometry is believed from there on.
        let Some(link) = joint.links.iter().max_by_key(|link| link.to) else {
            return MapSearchOutcome::NotFound(0);
        };
        MapSearchOutcome::Found {
            keyframe: link.from,
            waypoint: self.first + u64::from(link.to.0),
            keyframe_from_base: pose_from_isometry(&link.from_from_to),
            information: rows(&link.information),
            places: joint.support as u32,
            elsewhere: joint.rival as u32,
        }
    }
}
