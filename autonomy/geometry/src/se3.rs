//! Rigid motions SE(3) with the error convention of this project: rotation and translation perturbed on the right,
//! `retract(T, [w; v]) = (R exp(w), t + R v)`. This is the product manifold SO(3) x R³ in the body frame: cheaper than
//! the full exponential and with the same tangent space at zero.

use crate::{Isometry, Matrix3, Matrix6, Vector3, Vector6, so3};
use nalgebra::Translation3;

/// Moves `t` by the error `[rotation; translation]` in its own frame.
pub fn retract(t: &Isometry, error: &Vector6) -> Isometry {
    let rotation = so3::exp(&error.fixed_rows::<3>(0).into_owned());
    let shift = t.rotation * error.fixed_rows::<3>(3).into_owned();
    Isometry::from_parts(Translation3::from(t.translation.vector + shift), t.rotation * rotation)
}

/// The error that [`retract`] needs to go from `from` to `to`.
pub fn local(from: &Isometry, to: &Isometry) -> Vector6 {
    let delta = from.inverse() * to;
    let mut error = Vector6::zeros();
    error.fixed_rows_mut::<3>(0).copy_from(&so3::log(&delta.rotation));
    error.fixed_rows_mut::<3>(3).copy_from(&delta.translation.vector);
    error
}

/// Moves an error from the child's frame to the parent's: `T * retract(I, e) ≈ retract(I, adjoint(T) e) * T` to first
/// order.
pub fn adjoint(t: &Isometry) -> Matrix6 {
    let r: Matrix3 = t.rotation.to_rotation_matrix().into_inner();
    let mut ad = Matrix6::zeros();
    ad.fixed_view_mut::<3, 3>(0, 0).copy_from(&r);
    ad.fixed_view_mut::<3, 3>(3, 3).copy_from(&r);
    ad.fixed_view_mut::<3, 3>(3, 0).copy_from(&(so3::hat(&t.translation.vector) * r));
    ad
}

/// Pose at `fraction` (0 to 1) of the way from `from` to `to`: rotation at constant rate, translation on a line.
pub fn interpolate(from: &Isometry, to: &Isometry, fraction: f64) -> Isometry {
    let rotation_vector = so3::log(&(from.rotation.inverse() * to.rotation));
    let rotation = from.rotation * so3::exp(&(rotation_vector * fraction));
    let translation: Vector3 = from.translation.vector.lerp(&to.translation.vector, fraction);
    Isometry::from_parts(Translation3::from(translation), rotation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RngTree;

    #[test]
    fn local_undoes_retract_and_the_adjoint_moves_errors() {
        let mut rng = RngTree::new(3).child("se3").rng();
        for _ in 0..100 {
            let mut random = |scale: f64| Vector6::from_fn(|_, _| rng.normal() * scale);
            let t = retract(&Isometry::identity(), &random(0.8));
            let e = random(0.3);
            assert!((local(&t, &retract(&t, &e)) - e).norm() < 1e-9);

            let small = random(1e-5);
            let left = t * retract(&Isometry::identity(), &small);
            let right = retract(&Isometry::identity(), &(adjoint(&t) * small)) * t;
            assert!(local(&left, &right).norm() < 1e-8);
        }
    }
}
