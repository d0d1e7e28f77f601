//! What the odometry publishes.

use geometry::{Isometry, Matrix6, Vector3};
use std::sync::Arc;
use vocab::{Span, Stamp};

/// An output of the odometry.
#[derive(Clone, Debug, PartialEq)]
pub enum OdometryEvent {
    /// The direction of gravity is known and the estimate begins, or begins anew after tracking was lost.
    Started(Started),
    /// The pose of the base at the end of a sweep.
    Pose(Box<PoseEvent>),
    /// The motion-corrected sweep of the preceding pose.
    Scan(DeskewedScan),
    /// A fault of a sensor or its setup. Each kind is published once, except lost tracking, which is published every time.
    Finding(Finding),
}

/// The beginning of an estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Started {
    /// First instant of the estimate.
    pub stamp: Stamp,
    /// Measured gravity, m/s², IMU frame, pointing down. Zero without an IMU.
    pub gravity: Vector3,
    /// Bias of the gyroscope, rad/s, IMU frame.
    pub gyro_bias: Vector3,
    /// Whether the robot stood still, so that gravity and bias are measurements and not first guesses.
    pub is_stationary: bool,
}

/// An estimate of the base's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Instant of the estimate.
    pub stamp: Stamp,
    /// Pose of the base in the odometry's frame: z against gravity, origin and heading where the odometry began.
    pub odom_from_base: Isometry,
    /// Velocity of the base, m/s, base frame.
    pub velocity: Vector3,
    /// Turn rate of the base, rad/s, base frame.
    pub turn_rate: Vector3,
    /// Covariance of `odom_from_base`, `[rotation; translation]`, error on the right.
    pub covariance: Matrix6,
    /// The part of `covariance` that was added when tracking was lost. It is the same for every later pose, so it is no
    /// uncertainty of the motion between two later poses.
    pub covariance_inflation: Matrix6,
}

/// The estimate after one scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseEvent {
    /// The estimate at the end of the sweep.
    pub estimate: Estimate,
    /// The scan's own stamp, usually the start of the sweep.
    pub scan_stamp: Stamp,
    /// Pose of the base at the scan's own stamp, from the corrected motion during the sweep.
    pub odom_from_base_at_scan: Isometry,
    /// Directions of translation that the LiDAR does not observe: unit vectors in the base frame, weakest first. The other sources
    /// determine the motion along them.
    pub degenerate_directions: [Option<Vector3>; 3],
    /// Result of the registration.
    pub registration: RegistrationReport,
    /// Whether an IMU measures gravity, so that the tilt of the pose does not drift.
    pub is_gravity_measured: bool,
    /// Whether the scan had too few points or did not fit the map, so that the pose is dead reckoning by the other sources.
    pub is_dead_reckoned: bool,
    /// Bias of the gyroscope, rad/s, IMU frame.
    pub gyro_bias: Vector3,
    /// Bias of the accelerometer, m/s², IMU frame.
    pub accel_bias: Vector3,
    /// Velocity reported by the legs divided by the true velocity.
    pub leg_scale: f64,
}

/// Result of a scan's registration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RegistrationReport {
    /// Points used, after downsampling.
    pub points_used: usize,
    /// Edge of the voxels of the downsampling, metres.
    pub voxel_m: f32,
    /// Points that found a surface in the map in the last iteration.
    pub matched: usize,
    /// Share of the matched points whose residual is less than the kernel width.
    pub inlier_share: f64,
    /// Gauss-Newton iterations.
    pub iterations: usize,
    /// Whether rotated starts were searched because the prediction did not fit.
    pub searched: bool,
    /// Whether the scan was not used because it had too few points or did not fit.
    pub rejected: bool,
}

/// A motion-corrected scan.
#[derive(Clone, Debug, PartialEq)]
pub struct DeskewedScan {
    /// The instant to which all points were moved: the end of the sweep.
    pub stamp: Stamp,
    /// Pose of the base at that instant.
    pub odom_from_base: Isometry,
    /// Points in the base frame, metres, within range and outside the robot's body.
    pub xyz: Arc<Vec<[f32; 3]>>,
    /// Return strength of each point, or empty.
    pub intensity: Arc<Vec<f32>>,
}

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Severity {
    Info,
    Warning,
    Error,
}

/// Kind of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FindingKind {
    /// The scans do not say when each point was measured.
    MissingPointTimes,
    /// The clocks of IMU and LiDAR have no common time.
    ClocksApart,
    /// The stamps of the IMU are ahead of or behind the LiDAR's.
    ImuLag,
    /// The IMU reached the end of its range.
    ImuSaturated,
    /// Gravity does not point down with the given mounting.
    MountingTilted,
    /// The accelerometer's reading at rest does not have the length of gravity.
    GravityImplausible,
    /// LiDAR and IMU turn about different axes: the mounting of one of them is wrong.
    MountingInconsistent,
    /// The robot moved when it should have stood still.
    NotStationary,
    /// An expected source sends nothing.
    SourceSilent,
    /// Stamps of a source went backwards or repeated. Those messages are ignored.
    StampsBackwards,
    /// Scans did not fit the local map for so long that the odometry began anew.
    TrackingLost,
}

/// A fault of a sensor or its setup, and its remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// The kind.
    pub kind: FindingKind,
    /// The severity.
    pub severity: Severity,
    /// What is wrong, one sentence.
    pub what: String,
    /// What to do, one sentence.
    pub remedy: String,
}

/// A span in whole milliseconds, for sentences.
pub(crate) fn milliseconds(span: Span) -> i64 {
    span.nanos() / 1_000_000
}
