//! Known ground: where the robot walks again, it finds its place among old keyframes instead of adding new ones, so that the
//! graph follows the size of the site and not the time.
//!
//! The robot's place is told from an anchor, a keyframe, by the way walked from there. A waypoint near an old keyframe that saw
//! most of what is seen now is a visit: nothing is kept of it. Every few metres a visit is compared with that keyframe, and what
//! comes out makes it the anchor. If that says more of how the two anchors lie to each other than the graph knows, it is a loop between
//! them. Where the ground is not known, or no comparison has succeeded for some metres, waypoints become keyframes. Source of the
//! idea: Johannsson et al., *Temporally scalable visual SLAM using a reduced pose graph*, ICRA 2013.

use crate::loop_finder::keyframe;
use crate::scan_context::level_from_base;
use crate::session::{Step, Waypoint};
use crate::submap::KeyframeCloud;
use crate::verify::{CandidateSource, Comparison, ComparisonResult, VerificationTask, VerifiedPair};
use crate::{Edge, LoopFinder, UncertainPose};
use geometry::{Isometry, Rotation};
use std::collections::VecDeque;
use std::sync::Arc;
use vocab::{KeyframeId, Stamp};

/// A keyframe overlooks what is this near to it, metres: one of the walk just made, less than lies between two of them, and
/// an old one, whose lane need not be met.
const NEAR: (f64, f64) = (0.95, 1.5);
/// The same vertically, metres: some steps of a flight of stairs.
const LEVEL: f64 = 0.5;
/// Least share of what is seen now that the keyframe saw too. A metre away it is 0.65 to 0.95, and behind a wall below 0.3.
const COVERED: f64 = 0.6;
/// Points looked at for that.
const POINTS: usize = 300;
/// Keyframes asked for that.
const ASKED: usize = 3;
/// Known ground is believed for so many metres after the last keyframe or visit that was confirmed.
const BELIEVED: f64 = 6.0;
/// Comparisons under way at most; beyond it the oldest is given up.
const UNDER_WAY: usize = 8;
/// A tie serves two edges, the one that leads to it and the one that leads away, so that each gets half its information.
const SHARED: f64 = 2.0;

/// What a waypoint is.
#[derive(Clone, Debug)]
pub enum Novelty {
    /// A keyframe, with the edge that leads to it (none to the first) and pairs to verify.
    Keyframe {
        /// From an old keyframe, mostly the last one.
        edge: Option<Edge>,
        /// As [`LoopFinder::add_keyframe`] has them.
        tasks: Vec<VerificationTask>,
    },
    /// A visit to old keyframes, perhaps to be compared with one of them.
    Revisit(Option<Revisit>),
    /// Somewhere in a finished map; [`LoopFinder::localise_in_map`] has not been told where. Its number.
    Unlocalised(u64),
}

/// A visit to be compared.
#[derive(Clone, Debug)]
pub struct Revisit {
    /// Number of the waypoint.
    pub number: u64,
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// What comparing takes; the keyframe is the older place.
    pub comparison: Comparison,
}

/// What became of a visit that was compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RevisitResult {
    /// It is not where it was expected, or nothing could be told: all stays as it was.
    Rejected,
    /// It confirms the place without saying anything better; or something newer is known by now.
    Confirmed,
    /// The place is known anew.
    Reanchored(Reanchoring),
    /// The walk has left known ground since, and this is how its first keyframe there lies to the visited one: a loop to be judged.
    Loop(VerifiedPair),
}

/// The robot's place, known anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reanchoring {
    /// From when on.
    pub since: Stamp,
    /// Keyframe that it is told from.
    pub anchor: KeyframeId,
    /// The newest waypoint in it.
    pub anchor_from_waypoint: Isometry,
    /// A loop between the anchor before and this one, that says more than the graph.
    pub edge: Option<VerifiedPair>,
}

