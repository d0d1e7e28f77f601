//! How the state and its error move over a short time, for each kind of knowledge about the motion.
//!
//! Source of the inertial case: Solà, *Quaternion kinematics for the error-state Kalman filter*, 2017, section 5, with
//! the position error in the body frame; the mean is integrated with the rotation half-way.

use crate::state::{
    ACCEL_BIAS, ErrorMatrix, GRAVITY, GYRO_BIAS, POSITION, ROTATION, STANDARD_GRAVITY, State, VELOCITY,
};
use geometry::{Isometry, Matrix3, Vector3, so3};
use nalgebra::Translation3;

/// Where nothing measures the motion, velocity and turn rate die away with these time constants, seconds. With the walks
/// of [`NoiseConfig`](crate::config::Noise) they then stay near 1.5 m/s and 1 rad/s, as walkers do, and a direction that a scan
/// cannot see does not run away.
const VELOCITY_FADES: f64 = 2.0;
const TURN_FADES: f64 = 0.5;

/// What is known of the motion over a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionModel {
    /// An IMU reads: turn rate (rad/s) and specific force (m/s²), means over the step, body frame.
    Inertial {
        /// Gyroscope.
        gyro: Vector3,
        /// Accelerometer.
        specific_force: Vector3,
    },
    /// Another odometry measured the twist, body frame: rad/s and m/s.
    Twist {
        /// Turn rate.
        turn_rate: Vector3,
        /// Velocity.
        velocity: Vector3,
    },
    /// Nothing: the body goes on as it went, more and more slowly.
    DecayingVelocity,
}

impl MotionModel {
    /// The state `dt` seconds later.
    pub fn propagate_mean(&self, state: &State, dt: f64) -> State {
        let pose = &state.odom_from_body;
        let (rotation, position) = (pose.rotation, pose.translation.vector);
        let mut next = *state;
        let place =
            |position: Vector3, rotation| Isometry::from_parts(Translation3::from(position), rotation);
        match *self {
            Self::Inertial { gyro, specific_force } => {
                let turn = (gyro - state.gyro_bias) * dt;
                let half_way = rotation * so3::exp(&(turn * 0.5));
                let acceleration = half_way * (specific_force - state.accel_bias) + state.gravity();
                let moved = position + state.velocity * dt + acceleration * (0.5 * dt * dt);
                next.odom_from_body = place(moved, rotation * so3::exp(&turn));
                next.velocity += acceleration * dt;
            }
            Self::Twist { turn_rate, velocity } => {
                let half_way = rotation * so3::exp(&(turn_rate * (0.5 * dt)));
                let turned = rotation * so3::exp(&(turn_rate * dt));
                next.odom_from_body = place(position + half_way * velocity * dt, turned);
                next.velocity = turned * velocity;
                next.gyro_bias = -turn_rate;
            }
            Self::DecayingVelocity => {
                let turned = rotation * so3::exp(&(state.gyro_bias * -fading(dt, TURN_FADES)));
                next.odom_from_body = place(position + state.velocity * fading(dt, VELOCITY_FADES), turned);
                next.velocity *= (-dt / VELOCITY_FADES).exp();
                next.gyro_bias *= (-dt / TURN_FADES).exp();
            }
        }
        next
    }

