//! The rotation group SO(3): exponential, logarithm and the right Jacobian.
//!
//! Source: Solà, Deray, Atchuthan, *A micro Lie theory for state estimation in robotics*, 2018, appendix B.

use crate::{Matrix3, Rotation, Vector3};
use nalgebra::Quaternion;

/// Below this squared angle (rad²) the truncated series is exact to rounding: its next term is of relative order angle⁴/1920.
const SMALL_ANGLE_SQUARED: f64 = 1e-8;

/// Cross-product matrix: `hat(a) * b == a × b`.
pub fn hat(v: &Vector3) -> Matrix3 {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// Rotation by the vector `v` (axis times angle, radians). Defined for every finite `v`.
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

/// Rotation vector of `r` (axis times angle, radians), of length at most π. At exactly π it is either of the two possible axes.
pub fn log(r: &Rotation) -> Vector3 {
    let q = r.quaternion();
    // q and -q are the same rotation; the one with w >= 0 has the shorter vector.
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

/// Inverse of [`right_jacobian`]: `log(exp(v) * exp(dv)) ≈ v + right_jacobian_inverse(v) * dv`. Singular only at an angle of 2π.
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

/// Inverse of the left Jacobian: `right_jacobian_inverse(-v)`. Singular only at an angle of 2π.
pub fn left_jacobian_inverse(v: &Vector3) -> Matrix3 {
    right_jacobian_inverse(v).transpose()
}

/// Derivative of `left_jacobian_inverse(v) * t` with respect to `v`.
pub fn left_jacobian_inverse_derivative(v: &Vector3, t: &Vector3) -> Matrix3 {
    let angle_squared = v.norm_squared();
    // The product is t - v × t / 2 + b v × (v × t). `slope` is the derivative of b by the angle, divided by the angle.
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
