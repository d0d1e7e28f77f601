//! Configuration of the odometry: which sensors there are, where they are mounted, and the parameters of its algorithms.

use crate::filter::FilterConfig;
use crate::imu_lidar_consistency::ConsistencyConfig;
use crate::imu_queue::ImuQueueConfig;
use crate::initial_alignment::InitialAlignmentConfig;
use crate::local_map::LocalMapConfig;
use crate::odometry::SynchronisationConfig;
use crate::pickup_detector::PickupConfig;
use crate::reinitialiser::ReinitialiserConfig;
use crate::scan_tracker::TrackingConfig;
use crate::state_propagator::PropagationConfig;
use geometry::{Base, External, Imu, Lidar, Transform};
use vocab::{Aabb, Pose};

/// Sources that may be used. Messages of the others are ignored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the fields are the sources")]
pub struct Sources {
    pub lidar: bool,
    pub imu: bool,
    pub legs: bool,
    pub external: bool,
}

impl Default for Sources {
    fn default() -> Self {
        Self { lidar: true, imu: true, legs: true, external: true }
    }
}

/// Poses of the sensors on the base (x forward, y left, z up).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    /// Pose of the LiDAR.
    pub base_from_lidar: Transform<Base, Lidar>,
    /// Pose of the IMU.
    pub base_from_imu: Transform<Base, Imu>,
    /// Pose of the frame whose motion the external odometry reports.
    pub base_from_external: Transform<Base, External>,
}

impl Default for Mounting {
    /// All sensors at the base.
    fn default() -> Self {
        Self {
            base_from_lidar: Transform::identity(),
            base_from_imu: Transform::identity(),
            base_from_external: Transform::identity(),
        }
    }
}

impl Mounting {
    /// From the plain poses of a boot record. A pose that is missing or invalid is replaced by the base's.
    pub fn from_poses(
        base_from_lidar: Option<&Pose>,
        base_from_imu: Option<&Pose>,
        base_from_external: Option<&Pose>,
    ) -> Self {
        let isometry = |pose: Option<&Pose>| pose.and_then(geometry::isometry_from_pose).unwrap_or_default();
        Self {
            base_from_lidar: Transform::new(isometry(base_from_lidar)),
            base_from_imu: Transform::new(isometry(base_from_imu)),
            base_from_external: Transform::new(isometry(base_from_external)),
        }
    }
}

/// Configuration of an [`Odometry`](crate::Odometry).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryConfig {
    /// Sources that may be used.
    pub sources: Sources,
    /// Poses of the sensors.
    pub mounting: Mounting,
    /// Points nearer to the LiDAR than this are dropped, metres.
    pub min_range_m: f32,
    /// Points farther from the LiDAR than this are dropped, metres.
    pub max_range_m: f32,
    /// Box around the robot's own body, base frame, metres. Points inside are dropped (self-filter).
    pub self_filter: Option<Aabb>,
    /// Waiting for messages and detection of silent sources.
    pub synchronisation: SynchronisationConfig,
    /// Limits of the IMU's readings.
    pub imu_queue: ImuQueueConfig,
    /// Gravity, gyroscope bias and uncertainty at the start.
    pub initial_alignment: InitialAlignmentConfig,
    /// Noise of the sensors and the error-state filter.
    pub filter: FilterConfig,
    /// Propagation between scans.
    pub propagation: PropagationConfig,
    /// Detection of a robot that is carried.
    pub pickup: PickupConfig,
    /// Comparison of the rotations of IMU and LiDAR.
    pub consistency: ConsistencyConfig,
    /// Local map and registration.
    pub local_map: LocalMapConfig,
    /// Acceptance of scans and loss of tracking.
    pub tracking: TrackingConfig,
    /// Search for the pose after a gap.
    pub reinitialiser: ReinitialiserConfig,
}

impl Default for OdometryConfig {
    fn default() -> Self {
        Self {
            sources: Sources::default(),
            mounting: Mounting::default(),
            min_range_m: 0.4,
            max_range_m: 120.0,
            self_filter: None,
            synchronisation: SynchronisationConfig::default(),
            imu_queue: ImuQueueConfig::default(),
            initial_alignment: InitialAlignmentConfig::default(),
            filter: FilterConfig::default(),
            propagation: PropagationConfig::default(),
            pickup: PickupConfig::default(),
            consistency: ConsistencyConfig::default(),
            local_map: LocalMapConfig::default(),
            tracking: TrackingConfig::default(),
            reinitialiser: ReinitialiserConfig::default(),
        }
    }
}
