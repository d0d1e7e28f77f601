//! Laws of rotations, rigid motions, framed transforms and alignment, on random inputs.
#![allow(clippy::unwrap_used, reason = "a test stops at what it did not expect")]

use geometry::{
    Base, Body, Isometry, Lidar, Matrix3, Matrix6, Rotation, Transform, Vector3, Vector6, align_yaw_only,
    rms_distance, se3, so3, umeyama,
};
use nalgebra::{SMatrix, SVector, Translation3};
use proptest::prelude::*;
use std::f64::consts::PI;

/// Vectors of any direction, at most `max` long. One in four is a thousand times shorter, so that the series for small angles are tested.
fn vector(max: f64) -> impl Strategy<Value = Vector3> {
    let direction = [-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64].prop_map(Vector3::from);
    let length = prop_oneof![3 => 0.0..max, 1 => 0.0..max * 1e-5];
    (direction, length)
        .prop_filter("no direction", |(direction, _)| direction.norm() > 0.1)
        .prop_map(|(direction, length)| direction.normalize() * length)
}

fn rotation() -> impl Strategy<Value = Rotation> {
    vector(PI - 1e-6).prop_map(|v| so3::exp(&v))
}

fn pose() -> impl Strategy<Value = Isometry> {
    (rotation(), vector(50.0)).prop_map(|(rotation, t)| Isometry::from_parts(Translation3::from(t), rotation))
}

/// Pose errors with a rotation of less than half a turn.
fn pose_error(max_angle: f64, max_distance: f64) -> impl Strategy<Value = Vector6> {
    (vector(max_angle), vector(max_distance)).prop_map(|(rotation, shift)| {
        Vector6::new(rotation.x, rotation.y, rotation.z, shift.x, shift.y, shift.z)
    })
}

/// Derivative of a function of three numbers by central differences.
fn central_differences<const ROWS: usize>(
    at: &Vector3,
    step: f64,
    function: impl Fn(&Vector3) -> SVector<f64, ROWS>,
) -> SMatrix<f64, ROWS, 3> {
    let mut derivative = SMatrix::<f64, ROWS, 3>::zeros();
    for axis in 0..3 {
        let mut offset = Vector3::zeros();
        offset[axis] = step;
        let slope = (function(&(at + offset)) - function(&(at - offset))) / (2.0 * step);
        derivative.set_column(axis, &slope);
    }
    derivative
}

