//! Measured relative poses.
//!
//! There are two residuals. [`Residual::Split`] keeps rotation and translation apart, as in g2o files. [`Residual::Logarithm`] is the logarithm
//! of the whole motion, as in GTSAM. They agree to second order in the error's angle.

use crate::error::FactorError;
use crate::factor::{Factor, Linearised};
use crate::information::Whitening;
use crate::names::{Key, VariableKind};
use crate::texts;
use crate::value::{Planar, Values};
use geometry::{Isometry, Matrix3, Matrix6, Vector3, Vector6, so3};
use nalgebra::{Matrix2, SMatrix, UnitComplex, Vector2};

/// Definition of the residual vector of a relative pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Residual {
    /// Logarithm of the rotation, and the translation unchanged.
    #[default]
    Split,
    /// Logarithm of the motion: the translation is `V⁻¹ t` with the left Jacobian `V` of the rotation.
    Logarithm,
}

/// A measured pose of `to` in `from`. Residual `[Log(R); t]` (see [`Residual`]) of `measured⁻¹ · from⁻¹ · to`, in the measured frame.
#[derive(Clone, Debug)]
pub struct Between {
    keys: [Key; 2],
    measured_inverse: Isometry,
    /// Rotation matrix of `measured_inverse`.
    measured_from_parent: Matrix3,
    whitening: Whitening<6>,
    residual: Residual,
}

impl Between {
    /// `from_from_to` is the measurement. `information` belongs to its error `[rotation; translation]`, radians and metres.
    ///
    /// # Errors
    /// When the measurement is not finite, or the information is not the inverse of a covariance.
    pub fn new(
        from: Key,
        to: Key,
        from_from_to: &Isometry,
        information: &Matrix6,
    ) -> Result<Self, FactorError> {
        let measured_inverse = from_from_to.inverse();
        if !crate::Value::Pose(measured_inverse).is_finite() {
            return Err(FactorError::NotFinite { what: texts::MEASURED_POSE });
        }
        Ok(Self {
            keys: [from, to],
            measured_inverse,
            measured_from_parent: measured_inverse.rotation.to_rotation_matrix().into_inner(),
            whitening: Whitening::from_information(information)?,
            residual: Residual::default(),
        })
    }

    /// Selects another residual.
    #[must_use]
    pub const fn with_residual(mut self, residual: Residual) -> Self {
        self.residual = residual;
        self
    }

    /// The measurement.
    pub fn from_from_to(&self) -> Isometry {
        self.measured_inverse.inverse()
    }

    /// Information of its error.
    pub fn information(&self) -> Matrix6 {
        self.whitening.information()
    }

    fn error(&self, from_from_to: &Isometry) -> (Vector6, Vector3, geometry::Rotation) {
        let rotation = self.measured_inverse.rotation * from_from_to.rotation;
        let translation = self.measured_from_parent * from_from_to.translation.vector
            + self.measured_inverse.translation.vector;
        let angle = so3::log(&rotation);
        let error = Vector6::new(angle.x, angle.y, angle.z, translation.x, translation.y, translation.z);
        (error, angle, rotation)
    }

    /// Whitened residual of a split error.
    fn whitened(&self, error: &Vector6, angle: &Vector3) -> Vector6 {
        let mut error = *error;
        if self.residual == Residual::Logarithm {
            let translation = so3::left_jacobian_inverse(angle) * error.fixed_rows::<3>(3);
            error.fixed_rows_mut::<3>(3).copy_from(&translation);
        }
        self.whitening.matrix() * error
    }

    /// `W` times the derivatives of the residual with respect to the rotational and the translational part of the split error (docs/maths/factors.md,
    /// equation 5).
    fn weights(&self, error: &Vector6, angle: &Vector3) -> (SMatrix<f64, 6, 3>, SMatrix<f64, 6, 3>) {
        let weight = self.whitening.matrix();
        let (rotational, translational) =
            (weight.fixed_columns::<3>(0).into_owned(), weight.fixed_columns::<3>(3).into_owned());
        match self.residual {
            Residual::Split => (rotational, translational),
            Residual::Logarithm => {
                let translation: Vector3 = error.fixed_rows::<3>(3).into_owned();
                let by_angle = so3::left_jacobian_inverse_derivative(angle, &translation);
                (rotational + translational * by_angle, translational * so3::left_jacobian_inverse(angle))
            }
        }
    }
}

impl Factor for Between {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn kinds(&self) -> &[VariableKind] {
        &[VariableKind::Pose, VariableKind::Pose]
    }

    fn rows(&self) -> usize {
        6
    }

    fn linearise(&self, values: &Values, out: &mut Linearised) -> Result<(), FactorError> {
        let (from, to) = (values.pose(self.keys[0])?, values.pose(self.keys[1])?);
        let from_from_to = from.inv_mul(to);
        let (error, angle, rotation) = self.error(&from_from_to);
        let (rotational, translational) = self.weights(&error, &angle);

        // An error [w; v] of `to` moves Log by Jr⁻¹ w and t by R_error v.
        let by_turn: SMatrix<f64, 6, 3> = rotational * so3::right_jacobian_inverse(&angle);
        let by_shift: SMatrix<f64, 6, 3> = translational * rotation.to_rotation_matrix().matrix();
        let mut to_jacobian = Matrix6::zeros();
        to_jacobian.fixed_columns_mut::<3>(0).copy_from(&by_turn);
        to_jacobian.fixed_columns_mut::<3>(3).copy_from(&by_shift);

        // An error [w; v] of `from` rotates the relative rotation backwards and moves the relative position p by p × w - v.
        let relative: Matrix3 = from_from_to.rotation.to_rotation_matrix().into_inner();
        let seen: SMatrix<f64, 6, 3> = translational * self.measured_from_parent;
        let mut from_jacobian = Matrix6::zeros();
        let turn = seen * so3::hat(&from_from_to.translation.vector) - by_turn * relative.transpose();
        from_jacobian.fixed_columns_mut::<3>(0).copy_from(&turn);
        from_jacobian.fixed_columns_mut::<3>(3).copy_from(&(-seen));

        out.set_jacobian(0, &from_jacobian);
        out.set_jacobian(1, &to_jacobian);
        out.set_residual(&self.whitened(&error, &angle));
        Ok(())
    }

