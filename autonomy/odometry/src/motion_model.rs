//! Motion models: how the state and its error propagate over a short time, for each kind of knowledge about the motion.
//!
//! Equations: docs/maths/odometry.md, equations 4 to 7. Source of the inertial model: Solà, *Quaternion kinematics for the
//! error-state Kalman filter*, 2017, section 5. Here the position error is in the body frame, and the mean is integrated with the
//! rotation half-way through the step.

use crate::state::{ACCEL_BIAS, ErrorMatrix, GRAVITY, GYRO_BIAS, POSITION, ROTATION, State, VELOCITY};
use geometry::{Isometry, Matrix3, STANDARD_GRAVITY_M_S2, Vector3, so3};
use nalgebra::Translation3;

/// Decay of a motion that nothing measures. With the random walks of [`FilterConfig`](crate::FilterConfig) the velocity then stays
/// near 1.5 m/s and the turn rate near 1 rad/s, as those of walkers do, and a direction that a scan does not observe does not
/// diverge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecayConfig {
    /// Time constant of the velocity, seconds. Chosen: a few steps of a walk.
    pub velocity_time_constant_s: f64,
    /// Time constant of the turn rate, seconds. Chosen: a step of a walk.
    pub turn_rate_time_constant_s: f64,
}

impl Default for DecayConfig {
    fn default() -> Self {
        Self { velocity_time_constant_s: 2.0, turn_rate_time_constant_s: 0.5 }
    }
}

/// Knowledge of the motion over a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionModel {
    /// Mean readings of an IMU over the step, body frame (equation 4).
    Inertial {
        /// Turn rate, rad/s.
        gyro: Vector3,
        /// Specific force, m/s².
        specific_force: Vector3,
    },
    /// Mean twist that another odometry measured, body frame (equation 5).
    Twist {
        /// Turn rate, rad/s.
        turn_rate: Vector3,
        /// Velocity, m/s.
        velocity: Vector3,
    },
    /// No knowledge: velocity and turn rate decay exponentially (equation 6).
    DecayingVelocity(DecayConfig),
}

impl MotionModel {
    /// The mean of the state `dt` seconds later.
    pub fn propagate_mean(&self, state: &State, dt: f64) -> State {
        let pose = &state.odom_from_body;
        let (rotation, position) = (pose.rotation, pose.translation.vector);
        let mut next = *state;
        let pose_of =
            |position: Vector3, rotation| Isometry::from_parts(Translation3::from(position), rotation);
        match *self {
            Self::Inertial { gyro, specific_force } => {
                let turn = (gyro - state.gyro_bias) * dt;
                let midpoint_rotation = rotation * so3::exp(&(turn * 0.5));
                let acceleration = midpoint_rotation * (specific_force - state.accel_bias) + state.gravity();
                let moved = position + state.velocity * dt + acceleration * (0.5 * dt * dt);
                next.odom_from_body = pose_of(moved, rotation * so3::exp(&turn));
                next.velocity += acceleration * dt;
            }
            Self::Twist { turn_rate, velocity } => {
                let midpoint_rotation = rotation * so3::exp(&(turn_rate * (0.5 * dt)));
                let turned = rotation * so3::exp(&(turn_rate * dt));
                next.odom_from_body = pose_of(position + midpoint_rotation * velocity * dt, turned);
                next.velocity = turned * velocity;
                next.gyro_bias = -turn_rate;
            }
            Self::DecayingVelocity(decay) => {
                let (velocity_s, turn_rate_s) =
                    (decay.velocity_time_constant_s, decay.turn_rate_time_constant_s);
                let turned = rotation * so3::exp(&(state.gyro_bias * -decayed_duration(dt, turn_rate_s)));
                let moved = position + state.velocity * decayed_duration(dt, velocity_s);
                next.odom_from_body = pose_of(moved, turned);
                next.velocity *= (-dt / velocity_s).exp();
                next.gyro_bias *= (-dt / turn_rate_s).exp();
            }
        }
        next
    }

