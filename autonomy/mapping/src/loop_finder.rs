//! Finding loops: from a new keyframe to pairs worth verifying, and from verified pairs to edges of the graph.
//!
//! The owner calls [`LoopFinder::add_keyframe`] for every keyframe, runs [`crate::verify()`] on each task that comes back
//! (anywhere, in any order), and hands the results to [`LoopFinder::judge`] in an order of its choosing: the same calls give
//! the same bits. A robot that also walks over known ground calls [`LoopFinder::arrive`] instead, see [`crate::Novelty`].

use crate::candidates::{self, Candidate, CandidateConfig};
use crate::consistency::{ConsistencyConfig, Decision, LoopConsistencyCheck, Verdict};
use crate::keyframe_descriptor::{ASIDE, KeyframeDescriptor, VIEW_ORIGINS};
use crate::quality::Coverage;
use crate::recent_scans::RecentScans;
use crate::revisits::Revisits;
use crate::scan_context::{ScanContext, level_from_base};
use crate::scan_context_index::ScanContextIndex;
use crate::submap::{KeyframeCloud, LazySubmap, SubmapCache};
use crate::verify::{CandidateSource, Comparison, VerificationConfig, VerificationTask, VerifiedPair};
use crate::{Edge, UncertainPose, dynamic_points};
use geometry::{Isometry, Rotation};
use points::Downsampler;
use std::sync::Arc;
use vocab::KeyframeId;

/// A submap takes in what was walked this far before and after its keyframe, metres, and so many keyframes at most.
const SUBMAP_WALK: f64 = 8.0;
const SUBMAP_MEMBERS: usize = 17;
/// Where the walk alone gives fewer, those nearest over loops are taken in too, if they are known this well, metres.
const SUBMAP_LEAST: usize = 9;
const SUBMAP_DEVIATION: f64 = 0.1;
/// Submaps held ready: 4 to 15 MB each.
const SUBMAPS_HELD: usize = 4;

/// Settings of a [`LoopFinder`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoopConfig {
    /// Who is compared.
    pub candidates: CandidateConfig,
    /// What a comparison must pass.
    pub gates: VerificationConfig,
    /// When its result is believed.
    pub trust: ConsistencyConfig,
}

/// A keyframe as the loop finder takes it.
#[derive(Clone, Copy, Debug)]
pub struct NewKeyframe<'a> {
    /// How the odometry came here from the last keyframe; `None` for the first.
    pub edge: Option<&'a Edge>,
    /// Attitude of the base in any frame whose z axis points up.
    pub rotation: Rotation,
    /// Its motion-corrected cloud, base frame, metres.
    pub xyz: &'a [[f32; 3]],
    /// Where the LiDAR is, base frame, metres.
    pub sensor: [f32; 3],
}

/// A keyframe of a finished map.
#[derive(Clone, Debug)]
pub struct MapKeyframe {
    /// Where it is.
    pub map_from_keyframe: Isometry,
    /// What it saw.
    pub place: KeyframeDescriptor,
}

/// Place recognition and loop closure of one session. Holds about 34 kB a keyframe (cloud 18, image 11.5, descriptor 3.3,
/// edges 1.5) and four submaps.
#[derive(Clone, Debug)]
pub struct LoopFinder {
    pub(crate) config: LoopConfig,
    pub(crate) consistency: LoopConsistencyCheck,
    places: ScanContextIndex,
    pub(crate) clouds: Vec<Arc<KeyframeCloud>>,
    pub(crate) levels: Vec<Rotation>,
    submaps: SubmapCache,
    pub(crate) downsampler: Downsampler,
    /// Keyframe of the last loop that was accepted by geometry.
    last_closed: Option<usize>,
    pub(crate) trail: RecentScans,
    pub(crate) visits: Revisits,
    pub(crate) coverage: Coverage,
}

impl LoopFinder {
    /// Of a session that begins.
    pub fn new(config: LoopConfig) -> Self {
        Self {
            config,
            consistency: LoopConsistencyCheck::new(config.trust),
            places: ScanContextIndex::default(),
            clouds: Vec::new(),
            levels: Vec::new(),
            submaps: SubmapCache::new(SUBMAPS_HELD),
            downsampler: Downsampler::default(),
            last_closed: None,
            trail: RecentScans::default(),
            visits: Revisits::default(),
            coverage: Coverage::default(),
        }
    }

    /// Of a session that goes on from a finished map with these keyframes, that the robot has to find itself in first: what it walks
    /// until [`Self::place`] adds nothing. Linear in keyframes and edges, but for a search of the edges for each keyframe.
    pub fn resume(config: LoopConfig, map: &[MapKeyframe], edges: &[Edge], loops: &[Edge]) -> Self {
        let mut finder = Self::new(config);
        let poses: Vec<Isometry> = map.iter().map(|old| old.map_from_keyframe).collect();
        finder.consistency = LoopConsistencyCheck::resume(config.trust, &poses, edges, loops);
        // All of it is no recent travel.
        finder.consistency.walk(2.0 * config.candidates.walked);
        for MapKeyframe { map_from_keyframe, place } in map {
            finder.clouds.push(Arc::clone(&place.cloud));
            finder.levels.push(level_from_base(&map_from_keyframe.rotation));
            finder.places.push(Arc::clone(&place.views[0]));
        }
        finder
    }

