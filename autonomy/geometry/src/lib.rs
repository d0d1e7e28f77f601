//! Rotations, rigid transforms, alignment of point sets, and seeded random numbers.
//!
//! Conventions of the whole core: metres, radians, seconds; `parent_from_child` transforms; Hamilton quaternions; errors of a
//! pose have the order `[rotation; translation]` and are applied on the *right* of the pose ([`se3::retract`]).

mod alignment;
mod frames;
mod plain;
mod random;
pub mod se3;
pub mod so3;

pub use alignment::{Similarity, align_yaw_only, aligned_rmse, rms_distance, umeyama};
pub use frames::{Base, Body, External, Imu, Lidar, Transform};
pub use plain::{
    isometry_from_pose, isometry_from_unit_pose, pose_from_isometry, vec_from_plain, vec_to_plain,
};
pub use random::{Rng, RngTree};

/// Standard gravity, m/s² (CGPM 1901). Local gravity differs by up to 0.03 m/s².
pub const STANDARD_GRAVITY_M_S2: f64 = 9.80665;

/// 3-vector, f64.
pub type Vector3 = nalgebra::Vector3<f64>;
/// 6-vector, f64; `[rotation; translation]` where it is a twist or an error.
pub type Vector6 = nalgebra::Vector6<f64>;
/// 3x3 matrix, f64.
pub type Matrix3 = nalgebra::Matrix3<f64>;
/// 6x6 matrix, f64.
pub type Matrix6 = nalgebra::Matrix6<f64>;
/// Unit quaternion, f64.
pub type Rotation = nalgebra::UnitQuaternion<f64>;
/// Rigid transform without frames in its type, f64.
pub type Isometry = nalgebra::Isometry3<f64>;
