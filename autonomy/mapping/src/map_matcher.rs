//! Finished maps: where what one of them holds lies in another.
//!
//! Nothing is known beforehand of how two maps lie to each other, but that both stand upright. Every few metres a keyframe of one
//! is looked up by its looks among all of the other's; what fits when compared says, each by itself, where one map is in the
//! other. They vote, each keyframe for the place where it fits best, because a place built alike fits nearly as well. Looking alike, be it
//! a hundred times in one room, proves nothing, so that supporters must come from farther apart than most rooms are long, and no other
//! way may have half as many. From the winner on, the rest is compared where it is then expected.
//! `docs/maths/loops.md` has the numbers.

use crate::keyframe_descriptor::{KeyframeDescriptor, VIEW_ORIGINS};
use crate::scan_context::{first_from_second, level_from_base};
use crate::scan_context_index::ScanContextIndex;
use crate::submap::{LazySubmap, SubmapCache};
use crate::verify::{CandidateSource, Comparison, ComparisonResult, VerificationConfig, compare};
use crate::{Edge, UncertainPose};
use geometry::{Isometry, Matrix6, Rotation, Vector3, Vector6, so3};
use points::Downsampler;
use std::collections::BTreeSet;
use std::sync::Arc;
use vocab::KeyframeId;

/// A submap takes in the keyframes so near, metres, so many at most.
const SUBMAP_REACH: f64 = 8.0;
const SUBMAP_LEVEL: f64 = 1.5;
const SUBMAP_MEMBERS: usize = 17;
const SUBMAPS_HELD: usize = 8;
/// How far neighbours in a finished map are off each other: rotation (rad), translation (m).
const SETTLED: (f64, f64) = (5e-4, 0.005);
/// Keyframes are looked up so far apart along the walk, metres.
const SPACING: f64 = 2.0;
/// Places looked at for each, so far apart at least, metres, and the greatest distance of descriptors: generous, since what
/// looks alike is compared and has to win a vote.
const LOOKED_AT: usize = 3;
const PLACES_APART: f64 = 5.0;
const RESEMBLANCE: f32 = 0.75;
/// Two links agree if they say the same within this: metres, metres for each metre between them, and radians.
const AGREE: (f64, f64, f64) = (0.3, 0.02, 0.1);
/// Votes that must agree, and how far apart the farthest of them are in either map, metres: more than most rooms.
const SUPPORT: usize = 6;
const SPREAD: f64 = 12.0;
/// The same of a walk in a small map, as a share of the map's extent.
const SMALL: f64 = 0.55;
/// Another place may have this share of the supporters at most.
const RIVAL: f64 = 0.5;
/// Keyframes of both maps this near overlook the same, metres, and the same vertically.
const NEAR: f64 = 2.5;
const LEVEL: f64 = 1.0;
/// What is expected from the nearest link: radians and metres, and metres for each metre from there.
const EXPECTED: (f64, f64, f64) = (0.03, 0.1, 0.02);
/// Nothing is expected farther from a link than this, metres: by then it is as vague as things repeat.
const FROM_A_LINK: f64 = 15.0;
/// 99.9 % of the squared Mahalanobis distances of six normal errors lie below.
const CHI_SQUARED_6: f64 = 22.46;

/// A finished map as places are looked up in it: 45 kB a keyframe.
#[derive(Clone, Debug)]
pub struct MapMatcher {
    places: ScanContextIndex,
    keyframes: Vec<Charted>,
    submaps: SubmapCache,
    downsampler: Downsampler,
}

#[derive(Clone, Debug)]
struct Charted {
    map_from_keyframe: Isometry,
    level: Rotation,
    place: KeyframeDescriptor,
}

/// How two maps lie to each other.
#[derive(Clone, Debug, PartialEq)]
pub struct MapAlignment {
    /// Where the second one is in the first.
    pub first_from_second: Isometry,
    /// Measured poses of keyframes of the second (`to`) in keyframes of the first (`from`), numbered as in their own maps.
    pub links: Vec<Edge>,
    /// Places recognised that agree on it.
    pub support: usize,
    /// Places that agree on the best other way.
    pub rival: usize,
}

/// Why it cannot be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlignmentError {
    /// Too few places were recognised that agree with each other, or all in one spot; this many.
    TooFew(usize),
    /// Two ways fit about as well, with so many places each.
    Ambiguous(usize, usize),
}

