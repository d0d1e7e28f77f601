//! Loop candidates: old keyframes worth comparing with the newest one, because the estimates put them within reach or because they look
//! alike (docs/maths/loops.md, section 4).

use crate::odometry_chain::OdometryChain;
use crate::scan_context::first_from_second;
use crate::scan_context_index::ScanContextMatch;
use crate::{CandidateSource, PoseCertaintyConfig, UncertainPose};
use geometry::{Isometry, Rotation, Vector3};
use std::ops::Range;

/// Which old keyframes are compared with the newest one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CandidateConfig {
    /// Least walking distance between two keyframes for a loop, metres. Nearer ones are recent travel. Chosen: odometry drifts by some millimetres over it
    /// (docs/benchmarks/odometry.md), so that a nearer loop measures nothing new.
    pub min_walked_m: f64,
    /// Horizontal distance at which two keyframes still see the same surroundings, metres. Chosen: two and a half keyframes; the overlap of clouds falls with the
    /// distance.
    pub max_offset_m: f64,
    /// Vertical distance at which two keyframes still see the same surroundings, metres. Less than half a storey. Chosen: ramps and steps of a floor are lower.
    pub max_height_m: f64,
    /// Limit of the horizontal search radius however uncertain the estimate is, metres. Chosen: it bounds the cost; beyond it, appearance proposes candidates.
    pub max_search_radius_m: f64,
    /// Standard deviations by which the search radius grows with the uncertainty of the estimate. Source: the usual three standard deviations.
    pub search_deviations: f64,
    /// Greatest distance of scan contexts that count as alike, 0 to 1. Chosen: less than the 0.75 of merging maps, because nothing votes here.
    pub max_appearance_distance: f32,
    /// Greatest number of candidates of each kind, by geometry and by appearance. Chosen: the nearest and one more; each costs a comparison of 4 to 6 ms
    /// (docs/maths/loops.md).
    pub max_count: usize,
    /// After a loop was accepted by geometry, the next candidate by geometry is compared only after this walking distance, metres. Chosen: two keyframes. The graph is
    /// certain there, so that more loops add cost and little information.
    pub spacing_m: f64,
    /// Candidates by appearance are skipped if the estimate of a candidate by geometry has at most this standard deviation, metres. Its default is
    /// that of [`PoseCertaintyConfig`].
    pub certain_std_m: f64,
}

impl Default for CandidateConfig {
    fn default() -> Self {
        Self {
            min_walked_m: 15.0,
            max_offset_m: 2.5,
            max_height_m: 1.0,
            max_search_radius_m: 12.0,
            search_deviations: 3.0,
            max_appearance_distance: 0.45,
            max_count: 2,
            spacing_m: 2.0,
            certain_std_m: PoseCertaintyConfig::default().max_std_m,
        }
    }
}

impl CandidateConfig {
    /// Greatest height difference of a candidate whose estimate has this standard deviation, metres. It stays below a storey.
    fn height_limit_m(&self, std_m: f64) -> f64 {
        self.max_height_m + (self.search_deviations * std_m).min(self.max_height_m)
    }
}

/// An old keyframe to compare with the newest one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopCandidate {
    /// Its number.
    pub keyframe: usize,
    /// Why it was proposed.
    pub source: CandidateSource,
    /// Guess of the newest keyframe's pose in it.
    pub guess: Isometry,
    /// The same pose as the graph knows it.
    pub expected: UncertainPose,
}

/// Keyframes that are not recent travel: all up to the last one that lies far enough before `newest` along the walk.
pub fn old_keyframes(chain: &OdometryChain, newest: usize, config: &CandidateConfig) -> Range<usize> {
    let is_recent =
        |keyframe: &usize| chain.distance_between(*keyframe, newest).is_none_or(|d| d < config.min_walked_m);
    let first_recent = (0..=newest).rev().take_while(is_recent).last().unwrap_or(newest);
    0..first_recent
}

