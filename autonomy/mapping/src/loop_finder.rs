//! Place recognition of a session: from a new keyframe to pairs worth verifying.
//!
//! The owner adds every keyframe with [`LoopFinder::add_keyframe`], runs [`crate::verify()`] on the tasks that come back, anywhere and in any
//! order, and hands the results to [`LoopFinder::evaluate`]. The same calls give the same bits. A robot that also walks over known ground calls
//! [`LoopFinder::add_waypoint`] instead, see [`crate::Novelty`]. The pose graph belongs to the caller.

use crate::candidates::{self, CandidateConfig, LoopCandidate};
use crate::consistency::{Decision, LoopConsistencyCheck, LoopConsistencyConfig, Verdict};
use crate::graph_element::{PoseGraphEdge, keyframe_id};
use crate::keyframe_descriptor::{KeyframeDescriptor, VIEW_OFFSET_M, VIEW_ORIGINS};
use crate::pose_graph::PoseGraph;
use crate::quality::{KeyframeFloor, MapQualityConfig, MapQualityData};
use crate::recent_scans::RecentScans;
use crate::revisits::{RevisitConfig, Revisits};
use crate::scan_context::{ScanContext, level_from_base};
use crate::scan_context_index::ScanContextIndex;
use crate::submap::{KeyframeCloud, LazySubmap, SubmapCache, SubmapConfig};
use crate::verification::{CandidateSource, Comparison, VerificationConfig, VerificationTask, VerifiedPair};
use crate::vertical::{MeasuredVertical, RelativeTilt};
use crate::{UncertainPose, dynamic_points};
use geometry::{Isometry, Rotation};
use points::Downsampler;
use std::sync::Arc;
use vocab::{KeyframeId, Stamp};

/// Parameters of a [`LoopFinder`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopConfig {
    /// Which keyframes are compared.
    pub candidates: CandidateConfig,
    /// How submaps are made.
    pub submap: SubmapConfig,
    /// Submaps kept in memory, 4 to 15 MB each. Chosen: both of a pair, and those of the pair before.
    pub cached_submaps: usize,
    /// What a comparison must pass.
    pub verification: VerificationConfig,
    /// When a loop is accepted.
    pub consistency: LoopConsistencyConfig,
    /// What is known ground, and when it is compared.
    pub revisits: RevisitConfig,
    /// How dynamic points are found.
    pub dynamic_points: dynamic_points::DynamicPointsConfig,
    /// Two guesses of a pose nearer than this lead to the same result of a registration, metres. Chosen: the starts of a registration lie 1.2 m around a guess
    /// ([`VerificationConfig::start_offset_m`]).
    pub same_guess_m: f64,
    /// The same for rotation, radians. Chosen: the coarse registration converges from more.
    pub same_guess_rad: f64,
}

impl Default for LoopConfig {
    fn default() -> Self {
        Self {
            candidates: CandidateConfig::default(),
            submap: SubmapConfig::default(),
            cached_submaps: 4,
            verification: VerificationConfig::default(),
            consistency: LoopConsistencyConfig::default(),
            revisits: RevisitConfig::default(),
            dynamic_points: dynamic_points::DynamicPointsConfig::default(),
            same_guess_m: 1.0,
            same_guess_rad: 0.2,
        }
    }
}

/// A keyframe as the loop finder takes it.
#[derive(Clone, Copy, Debug)]
pub struct NewKeyframe<'a> {
    /// Odometry edge from the last keyframe; `None` for the first.
    pub edge: Option<&'a PoseGraphEdge>,
    /// Attitude of the base in any frame whose z axis points up.
    pub rotation: Rotation,
    /// Its motion-corrected cloud, base frame, metres.
    pub xyz: &'a [[f32; 3]],
    /// Position of the LiDAR, base frame, metres.
    pub sensor: [f32; 3],
}

/// A keyframe of a finished map.
#[derive(Clone, Debug)]
pub struct MapKeyframe {
    /// Its pose.
    pub map_from_keyframe: Isometry,
    /// Its descriptor.
    pub descriptor: KeyframeDescriptor,
}

/// Place recognition and loop closure of one session. Holds about 33 kB a keyframe (cloud 18, range image 11.5, scan context 3.3) and four
/// submaps.
#[derive(Clone, Debug)]
pub struct LoopFinder {
    pub(crate) config: LoopConfig,
    pub(crate) consistency: LoopConsistencyCheck,
    index: ScanContextIndex,
    pub(crate) clouds: Vec<Arc<KeyframeCloud>>,
    pub(crate) levels: Vec<Rotation>,
    /// For each keyframe: the vertical there, if odometry measured it in this session.
    verticals: Vec<Option<MeasuredVertical>>,
    submaps: SubmapCache,
    pub(crate) downsampler: Downsampler,
    /// Keyframe of the last accepted loop.
    last_closed: Option<usize>,
    pub(crate) recent: RecentScans,
    pub(crate) revisits: Revisits,
    floors: Vec<Arc<KeyframeFloor>>,
}

