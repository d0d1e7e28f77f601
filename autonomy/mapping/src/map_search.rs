//! Search for the robot's pose in a finished map that a session extends (docs/maths/loops.md, section 9).
//!
//! Nothing is known about the robot's pose, except that it is upright and somewhere in the map. The waypoints since the start are kept, and after
//! every other metre they are searched in the map as a whole, see [`MapMatcher::locate`]. That takes a job. The result is used only if enough of
//! the walk is recognised, and in one place only.

use crate::UncertainPose;
use crate::keyframe_descriptor::KeyframeDescriptor;
use crate::map_matcher::{AlignmentError, MapAlignment, MapMatcher};
use crate::verification::VerificationConfig;
use geometry::Isometry;
use points::Downsampler;
use std::collections::VecDeque;
use vocab::KeyframeId;

/// Parameters of [`MapSearch`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapSearchConfig {
    /// Distance walked before the first search, metres. Less is rarely enough to be recognised. Chosen: the extent that links have to have
    /// ([`MapMatcherConfig::min_extent_m`](crate::MapMatcherConfig)).
    pub first_search_m: f64,
    /// Distance walked between searches, metres. Chosen: each search adds one query ([`MapMatcherConfig::query_spacing_m`](crate::MapMatcherConfig)).
    pub search_spacing_m: f64,
    /// Greatest number of waypoints that are searched, the newest ones. A metre and 40 kB each. Chosen: five times the first search, 2.4 MB.
    pub max_waypoints: usize,
    /// What a comparison must pass.
    pub verification: VerificationConfig,
}

impl Default for MapSearchConfig {
    fn default() -> Self {
        Self {
            first_search_m: 12.0,
            search_spacing_m: 2.0,
            max_waypoints: 60,
            verification: VerificationConfig::default(),
        }
    }
}

/// A search that continues until the robot is found.
#[derive(Debug)]
pub struct MapSearch {
    config: MapSearchConfig,
    matcher: MapMatcher,
    /// The newest waypoints, in the odometry's frame.
    waypoints: VecDeque<(Isometry, KeyframeDescriptor)>,
    /// Number of the first of them.
    first: u64,
    distance_m: f64,
    /// Distance at which the next search starts, metres.
    next_search_m: f64,
    running_job: Option<u64>,
    is_ambiguous: bool,
    downsampler: Downsampler,
}

/// Pose of a waypoint in a keyframe of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapSearchFix {
    /// Number of the waypoint.
    pub waypoint: u64,
    /// The keyframe.
    pub keyframe: KeyframeId,
    /// Pose of the waypoint in it.
    pub keyframe_from_waypoint: UncertainPose,
}

/// The data of one search.
#[derive(Debug)]
pub struct MapSearchData {
    matcher: MapMatcher,
    walk: MapMatcher,
    first: u64,
    verification: VerificationConfig,
}

impl MapSearchData {
    /// Searches: a pure function of the data. Makes three or more comparisons for every other metre walked, 5 to 25 ms each. Returns the alignment,
    /// whose links give the pose of waypoints, and the number of the waypoint that is numbered 0 in it.
    ///
    /// # Errors
    /// When too little is recognised, or it fits in several places.
    pub fn run(mut self) -> Result<(MapAlignment, u64), AlignmentError> {
        let alignment = self.matcher.locate(&mut self.walk, &self.verification)?;
        Ok((alignment, self.first))
    }
}

impl MapSearch {
    /// In the map of `matcher`.
    pub fn new(config: MapSearchConfig, matcher: MapMatcher) -> Self {
        Self {
            config,
            matcher,
            waypoints: VecDeque::new(),
            first: 0,
            distance_m: 0.0,
            next_search_m: config.first_search_m,
            running_job: None,
            is_ambiguous: false,
            downsampler: Downsampler::default(),
        }
    }

    /// Distance walked since the start, metres.
    pub fn distance_m(&self) -> f64 {
        self.distance_m
    }

    /// Whether the walk so far fits in two places.
    pub fn is_ambiguous(&self) -> bool {
        self.is_ambiguous
    }

    /// Number of the newest waypoint; 0 before the first.
    pub fn newest_waypoint(&self) -> u64 {
        (self.first + self.waypoints.len() as u64).saturating_sub(1)
    }

    /// Adds the next waypoint with its cloud (base frame, metres), measured from `sensor` (base frame, metres).
    pub fn add_waypoint(
        &mut self,
        number: u64,
        odom_from_base: &Isometry,
        xyz: &[[f32; 3]],
        sensor: [f32; 3],
    ) {
        if let Some((last, _)) = self.waypoints.back() {
            self.distance_m += (odom_from_base.translation.vector - last.translation.vector).norm();
        }
        let descriptor =
            KeyframeDescriptor::new(xyz, &odom_from_base.rotation, sensor, &mut self.downsampler);
        self.waypoints.push_back((*odom_from_base, descriptor));
        if self.waypoints.len() > self.config.max_waypoints {
            self.waypoints.pop_front();
        }
        self.first = (number + 1).saturating_sub(self.waypoints.len() as u64);
    }

    /// Starts a search as the job `next_job`, if one is due. Returns the job.
    pub fn start(&mut self, next_job: &mut u64) -> Option<u64> {
        if self.running_job.is_some() || self.distance_m < self.next_search_m {
            return None;
        }
        self.next_search_m = self.distance_m + self.config.search_spacing_m;
        self.running_job = Some(*next_job);
        *next_job += 1;
        self.running_job
    }

    /// The data of a job.
    pub fn data(&self, job: u64) -> Option<MapSearchData> {
        (self.running_job == Some(job)).then(|| {
            let mut walk = MapMatcher::default();
            for (pose, descriptor) in &self.waypoints {
                walk.push(pose, descriptor.clone());
            }
            let (matcher, verification) = (self.matcher.clone(), self.config.verification);
            MapSearchData { matcher, walk, first: self.first, verification }
        })
    }

    /// A job has ended, whether the robot was found in two places or not. Returns whether it was this search's job.
    pub fn end(&mut self, job: u64, is_ambiguous: Option<bool>) -> bool {
        let is_own = self.running_job == Some(job);
        if is_own {
            self.running_job = None;
            self.is_ambiguous = is_ambiguous.unwrap_or(self.is_ambiguous);
        }
        is_own
    }
}