impl Default for MapMatcher {
    fn default() -> Self {
        Self {
            places: ScanContextIndex::default(),
            keyframes: Vec::new(),
            submaps: SubmapCache::new(SUBMAPS_HELD),
            downsampler: Downsampler::default(),
        }
    }
}

/// A link between two maps under consideration.
#[derive(Clone, Copy, Debug)]
struct Link {
    from: usize,
    to: usize,
    compared: ComparisonResult,
    first_from_second: Isometry,
}

impl MapMatcher {
    /// Adds a keyframe with its cloud (keyframe's frame, metres), seen from `sensor` (keyframe's frame). Keyframes are numbered from 0.
    pub fn push(&mut self, map_from_keyframe: &Isometry, xyz: &[[f32; 3]], sensor: [f32; 3]) {
        let place = KeyframeDescriptor::new(xyz, &map_from_keyframe.rotation, sensor, &mut self.downsampler);
        self.push_place(map_from_keyframe, place);
    }

    /// As [`Self::push`], of a place that was made before.
    pub fn push_place(&mut self, map_from_keyframe: &Isometry, place: KeyframeDescriptor) {
        let level = level_from_base(&map_from_keyframe.rotation);
        self.places.push(Arc::clone(&place.views[0]));
        self.keyframes.push(Charted { map_from_keyframe: *map_from_keyframe, level, place });
    }

    /// Number of keyframes.
    pub fn len(&self) -> usize {
        self.keyframes.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.keyframes.is_empty()
    }

    /// Takes in the keyframes of another map, numbered on from this one's. `poses`: where all of them are in the map now; those
    /// missing stay.
    pub fn append(&mut self, other: Self, poses: &[Isometry]) {
        for keyframe in other.keyframes {
            self.places.push(Arc::clone(&keyframe.place.views[0]));
            self.keyframes.push(keyframe);
        }
        for (keyframe, pose) in self.keyframes.iter_mut().zip(poses) {
            // Turned about the upright axis mostly: the levelled views stay true.
            keyframe.level = level_from_base(&pose.rotation);
            keyframe.map_from_keyframe = *pose;
        }
        self.submaps = SubmapCache::new(SUBMAPS_HELD);
    }

    /// Finds where `other` lies in this map. Costs some 15 ms for each place looked at: three for every two metres of `other`'s
    /// keyframes, and one more where both maps overlap.
    ///
    /// # Errors
    /// When the maps have too little in common, or it fits in several ways.
    pub fn join(
        &mut self,
        other: &mut Self,
        gates: &VerificationConfig,
    ) -> Result<MapAlignment, AlignmentError> {
        self.join_over(other, gates, SPREAD)
    }

    /// As [`Self::join`], of a walk that is known to have been made where this map is of: in a map smaller than most rooms are long,
    /// less has to be recognised.
    ///
    /// # Errors
    /// As for [`Self::join`].
    pub fn find(
        &mut self,
        walk: &mut Self,
        gates: &VerificationConfig,
    ) -> Result<MapAlignment, AlignmentError> {
        let places: Vec<Vector3> = (0..self.len()).map(|keyframe| self.place(keyframe)).collect();
        self.join_over(walk, gates, SPREAD.min(SMALL * extent(&places)))
    }

    fn join_over(
        &mut self,
        other: &mut Self,
        gates: &VerificationConfig,
        apart: f64,
    ) -> Result<MapAlignment, AlignmentError> {
        let mut found = Vec::new();
        for to in other.spaced() {
            let mut best: Option<Link> = None;
            for (from, guess) in self.alike(&other.keyframes[to]) {
                let link = self.link(other, (from, to), (guess, None), gates);
                // Of equals the one that looks more alike.
                best = match (best, link) {
                    (Some(best), Some(link)) if link.score() > best.score() => Some(link),
                    (best, link) => best.or(link),
                };
            }
            found.extend(best);
        }
        let (winner, support, rival) = vote(&found, self, other, apart)?;
        let links = self.spread_out(other, winner, gates);
        let links = links.iter().map(Link::edge).collect();
        Ok(MapAlignment { first_from_second: winner.first_from_second, links, support, rival })
    }

    /// Every few metres of the walk one keyframe.
    fn spaced(&self) -> Vec<usize> {
        let mut chosen: Vec<usize> = Vec::new();
        for index in 0..self.len() {
            let far = |last: &usize| (self.place(*last) - self.place(index)).norm() >= SPACING;
            if chosen.last().is_none_or(far) {
                chosen.push(index);
            }
        }
        chosen
    }

