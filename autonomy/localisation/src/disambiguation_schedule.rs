//! Schedule of disambiguation: when a path is planned on which wrong hypotheses can be rejected.
//!
//! Planning takes up to a tenth of a second, so it is a job. A new path is planned whenever a hypothesis has been rejected. It is also planned again
//! while the robot walks, because the poses are known better then.

use crate::disambiguation::{DisambiguationConfig, plan_disambiguation};
use crate::global_localiser::GlobalLocaliser;
use crate::request_progress::RequestProgress;
use geometry::{Isometry, Vector3};
use std::sync::Arc;

/// Hypotheses and planned path, for the behaviour that moves the robot.
#[derive(Clone, Debug, Default)]
pub struct ExplorationHint {
    /// Number of hypotheses.
    pub hypotheses: usize,
    /// Path on which wrong hypotheses can be rejected, odometry's frame. Empty if there is none; `None` until it has been planned.
    pub path: Option<Arc<[Vector3]>>,
}

/// The newest path and the latest request for one.
#[derive(Debug)]
pub(crate) struct DisambiguationSchedule {
    config: DisambiguationConfig,
    path: Option<Arc<[Vector3]>>,
    request: Option<DisambiguationRequest>,
}

#[derive(Debug)]
struct DisambiguationRequest {
    id: u64,
    /// Poses of the base in the map, the most likely first.
    hypotheses: Vec<Isometry>,
    odom_from_base: Isometry,
    progress: RequestProgress,
}

impl DisambiguationSchedule {
    /// Nothing requested yet.
    pub fn new(config: DisambiguationConfig) -> Self {
        Self { config, path: None, request: None }
    }

    /// Removes path and request, because there are no hypotheses to distinguish.
    pub fn reset(&mut self) {
        (self.path, self.request) = (None, None);
    }

    /// The newest path.
    pub fn path(&self) -> Option<&Arc<[Vector3]>> {
        self.path.as_ref()
    }

    /// Whether to plan for this number of hypotheses, at a pose by odometry.
    pub fn is_due(&self, hypotheses: usize, odom_from_base: &Isometry) -> bool {
        hypotheses > 1
            && self.request.as_ref().is_none_or(|request| {
                let moved = odom_from_base.translation.vector - request.odom_from_base.translation.vector;
                request.progress == RequestProgress::Done
                    && (request.hypotheses.len() != hypotheses
                        || moved.norm() >= self.config.replan_distance_m)
            })
    }

    /// Requests a path for these hypotheses, the most likely first.
    pub fn request(&mut self, id: u64, hypotheses: Vec<Isometry>, odom_from_base: &Isometry) {
        let (odom_from_base, progress) = (*odom_from_base, RequestProgress::default());
        self.request = Some(DisambiguationRequest { id, hypotheses, odom_from_base, progress });
    }

    /// Starts the pending request with this job. Returns its id. `None` if no request is pending.
    pub fn start(&mut self, job: u64) -> Option<u64> {
        let request = self.request.as_mut()?;
        request.progress.start(job).then_some(request.id)
    }

    /// The data of a job. `None` if the job is not of this schedule.
    pub fn work(&self, job: u64, localiser: &Arc<GlobalLocaliser>) -> Option<DisambiguationWork> {
        let request = self.request.as_ref().filter(|request| request.progress.is_running(job))?;
        Some(DisambiguationWork {
            id: request.id,
            config: self.config,
            localiser: Arc::clone(localiser),
            hypotheses: request.hypotheses.clone(),
            odom_from_base: request.odom_from_base,
        })
    }

    /// A job has ended, with a path in odometry's frame or without one. Other jobs are ignored.
    pub fn finish(&mut self, job: u64, path: Option<Vec<Vector3>>) {
        if let Some(request) = self.request.as_mut().filter(|request| request.progress.is_running(job)) {
            request.progress = RequestProgress::Done;
            self.path = Some(path.unwrap_or_default().into());
        }
    }
}

/// The planning of a path, with all its data.
#[derive(Debug)]
pub struct DisambiguationWork {
    id: u64,
    config: DisambiguationConfig,
    localiser: Arc<GlobalLocaliser>,
    hypotheses: Vec<Isometry>,
    odom_from_base: Isometry,
}

impl DisambiguationWork {
    /// Id of the request.
    pub fn id(&self) -> u64 {
        self.id
    }

    /// Plans the path, see [`plan_disambiguation`]: a pure function of what it owns. The path is in odometry's frame.
    pub fn run(&self) -> Vec<Vector3> {
        let path = plan_disambiguation(self.localiser.map(), &self.hypotheses, &self.config);
        let in_odom =
            |at: &Vector3| self.odom_from_base.rotation * at + self.odom_from_base.translation.vector;
        path.iter().map(in_odom).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::localisation_map::LocalisationMap;

    fn at(x: f64) -> Isometry {
        Isometry::translation(x, 0.0, 0.0)
    }

    #[test]
    fn a_path_is_planned_again_after_a_rejection_or_a_distance() {
        let mut schedule = DisambiguationSchedule::new(DisambiguationConfig::default());
        assert!(!schedule.is_due(1, &at(0.0)) && schedule.is_due(3, &at(0.0)));
        schedule.request(7, vec![at(0.0), at(5.0), at(9.0)], &at(0.0));
        assert!(!schedule.is_due(2, &at(9.0)), "it has not been answered");
        assert_eq!((schedule.start(1), schedule.start(2)), (Some(7), None));
        schedule.finish(2, Some(vec![Vector3::zeros()]));
        assert!(schedule.path().is_none(), "another job");
        schedule.finish(1, None);
        assert!(schedule.path().is_some_and(|path| path.is_empty()), "there is none");
        assert!(!schedule.is_due(3, &at(2.9)));
        assert!(schedule.is_due(2, &at(0.0)) && schedule.is_due(3, &at(3.0)));
        schedule.reset();
        assert!(schedule.path().is_none() && schedule.is_due(2, &at(0.0)));
    }

    #[test]
    fn the_work_belongs_to_the_job_that_was_started() {
        let localiser = Arc::new(GlobalLocaliser::new(Arc::new(LocalisationMap::new(Vec::new()))));
        let mut schedule = DisambiguationSchedule::new(DisambiguationConfig::default());
        assert!(schedule.work(1, &localiser).is_none());
        schedule.request(7, vec![at(0.0), at(5.0)], &at(0.0));
        schedule.start(1);
        assert!(schedule.work(2, &localiser).is_none());
        let Some(work) = schedule.work(1, &localiser) else { panic!("job 1 was started") };
        assert_eq!((work.id(), work.run()), (7, Vec::new()));
    }
}