/// Where the robot is in the graph, and which comparisons are under way.
#[derive(Clone, Debug, Default)]
pub(crate) struct Revisits {
    position: Option<Position>,
    /// Waypoint of the last keyframe.
    last_keyframe: u64,
    /// The last keyframe and the way walked from there, without any comparison.
    reckoned: Option<(KeyframeId, UncertainPose)>,
    under_way: VecDeque<UnderWay>,
}

#[derive(Clone, Copy, Debug)]
struct Position {
    anchor: KeyframeId,
    /// The newest waypoint in the anchor.
    way: UncertainPose,
    /// Waypoint from which on this is known.
    since: u64,
    /// Whether that is the anchor itself, and not a visit to it.
    own: bool,
    /// Metres walked since the last keyframe or confirmation, and since a comparison was asked for.
    unconfirmed: f64,
    unasked: f64,
}

#[derive(Clone, Copy, Debug)]
struct UnderWay {
    visit: u64,
    stamp: Stamp,
    keyframe: KeyframeId,
    /// The visit in the keyframe, by what was known then.
    expected: UncertainPose,
    /// The visit in the anchor of then.
    anchor: KeyframeId,
    anchor_from_visit: UncertainPose,
    /// Keyframes there were.
    keyframes: usize,
}

impl Revisits {
    /// A waypoint became a keyframe: the place is told from it.
    pub fn begin_at(&mut self, anchor: KeyframeId, waypoint: u64) {
        let way = UncertainPose::identity();
        let position = Position { anchor, way, since: waypoint, own: true, unconfirmed: 0.0, unasked: 0.0 };
        self.position = Some(position);
        self.last_keyframe = waypoint;
        self.reckoned = Some((anchor, way));
    }

    /// A loop was taken back, on which the place may rest: it is told from the last keyframe, no comparison under way is
    /// believed, and the next waypoint is a keyframe.
    pub fn doubt(&mut self) {
        self.under_way.clear();
        if let (Some(position), Some((anchor, way))) = (&mut self.position, self.reckoned) {
            (position.anchor, position.way, position.own) = (anchor, way, false);
            position.unconfirmed = f64::INFINITY;
        }
    }
}

impl LoopFinder {
    /// Takes in the next waypoint with its motion-corrected cloud (base frame, metres), seen from `sensor` (base frame).
    /// Costs a search of the graph, as [`Self::add_keyframe`].
    pub fn add_waypoint(&mut self, waypoint: &Waypoint, xyz: &[[f32; 3]], sensor: [f32; 3]) -> Novelty {
        let cloud = Arc::new(KeyframeCloud::new(xyz, sensor, &mut self.downsampler));
        let rotation = &waypoint.map_from_base.rotation;
        let step = |step: &Step| UncertainPose::from_information(step.pose, &step.information);
        let way = waypoint.step.as_ref().map_or_else(UncertainPose::identity, step);
        let length = way.pose.translation.vector.norm();
        let number = self.trail.push(way, Arc::clone(&cloud));
        if self.clouds.is_empty() {
            return Novelty::Keyframe {
                edge: None,
                tasks: self.insert_keyframe(number, cloud, rotation, xyz),
            };
        }
        self.consistency.walk(length);
        let Some(mut position) = self.visits.position else { return Novelty::Unlocalised(number) };
        position.way = position.way.then(&way);
        self.visits.reckoned = self.visits.reckoned.map(|(from, walked)| (from, walked.then(&way)));
        position.unconfirmed += length;
        position.unasked += length;
        self.visits.position = Some(position);
        if let Some((known, seen)) = self.known_ground(&position, &cloud, rotation) {
            return Novelty::Revisit(self.visit(number, waypoint.stamp, known, &seen));
        }
        let next = keyframe(self.clouds.len());
        let (pose, information) = match &waypoint.step {
            Some(step) if position.own && position.since + 1 == number => (step.pose, step.information),
            _ => (position.way.pose, position.way.information()),
        };
        let edge = Edge { from: position.anchor, to: next, from_from_to: pose, information };
        self.consistency.attach_keyframe(&edge);
        Novelty::Keyframe { edge: Some(edge), tasks: self.insert_keyframe(number, cloud, rotation, xyz) }
    }

