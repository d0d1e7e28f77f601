//! Global localisation: at which poses of a known map a single scan may have been taken.
//!
//! Place recognition and correlative matching propose start poses. The scan is aligned with the map's surfaces from each of them, first with few
//! points, and from the best ones with all points. The free space of the keyframes near each result confirms or contradicts it. Sites have parts that
//! look alike, so one scan often fits at several poses. `AcceptanceConfig::classify` classifies the list.

use crate::correlative_matcher::{CorrelativeMatcher, CorrelativeMatcherConfig};
use crate::localisation_map::LocalisationMap;
use crate::periodic_global_check::{GlobalCheckResult, check_tracked_pose};
use crate::pose_hypothesis::{AcceptanceConfig, HypothesisTolerance, PoseHypothesis, RelocalisationResult};
use geometry::{Isometry, Rotation, Vector3, so3};
use mapping::scan_context::{first_from_second, level_from_base};
use mapping::scan_context_index::ScanContextIndex;
use mapping::{KeyframeDescriptor, VIEW_ORIGINS, VerificationConfig};
use nalgebra::Translation3;
use registration::{Fit, MatchingConfig, refine, score};
use std::sync::{Arc, OnceLock};

/// Parameters of [`GlobalLocaliser`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlobalLocaliserConfig {
    /// Parameters of the correlative matcher.
    pub matcher: CorrelativeMatcherConfig,
    /// Number of start poses from the correlative matcher. Chosen: the time of a search is in proportion to the number of starts; docs/benchmarks/localisation.md has
    /// what is found with 200.
    pub max_matcher_starts: usize,
    /// Number of start poses from place recognition. Chosen: the matcher gives the other starts, and each costs a coarse alignment.
    pub max_recognised_starts: usize,
    /// Greatest descriptor distance of a recognised keyframe. Chosen: greater than for maps that are merged (0.75), because the map may have changed and each start is
    /// aligned and ranked.
    pub max_descriptor_distance: f32,
    /// Start poses from place recognition are further apart than this. Chosen: the alignment converges from within it.
    pub recognised_separation: HypothesisTolerance,
    /// Offsets along x and along y from a pose prior, metres, at which starts are tried. Chosen: half a metre apart, from which the alignment converges, up to the error
    /// of a person's click and of a pose from before a restart.
    pub prior_offsets_m: [f64; 5],
    /// Heading offsets from a pose prior, radians, at which starts are tried: up to 20 degrees. Chosen: 10 degrees apart, from which the alignment converges.
    pub prior_heading_offsets_rad: [f64; 5],
    /// Number of points in the first alignment from each start. Chosen: a tenth of a keyframe's points, for time.
    pub coarse_points: usize,
    /// Gauss-Newton steps of the first alignment. Its default is that of the verification of loops ([`VerificationConfig::coarse_steps`]).
    pub coarse_iterations: usize,
    /// How points are matched in the first alignment.
    pub coarse_matching: MatchingConfig,
    /// Number of first alignments, the best, that are refined with all points. Chosen: a refinement has ten times the points of a coarse alignment.
    pub max_refined: usize,
    /// Gauss-Newton steps of the refinement. Chosen: from a coarse alignment fewer are needed mostly, so it bounds the time.
    pub fine_iterations: usize,
    /// How points are matched in the refinement.
    pub fine_matching: MatchingConfig,
    /// How hypotheses are accepted. Two poses that are one by its `same_pose` are refined once.
    pub acceptance: AcceptanceConfig,
    /// Surfaces are built up to this distance from a tracked pose, metres, so that the pose tracker need not build them until the next
    /// check. It is the range of keyframes' clouds.
    pub surface_radius_m: f64,
}

impl Default for GlobalLocaliserConfig {
    fn default() -> Self {
        Self {
            matcher: CorrelativeMatcherConfig::default(),
            max_matcher_starts: 200,
            max_recognised_starts: 24,
            max_descriptor_distance: 0.85,
            recognised_separation: HypothesisTolerance { distance_m: 1.0, angle_rad: 0.3 },
            prior_offsets_m: [-1.0, -0.5, 0.0, 0.5, 1.0],
            prior_heading_offsets_rad: [-0.35, -0.17, 0.0, 0.17, 0.35],
            coarse_points: 300,
            coarse_iterations: VerificationConfig::default().coarse_steps,
            coarse_matching: MatchingConfig { front_facing_only: true, ..MatchingConfig::coarse() },
            max_refined: 10,
            fine_iterations: 12,
            fine_matching: MatchingConfig { front_facing_only: true, ..MatchingConfig::fine() },
            acceptance: AcceptanceConfig::default(),
            surface_radius_m: 64.0,
        }
    }
}