/// Candidates by geometry: nearest first, each from another part of the walk. `poses` are the keyframes' poses in `newest`. Linear in the
/// old keyframes.
pub fn by_geometry(
    poses: &[Option<UncertainPose>],
    chain: &OdometryChain,
    level_from_newest: &Rotation,
    old: Range<usize>,
    config: &CandidateConfig,
) -> Vec<LoopCandidate> {
    let mut near: Vec<(f64, usize, UncertainPose)> = old
        .filter_map(|keyframe| {
            let seen = poses.get(keyframe).copied().flatten()?;
            let offset: Vector3 = level_from_newest * seen.pose.translation.vector;
            let std_m = seen.translation_std_m();
            let distance_m = offset.xy().norm();
            let radius_m =
                (config.max_offset_m + config.search_deviations * std_m).min(config.max_search_radius_m);
            let is_near = distance_m <= radius_m && offset.z.abs() <= config.height_limit_m(std_m);
            is_near.then_some((distance_m, keyframe, seen))
        })
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut chosen: Vec<LoopCandidate> = Vec::new();
    for (_, keyframe, seen) in near {
        if chosen.len() < config.max_count && is_elsewhere(&chosen, keyframe, chain, config) {
            let expected = seen.inverse();
            let source = CandidateSource::Geometry;
            chosen.push(LoopCandidate { keyframe, source, guess: expected.pose, expected });
        }
    }
    chosen
}

/// Whether a keyframe is from another part of the walk than all candidates chosen so far.
fn is_elsewhere(
    chosen: &[LoopCandidate],
    keyframe: usize,
    chain: &OdometryChain,
    config: &CandidateConfig,
) -> bool {
    let is_far = |c: &LoopCandidate| {
        chain.distance_between(c.keyframe, keyframe).is_some_and(|d| d > config.min_walked_m)
    };
    chosen.iter().all(is_far)
}

/// Whether any old keyframe could become a candidate by appearance. If the estimates rule out all of them, no scan context has to be
/// computed. `view_offset_m` is the distance of the farthest virtual view from the base, `deviations` as for [`by_appearance`]. Linear in
/// the old keyframes, 30 ns each where they are far away.
pub fn appearance_may_help(
    poses: &[Option<UncertainPose>],
    level_from_newest: &Rotation,
    old: Range<usize>,
    (view_offset_m, deviations): (f64, f64),
    config: &CandidateConfig,
) -> bool {
    poses.get(old).unwrap_or_default().iter().flatten().any(|seen| {
        let distance_m = (level_from_newest * seen.pose.translation.vector).xy().norm();
        let is_near = |std_m: f64| distance_m <= config.max_offset_m + view_offset_m + deviations * std_m;
        // A cheap upper bound first: the trace of the translation, and that of the rotation at the lever of the distance.
        let variance = |first: usize| (first..first + 3).map(|i| seen.covariance[(i, i)]).sum::<f64>();
        let bound = variance(3).max(0.0).sqrt() + distance_m * variance(0).max(0.0).sqrt();
        is_near(bound) && is_near(seen.inverse().translation_std_m())
    })
}

