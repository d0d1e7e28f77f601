//! Where the robot stands in a known map, told from one scan and nothing else.
//!
//! What looks alike is tried: a scan is fitted to the known surfaces from many starts, what fits best is settled with all of its points,
//! and the keyframes about say whether they could have seen it there. The answer is a list of places, best first. Sites are built of
//! like parts, so that one scan often fits in several; whoever asks must not believe the first one before the others are out.

use crate::correlative_matcher::CorrelativeMatcher;
use crate::localisation_map::LocalisationMap;
use geometry::{Isometry, Rotation, Vector3, so3};
use mapping::scan_context::{first_from_second, level_from_base};
use mapping::scan_context_index::ScanContextIndex;
use mapping::{KeyframeDescriptor, VIEW_ORIGINS};
use nalgebra::Translation3;
use registration::{Fit, MatchingConfig, refine, score};
use std::sync::Arc;

/// Places looked at that look alike, and their greatest distance of descriptors.
const LOOKED_AT: usize = 24;
const RESEMBLANCE: f32 = 0.85;
/// Spots looked at whose outline is alike.
const COVERED: usize = 200;
/// Two starts are different beyond this: metres and radians.
const STARTS_APART: (f64, f64) = (1.0, 0.3);
/// Starts about a place that somebody told: metres aside, and radians.
const ABOUT: ([f64; 5], [f64; 5]) = ([-1.0, -0.5, 0.0, 0.5, 1.0], [-0.35, -0.17, 0.0, 0.17, 0.35]);
/// Points that try starts out, and steps.
const COARSE_POINTS: usize = 300;
const COARSE_STEPS: usize = 8;
const COARSE: MatchingConfig = MatchingConfig {
    gate_m: 0.25,
    kernel_width: 3.0,
    noise_m: 0.05,
    use_distributions: true,
    front_facing_only: true,
};
/// The best are settled with all points.
const SETTLED: usize = 10;
const FINE_STEPS: usize = 12;
const FINE: MatchingConfig = MatchingConfig {
    gate_m: 0.15,
    kernel_width: 3.0,
    noise_m: 0.02,
    use_distributions: true,
    front_facing_only: true,
};
/// Two places are different beyond this: metres and radians.
const APART: (f64, f64) = (0.5, 0.15);

/// A known map, to find oneself in.
#[derive(Clone, Debug)]
pub struct GlobalLocaliser {
    guide: Arc<LocalisationMap>,
    places: ScanContextIndex,
    outlines: CorrelativeMatcher,
}

/// A place where a scan may have been taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseHypothesis {
    /// The base.
    pub map_from_base: Isometry,
    /// How well the scan fits the known surfaces there, 0 to 1.
    pub fit: f64,
    /// Share of its points, of those that keyframes can speak of, that stand where they saw through.
    pub contradicted: f64,
}

/// What one scan says of the robot's place.
#[derive(Clone, Debug, PartialEq)]
pub enum RelocalisationResult {
    /// It is there, and nowhere else.
    Unique(PoseHypothesis),
    /// It is at one of these, the best first; the robot has to move for the others to fail.
    Ambiguous(Vec<PoseHypothesis>),
    /// It may be there, where much of what it sees is in no map, and nowhere else; one scan is not enough to say so.
    LowConfidence(PoseHypothesis),
    /// It is nowhere that the map shows well.
    NotFound,
}

/// Least fit, and greatest contradiction, of a place that may be the right one.
const MAY_BE: (f64, f64) = (0.72, 0.1);
/// Greatest share of the best one's quality that another place may have, if nothing more is to be asked.
const ALONE: f64 = 0.85;
/// Least fit of a place that is worth another look, and the share of its quality that no other one may have.
const FAINT: (f64, f64) = (0.4, 0.75);

/// What the places where a scan may have been taken ([`GlobalLocaliser::seek`]) say of where it was.
pub fn classify_hypotheses(found: &[PoseHypothesis]) -> RelocalisationResult {
    let Some(best) = found.first() else { return RelocalisationResult::NotFound };
    if !best.may_be() {
        let faint = best.fit >= FAINT.0 && best.contradicted <= MAY_BE.1;
        let alone = found.iter().skip(1).all(|other| other.quality() < FAINT.1 * best.quality());
        return if faint && alone {
            RelocalisationResult::LowConfidence(*best)
        } else {
            RelocalisationResult::NotFound
        };
    }
    let rivals: Vec<PoseHypothesis> =
        found.iter().filter(|one| one.quality() >= ALONE * best.quality()).copied().collect();
    if rivals.len() == 1 {
        RelocalisationResult::Unique(*best)
    } else {
        RelocalisationResult::Ambiguous(rivals)
    }
}

impl PoseHypothesis {
    /// Whether it can be the right one at all.
    fn may_be(&self) -> bool {
        self.fit >= MAY_BE.0 && self.contradicted <= MAY_BE.1
    }

    /// How good it is: what fits, less what cannot be.
    pub fn quality(&self) -> f64 {
        self.fit * (1.0 - self.contradicted)
    }
}

impl LocalisationMap {
    /// How well a scan's points (base frame, metres) fit near a place, settled with all of them: twelve looks at each.
    pub fn settle(&self, points: &[[f32; 3]], start: &Isometry) -> PoseHypothesis {
        let Fit { map_from_body, .. } = refine(self.surfaces(), points, start, &FINE, FINE_STEPS);
        PoseHypothesis {
            map_from_base: map_from_body,
            fit: score(self.surfaces(), points, &map_from_body, &FINE),
            contradicted: self.sightings(&map_from_body, points).share(),
        }
    }

