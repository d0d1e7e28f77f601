//! Finds a start for registration when only the scans themselves say how the robot moved: the best of a few candidates, or, if none
//! fits as scans usually do, the best of many rotated starts.

use crate::local_map::{DownsampledPoints, LocalMap};
use geometry::Isometry;
use registration::{MatchingConfig, MultiStartConfig, multi_start, refine, score};

/// Parameters of a [`Reinitialiser`]. Scores are shares of the typical score of recent scans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReinitialiserConfig {
    /// Points that are used to compare starts. Chosen: an eighth of a scan's points, for time.
    pub sample_points: usize,
    /// Gauss-Newton iterations that refine a candidate before it is scored. Chosen: as the default of [`registration::GaussNewtonConfig`].
    pub refine_iterations: usize,
    /// A start with a higher score than this is taken without trying others. Also the least score of a scan far from its prediction,
    /// because places look alike. Chosen: people in a scan may take a seventh of the usual score.
    pub confident_score: f64,
    /// A start with a lower score than this is not followed. Chosen: below it, two fifths of what usually fits fit nowhere.
    pub min_score: f64,
    /// A rotated start has to fit this many times as well as the best candidate. Behind a door most of the seen surfaces are new and fit at no pose,
    /// so a rotated start may fit slightly better by chance.
    pub min_improvement: f64,
    /// Weight of one scan in the running mean of scores. Chosen: ten scans, a second at 10 Hz; surroundings change the score within some seconds.
    pub learning_rate: f64,
    /// Gate of the matching, metres: wide enough to converge from several decimetres. Chosen: twice that of a scan near its prediction.
    pub gate_m: f32,
    /// Noise of the matching, metres, for the same reason. Chosen: three times that of a scan near its prediction.
    pub noise_m: f32,
    /// The rotated starts.
    pub multi_start: MultiStartConfig,
}

impl Default for ReinitialiserConfig {
    fn default() -> Self {
        Self {
            sample_points: 500,
            refine_iterations: 10,
            confident_score: 0.85,
            min_score: 0.6,
            min_improvement: 1.3,
            learning_rate: 0.1,
            gate_m: 0.2,
            noise_m: 0.03,
            multi_start: MultiStartConfig::default(),
        }
    }
}

/// Learns how well scans fit, and finds starts.
#[derive(Clone, Debug)]
pub struct Reinitialiser {
    config: ReinitialiserConfig,
    /// Running mean of the scores of accepted scans; 0 before the first.
    typical_score: f64,
    sample: Vec<[f32; 3]>,
}

/// A start for registration.
#[derive(Clone, Copy, Debug)]
pub struct StartPose {
    /// Pose of the body in the map.
    pub map_from_body: Isometry,
    /// Whether rotated starts were searched because no candidate fitted.
    pub searched: bool,
}

impl Reinitialiser {
    /// Before the first scan.
    pub fn new(config: ReinitialiserConfig) -> Self {
        Self { config, typical_score: 0.0, sample: Vec::new() }
    }

    /// The best of the candidates, or of rotated starts about the first two.
    pub fn find_start(
        &mut self,
        map: &LocalMap,
        scan: &DownsampledPoints,
        candidates: &[Isometry; 3],
    ) -> StartPose {
        self.subsample(scan);
        let config = self.config;
        let matching = self.matching(map);
        let refined = |candidate: &Isometry| {
            refine(map.gaussians(), &self.sample, candidate, &matching, config.refine_iterations)
        };
        let mut best = refined(&candidates[0]);
        for candidate in &candidates[1..] {
            if best.score > config.confident_score * self.typical_score {
                return StartPose { map_from_body: best.map_from_body, searched: false };
            }
            let other = refined(candidate);
            if other.score > best.score {
                best = other;
            }
        }
        let searched = best.score <= config.confident_score * self.typical_score;
        if searched {
            let rotated =
                multi_start(map.gaussians(), &self.sample, &candidates[..2], &matching, &config.multi_start);
            let least = (config.min_improvement * best.score).max(config.min_score * self.typical_score);
            if let Some(found) = rotated.filter(|found| found.score > least) {
                best = found;
            }
        }
        StartPose { map_from_body: best.map_from_body, searched }
    }

    /// Whether a scan fits at a pose about as well as scans usually do.
    pub fn is_typical_fit(
        &mut self,
        map: &LocalMap,
        scan: &DownsampledPoints,
        map_from_body: &Isometry,
    ) -> bool {
        self.score(map, scan, map_from_body) > self.config.min_score * self.typical_score
    }

    /// Whether a scan fits so well at an unexpected pose that a place that only looks alike is unlikely.
    pub fn is_confident_fit(
        &mut self,
        map: &LocalMap,
        scan: &DownsampledPoints,
        map_from_body: &Isometry,
    ) -> bool {
        self.score(map, scan, map_from_body) > self.config.confident_score * self.typical_score
    }

    /// Updates the typical score by an accepted scan at its final pose, before the scan enters the map.
    pub fn update_typical_score(
        &mut self,
        map: &LocalMap,
        scan: &DownsampledPoints,
        map_from_body: &Isometry,
    ) {
        let score = self.score(map, scan, map_from_body);
        let rate = if self.typical_score > 0.0 { self.config.learning_rate } else { 1.0 };
        self.typical_score += (score - self.typical_score) * rate;
    }

    fn score(&mut self, map: &LocalMap, scan: &DownsampledPoints, map_from_body: &Isometry) -> f64 {
        self.subsample(scan);
        score(map.gaussians(), &self.sample, map_from_body, &self.matching(map))
    }

    /// Takes evenly spread points of a scan as the sample.
    fn subsample(&mut self, scan: &DownsampledPoints) {
        let step = scan.coarse.len().div_ceil(self.config.sample_points).max(1);
        self.sample.clear();
        self.sample.extend(scan.coarse.iter().step_by(step));
    }

    /// The map's matching, wide enough to converge from far away.
    fn matching(&self, map: &LocalMap) -> MatchingConfig {
        let ReinitialiserConfig { gate_m, noise_m, .. } = self.config;
        // From decimetres away, a point may be on the wrong side of a thin surface.
        MatchingConfig { gate_m, noise_m, front_facing_only: false, ..map.config().matching }
    }
}
