//! Where to begin when only the scans themselves say how the robot moved: the best of a few guesses, and when none fits
//! as scans usually do, a search over turns.

use crate::local_map::{DownsampledScan, LocalMap};
use geometry::Isometry;
use registration::{MatchingConfig, MultiStartConfig, multi_start, refine};

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
pub struct Reinitialiser {
    /// Running mean of the fit; 0 before the first.
    typical: f64,
    sample: Vec<[f32; 3]>,
}

/// Where to begin.
#[derive(Clone, Copy, Debug)]
pub struct StartPose {
    /// Body in the map.
    pub map_from_body: Isometry,
    /// Whether no guess fitted.
    pub searched: bool,
}

impl Reinitialiser {
    /// The best of the guesses, or of turned starts about them.
    pub fn find_start(
        &mut self,
        map: &LocalMap,
        downsampled: &DownsampledScan,
        guesses: &[Isometry; 3],
    ) -> StartPose {
        self.subsample(downsampled);
        let options = coarse(map);
        let mut best = refine(map.gaussians(), &self.sample, &guesses[0], &options, ITERATIONS);
        for guess in &guesses[1..] {
            if best.score > GOOD_ENOUGH * self.typical {
                return StartPose { map_from_body: best.map_from_body, searched: false };
            }
            let other = refine(map.gaussians(), &self.sample, guess, &options, ITERATIONS);
            if other.score > best.score {
                best = other;
            }
        }
        let searched = best.score <= GOOD_ENOUGH * self.typical;
        if searched {
            let turned = multi_start(
                map.gaussians(),
                &self.sample,
                &guesses[..2],
                &options,
                &MultiStartConfig::default(),
            );
            let least = (CLEARLY_BETTER * best.score).max(POOR * self.typical);
            if let Some(found) = turned.filter(|found| found.score > least) {
                best = found;
            }
        }
        StartPose { map_from_body: best.map_from_body, searched }
    }

    /// Whether a scan fits at a pose about as well as scans usually do.
    pub fn is_typical_fit(
        &mut self,
        map: &LocalMap,
        downsampled: &DownsampledScan,
        map_from_body: &Isometry,
    ) -> bool {
        self.fit(map, downsampled, map_from_body) > POOR * self.typical
    }

    /// Whether a scan fits so well at a pose that nobody expected that it is hardly taken somewhere that looks alike.
    pub fn is_confident_fit(
        &mut self,
        map: &LocalMap,
        downsampled: &DownsampledScan,
        map_from_body: &Isometry,
    ) -> bool {
        self.fit(map, downsampled, map_from_body) > GOOD_ENOUGH * self.typical
    }

    fn fit(&mut self, map: &LocalMap, downsampled: &DownsampledScan, map_from_body: &Isometry) -> f64 {
        self.subsample(downsampled);
        registration::score(map.gaussians(), &self.sample, map_from_body, &coarse(map))
    }

    /// Remembers how well an accepted scan fits at its final pose, before it enters the map.
    pub fn update_typical_score(
        &mut self,
        map: &LocalMap,
        downsampled: &DownsampledScan,
        map_from_body: &Isometry,
    ) {
        let fit = self.fit(map, downsampled, map_from_body);
        self.typical += (fit - self.typical) * if self.typical > 0.0 { LEARNING } else { 1.0 };
    }

    /// Evenly spread points of a scan.
    fn subsample(&mut self, downsampled: &DownsampledScan) {
        let step = downsampled.coarse.len().div_ceil(SAMPLE).max(1);
        self.sample.clear();
        self.sample.extend(downsampled.coarse.iter().step_by(step));
    }
}

/// Matching that is wide enough to be drawn in from afar.
fn coarse(map: &LocalMap) -> MatchingConfig {
    MatchingConfig { gate_m: 0.2, noise_m: 0.03, ..map.matching() }
}
