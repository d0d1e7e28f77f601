//! Being localised in a saved map: idle, loading, relocalising, localised.
//!
//! Relocalising asks, in a job, where the newest scan may have been taken. One place is believed; of several, each is tracked while the
//! robot moves until what it sees leaves one. Localised, every scan corrects the place, until what is seen speaks against it for long
//! enough, or another place turns out to fit better: then all begins anew.

use crate::contest::Contest;
use crate::docks::Docks;
use crate::faint::Faint;
use crate::known::Known;
use crate::localising::Located;
use crate::question::{Ground, Question, Thought};
use crate::second_opinion::{SecondOpinion, outdone, upheld};
use crate::telling::{Clue, Telling};
use crate::work::Work;
use geometry::{Isometry, Matrix6};
use localisation::{Doubt, Scan, Standing, Thinner, Tracker, Trust, standing};
use mapping::Place;
use messages::{
    Effect, Job, KnownMap, LocalisationDoubt, LocalisationState, RelocaliseTask, Relocalised, TellApartTask,
    ToldApart,
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
    thinner: Thinner,
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
        at: Option<Told>,
        job: Option<u64>,
    },
    Relocalising(Box<Relocalising>),
    Localised(Box<Localised>),
}

#[derive(Debug)]
struct Relocalising {
    map: MapId,
    ground: Arc<Ground>,
    /// Until the next scan.
    told: Option<Told>,
    question: Option<Question>,
    contest: Contest,
    telling: Telling,
    faint: Faint,
    /// Whether the places in the contest are all that look alike in the whole map.
    everywhere: bool,
    /// Whether the docks have been tried since the robot has been charged.
    docked: bool,
}

#[derive(Debug)]
struct Localised {
    map: MapId,
    ground: Arc<Ground>,
    tracker: Tracker,
    covariance: Matrix6,
    doubt: Option<LocalisationDoubt>,
    /// Of the newest scan.
    seen: Option<Stamp>,
    second_opinion: SecondOpinion,
    /// Whether the whole map has been searched for the place: not yet, where a person showed it.
    confirmed: bool,
    question: Option<Question>,
}

/// Where the robot is in the map, to whoever knows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Told {
    /// By a person: the base in the map.
    Base(Isometry),
    /// By the way walked since that map was made: odometry's frame in the map.
    Odom(Isometry),
}

/// What the phase made of a scan or an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    /// The place is known; it was not before.
    Found,
    /// It is not known any more.
    Lost,
}

