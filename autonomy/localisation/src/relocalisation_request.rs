//! A request to find the pose of one scan in the map.
//!
//! The search takes a tenth of a second or more, so it is a job. The request provides the data of the job, and the result arrives as an input.

use crate::global_localiser::{GlobalLocaliser, PosePrior};
use crate::pose_hypothesis::PoseHypothesis;
use crate::request_progress::RequestProgress;
use geometry::{Isometry, Rotation, so3};
use mapping::KeyframeDescriptor;
use std::sync::Arc;
use vocab::{Span, Stamp};

/// Conditions for repeating a request that found no pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelocalisationRequestConfig {
    /// After this distance, metres. Chosen: a scan from there gives new information ([`MultiHypothesisConfig::update_distance_m`](crate::MultiHypothesisConfig) is about
    /// as far).
    pub retry_distance_m: f64,
    /// Or after this rotation, radians. Chosen as a round number, 30 degrees: less repeats a search that fails again, more leaves the robot without its pose for longer.
    pub retry_angle_rad: f64,
    /// Or after this time. Chosen: people have moved; a search takes a fifth of a second of another thread.
    pub retry_after: Span,
}

impl Default for RelocalisationRequestConfig {
    fn default() -> Self {
        Self { retry_distance_m: 0.5, retry_angle_rad: 0.5, retry_after: Span::from_millis(2_000) }
    }
}

/// The scan whose pose is requested: what its descriptor is computed of. That takes as long as tracking a scan, so the job does it.
#[derive(Clone, Debug)]
pub(crate) struct QueryScan {
    /// Motion-corrected points, base frame, metres.
    pub points: Arc<[[f32; 3]]>,
    /// Attitude of the base in odometry's frame.
    pub rotation: Rotation,
    /// Position of the LiDAR, base frame, metres.
    pub sensor: [f32; 3],
}

/// A request, from its creation until the next one is created.
#[derive(Debug)]
pub(crate) struct RelocalisationRequest {
    pub id: u64,
    /// Of the scan.
    pub stamp: Stamp,
    /// Pose by odometry at the scan.
    pub odom_from_base: Isometry,
    pub prior: PosePrior,
    scan: QueryScan,
    progress: RequestProgress,
}

impl RelocalisationRequest {
    /// A request for this scan.
    pub fn new(id: u64, stamp: Stamp, odom_from_base: Isometry, scan: QueryScan, prior: PosePrior) -> Self {
        Self { id, stamp, odom_from_base, prior, scan, progress: RequestProgress::default() }
    }

    /// Whether it has been answered and the next one is due.
    pub fn is_stale(
        &self,
        config: &RelocalisationRequestConfig,
        at: Stamp,
        odom_from_base: &Isometry,
    ) -> bool {
        let motion = self.odom_from_base.inverse() * odom_from_base;
        let has_moved = motion.translation.vector.norm() >= config.retry_distance_m
            || so3::log(&motion.rotation).norm() >= config.retry_angle_rad;
        self.progress == RequestProgress::Done && (has_moved || at - self.stamp >= config.retry_after)
    }

    /// Starts with this job. Returns false if it was started before.
    pub fn start(&mut self, job: u64) -> bool {
        self.progress.start(job)
    }

    /// Whether it has not been answered.
    pub fn is_open(&self) -> bool {
        self.progress != RequestProgress::Done
    }

    /// Whether this job answers it.
    pub fn is_answered_by(&self, job: u64) -> bool {
        self.progress.is_running(job)
    }

    /// Its job has ended.
    pub fn finish(&mut self) {
        self.progress = RequestProgress::Done;
    }

    /// The data of its job.
    pub fn work(&self, localiser: &Arc<GlobalLocaliser>) -> RelocalisationWork {
        RelocalisationWork {
            id: self.id,
            localiser: Arc::clone(localiser),
            scan: self.scan.clone(),
            prior: self.prior.clone(),
        }
    }
}

/// A search for the pose of a scan, with all its data.
#[derive(Debug)]
pub struct RelocalisationWork {
    id: u64,
    localiser: Arc<GlobalLocaliser>,
    scan: QueryScan,
    prior: PosePrior,
}

impl RelocalisationWork {
    /// Id of the request.
    pub fn id(&self) -> u64 {
        self.id
    }

    /// Poses at which the scan may have been taken, the best first, see [`GlobalLocaliser::find_poses_with_prior`]: a pure function of what it
    /// owns.
    pub fn run(&self) -> Vec<PoseHypothesis> {
        let QueryScan { points, rotation, sensor } = &self.scan;
        let descriptor = KeyframeDescriptor::of_cloud(points, rotation, *sensor);
        self.localiser.find_poses_with_prior(&descriptor, rotation, &self.prior)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::at;

    #[test]
    fn a_request_is_repeated_only_after_its_answer_and_by_distance_rotation_or_time() {
        let config = RelocalisationRequestConfig::default();
        let (pose, start) = (at(4.0, 6.0, 0.0), Stamp::from_parts(10, 0));
        let scan = QueryScan { points: [[0.0; 3]].into(), rotation: pose.rotation, sensor: [0.0; 3] };
        let mut request = RelocalisationRequest::new(1, start, pose, scan, PosePrior::None);
        let soon = start + Span::from_millis(100);
        assert!(request.is_open() && !request.is_stale(&config, soon, &at(9.0, 6.0, 0.0)));
        assert!(request.start(4) && request.is_answered_by(4) && !request.start(5));
        assert!(!request.is_stale(&config, soon, &at(9.0, 6.0, 0.0)), "its job runs");
        request.finish();
        assert!(!request.is_open() && !request.is_answered_by(4));
        assert!(!request.is_stale(&config, soon, &at(4.4, 6.0, 0.4)));
        assert!(request.is_stale(&config, soon, &at(4.5, 6.0, 0.0)));
        assert!(request.is_stale(&config, soon, &at(4.0, 6.0, -0.51)));
        assert!(request.is_stale(&config, start + Span::from_millis(2_000), &pose));
    }
}