impl LoopFinder {
    /// Of a session that begins.
    pub fn new(config: LoopConfig) -> Self {
        Self {
            config,
            consistency: LoopConsistencyCheck::new(config.consistency),
            index: ScanContextIndex::default(),
            clouds: Vec::new(),
            levels: Vec::new(),
            verticals: Vec::new(),
            submaps: SubmapCache::new(config.cached_submaps),
            downsampler: Downsampler::default(),
            last_closed: None,
            recent: RecentScans::default(),
            revisits: Revisits::default(),
            floors: Vec::new(),
        }
    }

    /// Of a session that extends a finished map with these keyframes and this graph. The robot's pose in the map is unknown at first: waypoints
    /// add nothing until [`Self::localise_in_map`] is called. Linear in the keyframes.
    pub fn resume(config: LoopConfig, map: &[MapKeyframe], graph: &mut PoseGraph) -> Self {
        let mut finder = Self::new(config);
        // So that no keyframe of the map counts as recent travel.
        graph.add_distance(2.0 * config.candidates.min_walked_m);
        for MapKeyframe { map_from_keyframe, descriptor } in map {
            let level = level_from_base(&map_from_keyframe.rotation);
            // Its vertical is that of another run of the odometry.
            finder.push_cloud(Arc::clone(&descriptor.cloud), level, None);
            finder.index.push(Arc::clone(&descriptor.views[0]));
        }
        finder
    }

    /// The parameters.
    pub fn config(&self) -> &LoopConfig {
        &self.config
    }

    /// Adds a keyframe to the graph, placed by its odometry edge. Returns the pairs to verify, at most twice
    /// [`CandidateConfig::max_count`]. Keyframes are numbered from 0 in the order of these calls.
    pub fn add_keyframe(&mut self, graph: &mut PoseGraph, new: &NewKeyframe) -> Vec<VerificationTask> {
        let step = new.edge.map(PoseGraphEdge::relative_pose);
        let last = graph.nodes().last().map_or_else(Isometry::identity, |node| node.map_from_keyframe);
        if let Some(step) = &step {
            graph.add_distance(step.pose.translation.vector.norm());
        }
        let pose = step.map_or(last, |step| last * step.pose);
        graph.add_keyframe(Stamp::EPOCH, &pose, new.edge);
        let cloud = Arc::new(KeyframeCloud::new(new.xyz, new.sensor, &mut self.downsampler));
        let waypoint = self.recent.push(step.unwrap_or_else(UncertainPose::identity), Arc::clone(&cloud));
        self.insert_keyframe(graph, waypoint, cloud, (&new.rotation, None), new.xyz)
    }

    /// Makes the newest waypoint a keyframe. The graph contains it already.
    pub(crate) fn insert_keyframe(
        &mut self,
        graph: &PoseGraph,
        waypoint: u64,
        cloud: Arc<KeyframeCloud>,
        (rotation, vertical): (&Rotation, Option<MeasuredVertical>),
        xyz: &[[f32; 3]],
    ) -> Vec<VerificationTask> {
        let newest = self.clouds.len();
        let level = level_from_base(rotation);
        self.revisits.anchor_at(keyframe_id(newest), waypoint);
        self.push_cloud(cloud, level, vertical);
        self.index.push(Arc::new(ScanContext::new(xyz, &level, [0.0; 2])));
        let candidates = self.candidates(graph, newest, xyz);
        if candidates.is_empty() {
            return Vec::new();
        }
        let newer = Arc::new(self.recent_submap());
        let tasks = candidates.into_iter().map(|candidate| VerificationTask {
            from: keyframe_id(candidate.keyframe),
            to: keyframe_id(newest),
            comparison: Comparison {
                source: candidate.source,
                guesses: vec![candidate.guess],
                expected: Some(candidate.expected),
                tilt: self.relative_tilt(candidate.keyframe, vertical.as_ref()),
                older: self.submap(graph, candidate.keyframe),
                newer: Arc::clone(&newer),
            },
        });
        tasks.collect()
    }

    /// The vertical at a keyframe and at a newer place, if it is known at both.
    pub(crate) fn relative_tilt(
        &self,
        older: usize,
        newer: Option<&MeasuredVertical>,
    ) -> Option<RelativeTilt> {
        let older = self.verticals.get(older)?.as_ref()?;
        Some(RelativeTilt::new(older, newer?))
    }

