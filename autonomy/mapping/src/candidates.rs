//! Which old keyframes are worth comparing with the newest: those that the estimates put within reach, and those that look
//! alike.

use crate::drift::OdometryChain;
use crate::scan_context::first_from_second;
use crate::scan_context_index::ScanContextMatch;
use crate::{CandidateSource, UncertainPose};
use geometry::{Isometry, Rotation, Vector3};
use std::ops::Range;

/// Standard deviations that "within reach" means.
const DEVIATIONS: f64 = 3.0;

/// Who is a candidate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CandidateConfig {
    /// Places reached by less walking than this are no revisits, metres.
    pub walked: f64,
    /// Horizontal distance at which two keyframes still overlook the same, metres.
    pub near: f64,
    /// The same vertically, metres: less than half a storey.
    pub level: f64,
    /// However uncertain the estimate, nothing farther than this is a geometric candidate, metres.
    pub reach: f64,
    /// Greatest distance of descriptors that look alike.
    pub resemblance: f32,
    /// Candidates of either kind at most.
    pub most: usize,
    /// Once a loop was accepted by geometry, the next is looked for after so many metres.
    pub spacing: f64,
    /// Looking alike is not asked where the estimate is at least as good as this, metres.
    pub sure: f64,
}

impl Default for CandidateConfig {
    fn default() -> Self {
        Self {
            walked: 15.0,
            near: 2.5,
            level: 1.0,
            reach: 12.0,
            resemblance: 0.45,
            most: 2,
            spacing: 2.0,
            sure: 0.4,
        }
    }
}

impl CandidateConfig {
    /// Greatest difference of height for a deviation of the estimate, metres: never a storey.
    fn rise(&self, deviation: f64) -> f64 {
        self.level + (DEVIATIONS * deviation).min(self.level)
    }
}

/// An old keyframe to compare with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Its number.
    pub keyframe: usize,
    /// Why.
    pub source: CandidateSource,
    /// Guess of the newest keyframe's pose in it.
    pub guess: Isometry,
    /// What the graph says of the same.
    pub expected: UncertainPose,
}

/// Old keyframes that are no recent travel: the longest beginning of the walk that ends far enough before `newest`.
pub fn old(chain: &OdometryChain, newest: usize, policy: &CandidateConfig) -> Range<usize> {
    let recent = |keyframe: &usize| chain.walked(*keyframe, newest).is_none_or(|w| w < policy.walked);
    let first_recent = (0..=newest).rev().take_while(recent).last().unwrap_or(newest);
    0..first_recent
}

/// Candidates by the estimates, nearest first, each from another stretch of the walk. `reach` is where each keyframe is as
/// seen from `newest`. Linear in the old keyframes.
pub fn by_geometry(
    reach: &[Option<UncertainPose>],
    chain: &OdometryChain,
    level_from_newest: &Rotation,
    old: Range<usize>,
    policy: &CandidateConfig,
) -> Vec<Candidate> {
    let mut near: Vec<(f64, usize, UncertainPose)> = old
        .filter_map(|keyframe| {
            let seen = reach.get(keyframe).copied().flatten()?;
            let offset: Vector3 = level_from_newest * seen.pose.translation.vector;
            let deviation = seen.translation_std_m();
            let apart = offset.xy().norm();
            let within = apart <= (policy.near + DEVIATIONS * deviation).min(policy.reach)
                && offset.z.abs() <= policy.rise(deviation);
            within.then_some((apart, keyframe, seen))
        })
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut chosen: Vec<Candidate> = Vec::new();
    for (_, keyframe, seen) in near {
        let fresh = |c: &Candidate| chain.walked(c.keyframe, keyframe).is_some_and(|w| w > policy.walked);
        if chosen.len() < policy.most && chosen.iter().all(fresh) {
            let expected = seen.inverse();
            let source = CandidateSource::Geometry;
            chosen.push(Candidate { keyframe, source, guess: expected.pose, expected });
        }
    }
    chosen
}

/// Whether any old keyframe could be a candidate by looks, seen from up to `aside` metres beside the base: where the estimates rule
/// all of them out, nobody has to look. `newest` and its greatest deviation as for [`by_appearance`]. Linear in the old
/// keyframes, 30 ns each where they are far.
pub fn appearance_may_help(
    reach: &[Option<UncertainPose>],
    level_from_newest: &Rotation,
    old: Range<usize>,
    (aside, deviations): (f64, f64),
    policy: &CandidateConfig,
) -> bool {
    reach.get(old).unwrap_or_default().iter().flatten().any(|seen| {
        let apart = (level_from_newest * seen.pose.translation.vector).xy().norm();
        let within = |deviation: f64| apart <= policy.near + aside + deviations * deviation;
        // First a bound that costs little: the whole of the variance, and rotation's at the lever.
        let variance = |first: usize| (first..first + 3).map(|i| seen.covariance[(i, i)]).sum::<f64>();
        let bound = variance(3).max(0.0).sqrt() + apart * variance(0).max(0.0).sqrt();
        within(bound) && within(seen.inverse().translation_std_m())
    })
}