    /// The settings.
    pub fn config(&self) -> &LoopConfig {
        &self.config
    }

    /// Adds a keyframe; returns the pairs to verify, at most `2 * most` of the policy. Keyframes are numbered from 0 in the
    /// order of these calls, as a session does.
    pub fn add_keyframe(&mut self, new: &NewKeyframe) -> Vec<VerificationTask> {
        let step = new.edge.map(|edge| UncertainPose::from_information(edge.from_from_to, &edge.information));
        if let Some(edge) = new.edge {
            self.consistency.add_keyframe(edge);
        }
        let cloud = Arc::new(KeyframeCloud::new(new.xyz, new.sensor, &mut self.downsampler));
        let waypoint = self.trail.push(step.unwrap_or_else(UncertainPose::identity), Arc::clone(&cloud));
        self.insert_keyframe(waypoint, cloud, &new.rotation, new.xyz)
    }

    /// Makes the newest waypoint, that the consistency knows as a keyframe already, one.
    pub(crate) fn insert_keyframe(
        &mut self,
        waypoint: u64,
        cloud: Arc<KeyframeCloud>,
        rotation: &Rotation,
        xyz: &[[f32; 3]],
    ) -> Vec<VerificationTask> {
        let newest = self.clouds.len();
        let level = level_from_base(rotation);
        self.visits.begin_at(keyframe(newest), waypoint);
        self.clouds.push(cloud);
        self.levels.push(level);
        self.places.push(Arc::new(ScanContext::new(xyz, &level, [0.0; 2])));
        let candidates = self.candidates(newest, xyz);
        if candidates.is_empty() {
            return Vec::new();
        }
        let newer = Arc::new(self.walked_submap());
        let tasks = candidates.into_iter().map(|candidate| VerificationTask {
            from: keyframe(candidate.keyframe),
            to: keyframe(newest),
            comparison: Comparison {
                source: candidate.source,
                guesses: vec![candidate.guess],
                expected: Some(candidate.expected),
                older: self.submap(candidate.keyframe),
                newer: Arc::clone(&newer),
            },
        });
        tasks.collect()
    }

    /// Decides about a verified pair, and about others that it makes believable. Accepted edges belong into the graph.
    pub fn evaluate(&mut self, verified: &VerifiedPair) -> Vec<Decision> {
        let decisions = self.consistency.evaluate(verified);
        for decision in &decisions {
            if decision.verdict == Verdict::Accepted {
                let closed = decision.edge.to.0 as usize;
                self.last_closed = self.last_closed.max(Some(closed));
            }
        }
        decisions
    }

    /// A task for a pair that a person points at, with a guess of the newer one's pose in the older one; `None` if there are
    /// no such keyframes.
    pub fn propose(&mut self, from: KeyframeId, to: KeyframeId, guess: Isometry) -> Option<VerificationTask> {
        let (older, newer) = (from.0 as usize, to.0 as usize);
        if older.max(newer) >= self.clouds.len() {
            return None;
        }
        let expected = self.consistency.reach(from).get(newer).copied().flatten();
        let (older, newer) = (self.submap(older), self.submap(newer));
        let comparison =
            Comparison { source: CandidateSource::Person, guesses: vec![guess], expected, older, newer };
        Some(VerificationTask { from, to, comparison })
    }

    /// Takes an edge on a person's word, without judging it. Says whether there are such keyframes.
    pub fn accept(&mut self, edge: &Edge) -> bool {
        self.consistency.accept(edge)
    }

    /// Takes a loop back that was accepted or waits for others, a person having found it wrong. Says whether there was one.
    pub fn remove_loop(&mut self, from: KeyframeId, to: KeyframeId) -> bool {
        let withdrawn = self.consistency.remove_loop(from, to);
        if withdrawn {
            self.submaps = SubmapCache::new(SUBMAPS_HELD);
            self.visits.doubt();
        }
        withdrawn
    }

    /// Points of a keyframe's cloud (base frame, metres) that move, judged by what the keyframes around it saw through.
    pub fn moving_points(&self, of: KeyframeId, xyz: &[[f32; 3]]) -> Vec<u32> {
        let own = of.0 as usize;
        let mut around: Vec<(f64, usize)> = (0..self.clouds.len())
            .filter(|&other| other != own)
            .filter_map(|other| Some((self.consistency.chain().walked(own, other)?, other)))
            .filter(|(walked, _)| *walked <= SUBMAP_WALK)
            .collect();
        around.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let others: Vec<_> = around
            .iter()
            .take(dynamic_points::VOTERS)
            .filter_map(|&(_, other)| {
                let way = self.consistency.chain().relative(own, other)?;
                Some((way.pose, self.clouds.get(other)?.view()))
            })
            .collect();
        dynamic_points::moving_points(xyz, &others)
    }

    /// What is known of the graph.
    pub fn consistency(&self) -> &LoopConsistencyCheck {
        &self.consistency
    }