    fn place(&self, keyframe: usize) -> Vector3 {
        self.keyframes[keyframe].map_from_keyframe.translation.vector
    }

    /// Keyframes that look like one of another map, with a guess of its pose in them.
    fn alike(&self, query: &Charted) -> Vec<(usize, Isometry)> {
        let mut chosen: Vec<(usize, Isometry)> = Vec::new();
        for resemblance in self.places.search(&query.place.views, 0..self.len()) {
            if chosen.len() == LOOKED_AT || resemblance.alignment.distance > RESEMBLANCE {
                break;
            }
            let (place, origin) = (resemblance.place, VIEW_ORIGINS[resemblance.view]);
            let fresh = |(other, _): &(usize, Isometry)| {
                (self.place(*other) - self.place(place)).norm() > PLACES_APART
            };
            if chosen.iter().all(fresh) {
                let level = &self.keyframes[place].level;
                chosen.push((place, first_from_second(&resemblance.alignment, level, &query.level, origin)));
            }
        }
        chosen
    }

    /// Compares a keyframe of this map with one of another; none if they do not fit.
    fn link(
        &mut self,
        other: &mut Self,
        (from, to): (usize, usize),
        (guess, expected): (Isometry, Option<UncertainPose>),
        gates: &VerificationConfig,
    ) -> Option<Link> {
        let (older, newer) = (self.submap(from), other.submap(to));
        let (source, guesses) = (CandidateSource::Geometry, vec![guess]);
        let compared = compare(&Comparison { source, guesses, expected, older, newer }, gates);
        let measured = UncertainPose::from_information(compared.pose, &compared.information);
        let surprising = |expected: UncertainPose| {
            expected.distance_squared(&measured).is_none_or(|squared| squared > CHI_SQUARED_6)
        };
        if compared.rejection.is_some() || expected.is_some_and(surprising) {
            return None;
        }
        let first_from_second = self.keyframes[from].map_from_keyframe
            * compared.pose
            * other.keyframes[to].map_from_keyframe.inverse();
        Some(Link { from, to, compared, first_from_second })
    }

    /// A keyframe with those about it.
    fn submap(&mut self, own: usize) -> Arc<LazySubmap> {
        let keyframes = &self.keyframes;
        self.submaps.get(own, || {
            let (turn, place) = (SETTLED.0 * SETTLED.0, SETTLED.1 * SETTLED.1);
            let settled = Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, place, place, place));
            let own_from_map = keyframes[own].map_from_keyframe.inverse();
            let mut near: Vec<(f64, usize, UncertainPose)> = keyframes
                .iter()
                .enumerate()
                .map(|(index, keyframe)| {
                    let covariance = if index == own { Matrix6::zeros() } else { settled };
                    let pose = own_from_map * keyframe.map_from_keyframe;
                    (pose.translation.vector.norm(), index, UncertainPose { pose, covariance })
                })
                .filter(|(apart, _, way)| {
                    *apart <= SUBMAP_REACH && way.pose.translation.vector.z.abs() <= SUBMAP_LEVEL
                })
                .collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            near.truncate(SUBMAP_MEMBERS);
            near.sort_by_key(|(_, index, _)| *index);
            let place = near.iter().position(|(_, index, _)| *index == own).unwrap_or_default();
            let members =
                near.into_iter().map(|(_, index, way)| (way, Arc::clone(&keyframes[index].place.cloud)));
            LazySubmap::new(members.collect(), place)
        })
    }

    /// From the winner to all that overlaps, nearest first, so that a bend of either map is followed.
    fn spread_out(&mut self, other: &mut Self, winner: Link, gates: &VerificationConfig) -> Vec<Link> {
        let mut grown = vec![winner];
        let mut waiting: BTreeSet<usize> = other.spaced().into_iter().collect();
        waiting.remove(&winner.to);
        while let Some((apart, to, by)) = nearest(other, &waiting, &grown) {
            if apart > FROM_A_LINK {
                break;
            }
            waiting.remove(&to);
            let first_from_base = by.first_from_second * other.keyframes[to].map_from_keyframe;
            let Some(from) = self.nearest_to(&first_from_base) else { continue };
            let guess = self.keyframes[from].map_from_keyframe.inverse() * first_from_base;
            let (turn, place) = (EXPECTED.0, EXPECTED.1 + EXPECTED.2 * apart);
            let (turn, place) = (turn * turn, place * place);
            let covariance = Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, place, place, place));
            let expected = UncertainPose { pose: guess, covariance };
            grown.extend(self.link(other, (from, to), (guess, Some(expected)), gates));
        }
        grown.sort_by_key(|link| (link.to, link.from));
        grown
    }

    /// The keyframe nearest to a place, if it overlooks it.
    fn nearest_to(&self, map_from_base: &Isometry) -> Option<usize> {
        let place = map_from_base.translation.vector;
        let offsets = self.keyframes.iter().map(|k| k.map_from_keyframe.translation.vector - place);
        let near = offsets
            .enumerate()
            .filter(|(_, offset)| offset.xy().norm() <= NEAR && offset.z.abs() <= LEVEL)
            .min_by(|a, b| a.1.norm().total_cmp(&b.1.norm()).then(a.0.cmp(&b.0)));
        near.map(|(index, _)| index)
    }
}

