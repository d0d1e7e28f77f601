//! Landmarks measured from poses.

use crate::error::FactorError;
use crate::factor::{Factor, Linearised};
use crate::information::Whitening;
use crate::names::{Key, VariableKind};
use crate::texts;
use crate::value::Values;
use geometry::{Matrix3, Vector3, so3};
use nalgebra::{Matrix2, Matrix2x3, RowVector2, SMatrix, Vector2};

/// A landmark measured in the frame of a pose. Residual `Rᵀ (l - t) - seen`, metres. Variables: pose, landmark in the map frame.
#[derive(Clone, Debug)]
pub struct Landmark {
    keys: [Key; 2],
    seen: Vector3,
    whitening: Whitening<3>,
}

impl Landmark {
    /// `point_in_pose` is the measured position, metres. `information` belongs to it.
    ///
    /// # Errors
    /// When the point is not finite, or the information is not the inverse of a covariance.
    pub fn new(
        pose: Key,
        point: Key,
        point_in_pose: &Vector3,
        information: &Matrix3,
    ) -> Result<Self, FactorError> {
        if !point_in_pose.iter().all(|component| component.is_finite()) {
            return Err(FactorError::NotFinite { what: texts::SEEN_POINT });
        }
        let whitening = Whitening::from_information(information)?;
        Ok(Self { keys: [pose, point], seen: *point_in_pose, whitening })
    }
}

impl Factor for Landmark {
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
        let (pose, point) = (values.pose(self.keys[0])?, values.vector3(self.keys[1])?);
        let pose_from_map: Matrix3 = pose.rotation.inverse().to_rotation_matrix().into_inner();
        let in_pose = pose_from_map * (point - pose.translation.vector);
        let mut by_pose = SMatrix::<f64, 3, 6>::zeros();
        by_pose.fixed_columns_mut::<3>(0).copy_from(&so3::hat(&in_pose));
        by_pose.fixed_columns_mut::<3>(3).copy_from(&(-Matrix3::identity()));
        let weight = self.whitening.matrix();
        out.set_jacobian(0, &(weight * by_pose));
        out.set_jacobian(1, &(weight * pose_from_map));
        out.set_residual(&(weight * (in_pose - self.seen)));
        Ok(())
    }
}

/// Bearing and range of a landmark in the plane. Residual `[bearing; range]`, radians and metres. Variables: plane pose, landmark.
#[derive(Clone, Debug)]
pub struct BearingRange {
    keys: [Key; 2],
    bearing: f64,
    range: f64,
    whitening: Whitening<2>,
}

/// At smaller ranges the bearing is undefined, metres.
const MIN_RANGE: f64 = 1e-9;

impl BearingRange {
    /// `bearing` in radians, counter-clockwise from the pose's x axis. `range` in metres. `information` belongs to `[bearing; range]`.
    ///
    /// # Errors
    /// When a number is not finite, the range is negative, or the information is not the inverse of a covariance.
    pub fn new(
        pose: Key,
        point: Key,
        bearing: f64,
        range: f64,
        information: &Matrix2<f64>,
    ) -> Result<Self, FactorError> {
        if !bearing.is_finite() {
            return Err(FactorError::NotFinite { what: texts::BEARING });
        }
        if !range.is_finite() || range < 0.0 {
            return Err(FactorError::NotFinite { what: texts::RANGE });
        }
        let whitening = Whitening::from_information(information)?;
        Ok(Self { keys: [pose, point], bearing, range, whitening })
    }
}

impl Factor for BearingRange {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn kinds(&self) -> &[VariableKind] {
        &[VariableKind::Planar, VariableKind::Vector2]
    }

    fn rows(&self) -> usize {
        2
    }

    fn linearise(&self, values: &Values, out: &mut Linearised) -> Result<(), FactorError> {
        let (pose, point) = (values.planar(self.keys[0])?, values.vector2(self.keys[1])?);
        let pose_from_map: Matrix2<f64> = pose.rotation.inverse().to_rotation_matrix().into_inner();
        let p = pose_from_map * (point - pose.translation.vector);
        let range = p.norm();
        if range < MIN_RANGE {
            return Err(FactorError::Degenerate { key: self.keys[1], reason: texts::POINT_AT_POSE });
        }
        let by_point_in_pose = Matrix2::from_rows(&[
            RowVector2::new(-p.y, p.x) / (range * range),
            RowVector2::new(p.x, p.y) / range,
        ]);
        let moved = Matrix2x3::new(-1.0, 0.0, p.y, 0.0, -1.0, -p.x);
        let off = p.y.atan2(p.x) - self.bearing;
        let residual = Vector2::new(off.sin().atan2(off.cos()), range - self.range);
        let weight = self.whitening.matrix();
        out.set_jacobian(0, &(weight * by_point_in_pose * moved));
        out.set_jacobian(1, &(weight * by_point_in_pose * pose_from_map));
        out.set_residual(&(weight * residual));
        Ok(())
    }
}
