//! Being localised in a saved map: idle, loading, relocalising, localised.
//!
//! Relocalising asks, in a job, where the newest scan may have been taken. One place is believed; of several, each is tracked while the
//! robot moves until all others are contradicted by what it sees. Localised, every scan corrects the place, until what is seen speaks
//! against it for long enough: then all begins anew.

use crate::known::Known;
use crate::localising::Located;
use crate::work::Work;
use geometry::{Isometry, Matrix6, Vector6, isometry_from_pose, so3};
use localisation::{Atlas, Doubt, Fix, Guide, Hypothesis, Scan, Standing, Thinner, Tracker, Trust, standing};
use mapping::{Place, Uncertain};
use messages::{
    Effect, Job, KnownMap, LocalisationDoubt, LocalisationState, PossiblePlace, RelocaliseTask, Relocalised,
};
use points::Downsampler;
use std::sync::{Arc, OnceLock};
use vocab::{MapId, Span, Stamp};

/// A place that one scan was recognised by is so vague where the scan does not see it, as along a corridor: radians and metres.
const RECOGNISED: (f64, f64) = (0.05, 0.4);
/// Where nothing was recognised, the question is asked again after so many metres or radians, or so long.
const AGAIN: (f64, f64) = (0.5, 0.5);
const AGAIN_AFTER: Span = Span::from_millis(2_000);
/// Of several places, one is out when its scans fit worse than this share of the best one's, in the mean over so many scans or so.
const OUT: f64 = 0.85;
const MEAN_OF: f64 = 10.0;
/// And not before so many.
const SCANS: u32 = 5;
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
        at: Option<Isometry>,
        job: Option<u64>,
    },
    Relocalising(Box<Relocalising>),
    Localised(Box<Localised>),
}

#[derive(Debug)]
struct Relocalising {
    map: MapId,
    ground: Arc<Ground>,
    /// Told by a person, until the next scan.
    told: Option<Isometry>,
    question: Option<Question>,
    rivals: Vec<Rival>,
}

/// A place that is being tried.
#[derive(Debug)]
struct Rival {
    tracker: Tracker,
    /// Mean of how well its scans fit.
    quality: f64,
    scans: u32,
    /// Whether nothing speaks against it now.
    sure: bool,
}

#[derive(Debug)]
struct Question {
    at: Stamp,
    number: u64,
    odom_from_base: Isometry,
    place: Place,
    /// Where somebody said that it was taken.
    told: Option<Isometry>,
    /// None before it has started and after it has ended.
    job: Option<u64>,
    answered: bool,
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
}

/// A known map, with what is made of it when it is first needed, by whoever needs it: the same whoever that is.
#[derive(Debug)]
pub(crate) struct Ground {
    keyframes: Vec<(Isometry, Place)>,
    atlas: OnceLock<Atlas>,
}

impl Ground {
    fn atlas(&self) -> &Atlas {
        self.atlas.get_or_init(|| Atlas::new(Arc::new(Guide::new(self.keyframes.clone()))))
    }
}

/// What the phase made of a scan or an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    /// The place is known; it was not before.
    Found,
    /// It is not known any more.
    Lost,
}

/// A question on its way.
#[derive(Debug)]
pub(crate) struct Ask {
    pub task: RelocaliseTask,
    ground: Arc<Ground>,
    odom_from_base: Isometry,
    place: Place,
    told: Option<Isometry>,
}

impl Ask {
    /// Where the scan may have been taken: a pure function of what it owns, see [`Atlas::seek`]; the first one makes the map's surfaces.
    pub fn run(self) -> Relocalised {
        let atlas = self.ground.atlas();
        let places = match &self.told {
            Some(told) => atlas.seek_about(&self.place, told),
            None => atlas.seek(&self.place, &self.odom_from_base.rotation),
        };
        let plain = |one: &Hypothesis| PossiblePlace {
            map_from_base: geometry::pose_from_isometry(&one.map_from_base),
            fit: one.fit,
            contradicted: one.contradicted,
        };
        Relocalised { task: self.task, places: places.iter().map(plain).collect() }
    }
}