/// Prior knowledge of the robot's pose for the localisation of a scan.
#[derive(Clone, Debug, PartialEq)]
pub enum PosePrior {
    /// No knowledge: the robot may be anywhere in the map.
    None,
    /// An approximate pose of the base, from a person or from odometry.
    Given(Isometry),
    /// The robot is charged, so the base is near one of these docks.
    AtDocks(Vec<Isometry>),
    /// The base is tracked at this pose. The search decides whether another pose fits better.
    Tracked(Isometry),
}

/// Finds poses in a known map.
#[derive(Debug)]
pub struct GlobalLocaliser {
    config: GlobalLocaliserConfig,
    map: Arc<LocalisationMap>,
    /// Built by the first search of the whole map. The result does not depend on which search is the first.
    index: OnceLock<SearchIndex>,
}

/// The data of a search of the whole map.
#[derive(Debug)]
struct SearchIndex {
    descriptors: ScanContextIndex,
    matcher: CorrelativeMatcher,
}

impl GlobalLocaliser {
    /// A localiser with default parameters. The first search of the whole map builds the data that such searches need.
    pub fn new(map: Arc<LocalisationMap>) -> Self {
        Self::with_config(GlobalLocaliserConfig::default(), map)
    }

    /// A localiser with these parameters.
    pub fn with_config(config: GlobalLocaliserConfig, map: Arc<LocalisationMap>) -> Self {
        Self { config, map, index: OnceLock::new() }
    }

    /// Its parameters.
    pub fn config(&self) -> &GlobalLocaliserConfig {
        &self.config
    }

    /// The known map.
    pub fn map(&self) -> &Arc<LocalisationMap> {
        &self.map
    }

    /// Classifies a list of hypotheses of one scan, the best first.
    pub fn classify(&self, found: &[PoseHypothesis]) -> RelocalisationResult {
        self.config.acceptance.classify(found)
    }

    /// Poses at which a scan may have been taken, the best first, by what is known about the pose. `up_from_base` is the base's rotation in
    /// a frame whose z axis points up.
    ///
    /// A given pose is accepted immediately if the scan fits there, without a search of the whole map for poses that look alike. If the scan does not
    /// fit there, the whole map is searched.
    pub fn find_poses_with_prior(
        &self,
        descriptor: &KeyframeDescriptor,
        up_from_base: &Rotation,
        prior: &PosePrior,
    ) -> Vec<PoseHypothesis> {
        match prior {
            PosePrior::Given(pose) => {
                self.find_poses_at(descriptor, up_from_base, std::slice::from_ref(pose))
            }
            PosePrior::AtDocks(docks) => self.find_poses_at(descriptor, up_from_base, docks),
            PosePrior::Tracked(pose) => {
                self.map.surfaces().build_around(&pose.translation.vector, self.config.surface_radius_m);
                self.find_poses(descriptor, up_from_base, Some(pose))
            }
            PosePrior::None => self.find_poses(descriptor, up_from_base, None),
        }
    }

    /// Poses in the whole map at which a scan may have been taken, the best first and further apart than `same_pose`. A tracked pose is among
    /// them, however poorly it fits, unless alignment moves it elsewhere. Costs some hundred alignments, a comparison with each
    /// keyframe's ring key and the correlative search: linear in the area that was walked.
    pub fn find_poses(
        &self,
        descriptor: &KeyframeDescriptor,
        up_from_base: &Rotation,
        tracked: Option<&Isometry>,
    ) -> Vec<PoseHypothesis> {
        self.align_from(descriptor, &self.start_poses(descriptor, up_from_base), tracked)
    }

    /// As [`Self::find_poses`], within a metre and 20 degrees of these priors. The cost does not grow with the map.
    pub fn find_poses_near(
        &self,
        descriptor: &KeyframeDescriptor,
        priors: &[Isometry],
    ) -> Vec<PoseHypothesis> {
        let config = &self.config;
        let moved = |map_from_base: &Isometry, x: f64, y: f64, yaw: f64| {
            let position = map_from_base.translation.vector + Vector3::new(x, y, 0.0);
            let rotation = so3::exp(&(Vector3::z() * yaw)) * map_from_base.rotation;
            Isometry::from_parts(Translation3::from(position), rotation)
        };
        let mut starts = Vec::new();
        for prior in priors {
            for x in config.prior_offsets_m {
                for y in config.prior_offsets_m {
                    starts.extend(config.prior_heading_offsets_rad.map(|yaw| moved(prior, x, y, yaw)));
                }
            }
        }
        self.align_from(descriptor, &starts, None)
    }