    fn push_cloud(
        &mut self,
        cloud: Arc<KeyframeCloud>,
        level_from_base: Rotation,
        vertical: Option<MeasuredVertical>,
    ) {
        self.verticals.push(vertical);
        self.floors.push(Arc::new(KeyframeFloor::new(Arc::clone(&cloud), level_from_base)));
        self.clouds.push(cloud);
        self.levels.push(level_from_base);
    }

    /// Decides about a verified pair, and about held loops that it supports. Accepted loops are added to the graph, which the caller optimises.
    pub fn evaluate(&mut self, graph: &mut PoseGraph, verified: &VerifiedPair) -> Vec<Decision> {
        let decisions = self.consistency.evaluate(graph, verified);
        for decision in &decisions {
            if decision.verdict == Verdict::Accepted {
                let closed = decision.edge.to.0 as usize;
                self.last_closed = self.last_closed.max(Some(closed));
            }
        }
        decisions
    }

    /// A task for a pair that a person proposes, with a guess of the newer keyframe's pose in the older one. `None` for unknown keyframes.
    pub fn propose(
        &mut self,
        graph: &PoseGraph,
        from: KeyframeId,
        to: KeyframeId,
        guess: Isometry,
    ) -> Option<VerificationTask> {
        let (older, newer) = (from.0 as usize, to.0 as usize);
        if older.max(newer) >= self.clouds.len() {
            return None;
        }
        let expected = graph.poses_in(from).get(newer).copied().flatten();
        let tilt = self.relative_tilt(older, self.verticals.get(newer).and_then(Option::as_ref));
        let (older, newer) = (self.submap(graph, older), self.submap(graph, newer));
        let source = CandidateSource::Person;
        let comparison = Comparison { source, guesses: vec![guess], expected, tilt, older, newer };
        Some(VerificationTask { from, to, comparison })
    }

    /// Adds a loop that a person accepted, without a check. Returns whether the keyframes exist.
    pub fn accept(&mut self, graph: &mut PoseGraph, edge: &PoseGraphEdge) -> bool {
        self.consistency.accept(graph, edge)
    }

    /// Removes a loop that a person rejected, whether it was accepted or held. Returns whether there was one. The robot's pose may depend on it, so
    /// it is relative to the last keyframe again.
    pub fn remove_loop(&mut self, graph: &mut PoseGraph, from: KeyframeId, to: KeyframeId) -> bool {
        let removed = self.consistency.remove_loop(graph, from, to);
        if removed {
            self.submaps = SubmapCache::new(self.config.cached_submaps);
            self.revisits.reset_to_odometry();
        }
        removed
    }

    /// Dynamic points of a keyframe's cloud (base frame, metres), by the scans of the keyframes around it.
    pub fn dynamic_points(&self, graph: &PoseGraph, of: KeyframeId, xyz: &[[f32; 3]]) -> Vec<u32> {
        let (own, chain, config) = (of.0 as usize, graph.chain(), &self.config.dynamic_points);
        let mut around: Vec<(f64, usize)> = (0..self.clouds.len())
            .filter(|&other| other != own)
            .filter_map(|other| Some((chain.distance_between(own, other)?, other)))
            .filter(|(distance_m, _)| *distance_m <= config.max_walk_distance_m)
            .collect();
        around.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let others: Vec<_> = around
            .iter()
            .take(config.max_voters)
            .filter_map(|&(_, other)| {
                let relative = chain.relative_pose(own, other)?;
                Some((relative.pose, self.clouds.get(other)?.view()))
            })
            .collect();
        dynamic_points::dynamic_points(xyz, &others, config)
    }

    /// The consistency check.
    pub fn consistency(&self) -> &LoopConsistencyCheck {
        &self.consistency
    }

    /// A snapshot of the map whose keyframes are at `poses`, for its quality. Linear in the keyframes and edges, which it copies; clouds are shared.
    pub fn quality_data(&self, graph: &PoseGraph, poses: &[Isometry]) -> MapQualityData {
        let keyframes = poses.iter().copied().zip(self.floors.iter().cloned()).collect();
        let (config, covariances) = (MapQualityConfig::default(), graph.covariances().clone());
        MapQualityData { config, keyframes, covariances }
    }

    /// Bytes of the cached submaps. They do not grow with the walk.
    pub fn submap_bytes(&self) -> usize {
        self.submaps.bytes()
    }