impl LocalisationPhase {
    /// Begins to be localised in a map, once that has been read.
    pub fn begin(&mut self, map: MapId, at: Option<Isometry>) {
        match &mut self.phase {
            Phase::Relocalising(state) if state.map == map => state.told = at,
            Phase::Localised(state) if state.map == map => {
                if let Some(at) = at {
                    let (ground, told) = (Arc::clone(&state.ground), Some(at));
                    let state = Relocalising { map, ground, told, question: None, rivals: Vec::new() };
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

    /// Whether the place in a saved map is wanted and not known.
    pub fn is_looking(&self) -> bool {
        matches!(self.phase, Phase::Loading { .. } | Phase::Relocalising(_))
    }

    /// Whether the place in a saved map is known and nothing speaks against it.
    pub fn knows(&self) -> bool {
        matches!(&self.phase, Phase::Localised(state) if state.doubt.is_none())
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
        let ground = Arc::new(Ground { keyframes: keyframes.collect(), atlas: OnceLock::new() });
        let state = Relocalising { map, ground, told: at, question: None, rivals: Vec::new() };
        self.phase = Phase::Relocalising(Box::new(state));
        Ok(())
    }

    /// Takes in a located scan, seen from `sensor` (base frame).
    pub fn add(&mut self, located: &Located, sensor: [f32; 3]) -> Option<Turn> {
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
        let turn = match &mut self.phase {
            Phase::Localised(state) => state.track(&scan),
            Phase::Relocalising(state) => {
                let found = state.try_rivals(&scan);
                if !found && state.is_due(located) {
                    let rotation = &located.odom_from_base.rotation;
                    let place = Place::new(&located.cloud.xyz, rotation, sensor, &mut self.downsampler);
                    self.questions += 1;
                    state.ask(located, place, self.questions);
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

    /// Time passes.
    pub fn tick(&mut self, at: Stamp) {
        if let Phase::Localised(state) = &mut self.phase
            && state.seen.is_some_and(|seen| at - seen > DARK_AFTER)
        {
            state.doubt = Some(LocalisationDoubt::Dark);
        }
    }

    /// Moves between looking and knowing.
    fn change(&mut self, turn: Option<Turn>) {
        let Some(turn) = turn else { return };
        self.phase = match (turn, std::mem::take(&mut self.phase)) {
            (Turn::Found, Phase::Relocalising(mut state)) => match state.rivals.pop() {
                Some(Rival { tracker, .. }) => {
                    let Relocalising { map, ground, .. } = *state;
                    let covariance = tracker.map_from_base().covariance;
                    Phase::Localised(Box::new(Localised {
                        map,
                        ground,
                        tracker,
                        covariance,
                        doubt: None,
                        seen: None,
                    }))
                }
                None => Phase::Relocalising(state),
            },
            (Turn::Lost, Phase::Localised(state)) => {
                let Localised { map, ground, .. } = *state;
                let state = Relocalising { map, ground, told: None, question: None, rivals: Vec::new() };
                Phase::Relocalising(Box::new(state))
            }
            (_, phase) => phase,
        };
    }

    /// Starts what is to be asked. `jobs` counts all jobs of the stack.
    pub fn start_jobs(&mut self, jobs: &mut u64, effects: &mut Vec<Effect>) {
        let work = match &mut self.phase {
            Phase::Loading { map, job: job @ None, .. } => {
                *job = Some(*jobs);
                Job::ReadMap(*map)
            }
            Phase::Relocalising(state) => {
                let map = state.map;
                let question = state.question.as_mut().filter(|it| it.job.is_none() && !it.answered);
                let Some(question) = question else { return };
                question.job = Some(*jobs);
                Job::Relocalise(RelocaliseTask { map, number: question.number })
            }
            _ => return,
        };
        effects.push(Effect::StartJob { job: *jobs, work });
        *jobs += 1;
    }

    /// What a job takes.
    pub fn take_work(&self, job: u64) -> Option<Work> {
        let Phase::Relocalising(state) = &self.phase else { return None };
        let question = state.question.as_ref().filter(|question| question.job == Some(job))?;
        let task = RelocaliseTask { map: state.map, number: question.number };
        let (ground, place) = (Arc::clone(&state.ground), question.place.clone());
        let (odom_from_base, told) = (question.odom_from_base, question.told);
        Some(Work::ask(Ask { task, ground, odom_from_base, place, told }))
    }

    /// A question was answered, or was not. Others' jobs are ignored.
    pub fn answered(&mut self, job: u64, answer: Option<&Relocalised>) {
        let Phase::Relocalising(state) = &mut self.phase else { return };
        let Some(question) = state.question.as_mut().filter(|question| question.job == Some(job)) else {
            return;
        };
        (question.job, question.answered) = (None, true);
        let Some(answer) = answer else { return };
        let read = |place: &PossiblePlace| {
            let map_from_base = isometry_from_pose(&place.map_from_base)?;
            Some(Hypothesis { map_from_base, fit: place.fit, contradicted: place.contradicted })
        };
        let found: Vec<Hypothesis> = answer.places.iter().filter_map(read).collect();
        let believed = match standing(&found) {
            Standing::There(one) => vec![one],
            Standing::OneOf(several) => several,
            Standing::Nowhere => Vec::new(),
        };
        let at = question.odom_from_base;
        for one in believed {
            state.rivals.push(Rival::new(&state.ground, &one.map_from_base, &at));
        }
    }

    /// The state, if it changed since it was last said.
    pub fn changed(&mut self) -> Option<LocalisationState> {
        let state = match &self.phase {
            Phase::Idle => LocalisationState::Idle,
            Phase::Loading { map, .. } => LocalisationState::Loading { map: *map },
            Phase::Relocalising(state) => {
                LocalisationState::Relocalising { map: state.map, places: state.rivals.len() as u32 }
            }
            Phase::Localised(state) => LocalisationState::Localised { map: state.map, doubt: state.doubt },
        };
        (self.published.replace(state) != Some(state)).then_some(state)
    }
}

impl Relocalising {
    /// Tracks all places that the robot may be at; says whether one is left that can be believed.
    fn try_rivals(&mut self, scan: &Scan) -> bool {
        self.rivals.retain_mut(|rival| rival.take(scan));
        let best = self.rivals.iter().map(|rival| rival.quality).fold(0.0, f64::max);
        self.rivals.retain(|rival| rival.scans < SCANS || rival.quality >= OUT * best);
        matches!(self.rivals.as_slice(), [Rival { scans: SCANS.., sure: true, .. }])
    }

    /// Whether to ask where this scan may have been taken.
    fn is_due(&self, located: &Located) -> bool {
        if self.told.is_some() {
            return true;
        }
        if !self.rivals.is_empty() {
            return false;
        }
        let Some(question) = &self.question else { return true };
        let moved = question.odom_from_base.inverse() * located.odom_from_base;
        let far = moved.translation.vector.norm() >= AGAIN.0 || so3::log(&moved.rotation).norm() >= AGAIN.1;
        question.answered && (far || located.stamp - question.at >= AGAIN_AFTER)
    }

    fn ask(&mut self, located: &Located, place: Place, number: u64) {
        let (at, odom_from_base, told) = (located.stamp, located.odom_from_base, self.told.take());
        if told.is_some() {
            self.rivals.clear();
        }
        let question = Question { at, number, odom_from_base, place, told, job: None, answered: false };
        self.question = Some(question);
    }
}

impl Rival {
    fn new(ground: &Ground, map_from_base: &Isometry, odom_from_base: &Isometry) -> Self {
        let (turn, place) = (RECOGNISED.0 * RECOGNISED.0, RECOGNISED.1 * RECOGNISED.1);
        let covariance = Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, place, place, place));
        let map_from_base = Uncertain { pose: *map_from_base, covariance };
        let guide = Arc::clone(ground.atlas().guide());
        // Odometry's own doubt counts from the first scan on.
        let tracker = Tracker::new(guide, map_from_base, odom_from_base, None);
        Self { tracker, quality: 0.0, scans: 0, sure: false }
    }

    /// Takes a scan in; says whether the robot may still be there.
    fn take(&mut self, scan: &Scan) -> bool {
        let Fix { trust, evidence, .. } = self.tracker.track(scan);
        let quality = evidence.matched * (1.0 - evidence.sightings.share());
        self.scans += 1;
        self.quality += (quality - self.quality) / MEAN_OF.min(f64::from(self.scans));
        self.sure = trust == Trust::Localised;
        !matches!(trust, Trust::Lost(_))
    }
}

impl Localised {
    fn track(&mut self, scan: &Scan) -> Option<Turn> {
        let fix = self.tracker.track(scan);
        self.covariance = fix.map_from_base.covariance;
        self.seen = Some(scan.stamp);
        self.doubt = match fix.trust {
            Trust::Localised => None,
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
