//! Localisation of a robot in one known map: relocalising until its pose is known, then tracking it until the scans contradict it.
//!
//! Relocalisation is a job that finds the poses at which the newest scan may have been taken. They are tracked as hypotheses while the robot moves,
//! until one is left. Once localised, every scan corrects the pose. When scans contradict it for long enough, or a periodic global check finds a pose
//! that fits better, relocalisation starts again.
//!
//! A [`Localiser`] does no long computation by itself. It provides the data of a job ([`Localiser::work`]) and processes the job's result.

use crate::adaptive_voxel_filter::{AdaptiveVoxelFilter, AdaptiveVoxelFilterConfig};
use crate::disambiguation::DisambiguationConfig;
use crate::disambiguation_schedule::{DisambiguationSchedule, DisambiguationWork, ExplorationHint};
use crate::global_localiser::{GlobalLocaliser, PosePrior};
use crate::localisation_monitor::{DegradationReason, LocalisationStatus};
use crate::low_confidence::{LowConfidenceConfig, LowConfidenceConfirmation};
use crate::multi_hypothesis_tracker::{MultiHypothesisConfig, MultiHypothesisTracker};
use crate::periodic_global_check::{
    GlobalCheckResult, PeriodicGlobalCheck, PeriodicGlobalCheckConfig, check_tracked_pose,
};
use crate::pose_hypothesis::{PoseHypothesis, RelocalisationResult};
use crate::pose_tracker::{DownsampledScan, PoseTracker};
use crate::relocalisation_request::{
    QueryScan, RelocalisationRequest, RelocalisationRequestConfig, RelocalisationWork,
};
use geometry::{Isometry, Matrix6, Vector3};
use std::sync::Arc;
use vocab::Stamp;

/// Parameters of [`Localiser`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LocaliserConfig {
    /// Downsampling of scans for the trackers.
    pub filter: AdaptiveVoxelFilterConfig,
    /// Tracking of hypotheses, and of the pose.
    pub hypotheses: MultiHypothesisConfig,
    /// Confirmation of poses of low confidence.
    pub low_confidence: LowConfidenceConfig,
    /// Periodic global checks.
    pub global_check: PeriodicGlobalCheckConfig,
    /// Repetition of requests.
    pub request: RelocalisationRequestConfig,
    /// Planning of paths that distinguish hypotheses.
    pub disambiguation: DisambiguationConfig,
}

/// A scan that odometry has located and whose motion it has corrected.
#[derive(Clone, Copy, Debug)]
pub struct OdometryScan<'a> {
    /// Instant of the pose.
    pub stamp: Stamp,
    /// Pose of the base by odometry.
    pub odom_from_base: Isometry,
    /// Covariance of that pose, `[rotation; translation]`.
    pub covariance: Matrix6,
    /// Whether odometry could not align the scan with those before it, so that neither its motion nor its shape is known well.
    pub is_dead_reckoned: bool,
    /// All points, base frame, metres.
    pub points: &'a [[f32; 3]],
    /// Position of the LiDAR, base frame, metres.
    pub sensor: [f32; 3],
}

impl OdometryScan<'_> {
    /// A copy of what a search for its pose needs.
    fn query(&self) -> QueryScan {
        QueryScan { points: self.points.into(), rotation: self.odom_from_base.rotation, sensor: self.sensor }
    }
}

/// A pose that is known when localisation starts, with its source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InitialPose {
    /// Pose of the base in the map, given by a person.
    MapFromBase(Isometry),
    /// Pose of odometry's frame in the map, by the motion since the robot made that map.
    MapFromOdom(Isometry),
}

/// A change between relocalising and being localised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LocalisationTransition {
    /// The pose has become known.
    PoseFound,
    /// The pose is not known any more.
    PoseLost,
}

/// The data of a job.
#[derive(Debug)]
pub enum LocalisationWork {
    /// A search for the pose of a scan.
    Relocalise(RelocalisationWork),
    /// The planning of a path that distinguishes hypotheses.
    PlanDisambiguation(DisambiguationWork),
}

/// The state of a [`Localiser`], for publication.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LocaliserState {
    /// No map is in use.
    Idle,
    /// The pose is not known.
    Relocalising {
        /// Number of hypotheses.
        hypotheses: usize,
    },
    /// The pose is known.
    Localised {
        /// Evidence against it, if there is any.
        degradation: Option<DegradationReason>,
    },
}

