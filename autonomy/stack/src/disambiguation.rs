//! Which way to walk so that the places of a contest turn out to be different.
//!
//! Thinking that out takes up to a tenth of a second, so it is a job. It is thought out anew whenever a place is out, and as the robot gets on: its
//! places are known better then.

use crate::relocalisation_request::SearchableMap;
use crate::request_progress::RequestProgress;
use crate::work::ComputeJob;
use geometry::{Isometry, Vector3, vec_from_plain, vec_to_plain};
use messages::{DisambiguationPlan, DisambiguationTask};
use std::sync::Arc;
use vocab::MapId;

/// Thought out anew after so many metres.
const AGAIN: f64 = 3.0;

/// What is known of where the robot may be, to whoever walks it.
#[derive(Clone, Debug, Default)]
pub(crate) struct ExplorationHint {
    /// How many places are tracked.
    pub places: usize,
    /// The way on which they will turn out to be different, odometry's frame; empty if there is none, none as long as it has not been thought
    /// out.
    pub way: Option<Arc<[Vector3]>>,
}

/// The way, and what was asked last.
#[derive(Debug, Default)]
pub(crate) struct DisambiguationSchedule {
    way: Option<Arc<[Vector3]>>,
    asked: Option<Asked>,
}

#[derive(Debug)]
struct Asked {
    number: u64,
    /// Bases in the map.
    places: Vec<Isometry>,
    odom_from_base: Isometry,
    progress: RequestProgress,
}

impl DisambiguationSchedule {
    /// The newest that was thought out.
    pub fn way(&self) -> Option<&Arc<[Vector3]>> {
        self.way.as_ref()
    }

    /// Whether to think about so many places, of a robot that is there now.
    pub fn is_due(&self, places: usize, odom_from_base: &Isometry) -> bool {
        places > 1
            && self.asked.as_ref().is_none_or(|asked| {
                let moved = odom_from_base.translation.vector - asked.odom_from_base.translation.vector;
                asked.progress == RequestProgress::Answered
                    && (asked.places.len() != places || moved.norm() >= AGAIN)
            })
    }

    /// About these places, the likeliest first.
    pub fn ask(&mut self, number: u64, places: Vec<Isometry>, odom_from_base: &Isometry) {
        let odom_from_base = *odom_from_base;
        self.asked = Some(Asked { number, places, odom_from_base, progress: RequestProgress::default() });
    }

    /// Begins with a job, if one is wanted and has not begun: its number.
    pub fn start(&mut self, job: u64) -> Option<u64> {
        let asked = self.asked.as_mut()?;
        asked.progress.start(job).then_some(asked.number)
    }

    /// What a job takes; none if it is another's.
    pub fn work(&self, job: u64, map: MapId, ground: &Arc<SearchableMap>) -> Option<ComputeJob> {
        let asked = self.asked.as_ref().filter(|asked| asked.progress.is_run_by(job))?;
        Some(ComputeJob::plan_disambiguation(DisambiguationWork {
            task: DisambiguationTask { map, number: asked.number },
            ground: Arc::clone(ground),
            places: asked.places.clone(),
            odom_from_base: asked.odom_from_base,
        }))
    }

    /// A job has ended, with a way or without. Others' jobs are ignored.
    pub fn answered(&mut self, job: u64, told: Option<&DisambiguationPlan>) {
        let Some(asked) = self.asked.as_mut().filter(|asked| asked.progress.is_run_by(job)) else {
            return;
        };
        asked.progress = RequestProgress::Answered;
        self.way = Some(
            told.map(|told| told.path.iter().map(|at| vec_from_plain(*at)).collect()).unwrap_or_default(),
        );
    }
}

/// The question on its way.
#[derive(Debug)]
pub(crate) struct DisambiguationWork {
    task: DisambiguationTask,
    ground: Arc<SearchableMap>,
    places: Vec<Isometry>,
    odom_from_base: Isometry,
}

impl DisambiguationWork {
    /// A pure function of what it owns, see [`localisation::LocalisationMap::way_to_tell`].
    pub fn run(self) -> DisambiguationPlan {
        let way = self.ground.guide().way_to_tell(&self.places);
        let in_odom = |at: &Vector3| {
            vec_to_plain(&(self.odom_from_base.rotation * at + self.odom_from_base.translation.vector))
        };
        DisambiguationPlan { task: self.task, path: way.iter().map(in_odom).collect() }
    }
}