    fn residual(&self, values: &Values, out: &mut Linearised) -> Result<(), FactorError> {
        let (from, to) = (values.pose(self.keys[0])?, values.pose(self.keys[1])?);
        let (error, angle, _) = self.error(&from.inv_mul(to));
        out.set_residual(&self.whitened(&error, &angle));
        Ok(())
    }

    fn relative_pose(&self) -> Option<crate::RelativePose> {
        Some(crate::RelativePose::Space(self.from_from_to(), self.information()))
    }
}

/// A measured plane pose of `to` in `from`. Residual `[x; y; yaw]` of `measured⁻¹ · from⁻¹ · to`.
#[derive(Clone, Debug)]
pub struct PlanarBetween {
    keys: [Key; 2],
    measured_inverse: Planar,
    whitening: Whitening<3>,
    residual: Residual,
}

impl PlanarBetween {
    /// `from_from_to` is the measurement. `information` belongs to its error `[x; y; yaw]`, metres and radians.
    ///
    /// # Errors
    /// When the measurement is not finite, or the information is not the inverse of a covariance.
    pub fn new(
        from: Key,
        to: Key,
        from_from_to: &Planar,
        information: &Matrix3,
    ) -> Result<Self, FactorError> {
        let measured_inverse = from_from_to.inverse();
        if !crate::Value::Planar(measured_inverse).is_finite() {
            return Err(FactorError::NotFinite { what: texts::MEASURED_POSE });
        }
        let whitening = Whitening::from_information(information)?;
        Ok(Self { keys: [from, to], measured_inverse, whitening, residual: Residual::default() })
    }

    /// Selects another residual.
    #[must_use]
    pub const fn with_residual(mut self, residual: Residual) -> Self {
        self.residual = residual;
        self
    }

    /// The measurement.
    pub fn from_from_to(&self) -> Planar {
        self.measured_inverse.inverse()
    }

    /// Information of its error.
    pub fn information(&self) -> Matrix3 {
        self.whitening.information()
    }
}

/// Logarithm of a plane motion `[x; y; yaw]` and its derivative with respect to these three.
fn planar_logarithm(split: &Vector3) -> (Vector3, Matrix3) {
    let half = split.z / 2.0;
    // half · cot(half) and its derivative with respect to the yaw.
    let (scale, slope) = if half.abs() < 1e-4 {
        (1.0 - half * half / 3.0, -half / 3.0)
    } else {
        let (sin, cos) = half.sin_cos();
        (half * cos / sin, (cos / sin - half / (sin * sin)) / 2.0)
    };
    let derivative = Matrix3::new(
        scale,
        half,
        slope * split.x + split.y / 2.0,
        -half,
        scale,
        slope * split.y - split.x / 2.0,
        0.0,
        0.0,
        1.0,
    );
    let logarithm = Vector3::new(scale * split.x + half * split.y, scale * split.y - half * split.x, split.z);
    (logarithm, derivative)
}

fn matrix(rotation: UnitComplex<f64>) -> Matrix2<f64> {
    rotation.to_rotation_matrix().into_inner()
}

impl Factor for PlanarBetween {
    fn keys(&self) -> &[Key] {
        &self.keys
    }

    fn kinds(&self) -> &[VariableKind] {
        &[VariableKind::Planar, VariableKind::Planar]
    }

    fn rows(&self) -> usize {
        3
    }

    fn linearise(&self, values: &Values, out: &mut Linearised) -> Result<(), FactorError> {
        let (from, to) = (values.planar(self.keys[0])?, values.planar(self.keys[1])?);
        let from_from_to = from.inv_mul(to);
        let error = self.measured_inverse * from_from_to;
        let seen = matrix(self.measured_inverse.rotation);
        let p = from_from_to.translation.vector;

        let mut to_jacobian = Matrix3::identity();
        to_jacobian.fixed_view_mut::<2, 2>(0, 0).copy_from(&matrix(error.rotation));
        let mut from_jacobian = -Matrix3::identity();
        from_jacobian.fixed_view_mut::<2, 2>(0, 0).copy_from(&(-seen));
        from_jacobian.fixed_view_mut::<2, 1>(0, 2).copy_from(&(seen * Vector2::new(p.y, -p.x)));

        let mut residual = Vector3::new(error.translation.x, error.translation.y, error.rotation.angle());
        let mut weight = *self.whitening.matrix();
        if self.residual == Residual::Logarithm {
            let (logarithm, derivative) = planar_logarithm(&residual);
            out.set_residual(&(weight * logarithm));
            weight *= derivative;
        } else {
            residual = weight * residual;
            out.set_residual(&residual);
        }
        out.set_jacobian(0, &(weight * from_jacobian));
        out.set_jacobian(1, &(weight * to_jacobian));
        Ok(())
    }

    fn relative_pose(&self) -> Option<crate::RelativePose> {
        Some(crate::RelativePose::Plane(self.from_from_to(), self.information()))
    }
}
