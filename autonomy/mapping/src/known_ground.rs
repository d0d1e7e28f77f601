//! Known ground, in the [`LoopFinder`]: the decision whether a waypoint becomes a keyframe or is a revisit, and the update after the comparison of a
//! revisit. `revisits` holds the robot's pose in the graph, and explains the method.

use crate::graph_element::{PoseGraphEdge, keyframe_id};
use crate::loop_finder::LoopFinder;
use crate::pose_graph::PoseGraph;
use crate::revisits::{AnchoredPose, Novelty, PendingRevisit, Reanchoring, Revisit, RevisitResult};
use crate::scan_context::level_from_base;
use crate::session::{OdometryStep, Waypoint};
use crate::submap::KeyframeCloud;
use crate::uncertain_pose::UncertainPose;
use crate::verification::{CandidateSource, Comparison, ComparisonResult, VerifiedPair};
use geometry::{Isometry, Rotation};
use std::sync::Arc;
use vocab::KeyframeId;

impl LoopFinder {
    /// Adds the next waypoint with its motion-corrected cloud (base frame, metres), measured from `sensor` (base frame, metres). If it is a
    /// keyframe, it is added to the graph. Costs a search of the graph, as [`Self::add_keyframe`].
    pub fn add_waypoint(
        &mut self,
        graph: &mut PoseGraph,
        waypoint: &Waypoint,
        xyz: &[[f32; 3]],
        sensor: [f32; 3],
    ) -> Novelty {
        let cloud = Arc::new(KeyframeCloud::new(xyz, sensor, &mut self.downsampler));
        let rotation = &waypoint.map_from_base.rotation;
        let step = waypoint.step.as_ref().map_or_else(UncertainPose::identity, OdometryStep::relative_pose);
        let length_m = step.pose.translation.vector.norm();
        let number = self.recent.push(step, Arc::clone(&cloud));
        if self.clouds.is_empty() {
            let id = graph.add_keyframe(waypoint.stamp, &waypoint.map_from_base, None).id;
            return Novelty::Keyframe {
                id,
                tasks: self.insert_keyframe(graph, number, cloud, (rotation, waypoint.vertical), xyz),
            };
        }
        graph.add_distance(length_m);
        let Some(mut position) = self.revisits.position else { return Novelty::Unlocalised(number) };
        position.anchor_from_waypoint = position.anchor_from_waypoint.compose(&step);
        self.revisits.by_odometry =
            self.revisits.by_odometry.map(|(keyframe, pose)| (keyframe, pose.compose(&step)));
        position.unconfirmed_m += length_m;
        position.uncompared_m += length_m;
        self.revisits.position = Some(position);
        if let Some((known, waypoint_from_known)) = self.find_known_ground(graph, &position, &cloud, rotation)
        {
            let revisit = self.ask_comparison(graph, number, waypoint, known, &waypoint_from_known);
            return Novelty::Revisit(revisit);
        }
        let (pose, information) = match &waypoint.step {
            Some(step) if position.at_anchor && position.since + 1 == number => (step.pose, step.information),
            _ => (position.anchor_from_waypoint.pose, position.anchor_from_waypoint.information()),
        };
        let edge =
            PoseGraphEdge { from: position.anchor, to: graph.next_id(), from_from_to: pose, information };
        let id = graph.add_keyframe(waypoint.stamp, &waypoint.map_from_base, Some(&edge)).id;
        Novelty::Keyframe {
            id,
            tasks: self.insert_keyframe(graph, number, cloud, (rotation, waypoint.vertical), xyz),
        }
    }

    /// Sets the pose of a waypoint in the finished map that the session extends. From now on the walk extends the map. Returns the pose of the
    /// newest waypoint in the keyframe. `None`, without an effect, for an unknown keyframe or a waypoint that is not kept any more.
    pub fn localise_in_map(
        &mut self,
        waypoint: u64,
        keyframe: KeyframeId,
        keyframe_from_waypoint: &UncertainPose,
    ) -> Option<Isometry> {
        let since = self.recent.relative_pose(waypoint, self.recent.newest())?;
        if keyframe.0 as usize >= self.clouds.len() {
            return None;
        }
        let pose = keyframe_from_waypoint.compose(&since);
        self.revisits.position = Some(AnchoredPose {
            anchor: keyframe,
            anchor_from_waypoint: pose,
            since: waypoint,
            at_anchor: false,
            unconfirmed_m: since.pose.translation.vector.norm(),
            uncompared_m: 0.0,
        });
        self.revisits.by_odometry = Some((keyframe, pose));
        Some(pose.pose)
    }

