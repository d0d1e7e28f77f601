//! Localisation in a saved map, as the stack wires it: it reads the map, gives located scans to a [`Localiser`], starts the jobs that this asks
//! for, and publishes the results.

use crate::map_loading::MapLoading;
use crate::odometry_adapter::LocatedScan;
use crate::prior_map::PreparedMap;
use crate::work::{ComputeJob, Work};
use geometry::{Isometry, Matrix6, isometry_from_pose, vec_from_plain};
use localisation::{
    DockRegistry, DockRegistryConfig, ExplorationHint, InitialPose, LocalisationTransition, Localiser,
    LocaliserConfig, LocaliserState, MapDock, OdometryScan,
};
use messages::{
    DegradationReason, DisambiguationPlan, DisambiguationTask, Job, JobFailure, LocalisationState, PoseInMap,
    PriorMap, RelocalisationResponse, RelocalisationTask, StackEffect,
};
use std::sync::Arc;
use vocab::{MapId, Stamp};

/// The map in use and the localiser.
#[derive(Debug)]
pub(crate) struct LocalisationPhase {
    phase: Phase,
    localiser: Localiser,
    /// Pose of odometry's frame in the map, the latest that was known.
    map_from_odom: Option<Isometry>,
    published: Option<LocalisationState>,
}

#[derive(Debug, Default)]
enum Phase {
    #[default]
    Idle,
    /// The map is being read.
    Loading { loading: MapLoading, initial_pose: Option<InitialPose> },
    /// The localiser runs in the map.
    Running { map: MapId },
}

impl Default for LocalisationPhase {
    fn default() -> Self {
        let localiser = Localiser::new(LocaliserConfig::default());
        Self { phase: Phase::Idle, localiser, map_from_odom: None, published: None }
    }
}

impl LocalisationPhase {
    /// Starts to localise in a map, once that has been read.
    pub fn start(&mut self, map: MapId, initial_pose: Option<InitialPose>) {
        match self.phase {
            Phase::Running { map: current } if current == map => {
                self.localiser.set_initial_pose(initial_pose)
            }
            _ => {
                self.localiser.stop();
                self.phase = Phase::Loading { loading: MapLoading::new(map), initial_pose };
            }
        }
    }

    /// No map is in use any more.
    pub fn stop(&mut self) {
        self.localiser.stop();
        self.phase = Phase::Idle;
        self.map_from_odom = None;
    }

    /// Whether no saved map is in use.
    pub fn is_idle(&self) -> bool {
        matches!(self.phase, Phase::Idle)
    }

    /// Whether the pose in a saved map is wanted and is not known, or not confirmed.
    pub fn is_unconfirmed(&self) -> bool {
        !self.is_idle() && !self.localiser.is_confirmed()
    }

    /// Whether the pose in a saved map is known and nothing speaks against it.
    pub fn is_localised(&self) -> bool {
        self.localised_map().is_some()
    }

    /// The map in which the pose is known with nothing speaking against it.
    pub fn localised_map(&self) -> Option<MapId> {
        match (&self.phase, self.localiser.state()) {
            (Phase::Running { map }, LocaliserState::Localised { degradation: None }) => Some(*map),
            _ => None,
        }
    }

    /// What is known of where the robot may be while it relocalises.
    pub fn exploration_hint(&self) -> ExplorationHint {
        self.localiser.exploration_hint()
    }

    /// Pose of odometry's frame in the map; none before the robot was localised in it.
    pub fn map_from_odom(&self) -> Option<Isometry> {
        self.map_from_odom
    }

    /// Covariance of the base's pose in the map, while that is known.
    pub fn covariance(&self) -> Option<Matrix6> {
        self.localiser.covariance()
    }

    /// The map has been read, or could not be; `supplied` may be its prepared form. Maps that nobody waits for are ignored.
    ///
    /// # Errors
    /// Why the robot is in no map then.
    pub fn finish_loading(
        &mut self,
        job: u64,
        read: &Result<Arc<PriorMap>, JobFailure>,
        supplied: Option<PreparedMap>,
    ) -> Result<(), String> {
        let Phase::Loading { loading, initial_pose } = self.phase else { return Ok(()) };
        let Some(read) = loading.finish(job, read) else { return Ok(()) };
        self.phase = Phase::Idle;
        self.localiser.start(PreparedMap::localiser(supplied, read?)?, initial_pose);
        self.phase = Phase::Running { map: loading.map() };
        Ok(())
    }

    /// Takes in a located scan, seen from `sensor` (base frame).
    pub fn update(
        &mut self,
        located: &LocatedScan,
        sensor: [f32; 3],
        docks: &DockRegistry,
    ) -> Option<LocalisationTransition> {
        let Phase::Running { map } = self.phase else { return None };
        let scan = OdometryScan {
            stamp: located.stamp,
            odom_from_base: located.odom_from_base,
            covariance: located.covariance,
            is_dead_reckoned: located.is_dead_reckoned,
            points: &located.cloud.xyz,
            sensor,
        };
        let transition = self.localiser.update(&scan, &docks.possible_poses(map));
        if let Some(map_from_odom) = self.localiser.map_from_odom() {
            self.map_from_odom = Some(map_from_odom);
        }
        transition
    }

