//! The estimated state and its error (docs/maths/odometry.md, equations 1 to 3).
//!
//! Frames: `odom` has z up at the start; `body` is the IMU, or the base of a robot without an IMU. The error has 18 components in
//! the order of the constants below. Errors of rotation, position and biases are in the body frame, those of velocity and gravity
//! in the odom frame.

use geometry::{Isometry, STANDARD_GRAVITY_M_S2, Vector3, Vector6, se3};
use nalgebra::{SMatrix, SVector};

/// Components of the error.
pub const DIMENSION: usize = 18;
/// First component of the rotation error, radians. The position error follows it.
pub const ROTATION: usize = 0;
/// First component of the position error, metres.
pub const POSITION: usize = 3;
/// First component of the velocity error, m/s.
pub const VELOCITY: usize = 6;
/// First component of the error of the gyroscope bias, rad/s.
pub const GYRO_BIAS: usize = 9;
/// First component of the error of the accelerometer bias, m/s².
pub const ACCEL_BIAS: usize = 12;
/// First component of the error of the horizontal part of gravity, m/s².
pub const GRAVITY: usize = 15;
/// Component of the error of the leg scale.
pub const LEG_SCALE: usize = 17;

/// Error of a state.
pub type ErrorVector = SVector<f64, DIMENSION>;
/// Covariance of an error, or Jacobian of one error by another.
pub type ErrorMatrix = SMatrix<f64, DIMENSION, DIMENSION>;

/// The estimated state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Pose of the body in the odometry's frame.
    pub odom_from_body: Isometry,
    /// Velocity of the body, m/s, odom frame.
    pub velocity: Vector3,
    /// Gyroscope bias, rad/s, body frame. Without an IMU it is the bias of a gyroscope that always reads zero, so the turn rate is its
    /// negative.
    pub gyro_bias: Vector3,
    /// Accelerometer bias, m/s², body frame.
    pub accel_bias: Vector3,
    /// x and y of gravity in the odom frame, m/s². Near zero, because the odom frame starts level.
    pub gravity_tilt: [f64; 2],
    /// Velocity reported by the legs divided by the true velocity.
    pub leg_scale: f64,
}

impl State {
    /// At rest at a pose.
    pub fn at(odom_from_body: Isometry) -> Self {
        Self {
            odom_from_body,
            velocity: Vector3::zeros(),
            gyro_bias: Vector3::zeros(),
            accel_bias: Vector3::zeros(),
            gravity_tilt: [0.0; 2],
            leg_scale: 1.0,
        }
    }

    /// Gravity in the odom frame, m/s², pointing down, of the fixed length [`STANDARD_GRAVITY_M_S2`] (equation 2). The accelerometer's bias absorbs the
    /// difference to local gravity.
    pub fn gravity(&self) -> Vector3 {
        let [x, y] = self.gravity_tilt;
        Vector3::new(x, y, -(STANDARD_GRAVITY_M_S2 * STANDARD_GRAVITY_M_S2 - x * x - y * y).max(0.0).sqrt())
    }

    /// The state plus an error (equation 3).
    pub fn retract(&self, error: &ErrorVector) -> Self {
        let block = |first: usize| error.fixed_rows::<3>(first).into_owned();
        let pose: Vector6 = error.fixed_rows::<6>(ROTATION).into_owned();
        Self {
            odom_from_body: se3::retract(&self.odom_from_body, &pose),
            velocity: self.velocity + block(VELOCITY),
            gyro_bias: self.gyro_bias + block(GYRO_BIAS),
            accel_bias: self.accel_bias + block(ACCEL_BIAS),
            gravity_tilt: [self.gravity_tilt[0] + error[GRAVITY], self.gravity_tilt[1] + error[GRAVITY + 1]],
            leg_scale: self.leg_scale + error[LEG_SCALE],
        }
    }

    /// The error with `self.retract(&error) == to`.
    #[cfg(test)]
    pub fn local(&self, to: &Self) -> ErrorVector {
        let mut error = ErrorVector::zeros();
        error.fixed_rows_mut::<6>(0).copy_from(&se3::local(&self.odom_from_body, &to.odom_from_body));
        error.fixed_rows_mut::<3>(VELOCITY).copy_from(&(to.velocity - self.velocity));
        error.fixed_rows_mut::<3>(GYRO_BIAS).copy_from(&(to.gyro_bias - self.gyro_bias));
        error.fixed_rows_mut::<3>(ACCEL_BIAS).copy_from(&(to.accel_bias - self.accel_bias));
        error[GRAVITY] = to.gravity_tilt[0] - self.gravity_tilt[0];
        error[GRAVITY + 1] = to.gravity_tilt[1] - self.gravity_tilt[1];
        error[LEG_SCALE] = to.leg_scale - self.leg_scale;
        error
    }
}
