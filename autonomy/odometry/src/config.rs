//! Configuration of the odometry: which sensors there are, where they are mounted, and the parameters of its algorithms. This file holds the
//! parameters of the parts that read the whole configuration. The parameters of the other parts are beside their algorithms.

use crate::filter::FilterConfig;
use crate::imu_lidar_consistency::ImuLidarConsistencyConfig;
use crate::imu_queue::ImuQueueConfig;
use crate::initial_alignment::InitialAlignmentConfig;
use crate::local_map::LocalMapConfig;
use crate::pickup_detector::PickupConfig;
use crate::reinitialiser::ReinitialiserConfig;
use crate::sweep::SweepConfig;
use geometry::{Base, External, Imu, Lidar, Transform};
use vocab::{Aabb, Pose, Span};

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

/// Parameters of waiting for messages and of silent sources. All times are differences between stamps; there is no other clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SynchronisationConfig {
    /// Longest time that a scan waits for the other sensors to cover its end. Chosen: two sweeps at 10 Hz; more delays the estimate when a sensor falls silent.
    pub max_wait: Span,
    /// Longest time that the first scan waits for an IMU to send at all. Chosen: twice [`Self::max_wait`], because drivers start one after the other.
    pub max_initial_wait: Span,
    /// A source that has sent nothing for this time is not waited for. Chosen: five periods of a source at 10 Hz.
    pub silent_after: Span,
    /// A source that has sent nothing for this time is reported as silent. Chosen: four times [`Self::silent_after`], so that a pause of the network is not told to
    /// people.
    pub report_silent_after: Span,
    /// Without scans, readings older than this are processed. Chosen: more than the half second between two scans of the slowest LiDARs.
    pub max_backlog: Span,
    /// Age of the newest reading that is processed then. Chosen: longer than [`Self::max_wait`], so that a late scan still finds its readings.
    pub kept_backlog: Span,
    /// Stamps of IMU and LiDAR farther apart than this have no common clock. Chosen: far longer than any delay of a driver.
    pub max_clock_difference: Span,
    /// Number of consecutive scans with such stamps after which the IMU is not used any more. Chosen: a single wrong stamp decides nothing.
    pub clock_mismatches: usize,
    /// An IMU that has sent nothing during more scans than this has stopped. Chosen: 0.3 s at 10 Hz, longer than a pause of a driver.
    pub silent_imu_scans: usize,
    /// Greatest number of waiting scans. If there are more, the oldest is processed without waiting. Chosen: four seconds at 10 Hz; it bounds the memory.
    pub max_waiting_scans: usize,
    /// Greatest number of scans that are processed on one message, which bounds the time that a message takes. More than one, so that waiting scans
    /// also become fewer where no other sensor sends messages. Chosen: the least number with that property.
    pub max_scans_per_message: usize,
}

impl Default for SynchronisationConfig {
    fn default() -> Self {
        Self {
            max_wait: Span::from_millis(200),
            max_initial_wait: Span::from_millis(400),
            silent_after: Span::from_millis(500),
            report_silent_after: Span::from_millis(2_000),
            max_backlog: Span::from_millis(600),
            kept_backlog: Span::from_millis(300),
            max_clock_difference: Span::from_millis(3_000),
            clock_mismatches: 3,
            silent_imu_scans: 3,
            max_waiting_scans: 40,
            max_scans_per_message: 2,
        }
    }
}

/// Parameters of a [`StatePropagator`](crate::state_propagator::StatePropagator).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PropagationConfig {
    /// Standard deviation that is added to the rotation when tracking is lost, radians. The robot may have been carried away. Chosen as a round number, 30 degrees: with
    /// more, loops that put the pose right are worth less; with less, they are rejected.
    pub lost_rotation_rad: f64,
    /// Standard deviation that is added to the position when tracking is lost, metres. Chosen as a round number: a robot is carried some metres.
    pub lost_position_m: f64,
    /// Standard deviation of the gyroscope bias when the IMU sends again after a gap, rad/s. Chosen: twice the deviation of a bias that was found at a standstill.
    pub returned_gyro_bias_rad_s: f64,
    /// Standard deviation of the turn rate when the IMU falls silent, rad/s. Chosen: half of a usual turning speed.
    pub silent_turn_rate_rad_s: f64,
    /// Poses of an external odometry farther apart than this give no twist, seconds. Chosen: longer than a period of an odometry at 1 Hz.
    pub max_external_gap_s: f64,
    /// Half of the usual interval between external poses, seconds. A mean velocity is rotated by the turn of this time, so that it is
    /// in the axes at the end of its interval. Chosen: half a period at 10 Hz.
    pub external_half_interval_s: f64,
    /// Predictions farther ahead than this keep the pose at this time. Chosen: a velocity says little about a pose after a longer time.
    pub max_prediction: Span,
}

impl Default for PropagationConfig {
    fn default() -> Self {
        Self {
            lost_rotation_rad: 0.5,
            lost_position_m: 5.0,
            returned_gyro_bias_rad_s: 2e-3,
            silent_turn_rate_rad_s: 0.5,
            max_external_gap_s: 1.5,
            external_half_interval_s: 0.05,
            max_prediction: Span::from_millis(1_000),
        }
    }
}

