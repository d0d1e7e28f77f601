//! Matching of finished maps: where one map lies in another (docs/maths/loops.md, section 8).
//!
//! The relative pose of the maps is unknown, except that both are upright. Every few metres, a keyframe of one map is searched by its appearance
//! among all keyframes of the other. Each pair that fits after registration gives one vote for the pose of the second map in the first. Each keyframe
//! votes for the pair where it fits best, because a place built alike fits nearly as well. Many votes from one room are no proof, so the supporters
//! must be farther apart than most rooms are long. In addition, no other pose may have more than half as many votes. Starting from the links of the
//! winner, the remaining keyframes are compared where the nearest link predicts them.

use crate::candidates::CandidateConfig;
use crate::keyframe_descriptor::{KeyframeDescriptor, VIEW_ORIGINS};
use crate::registration_floor::RegistrationFloor;
use crate::scan_context::{first_from_second, level_from_base};
use crate::scan_context_index::ScanContextIndex;
use crate::submap::{LazySubmap, SubmapCache, SubmapConfig};
use crate::uncertain_pose::{CHI_SQUARED_6_999, diagonal_covariance};
use crate::verification::{CandidateSource, Comparison, ComparisonResult, VerificationConfig, compare};
use crate::{PoseGraphEdge, UncertainPose};
use geometry::{Isometry, Matrix6, Rotation, Vector3, so3};
use points::Downsampler;
use std::collections::BTreeSet;
use std::sync::Arc;
use vocab::KeyframeId;

/// Parameters of [`MapMatcher`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapMatcherConfig {
    /// How submaps are made.
    pub submap: SubmapConfig,
    /// Submaps kept in memory, 4 to 15 MB each. Chosen: both of a query and its three candidates, twice.
    pub cached_submaps: usize,
    /// Standard deviation of the relative rotation of neighbouring keyframes in a finished map, radians. Its default is that of registrations.
    pub neighbour_rotation_std_rad: f64,
    /// Standard deviation of their relative translation, metres. Its default is that of registrations.
    pub neighbour_translation_std_m: f64,
    /// Distance along the walk between keyframes that are searched, metres. Chosen: two keyframes; nearer ones give the same vote.
    pub query_spacing_m: f64,
    /// Greatest number of candidates that are compared with a query. Chosen: of the first five by appearance one is right nearly always (docs/maths/loops.md, section 2);
    /// each costs a comparison.
    pub max_candidates: usize,
    /// Least distance between the candidates of a query, metres. Chosen: nearer ones are the same place.
    pub candidate_spacing_m: f64,
    /// Greatest distance of scan contexts of a candidate. Greater than for loops, because a candidate is also compared and has to win a vote. Chosen: maps of one site
    /// are made on other days.
    pub max_appearance_distance: f32,
    /// Two links agree if their translations differ by at most this, metres, ... Chosen: an error of a right link is some centimetres; the error of a wrong one that is
    /// near is larger.
    pub agreement_m: f64,
    /// ... plus this share of the distance between them, ... Chosen: 2 %, the deformation of a map over that distance.
    pub agreement_share: f64,
    /// ... and their rotations by at most this, radians. Chosen: 6 degrees; at the least extent of 12 m, wrong poses that are turned by more lie apart.
    pub agreement_rad: f64,
    /// Least number of links that agree. Chosen: as the links that have to contradict a graph ([`crate::LoopConsistencyConfig::min_contradicting_support`]).
    pub min_support: usize,
    /// Least extent of the agreeing keyframes in either map, metres: more than the length of most rooms. Chosen: links between two equal rooms agree within the room.
    pub min_extent_m: f64,
    /// In a small map, a walk needs only this share of the map's extent. Chosen: more than half, so that two equal halves of a map are not taken for each other.
    pub min_extent_share: f64,
    /// Greatest support of another pose, as a share of the winner's. Chosen: half; of a map that repeats, another pose has nearly as many.
    pub max_runner_up_share: f64,
    /// Keyframes of both maps at most this far apart horizontally see the same surroundings, metres. Its default is that of [`CandidateConfig`].
    pub max_offset_m: f64,
    /// The same vertically, metres; also of [`CandidateConfig`].
    pub max_height_m: f64,
    /// Standard deviation of a rotation predicted from the nearest link, radians. Chosen: the deformation of both maps between neighbouring links.
    pub predicted_rotation_std_rad: f64,
    /// Standard deviation of a translation predicted from the nearest link, metres, ... Chosen: as that of a coarse registration
    /// ([`VerificationConfig::coarse_translation_std_m`]).
    pub predicted_translation_std_m: f64,
    /// ... plus this share of the distance to that link. Chosen: as [`Self::agreement_share`].
    pub predicted_translation_std_share: f64,
    /// Greatest distance from a link for a prediction, metres. Beyond it, the prediction is as uncertain as the distance at which things
    /// repeat. Chosen: at 15 m the standard deviation is 0.4 m ([`crate::PoseCertaintyConfig`]).
    pub max_prediction_m: f64,
}