    /// Aligns all of a scan's points (base frame, metres) from a start pose: 12 steps, and a free-space check.
    pub fn refine_pose(&self, points: &[[f32; 3]], start: &Isometry) -> PoseHypothesis {
        let (surfaces, matching) = (self.map.surfaces(), &self.config.fine_matching);
        let Fit { map_from_body, .. } =
            refine(surfaces, points, start, matching, self.config.fine_iterations);
        PoseHypothesis {
            map_from_base: map_from_body,
            fit: score(surfaces, points, &map_from_body, matching),
            violation_share: self.map.check_free_space(&map_from_body, points).violation_share(),
        }
    }

    /// Poses near these priors if the scan fits there. Otherwise the poses in the whole map, if they fit clearly better.
    fn find_poses_at(
        &self,
        descriptor: &KeyframeDescriptor,
        up_from_base: &Rotation,
        priors: &[Isometry],
    ) -> Vec<PoseHypothesis> {
        let near = self.find_poses_near(descriptor, priors);
        if !self.classify(&near).into_accepted().is_empty() {
            return near;
        }
        let Some(best) = near.first() else { return near };
        let tracked = &best.map_from_base;
        let everywhere = self.find_poses(descriptor, up_from_base, Some(tracked));
        match check_tracked_pose(&self.config.acceptance, tracked, &everywhere) {
            GlobalCheckResult::Contradicted(better) => better,
            GlobalCheckResult::Confirmed | GlobalCheckResult::Inconclusive => near,
        }
    }

    /// Aligns a scan from all these starts, and refines the best of them and a tracked pose in any case.
    fn align_from(
        &self,
        descriptor: &KeyframeDescriptor,
        starts: &[Isometry],
        tracked: Option<&Isometry>,
    ) -> Vec<PoseHypothesis> {
        let config = &self.config;
        let same_pose = &config.acceptance.same_pose;
        let points: Vec<[f32; 3]> = descriptor.points().collect();
        let few: Vec<[f32; 3]> =
            points.iter().step_by(points.len().div_ceil(config.coarse_points).max(1)).copied().collect();
        let coarse = |start| {
            refine(self.map.surfaces(), &few, start, &config.coarse_matching, config.coarse_iterations)
        };
        let mut fits: Vec<Fit> = starts.iter().map(coarse).collect();
        // The sort is stable: of equal fits the one whose start looks more alike comes first.
        fits.sort_by(|a, b| b.score.total_cmp(&a.score));
        let refine_from = |start: &Isometry| self.refine_pose(&points, start);
        let best = distinct(fits, |fit| &fit.map_from_body, same_pose).into_iter().take(config.max_refined);
        let mut refined: Vec<PoseHypothesis> = best.map(|fit| refine_from(&fit.map_from_body)).collect();
        refined.extend(tracked.map(refine_from));
        refined.sort_by(|a, b| b.quality().total_cmp(&a.quality()));
        distinct(refined, |one| &one.map_from_base, same_pose)
    }

    /// Poses of the base from which a search of the whole map starts.
    fn start_poses(&self, descriptor: &KeyframeDescriptor, up_from_base: &Rotation) -> Vec<Isometry> {
        let config = &self.config;
        let index = self.index();
        let level = level_from_base(up_from_base);
        let keyframes = self.map.keyframes();
        let alike = index.descriptors.search(descriptor.views(), 0..keyframes.len());
        let recognised = alike
            .iter()
            .take_while(|one| one.alignment.distance <= config.max_descriptor_distance)
            .map(|one| {
                let (map_from_keyframe, _) = &keyframes[one.keyframe];
                let keyframe_level = level_from_base(&map_from_keyframe.rotation);
                map_from_keyframe
                    * first_from_second(&one.alignment, &keyframe_level, &level, VIEW_ORIGINS[one.view])
            });
        let mut starts = distinct(recognised, |pose| pose, &config.recognised_separation);
        starts.truncate(config.max_recognised_starts);
        let points: Vec<[f32; 3]> = descriptor.points().collect();
        starts.extend(index.matcher.search(&points, &level, config.max_matcher_starts));
        starts
    }