    /// The anchor, and the pose of the newest waypoint in it. `None` before the first keyframe.
    pub fn position(&self) -> Option<(KeyframeId, Isometry)> {
        self.revisits.position.map(|position| (position.anchor, position.anchor_from_waypoint.pose))
    }

    /// The nearest keyframe that saw the current scan, with its pose in the newest waypoint.
    fn find_known_ground(
        &self,
        graph: &PoseGraph,
        position: &AnchoredPose,
        cloud: &KeyframeCloud,
        rotation: &Rotation,
    ) -> Option<(usize, UncertainPose)> {
        let config = &self.config.revisits;
        if position.unconfirmed_m > config.max_unconfirmed_m {
            return None;
        }
        let level = level_from_base(rotation);
        let mut near: Vec<(f64, usize, UncertainPose)> = graph
            .poses_in_frame(position.anchor, &position.anchor_from_waypoint)
            .into_iter()
            .enumerate()
            .filter_map(|(index, seen)| {
                let seen = seen?;
                let offset = level * seen.pose.translation.vector;
                let radius_m =
                    if self.is_old(graph, index) { config.old_radius_m } else { config.recent_radius_m };
                let is_near = offset.xy().norm() <= radius_m && offset.z.abs() <= config.max_height_m;
                let is_certain = is_near && seen.translation_std_m() <= self.config.candidates.certain_std_m;
                is_certain.then_some((offset.norm(), index, seen))
            })
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.truncate(config.tested_keyframes);
        let known = near.into_iter().find(|(_, index, seen)| {
            self.clouds.get(*index).is_some_and(|old| {
                covered_share(old, cloud, &seen.pose, config.tested_points) >= config.min_covered_share
            })
        });
        known.map(|(_, index, seen)| (index, seen))
    }

    /// Whether a keyframe is not recent travel.
    fn is_old(&self, graph: &PoseGraph, keyframe: usize) -> bool {
        let distance_m = graph.chain().distance_since(keyframe);
        distance_m.is_some_and(|distance_m| distance_m > self.config.candidates.min_walked_m)
    }

    /// A comparison of the waypoint with this number with a known keyframe, if one is due. `waypoint_from_known` is the keyframe's pose in the waypoint.
    fn ask_comparison(
        &mut self,
        graph: &PoseGraph,
        number: u64,
        waypoint: &Waypoint,
        known: usize,
        waypoint_from_known: &UncertainPose,
    ) -> Option<Revisit> {
        let spacing_m = self.config.candidates.spacing_m;
        let is_old = self.is_old(graph, known);
        let keyframes = self.clouds.len();
        let position = self
            .revisits
            .position
            .as_mut()
            .filter(|position| is_old && position.uncompared_m >= spacing_m)?;
        position.uncompared_m = 0.0;
        let (expected, keyframe) = (waypoint_from_known.inverse(), keyframe_id(known));
        self.revisits.pending.push_back(PendingRevisit {
            waypoint: number,
            stamp: waypoint.stamp,
            keyframe,
            expected,
            anchor: position.anchor,
            anchor_from_revisit: position.anchor_from_waypoint,
            keyframes,
        });
        if self.revisits.pending.len() > self.config.revisits.max_pending {
            self.revisits.pending.pop_front();
        }
        let (older, newer) = (self.submap(graph, known), Arc::new(self.recent_submap()));
        let (source, guesses) = (CandidateSource::Geometry, vec![expected.pose]);
        let tilt = self.relative_tilt(known, waypoint.vertical.as_ref());
        let comparison = Comparison { source, guesses, expected: Some(expected), tilt, older, newer };
        Some(Revisit { waypoint: number, keyframe, comparison })
    }

