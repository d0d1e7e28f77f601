//! Being localised in a saved map: idle, loading, relocalising, localised.
//!
//! Relocalising asks, in a job, where the newest scan may have been taken. One place is believed; of several, each is tracked while the
//! robot moves until what it sees leaves one. Localised, every scan corrects the place, until what is seen speaks against it for long
//! enough, or another place turns out to fit better: then all begins anew.

use crate::disambiguation::{DisambiguationSchedule, ExplorationHint};
use crate::docks::Docks;
use crate::low_confidence::LowConfidenceConfirmation;
use crate::multi_hypothesis_tracker::MultiHypothesisTracker;
use crate::odometry_adapter::LocatedScan;
use crate::periodic_global_check::{PeriodicGlobalCheck, find_contradicting_hypotheses, is_confirmed};
use crate::prior_map::DecodedPriorMap;
use crate::relocalisation_request::{PosePrior, RelocalisationRequest, SearchableMap};
use crate::work::ComputeJob;
use geometry::{Isometry, Matrix6};
use localisation::{
    AdaptiveVoxelFilter, DownsampledScan, LocalisationStatus, PoseTracker, RelocalisationResult,
    classify_hypotheses,
};
use mapping::KeyframeDescriptor;
use messages::{
    DegradationReason, DisambiguationPlan, DisambiguationTask, Job, LocalisationState, PriorMap,
    RelocalisationResponse, RelocalisationTask, StackEffect,
};
use points::Downsampler;
use std::sync::Arc;
use vocab::{MapId, Span, Stamp};

/// Without a scan for so long the LiDAR sees nothing: slow ones turn twice a second.
const DARK_AFTER: Span = Span::from_millis(800);

/// The phase and what it needs.
#[derive(Debug, Default)]
pub(crate) struct LocalisationPhase {
    phase: Phase,
    /// Of the last place that was known.
    map_from_odom: Option<Isometry>,
    thinner: AdaptiveVoxelFilter,
    downsampler: Downsampler,
    questions: u64,
    published: Option<LocalisationState>,
}

#[derive(Debug, Default)]
enum Phase {
    #[default]
    Idle,
    /// The map is being read; the job is none until it has started.
    Loading {
        map: MapId,
        at: Option<InitialPose>,
        job: Option<u64>,
    },
    Relocalising(Box<Relocalising>),
    Localised(Box<Localised>),
}

#[derive(Debug)]
struct Relocalising {
    map: MapId,
    ground: Arc<SearchableMap>,
    /// Until the next scan.
    told: Option<InitialPose>,
    question: Option<RelocalisationRequest>,
    contest: MultiHypothesisTracker,
    telling: DisambiguationSchedule,
    faint: LowConfidenceConfirmation,
    /// Whether the places in the contest are all that look alike in the whole map.
    everywhere: bool,
    /// Whether the docks have been tried since the robot has been charged.
    docked: bool,
}

#[derive(Debug)]
struct Localised {
    map: MapId,
    ground: Arc<SearchableMap>,
    tracker: PoseTracker,
    covariance: Matrix6,
    doubt: Option<DegradationReason>,
    /// Of the newest scan.
    seen: Option<Stamp>,
    second_opinion: PeriodicGlobalCheck,
    /// Whether the whole map has been searched for the place: not yet, where a person showed it.
    confirmed: bool,
    question: Option<RelocalisationRequest>,
}

/// Where the robot is in the map, to whoever knows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum InitialPose {
    /// By a person: the base in the map.
    MapFromBase(Isometry),
    /// By the way walked since that map was made: odometry's frame in the map.
    MapFromOdom(Isometry),
}

/// What the phase made of a scan or an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LocalisationTransition {
    /// The place is known; it was not before.
    PoseFound,
    /// It is not known any more.
    PoseLost,
}