impl Default for MapMatcherConfig {
    fn default() -> Self {
        let candidates = CandidateConfig::default();
        Self {
            submap: SubmapConfig::default(),
            cached_submaps: 8,
            neighbour_rotation_std_rad: RegistrationFloor::default().rotation_std_rad,
            neighbour_translation_std_m: RegistrationFloor::default().translation_std_m,
            query_spacing_m: 2.0,
            max_candidates: 3,
            candidate_spacing_m: 5.0,
            max_appearance_distance: 0.75,
            agreement_m: 0.3,
            agreement_share: 0.02,
            agreement_rad: 0.1,
            min_support: 6,
            min_extent_m: 12.0,
            min_extent_share: 0.55,
            max_runner_up_share: 0.5,
            max_offset_m: candidates.max_offset_m,
            max_height_m: candidates.max_height_m,
            predicted_rotation_std_rad: 0.03,
            predicted_translation_std_m: 0.1,
            predicted_translation_std_share: 0.02,
            max_prediction_m: 15.0,
        }
    }
}

/// A finished map as keyframes are searched in it: 40 kB a keyframe.
#[derive(Clone, Debug)]
pub struct MapMatcher {
    config: MapMatcherConfig,
    index: ScanContextIndex,
    keyframes: Vec<MatcherKeyframe>,
    submaps: SubmapCache,
    downsampler: Downsampler,
}

#[derive(Clone, Debug)]
struct MatcherKeyframe {
    map_from_keyframe: Isometry,
    level_from_base: Rotation,
    descriptor: KeyframeDescriptor,
}

/// The relative pose of two maps.
#[derive(Clone, Debug, PartialEq)]
pub struct MapAlignment {
    /// Pose of the second map in the first.
    pub first_from_second: Isometry,
    /// Measured poses of keyframes of the second map (`to`) in keyframes of the first (`from`), numbered as in their own maps.
    pub links: Vec<PoseGraphEdge>,
    /// Number of keyframes that agree on it.
    pub support: usize,
    /// Number of keyframes that agree on the best other pose.
    pub runner_up_support: usize,
}

/// Why two maps cannot be aligned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlignmentError {
    /// Too few recognised keyframes agree with each other, or they are too close together. Their number.
    TooFew(usize),
    /// Two poses fit about equally well. The numbers of keyframes that agree on each.
    Ambiguous(usize, usize),
}

impl Default for MapMatcher {
    fn default() -> Self {
        Self::new(MapMatcherConfig::default())
    }
}

/// A candidate for a link between two maps.
#[derive(Clone, Copy, Debug)]
struct Link {
    from: usize,
    to: usize,
    result: ComparisonResult,
    first_from_second: Isometry,
}

impl MapMatcher {
    /// An empty map.
    pub fn new(config: MapMatcherConfig) -> Self {
        Self {
            config,
            index: ScanContextIndex::default(),
            keyframes: Vec::new(),
            submaps: SubmapCache::new(config.cached_submaps),
            downsampler: Downsampler::default(),
        }
    }

    /// Adds a keyframe with its cloud (keyframe's frame, metres), measured from `sensor` (keyframe's frame, metres). Keyframes are numbered
    /// from 0.
    pub fn push_cloud(&mut self, map_from_keyframe: &Isometry, xyz: &[[f32; 3]], sensor: [f32; 3]) {
        let descriptor =
            KeyframeDescriptor::new(xyz, &map_from_keyframe.rotation, sensor, &mut self.downsampler);
        self.push(map_from_keyframe, descriptor);
    }