    /// Takes in that time passes, and whether odometry follows the robot.
    pub fn tick(&mut self, at: Stamp, is_odometry_running: bool) {
        self.localiser.tick(at, is_odometry_running);
    }

    /// Starts the jobs that are pending. `jobs` counts all jobs of the stack.
    pub fn start_jobs(&mut self, jobs: &mut u64, effects: &mut Vec<StackEffect>) {
        let start = |work: Job, jobs: &mut u64, effects: &mut Vec<StackEffect>| {
            effects.push(StackEffect::start_job(*jobs, work));
            *jobs += 1;
        };
        match &mut self.phase {
            Phase::Idle => {}
            Phase::Loading { loading, .. } => {
                if let Some(job) = loading.start(jobs) {
                    effects.push(StackEffect::start_job(job, Job::ReadMap(loading.map())));
                }
            }
            Phase::Running { map } => {
                let map = *map;
                if let Some(number) = self.localiser.start_disambiguation(*jobs) {
                    start(Job::PlanDisambiguation(DisambiguationTask { map, number }), jobs, effects);
                }
                if let Some(number) = self.localiser.start_relocalisation(*jobs) {
                    start(Job::Relocalise(RelocalisationTask { map, number }), jobs, effects);
                }
            }
        }
    }

    /// What a job needs; none if the job is another's.
    pub fn take_compute_job(&mut self, job: u64) -> Option<ComputeJob> {
        let Phase::Running { map } = self.phase else { return None };
        let work = self.localiser.work(job)?;
        Some(ComputeJob::new(job, Work::Localise { map, work: Box::new(work) }))
    }

    /// A relocalisation job has ended, with an answer or without one. Other jobs are ignored.
    pub fn finish_relocalisation(
        &mut self,
        job: u64,
        answer: &Result<RelocalisationResponse, JobFailure>,
    ) -> Option<LocalisationTransition> {
        let decode = |one: &messages::PoseHypothesis| {
            let map_from_base = isometry_from_pose(&one.map_from_base)?;
            let (fit, violation_share) = (one.fit, one.violation_share);
            Some(localisation::PoseHypothesis { map_from_base, fit, violation_share })
        };
        let found: Option<Vec<_>> =
            answer.as_ref().ok().map(|answer| answer.hypotheses.iter().filter_map(decode).collect());
        self.localiser.finish_relocalisation(job, found.as_deref())
    }

    /// The planning of a path has ended, with a path or without one. Other jobs are ignored.
    pub fn finish_disambiguation(&mut self, job: u64, plan: &Result<DisambiguationPlan, JobFailure>) {
        let path = plan.as_ref().ok().map(|plan| plan.path.iter().map(|at| vec_from_plain(*at)).collect());
        self.localiser.finish_disambiguation(job, path);
    }

    /// The state, if it changed since it was published last.
    pub fn take_changed_state(&mut self) -> Option<LocalisationState> {
        let state = match (&self.phase, self.localiser.state()) {
            (Phase::Loading { loading, .. }, _) => LocalisationState::Loading { map: loading.map() },
            (Phase::Running { map }, LocaliserState::Relocalising { hypotheses }) => {
                LocalisationState::Relocalising { map: *map, hypotheses: hypotheses as u32 }
            }
            (Phase::Running { map }, LocaliserState::Localised { degradation }) => {
                LocalisationState::Localised { map: *map, degradation: degradation.map(plain_reason) }
            }
            (Phase::Idle, _) | (Phase::Running { .. }, LocaliserState::Idle) => LocalisationState::Idle,
        };
        (self.published.replace(state) != Some(state)).then_some(state)
    }
}

/// A registry of the docks that the boot record lists.
pub(crate) fn dock_registry(docks: &[PoseInMap]) -> DockRegistry {
    let dock = |dock: &PoseInMap| MapDock { map: dock.map, map_from_base: dock.map_from_base };
    DockRegistry::new(DockRegistryConfig::default(), docks.iter().map(dock).collect())
}

/// All docks, for publication.
pub(crate) fn plain_docks(docks: &DockRegistry) -> Arc<[PoseInMap]> {
    let plain = |dock: &MapDock| PoseInMap { map: dock.map, map_from_base: dock.map_from_base };
    docks.docks().iter().map(plain).collect()
}

fn plain_reason(reason: localisation::DegradationReason) -> DegradationReason {
    match reason {
        localisation::DegradationReason::MapMismatch { .. } => DegradationReason::MapMismatch,
        localisation::DegradationReason::PoseUncertain { .. } => DegradationReason::PoseUncertain,
        localisation::DegradationReason::LidarBlind => DegradationReason::LidarBlind,
        localisation::DegradationReason::Unmapped => DegradationReason::Unmapped,
        localisation::DegradationReason::Unconfirmed => DegradationReason::Unconfirmed,
    }
}

#[cfg(test)]
#[path = "localisation_phase_tests.rs"]
mod tests;