    /// As [`GlobalLocaliser::seek`], of a scan that was taken about one of these places, to a metre and 20 degrees. Costs as many fits for each, and
    /// nothing that grows with the map.
    pub fn seek_about(&self, place: &KeyframeDescriptor, bases: &[Isometry]) -> Vec<PoseHypothesis> {
        let moved = |map_from_base: &Isometry, x: f64, y: f64, yaw: f64| {
            let at = map_from_base.translation.vector + Vector3::new(x, y, 0.0);
            let turn = so3::exp(&(Vector3::z() * yaw)) * map_from_base.rotation;
            Isometry::from_parts(Translation3::from(at), turn)
        };
        let mut starts = Vec::new();
        for base in bases {
            for x in ABOUT.0 {
                for y in ABOUT.0 {
                    starts.extend(ABOUT.1.map(|yaw| moved(base, x, y, yaw)));
                }
            }
        }
        self.try_starts(place, &starts, None)
    }

    /// Fits a scan from all these starts and settles the best, and what is held in any case.
    fn try_starts(
        &self,
        place: &KeyframeDescriptor,
        starts: &[Isometry],
        held: Option<&Isometry>,
    ) -> Vec<PoseHypothesis> {
        let points: Vec<[f32; 3]> = place.points().collect();
        let few: Vec<[f32; 3]> =
            points.iter().step_by(points.len().div_ceil(COARSE_POINTS).max(1)).copied().collect();
        let coarse = |start| refine(self.surfaces(), &few, start, &COARSE, COARSE_STEPS);
        let mut fits: Vec<Fit> = starts.iter().map(coarse).collect();
        // Stable, so that of equals the one that looks more alike comes first.
        fits.sort_by(|a, b| b.score.total_cmp(&a.score));
        let settle = |start: &Isometry| self.settle(&points, start);
        let best = distinct(fits, |fit| &fit.map_from_body, APART).into_iter().take(SETTLED);
        let mut settled: Vec<PoseHypothesis> = best.map(|fit| settle(&fit.map_from_body)).collect();
        settled.extend(held.map(settle));
        settled.sort_by(|a, b| b.quality().total_cmp(&a.quality()));
        distinct(settled, |one| &one.map_from_base, APART)
    }
}

impl GlobalLocaliser {
    /// Of a known map.
    pub fn new(guide: Arc<LocalisationMap>) -> Self {
        let mut places = ScanContextIndex::default();
        for (_, place) in guide.keyframes() {
            places.push(Arc::clone(&place.views()[0]));
        }
        let outlines = CorrelativeMatcher::new(&guide);
        Self { guide, places, outlines }
    }

    /// The known map.
    pub fn guide(&self) -> &Arc<LocalisationMap> {
        &self.guide
    }

    /// Where a scan may have been taken, the base being turned like that in a frame whose z axis points up: places apart from each
    /// other, best first. A place that is `held` to be the right one is among them, however poor it is, unless the scan draws it elsewhere.
    /// Costs some hundred fits, a look at each keyframe's ring key, and a look at each heading of each spot near one: linear in the area
    /// walked.
    pub fn seek(
        &self,
        place: &KeyframeDescriptor,
        up_from_base: &Rotation,
        held: Option<&Isometry>,
    ) -> Vec<PoseHypothesis> {
        self.guide.try_starts(place, &self.starts(place, up_from_base), held)
    }

    /// Poses of the base from which fits are tried.
    fn starts(&self, place: &KeyframeDescriptor, up_from_base: &Rotation) -> Vec<Isometry> {
        let level = level_from_base(up_from_base);
        let keyframes = self.guide.keyframes();
        let alike = self.places.search(place.views(), 0..keyframes.len());
        let guesses = alike.iter().take_while(|one| one.alignment.distance <= RESEMBLANCE).map(|one| {
            let (map_from_keyframe, _) = &keyframes[one.place];
            let its_level = level_from_base(&map_from_keyframe.rotation);
            map_from_keyframe * first_from_second(&one.alignment, &its_level, &level, VIEW_ORIGINS[one.view])
        });
        let mut starts = distinct(guesses, |guess| guess, STARTS_APART);
        starts.truncate(LOOKED_AT);
        let points: Vec<[f32; 3]> = place.points().collect();
        let covering = self.outlines.search(&points, &level, COVERED);
        starts.extend(covering.iter().map(|cover| cover.map_from_base));
        starts
    }
}

/// Those that are no others' doubles, in their order. Quadratic.
fn distinct<T>(
    all: impl IntoIterator<Item = T>,
    pose: impl Fn(&T) -> &Isometry,
    beyond: (f64, f64),
) -> Vec<T> {
    let mut chosen: Vec<T> = Vec::new();
    for one in all {
        if chosen.iter().all(|other| apart(pose(other), pose(&one), beyond)) {
            chosen.push(one);
        }
    }
    chosen
}

/// Whether two poses of the base are the same place, one found from the other.
pub fn is_same_place(a: &Isometry, b: &Isometry) -> bool {
    !apart(a, b, APART)
}

fn apart(a: &Isometry, b: &Isometry, (metres, radians): (f64, f64)) -> bool {
    (a.translation.vector - b.translation.vector).norm() > metres
        || so3::log(&(a.rotation.inverse() * b.rotation)).norm() > radians
}