/// Candidates by appearance: most alike first, each from another part of the walk, and none that the estimates rule out by more than
/// `deviations` standard deviations. `origins` are the points from which the views of the query were taken.
pub fn by_appearance(
    found: &[ScanContextMatch],
    levels: &[Rotation],
    origins: &[[f32; 2]],
    poses: &[Option<UncertainPose>],
    chain: &OdometryChain,
    (newest, deviations): (usize, f64),
    config: &CandidateConfig,
) -> Vec<LoopCandidate> {
    let mut chosen: Vec<LoopCandidate> = Vec::new();
    for found in found {
        if chosen.len() == config.max_count || found.alignment.distance > config.max_appearance_distance {
            break;
        }
        let keyframe = found.keyframe;
        if !is_elsewhere(&chosen, keyframe, chain, config) {
            continue;
        }
        let (Some(level_from_old), Some(level_from_newest), Some(origin)) =
            (levels.get(keyframe), levels.get(newest), origins.get(found.view))
        else {
            continue;
        };
        let Some(expected) = poses.get(keyframe).copied().flatten().map(|seen| seen.inverse()) else {
            continue;
        };
        let guess = first_from_second(&found.alignment, level_from_old, level_from_newest, *origin);
        // The guess is right to a few metres. A guess farther away would be rejected by the consistency check anyway.
        let error = level_from_old * (guess.translation.vector - expected.pose.translation.vector);
        let std_m = expected.translation_std_m();
        if error.xy().norm() > config.max_offset_m + deviations * std_m
            || error.z.abs() > config.height_limit_m(std_m)
        {
            continue;
        }
        let source = CandidateSource::Appearance(found.alignment.distance);
        chosen.push(LoopCandidate { keyframe, source, guess, expected });
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::covariance_graph::CovarianceGraph;
    use crate::scan_context::ScanContextAlignment;
    use crate::testing::at;
    use geometry::Matrix6;

    /// 30 m forth, and 30 m back beside it at the height `rise`. Returns the chain and the poses in its last keyframe.
    fn walk(rise: f64, variance: f64) -> (OdometryChain, Vec<Option<UncertainPose>>) {
        let (mut chain, mut graph) = (OdometryChain::default(), CovarianceGraph::default());
        let mut poses: Vec<Isometry> = (0..=30).map(|i| at(f64::from(i), 0.0, 0.0)).collect();
        poses.extend((0..=30).rev().map(|i| {
            let mut pose = at(f64::from(i), 0.8, 3.0);
            pose.translation.vector.z = rise;
            pose
        }));
        for (index, pair) in poses.windows(2).enumerate() {
            let step = UncertainPose {
                pose: pair[0].inverse() * pair[1],
                covariance: Matrix6::identity() * variance,
            };
            chain.push(&step);
            graph.add_odometry(index, index + 1, &step);
        }
        let newest = chain.len() - 1;
        (chain, graph.poses_in(newest))
    }

    fn geometric(rise: f64, variance: f64) -> Vec<LoopCandidate> {
        let (chain, poses) = walk(rise, variance);
        let (newest, config) = (chain.len() - 1, CandidateConfig::default());
        let old = old_keyframes(&chain, newest, &config);
        assert!((40..50).contains(&old.end), "{old:?}");
        by_geometry(&poses, &chain, &Rotation::identity(), old, &config)
    }

    #[test]
    fn the_nearest_old_keyframe_is_found_and_other_floors_are_not() {
        let found = geometric(0.0, 1e-8);
        assert_eq!(found.iter().map(|c| c.keyframe).collect::<Vec<_>>(), [0]);
        let guess = &found[0].guess;
        assert!((guess.translation.vector - Vector3::new(0.0, 0.8, 0.0)).norm() < 1e-9, "{guess}");
        // However uncertain the estimate is, a storey up is another floor.
        assert!(geometric(4.0, 1e-8).is_empty() && geometric(4.0, 1e-2).is_empty());
    }

    #[test]
    fn uncertain_estimates_enlarge_the_search_radius() {
        let (chain, poses) = walk(0.0, 1e-8);
        let config = CandidateConfig { max_offset_m: 0.5, ..CandidateConfig::default() };
        let level = Rotation::identity();
        assert!(by_geometry(&poses, &chain, &level, 0..40, &config).is_empty());
        let (chain, poses) = walk(0.0, 1e-3);
        assert_eq!(by_geometry(&poses, &chain, &level, 0..40, &config).len(), 1);
    }

    #[test]
    fn appearance_is_skipped_where_the_estimates_rule_out_all_keyframes() {
        let (level, config) = (Rotation::identity(), CandidateConfig::default());
        let matter = |old, variance, aside| {
            let (_, poses) = walk(0.0, variance);
            appearance_may_help(&poses, &level, old, (aside, 10.0), &config)
        };
        // The walk ends beside keyframe 0.
        assert!(matter(0..30, 1e-8, 0.0) && !matter(8..30, 1e-8, 0.0) && !matter(8..30, 1e-8, 1.5));
        assert!(matter(8..30, 1e-8, 6.0), "a view farther from the base");
        assert!(matter(8..30, 1e-3, 0.0), "uncertain estimates");
        assert!(!matter(8..4_000, 1e-3, 9.0), "no such keyframes");
    }

    #[test]
    fn candidates_by_appearance_must_agree_with_the_estimates() {
        let found = |keyframe| ScanContextMatch {
            keyframe,
            view: 0,
            alignment: ScanContextAlignment { distance: 0.2, yaw: 3.0 },
        };
        let chosen = |rise, variance, place| {
            let (chain, poses) = walk(rise, variance);
            let levels = vec![Rotation::identity(); chain.len()];
            let config = CandidateConfig::default();
            let newest = (chain.len() - 1, 10.0);
            by_appearance(&[found(place)], &levels, &[[0.0; 2]], &poses, &chain, newest, &config).len()
        };
        assert_eq!((chosen(0.0, 1e-8, 0), chosen(0.0, 1e-8, 20)), (1, 0));
        assert_eq!((chosen(0.0, 1e-3, 20), chosen(4.0, 1e-3, 0)), (1, 0));
        assert_eq!(chosen(0.0, 1e-8, 4_000), 0, "an unknown keyframe");
    }
}