impl LocalisationPhase {
    /// Begins to be localised in a map, once that has been read.
    pub fn begin(&mut self, map: MapId, at: Option<InitialPose>) {
        match &mut self.phase {
            Phase::Relocalising(state) if state.map == map => state.told = at,
            Phase::Localised(state) if state.map == map => {
                if let Some(at) = at {
                    let state = Relocalising::new(map, Arc::clone(&state.ground), Some(at));
                    self.phase = Phase::Relocalising(Box::new(state));
                }
            }
            _ => self.phase = Phase::Loading { map, at, job: None },
        }
    }

    /// No map any more.
    pub fn leave(&mut self) {
        self.phase = Phase::Idle;
        self.map_from_odom = None;
    }

    /// Whether no saved map is in use.
    pub fn is_idle(&self) -> bool {
        matches!(self.phase, Phase::Idle)
    }

    /// Whether the place in a saved map is wanted and not known, or might yet be another.
    pub fn is_looking(&self) -> bool {
        match &self.phase {
            Phase::Loading { .. } | Phase::Relocalising(_) => true,
            Phase::Localised(state) => !state.confirmed,
            Phase::Idle => false,
        }
    }

    /// Whether the place in a saved map is known and nothing speaks against it.
    pub fn knows(&self) -> bool {
        self.sure_of().is_some()
    }

    /// The map in which the robot knows its place with nothing speaking against it.
    pub fn sure_of(&self) -> Option<MapId> {
        match &self.phase {
            Phase::Localised(state) if state.doubt.is_none() => Some(state.map),
            _ => None,
        }
    }

    /// What is known of where the robot may be while it looks for itself.
    pub fn exploration_hint(&self) -> ExplorationHint {
        match &self.phase {
            Phase::Relocalising(state) => {
                ExplorationHint { places: state.contest.len(), way: state.telling.way().map(Arc::clone) }
            }
            _ => ExplorationHint::default(),
        }
    }

    /// Where odometry's frame is in the map; none before the robot has found itself in one.
    pub fn map_from_odom(&self) -> Option<Isometry> {
        self.map_from_odom
    }

    /// Of the base's place in the map, while that is known.
    pub fn covariance(&self) -> Option<Matrix6> {
        if let Phase::Localised(state) = &self.phase { Some(state.covariance) } else { None }
    }

    /// The map has been read, or could not be. Maps that nobody waits for are ignored.
    ///
    /// # Errors
    /// Why the robot is in no map then.
    pub fn loaded(&mut self, job: u64, read: Result<&PriorMap, &str>) -> Result<(), String> {
        let Phase::Loading { map, at, job: Some(waited) } = self.phase else { return Ok(()) };
        if waited != job {
            return Ok(());
        }
        self.phase = Phase::Idle;
        let known = DecodedPriorMap::decode(read?)?;
        let keyframes =
            known.keyframes.into_iter().map(|keyframe| (keyframe.map_from_keyframe, keyframe.place));
        let ground = Arc::new(SearchableMap::new(keyframes.collect()));
        self.phase = Phase::Relocalising(Box::new(Relocalising::new(map, ground, at)));
        Ok(())
    }

