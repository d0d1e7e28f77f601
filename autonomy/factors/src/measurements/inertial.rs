//! Preintegration of the IMU readings between two poses.
//!
//! Readings are integrated in the frame of the first pose, without its velocity and without gravity. So the integral stays valid when these
//! change. A change of the biases is corrected to first order.
//! Source: Forster, Carlone, Dellaert, Scaramuzza, *On-manifold preintegration for real-time visual-inertial odometry*, T-RO 33, 2017.

use crate::error::FactorError;
use crate::factor::{Factor, Linearised};
use crate::information::Whitening;
use crate::names::{Key, VariableKind};
use crate::texts;
use crate::value::Values;
use geometry::{Matrix3, Rotation, Vector3, Vector6, so3};
use nalgebra::{SMatrix, SVector};

type Matrix9 = SMatrix<f64, 9, 9>;
type Matrix9x3 = SMatrix<f64, 9, 3>;
type Matrix9x6 = SMatrix<f64, 9, 6>;

/// Noise densities of an IMU.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertialNoise {
    /// Gyroscope noise density, rad/s/√Hz.
    pub gyro_density_rad_s_per_sqrt_hz: f64,
    /// Accelerometer noise density, m/s²/√Hz.
    pub accel_density_m_s2_per_sqrt_hz: f64,
}

/// Integrated readings: change of rotation, velocity and position in the frame of the first pose.
#[derive(Clone, Debug)]
pub struct Preintegrated {
    noise: InertialNoise,
    /// `[gyroscope; accelerometer]`, rad/s and m/s².
    bias: Vector6,
    seconds: f64,
    rotation: Rotation,
    velocity: Vector3,
    position: Vector3,
    /// Derivatives of `[rotation; velocity; position]` with respect to the bias.
    by_bias: Matrix9x6,
    covariance: Matrix9,
}

impl Preintegrated {
    /// An empty integral. `bias` is the best estimate, `[gyroscope; accelerometer]`.
    ///
    /// # Errors
    /// When a number is not finite, or a density is not positive.
    pub fn new(bias: &Vector6, noise: InertialNoise) -> Result<Self, FactorError> {
        if !bias.iter().all(|component| component.is_finite()) {
            return Err(FactorError::NotFinite { what: texts::BIAS });
        }
        let usable = |density: f64| density.is_finite() && density > 0.0;
        if !usable(noise.gyro_density_rad_s_per_sqrt_hz) || !usable(noise.accel_density_m_s2_per_sqrt_hz) {
            return Err(FactorError::NotFinite { what: texts::NOISE_DENSITY });
        }
        Ok(Self {
            noise,
            bias: *bias,
            seconds: 0.0,
            rotation: Rotation::identity(),
            velocity: Vector3::zeros(),
            position: Vector3::zeros(),
            by_bias: Matrix9x6::zeros(),
            covariance: Matrix9::zeros(),
        })
    }