impl Link {
    fn edge(&self) -> Edge {
        let id = |index: usize| KeyframeId(u32::try_from(index).unwrap_or(u32::MAX));
        let ComparisonResult { pose, information, .. } = self.compared;
        Edge { from: id(self.from), to: id(self.to), from_from_to: pose, information }
    }

    fn score(&self) -> f64 {
        self.compared.evidence.score
    }

    /// Whether this link says the same of another link's keyframes as that one does.
    fn agrees(&self, with: &Self, other: &MapMatcher) -> bool {
        let apart = (other.place(self.to) - other.place(with.to)).norm();
        let there = other.keyframes[with.to].map_from_keyframe;
        let off = (self.first_from_second * there).inverse() * (with.first_from_second * there);
        off.translation.vector.norm() <= AGREE.0 + AGREE.1 * apart
            && so3::log(&off.rotation).norm() <= AGREE.2
    }
}

/// The link on which most others agree, how many those are, and how many agree on the best of the rest; some of them must be so
/// far apart. Quadratic in the links.
fn vote(
    links: &[Link],
    first: &MapMatcher,
    second: &MapMatcher,
    apart: f64,
) -> Result<(Link, usize, usize), AlignmentError> {
    let supporters = |link: &Link, among: &[Link]| -> Vec<Link> {
        among.iter().filter(|with| link.agrees(with, second)).copied().collect()
    };
    let best = |among: &[Link]| {
        let counted = among.iter().map(|link| (supporters(link, among).len(), *link));
        // Of equals the first.
        counted.fold(None, |best: Option<(usize, Link)>, next| match best {
            Some(best) if best.0 >= next.0 => Some(best),
            _ => Some(next),
        })
    };
    let Some((count, winner)) = best(links) else { return Err(AlignmentError::TooFew(0)) };
    let supported = supporters(&winner, links);
    let others: Vec<Link> = links.iter().filter(|link| !winner.agrees(link, second)).copied().collect();
    let rival = best(&others).map_or(0, |(count, _)| count);
    let spread = |place: fn(&Link, &MapMatcher) -> Vector3, chart: &MapMatcher| {
        let places: Vec<Vector3> = supported.iter().map(|link| place(link, chart)).collect();
        extent(&places)
    };
    let far = spread(|link, chart| chart.place(link.from), first) >= apart
        && spread(|link, chart| chart.place(link.to), second) >= apart;
    if count < SUPPORT || !far {
        return Err(AlignmentError::TooFew(count));
    }
    if rival as f64 > RIVAL * count as f64 {
        return Err(AlignmentError::Ambiguous(count, rival));
    }
    Ok((winner, count, rival))
}

/// How far the farthest two are apart. Quadratic.
fn extent(places: &[Vector3]) -> f64 {
    places.iter().flat_map(|a| places.iter().map(move |b| (a - b).norm())).fold(0.0, f64::max)
}

/// Of the keyframes that wait the one nearest to a link, how far it is, and that link. Linear in both.
fn nearest(other: &MapMatcher, waiting: &BTreeSet<usize>, links: &[Link]) -> Option<(f64, usize, Link)> {
    let pairs = waiting.iter().flat_map(|&to| {
        links.iter().map(move |link| ((other.place(to) - other.place(link.to)).norm(), to, link))
    });
    pairs.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(apart, to, link)| (apart, to, *link))
}

#[cfg(test)]
#[path = "map_matcher_tests.rs"]
mod tests;