/// Localises the robot in a known map.
#[derive(Debug)]
pub struct Localiser {
    config: LocaliserConfig,
    filter: AdaptiveVoxelFilter,
    state: State,
    /// Number of requests made so far.
    requests: u64,
}

#[derive(Debug)]
enum State {
    Idle,
    Relocalising(Box<Relocalising>),
    Localised(Box<Localised>),
}

#[derive(Debug)]
struct Relocalising {
    localiser: Arc<GlobalLocaliser>,
    /// Used by the next scan.
    initial_pose: Option<InitialPose>,
    request: Option<RelocalisationRequest>,
    hypotheses: MultiHypothesisTracker,
    disambiguation: DisambiguationSchedule,
    low_confidence: LowConfidenceConfirmation,
    /// Whether the hypotheses come from a search of the whole map.
    is_confirmed: bool,
    /// Whether the docks have been tried since the robot began to be charged.
    has_tried_docks: bool,
}

#[derive(Debug)]
struct Localised {
    localiser: Arc<GlobalLocaliser>,
    tracker: PoseTracker,
    covariance: Matrix6,
    degradation: Option<DegradationReason>,
    latest_scan: Option<Stamp>,
    global_check: PeriodicGlobalCheck,
    /// Whether the whole map has been searched for poses that look alike. A given pose starts without this search.
    is_confirmed: bool,
    request: Option<RelocalisationRequest>,
}

impl Localiser {
    /// A localiser without a map.
    pub fn new(config: LocaliserConfig) -> Self {
        Self { config, filter: AdaptiveVoxelFilter::new(config.filter), state: State::Idle, requests: 0 }
    }

    /// Starts to relocalise in a map.
    pub fn start(&mut self, localiser: Arc<GlobalLocaliser>, initial_pose: Option<InitialPose>) {
        self.state = State::Relocalising(Box::new(Relocalising::new(&self.config, localiser, initial_pose)));
    }

    /// Sets a new initial pose in the same map. A robot that is localised starts to relocalise from it; without one it stays localised.
    pub fn set_initial_pose(&mut self, initial_pose: Option<InitialPose>) {
        match &mut self.state {
            State::Relocalising(state) => state.initial_pose = initial_pose,
            State::Localised(state) if initial_pose.is_some() => {
                let localiser = Arc::clone(&state.localiser);
                self.start(localiser, initial_pose);
            }
            State::Localised(_) | State::Idle => {}
        }
    }

    /// No map is in use any more.
    pub fn stop(&mut self) {
        self.state = State::Idle;
    }

    /// Its state.
    pub fn state(&self) -> LocaliserState {
        match &self.state {
            State::Idle => LocaliserState::Idle,
            State::Relocalising(state) => LocaliserState::Relocalising { hypotheses: state.hypotheses.len() },
            State::Localised(state) => LocaliserState::Localised { degradation: state.degradation },
        }
    }

    /// Whether the pose is known, and the whole map has been searched for poses that look alike.
    pub fn is_confirmed(&self) -> bool {
        matches!(&self.state, State::Localised(state) if state.is_confirmed)
    }

    /// Pose of odometry's frame in the map, while the pose is known.
    pub fn map_from_odom(&self) -> Option<Isometry> {
        if let State::Localised(state) = &self.state { Some(state.tracker.map_from_odom()) } else { None }
    }

    /// Covariance of the base's pose in the map, while that is known.
    pub fn covariance(&self) -> Option<Matrix6> {
        if let State::Localised(state) = &self.state { Some(state.covariance) } else { None }
    }

    /// Hypotheses and planned path while the robot relocalises.
    pub fn exploration_hint(&self) -> ExplorationHint {
        match &self.state {
            State::Relocalising(state) => ExplorationHint {
                hypotheses: state.hypotheses.len(),
                path: state.disambiguation.path().map(Arc::clone),
            },
            State::Idle | State::Localised(_) => ExplorationHint::default(),
        }
    }