    /// As [`Self::push_cloud`], with a descriptor computed before.
    pub fn push(&mut self, map_from_keyframe: &Isometry, descriptor: KeyframeDescriptor) {
        self.index.push(Arc::clone(&descriptor.views[0]));
        self.keyframes.push(MatcherKeyframe {
            map_from_keyframe: *map_from_keyframe,
            level_from_base: level_from_base(&map_from_keyframe.rotation),
            descriptor,
        });
    }

    /// Number of keyframes.
    pub fn len(&self) -> usize {
        self.keyframes.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.keyframes.is_empty()
    }

    /// Appends the keyframes of another map, numbered on from this one's. `poses` are the new poses of all keyframes in the map; keyframes
    /// beyond its end stay where they are.
    pub fn append(&mut self, other: Self, poses: &[Isometry]) {
        for keyframe in other.keyframes {
            self.index.push(Arc::clone(&keyframe.descriptor.views[0]));
            self.keyframes.push(keyframe);
        }
        for (keyframe, pose) in self.keyframes.iter_mut().zip(poses) {
            // The rotation is mostly about the vertical, so the levelled scan contexts stay valid.
            keyframe.level_from_base = level_from_base(&pose.rotation);
            keyframe.map_from_keyframe = *pose;
        }
        self.submaps = SubmapCache::new(self.config.cached_submaps);
    }

    /// Aligns `other` with this map. Costs some 15 ms a comparison: three for every two metres of `other`'s keyframes, and one more where the
    /// maps overlap.
    ///
    /// # Errors
    /// When the maps have too little in common, or fit in several ways.
    pub fn align(
        &mut self,
        other: &mut Self,
        verification: &VerificationConfig,
    ) -> Result<MapAlignment, AlignmentError> {
        self.align_over(other, verification, self.config.min_extent_m)
    }

    /// As [`Self::align`], for a walk that is known to be within this map. In a map smaller than most rooms, less of it has to be recognised.
    ///
    /// # Errors
    /// As for [`Self::align`].
    pub fn locate(
        &mut self,
        walk: &mut Self,
        verification: &VerificationConfig,
    ) -> Result<MapAlignment, AlignmentError> {
        let positions: Vec<Vector3> = (0..self.len()).map(|keyframe| self.position(keyframe)).collect();
        let min_extent_m = self.config.min_extent_m.min(self.config.min_extent_share * extent_m(&positions));
        self.align_over(walk, verification, min_extent_m)
    }

    fn align_over(
        &mut self,
        other: &mut Self,
        verification: &VerificationConfig,
        min_extent_m: f64,
    ) -> Result<MapAlignment, AlignmentError> {
        let mut links = Vec::new();
        for to in other.spaced_keyframes() {
            let mut best: Option<Link> = None;
            for (from, guess) in self.candidates(&other.keyframes[to]) {
                let link = self.find_link(other, (from, to), (guess, None), verification);
                // Of equal scores, the one that looks more alike comes first.
                best = match (best, link) {
                    (Some(best), Some(link)) if link.score() > best.score() => Some(link),
                    (best, link) => best.or(link),
                };
            }
            links.extend(best);
        }
        let (winner, support, runner_up_support) = vote(&links, self, other, min_extent_m)?;
        let links = self.extend_links(other, winner, verification);
        let links = links.iter().map(Link::edge).collect();
        Ok(MapAlignment { first_from_second: winner.first_from_second, links, support, runner_up_support })
    }

    /// Keyframes at the query spacing.
    fn spaced_keyframes(&self) -> Vec<usize> {
        let mut chosen: Vec<usize> = Vec::new();
        for index in 0..self.len() {
            let is_far = |last: &usize| {
                (self.position(*last) - self.position(index)).norm() >= self.config.query_spacing_m
            };
            if chosen.last().is_none_or(is_far) {
                chosen.push(index);
            }
        }
        chosen
    }

    fn position(&self, keyframe: usize) -> Vector3 {
        self.keyframes[keyframe].map_from_keyframe.translation.vector
    }

    /// Keyframes that look like a keyframe of another map, with a guess of its pose in them.
    fn candidates(&self, query: &MatcherKeyframe) -> Vec<(usize, Isometry)> {
        let config = &self.config;
        let mut chosen: Vec<(usize, Isometry)> = Vec::new();
        for found in self.index.search(&query.descriptor.views, 0..self.len()) {
            if chosen.len() == config.max_candidates
                || found.alignment.distance > config.max_appearance_distance
            {
                break;
            }
            let (keyframe, origin) = (found.keyframe, VIEW_ORIGINS[found.view]);
            let is_elsewhere = |(other, _): &(usize, Isometry)| {
                (self.position(*other) - self.position(keyframe)).norm() > config.candidate_spacing_m
            };
            if chosen.iter().all(is_elsewhere) {
                let level = &self.keyframes[keyframe].level_from_base;
                let guess = first_from_second(&found.alignment, level, &query.level_from_base, origin);
                chosen.push((keyframe, guess));
            }
        }
        chosen
    }

