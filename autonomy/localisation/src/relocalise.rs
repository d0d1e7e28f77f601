//! Where the robot stands in a known map, told from one scan and nothing else.
//!
//! What looks alike is tried: a scan is fitted to the known surfaces from many starts, what fits best is settled with all of its points,
//! and the keyframes about say whether they could have seen it there. The answer is a list of places, best first. Sites are built of
//! like parts, so that one scan often fits in several; whoever asks must not believe the first one before the others are out.

use crate::guide::Guide;
use geometry::{Isometry, Vector3, so3};
use mapping::ORIGINS;
use mapping::Place;
use mapping::places::Places;
use mapping::scan_context::{first_from_second, level_from_base};
use nalgebra::Translation3;
use registration::{Fit, MatchOptions, refine, score};
use std::sync::Arc;

/// Places looked at that look alike, and their greatest distance of descriptors.
const LOOKED_AT: usize = 24;
const RESEMBLANCE: f32 = 0.85;
/// Two starts are different beyond this: metres and radians.
const STARTS_APART: (f64, f64) = (1.0, 0.3);
/// Besides each place that looks alike, starts so far aside, metres.
const ASIDE: f64 = 1.2;
/// Points that try starts out, and steps.
const COARSE_POINTS: usize = 300;
const COARSE_STEPS: usize = 8;
const COARSE: MatchOptions = MatchOptions { gate: 0.25, kernel: 3.0, noise: 0.05, spread: true };
/// The best are settled with all points.
const SETTLED: usize = 10;
const FINE_STEPS: usize = 12;
const FINE: MatchOptions = MatchOptions { gate: 0.15, kernel: 3.0, noise: 0.02, spread: true };
/// Two places are different beyond this: metres and radians.
const APART: (f64, f64) = (0.5, 0.15);

/// A known map, to find oneself in.
#[derive(Clone, Debug)]
pub struct Atlas {
    guide: Arc<Guide>,
    places: Places,
}

/// A place where a scan may have been taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hypothesis {
    /// The base.
    pub map_from_base: Isometry,
    /// How well the scan fits the known surfaces there, 0 to 1.
    pub fit: f64,
    /// Share of its points, of those that keyframes can speak of, that stand where they saw through.
    pub contradicted: f64,
}

impl Hypothesis {
    /// How good it is: what fits, less what cannot be.
    pub fn quality(&self) -> f64 {
        self.fit * (1.0 - self.contradicted)
    }
}

impl Atlas {
    /// Of a known map.
    pub fn new(guide: Arc<Guide>) -> Self {
        let mut places = Places::default();
        for (_, place) in guide.keyframes() {
            places.push(Arc::clone(&place.views()[0]));
        }
        Self { guide, places }
    }

    /// The known map.
    pub fn guide(&self) -> &Arc<Guide> {
        &self.guide
    }

    /// Where a scan may have been taken, the base being turned like that in a frame whose z axis points up: places apart from each
    /// other, best first. Costs some 0.2 s, whatever the map's size but for a look at each keyframe's ring key.
    pub fn seek(&self, place: &Place, up_from_base: &geometry::Rotation) -> Vec<Hypothesis> {
        let points: Vec<[f32; 3]> = place.points().collect();
        let few: Vec<[f32; 3]> =
            points.iter().step_by(points.len().div_ceil(COARSE_POINTS).max(1)).copied().collect();
        let surfaces = self.guide.surfaces();
        let mut fits: Vec<Fit> = self
            .starts(place, up_from_base)
            .iter()
            .map(|start| refine(surfaces, &few, start, &COARSE, COARSE_STEPS))
            .collect();
        // Stable, so that of equals the one that looks more alike comes first.
        fits.sort_by(|a, b| b.score.total_cmp(&a.score));
        let mut settled: Vec<Hypothesis> = Vec::new();
        for fit in distinct(&fits).into_iter().take(SETTLED) {
            let Fit { map_from_body, .. } = refine(surfaces, &points, &fit.map_from_body, &FINE, FINE_STEPS);
            let sightings = self.guide.sightings(&map_from_body, &points);
            settled.push(Hypothesis {
                map_from_base: map_from_body,
                fit: score(surfaces, &points, &map_from_body, &FINE),
                contradicted: sightings.contradicted(),
            });
        }
        settled.sort_by(|a, b| b.quality().total_cmp(&a.quality()));
        let mut chosen: Vec<Hypothesis> = Vec::new();
        for one in settled {
            if chosen.iter().all(|other| apart(&other.map_from_base, &one.map_from_base, APART)) {
                chosen.push(one);
            }
        }
        chosen
    }

    /// Poses of the base from which fits are tried.
    fn starts(&self, place: &Place, up_from_base: &geometry::Rotation) -> Vec<Isometry> {
        let level = level_from_base(up_from_base);
        let keyframes = self.guide.keyframes();
        let mut alike: Vec<Isometry> = Vec::new();
        for resemblance in self.places.search(place.views(), 0..keyframes.len()) {
            if alike.len() == LOOKED_AT || resemblance.alignment.distance > RESEMBLANCE {
                break;
            }
            let (map_from_keyframe, _) = &keyframes[resemblance.place];
            let origin = ORIGINS[resemblance.view];
            let its_level = level_from_base(&map_from_keyframe.rotation);
            let guess =
                map_from_keyframe * first_from_second(&resemblance.alignment, &its_level, &level, origin);
            if alike.iter().all(|other| apart(other, &guess, STARTS_APART)) {
                alike.push(guess);
            }
        }
        let around = [(0.0, 0.0), (ASIDE, 0.0), (-ASIDE, 0.0), (0.0, ASIDE), (0.0, -ASIDE)];
        let aside = |guess: &Isometry| {
            let guess = *guess;
            around.map(|(x, y)| {
                let moved = guess.translation.vector + Vector3::new(x, y, 0.0);
                Isometry::from_parts(Translation3::from(moved), guess.rotation)
            })
        };
        alike.iter().flat_map(aside).collect()
    }
}

/// Those fits that are no others' doubles, in their order.
fn distinct(fits: &[Fit]) -> Vec<Fit> {
    let mut chosen: Vec<Fit> = Vec::new();
    for fit in fits {
        if chosen.iter().all(|other| apart(&other.map_from_body, &fit.map_from_body, APART)) {
            chosen.push(*fit);
        }
    }
    chosen
}

fn apart(a: &Isometry, b: &Isometry, (metres, radians): (f64, f64)) -> bool {
    (a.translation.vector - b.translation.vector).norm() > metres
        || so3::log(&(a.rotation.inverse() * b.rotation)).norm() > radians
}