    /// Jacobian of the error after the step by the error before it (18x18; equation 7). `next` is the mean after the step.
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
                let midpoint_rotation = rotation * so3::exp(&half_turn).to_rotation_matrix().into_inner();
                let force = specific_force - state.accel_bias;
                // Jacobians of the acceleration by a rotation error at the start of the step, and by the gyroscope bias through the
                // half-way rotation.
                let by_midpoint = -midpoint_rotation * so3::hat(&force);
                let by_rotation = by_midpoint * so3::exp(&-half_turn).to_rotation_matrix().into_inner();
                let by_gyro_bias = by_midpoint * so3::right_jacobian(&half_turn) * (-0.5 * dt);
                let half_dt2 = 0.5 * dt * dt;
                set(ROTATION, GYRO_BIAS, &(so3::right_jacobian(&turn) * -dt));
                set(POSITION, ROTATION, &(next_from_odom * by_rotation * half_dt2));
                set(POSITION, VELOCITY, &(next_from_odom * dt));
                set(POSITION, GYRO_BIAS, &(next_from_odom * by_gyro_bias * half_dt2));
                set(POSITION, ACCEL_BIAS, &(next_from_odom * midpoint_rotation * -half_dt2));
                set(VELOCITY, ROTATION, &(by_rotation * dt));
                set(VELOCITY, GYRO_BIAS, &(by_gyro_bias * dt));
                set(VELOCITY, ACCEL_BIAS, &(midpoint_rotation * -dt));
                let gravity = state.gravity();
                for axis in 0..2 {
                    // The length of gravity is fixed, so a change of a horizontal component changes z as well.
                    let mut direction = Vector3::ith(axis, 1.0);
                    direction.z = -gravity[axis] / gravity.z.min(-0.1 * STANDARD_GRAVITY_M_S2);
                    f.fixed_view_mut::<3, 1>(VELOCITY, GRAVITY + axis).copy_from(&(direction * dt));
                    let moved = next_from_odom * direction * half_dt2;
                    f.fixed_view_mut::<3, 1>(POSITION, GRAVITY + axis).copy_from(&moved);
                }
            }
            Self::Twist { turn_rate, velocity } => {
                let midpoint_rotation = so3::exp(&(turn_rate * (0.5 * dt)));
                let step = midpoint_rotation * velocity * dt;
                set(POSITION, ROTATION, &(next_from_body * so3::hat(&step) * -1.0));
                let next_rotation = next.odom_from_body.rotation.to_rotation_matrix().into_inner();
                set(VELOCITY, ROTATION, &(next_rotation * so3::hat(&velocity) * next_from_body * -1.0));
                set(VELOCITY, VELOCITY, &Matrix3::zeros());
                set(GYRO_BIAS, GYRO_BIAS, &Matrix3::zeros());
            }
            Self::DecayingVelocity(decay) => {
                let (velocity_s, turn_rate_s) =
                    (decay.velocity_time_constant_s, decay.turn_rate_time_constant_s);
                let (turn_duration, duration) =
                    (decayed_duration(dt, turn_rate_s), decayed_duration(dt, velocity_s));
                let turn = state.gyro_bias * -turn_duration;
                set(ROTATION, GYRO_BIAS, &(so3::right_jacobian(&turn) * -turn_duration));
                set(POSITION, VELOCITY, &(next_from_odom * duration));
                set(VELOCITY, VELOCITY, &(Matrix3::identity() * (-dt / velocity_s).exp()));
                set(GYRO_BIAS, GYRO_BIAS, &(Matrix3::identity() * (-dt / turn_rate_s).exp()));
            }
        }
        f
    }
}

/// The time in which a constant motion covers what a decaying motion covers in `dt`, seconds.
fn decayed_duration(dt: f64, time_constant: f64) -> f64 {
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
    fn every_jacobian_matches_central_differences() {
        let mut rng = RngTree::new(12).child("motion").rng();
        for _ in 0..30 {
            let state = random_state(&mut rng);
            let mut random = |scale: f64| Vector3::new(rng.normal(), rng.normal(), rng.normal()) * scale;
            let motions = [
                MotionModel::Inertial { gyro: random(2.0), specific_force: random(10.0) },
                MotionModel::Twist { turn_rate: random(1.0), velocity: random(1.0) },
                MotionModel::DecayingVelocity(DecayConfig::default()),
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