    /// Compares a keyframe of this map with one of another. `None` if they do not fit.
    fn find_link(
        &mut self,
        other: &mut Self,
        (from, to): (usize, usize),
        (guess, expected): (Isometry, Option<UncertainPose>),
        verification: &VerificationConfig,
    ) -> Option<Link> {
        let (older, newer) = (self.submap(from), other.submap(to));
        let (source, guesses) = (CandidateSource::Geometry, vec![guess]);
        let result =
            compare(&Comparison { source, guesses, expected, tilt: None, older, newer }, verification);
        let measured = UncertainPose::from_information(result.pose, &result.information);
        let contradicts = |expected: UncertainPose| {
            expected.mahalanobis_squared(&measured).is_none_or(|squared| squared > CHI_SQUARED_6_999)
        };
        if result.rejection.is_some() || expected.is_some_and(contradicts) {
            return None;
        }
        let first_from_second = self.keyframes[from].map_from_keyframe
            * result.pose
            * other.keyframes[to].map_from_keyframe.inverse();
        Some(Link { from, to, result, first_from_second })
    }

    /// Submap of a keyframe and those around it.
    fn submap(&mut self, own: usize) -> Arc<LazySubmap> {
        let (keyframes, config) = (&self.keyframes, &self.config);
        self.submaps.get(own, || {
            let neighbour =
                diagonal_covariance(config.neighbour_rotation_std_rad, config.neighbour_translation_std_m);
            let own_from_map = keyframes[own].map_from_keyframe.inverse();
            let mut near: Vec<(f64, usize, UncertainPose)> = keyframes
                .iter()
                .enumerate()
                .map(|(index, keyframe)| {
                    let covariance = if index == own { Matrix6::zeros() } else { neighbour };
                    let pose = own_from_map * keyframe.map_from_keyframe;
                    (pose.translation.vector.norm(), index, UncertainPose { pose, covariance })
                })
                .filter(|(distance_m, _, relative)| {
                    *distance_m <= config.submap.radius_m
                        && relative.pose.translation.vector.z.abs() <= config.submap.max_height_m
                })
                .collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            near.truncate(config.submap.max_keyframes);
            near.sort_by_key(|(_, index, _)| *index);
            let position = near.iter().position(|(_, index, _)| *index == own).unwrap_or_default();
            let members = near
                .into_iter()
                .map(|(_, index, relative)| (relative, Arc::clone(&keyframes[index].descriptor.cloud)));
            LazySubmap::new(members.collect(), position)
        })
    }

    /// Extends the winner to all keyframes that overlap, nearest first, so that deformations of either map are followed.
    fn extend_links(
        &mut self,
        other: &mut Self,
        winner: Link,
        verification: &VerificationConfig,
    ) -> Vec<Link> {
        let config = self.config;
        let mut links = vec![winner];
        let mut waiting: BTreeSet<usize> = other.spaced_keyframes().into_iter().collect();
        waiting.remove(&winner.to);
        while let Some((distance_m, to, link)) = nearest_link(other, &waiting, &links) {
            if distance_m > config.max_prediction_m {
                break;
            }
            waiting.remove(&to);
            let first_from_base = link.first_from_second * other.keyframes[to].map_from_keyframe;
            let Some(from) = self.nearest_keyframe(&first_from_base) else { continue };
            let guess = self.keyframes[from].map_from_keyframe.inverse() * first_from_base;
            let translation_std_m =
                config.predicted_translation_std_m + config.predicted_translation_std_share * distance_m;
            let covariance = diagonal_covariance(config.predicted_rotation_std_rad, translation_std_m);
            let expected = UncertainPose { pose: guess, covariance };
            links.extend(self.find_link(other, (from, to), (guess, Some(expected)), verification));
        }
        links.sort_by_key(|link| (link.to, link.from));
        links
    }

