//! Factors on velocities, gravity, and vectors that change slowly.

use crate::error::FactorError;
use crate::factor::{Factor, Linearised};
use crate::information::Whitening;
use crate::names::{Key, VariableKind};
use crate::texts;
use crate::value::Values;
use geometry::{Matrix3, Matrix6, Vector3, Vector6, so3};
use nalgebra::SMatrix;

/// Velocity measured in the body frame, by legs or wheels. Residual `Rᵀ v - measured`, m/s. Variables: pose, velocity in the map frame.
#[derive(Clone, Debug)]
pub struct BodyVelocity {
    keys: [Key; 2],
    measured: Vector3,
    whitening: Whitening<3>,
}

impl BodyVelocity {
    /// `measured` in m/s in the body frame. `information` belongs to it.
    ///
    /// # Errors
    /// When the velocity is not finite, or the information is not the inverse of a covariance.
    pub fn new(
        pose: Key,
        velocity: Key,
        measured: &Vector3,
        information: &Matrix3,
    ) -> Result<Self, FactorError> {
        if !measured.iter().all(|component| component.is_finite()) {
            return Err(FactorError::NotFinite { what: texts::MEASURED_VELOCITY });
        }
        let whitening = Whitening::from_information(information)?;
        Ok(Self { keys: [pose, velocity], measured: *measured, whitening })
    }
}

impl Factor for BodyVelocity {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn kinds(&self) -> &[VariableKind] {
        &[VariableKind::Pose, VariableKind::Vector3]
    }

    fn rows(&self) -> usize {
        3
    }

    fn linearise(&self, values: &Values, out: &mut Linearised) -> Result<(), FactorError> {
        let (pose, velocity) = (values.pose(self.keys[0])?, values.vector3(self.keys[1])?);
        let body_from_map: Matrix3 = pose.rotation.inverse().to_rotation_matrix().into_inner();
        let in_body = body_from_map * velocity;
        let mut by_pose = SMatrix::<f64, 3, 6>::zeros();
        by_pose.fixed_columns_mut::<3>(0).copy_from(&so3::hat(&in_body));
        let weight = self.whitening.matrix();
        out.set_jacobian(0, &(weight * by_pose));
        out.set_jacobian(1, &(weight * body_from_map));
        out.set_residual(&(weight * (in_body - self.measured)));
        Ok(())
    }
}

/// Direction opposite to gravity ("up"), measured in the body frame. Residual `Rᵀ up - measured` of unit vectors, which is in radians for small
/// errors. It does not constrain the heading. Variable: pose.
#[derive(Clone, Debug)]
pub struct GravityDirection {
    key: [Key; 1],
    up_in_map: Vector3,
    up_in_body: Vector3,
    /// Inverse standard deviation, 1/radians.
    weight: f64,
}

impl GravityDirection {
    /// `up_in_body` is the reading of an accelerometer at rest, of any length. `deviation` in radians.
    ///
    /// # Errors
    /// When a vector has no direction, or the deviation is not positive.
    pub fn new(
        key: Key,
        up_in_map: &Vector3,
        up_in_body: &Vector3,
        deviation: f64,
    ) -> Result<Self, FactorError> {
        let direction = |vector: &Vector3| {
            let length = vector.norm();
            let usable = length.is_finite() && length > 1e-9;
            usable
                .then(|| vector / length)
                .ok_or(FactorError::Degenerate { key, reason: texts::NO_DIRECTION })
        };
        if !(deviation.is_finite() && deviation > 0.0) {
            return Err(FactorError::NotFinite { what: texts::STANDARD_DEVIATION });
        }
        let (up_in_map, up_in_body) = (direction(up_in_map)?, direction(up_in_body)?);
        Ok(Self { key: [key], up_in_map, up_in_body, weight: 1.0 / deviation })
    }
}

impl Factor for GravityDirection {
    fn keys(&self) -> &[Key] {
        &self.key
    }

    fn kinds(&self) -> &[VariableKind] {
        &[VariableKind::Pose]
    }

    fn rows(&self) -> usize {
        3
    }

    fn linearise(&self, values: &Values, out: &mut Linearised) -> Result<(), FactorError> {
        let up = values.pose(self.key[0])?.rotation.inverse() * self.up_in_map;
        let mut jacobian = SMatrix::<f64, 3, 6>::zeros();
        jacobian.fixed_columns_mut::<3>(0).copy_from(&(so3::hat(&up) * self.weight));
        out.set_jacobian(0, &jacobian);
        out.set_residual(&((up - self.up_in_body) * self.weight));
        Ok(())
    }
}

/// Six numbers that change slowly, such as an IMU's biases. Residual `to - from`.
#[derive(Clone, Debug)]
pub struct RandomWalk {
    keys: [Key; 2],
    whitening: Whitening<6>,
}

impl RandomWalk {
    /// `information` belongs to the change.
    ///
    /// # Errors
    /// When the information is not the inverse of a covariance.
    pub fn new(from: Key, to: Key, information: &Matrix6) -> Result<Self, FactorError> {
        Ok(Self { keys: [from, to], whitening: Whitening::from_information(information)? })
    }
}

impl Factor for RandomWalk {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn kinds(&self) -> &[VariableKind] {
        &[VariableKind::Vector6, VariableKind::Vector6]
    }

    fn rows(&self) -> usize {
        6
    }

    fn linearise(&self, values: &Values, out: &mut Linearised) -> Result<(), FactorError> {
        let change: Vector6 = values.vector6(self.keys[1])? - values.vector6(self.keys[0])?;
        let weight = self.whitening.matrix();
        out.set_jacobian(0, &(-weight));
        out.set_jacobian(1, weight);
        out.set_residual(&(weight * change));
        Ok(())
    }
}