impl LocalisationPhase {
    /// Begins to be localised in a map, once that has been read.
    pub fn begin(&mut self, map: MapId, at: Option<Told>) {
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
    pub fn clue(&self) -> Clue {
        match &self.phase {
            Phase::Relocalising(state) => {
                Clue { places: state.contest.len(), way: state.telling.way().map(Arc::clone) }
            }
            _ => Clue::default(),
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
    pub fn loaded(&mut self, job: u64, read: Result<&KnownMap, &str>) -> Result<(), String> {
        let Phase::Loading { map, at, job: Some(waited) } = self.phase else { return Ok(()) };
        if waited != job {
            return Ok(());
        }
        self.phase = Phase::Idle;
        let known = Known::read(read?)?;
        let keyframes =
            known.keyframes.into_iter().map(|keyframe| (keyframe.map_from_keyframe, keyframe.place));
        let ground = Arc::new(Ground::new(keyframes.collect()));
        self.phase = Phase::Relocalising(Box::new(Relocalising::new(map, ground, at)));
        Ok(())
    }

    /// Takes in a located scan, seen from `sensor` (base frame), by a robot that may be at one of these docks of the map.
    pub fn add(&mut self, located: &Located, sensor: [f32; 3], docks: &Docks) -> Option<Turn> {
        if !matches!(self.phase, Phase::Relocalising(_) | Phase::Localised(_)) {
            return None;
        }
        let points = self.thinner.thin(&located.cloud.xyz);
        let scan = Scan {
            stamp: located.stamp,
            odom_from_base: located.odom_from_base,
            covariance: located.covariance,
            points: &points,
        };
        let mut place = || {
            let rotation = &located.odom_from_base.rotation;
            Place::new(&located.cloud.xyz, rotation, sensor, &mut self.downsampler)
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
                    state.telling = Telling::default();
                } else if state.telling.is_due(state.contest.len(), &located.odom_from_base) {
                    self.questions += 1;
                    state.telling.ask(self.questions, state.contest.places(), &located.odom_from_base);
                }
                found.then_some(Turn::Found)
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
            state.doubt = Some(LocalisationDoubt::Dark);
        }
    }

    /// Moves between looking and knowing.
    fn change(&mut self, turn: Option<Turn>) {
        let Some(turn) = turn else { return };
        self.phase = match (turn, std::mem::take(&mut self.phase)) {
            (Turn::Found, Phase::Relocalising(state)) => match state.contest.winner() {
                Some(tracker) => {
                    let tracker = tracker.clone();
                    let Relocalising { map, ground, everywhere, .. } = *state;
                    Phase::Localised(Box::new(Localised::new(map, ground, tracker, everywhere)))
                }
                None => Phase::Relocalising(state),
            },
            (Turn::Lost, Phase::Localised(state)) => {
                Phase::Relocalising(Box::new(Relocalising::new(state.map, state.ground, None)))
            }
            (_, phase) => phase,
        };
    }

    /// Starts what is to be asked. `jobs` counts all jobs of the stack.
    pub fn start_jobs(&mut self, jobs: &mut u64, effects: &mut Vec<Effect>) {
        if let Phase::Relocalising(state) = &mut self.phase
            && let Some(number) = state.telling.start(*jobs)
        {
            let work = Job::TellApart(TellApartTask { map: state.map, number });
            effects.push(Effect::StartJob { job: *jobs, work });
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
                Job::Relocalise(RelocaliseTask { map, number: question.number })
            }
        };
        effects.push(Effect::StartJob { job, work });
        *jobs += 1;
    }

    /// What a job takes.
    pub fn take_work(&mut self, job: u64) -> Option<Work> {
        if let Phase::Relocalising(state) = &self.phase
            && let Some(work) = state.telling.work(job, state.map, &state.ground)
        {
            return Some(work);
        }
        let (map, ground, question) = self.phase.asking()?;
        question.is_answered_by(job).then(|| question.work(map, ground))
    }

    /// A question was answered, or was not. Others' jobs are ignored.
    pub fn answered(&mut self, job: u64, answer: Option<&Relocalised>) -> Option<Turn> {
        let (_, ground, question) = self.phase.asking()?;
        if !question.is_answered_by(job) {
            return None;
        }
        let ground = Arc::clone(ground);
        let (at, thought) = (question.odom_from_base, question.thought.clone());
        let found = question.answered(answer);
        let told = matches!(thought, Thought::Told(_));
        let docked = matches!(thought, Thought::Docked(_));
        match (&mut self.phase, thought) {
            (Phase::Localised(state), Thought::Held(held)) => {
                let Some(places) = outdone(&held, &found) else {
                    state.confirm(upheld(&held, &found));
                    return None;
                };
                self.change(Some(Turn::Lost));
                if let Phase::Relocalising(state) = &mut self.phase {
                    state.contest = Contest::new(&ground, &places, Some(&held), &at);
                    state.everywhere = true;
                }
                Some(Turn::Lost)
            }
            (Phase::Relocalising(state), Thought::Held(held)) => {
                if answer.is_some() && !state.contest.is_empty() {
                    state.contest.challenge(&ground, &found, &held, &at);
                    state.everywhere = upheld(&held, &found);
                }
                None
            }
            (Phase::Relocalising(state), _) => {
                state.everywhere = !told && !docked;
                let places = match standing(&found) {
                    Standing::There(one) => vec![one],
                    Standing::OneOf(several) => several,
                    Standing::Faint(one) => {
                        let believed = told || state.faint.recognise(&one, &at);
                        if believed { vec![one] } else { Vec::new() }
                    }
                    Standing::Nowhere => Vec::new(),
                };
                state.contest = Contest::new(&ground, &places, None, &at);
                None
            }
            _ => None,
        }
    }

    /// A way on which places can be told apart was thought out, or was not. Others' jobs are ignored.
    pub fn told_apart(&mut self, job: u64, told: Option<&ToldApart>) {
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
                LocalisationState::Relocalising { map: state.map, places: state.contest.len() as u32 }
            }
            Phase::Localised(state) => LocalisationState::Localised { map: state.map, doubt: state.doubt },
        };
        (self.published.replace(state) != Some(state)).then_some(state)
    }
}

