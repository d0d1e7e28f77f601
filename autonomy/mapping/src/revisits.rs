//! Known ground: on a repeated walk, the robot's pose is found among old keyframes, and no new keyframes are added. The graph then grows with the
//! size of the site and not with time (docs/maths/loops.md, section 7).
//!
//! The robot's pose is that of an anchor, which is a keyframe, plus the odometry since then. A waypoint near an old keyframe that saw most of the
//! current scan is a revisit. Its scan is not stored. Every few metres a revisit is compared with that keyframe, and the result makes it the anchor.
//! If the comparison knows the relative pose of both anchors better than the graph does, it becomes a loop between them. Where the ground is unknown,
//! or no comparison has succeeded for some metres, waypoints become keyframes. Source of the idea: Johannsson et al., *Temporally scalable visual
//! SLAM using a reduced pose graph*, ICRA 2013.

use crate::UncertainPose;
use crate::verification::{Comparison, VerificationTask, VerifiedPair};
use geometry::Isometry;
use std::collections::VecDeque;
use vocab::{KeyframeId, Stamp};

/// Parameters of revisits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RevisitConfig {
    /// A keyframe of recent travel covers a waypoint within this distance, metres. Less than the distance between two keyframes. Chosen: a little less than a metre.
    pub recent_radius_m: f64,
    /// An old keyframe covers a waypoint within this distance, metres. It is greater, because the robot may walk in another lane. Chosen: lanes of a corridor are no
    /// farther apart.
    pub old_radius_m: f64,
    /// Greatest height difference of a keyframe that covers a waypoint, metres: some steps of a flight of stairs. Chosen: less than half a storey, so that no other floor
    /// counts.
    pub max_height_m: f64,
    /// Least share of the current scan that the keyframe saw too. It is 0.65 to 0.95 at a distance of a metre, and below 0.3 behind a wall. Chosen between them.
    pub min_covered_share: f64,
    /// Number of points of the scan that are tested for that. Chosen: a share is then known to 0.03 (binomial standard deviation).
    pub tested_points: usize,
    /// Number of keyframes that are tested for that, nearest first. Chosen: a wall may hide the nearest one; the time is in proportion.
    pub tested_keyframes: usize,
    /// Distance after the last keyframe or confirmed revisit within which ground counts as known, metres. Chosen: three comparisons, one every 2 m, may fail.
    pub max_unconfirmed_m: f64,
    /// Greatest number of comparisons that are pending; beyond it the oldest is dropped. Chosen: 16 m of walk at one every 2 m, longer than comparisons take.
    pub max_pending: usize,
    /// Factor of the covariance of a comparison. It serves two edges, the one that leads to the anchor and the one that leads away from it, so each
    /// gets half of its information. Source: two edges share one measurement (docs/maths/loops.md, section 7).
    pub shared_covariance: f64,
}

impl Default for RevisitConfig {
    fn default() -> Self {
        Self {
            recent_radius_m: 0.95,
            old_radius_m: 1.5,
            max_height_m: 0.5,
            min_covered_share: 0.6,
            tested_points: 300,
            tested_keyframes: 3,
            max_unconfirmed_m: 6.0,
            max_pending: 8,
            shared_covariance: 2.0,
        }
    }
}

/// Kind of a waypoint.
#[derive(Clone, Debug)]
pub enum Novelty {
    /// A keyframe.
    Keyframe {
        /// Its number. The graph contains it already.
        id: KeyframeId,
        /// Pairs to verify, as from [`LoopFinder::add_keyframe`](crate::LoopFinder::add_keyframe).
        tasks: Vec<VerificationTask>,
    },
    /// A revisit of known ground, with a comparison if one is due.
    Revisit(Option<Revisit>),
    /// A point of a finished map, with the number of the waypoint. [`LoopFinder::localise_in_map`](crate::LoopFinder::localise_in_map) has not been
    /// called yet.
    Unlocalised(u64),
}

/// A revisit to be compared.
#[derive(Clone, Debug)]
pub struct Revisit {
    /// Number of the waypoint.
    pub waypoint: u64,
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// The data of the comparison; the keyframe is the older place.
    pub comparison: Comparison,
}

/// Outcome of a comparison of a revisit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RevisitResult {
    /// The robot is not where it was expected, or the comparison failed. Nothing changes.
    Rejected,
    /// The pose is confirmed but not improved, or a newer result has arrived before.
    Confirmed,
    /// The keyframe is the new anchor.
    Reanchored(Reanchoring),
    /// The walk has left known ground since. This is the pose of its first keyframe there in the revisited one, as a loop to be evaluated.
    Loop(VerifiedPair),
}

/// A new anchor of the robot's pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reanchoring {
    /// Stamp of the revisit. The pose is corrected from then on.
    pub since: Stamp,
    /// The new anchor.
    pub anchor: KeyframeId,
    /// Pose of the newest waypoint in it.
    pub anchor_from_waypoint: Isometry,
    /// A loop between the old anchor and the new one that is known better than in the graph.
    pub edge: Option<VerifiedPair>,
}

/// The robot's pose in the graph, and the pending comparisons.
#[derive(Clone, Debug, Default)]
pub(crate) struct Revisits {
    pub position: Option<AnchoredPose>,
    /// Waypoint of the last keyframe.
    pub last_keyframe: u64,
    /// The last keyframe, and the pose in it by odometry alone.
    pub by_odometry: Option<(KeyframeId, UncertainPose)>,
    pub pending: VecDeque<PendingRevisit>,
}

/// The robot's pose relative to a keyframe.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AnchoredPose {
    pub anchor: KeyframeId,
    /// Pose of the newest waypoint in the anchor.
    pub anchor_from_waypoint: UncertainPose,
    /// Waypoint at which the anchor was set.
    pub since: u64,
    /// Whether that waypoint is the anchor itself, and not a revisit of it.
    pub at_anchor: bool,
    /// Distance walked since the last keyframe or confirmed revisit, metres.
    pub unconfirmed_m: f64,
    /// Distance walked since the last comparison was asked for, metres.
    pub uncompared_m: f64,
}

/// A revisit whose comparison has not ended yet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PendingRevisit {
    pub waypoint: u64,
    pub stamp: Stamp,
    pub keyframe: KeyframeId,
    /// Pose of the revisit in the keyframe, as expected then.
    pub expected: UncertainPose,
    /// The anchor then.
    pub anchor: KeyframeId,
    pub anchor_from_revisit: UncertainPose,
    /// Number of keyframes then.
    pub keyframes: usize,
}

impl Revisits {
    /// A waypoint became a keyframe: it is the anchor now.
    pub fn anchor_at(&mut self, anchor: KeyframeId, waypoint: u64) {
        let identity = UncertainPose::identity();
        self.position = Some(AnchoredPose {
            anchor,
            anchor_from_waypoint: identity,
            since: waypoint,
            at_anchor: true,
            unconfirmed_m: 0.0,
            uncompared_m: 0.0,
        });
        self.last_keyframe = waypoint;
        self.by_odometry = Some((anchor, identity));
    }

    /// A loop was removed on which the pose may depend: the pose is relative to the last keyframe again, pending comparisons are dropped, and the next
    /// waypoint becomes a keyframe.
    pub fn reset_to_odometry(&mut self) {
        self.pending.clear();
        if let (Some(position), Some((anchor, pose))) = (&mut self.position, self.by_odometry) {
            (position.anchor, position.anchor_from_waypoint, position.at_anchor) = (anchor, pose, false);
            position.unconfirmed_m = f64::INFINITY;
        }
    }
}