    /// Builds the data of a search of the whole map, if no search has done so. A call is needed only before a measurement of search times.
    pub fn prepare_search(&self) {
        self.index();
    }

    fn index(&self) -> &SearchIndex {
        self.index.get_or_init(|| self.build_index())
    }

    fn build_index(&self) -> SearchIndex {
        let mut descriptors = ScanContextIndex::default();
        for (_, descriptor) in self.map.keyframes() {
            descriptors.push(Arc::clone(&descriptor.views()[0]));
        }
        SearchIndex { descriptors, matcher: CorrelativeMatcher::new(self.config.matcher, &self.map) }
    }
}

/// The hypotheses whose poses differ from all previous ones, in their order. Quadratic.
fn distinct<T>(
    all: impl IntoIterator<Item = T>,
    pose: impl Fn(&T) -> &Isometry,
    tolerance: &HypothesisTolerance,
) -> Vec<T> {
    let mut chosen: Vec<T> = Vec::new();
    for one in all {
        if !chosen.iter().any(|other| tolerance.contains(pose(other), pose(&one))) {
            chosen.push(one);
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{at, room_keyframe, rooms, rooms_keyframes};

    fn localiser() -> GlobalLocaliser {
        GlobalLocaliser::new(Arc::new(LocalisationMap::new(rooms_keyframes())))
    }

    fn error_m(found: &PoseHypothesis, truth: &Isometry) -> f64 {
        (found.map_from_base.translation.vector - truth.translation.vector).norm()
    }

    #[test]
    fn a_scan_among_the_boxes_has_one_pose_and_one_in_a_room_has_two() {
        let localiser = localiser();
        let up = Rotation::identity();
        let (truth, scan) = room_keyframe(&rooms(), 37.2, 0.2, 0.4);
        let found = localiser.find_poses(&scan, &up, None);
        let RelocalisationResult::Unique(best) = localiser.classify(&found) else { panic!("{found:?}") };
        assert!(error_m(&best, &truth) < 0.05, "{best:?}");

        let (truth, scan) = room_keyframe(&rooms(), 5.0, 6.0, 0.4);
        let found = localiser.classify(&localiser.find_poses(&scan, &up, None));
        let RelocalisationResult::Ambiguous(several) = found else { panic!("{found:?}") };
        for alike in [truth, at(25.0, 6.0, 0.4)] {
            assert!(several.iter().any(|one| error_m(one, &alike) < 0.05), "{several:?}");
        }
    }

    #[test]
    fn a_given_pose_decides_between_rooms_that_are_alike() {
        let localiser = localiser();
        let (truth, scan) = room_keyframe(&rooms(), 25.0, 6.0, 0.4);
        let prior = PosePrior::Given(at(24.4, 6.5, 0.6));
        let found = localiser.find_poses_with_prior(&scan, &Rotation::identity(), &prior);
        let RelocalisationResult::Unique(best) = localiser.classify(&found) else { panic!("{found:?}") };
        assert!(error_m(&best, &truth) < 0.05, "{best:?}");
        let docks = PosePrior::AtDocks(vec![at(-5.0, 0.0, 0.0), at(24.4, 6.5, 0.6)]);
        let found = localiser.find_poses_with_prior(&scan, &Rotation::identity(), &docks);
        assert!(found.first().is_some_and(|best| error_m(best, &truth) < 0.05), "{found:?}");
        let none =
            localiser.find_poses_with_prior(&scan, &Rotation::identity(), &PosePrior::AtDocks(Vec::new()));
        assert_eq!(none, []);
    }

    #[test]
    fn a_tracked_pose_is_in_the_list_however_poorly_it_fits() {
        let localiser = localiser();
        let (_, scan) = room_keyframe(&rooms(), 37.2, 0.2, 0.4);
        let wrong = at(12.0, 0.0, 0.4);
        let found = localiser.find_poses_with_prior(&scan, &Rotation::identity(), &PosePrior::Tracked(wrong));
        // Alignment may move it along the corridor.
        assert!(found.iter().any(|one| error_m(one, &wrong) < 3.0), "{found:?}");
        assert!(found.windows(2).all(|pair| pair[0].quality() >= pair[1].quality()), "{found:?}");
    }
}