/// Parameters of a [`ScanTracker`](crate::scan_tracker::ScanTracker).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackingConfig {
    /// A scan is rejected if fewer of its matched points than this share are inliers and enough of its points are matched. Chosen: people and moved things may hide half
    /// of a scan.
    pub min_inlier_share: f64,
    /// Share of the points that has to be matched before too few inliers reject a scan. Chosen: of fewer, the rest of the scan sees new surfaces.
    pub min_matched_share: f64,
    /// Directions of translation with a larger standard deviation than this are reported as degenerate, metres. Chosen: about three times the noise of a LiDAR.
    pub degenerate_deviation_m: f64,
    /// Poses older than this are removed from the pose table. Chosen: longer than a sweep at 10 Hz and [`SynchronisationConfig::max_wait`] together.
    pub pose_history: Span,
    /// Without an IMU, a sweep is registered in this many parts, so that the estimate can follow the bounce of a walk. Source: docs/maths/odometry.md: it reduced the
    /// error of the LiDAR alone from 46 to 5 mm. More parts see fewer directions each.
    pub sweep_parts: usize,
    /// Without an IMU, this many scans at the start are registered whole, because a part needs a map of everything that it sees. Chosen: 0.8 s at 10 Hz, in which a robot
    /// mostly stands.
    pub first_whole_sweeps: usize,
    /// Without an IMU, each part is corrected and registered this many times. Source: docs/maths/odometry.md; the second pass uses the motion that the first has found.
    pub part_passes: usize,
    /// A part with a lower share of inliers than this share of the typical one is not used; the sweep is then registered whole. In a door, one part
    /// may see only new surfaces and fit at a wrong pose by chance. Chosen nearer to 1 than a whole sweep's, because a part has fewer directions.
    pub min_part_inlier_ratio: f64,
    /// Weight of one sweep in the running mean of the share of inliers. Chosen: twenty sweeps, in which surroundings change.
    pub inlier_share_learning_rate: f64,
    /// Tracking is lost after this time in which scans had points and none fitted. Chosen: longer than people stand close round the robot in passing.
    pub lost_after: Span,
    /// After this time in which no scan entered the map (LiDAR outage), the next scan has to fit as scans usually do, because the robot may be elsewhere. Chosen: ten
    /// scans at 10 Hz. With less, a covered LiDAR for a moment is an outage; with more, a robot that was carried quickly is believed.
    pub outage_after: Span,
    /// After a LiDAR outage, a scan within this many standard deviations of its prediction may fit less well. Chosen: one right prediction in thousands is farther off.
    pub outage_gate_deviations: f64,
    /// After an outage with consistent legs and IMU, a scan is accepted if at most this share of its points is matched, because it sees new surfaces. Chosen: a tenth, so
    /// few that their fit says nothing.
    pub max_new_area_matched_share: f64,
    /// After an outage with consistent legs and IMU, a scan is accepted if this share of its matched points are inliers. Chosen: half, more than
    /// [`Self::min_inlier_share`], because the place has to be recognised.
    pub min_known_area_inlier_share: f64,
    /// A robot on legs that seems to be faster than this is not believed when the estimate begins anew, m/s. Chosen: more than twice the greatest speed by hand of the
    /// default robot, 1.2 m/s.
    pub max_believable_speed_m_s: f64,
    /// Tracking is lost if the estimate is this much faster than the legs for a while, m/s. Chosen: feet slip by less than the greatest speed by hand, 1.2 m/s.
    pub max_speed_above_legs_m_s: f64,
    /// Duration of that while. Chosen: a jump of one scan is no loss.
    pub runaway_after: Span,
    /// Without an IMU, several starts are compared after this time without a scan. Chosen: one and a half sweeps at 10 Hz, so that one scan is missing.
    pub compare_starts_after: Span,
}

impl Default for TrackingConfig {
    fn default() -> Self {
        Self {
            min_inlier_share: 0.35,
            min_matched_share: 0.3,
            degenerate_deviation_m: 0.03,
            pose_history: Span::from_millis(400),
            sweep_parts: 4,
            first_whole_sweeps: 8,
            part_passes: 2,
            min_part_inlier_ratio: 0.85,
            inlier_share_learning_rate: 0.05,
            lost_after: Span::from_millis(3_000),
            outage_after: Span::from_millis(1_000),
            outage_gate_deviations: 4.0,
            max_new_area_matched_share: 0.1,
            min_known_area_inlier_share: 0.5,
            max_believable_speed_m_s: 3.0,
            max_speed_above_legs_m_s: 3.0,
            runaway_after: Span::from_millis(1_000),
            compare_starts_after: Span::from_millis(150),
        }
    }
}

/// Configuration of an [`Odometry`](crate::Odometry).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryConfig {
    /// Sources that may be used. The default is all of them; the caller leaves some out.
    pub sources: Sources,
    /// Poses of the sensors. Given by the boot record.
    pub mounting: Mounting,
    /// Points nearer to the LiDAR than this are dropped, metres. Chosen: about the radius of a robot's footprint, 0.38 m.
    pub min_range_m: f32,
    /// Points farther from the LiDAR than this are dropped, metres. Chosen: the nominal range of an XT-32.
    pub max_range_m: f32,
    /// Box around the robot's own body, base frame, metres. Points inside are dropped (self-filter). It is that of the robot's profile.
    pub self_filter: Option<Aabb>,
    /// Variance of the published pose before the estimate begins, rad² and m². Far larger than that of any estimate. Chosen: a standard deviation of a kilometre.
    pub unknown_pose_variance: f64,
    /// Motion correction.
    pub sweep: SweepConfig,
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
    pub consistency: ImuLidarConsistencyConfig,
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
            unknown_pose_variance: 1e6,
            sweep: SweepConfig::default(),
            synchronisation: SynchronisationConfig::default(),
            imu_queue: ImuQueueConfig::default(),
            initial_alignment: InitialAlignmentConfig::default(),
            filter: FilterConfig::default(),
            propagation: PropagationConfig::default(),
            pickup: PickupConfig::default(),
            consistency: ImuLidarConsistencyConfig::default(),
            local_map: LocalMapConfig::default(),
            tracking: TrackingConfig::default(),
            reinitialiser: ReinitialiserConfig::default(),
        }
    }
}
