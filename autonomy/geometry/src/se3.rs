//! Rigid motions with the error convention of this project: rotation and translation are perturbed on the right,
//! `retract(T, [w; v]) = (R exp(w), t + R v)`. This is the product manifold SO(3) x R³ in the body frame. It is cheaper than
//! the exponential of SE(3) and has the same tangent space at zero.

use crate::{Isometry, Matrix3, Matrix6, Vector3, Vector6, so3};
use nalgebra::Translation3;

/// Applies an error `[rotation; translation]` (radians, metres), given in the child's frame, to a pose.
pub fn retract(t: &Isometry, error: &Vector6) -> Isometry {
    let rotation = so3::exp(&error.fixed_rows::<3>(0).into_owned());
    let shift = t.rotation * error.fixed_rows::<3>(3).into_owned();
    Isometry::from_parts(Translation3::from(t.translation.vector + shift), t.rotation * rotation)
}

/// The error with `retract(from, error) == to`: the inverse of [`retract`].
pub fn local(from: &Isometry, to: &Isometry) -> Vector6 {
    let delta = from.inverse() * to;
    let mut error = Vector6::zeros();
    error.fixed_rows_mut::<3>(0).copy_from(&so3::log(&delta.rotation));
    error.fixed_rows_mut::<3>(3).copy_from(&delta.translation.vector);
    error
}

/// Maps an error from the child's frame to the parent's: `T * retract(I, e) = retract(I, adjoint(T) e) * T` to first order in
/// `e`.
pub fn adjoint(t: &Isometry) -> Matrix6 {
    let r: Matrix3 = t.rotation.to_rotation_matrix().into_inner();
    let mut ad = Matrix6::zeros();
    ad.fixed_view_mut::<3, 3>(0, 0).copy_from(&r);
    ad.fixed_view_mut::<3, 3>(3, 3).copy_from(&r);
    ad.fixed_view_mut::<3, 3>(3, 0).copy_from(&(so3::hat(&t.translation.vector) * r));
    ad
}

/// Pose at a fraction (0 to 1) between `from` and `to`: the rotation at a constant rate about a fixed axis, the translation on a
/// straight line.
pub fn interpolate(from: &Isometry, to: &Isometry, fraction: f64) -> Isometry {
    let rotation_vector = so3::log(&(from.rotation.inverse() * to.rotation));
    let rotation = from.rotation * so3::exp(&(rotation_vector * fraction));
    let translation: Vector3 = from.translation.vector.lerp(&to.translation.vector, fraction);
    Isometry::from_parts(Translation3::from(translation), rotation)
}