impl Phase {
    /// The question that has come up, of whatever place in which map.
    fn asking(&mut self) -> Option<(MapId, &Arc<Ground>, &mut Question)> {
        match self {
            Self::Relocalising(state) => Some((state.map, &state.ground, state.question.as_mut()?)),
            Self::Localised(state) => Some((state.map, &state.ground, state.question.as_mut()?)),
            Self::Idle | Self::Loading { .. } => None,
        }
    }
}

impl Relocalising {
    fn new(map: MapId, ground: Arc<Ground>, told: Option<Told>) -> Self {
        Self {
            map,
            ground,
            told,
            question: None,
            contest: Contest::default(),
            telling: Telling::default(),
            faint: Faint::default(),
            everywhere: false,
            docked: false,
        }
    }

    /// Whether to ask where this scan may have been taken.
    fn is_due(&mut self, located: &Located, docks: &Docks) -> bool {
        let at_dock = docks.is_at_one_of(self.map);
        self.docked &= at_dock;
        let stale = || self.question.as_ref().is_none_or(|question| question.is_stale(located));
        let last = self.contest.winner().is_some() && !self.contest.is_fresh();
        self.told.is_some()
            || (at_dock && !self.docked)
            || (self.contest.is_empty() && stale())
            || (last && stale())
    }

    fn ask(&mut self, located: &Located, place: Place, number: u64, docks: &Docks) {
        let thought = match self.told.take() {
            Some(Told::Base(map_from_base)) => Thought::Told(map_from_base),
            Some(Told::Odom(map_from_odom)) => Thought::Told(map_from_odom * located.odom_from_base),
            None if docks.is_at_one_of(self.map) && !self.docked => {
                self.docked = true;
                Thought::Docked(docks.candidates(self.map))
            }
            None => match self.contest.winner() {
                Some(tracker) => Thought::Held(tracker.map_from_base().pose),
                None => Thought::Nothing,
            },
        };
        if matches!(thought, Thought::Told(_) | Thought::Docked(_)) {
            self.contest = Contest::default();
        }
        self.question = Some(Question::new(located, place, number, thought));
    }
}

impl Localised {
    fn new(map: MapId, ground: Arc<Ground>, tracker: Tracker, confirmed: bool) -> Self {
        let covariance = tracker.map_from_base().covariance;
        let doubt = (!confirmed).then_some(LocalisationDoubt::Unconfirmed);
        let second_opinion = SecondOpinion::default();
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
    fn is_due(&mut self, located: &Located) -> bool {
        let asking = self.question.as_ref().is_some_and(Question::is_open);
        let stale = || self.question.as_ref().is_none_or(|question| question.is_stale(located));
        let due = self.second_opinion.is_due(located) && !asking && self.doubt.is_none();
        due || (!self.confirmed && stale())
    }

    fn ask(&mut self, located: &Located, place: Place, number: u64) {
        self.second_opinion.ask();
        let held = Thought::Held(self.tracker.map_from_base().pose);
        self.question = Some(Question::new(located, place, number, held));
    }

    /// The whole map has been searched; nothing was better, if the place is upheld.
    fn confirm(&mut self, upheld: bool) {
        self.confirmed |= upheld;
        if self.confirmed && self.doubt == Some(LocalisationDoubt::Unconfirmed) {
            self.doubt = None;
        }
    }

    fn track(&mut self, scan: &Scan) -> Option<Turn> {
        let fix = self.tracker.track(scan);
        self.covariance = fix.map_from_base.covariance;
        self.seen = Some(scan.stamp);
        self.doubt = match fix.trust {
            Trust::Localised => (!self.confirmed).then_some(LocalisationDoubt::Unconfirmed),
            Trust::Uncertain(doubt) | Trust::Lost(doubt) => Some(plain(doubt)),
        };
        matches!(fix.trust, Trust::Lost(_)).then_some(Turn::Lost)
    }
}

fn plain(doubt: Doubt) -> LocalisationDoubt {
    match doubt {
        Doubt::Contradicted { .. } => LocalisationDoubt::Contradicted,
        Doubt::Vague { .. } => LocalisationDoubt::Vague,
        Doubt::Dark => LocalisationDoubt::Dark,
        Doubt::Unmapped => LocalisationDoubt::Unmapped,
    }
}
