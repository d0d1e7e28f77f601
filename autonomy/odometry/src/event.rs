//! What the odometry says.

use geometry::{Isometry, Matrix6, Vector3};
use std::sync::Arc;
use vocab::{Span, Stamp};

/// Something the odometry found out.
#[derive(Clone, Debug, PartialEq)]
pub enum OdometryEvent {
    /// It knows which way is up and begins to estimate.
    Started(Started),
    /// Where the base was at the end of a sweep.
    Pose(Box<PoseEvent>),
    /// The sweep of the pose before it, with the motion taken out.
    Scan(DeskewedScan),
    /// Something is wrong with a sensor or its setup; each kind is told once, but for a lost way.
    Finding(Finding),
}

/// The start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Started {
    /// First instant of the estimate.
    pub stamp: Stamp,
    /// Gravity in the IMU's frame as measured, m/s² (points down). Zero without an IMU.
    pub gravity: Vector3,
    /// Bias of the gyroscope, rad/s, IMU frame.
    pub gyro_bias: Vector3,
    /// Whether the robot stood still, so that both can be trusted.
    pub still: bool,
}

/// An estimate of the base's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Instant of the estimate.
    pub stamp: Stamp,
    /// Base in the odometry's frame: z against gravity, origin and heading where it began.
    pub odom_from_base: Isometry,
    /// Velocity of the base in its own frame, m/s.
    pub velocity: Vector3,
    /// Turn rate of the base in its own frame, rad/s.
    pub turn_rate: Vector3,
    /// Covariance of `odom_from_base`, `[rotation; translation]`, perturbed on the right.
    pub covariance: Matrix6,
    /// What of it stretches left on which nothing was followed: the same for every pose after them, so no part of what the way
    /// between two such poses is worth.
    pub covariance_inflation: Matrix6,
}

/// The estimate after one scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseEvent {
    /// At the end of the sweep.
    pub estimate: Estimate,
    /// The scan's own stamp (usually the start of the sweep).
    pub scan_stamp: Stamp,
    /// Base at the scan's own stamp, from the corrected motion during the sweep.
    pub odom_from_base_at_scan: Isometry,
    /// Directions of translation that the LiDAR did not see, unit vectors in the base frame, weakest first; other
    /// sources carry them.
    pub degenerate_directions: [Option<Vector3>; 3],
    /// How registration went.
    pub registration: RegistrationReport,
    /// Whether the LiDAR saw nothing, or nothing that fits what was seen before: other sources carry the whole pose.
    pub is_dead_reckoned: bool,
    /// Bias of the gyroscope, rad/s, IMU frame.
    pub gyro_bias: Vector3,
    /// Bias of the accelerometer, m/s², IMU frame.
    pub accel_bias: Vector3,
    /// Factor between the legs' velocity and the true one.
    pub leg_scale: f64,
}

/// How a scan's registration went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RegistrationReport {
    /// Points that entered, after thinning.
    pub points_used: usize,
    /// Voxel size that thinned the scan, metres.
    pub voxel: f32,
    /// Points that found a surface in the map at the last step.
    pub matched: usize,
    /// Share of the points that lay within the kernel's width of their surface.
    pub inlier_share: f64,
    /// Gauss-Newton steps.
    pub iterations: usize,
    /// Whether the pose had to be searched for, because the predicted one did not fit.
    pub searched: bool,
    /// Whether the scan was too blind or too different to be used at all.
    pub rejected: bool,
}

/// A scan with the robot's motion during the sweep taken out.
#[derive(Clone, Debug, PartialEq)]
pub struct DeskewedScan {
    /// The instant to which all points were moved: the end of the sweep.
    pub stamp: Stamp,
    /// Base at that instant.
    pub odom_from_base: Isometry,
    /// Points in the base frame, metres: those within range and outside the robot's body.
    pub xyz: Arc<Vec<[f32; 3]>>,
    /// Return strength of each, or empty.
    pub intensity: Arc<Vec<f32>>,
}

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Severity {
    Info,
    Warning,
    Error,
}

/// What can be wrong, without the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FindingKind {
    /// The scans do not say when each point was measured.
    MissingPointTimes,
    /// IMU and LiDAR clocks share no common time at all.
    ClocksApart,
    /// The IMU leads or lags the LiDAR.
    ImuLag,
    /// The IMU reached the end of its range.
    ImuSaturated,
    /// Gravity does not point down with the given mounting.
    MountingTilted,
    /// The accelerometer's length at rest is not that of gravity.
    GravityOdd,
    /// LiDAR and IMU turn about different axes: one of them is mounted otherwise than stated.
    MountingDisagrees,
    /// The robot moved while it should have stood still.
    NotStill,
    /// An expected source does not speak.
    SourceSilent,
    /// Stamps of a source went backwards; such messages are ignored.
    StampsBackwards,
    /// Scans did not fit what was seen before for so long that the odometry began anew.
    TrackingLost,
}

/// Something wrong with a sensor or its setup, with what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Which kind.
    pub kind: FindingKind,
    /// How bad.
    pub severity: Severity,
    /// What is wrong, one sentence.
    pub what: String,
    /// What to do, one sentence.
    pub remedy: String,
}

/// How much later the first stamp is, in whole milliseconds: for sentences.
pub(crate) fn milliseconds(span: Span) -> i64 {
    span.nanos() / 1_000_000
}
