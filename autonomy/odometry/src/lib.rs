//! LiDAR-inertial-leg odometry: the robot's motion since it was switched on, smooth but slowly drifting, with motion-corrected
//! scans.
//!
//! An iterated error-state Kalman filter propagates pose, velocity, biases, gravity and the scale of the legs through IMU readings.
//! Leg velocities are measurements. Each scan is registered to a local map of Gaussians with the prediction as prior. Directions
//! that the LiDAR does not observe keep the prediction of the other sources, and their covariance grows. Every source is optional.
//! `docs/maths/odometry.md` has the equations; docstrings name them by number.
//!
//! Read [`Odometry`] first (queues and order of messages), then `state_propagator` (between scans), `scan_tracker` (a scan) and
//! `local_map` (its registration).

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
mod plane_thickness;
mod pose_table;
mod reinitialiser;
mod scan_tracker;
mod state;
mod state_propagator;
mod sweep;
mod velocity_measurement;

pub use config::{
    Mounting, OdometryConfig, PropagationConfig, Sources, SynchronisationConfig, TrackingConfig,
};
pub use event::{
    DeskewedScan, Estimate, Finding, FindingKind, OdometryEvent, PoseEvent, RegistrationReport, Severity,
    Started,
};
pub use filter::{FilterConfig, ImuNoise};
pub use imu_lidar_consistency::ImuLidarConsistencyConfig;
pub use imu_queue::ImuQueueConfig;
pub use initial_alignment::{InitialAlignmentConfig, InitialDeviations};
pub use local_map::LocalMapConfig;
pub use motion_model::DecayConfig;
pub use odometry::Odometry;
pub use pickup_detector::PickupConfig;
pub use plane_thickness::PlaneThicknessConfig;
pub use reinitialiser::ReinitialiserConfig;
pub use sweep::{ScanView, SweepConfig, deskew};
