//! Saved maps as the stack uses them, to localise in or to extend, and the jobs that search them for the robot's pose.
//!
//! What such a job needs besides its task stays with the stack until it is fetched with `Stack::take_compute_job`.

use crate::PoseGraph;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use vocab::{KeyframeId, MapId, Pose, SessionId, Vec3};

/// A saved map without its full clouds: some 40 kB a keyframe. It is part of the log, so that a replay needs no other file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PriorMap {
    /// The map's version.
    pub map: MapId,
    /// Its pose graph. Keyframes are numbered from 0.
    pub graph: PoseGraph,
    /// What is kept of each keyframe's scan, in their order.
    pub keyframes: Vec<PriorKeyframe>,
}

/// What is kept of a keyframe's scan: small enough for memory and large enough to recognise the place by.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PriorKeyframe {
    /// Position of the LiDAR, keyframe's frame, metres.
    pub lidar: [f32; 3],
    /// The thinned cloud, keyframe's frame, in steps of 2 mm.
    pub points: Arc<[[i16; 3]]>,
    /// Nearest range in each direction, centimetres; 0 where nothing returned.
    pub ranges: Arc<[u16]>,
    /// Appearance descriptors from the base and from both sides: greatest heights and filled slices of polar bins.
    pub views: [[Vec<u8>; 2]; 3],
}

/// A job: at which poses of a map may a scan have been taken?
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RelocalisationTask {
    /// The map.
    pub map: MapId,
    /// Number of the request.
    pub number: u64,
}

/// The result of a [`RelocalisationTask`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RelocalisationResponse {
    /// The task.
    pub task: RelocalisationTask,
    /// Poses, the best first.
    pub hypotheses: Vec<PoseHypothesis>,
}

/// A pose at which a scan may have been taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseHypothesis {
    /// Pose of the base in the map.
    pub map_from_base: Pose,
    /// How well the scan fits the map's surfaces there, 0 to 1.
    pub fit: f64,
    /// Share of the points inside the keyframes' view that lie where the keyframes saw free space.
    pub violation_share: f64,
}

/// A job: on which path can the robot find out which of the possible poses is right?
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DisambiguationTask {
    /// The map.
    pub map: MapId,
    /// Number of the request.
    pub number: u64,
}

/// The result of a [`DisambiguationTask`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DisambiguationPlan {
    /// The task.
    pub task: DisambiguationTask,
    /// Positions of the base, odometry's frame, metres; empty if there is no such path.
    pub path: Vec<Vec3>,
}

/// A job: where in a map that a session extends has the robot walked?
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapSearchTask {
    /// The mapping session.
    pub session: SessionId,
    /// The map.
    pub map: MapId,
    /// Number of the newest waypoint, counted along the walk.
    pub waypoint: u64,
}

/// The result of a [`MapSearchTask`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapSearchResult {
    /// The task.
    pub task: MapSearchTask,
    /// What was found.
    pub found: MapSearchOutcome,
}

/// What a search for the walk in a map has found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum MapSearchOutcome {
    /// One alignment.
    Found {
        /// A keyframe of the map.
        keyframe: KeyframeId,
        /// Number of the waypoint that was recognised there.
        waypoint: u64,
        /// Pose of the base at that waypoint in the keyframe.
        keyframe_from_base: Pose,
        /// Information (inverse covariance) of that pose, `[rotation; translation]`.
        information: [[f64; 6]; 6],
        /// Number of recognised places that agree on the alignment.
        support: u32,
        /// Number of recognised places that agree on the best other alignment.
        runner_up_support: u32,
    },
    /// Too few recognised places agree, or all of them lie close together; their number.
    NotFound(u32),
    /// Two alignments fit; the number of recognised places that agree on each.
    Ambiguous(u32, u32),
}