    /// Processes a scan. `docks` are the poses of the map's docks if the robot is charged, and empty if it is not.
    pub fn update(&mut self, scan: &OdometryScan, docks: &[Isometry]) -> Option<LocalisationTransition> {
        if matches!(self.state, State::Idle) {
            return None;
        }
        let points = self.filter.filter(scan.points);
        let downsampled = DownsampledScan {
            stamp: scan.stamp,
            odom_from_base: scan.odom_from_base,
            covariance: scan.covariance,
            points: &points,
        };
        let transition = match &mut self.state {
            State::Localised(state) => {
                let transition = state.track(&downsampled);
                if transition.is_none() && !scan.is_dead_reckoned && state.is_request_due(&self.config, scan)
                {
                    self.requests += 1;
                    state.request(self.requests, scan);
                }
                transition
            }
            // A scan that odometry could not align has a wrong shape as well.
            State::Relocalising(_) if scan.is_dead_reckoned => None,
            State::Relocalising(state) => {
                state.hypotheses.update(&downsampled);
                let found = state.hypotheses.converged().is_some() && state.hypotheses.is_search_recent();
                if !found && state.is_request_due(&self.config, scan, docks) {
                    self.requests += 1;
                    state.request(&self.config, self.requests, scan, docks);
                }
                self.requests += u64::from(state.update_disambiguation(self.requests + 1, scan));
                found.then_some(LocalisationTransition::PoseFound)
            }
            State::Idle => None,
        };
        self.apply(transition);
        transition
    }

    /// Updates by the present time and by whether odometry tracks the robot. A pose without scans degrades.
    pub fn tick(&mut self, at: Stamp, is_odometry_running: bool) {
        let max_scan_gap = self.config.hypotheses.tracking.monitor.max_scan_gap;
        if let State::Localised(state) = &mut self.state
            && (!is_odometry_running || state.latest_scan.is_some_and(|latest| at - latest > max_scan_gap))
        {
            state.degradation = Some(DegradationReason::LidarBlind);
        }
    }

    /// Changes the state.
    fn apply(&mut self, transition: Option<LocalisationTransition>) {
        match (transition, &self.state) {
            (Some(LocalisationTransition::PoseFound), State::Relocalising(state)) => {
                if let Some(tracker) = state.hypotheses.converged() {
                    let (localiser, tracker) = (Arc::clone(&state.localiser), tracker.clone());
                    let localised = Localised::new(&self.config, localiser, tracker, state.is_confirmed);
                    self.state = State::Localised(Box::new(localised));
                }
            }
            (Some(LocalisationTransition::PoseLost), State::Localised(state)) => {
                let localiser = Arc::clone(&state.localiser);
                self.start(localiser, None);
            }
            _ => {}
        }
    }

    /// Starts the pending planning of a path with this job. Returns the request's id. `None` if no request is pending.
    pub fn start_disambiguation(&mut self, job: u64) -> Option<u64> {
        if let State::Relocalising(state) = &mut self.state { state.disambiguation.start(job) } else { None }
    }

    /// Starts the pending relocalisation request with this job. Returns the request's id. `None` if no request is pending.
    pub fn start_relocalisation(&mut self, job: u64) -> Option<u64> {
        let (_, request) = self.request_mut()?;
        request.start(job).then_some(request.id)
    }

    /// The data of a job. `None` if the job is not of this localiser.
    pub fn work(&mut self, job: u64) -> Option<LocalisationWork> {
        if let State::Relocalising(state) = &self.state
            && let Some(work) = state.disambiguation.work(job, &state.localiser)
        {
            return Some(LocalisationWork::PlanDisambiguation(work));
        }
        let (localiser, request) = self.request_mut()?;
        request.is_answered_by(job).then(|| LocalisationWork::Relocalise(request.work(localiser)))
    }