    /// Takes in a located scan, seen from `sensor` (base frame), by a robot that may be at one of these docks of the map.
    pub fn add(
        &mut self,
        located: &LocatedScan,
        sensor: [f32; 3],
        docks: &Docks,
    ) -> Option<LocalisationTransition> {
        if !matches!(self.phase, Phase::Relocalising(_) | Phase::Localised(_)) {
            return None;
        }
        let points = self.thinner.thin(&located.cloud.xyz);
        let scan = DownsampledScan {
            stamp: located.stamp,
            odom_from_base: located.odom_from_base,
            covariance: located.covariance,
            points: &points,
        };
        let mut place = || {
            let rotation = &located.odom_from_base.rotation;
            KeyframeDescriptor::new(&located.cloud.xyz, rotation, sensor, &mut self.downsampler)
        };
        let turn = match &mut self.phase {
            Phase::Localised(state) => {
                let turn = state.track(&scan);
                if turn.is_none() && !located.blind && state.is_due(located) {
                    self.questions += 1;
                    state.ask(located, place(), self.questions);
                }
                turn
            }
            // Odometry that does not know how the robot moves spoils the scan as well.
            Phase::Relocalising(_) if located.blind => None,
            Phase::Relocalising(state) => {
                state.contest.take(&scan);
                let found = state.contest.winner().is_some() && state.contest.is_fresh();
                if !found && state.is_due(located, docks) {
                    self.questions += 1;
                    state.ask(located, place(), self.questions, docks);
                }
                if state.contest.len() < 2 {
                    state.telling = DisambiguationSchedule::default();
                } else if state.telling.is_due(state.contest.len(), &located.odom_from_base) {
                    self.questions += 1;
                    state.telling.ask(self.questions, state.contest.places(), &located.odom_from_base);
                }
                found.then_some(LocalisationTransition::PoseFound)
            }
            Phase::Idle | Phase::Loading { .. } => None,
        };
        self.change(turn);
        if let Phase::Localised(state) = &self.phase {
            self.map_from_odom = Some(state.tracker.map_from_odom());
        }
        turn
    }

    /// Time passes, with odometry underway or not.
    pub fn tick(&mut self, at: Stamp, underway: bool) {
        if let Phase::Localised(state) = &mut self.phase
            && (!underway || state.seen.is_some_and(|seen| at - seen > DARK_AFTER))
        {
            state.doubt = Some(DegradationReason::LidarBlind);
        }
    }

    /// Moves between looking and knowing.
    fn change(&mut self, turn: Option<LocalisationTransition>) {
        let Some(turn) = turn else { return };
        self.phase = match (turn, std::mem::take(&mut self.phase)) {
            (LocalisationTransition::PoseFound, Phase::Relocalising(state)) => match state.contest.winner() {
                Some(tracker) => {
                    let tracker = tracker.clone();
                    let Relocalising { map, ground, everywhere, .. } = *state;
                    Phase::Localised(Box::new(Localised::new(map, ground, tracker, everywhere)))
                }
                None => Phase::Relocalising(state),
            },
            (LocalisationTransition::PoseLost, Phase::Localised(state)) => {
                Phase::Relocalising(Box::new(Relocalising::new(state.map, state.ground, None)))
            }
            (_, phase) => phase,
        };
    }

    /// Starts what is to be asked. `jobs` counts all jobs of the stack.
    pub fn start_jobs(&mut self, jobs: &mut u64, effects: &mut Vec<StackEffect>) {
        if let Phase::Relocalising(state) = &mut self.phase
            && let Some(number) = state.telling.start(*jobs)
        {
            let work = Job::PlanDisambiguation(DisambiguationTask { map: state.map, number });
            effects.push(StackEffect::StartJob { job: *jobs, work });
            *jobs += 1;
        }
        let job = *jobs;
        let work = match &mut self.phase {
            Phase::Loading { map, job: waited @ None, .. } => {
                *waited = Some(job);
                Job::ReadMap(*map)
            }
            phase => {
                let Some((map, _, question)) = phase.asking() else { return };
                if !question.start(job) {
                    return;
                }
                Job::Relocalise(RelocalisationTask { map, number: question.number })
            }
        };
        effects.push(StackEffect::StartJob { job, work });
        *jobs += 1;
    }

    /// What a job takes.
    pub fn take_compute_job(&mut self, job: u64) -> Option<ComputeJob> {
        if let Phase::Relocalising(state) = &self.phase
            && let Some(work) = state.telling.work(job, state.map, &state.ground)
        {
            return Some(work);
        }
        let (map, ground, question) = self.phase.asking()?;
        question.is_answered_by(job).then(|| question.work(map, ground))
    }