    /// The keyframe nearest to a pose, if it sees the same surroundings.
    fn nearest_keyframe(&self, map_from_base: &Isometry) -> Option<usize> {
        let position = map_from_base.translation.vector;
        let offsets = self.keyframes.iter().map(|k| k.map_from_keyframe.translation.vector - position);
        let near = offsets
            .enumerate()
            .filter(|(_, offset)| {
                offset.xy().norm() <= self.config.max_offset_m && offset.z.abs() <= self.config.max_height_m
            })
            .min_by(|a, b| a.1.norm().total_cmp(&b.1.norm()).then(a.0.cmp(&b.0)));
        near.map(|(index, _)| index)
    }
}

impl Link {
    fn edge(&self) -> PoseGraphEdge {
        let id = |index: usize| KeyframeId(u32::try_from(index).unwrap_or(u32::MAX));
        let ComparisonResult { pose, information, .. } = self.result;
        PoseGraphEdge { from: id(self.from), to: id(self.to), from_from_to: pose, information }
    }

    fn score(&self) -> f64 {
        self.result.evidence.score
    }

    /// Whether this link puts another link's keyframe where that one does (equation 11).
    fn agrees(&self, with: &Self, second: &MapMatcher, config: &MapMatcherConfig) -> bool {
        let distance_m = (second.position(self.to) - second.position(with.to)).norm();
        let second_from_keyframe = second.keyframes[with.to].map_from_keyframe;
        let error = (self.first_from_second * second_from_keyframe).inverse()
            * (with.first_from_second * second_from_keyframe);
        error.translation.vector.norm() <= config.agreement_m + config.agreement_share * distance_m
            && so3::log(&error.rotation).norm() <= config.agreement_rad
    }
}

/// The link that most others agree with, their number, and the number that agree on the best of the rest. The agreeing keyframes must extend
/// over `min_extent_m` in both maps. Quadratic in the links.
fn vote(
    links: &[Link],
    first: &MapMatcher,
    second: &MapMatcher,
    min_extent_m: f64,
) -> Result<(Link, usize, usize), AlignmentError> {
    let config = &first.config;
    let supporters = |link: &Link, among: &[Link]| -> Vec<Link> {
        among.iter().filter(|with| link.agrees(with, second, config)).copied().collect()
    };
    let best = |among: &[Link]| {
        let counted = among.iter().map(|link| (supporters(link, among).len(), *link));
        // Of equal counts, the first one.
        counted.fold(None, |best: Option<(usize, Link)>, next| match best {
            Some(best) if best.0 >= next.0 => Some(best),
            _ => Some(next),
        })
    };
    let Some((count, winner)) = best(links) else { return Err(AlignmentError::TooFew(0)) };
    let supported = supporters(&winner, links);
    let others: Vec<Link> =
        links.iter().filter(|link| !winner.agrees(link, second, config)).copied().collect();
    let runner_up = best(&others).map_or(0, |(count, _)| count);
    let extent = |position: fn(&Link, &MapMatcher) -> Vector3, map: &MapMatcher| {
        let positions: Vec<Vector3> = supported.iter().map(|link| position(link, map)).collect();
        extent_m(&positions)
    };
    let is_wide = extent(|link, map| map.position(link.from), first) >= min_extent_m
        && extent(|link, map| map.position(link.to), second) >= min_extent_m;
    if count < config.min_support || !is_wide {
        return Err(AlignmentError::TooFew(count));
    }
    if runner_up as f64 > config.max_runner_up_share * count as f64 {
        return Err(AlignmentError::Ambiguous(count, runner_up));
    }
    Ok((winner, count, runner_up))
}

/// Distance between the two points that are farthest apart, metres. Quadratic.
fn extent_m(points: &[Vector3]) -> f64 {
    points.iter().flat_map(|a| points.iter().map(move |b| (a - b).norm())).fold(0.0, f64::max)
}

/// Of the waiting keyframes the one nearest to a link: its distance, its number, and that link. Linear in both.
fn nearest_link(other: &MapMatcher, waiting: &BTreeSet<usize>, links: &[Link]) -> Option<(f64, usize, Link)> {
    let pairs = waiting.iter().flat_map(|&to| {
        links.iter().map(move |link| ((other.position(to) - other.position(link.to)).norm(), to, link))
    });
    pairs.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(distance_m, to, link)| (distance_m, to, *link))
}

#[cfg(test)]
#[path = "map_matcher_tests.rs"]
mod tests;
