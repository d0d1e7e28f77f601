//! Where to begin when only the scans themselves say how the robot moved: the best of a few guesses, and when none fits
//! as scans usually do, a search over turns.

use crate::local_map::{LocalMap, Thinned};
use geometry::Isometry;
use registration::{MatchOptions, SearchOptions, refine, search};

/// Points that compare guesses.
const SAMPLE: usize = 500;
/// Steps that refine a guess before it is judged.
const ITERATIONS: usize = 10;
/// A guess that fits this share of what is typical is taken.
const GOOD_ENOUGH: f64 = 0.85;
/// One that fits less than this share is not followed.
const POOR: f64 = 0.6;
/// A turned start must fit so many times as well as the best guess, and as well as [`POOR`] asks, to be followed: through a
/// door most of what is seen is new and fits nowhere, and something turned fits a little better by chance.
const CLEARLY_BETTER: f64 = 1.3;
/// Weight of one scan in the running mean of fits.
const LEARNING: f64 = 0.1;

/// Knows how well scans fit when all is well.
#[derive(Clone, Debug, Default)]
pub struct Recovery {
    /// Running mean of the fit; 0 before the first.
    typical: f64,
    sample: Vec<[f32; 3]>,
}

/// Where to begin.
#[derive(Clone, Copy, Debug)]
pub struct Beginning {
    /// Body in the map.
    pub map_from_body: Isometry,
    /// Whether no guess fitted.
    pub searched: bool,
}

impl Recovery {
    /// The best of the guesses, or of turned starts about them.
    pub fn best_start(&mut self, map: &LocalMap, thinned: &Thinned, guesses: &[Isometry; 3]) -> Beginning {
        self.pick(thinned);
        let options = coarse(map);
        let mut best = refine(map.gaussians(), &self.sample, &guesses[0], &options, ITERATIONS);
        for guess in &guesses[1..] {
            if best.score > GOOD_ENOUGH * self.typical {
                return Beginning { map_from_body: best.map_from_body, searched: false };
            }
            let other = refine(map.gaussians(), &self.sample, guess, &options, ITERATIONS);
            if other.score > best.score {
                best = other;
            }
        }
        let searched = best.score <= GOOD_ENOUGH * self.typical;
        if searched {
            let turned =
                search(map.gaussians(), &self.sample, &guesses[..2], &options, &SearchOptions::default());
            let least = (CLEARLY_BETTER * best.score).max(POOR * self.typical);
            if let Some(found) = turned.filter(|found| found.score > least) {
                best = found;
            }
        }
        Beginning { map_from_body: best.map_from_body, searched }
    }

    /// Whether a scan fits at a pose about as well as scans usually do.
    pub fn fits(&mut self, map: &LocalMap, thinned: &Thinned, map_from_body: &Isometry) -> bool {
        self.fit(map, thinned, map_from_body) > POOR * self.typical
    }

    /// Whether a scan fits so well at a pose that nobody expected that it is hardly taken somewhere that looks alike.
    pub fn fits_well(&mut self, map: &LocalMap, thinned: &Thinned, map_from_body: &Isometry) -> bool {
        self.fit(map, thinned, map_from_body) > GOOD_ENOUGH * self.typical
    }

    fn fit(&mut self, map: &LocalMap, thinned: &Thinned, map_from_body: &Isometry) -> f64 {
        self.pick(thinned);
        registration::score(map.gaussians(), &self.sample, map_from_body, &coarse(map))
    }

    /// Remembers how well an accepted scan fits at its final pose, before it enters the map.
    pub fn learn(&mut self, map: &LocalMap, thinned: &Thinned, map_from_body: &Isometry) {
        let fit = self.fit(map, thinned, map_from_body);
        self.typical += (fit - self.typical) * if self.typical > 0.0 { LEARNING } else { 1.0 };
    }

    /// Evenly spread points of a scan.
    fn pick(&mut self, thinned: &Thinned) {
        let step = thinned.coarse.len().div_ceil(SAMPLE).max(1);
        self.sample.clear();
        self.sample.extend(thinned.coarse.iter().step_by(step));
    }
}

/// Matching that is wide enough to be drawn in from afar.
fn coarse(map: &LocalMap) -> MatchOptions {
    MatchOptions { gate: 0.2, noise: 0.03, ..map.matching() }
}