    /// A relocalisation job has ended, with hypotheses or without an answer. Other jobs are ignored.
    pub fn finish_relocalisation(
        &mut self,
        job: u64,
        answer: Option<&[PoseHypothesis]>,
    ) -> Option<LocalisationTransition> {
        let (_, request) = self.request_mut()?;
        if !request.is_answered_by(job) {
            return None;
        }
        request.finish();
        let (odom_from_base, prior) = (request.odom_from_base, request.prior.clone());
        let found = answer.unwrap_or_default();
        match (&mut self.state, prior) {
            (State::Localised(state), PosePrior::Tracked(tracked)) => {
                let acceptance = &state.localiser.config().acceptance;
                match check_tracked_pose(acceptance, &tracked, found) {
                    GlobalCheckResult::Confirmed => state.confirm(),
                    GlobalCheckResult::Inconclusive => {}
                    GlobalCheckResult::Contradicted(poses) => {
                        let localiser = Arc::clone(&state.localiser);
                        let config = self.config.hypotheses;
                        let hypotheses = MultiHypothesisTracker::new(
                            config,
                            &localiser,
                            &poses,
                            Some(&tracked),
                            &odom_from_base,
                        );
                        let state = Relocalising::new(&self.config, localiser, None);
                        let state = Relocalising { hypotheses, is_confirmed: true, ..state };
                        self.state = State::Relocalising(Box::new(state));
                        return Some(LocalisationTransition::PoseLost);
                    }
                }
            }
            (State::Relocalising(state), PosePrior::Tracked(tracked)) => {
                if answer.is_some() && !state.hypotheses.is_empty() {
                    state.hypotheses.inject_hypotheses(&state.localiser, found, &tracked, &odom_from_base);
                    let acceptance = &state.localiser.config().acceptance;
                    let result = check_tracked_pose(acceptance, &tracked, found);
                    state.is_confirmed = result == GlobalCheckResult::Confirmed;
                }
            }
            (State::Relocalising(state), prior) => {
                state.start_hypotheses(&self.config, found, &prior, &odom_from_base);
            }
            (State::Localised(_) | State::Idle, _) => {}
        }
        None
    }

    /// The planning of a path has ended, with a path in odometry's frame or without one. Other jobs are ignored.
    pub fn finish_disambiguation(&mut self, job: u64, path: Option<Vec<Vector3>>) {
        if let State::Relocalising(state) = &mut self.state {
            state.disambiguation.finish(job, path);
        }
    }

    /// The latest relocalisation request, with the map that it is about.
    fn request_mut(&mut self) -> Option<(&Arc<GlobalLocaliser>, &mut RelocalisationRequest)> {
        match &mut self.state {
            State::Relocalising(state) => Some((&state.localiser, state.request.as_mut()?)),
            State::Localised(state) => Some((&state.localiser, state.request.as_mut()?)),
            State::Idle => None,
        }
    }
}

impl Relocalising {
    fn new(
        config: &LocaliserConfig,
        localiser: Arc<GlobalLocaliser>,
        initial_pose: Option<InitialPose>,
    ) -> Self {
        Self {
            localiser,
            initial_pose,
            request: None,
            hypotheses: MultiHypothesisTracker::empty(config.hypotheses),
            disambiguation: DisambiguationSchedule::new(config.disambiguation),
            low_confidence: LowConfidenceConfirmation::new(config.low_confidence),
            is_confirmed: false,
            has_tried_docks: false,
        }
    }

    /// Whether to request the poses at which this scan may have been taken. This is due for a new initial pose, at a dock, and without hypotheses. It
    /// is also due when one hypothesis is left for which the whole map has not been searched lately.
    fn is_request_due(&mut self, config: &LocaliserConfig, scan: &OdometryScan, docks: &[Isometry]) -> bool {
        self.has_tried_docks &= !docks.is_empty();
        let is_stale = self
            .request
            .as_ref()
            .is_none_or(|request| request.is_stale(&config.request, scan.stamp, &scan.odom_from_base));
        let is_last_unchecked = self.hypotheses.converged().is_some() && !self.hypotheses.is_search_recent();
        self.initial_pose.is_some()
            || (!docks.is_empty() && !self.has_tried_docks)
            || (self.hypotheses.is_empty() && is_stale)
            || (is_last_unchecked && is_stale)
    }

    fn request(&mut self, config: &LocaliserConfig, id: u64, scan: &OdometryScan, docks: &[Isometry]) {
        let prior = match self.initial_pose.take() {
            Some(InitialPose::MapFromBase(map_from_base)) => PosePrior::Given(map_from_base),
            Some(InitialPose::MapFromOdom(map_from_odom)) => {
                PosePrior::Given(map_from_odom * scan.odom_from_base)
            }
            None if !docks.is_empty() && !self.has_tried_docks => {
                self.has_tried_docks = true;
                PosePrior::AtDocks(docks.to_vec())
            }
            None => match self.hypotheses.converged() {
                Some(tracker) => PosePrior::Tracked(tracker.map_from_base().pose),
                None => PosePrior::None,
            },
        };
        if matches!(prior, PosePrior::Given(_) | PosePrior::AtDocks(_)) {
            self.hypotheses = MultiHypothesisTracker::empty(config.hypotheses);
        }
        let (stamp, odom_from_base) = (scan.stamp, scan.odom_from_base);
        self.request = Some(RelocalisationRequest::new(id, stamp, odom_from_base, scan.query(), prior));
    }

