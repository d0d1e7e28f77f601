//! A saved map as the stack takes it to go on from, and the search for the robot's place in it.

use crate::PoseGraph;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use vocab::{KeyframeId, MapId, Pose, SessionId, Vec3};

/// A saved map, but for its full clouds: some 40 kB a keyframe. It is part of the log, so that a replay needs no other file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PriorMap {
    /// Which version.
    pub map: MapId,
    /// Its graph. Keyframes are numbered from 0.
    pub graph: PoseGraph,
    /// What each keyframe saw, in their order.
    pub places: Vec<PriorKeyframe>,
}

/// What a keyframe saw, small enough to keep in memory and large enough to be recognised by.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PriorKeyframe {
    /// Where the LiDAR was, keyframe's frame, metres.
    pub lidar: [f32; 3],
    /// Its thinned cloud, keyframe's frame, in steps of 2 mm.
    pub points: Arc<[[i16; 3]]>,
    /// Nearest range in each direction, centimetres; 0 where nothing returned.
    pub ranges: Arc<[u16]>,
    /// As it looks from the base and from both sides: greatest heights and filled slices of polar bins.
    pub views: [[Vec<u8>; 2]; 3],
}

/// A question to a known map: where may this scan have been taken? What the work needs besides lies with the stack, see
/// `Stack::take_compute_job`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RelocalisationTask {
    /// Where the robot is looked for.
    pub map: MapId,
    /// Number of the question.
    pub number: u64,
}

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RelocalisationResponse {
    /// What was asked.
    pub task: RelocalisationTask,
    /// Places, the best first.
    pub hypotheses: Vec<PoseHypothesis>,
}

/// A place where a scan may have been taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseHypothesis {
    /// The base when the scan was taken.
    pub map_from_base: Pose,
    /// How well the scan fits the known surfaces there, 0 to 1.
    pub fit: f64,
    /// Share of its points that stand where the map's keyframes saw through.
    pub violation_share: f64,
}

/// A question to a known map: which way to walk so that places that look alike turn out to be different? As for [`RelocalisationTask`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DisambiguationTask {
    /// Where the robot is looked for.
    pub map: MapId,
    /// Number of the question.
    pub number: u64,
}

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DisambiguationPlan {
    /// What was asked.
    pub task: DisambiguationTask,
    /// Odometry's frame, metres; empty where no way would tell.
    pub path: Vec<Vec3>,
}

/// A search for the robot's place in a known map. What the work needs besides lies with the stack, see `Stack::take_compute_job`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapSearchTask {
    /// The mapping session.
    pub session: SessionId,
    /// Where it is looked for.
    pub map: MapId,
    /// Number of the newest waypoint, counted along the walk.
    pub waypoint: u64,
}

/// What came of a search.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapSearchResult {
    /// What was asked.
    pub task: MapSearchTask,
    /// What was found.
    pub found: MapSearchOutcome,
}

/// What was found of the robot's place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum MapSearchOutcome {
    /// There.
    Found {
        /// Keyframe of the known map.
        keyframe: KeyframeId,
        /// Number of the waypoint that was found.
        waypoint: u64,
        /// Base at that waypoint in the keyframe.
        keyframe_from_base: Pose,
        /// Information (inverse covariance) of that pose, `[rotation; translation]`.
        information: [[f64; 6]; 6],
        /// Places recognised that agree on it.
        places: u32,
        /// Places that agree on the best other way.
        elsewhere: u32,
    },
    /// Too few places were recognised that agree, or all in one spot; this many.
    NotFound(u32),
    /// It fits in two ways, with so many places each.
    Ambiguous(u32, u32),
}
