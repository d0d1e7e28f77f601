//! The rotation group SO(3): exponential, logarithm and the right Jacobian.
//!
//! Source: Solà, Deray, Atchuthan, *A micro Lie theory for state estimation in robotics*, 2018, appendix B.

use crate::{Matrix3, Rotation, Vector3};
use nalgebra::Quaternion;

/// Below this squared angle the series is exact to rounding (next term is of order angle⁴/1920 relative).
const SMALL_ANGLE_SQUARED: f64 = 1e-8;

/// Cross-product matrix: `hat(a) * b == a × b`.
pub fn hat(v: &Vector3) -> Matrix3 {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// Rotation by the vector `v` (axis times angle, radians). Total.
pub fn exp(v: &Vector3) -> Rotation {
    let angle_squared = v.norm_squared();
    let (w, scale) = if angle_squared < SMALL_ANGLE_SQUARED {
        (1.0 - angle_squared / 8.0, 0.5 - angle_squared / 48.0)
    } else {
        let angle = angle_squared.sqrt();
        ((angle / 2.0).cos(), (angle / 2.0).sin() / angle)
    };
    Rotation::from_quaternion(Quaternion::new(w, v.x * scale, v.y * scale, v.z * scale))
}

/// Rotation vector of `r`, radians, of length at most π. At exactly π either of the two axes.
pub fn log(r: &Rotation) -> Vector3 {
    let q = r.quaternion();
    // The shorter of the two rotations that q and -q name.
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    let (w, v) = (q.w * sign, q.imag() * sign);
    let sin_squared = v.norm_squared();
    if sin_squared < SMALL_ANGLE_SQUARED {
        return v * (2.0 / w * (1.0 - sin_squared / (3.0 * w * w)));
    }
    let sin_half = sin_squared.sqrt();
    v * (2.0 * sin_half.atan2(w) / sin_half)
}

/// Right Jacobian: `exp(v + dv) ≈ exp(v) * exp(right_jacobian(v) * dv)`.
pub fn right_jacobian(v: &Vector3) -> Matrix3 {
    let angle_squared = v.norm_squared();
    let hat_v = hat(v);
    let (a, b) = if angle_squared < SMALL_ANGLE_SQUARED {
        (0.5 - angle_squared / 24.0, 1.0 / 6.0 - angle_squared / 120.0)
    } else {
        let angle = angle_squared.sqrt();
        ((1.0 - angle.cos()) / angle_squared, (angle - angle.sin()) / (angle_squared * angle))
    };
    Matrix3::identity() - hat_v * a + hat_v * hat_v * b
}

/// Inverse of [`right_jacobian`]: `log(exp(v) * exp(dv)) ≈ v + right_jacobian_inverse(v) * dv`. Singular at 2π only.
pub fn right_jacobian_inverse(v: &Vector3) -> Matrix3 {
    let angle_squared = v.norm_squared();
    let hat_v = hat(v);
    let b = if angle_squared < SMALL_ANGLE_SQUARED {
        1.0 / 12.0 + angle_squared / 720.0
    } else {
        let angle = angle_squared.sqrt();
        // (1 + cos) / (2 angle sin) written with half angles, which stays finite at π.
        1.0 / angle_squared - (angle / 2.0).cos() / (2.0 * angle * (angle / 2.0).sin())
    };
    Matrix3::identity() + hat_v * 0.5 + hat_v * hat_v * b
}

/// Inverse of the left Jacobian: `right_jacobian_inverse(-v)`. Singular at 2π only.
pub fn left_jacobian_inverse(v: &Vector3) -> Matrix3 {
    right_jacobian_inverse(v).transpose()
}

/// Derivative of `left_jacobian_inverse(v) * t` with respect to `v`.
pub fn left_jacobian_inverse_derivative(v: &Vector3, t: &Vector3) -> Matrix3 {
    let angle_squared = v.norm_squared();
    // The product is t - v × t / 2 + b v × (v × t); `slope` is b's derivative with respect to the angle, by the angle.
    let (b, slope) = if angle_squared < 1e-4 {
        (1.0 / 12.0 + angle_squared / 720.0, 1.0 / 360.0 + angle_squared / 7560.0)
    } else {
        let angle = angle_squared.sqrt();
        let (sin, cos) = (angle / 2.0).sin_cos();
        let b = 1.0 / angle_squared - cos / (2.0 * angle * sin);
        let slope =
            (-2.0 / angle_squared + 1.0 / (4.0 * sin * sin) + cos / (2.0 * angle * sin)) / angle_squared;
        (b, slope)
    };
    let inner = v.cross(&v.cross(t));
    hat(t) * 0.5
        + (Matrix3::identity() * v.dot(t) + v * t.transpose() - t * v.transpose() * 2.0) * b
        + inner * v.transpose() * slope
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RngTree;

    fn random_vectors(scale: f64) -> Vec<Vector3> {
        let mut rng = RngTree::new(7).child("so3").rng();
        (0..200)
            .map(|_| {
                Vector3::new(rng.normal(), rng.normal(), rng.normal()).normalize() * (rng.uniform() * scale)
            })
            .collect()
    }

    #[test]
    fn derivative_of_the_inverse_left_jacobian_matches_central_differences() {
        for (v, t) in
            random_vectors(3.0).iter().chain(&random_vectors(1e-2)).zip(random_vectors(2.0).iter().cycle())
        {
            let h = 1e-6;
            for axis in 0..3 {
                let mut d = Vector3::zeros();
                d[axis] = h;
                let numeric =
                    (left_jacobian_inverse(&(v + d)) * t - left_jacobian_inverse(&(v - d)) * t) / (2.0 * h);
                let analytic = left_jacobian_inverse_derivative(v, t);
                assert!((numeric - analytic.column(axis)).norm() < 2e-6 * (1.0 + analytic.norm()), "{v} {t}");
            }
        }
    }

    #[test]
    fn log_undoes_exp_up_to_a_half_turn() {
        for v in random_vectors(std::f64::consts::PI - 1e-6).iter().chain(&random_vectors(1e-5)) {
            assert!((log(&exp(v)) - v).norm() < 1e-9, "{v}");
        }
    }

    #[test]
    fn right_jacobian_matches_central_differences() {
        for v in random_vectors(3.0).iter().chain(&random_vectors(1e-6)) {
            let h = 1e-6;
            for axis in 0..3 {
                let mut d = Vector3::zeros();
                d[axis] = h;
                let numeric = (log(&(exp(v).inverse() * exp(&(v + d))))
                    - log(&(exp(v).inverse() * exp(&(v - d)))))
                    / (2.0 * h);
                assert!((numeric - right_jacobian(v).column(axis)).norm() < 1e-7);
            }
            let product = right_jacobian(v) * right_jacobian_inverse(v);
            assert!((product - Matrix3::identity()).norm() < 1e-9);
            assert!((left_jacobian_inverse(v) - right_jacobian_inverse(&-v)).norm() < 1e-12);
        }
    }
}