    /// Requests a path that distinguishes the hypotheses, if one is due. Returns whether it did.
    fn update_disambiguation(&mut self, id: u64, scan: &OdometryScan) -> bool {
        if self.hypotheses.len() < 2 {
            self.disambiguation.reset();
        } else if self.disambiguation.is_due(self.hypotheses.len(), &scan.odom_from_base) {
            self.disambiguation.request(id, self.hypotheses.poses(), &scan.odom_from_base);
            return true;
        }
        false
    }

    /// Starts to track the poses that were found for a scan. A pose of low confidence is tracked if it was given, or once it has been
    /// confirmed by walking.
    fn start_hypotheses(
        &mut self,
        config: &LocaliserConfig,
        found: &[PoseHypothesis],
        prior: &PosePrior,
        odom_from_base: &Isometry,
    ) {
        let is_given = matches!(prior, PosePrior::Given(_));
        self.is_confirmed = !is_given && !matches!(prior, PosePrior::AtDocks(_));
        let poses = match self.localiser.classify(found) {
            RelocalisationResult::LowConfidence(one) => {
                let same_pose = &self.localiser.config().acceptance.same_pose;
                let accepted =
                    is_given || self.low_confidence.update(&one.map_from_base, odom_from_base, same_pose);
                if accepted { vec![one] } else { Vec::new() }
            }
            other => other.into_accepted(),
        };
        self.hypotheses =
            MultiHypothesisTracker::new(config.hypotheses, &self.localiser, &poses, None, odom_from_base);
    }
}

impl Localised {
    fn new(
        config: &LocaliserConfig,
        localiser: Arc<GlobalLocaliser>,
        tracker: PoseTracker,
        is_confirmed: bool,
    ) -> Self {
        let covariance = tracker.map_from_base().covariance;
        Self {
            localiser,
            tracker,
            covariance,
            degradation: (!is_confirmed).then_some(DegradationReason::Unconfirmed),
            latest_scan: None,
            global_check: PeriodicGlobalCheck::new(config.global_check),
            is_confirmed,
            request: None,
        }
    }

    /// Whether to check that no other pose fits better. This is due when a periodic check is due and there is no evidence against the pose. It is
    /// always due as long as the pose is not confirmed.
    fn is_request_due(&mut self, config: &LocaliserConfig, scan: &OdometryScan) -> bool {
        let is_open = self.request.as_ref().is_some_and(RelocalisationRequest::is_open);
        let is_stale = self
            .request
            .as_ref()
            .is_none_or(|request| request.is_stale(&config.request, scan.stamp, &scan.odom_from_base));
        let is_check_due =
            self.global_check.update(&scan.odom_from_base) && !is_open && self.degradation.is_none();
        is_check_due || (!self.is_confirmed && is_stale)
    }

    fn request(&mut self, id: u64, scan: &OdometryScan) {
        self.global_check.restart();
        let prior = PosePrior::Tracked(self.tracker.map_from_base().pose);
        let (stamp, odom_from_base) = (scan.stamp, scan.odom_from_base);
        self.request = Some(RelocalisationRequest::new(id, stamp, odom_from_base, scan.query(), prior));
    }

    /// The whole map has been searched, and no pose fits clearly better.
    fn confirm(&mut self) {
        self.is_confirmed = true;
        if self.degradation == Some(DegradationReason::Unconfirmed) {
            self.degradation = None;
        }
    }

    fn track(&mut self, scan: &DownsampledScan) -> Option<LocalisationTransition> {
        let tracked = self.tracker.update(scan);
        self.covariance = tracked.map_from_base.covariance;
        self.latest_scan = Some(scan.stamp);
        self.degradation = match tracked.status {
            LocalisationStatus::Localised => (!self.is_confirmed).then_some(DegradationReason::Unconfirmed),
            LocalisationStatus::Uncertain(reason) | LocalisationStatus::Lost(reason) => Some(reason),
        };
        matches!(tracked.status, LocalisationStatus::Lost(_)).then_some(LocalisationTransition::PoseLost)
    }
}

#[cfg(test)]
#[path = "localiser_tests.rs"]
mod tests;