    /// Adds a reading that held for `seconds`: turn rate (rad/s) and specific force (m/s²) in the body frame.
    ///
    /// # Errors
    /// When a number is not finite, or `seconds` is not positive.
    pub fn add(
        &mut self,
        turn_rate: &Vector3,
        specific_force: &Vector3,
        seconds: f64,
    ) -> Result<(), FactorError> {
        if !(seconds.is_finite() && seconds > 0.0) {
            return Err(FactorError::NotFinite { what: texts::TIME_OF_READING });
        }
        if !turn_rate.iter().chain(specific_force.iter()).all(|component| component.is_finite()) {
            return Err(FactorError::NotFinite { what: texts::READING });
        }
        let h = seconds;
        let turn = (turn_rate - self.bias.fixed_rows::<3>(0)) * h;
        let force: Vector3 = specific_force - self.bias.fixed_rows::<3>(3);
        let before: Matrix3 = self.rotation.to_rotation_matrix().into_inner();
        let step = so3::exp(&turn);
        let back: Matrix3 = step.inverse().to_rotation_matrix().into_inner();
        let by_turn = so3::right_jacobian(&turn);
        let swung: Matrix3 = -(before * so3::hat(&force));

        // Jacobian of the errors of [rotation; velocity; position] after the step with respect to those before it.
        let mut carry = Matrix9::identity();
        carry.fixed_view_mut::<3, 3>(0, 0).copy_from(&back);
        carry.fixed_view_mut::<3, 3>(3, 0).copy_from(&(swung * h));
        carry.fixed_view_mut::<3, 3>(6, 0).copy_from(&(swung * (0.5 * h * h)));
        carry.fixed_view_mut::<3, 3>(6, 3).copy_from(&(Matrix3::identity() * h));
        // Jacobians with respect to errors of the two readings.
        let mut by_gyroscope = Matrix9x3::zeros();
        by_gyroscope.fixed_rows_mut::<3>(0).copy_from(&(by_turn * h));
        let mut by_accelerometer = Matrix9x3::zeros();
        by_accelerometer.fixed_rows_mut::<3>(3).copy_from(&(before * h));
        by_accelerometer.fixed_rows_mut::<3>(6).copy_from(&(before * (0.5 * h * h)));

        self.by_bias = carry * self.by_bias;
        let mut view = self.by_bias.fixed_columns_mut::<3>(0);
        view -= by_gyroscope;
        let mut view = self.by_bias.fixed_columns_mut::<3>(3);
        view -= by_accelerometer;
        let (g, a) = (self.noise.gyro_density_rad_s_per_sqrt_hz, self.noise.accel_density_m_s2_per_sqrt_hz);
        self.covariance = carry * self.covariance * carry.transpose()
            + by_gyroscope * by_gyroscope.transpose() * (g * g / h)
            + by_accelerometer * by_accelerometer.transpose() * (a * a / h);

        self.position += self.velocity * h + before * force * (0.5 * h * h);
        self.velocity += before * force * h;
        self.rotation *= step;
        self.rotation.renormalize_fast();
        self.seconds += h;
        Ok(())
    }

    /// Integrated time, seconds.
    pub const fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Change of rotation, velocity and position for another bias, to first order.
    pub fn gained(&self, bias: &Vector6) -> (Rotation, Vector3, Vector3) {
        let correction = self.by_bias * (bias - self.bias);
        let turn: Vector3 = correction.fixed_rows::<3>(0).into_owned();
        let velocity = self.velocity + correction.fixed_rows::<3>(3);
        let position = self.position + correction.fixed_rows::<3>(6);
        (self.rotation * so3::exp(&turn), velocity, position)
    }
}

/// Integrated IMU readings between two poses. Residual `[rotation; velocity; position]` in the first body frame. Variables: pose and velocity at
/// the beginning, pose and velocity at the end, bias. Velocities are in the map frame.
#[derive(Clone, Debug)]
pub struct Inertial {
    keys: [Key; 5],
    sum: Preintegrated,
    gravity: Vector3,
    whitening: Whitening<9>,
}

impl Inertial {
    /// `gravity` in the map frame, m/s², about `[0; 0; -9.81]`.
    ///
    /// # Errors
    /// When fewer than two readings were added. Their covariance would be singular.
    pub fn new(
        [from_pose, from_velocity, to_pose, to_velocity, bias]: [Key; 5],
        sum: Preintegrated,
        gravity: &Vector3,
    ) -> Result<Self, FactorError> {
        let keys = [from_pose, from_velocity, to_pose, to_velocity, bias];
        let degenerate = FactorError::Degenerate { key: from_pose, reason: texts::TOO_FEW_READINGS };
        let information = sum.covariance.cholesky().ok_or(degenerate)?.inverse();
        let symmetric = (information + information.transpose()) * 0.5;
        Ok(Self { keys, gravity: *gravity, whitening: Whitening::from_information(&symmetric)?, sum })
    }
}

