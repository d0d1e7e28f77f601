//! LiDAR-inertial-leg odometry: where the robot is since it was switched on, smooth but slowly drifting, with
//! motion-corrected scans.
//!
//! An iterated error-state Kalman filter carries pose, velocity, biases, gravity and the legs' scale through IMU
//! readings; leg velocities are measurements, and each scan is registered to a local map of Gaussians with the
//! prediction as prior, so that directions the LiDAR cannot see stay with the other sources and their covariance
//! grows. Every source is optional. `docs/maths/odometry.md` has the equations.
//!
//! Read [`Odometry`] (waiting and ordering), then `carrier` (from scan to scan), `tracker` (taking a scan in) and
//! `local_map` (its fit).

mod config;
mod event;
mod filter;
mod findings;
mod imu_lidar_consistency;
mod imu_queue;
mod initial_alignment;
mod local_map;
mod motion_model;
mod odometry;
mod pickup_detector;
mod pose_table;
mod reinitialiser;
mod scan_tracker;
mod state;
mod state_propagator;
mod sweep;
mod velocity_measurement;

pub use config::{Mounting, NoiseConfig, OdometryConfig, Sources};
pub use event::{
    DeskewedScan, Estimate, Finding, FindingKind, OdometryEvent, PoseEvent, RegistrationReport, Severity,
    Started,
};
pub use odometry::Odometry;
pub use sweep::{ScanView, deskew};
