//! What the odometry is told before it starts.

use geometry::Isometry;
use points::GaussianMapConfig;
use vocab::{Aabb, Pose};

/// Which sources may be used; whatever is off is ignored when it speaks.
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

/// Where the sensors sit on the base (x forward, y left, z up).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    /// LiDAR in the base.
    pub base_from_lidar: Isometry,
    /// IMU in the base.
    pub base_from_imu: Isometry,
    /// Frame of the external odometry in the base.
    pub base_from_external: Isometry,
}

impl Default for Mounting {
    fn default() -> Self {
        let here = Isometry::identity();
        Self { base_from_lidar: here, base_from_imu: here, base_from_external: here }
    }
}

impl Mounting {
    /// From the plain poses of a boot record; what is missing or not a pose is taken to be at the base.
    pub fn from_poses(
        base_from_lidar: Option<&Pose>,
        base_from_imu: Option<&Pose>,
        base_from_external: Option<&Pose>,
    ) -> Self {
        let place = |pose: Option<&Pose>| pose.and_then(geometry::isometry_from_pose).unwrap_or_default();
        Self {
            base_from_lidar: place(base_from_lidar),
            base_from_imu: place(base_from_imu),
            base_from_external: place(base_from_external),
        }
    }
}

/// How far each source can be trusted. Densities are per square root of a second (or hertz).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseConfig {
    /// Gyroscope, rad/s/√Hz. Larger than a datasheet's: timing and vibration come on top.
    pub gyro: f64,
    /// Accelerometer, m/s²/√Hz.
    pub accel: f64,
    /// Walk of the gyroscope's bias, rad/s/√s.
    pub gyro_walk: f64,
    /// Walk of the accelerometer's bias, m/s²/√s.
    pub accel_walk: f64,
    /// Velocity of the legs while the robot walks, m/s; neighbours in time are treated as independent.
    pub legs: f64,
    /// External odometry: share of the turn and of the distance of one second that is wrong, 1/√s. Its clock may lag.
    pub external: f64,
    /// Change of velocity when nothing measures it, m/s/√s.
    pub velocity_walk: f64,
    /// Change of turn rate when nothing measures it, rad/s/√s.
    pub rate_walk: f64,
    /// Range noise and other spread of LiDAR points that the map's cells cannot know, metres.
    pub lidar: f64,
    /// How many LiDAR points share one error (of map, calibration, timing), so count as one.
    pub lidar_correlation: f64,
}

impl Default for NoiseConfig {
    fn default() -> Self {
        Self {
            gyro: 1e-3,
            accel: 2e-2,
            gyro_walk: 3e-5,
            accel_walk: 5e-4,
            legs: 0.1,
            external: 0.14,
            velocity_walk: 1.5,
            rate_walk: 2.0,
            lidar: 0.01,
            lidar_correlation: 10.0,
        }
    }
}

/// Settings of an [`Odometry`](crate::Odometry).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometryConfig {
    /// Which sources may be used.
    pub sources: Sources,
    /// Where they sit.
    pub mounting: Mounting,
    /// Points nearer to the LiDAR than this are dropped, metres.
    pub range_min: f32,
    /// Points farther than this are dropped, metres.
    pub range_max: f32,
    /// The robot's own body in the base frame; points inside are dropped.
    pub hidden: Option<Aabb>,
    /// About so many points of a scan enter registration; the voxel size adapts.
    pub target_points: usize,
    /// How the local map divides space.
    pub map: GaussianMapConfig,
    /// Parts of the local map farther than this are forgotten, metres.
    pub map_radius: f64,
    /// How far each source can be trusted.
    pub noise: NoiseConfig,
}

impl Default for OdometryConfig {
    fn default() -> Self {
        Self {
            sources: Sources::default(),
            mounting: Mounting::default(),
            range_min: 0.4,
            range_max: 120.0,
            hidden: None,
            target_points: 4_000,
            map: GaussianMapConfig::default(),
            map_radius: 100.0,
            noise: NoiseConfig::default(),
        }
    }
}