/// Candidates by looks, most alike first, each from another stretch of the walk and none that the estimates rule out by
/// `deviations`. `origins` are the points from which the views of the search were taken.
pub fn by_appearance(
    found: &[ScanContextMatch],
    levels: &[Rotation],
    origins: &[[f32; 2]],
    reach: &[Option<UncertainPose>],
    chain: &OdometryChain,
    (newest, deviations): (usize, f64),
    policy: &CandidateConfig,
) -> Vec<Candidate> {
    let mut chosen: Vec<Candidate> = Vec::new();
    for resemblance in found {
        if chosen.len() == policy.most || resemblance.alignment.distance > policy.resemblance {
            break;
        }
        let keyframe = resemblance.place;
        let fresh = |c: &Candidate| chain.walked(c.keyframe, keyframe).is_some_and(|w| w > policy.walked);
        if !chosen.iter().all(fresh) {
            continue;
        }
        let (Some(level_from_old), Some(level_from_newest), Some(origin)) =
            (levels.get(keyframe), levels.get(newest), origins.get(resemblance.view))
        else {
            continue;
        };
        let Some(expected) = reach.get(keyframe).copied().flatten().map(|seen| seen.inverse()) else {
            continue;
        };
        let guess = first_from_second(&resemblance.alignment, level_from_old, level_from_newest, *origin);
        // The guess is right to a few metres; what is farther off than that would be refused anyway.
        let off = level_from_old * (guess.translation.vector - expected.pose.translation.vector);
        let deviation = expected.translation_std_m();
        if off.xy().norm() > policy.near + deviations * deviation || off.z.abs() > policy.rise(deviation) {
            continue;
        }
        let source = CandidateSource::Appearance(resemblance.alignment.distance);
        chosen.push(Candidate { keyframe, source, guess, expected });
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drift::CovarianceGraph;
    use crate::scan_context::Alignment;
    use crate::testing::at;
    use geometry::Matrix6;

    /// 30 m there, 30 m back beside it at height `rise`; the reach from its last keyframe.
    fn walk(rise: f64, variance: f64) -> (OdometryChain, Vec<Option<UncertainPose>>) {
        let (mut chain, mut web) = (OdometryChain::default(), CovarianceGraph::default());
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
            web.connect(index, index + 1, &step);
        }
        let newest = chain.len() - 1;
        (chain, web.reach(newest))
    }

    fn geometric(rise: f64, variance: f64) -> Vec<Candidate> {
        let (chain, reach) = walk(rise, variance);
        let (newest, policy) = (chain.len() - 1, CandidateConfig::default());
        let old = old(&chain, newest, &policy);
        assert!((40..50).contains(&old.end), "{old:?}");
        by_geometry(&reach, &chain, &Rotation::identity(), old, &policy)
    }

    #[test]
    fn the_nearest_old_place_is_found_and_other_floors_are_not() {
        let found = geometric(0.0, 1e-8);
        assert_eq!(found.iter().map(|c| c.keyframe).collect::<Vec<_>>(), [0]);
        let guess = &found[0].guess;
        assert!((guess.translation.vector - Vector3::new(0.0, 0.8, 0.0)).norm() < 1e-9, "{guess}");
        // However vague the estimate, a storey up is another floor.
        assert!(geometric(4.0, 1e-8).is_empty() && geometric(4.0, 1e-2).is_empty());
    }

    #[test]
    fn vague_estimates_reach_farther() {
        let (chain, reach) = walk(0.0, 1e-8);
        let policy = CandidateConfig { near: 0.5, ..CandidateConfig::default() };
        let level = Rotation::identity();
        assert!(by_geometry(&reach, &chain, &level, 0..40, &policy).is_empty());
        let (chain, reach) = walk(0.0, 1e-3);
        assert_eq!(by_geometry(&reach, &chain, &level, 0..40, &policy).len(), 1);
    }

    #[test]
    fn nobody_looks_where_the_estimates_rule_all_out() {
        let (level, policy) = (Rotation::identity(), CandidateConfig::default());
        let matter = |old, variance, aside| {
            let (_, reach) = walk(0.0, variance);
            appearance_may_help(&reach, &level, old, (aside, 10.0), &policy)
        };
        // The walk ends beside keyframe 0.
        assert!(matter(0..30, 1e-8, 0.0) && !matter(8..30, 1e-8, 0.0) && !matter(8..30, 1e-8, 1.5));
        assert!(matter(8..30, 1e-8, 6.0), "seen from farther aside");
        assert!(matter(8..30, 1e-3, 0.0), "known vaguely");
        assert!(!matter(8..4_000, 1e-3, 9.0), "no such keyframes");
    }

    #[test]
    fn looks_are_believed_only_where_the_estimates_allow() {
        let found =
            |place| ScanContextMatch { place, view: 0, alignment: Alignment { distance: 0.2, yaw: 3.0 } };
        let chosen = |rise, variance, place| {
            let (chain, reach) = walk(rise, variance);
            let levels = vec![Rotation::identity(); chain.len()];
            let policy = CandidateConfig::default();
            let newest = (chain.len() - 1, 10.0);
            by_appearance(&[found(place)], &levels, &[[0.0; 2]], &reach, &chain, newest, &policy).len()
        };
        assert_eq!((chosen(0.0, 1e-8, 0), chosen(0.0, 1e-8, 20)), (1, 0));
        assert_eq!((chosen(0.0, 1e-3, 20), chosen(4.0, 1e-3, 0)), (1, 0));
        assert_eq!(chosen(0.0, 1e-8, 4_000), 0, "a place that is not there");
    }
}