    /// Derivative of the error after the step by the error before it; `next` is the mean after the step.
    pub fn compute_jacobian(&self, state: &State, next: &State, dt: f64) -> ErrorMatrix {
        let rotation = state.odom_from_body.rotation.to_rotation_matrix().into_inner();
        let next_from_odom = next.odom_from_body.rotation.inverse().to_rotation_matrix().into_inner();
        let next_from_body = next_from_odom * rotation;
        let mut f = ErrorMatrix::identity();
        let mut set = |row: usize, column: usize, block: &Matrix3| {
            f.fixed_view_mut::<3, 3>(row, column).copy_from(block);
        };
        set(ROTATION, ROTATION, &next_from_body);
        set(POSITION, POSITION, &next_from_body);
        match *self {
            Self::Inertial { gyro, specific_force } => {
                let turn = (gyro - state.gyro_bias) * dt;
                let half_turn = turn * 0.5;
                let half_way = rotation * so3::exp(&half_turn).to_rotation_matrix().into_inner();
                let force = specific_force - state.accel_bias;
                // Acceleration by a rotation error at the start, and by the bias through the half-way rotation.
                let by_half_way = -half_way * so3::hat(&force);
                let by_rotation = by_half_way * so3::exp(&-half_turn).to_rotation_matrix().into_inner();
                let by_gyro_bias = by_half_way * so3::right_jacobian(&half_turn) * (-0.5 * dt);
                let half_dt2 = 0.5 * dt * dt;
                set(ROTATION, GYRO_BIAS, &(so3::right_jacobian(&turn) * -dt));
                set(POSITION, ROTATION, &(next_from_odom * by_rotation * half_dt2));
                set(POSITION, VELOCITY, &(next_from_odom * dt));
                set(POSITION, GYRO_BIAS, &(next_from_odom * by_gyro_bias * half_dt2));
                set(POSITION, ACCEL_BIAS, &(next_from_odom * half_way * -half_dt2));
                set(VELOCITY, ROTATION, &(by_rotation * dt));
                set(VELOCITY, GYRO_BIAS, &(by_gyro_bias * dt));
                set(VELOCITY, ACCEL_BIAS, &(half_way * -dt));
                let gravity = state.gravity();
                for axis in 0..2 {
                    // Gravity keeps its length: tipping it changes z as well.
                    let mut direction = Vector3::ith(axis, 1.0);
                    direction.z = -gravity[axis] / gravity.z.min(-0.1 * STANDARD_GRAVITY);
                    f.fixed_view_mut::<3, 1>(VELOCITY, GRAVITY + axis).copy_from(&(direction * dt));
                    let moved = next_from_odom * direction * half_dt2;
                    f.fixed_view_mut::<3, 1>(POSITION, GRAVITY + axis).copy_from(&moved);
                }
            }
            Self::Twist { turn_rate, velocity } => {
                let half_way = so3::exp(&(turn_rate * (0.5 * dt)));
                let step = half_way * velocity * dt;
                set(POSITION, ROTATION, &(next_from_body * so3::hat(&step) * -1.0));
                let next_rotation = next.odom_from_body.rotation.to_rotation_matrix().into_inner();
                set(VELOCITY, ROTATION, &(next_rotation * so3::hat(&velocity) * next_from_body * -1.0));
                set(VELOCITY, VELOCITY, &Matrix3::zeros());
                set(GYRO_BIAS, GYRO_BIAS, &Matrix3::zeros());
            }
            Self::DecayingVelocity => {
                let (turning, moving) = (fading(dt, TURN_FADES), fading(dt, VELOCITY_FADES));
                let turn = state.gyro_bias * -turning;
                set(ROTATION, GYRO_BIAS, &(so3::right_jacobian(&turn) * -turning));
                set(POSITION, VELOCITY, &(next_from_odom * moving));
                set(VELOCITY, VELOCITY, &(Matrix3::identity() * (-dt / VELOCITY_FADES).exp()));
                set(GYRO_BIAS, GYRO_BIAS, &(Matrix3::identity() * (-dt / TURN_FADES).exp()));
            }
        }
        f
    }
}

/// How long a motion that does not fade takes for what one that fades does in `dt`, seconds.
fn fading(dt: f64, time_constant: f64) -> f64 {
    -time_constant * (-dt / time_constant).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::{DIMENSION, ErrorVector};
    use geometry::{Rng, RngTree};

    fn random_state(rng: &mut Rng) -> State {
        let mut random = |scale: f64| Vector3::new(rng.normal(), rng.normal(), rng.normal()) * scale;
        State {
            odom_from_body: Isometry::new(random(3.0), random(0.8)),
            velocity: random(1.0),
            gyro_bias: random(0.1),
            accel_bias: random(0.1),
            gravity_tilt: [0.3, -0.2],
            leg_scale: 1.02,
        }
    }

    #[test]
    fn every_derivative_matches_central_differences() {
        let mut rng = RngTree::new(12).child("motion").rng();
        for _ in 0..30 {
            let state = random_state(&mut rng);
            let mut random = |scale: f64| Vector3::new(rng.normal(), rng.normal(), rng.normal()) * scale;
            let motions = [
                MotionModel::Inertial { gyro: random(2.0), specific_force: random(10.0) },
                MotionModel::Twist { turn_rate: random(1.0), velocity: random(1.0) },
                MotionModel::DecayingVelocity,
            ];
            let dt = 0.02;
            for motion in motions {
                let next = motion.propagate_mean(&state, dt);
                let analytic = motion.compute_jacobian(&state, &next, dt);
                for column in 0..DIMENSION {
                    let mut step = ErrorVector::zeros();
                    step[column] = 1e-5;
                    let after = motion.propagate_mean(&state.retract(&step), dt);
                    let before = motion.propagate_mean(&state.retract(&-step), dt);
                    let numeric = (next.local(&after) - next.local(&before)) / 2e-5;
                    let error = (numeric - analytic.column(column)).norm();
                    assert!(error < 1e-6, "{motion:?} column {column}: {error}\n{numeric}");
                }
            }
        }
    }
}