    /// A question was answered, or was not. Others' jobs are ignored.
    pub fn answered(
        &mut self,
        job: u64,
        answer: Option<&RelocalisationResponse>,
    ) -> Option<LocalisationTransition> {
        let (_, ground, question) = self.phase.asking()?;
        if !question.is_answered_by(job) {
            return None;
        }
        let ground = Arc::clone(ground);
        let (at, thought) = (question.odom_from_base, question.thought.clone());
        let found = question.answered(answer);
        let told = matches!(thought, PosePrior::Given(_));
        let docked = matches!(thought, PosePrior::AtDocks(_));
        match (&mut self.phase, thought) {
            (Phase::Localised(state), PosePrior::Tracked(held)) => {
                let Some(places) = find_contradicting_hypotheses(&held, &found) else {
                    state.confirm(is_confirmed(&held, &found));
                    return None;
                };
                self.change(Some(LocalisationTransition::PoseLost));
                if let Phase::Relocalising(state) = &mut self.phase {
                    state.contest = MultiHypothesisTracker::new(&ground, &places, Some(&held), &at);
                    state.everywhere = true;
                }
                Some(LocalisationTransition::PoseLost)
            }
            (Phase::Relocalising(state), PosePrior::Tracked(held)) => {
                if answer.is_some() && !state.contest.is_empty() {
                    state.contest.inject_hypotheses(&ground, &found, &held, &at);
                    state.everywhere = is_confirmed(&held, &found);
                }
                None
            }
            (Phase::Relocalising(state), _) => {
                state.everywhere = !told && !docked;
                let places = match classify_hypotheses(&found) {
                    RelocalisationResult::Unique(one) => vec![one],
                    RelocalisationResult::Ambiguous(several) => several,
                    RelocalisationResult::LowConfidence(one) => {
                        let believed = told || state.faint.recognise(&one, &at);
                        if believed { vec![one] } else { Vec::new() }
                    }
                    RelocalisationResult::NotFound => Vec::new(),
                };
                state.contest = MultiHypothesisTracker::new(&ground, &places, None, &at);
                None
            }
            _ => None,
        }
    }

    /// A way on which places can be told apart was thought out, or was not. Others' jobs are ignored.
    pub fn told_apart(&mut self, job: u64, told: Option<&DisambiguationPlan>) {
        if let Phase::Relocalising(state) = &mut self.phase {
            state.telling.answered(job, told);
        }
    }

    /// The state, if it changed since it was last said.
    pub fn changed(&mut self) -> Option<LocalisationState> {
        let state = match &self.phase {
            Phase::Idle => LocalisationState::Idle,
            Phase::Loading { map, .. } => LocalisationState::Loading { map: *map },
            Phase::Relocalising(state) => {
                LocalisationState::Relocalising { map: state.map, hypotheses: state.contest.len() as u32 }
            }
            Phase::Localised(state) => {
                LocalisationState::Localised { map: state.map, degradation: state.doubt }
            }
        };
        (self.published.replace(state) != Some(state)).then_some(state)
    }
}

impl Phase {
    /// The question that has come up, of whatever place in which map.
    fn asking(&mut self) -> Option<(MapId, &Arc<SearchableMap>, &mut RelocalisationRequest)> {
        match self {
            Self::Relocalising(state) => Some((state.map, &state.ground, state.question.as_mut()?)),
            Self::Localised(state) => Some((state.map, &state.ground, state.question.as_mut()?)),
            Self::Idle | Self::Loading { .. } => None,
        }
    }
}

impl Relocalising {
    fn new(map: MapId, ground: Arc<SearchableMap>, told: Option<InitialPose>) -> Self {
        Self {
            map,
            ground,
            told,
            question: None,
            contest: MultiHypothesisTracker::default(),
            telling: DisambiguationSchedule::default(),
            faint: LowConfidenceConfirmation::default(),
            everywhere: false,
            docked: false,
        }
    }

    /// Whether to ask where this scan may have been taken.
    fn is_due(&mut self, located: &LocatedScan, docks: &Docks) -> bool {
        let at_dock = docks.is_at_one_of(self.map);
        self.docked &= at_dock;
        let stale = || self.question.as_ref().is_none_or(|question| question.is_stale(located));
        let last = self.contest.winner().is_some() && !self.contest.is_fresh();
        self.told.is_some()
            || (at_dock && !self.docked)
            || (self.contest.is_empty() && stale())
            || (last && stale())
    }