    /// Tells where a waypoint was in the finished map that the session goes on from: what is walked from now on extends it. Says
    /// where the newest waypoint is in the keyframe; none, and nothing is told, if there is no such keyframe or the waypoint was
    /// too long ago.
    pub fn localise_in_map(
        &mut self,
        waypoint: u64,
        keyframe: KeyframeId,
        keyframe_from_waypoint: &UncertainPose,
    ) -> Option<Isometry> {
        let on = self.trail.way(waypoint, self.trail.newest())?;
        if keyframe.0 as usize >= self.clouds.len() {
            return None;
        }
        let way = keyframe_from_waypoint.then(&on);
        self.visits.position = Some(Position {
            anchor: keyframe,
            way,
            since: waypoint,
            own: false,
            unconfirmed: on.pose.translation.vector.norm(),
            unasked: 0.0,
        });
        self.visits.reckoned = Some((keyframe, way));
        Some(way.pose)
    }

    /// The anchor, and the newest waypoint in it; none before the first keyframe.
    pub fn position(&self) -> Option<(KeyframeId, Isometry)> {
        self.visits.position.map(|position| (position.anchor, position.way.pose))
    }

    /// The nearest keyframe that saw what is seen now, and how it lies to the newest waypoint.
    fn known_ground(
        &self,
        position: &Position,
        cloud: &KeyframeCloud,
        rotation: &Rotation,
    ) -> Option<(usize, UncertainPose)> {
        if position.unconfirmed > BELIEVED {
            return None;
        }
        let level = level_from_base(rotation);
        let mut near: Vec<(f64, usize, UncertainPose)> = self
            .consistency
            .reach_along(position.anchor, &position.way)
            .into_iter()
            .enumerate()
            .filter_map(|(index, seen)| {
                let seen = seen?;
                let offset = level * seen.pose.translation.vector;
                let limit = if self.is_old(index) { NEAR.1 } else { NEAR.0 };
                let within = offset.xy().norm() <= limit && offset.z.abs() <= LEVEL;
                let sure = within && seen.translation_std_m() <= self.config.candidates.sure;
                sure.then_some((offset.norm(), index, seen))
            })
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.truncate(ASKED);
        let known = near.into_iter().find(|(_, index, seen)| {
            self.clouds.get(*index).is_some_and(|old| covered(old, cloud, &seen.pose) >= COVERED)
        });
        known.map(|(_, index, seen)| (index, seen))
    }

    /// Whether a keyframe is no recent travel.
    fn is_old(&self, keyframe: usize) -> bool {
        self.consistency.chain().since(keyframe).is_some_and(|walked| walked > self.config.candidates.walked)
    }

    /// A comparison with a known keyframe, if one is due. `seen`: the keyframe in the waypoint.
    fn visit(&mut self, number: u64, stamp: Stamp, known: usize, seen: &UncertainPose) -> Option<Revisit> {
        let due = self.config.candidates.spacing;
        let old = self.is_old(known);
        let keyframes = self.clouds.len();
        let position = self.visits.position.as_mut().filter(|position| old && position.unasked >= due)?;
        position.unasked = 0.0;
        let (expected, known_id) = (seen.inverse(), keyframe(known));
        self.visits.under_way.push_back(UnderWay {
            visit: number,
            stamp,
            keyframe: known_id,
            expected,
            anchor: position.anchor,
            anchor_from_visit: position.way,
            keyframes,
        });
        if self.visits.under_way.len() > UNDER_WAY {
            self.visits.under_way.pop_front();
        }
        let (older, newer) = (self.submap(known), Arc::new(self.walked_submap()));
        let (source, guesses) = (CandidateSource::Geometry, vec![expected.pose]);
        let comparison = Comparison { source, guesses, expected: Some(expected), older, newer };
        Some(Revisit { number, keyframe: known_id, comparison })
    }