impl Factor for Inertial {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn kinds(&self) -> &[VariableKind] {
        &[
            VariableKind::Pose,
            VariableKind::Vector3,
            VariableKind::Pose,
            VariableKind::Vector3,
            VariableKind::Vector6,
        ]
    }

    fn rows(&self) -> usize {
        9
    }

    fn linearise(&self, values: &Values, out: &mut Linearised) -> Result<(), FactorError> {
        let (from, to) = (values.pose(self.keys[0])?, values.pose(self.keys[2])?);
        let (from_velocity, to_velocity) = (values.vector3(self.keys[1])?, values.vector3(self.keys[3])?);
        let bias = values.vector6(self.keys[4])?;
        let h = self.sum.seconds;
        let (rotation, velocity, position) = self.sum.gained(bias);
        let body_from_map: Matrix3 = from.rotation.inverse().to_rotation_matrix().into_inner();
        let relative = from.rotation.inverse() * to.rotation;
        let relative_matrix: Matrix3 = relative.to_rotation_matrix().into_inner();

        let error = rotation.inverse() * relative;
        let angle = so3::log(&error);
        let gained_velocity = body_from_map * (to_velocity - from_velocity - self.gravity * h);
        let moved = to.translation.vector
            - from.translation.vector
            - from_velocity * h
            - self.gravity * (0.5 * h * h);
        let gained_position = body_from_map * moved;
        let mut residual = SVector::<f64, 9>::zeros();
        residual.fixed_rows_mut::<3>(0).copy_from(&angle);
        residual.fixed_rows_mut::<3>(3).copy_from(&(gained_velocity - velocity));
        residual.fixed_rows_mut::<3>(6).copy_from(&(gained_position - position));

        let by_turn = so3::right_jacobian_inverse(&angle);
        let mut by_from = Matrix9x6::zeros();
        by_from.fixed_view_mut::<3, 3>(0, 0).copy_from(&(-(by_turn * relative_matrix.transpose())));
        by_from.fixed_view_mut::<3, 3>(3, 0).copy_from(&so3::hat(&gained_velocity));
        by_from.fixed_view_mut::<3, 3>(6, 0).copy_from(&so3::hat(&gained_position));
        by_from.fixed_view_mut::<3, 3>(6, 3).copy_from(&(-Matrix3::identity()));
        let mut by_to = Matrix9x6::zeros();
        by_to.fixed_view_mut::<3, 3>(0, 0).copy_from(&by_turn);
        by_to.fixed_view_mut::<3, 3>(6, 3).copy_from(&relative_matrix);
        let mut by_from_velocity = Matrix9x3::zeros();
        by_from_velocity.fixed_rows_mut::<3>(3).copy_from(&(-body_from_map));
        by_from_velocity.fixed_rows_mut::<3>(6).copy_from(&(body_from_map * -h));
        let mut by_to_velocity = Matrix9x3::zeros();
        by_to_velocity.fixed_rows_mut::<3>(3).copy_from(&body_from_map);
        let mut by_bias: Matrix9x6 = -self.sum.by_bias;
        let turn_by_bias: SMatrix<f64, 3, 6> = self.sum.by_bias.fixed_rows::<3>(0).into_owned();
        let turn: Vector3 = turn_by_bias * (bias - self.sum.bias);
        let error_back: Matrix3 = error.inverse().to_rotation_matrix().into_inner();
        let turned = -(by_turn * error_back * so3::right_jacobian(&turn) * turn_by_bias);
        by_bias.fixed_rows_mut::<3>(0).copy_from(&turned);

        let weight = self.whitening.matrix();
        out.set_jacobian(0, &(weight * by_from));
        out.set_jacobian(1, &(weight * by_from_velocity));
        out.set_jacobian(2, &(weight * by_to));
        out.set_jacobian(3, &(weight * by_to_velocity));
        out.set_jacobian(4, &(weight * by_bias));
        out.set_residual(&(weight * residual));
        Ok(())
    }
}