    fn ask(&mut self, located: &LocatedScan, place: KeyframeDescriptor, number: u64, docks: &Docks) {
        let thought = match self.told.take() {
            Some(InitialPose::MapFromBase(map_from_base)) => PosePrior::Given(map_from_base),
            Some(InitialPose::MapFromOdom(map_from_odom)) => {
                PosePrior::Given(map_from_odom * located.odom_from_base)
            }
            None if docks.is_at_one_of(self.map) && !self.docked => {
                self.docked = true;
                PosePrior::AtDocks(docks.candidates(self.map))
            }
            None => match self.contest.winner() {
                Some(tracker) => PosePrior::Tracked(tracker.map_from_base().pose),
                None => PosePrior::None,
            },
        };
        if matches!(thought, PosePrior::Given(_) | PosePrior::AtDocks(_)) {
            self.contest = MultiHypothesisTracker::default();
        }
        self.question = Some(RelocalisationRequest::new(located, place, number, thought));
    }
}

impl Localised {
    fn new(map: MapId, ground: Arc<SearchableMap>, tracker: PoseTracker, confirmed: bool) -> Self {
        let covariance = tracker.map_from_base().covariance;
        let doubt = (!confirmed).then_some(DegradationReason::Unconfirmed);
        let second_opinion = PeriodicGlobalCheck::default();
        Self {
            map,
            ground,
            tracker,
            covariance,
            doubt,
            seen: None,
            second_opinion,
            confirmed,
            question: None,
        }
    }

    /// Whether to ask if the robot might be elsewhere. Only while nothing speaks against the place, what does is dealt with; but a place
    /// that is not confirmed needs that in any case.
    fn is_due(&mut self, located: &LocatedScan) -> bool {
        let asking = self.question.as_ref().is_some_and(RelocalisationRequest::is_open);
        let stale = || self.question.as_ref().is_none_or(|question| question.is_stale(located));
        let due = self.second_opinion.is_due(located) && !asking && self.doubt.is_none();
        due || (!self.confirmed && stale())
    }

    fn ask(&mut self, located: &LocatedScan, place: KeyframeDescriptor, number: u64) {
        self.second_opinion.ask();
        let held = PosePrior::Tracked(self.tracker.map_from_base().pose);
        self.question = Some(RelocalisationRequest::new(located, place, number, held));
    }

    /// The whole map has been searched; nothing was better, if the place is confirmed.
    fn confirm(&mut self, is_confirmed: bool) {
        self.confirmed |= is_confirmed;
        if self.confirmed && self.doubt == Some(DegradationReason::Unconfirmed) {
            self.doubt = None;
        }
    }

    fn track(&mut self, scan: &DownsampledScan) -> Option<LocalisationTransition> {
        let fix = self.tracker.track(scan);
        self.covariance = fix.map_from_base.covariance;
        self.seen = Some(scan.stamp);
        self.doubt = match fix.trust {
            LocalisationStatus::Localised => (!self.confirmed).then_some(DegradationReason::Unconfirmed),
            LocalisationStatus::Uncertain(doubt) | LocalisationStatus::Lost(doubt) => Some(plain(doubt)),
        };
        matches!(fix.trust, LocalisationStatus::Lost(_)).then_some(LocalisationTransition::PoseLost)
    }
}

fn plain(reason: localisation::DegradationReason) -> DegradationReason {
    match reason {
        localisation::DegradationReason::MapMismatch { .. } => DegradationReason::MapMismatch,
        localisation::DegradationReason::PoseUncertain { .. } => DegradationReason::PoseUncertain,
        localisation::DegradationReason::LidarBlind => DegradationReason::LidarBlind,
        localisation::DegradationReason::Unmapped => DegradationReason::Unmapped,
    }
}
