//! Sensor messages, already parsed: points that are not finite never get here.

use serde::{Deserialize, Serialize};
use std::sync::Arc;
use vocab::{Pose, Stamp, Twist, Vec3};

/// One message from a sensor or robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Sensor {
    /// One LiDAR sweep.
    Scan(Arc<Scan>),
    /// One inertial sample.
    Imu(ImuSample),
    /// Velocity measured by the legs (or wheels).
    Legs(LegOdometry),
    /// A pose from another odometry (visual, vendor), drifting but smooth.
    Odometry(ExternalOdometry),
    /// State of the battery.
    Battery(BatteryState),
}

impl Sensor {
    /// When it was measured: for a scan, the reference time of the sweep.
    pub fn stamp(&self) -> Stamp {
        match self {
            Self::Scan(scan) => scan.stamp,
            Self::Imu(sample) => sample.stamp,
            Self::Legs(legs) => legs.stamp,
            Self::Odometry(odometry) => odometry.stamp,
            Self::Battery(battery) => battery.stamp,
        }
    }
}

/// One LiDAR sweep in the LiDAR's own frame, as parallel columns. Optional columns are empty or of full length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scan {
    /// The instant to which `offset_ns` 0 refers; usually the start of the sweep.
    pub stamp: Stamp,
    /// Positions in the LiDAR frame, metres, finite.
    pub xyz: Vec<[f32; 3]>,
    /// Return strength in the sensor's own units (0 to 255 for most), or empty.
    pub intensity: Vec<f32>,
    /// When each point was measured, nanoseconds after (or before) `stamp`, or empty when the sensor does not say.
    pub offset_ns: Vec<i32>,
    /// Channel of each point, counted from 0, or empty.
    pub ring: Vec<u16>,
}

/// One inertial sample in the IMU's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ImuSample {
    /// When it was measured.
    pub stamp: Stamp,
    /// Angular velocity, rad/s.
    pub angular_velocity: Vec3,
    /// Specific force (what an accelerometer reads: +9.81 m/s² upwards at rest), m/s².
    pub specific_force: Vec3,
}

/// What the legs say of the body's motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LegOdometry {
    /// When it was measured.
    pub stamp: Stamp,
    /// Velocity of the base in its own frame. Only the linear part is trusted for odometry.
    pub base_velocity: Twist,
    /// Integrated pose as the robot reports it; drifts.
    pub odom_from_base: Pose,
}

/// A pose from another odometry, of the frame named by the boot record's `base_from_external`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ExternalOdometry {
    /// When it was measured.
    pub stamp: Stamp,
    /// Pose in that odometry's own origin; drifts.
    pub odom_from_external: Pose,
}

/// State of the battery.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BatteryState {
    /// When it was measured.
    pub stamp: Stamp,
    /// Charge, 0 to 1.
    pub charge: f32,
    /// Terminal voltage, V.
    pub voltage_v: f32,
    /// Current, A; negative while discharging.
    pub current_a: f32,
    /// Whether the dock charges it now.
    pub charging: bool,
}