    fn candidates(&self, graph: &PoseGraph, newest: usize, xyz: &[[f32; 3]]) -> Vec<LoopCandidate> {
        let (config, chain) = (&self.config.candidates, graph.chain());
        let old = candidates::old_keyframes(chain, newest, config);
        if old.is_empty() {
            return Vec::new();
        }
        let poses = graph.poses_in(keyframe_id(newest));
        let level = &self.levels[newest];
        let near = candidates::by_geometry(&poses, chain, level, old.clone(), config);
        let is_certain = near.iter().any(|c| c.expected.translation_std_m() <= config.certain_std_m);
        if is_certain {
            let walked_m = self.last_closed.and_then(|closed| chain.distance_between(closed, newest));
            let is_due = walked_m.is_none_or(|walked_m| walked_m >= config.spacing_m);
            return if is_due { near } else { Vec::new() };
        }
        let deviations = self.config.consistency.max_contradiction_deviations;
        let offset_m = f64::from(VIEW_OFFSET_M);
        if !candidates::appearance_may_help(&poses, level, old.clone(), (offset_m, deviations), config) {
            return near;
        }
        let views = VIEW_ORIGINS.map(|origin| match self.index.get(newest) {
            Some(own) if origin == [0.0; 2] => Arc::clone(own),
            _ => Arc::new(ScanContext::new(xyz, level, origin)),
        });
        let found = self.index.search(&views, old);
        let alike = candidates::by_appearance(
            &found,
            &self.levels,
            &VIEW_ORIGINS,
            &poses,
            chain,
            (newest, deviations),
            config,
        );
        let mut all = near;
        for candidate in alike {
            let is_same = |c: &LoopCandidate| {
                let distance_m = chain.distance_between(c.keyframe, candidate.keyframe);
                distance_m.is_some_and(|distance_m| distance_m < config.max_offset_m)
                    && self.is_same_guess(&c.guess, &candidate.guess)
            };
            if !all.iter().any(is_same) {
                all.push(candidate);
            }
        }
        all
    }

    /// Whether a registration would give the same result from two guesses.
    fn is_same_guess(&self, a: &Isometry, b: &Isometry) -> bool {
        let between = a.inverse() * b;
        between.translation.vector.norm() < self.config.same_guess_m
            && between.rotation.angle() < self.config.same_guess_rad
    }

    /// Submap of the newest waypoint: what was walked up to it.
    pub(crate) fn recent_submap(&self) -> LazySubmap {
        let config = &self.config.submap;
        self.recent.submap(config.radius_m, config.max_keyframes / 2)
    }

    /// Submap of a keyframe: what was walked before and after it. If that is little, keyframes around it are added.
    pub(crate) fn submap(&mut self, graph: &PoseGraph, own: usize) -> Arc<LazySubmap> {
        let (clouds, min_walked_m) = (&self.clouds, self.config.candidates.min_walked_m);
        let config = self.config.submap;
        // The submap of the newest keyframe has one side only; its own key keeps it from being used when there is more.
        let key = if own + 1 == clouds.len() { usize::MAX - own } else { own };
        self.submaps.get(key, || {
            let chain = graph.chain();
            let is_close = |k: &usize| chain.distance_between(own, *k).is_some_and(|d| d <= config.radius_m);
            let half = config.max_keyframes / 2;
            let along = (own.saturating_sub(half)..(own + half + 1).min(clouds.len())).filter(is_close);
            let mut members: Vec<(usize, UncertainPose)> =
                along.filter_map(|k| Some((k, chain.relative_pose(own, k)?))).collect();
            if members.len() < config.min_keyframes {
                // Without the walk just made, because the submap is going to be compared with it.
                let is_old = |k: usize| chain.distance_since(k).is_some_and(|d| d > min_walked_m);
                add_nearest(&mut members, &graph.poses_in(keyframe_id(own)), is_old, &config);
            }
            let position = members.iter().position(|(k, _)| *k == own).unwrap_or_default();
            let members = members.into_iter().map(|(k, relative)| (relative, clouds[k].clone()));
            LazySubmap::new(members.collect(), position)
        })
    }
}

/// Adds to a submap those of the keyframes `among` that are nearest to its first one and known well from it, until it has the least number of
/// members. The members stay in the order of the walk.
fn add_nearest(
    members: &mut Vec<(usize, UncertainPose)>,
    poses: &[Option<UncertainPose>],
    among: impl Fn(usize) -> bool,
    config: &SubmapConfig,
) {
    let mut near: Vec<(f64, usize, UncertainPose)> = poses
        .iter()
        .enumerate()
        .filter(|(k, _)| among(*k) && members.iter().all(|(member, _)| member != k))
        .filter_map(|(k, pose)| {
            pose.filter(|pose| pose.translation_std_m() <= config.max_std_m)
                .map(|pose| (pose.pose.translation.vector.norm(), k, pose))
        })
        .filter(|(distance_m, _, _)| *distance_m <= config.radius_m)
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let missing = config.min_keyframes.saturating_sub(members.len());
    members.extend(near.into_iter().take(missing).map(|(_, k, pose)| (k, pose)));
    members.sort_by_key(|(k, _)| *k);
}

#[cfg(test)]
#[path = "loop_finder_tests.rs"]
mod tests;