    /// Takes the result of comparing a revisit. Comparisons that are not pending are rejected.
    pub fn complete_revisit(
        &mut self,
        graph: &PoseGraph,
        waypoint: u64,
        result: &ComparisonResult,
    ) -> RevisitResult {
        let index = self.revisits.pending.iter().position(|pending| pending.waypoint == waypoint);
        let Some(pending) = index.and_then(|index| self.revisits.pending.remove(index)) else {
            return RevisitResult::Rejected;
        };
        let measured = UncertainPose::from_information(result.pose, &result.information);
        if result.rejection.is_some() || !self.consistency.confirms(&pending.expected, &measured) {
            return RevisitResult::Rejected;
        }
        let covariance = measured.covariance * self.config.revisits.shared_covariance;
        let shared = UncertainPose { covariance, ..measured };
        let is_degenerate = result.evidence.degenerate_directions > 0;
        let newest = self.recent.newest();
        let Some(position) = &mut self.revisits.position else { return RevisitResult::Rejected };
        if self.clouds.len() > pending.keyframes {
            let first = keyframe_id(pending.keyframes);
            // Of several new keyframes, only the waypoint of the last one is known.
            let is_only_one = self.clouds.len() == pending.keyframes + 1;
            let since = self.recent.relative_pose(waypoint, self.revisits.last_keyframe);
            return match since.filter(|_| is_only_one && !is_degenerate) {
                Some(since) => {
                    let relative = shared.compose(&since);
                    RevisitResult::Loop(verified_loop(pending.keyframe, first, &relative, result))
                }
                None => RevisitResult::Confirmed,
            };
        }
        let Some(since) = self.recent.relative_pose(waypoint, newest) else {
            return RevisitResult::Confirmed;
        };
        position.unconfirmed_m = position.unconfirmed_m.min(since.pose.translation.vector.norm());
        if is_degenerate || position.since > waypoint {
            return RevisitResult::Confirmed;
        }
        let pose = shared.compose(&since);
        // An earlier comparison may have moved the anchor and used the path from there already.
        let is_used = position.anchor != pending.anchor;
        (position.anchor, position.anchor_from_waypoint) = (pending.keyframe, pose);
        (position.since, position.at_anchor) = (waypoint, false);
        let edge = if is_used { None } else { improved_edge(graph, &pending, &shared, result) };
        RevisitResult::Reanchored(Reanchoring {
            since: pending.stamp,
            anchor: pending.keyframe,
            anchor_from_waypoint: pose.pose,
            edge,
        })
    }
}

/// The relative pose of the old anchor and the revisited keyframe as a loop, if it is known better than in the graph.
fn improved_edge(
    graph: &PoseGraph,
    pending: &PendingRevisit,
    shared: &UncertainPose,
    result: &ComparisonResult,
) -> Option<VerifiedPair> {
    if pending.anchor == pending.keyframe {
        return None;
    }
    let measured = pending.anchor_from_revisit.compose(&shared.inverse());
    let known = graph.relative_pose(pending.anchor, pending.keyframe)?;
    let is_better = measured.translation_std_m() < known.translation_std_m();
    // The older keyframe comes first.
    let (from, to, relative) = if pending.anchor < pending.keyframe {
        (pending.anchor, pending.keyframe, measured)
    } else {
        (pending.keyframe, pending.anchor, measured.inverse())
    };
    is_better.then(|| verified_loop(from, to, &relative, result))
}

fn verified_loop(
    from: KeyframeId,
    to: KeyframeId,
    relative: &UncertainPose,
    result: &ComparisonResult,
) -> VerifiedPair {
    let result = ComparisonResult { pose: relative.pose, information: relative.information(), ..*result };
    VerifiedPair::new(from, to, &result)
}

/// Share of the current scan that an old keyframe saw too, by `tested_points` of its points. `now_from_old` is the keyframe's pose in the scan.
fn covered_share(
    old: &KeyframeCloud,
    now: &KeyframeCloud,
    now_from_old: &Isometry,
    tested_points: usize,
) -> f64 {
    let old_from_now = now_from_old.inverse();
    let rotation = old_from_now.rotation.to_rotation_matrix().into_inner().map(|v| v as f32);
    let translation = old_from_now.translation.vector.map(|v| v as f32);
    let stride = now.points().len().div_ceil(tested_points).max(1);
    let (mut seen, mut tested) = (0_usize, 0_usize);
    for point in now.points().step_by(stride) {
        let moved = rotation * nalgebra::Vector3::from(point) + translation;
        tested += 1;
        seen += usize::from(old.view().observes(&[moved.x, moved.y, moved.z]));
    }
    seen as f64 / tested.max(1) as f64
}

#[cfg(test)]
#[path = "known_ground_tests.rs"]
mod tests;
