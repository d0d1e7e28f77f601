//! What is asked of a known map: where one scan may have been taken.
//!
//! Answering takes a tenth of a second or more, so it is a job: whatever it needs leaves the stack with it, and its answer comes back as
//! an input.

use crate::odometry_adapter::LocatedScan;
use crate::periodic_global_check::find_contradicting_hypotheses;
use crate::request_progress::RequestProgress;
use crate::work::ComputeJob;
use geometry::{Isometry, isometry_from_pose, pose_from_isometry, so3};
use localisation::{
    GlobalLocaliser, LocalisationMap, PoseHypothesis, RelocalisationResult, classify_hypotheses,
};
use mapping::KeyframeDescriptor;
use messages::{RelocalisationResponse, RelocalisationTask};
use std::sync::{Arc, OnceLock};
use vocab::{MapId, Span, Stamp};

/// Where nothing was recognised, the question is asked again after so many metres or radians, or so long.
const AGAIN: (f64, f64) = (0.5, 0.5);
const AGAIN_AFTER: Span = Span::from_millis(2_000);
/// As far as keyframes' clouds reach, metres.
const READY: f64 = 64.0;

/// A known map, with what is made of it when it is first needed, by whoever needs it: the same whoever that is.
#[derive(Debug)]
pub(crate) struct SearchableMap {
    guide: Arc<LocalisationMap>,
    atlas: OnceLock<GlobalLocaliser>,
}

impl SearchableMap {
    /// Of keyframes, each with its pose in the map.
    pub fn new(keyframes: Vec<(Isometry, KeyframeDescriptor)>) -> Self {
        Self { guide: Arc::new(LocalisationMap::new(keyframes)), atlas: OnceLock::new() }
    }

    /// The map's surfaces and what its keyframes saw.
    pub fn guide(&self) -> &Arc<LocalisationMap> {
        &self.guide
    }

    fn atlas(&self) -> &GlobalLocaliser {
        self.atlas.get_or_init(|| GlobalLocaliser::new(Arc::clone(&self.guide)))
    }
}

/// What is thought of the robot's place when it asks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PosePrior {
    /// It may be anywhere.
    None,
    /// Somebody said that the base is about there.
    Given(Isometry),
    /// The contacts of a dock say that it is about one of these.
    AtDocks(Vec<Isometry>),
    /// The robot believes that the base is there, and wants to know whether it might be elsewhere.
    Tracked(Isometry),
}

/// A question, from when it comes up until the next one does.
#[derive(Debug)]
pub(crate) struct RelocalisationRequest {
    pub at: Stamp,
    pub number: u64,
    pub odom_from_base: Isometry,
    pub thought: PosePrior,
    place: KeyframeDescriptor,
    progress: RequestProgress,
}

impl RelocalisationRequest {
    /// About a located scan, of which `place` is made.
    pub fn new(located: &LocatedScan, place: KeyframeDescriptor, number: u64, thought: PosePrior) -> Self {
        let (at, odom_from_base) = (located.stamp, located.odom_from_base);
        Self { at, number, odom_from_base, thought, place, progress: RequestProgress::default() }
    }

    /// Whether it is time to ask again where nothing was recognised.
    pub fn is_stale(&self, located: &LocatedScan) -> bool {
        let moved = self.odom_from_base.inverse() * located.odom_from_base;
        let far = moved.translation.vector.norm() >= AGAIN.0 || so3::log(&moved.rotation).norm() >= AGAIN.1;
        self.progress == RequestProgress::Answered && (far || located.stamp - self.at >= AGAIN_AFTER)
    }

    /// Begins with a job, if it has not begun; says whether it did.
    pub fn start(&mut self, job: u64) -> bool {
        self.progress.start(job)
    }

    /// Whether it has not been answered.
    pub fn is_open(&self) -> bool {
        self.progress != RequestProgress::Answered
    }

    /// Whether a job answers it.
    pub fn is_answered_by(&self, job: u64) -> bool {
        self.progress.is_run_by(job)
    }

    /// Takes the answer, none if there is none: places, the best first.
    pub fn answered(&mut self, answer: Option<&RelocalisationResponse>) -> Vec<PoseHypothesis> {
        self.progress = RequestProgress::Answered;
        let read = |place: &messages::PoseHypothesis| {
            let map_from_base = isometry_from_pose(&place.map_from_base)?;
            Some(PoseHypothesis { map_from_base, fit: place.fit, contradicted: place.contradicted })
        };
        answer.map(|answer| answer.hypotheses.iter().filter_map(read).collect()).unwrap_or_default()
    }

    /// What its job takes.
    pub fn work(&self, map: MapId, ground: &Arc<SearchableMap>) -> ComputeJob {
        ComputeJob::relocalise(RelocalisationWork {
            task: RelocalisationTask { map, number: self.number },
            ground: Arc::clone(ground),
            odom_from_base: self.odom_from_base,
            place: self.place.clone(),
            thought: self.thought.clone(),
        })
    }
}

/// A question on its way.
#[derive(Debug)]
pub(crate) struct RelocalisationWork {
    pub task: RelocalisationTask,
    ground: Arc<SearchableMap>,
    odom_from_base: Isometry,
    place: KeyframeDescriptor,
    thought: PosePrior,
}

impl RelocalisationWork {
    /// Where the scan may have been taken: a pure function of what it owns, see [`GlobalLocaliser::seek`].
    pub fn run(self) -> RelocalisationResponse {
        let places = match &self.thought {
            PosePrior::Given(told) => self.seek_told(std::slice::from_ref(told)),
            PosePrior::AtDocks(docks) => self.seek_told(docks),
            PosePrior::Tracked(held) => {
                // Until it asks again the robot walks on ground that is ready.
                self.ground.guide().surfaces().make_about(&held.translation.vector, READY);
                self.seek(Some(held))
            }
            PosePrior::None => self.seek(None),
        };
        let plain = |one: &PoseHypothesis| messages::PoseHypothesis {
            map_from_base: pose_from_isometry(&one.map_from_base),
            fit: one.fit,
            contradicted: one.contradicted,
        };
        RelocalisationResponse { task: self.task, hypotheses: places.iter().map(plain).collect() }
    }

    fn seek(&self, held: Option<&Isometry>) -> Vec<PoseHypothesis> {
        self.ground.atlas().seek(&self.place, &self.odom_from_base.rotation, held)
    }

    /// Where somebody said, if the scan fits there: nobody need wait to see that until the whole map is searched for look-alikes,
    /// which the robot asks for next. Else wherever it fits better.
    fn seek_told(&self, told: &[Isometry]) -> Vec<PoseHypothesis> {
        let about = self.ground.guide().seek_about(&self.place, told);
        if matches!(
            classify_hypotheses(&about),
            RelocalisationResult::Unique(_) | RelocalisationResult::Ambiguous(_)
        ) {
            return about;
        }
        let Some(best) = about.first() else { return about };
        let held = &best.map_from_base;
        find_contradicting_hypotheses(held, &self.seek(Some(held))).unwrap_or(about)
    }
}