    /// Takes in what came of comparing a visit. Comparisons that are not under way are refused.
    pub fn complete_revisit(&mut self, visit: u64, compared: &ComparisonResult) -> RevisitResult {
        let place = self.visits.under_way.iter().position(|asked| asked.visit == visit);
        let Some(asked) = place.and_then(|place| self.visits.under_way.remove(place)) else {
            return RevisitResult::Rejected;
        };
        let measured = UncertainPose::from_information(compared.pose, &compared.information);
        if compared.rejection.is_some() || !self.consistency.confirms(&asked.expected, &measured) {
            return RevisitResult::Rejected;
        }
        let shared = UncertainPose { covariance: measured.covariance * SHARED, ..measured };
        let blind = compared.evidence.blind > 0;
        let newest = self.trail.newest();
        let Some(position) = &mut self.visits.position else { return RevisitResult::Rejected };
        if self.clouds.len() > asked.keyframes {
            let first = keyframe(asked.keyframes);
            let last = self.clouds.len() == asked.keyframes + 1;
            // Of several, only the last one's waypoint is remembered.
            return match self.trail.way(visit, self.visits.last_keyframe).filter(|_| last && !blind) {
                Some(on) => RevisitResult::Loop(loop_of(asked.keyframe, first, &shared.then(&on), compared)),
                None => RevisitResult::Confirmed,
            };
        }
        let Some(on) = self.trail.way(visit, newest) else { return RevisitResult::Confirmed };
        position.unconfirmed = position.unconfirmed.min(on.pose.translation.vector.norm());
        if blind || position.since > visit {
            return RevisitResult::Confirmed;
        }
        let way = shared.then(&on);
        // Another comparison that was asked for before has moved the anchor on, and has used that way already.
        let used = position.anchor != asked.anchor;
        (position.anchor, position.way) = (asked.keyframe, way);
        (position.since, position.own) = (visit, false);
        let edge = if used { None } else { self.news(&asked, &shared, compared) };
        let anchor = asked.keyframe;
        RevisitResult::Reanchored(Reanchoring {
            since: asked.stamp,
            anchor,
            anchor_from_waypoint: way.pose,
            edge,
        })
    }

    /// What a visit says of how its keyframe lies to the anchor before, if that is more than the graph knows.
    fn news(
        &self,
        asked: &UnderWay,
        shared: &UncertainPose,
        compared: &ComparisonResult,
    ) -> Option<VerifiedPair> {
        if asked.anchor == asked.keyframe {
            return None;
        }
        let between = asked.anchor_from_visit.then(&shared.inverse());
        let known = self.consistency.between(asked.anchor, asked.keyframe)?;
        let better = between.translation_std_m() < known.translation_std_m();
        // Older keyframe first.
        let (from, to, between) = if asked.anchor < asked.keyframe {
            (asked.anchor, asked.keyframe, between)
        } else {
            (asked.keyframe, asked.anchor, between.inverse())
        };
        better.then(|| loop_of(from, to, &between, compared))
    }
}

fn loop_of(
    from: KeyframeId,
    to: KeyframeId,
    way: &UncertainPose,
    compared: &ComparisonResult,
) -> VerifiedPair {
    let compared = ComparisonResult { pose: way.pose, information: way.information(), ..*compared };
    VerifiedPair::new(from, to, &compared)
}

/// Share of what is seen now, from where `now_from_old` says, that an old keyframe saw too.
fn covered(old: &KeyframeCloud, now: &KeyframeCloud, now_from_old: &Isometry) -> f64 {
    let old_from_now = now_from_old.inverse();
    let turn = old_from_now.rotation.to_rotation_matrix().into_inner().map(|v| v as f32);
    let shift = old_from_now.translation.vector.map(|v| v as f32);
    let stride = now.points().len().div_ceil(POINTS).max(1);
    let (mut seen, mut asked) = (0_usize, 0_usize);
    for point in now.points().step_by(stride) {
        let moved = turn * nalgebra::Vector3::from(point) + shift;
        asked += 1;
        seen += usize::from(old.view().observes(&[moved.x, moved.y, moved.z]));
    }
    seen as f64 / asked.max(1) as f64
}

#[cfg(test)]
#[path = "revisits_tests.rs"]
mod tests;