fn difference(a: &Isometry, b: &Isometry) -> f64 {
    (a.to_homogeneous() - b.to_homogeneous()).norm()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn log_inverts_exp_below_half_a_turn(v in vector(PI - 1e-6)) {
        prop_assert!((so3::log(&so3::exp(&v)) - v).norm() < 1e-9);
    }

    #[test]
    fn exp_inverts_log_and_log_is_at_most_half_a_turn(v in vector(20.0)) {
        let rotation = so3::exp(&v);
        let log = so3::log(&rotation);
        prop_assert!(log.norm() <= PI + 1e-12);
        prop_assert!(so3::exp(&log).angle_to(&rotation) < 1e-7);
    }

    #[test]
    fn exp_of_the_negative_is_the_inverse_and_turns_about_one_axis_add(v in vector(3.0), share in -1.0..1.0_f64) {
        prop_assert!((so3::exp(&-v) * so3::exp(&v)).angle() < 1e-7);
        let (first, second) = (so3::exp(&(v * share)), so3::exp(&(v * (1.0 - share))));
        prop_assert!((first * second).angle_to(&so3::exp(&v)) < 1e-7);
    }

    #[test]
    fn exp_is_the_matrix_exponential_of_hat(v in vector(2.0)) {
        let (mut sum, mut term) = (Matrix3::identity(), Matrix3::identity());
        for order in 1..40 {
            term = term * so3::hat(&v) / f64::from(order);
            sum += term;
        }
        prop_assert!((so3::exp(&v).to_rotation_matrix().into_inner() - sum).norm() < 1e-12);
    }

    #[test]
    fn the_right_jacobian_matches_central_differences(v in vector(3.0)) {
        let inverse = so3::exp(&v).inverse();
        let numeric = central_differences(&v, 1e-6, |v| so3::log(&(inverse * so3::exp(v))));
        prop_assert!((numeric - so3::right_jacobian(&v)).norm() < 2e-7);
        let product = so3::right_jacobian(&v) * so3::right_jacobian_inverse(&v);
        prop_assert!((product - Matrix3::identity()).norm() < 1e-9);
        prop_assert!((so3::left_jacobian_inverse(&v) - so3::right_jacobian_inverse(&-v)).norm() < 1e-12);
    }

    #[test]
    fn the_derivative_of_the_inverse_left_jacobian_matches_central_differences(v in vector(3.0), t in vector(2.0)) {
        let numeric = central_differences(&v, 1e-6, |v| so3::left_jacobian_inverse(v) * t);
        let analytic = so3::left_jacobian_inverse_derivative(&v, &t);
        prop_assert!((numeric - analytic).norm() < 4e-6 * (1.0 + analytic.norm()));
    }

    #[test]
    fn local_inverts_retract(t in pose(), error in pose_error(3.0, 5.0)) {
        prop_assert!((se3::local(&t, &se3::retract(&t, &error)) - error).norm() < 1e-9);
    }

    #[test]
    fn retract_inverts_local(from in pose(), to in pose()) {
        prop_assert!(difference(&se3::retract(&from, &se3::local(&from, &to)), &to) < 1e-9);
    }

    #[test]
    fn an_error_belongs_to_the_child_so_a_motion_of_the_parent_does_not_change_it(
        motion in pose(), t in pose(), error in pose_error(3.0, 5.0),
    ) {
        prop_assert!(difference(&se3::retract(&(motion * t), &error), &(motion * se3::retract(&t, &error))) < 1e-9);
    }

    #[test]
    fn the_adjoint_maps_small_errors_from_child_to_parent_frame(t in pose(), error in pose_error(1e-5, 1e-5)) {
        let child_side = t * se3::retract(&Isometry::identity(), &error);
        let parent_side = se3::retract(&Isometry::identity(), &(se3::adjoint(&t) * error)) * t;
        prop_assert!(se3::local(&child_side, &parent_side).norm() < 1e-7);
    }

    #[test]
    fn the_adjoint_is_a_homomorphism(a in pose(), b in pose()) {
        let scale = 1.0 + se3::adjoint(&a).norm() * se3::adjoint(&b).norm();
        prop_assert!((se3::adjoint(&(a * b)) - se3::adjoint(&a) * se3::adjoint(&b)).norm() < 1e-12 * scale);
        let product = se3::adjoint(&a) * se3::adjoint(&a.inverse());
        prop_assert!((product - Matrix6::identity()).norm() < 1e-10 * scale);
    }

    #[test]
    fn interpolation_starts_and_ends_right_and_is_reversible(from in pose(), to in pose(), fraction in 0.0..1.0_f64) {
        prop_assert!(difference(&se3::interpolate(&from, &to, 0.0), &from) < 1e-12);
        prop_assert!(difference(&se3::interpolate(&from, &to, 1.0), &to) < 1e-9);
        let (forth, back) = (se3::interpolate(&from, &to, fraction), se3::interpolate(&to, &from, 1.0 - fraction));
        prop_assert!(difference(&forth, &back) < 1e-6);
    }

    #[test]
    fn framed_transforms_compose_as_isometries_and_invert(a in pose(), b in pose()) {
        let body_from_base = Transform::<Body, Base>::new(a);
        let base_from_lidar = Transform::<Base, Lidar>::new(b);
        let body_from_lidar: Transform<Body, Lidar> = body_from_base * base_from_lidar;
        prop_assert_eq!(body_from_lidar.isometry(), &(a * b));
        let lidar_from_body: Transform<Lidar, Body> = base_from_lidar.inverse() * body_from_base.inverse();
        prop_assert!(difference(lidar_from_body.isometry(), body_from_lidar.inverse().isometry()) < 1e-9);
    }

    #[test]
    fn a_known_similarity_is_recovered(
        points in prop::collection::vec(vector(10.0), 4..30), motion in pose(), scale in 0.2..5.0_f64,
    ) {
        let mean = points.iter().sum::<Vector3>() / points.len() as f64;
        let scatter: Matrix3 = points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
        prop_assume!(scatter.symmetric_eigenvalues().min() > 0.1);
        let pairs: Vec<_> =
            points.iter().map(|p| (motion.transform_point(&(p * scale).into()).coords, *p)).collect();
        let found = umeyama(&pairs, true).unwrap();
        prop_assert!((found.scale - scale).abs() < 1e-9 * scale.max(1.0));
        prop_assert!(difference(&found.truth_from_estimate, &motion) < 1e-7);
    }

    /// No other yaw and translation nearby is better than the one found.
    #[test]
    fn the_yaw_alignment_is_a_minimum(
        pairs in prop::collection::vec((vector(10.0), vector(10.0)), 3..20),
        yaw in -0.1..0.1_f64, shift in vector(0.5),
    ) {
        let found = align_yaw_only(&pairs).unwrap();
        prop_assert!((found.rotation * Vector3::z() - Vector3::z()).norm() < 1e-12);
        let turn = Rotation::from_axis_angle(&Vector3::z_axis(), yaw);
        let other = Isometry::from_parts(Translation3::from(found.translation.vector + shift), turn * found.rotation);
        prop_assert!(rms_distance(&pairs, &found) <= rms_distance(&pairs, &other) + 1e-9);
    }
}
