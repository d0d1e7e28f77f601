//! What is asked of a known map: where one scan may have been taken.
//!
//! Answering takes a tenth of a second or more, so it is a job: whatever it needs leaves the stack with it, and its answer comes back as
//! an input.

use crate::localising::Located;
use crate::progress::Progress;
use crate::second_opinion::outdone;
use crate::work::Work;
use geometry::{Isometry, isometry_from_pose, pose_from_isometry, so3};
use localisation::{Atlas, Guide, Hypothesis, Standing, standing};
use mapping::Place;
use messages::{PossiblePlace, RelocaliseTask, Relocalised};
use std::sync::{Arc, OnceLock};
use vocab::{MapId, Span, Stamp};

/// Where nothing was recognised, the question is asked again after so many metres or radians, or so long.
const AGAIN: (f64, f64) = (0.5, 0.5);
const AGAIN_AFTER: Span = Span::from_millis(2_000);
/// As far as keyframes' clouds reach, metres.
const READY: f64 = 64.0;

/// A known map, with what is made of it when it is first needed, by whoever needs it: the same whoever that is.
#[derive(Debug)]
pub(crate) struct Ground {
    guide: Arc<Guide>,
    atlas: OnceLock<Atlas>,
}

impl Ground {
    /// Of keyframes, each with its pose in the map.
    pub fn new(keyframes: Vec<(Isometry, Place)>) -> Self {
        Self { guide: Arc::new(Guide::new(keyframes)), atlas: OnceLock::new() }
    }

    /// The map's surfaces and what its keyframes saw.
    pub fn guide(&self) -> &Arc<Guide> {
        &self.guide
    }

    fn atlas(&self) -> &Atlas {
        self.atlas.get_or_init(|| Atlas::new(Arc::clone(&self.guide)))
    }
}

/// What is thought of the robot's place when it asks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Thought {
    /// It may be anywhere.
    Nothing,
    /// Somebody said that the base is about there.
    Told(Isometry),
    /// The contacts of a dock say that it is about one of these.
    Docked(Vec<Isometry>),
    /// The robot believes that the base is there, and wants to know whether it might be elsewhere.
    Held(Isometry),
}

/// A question, from when it comes up until the next one does.
#[derive(Debug)]
pub(crate) struct Question {
    pub at: Stamp,
    pub number: u64,
    pub odom_from_base: Isometry,
    pub thought: Thought,
    place: Place,
    progress: Progress,
}

impl Question {
    /// About a located scan, of which `place` is made.
    pub fn new(located: &Located, place: Place, number: u64, thought: Thought) -> Self {
        let (at, odom_from_base) = (located.stamp, located.odom_from_base);
        Self { at, number, odom_from_base, thought, place, progress: Progress::default() }
    }

    /// Whether it is time to ask again where nothing was recognised.
    pub fn is_stale(&self, located: &Located) -> bool {
        let moved = self.odom_from_base.inverse() * located.odom_from_base;
        let far = moved.translation.vector.norm() >= AGAIN.0 || so3::log(&moved.rotation).norm() >= AGAIN.1;
        self.progress == Progress::Answered && (far || located.stamp - self.at >= AGAIN_AFTER)
    }

    /// Begins with a job, if it has not begun; says whether it did.
    pub fn start(&mut self, job: u64) -> bool {
        self.progress.start(job)
    }

    /// Whether it has not been answered.
    pub fn is_open(&self) -> bool {
        self.progress != Progress::Answered
    }

    /// Whether a job answers it.
    pub fn is_answered_by(&self, job: u64) -> bool {
        self.progress.is_run_by(job)
    }

    /// Takes the answer, none if there is none: places, the best first.
    pub fn answered(&mut self, answer: Option<&Relocalised>) -> Vec<Hypothesis> {
        self.progress = Progress::Answered;
        let read = |place: &PossiblePlace| {
            let map_from_base = isometry_from_pose(&place.map_from_base)?;
            Some(Hypothesis { map_from_base, fit: place.fit, contradicted: place.contradicted })
        };
        answer.map(|answer| answer.places.iter().filter_map(read).collect()).unwrap_or_default()
    }

    /// What its job takes.
    pub fn work(&self, map: MapId, ground: &Arc<Ground>) -> Work {
        Work::ask(Ask {
            task: RelocaliseTask { map, number: self.number },
            ground: Arc::clone(ground),
            odom_from_base: self.odom_from_base,
            place: self.place.clone(),
            thought: self.thought.clone(),
        })
    }
}

/// A question on its way.
#[derive(Debug)]
pub(crate) struct Ask {
    pub task: RelocaliseTask,
    ground: Arc<Ground>,
    odom_from_base: Isometry,
    place: Place,
    thought: Thought,
}

impl Ask {
    /// Where the scan may have been taken: a pure function of what it owns, see [`Atlas::seek`].
    pub fn run(self) -> Relocalised {
        let places = match &self.thought {
            Thought::Told(told) => self.seek_told(std::slice::from_ref(told)),
            Thought::Docked(docks) => self.seek_told(docks),
            Thought::Held(held) => {
                // Until it asks again the robot walks on ground that is ready.
                self.ground.guide().surfaces().make_about(&held.translation.vector, READY);
                self.seek(Some(held))
            }
            Thought::Nothing => self.seek(None),
        };
        let plain = |one: &Hypothesis| PossiblePlace {
            map_from_base: pose_from_isometry(&one.map_from_base),
            fit: one.fit,
            contradicted: one.contradicted,
        };
        Relocalised { task: self.task, places: places.iter().map(plain).collect() }
    }

    fn seek(&self, held: Option<&Isometry>) -> Vec<Hypothesis> {
        self.ground.atlas().seek(&self.place, &self.odom_from_base.rotation, held)
    }

    /// Where somebody said, if the scan fits there: nobody need wait to see that until the whole map is searched for look-alikes,
    /// which the robot asks for next. Else wherever it fits better.
    fn seek_told(&self, told: &[Isometry]) -> Vec<Hypothesis> {
        let about = self.ground.guide().seek_about(&self.place, told);
        if matches!(standing(&about), Standing::There(_) | Standing::OneOf(_)) {
            return about;
        }
        let Some(best) = about.first() else { return about };
        let held = &best.map_from_base;
        outdone(held, &self.seek(Some(held))).unwrap_or(about)
    }
}