    /// Bytes of submaps held ready, which do not grow with the walk.
    pub fn submap_bytes(&self) -> usize {
        self.submaps.bytes()
    }

    fn candidates(&self, newest: usize, xyz: &[[f32; 3]]) -> Vec<Candidate> {
        let (policy, chain) = (&self.config.candidates, self.consistency.chain());
        let old = candidates::old(chain, newest, policy);
        if old.is_empty() {
            return Vec::new();
        }
        let reach = self.consistency.reach(keyframe(newest));
        let level = &self.levels[newest];
        let near = candidates::by_geometry(&reach, chain, level, old.clone(), policy);
        let sure = near.iter().any(|c| c.expected.translation_std_m() <= policy.sure);
        if sure {
            let walked = self.last_closed.and_then(|closed| chain.walked(closed, newest));
            let due = walked.is_none_or(|walked| walked >= policy.spacing);
            return if due { near } else { Vec::new() };
        }
        let deviations = self.config.trust.contrary_deviations;
        if !candidates::appearance_may_help(
            &reach,
            level,
            old.clone(),
            (f64::from(ASIDE), deviations),
            policy,
        ) {
            return near;
        }
        let views = VIEW_ORIGINS.map(|origin| match self.places.descriptor(newest) {
            Some(own) if origin == [0.0; 2] => Arc::clone(own),
            _ => Arc::new(ScanContext::new(xyz, level, origin)),
        });
        let found = self.places.search(&views, old);
        let alike = candidates::by_appearance(
            &found,
            &self.levels,
            &VIEW_ORIGINS,
            &reach,
            chain,
            (newest, deviations),
            policy,
        );
        let mut all = near;
        for candidate in alike {
            let known = |c: &Candidate| {
                chain.walked(c.keyframe, candidate.keyframe).is_some_and(|walked| walked < policy.near)
                    && near_pose(&c.guess, &candidate.guess)
            };
            if !all.iter().any(known) {
                all.push(candidate);
            }
        }
        all
    }

    /// What was walked up to the newest waypoint.
    pub(crate) fn walked_submap(&self) -> LazySubmap {
        self.trail.submap(SUBMAP_WALK, SUBMAP_MEMBERS / 2)
    }

    /// A keyframe with what was walked before and after it, and where that is little, with what lies round it.
    pub(crate) fn submap(&mut self, own: usize) -> Arc<LazySubmap> {
        let (consistency, clouds, recent) = (&self.consistency, &self.clouds, self.config.candidates.walked);
        // A submap made while there was nothing after its keyframe knows only one side; keyed apart so that it is not kept.
        let key = if own + 1 == clouds.len() { usize::MAX - own } else { own };
        self.submaps.get(key, || {
            let chain = consistency.chain();
            let close = |k: &usize| chain.walked(own, *k).is_some_and(|walked| walked <= SUBMAP_WALK);
            let half = SUBMAP_MEMBERS / 2;
            let along = (own.saturating_sub(half)..(own + half + 1).min(clouds.len())).filter(close);
            let mut members: Vec<(usize, UncertainPose)> =
                along.filter_map(|k| Some((k, chain.relative(own, k)?))).collect();
            if members.len() < SUBMAP_LEAST {
                // Not of the walk just made, which is what this is going to be compared with.
                let old = |k: usize| chain.since(k).is_some_and(|walked| walked > recent);
                add_nearest(&mut members, &consistency.reach(keyframe(own)), old);
            }
            let place = members.iter().position(|(k, _)| *k == own).unwrap_or_default();
            LazySubmap::new(members.into_iter().map(|(k, way)| (way, clouds[k].clone())).collect(), place)
        })
    }
}

/// Adds those of the keyframes `among` that are nearest to the first one of a submap and known well from it, until it has the
/// least members; in the order of the walk.
fn add_nearest(
    members: &mut Vec<(usize, UncertainPose)>,
    reach: &[Option<UncertainPose>],
    among: impl Fn(usize) -> bool,
) {
    let mut near: Vec<(f64, usize, UncertainPose)> = reach
        .iter()
        .enumerate()
        .filter(|(k, _)| among(*k) && members.iter().all(|(member, _)| member != k))
        .filter_map(|(k, way)| {
            way.filter(|way| way.translation_std_m() <= SUBMAP_DEVIATION)
                .map(|way| (way.pose.translation.vector.norm(), k, way))
        })
        .filter(|(apart, _, _)| *apart <= SUBMAP_WALK)
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let missing = SUBMAP_LEAST.saturating_sub(members.len());
    members.extend(near.into_iter().take(missing).map(|(_, k, way)| (k, way)));
    members.sort_by_key(|(k, _)| *k);
}

/// Whether two guesses would lead to the same result.
fn near_pose(a: &Isometry, b: &Isometry) -> bool {
    let between = a.inverse() * b;
    between.translation.vector.norm() < 1.0 && between.rotation.angle() < 0.2
}

pub(crate) fn keyframe(index: usize) -> KeyframeId {
    KeyframeId(u32::try_from(index).unwrap_or(u32::MAX))
}

#[cfg(test)]
#[path = "loop_finder_tests.rs"]
mod tests;
