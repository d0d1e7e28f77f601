//! Derivatives equal central differences, known poses are recovered, and degenerate directions are found, on random inputs.
#![allow(clippy::unwrap_used, reason = "a test stops at what it did not expect")]

use geometry::{Isometry, Matrix6, Rng, RngTree, Rotation, Vector3, Vector6, se3, so3};
use nalgebra::Translation3;
use points::{GaussianMap, GaussianMapConfig};
use proptest::prelude::*;
use registration::linearise::plane_jacobian;
use registration::{
    MatchingConfig, MultiStartConfig, degenerate_directions, linearise, multi_start, refine,
    shrink_eigenvalues,
};
use std::sync::OnceLock;

fn vector(max: f64) -> impl Strategy<Value = Vector3> {
    [-max..max, -max..max, -max..max].prop_map(Vector3::from)
}

fn direction() -> impl Strategy<Value = Vector3> {
    vector(1.0).prop_filter("no direction", |v| v.norm() > 0.1).prop_map(|v| v.normalize())
}

fn pose(max_angle: f64, max_distance: f64) -> impl Strategy<Value = Isometry> {
    (direction(), 0.0..max_angle, vector(max_distance))
        .prop_map(|(axis, angle, t)| Isometry::from_parts(Translation3::from(t), so3::exp(&(axis * angle))))
}

/// A room of 8 x 6 x 3 m with a column and a cupboard.
fn room(seed: u64, points: usize) -> Vec<Vector3> {
    let mut rng = RngTree::new(seed).child("room").rng();
    (0..points)
        .map(|index| {
            let (a, b, n) = (rng.uniform(), rng.uniform(), rng.normal() * 0.01);
            match index % 9 {
                0 | 1 => Vector3::new(8.0 * a - 4.0, 6.0 * b - 3.0, -0.5 + n),
                2 => Vector3::new(8.0 * a - 4.0, 6.0 * b - 3.0, 2.5 + n),
                3 => Vector3::new(4.0 + n, 6.0 * a - 3.0, 3.0 * b - 0.5),
                4 => Vector3::new(-4.0 + n, 6.0 * a - 3.0, 3.0 * b - 0.5),
                5 => Vector3::new(8.0 * a - 4.0, 3.0 + n, 3.0 * b - 0.5),
                6 => Vector3::new(8.0 * a - 4.0, -3.0 + n, 3.0 * b - 0.5),
                7 => Vector3::new(2.0 + n, a - 2.0, 3.0 * b - 0.5),
                _ => Vector3::new(-4.0 + 1.5 * a, 1.6 + n, 2.0 * b - 0.5),
            }
        })
        .collect()
}

fn room_map() -> &'static GaussianMap {
    static MAP: OnceLock<GaussianMap> = OnceLock::new();
    MAP.get_or_init(|| {
        let mut map = GaussianMap::new(GaussianMapConfig::default());
        for point in room(1, 40_000) {
            map.insert(point.as_ref());
        }
        map
    })
}

/// Other points of the room, seen from a pose.
fn scan_from(map_from_body: &Isometry) -> Vec<[f32; 3]> {
    room(2, 600)
        .iter()
        .map(|point| map_from_body.inverse_transform_point(&(*point).into()).coords.map(|c| c as f32).into())
        .collect()
}

/// A wall at x = 2 m and a ball-shaped cloud, both far from any other surface.
fn wall_and_ball() -> &'static GaussianMap {
    static MAP: OnceLock<GaussianMap> = OnceLock::new();
    MAP.get_or_init(|| {
        let mut rng = RngTree::new(4).child("cost").rng();
        let mut map = GaussianMap::new(GaussianMapConfig::default());
        for _ in 0..30_000 {
            map.insert(&[2.0 + 0.01 * rng.normal(), rng.range(-3.0, 3.0), rng.range(-3.0, 3.0)]);
            map.insert(&[-1.0 + 0.15 * rng.normal(), -1.0 + 0.15 * rng.normal(), 0.4 + 0.15 * rng.normal()]);
        }
        map
    })
}

/// The share scales what a point in a cell that is not flat contributes, and nothing else.
#[test]
fn the_share_of_cells_that_are_not_flat_leaves_planes_alone() {
    let whole = MatchingConfig::default();
    let quarter = MatchingConfig { distribution_share: 0.25, ..whole };
    for (point, factor) in [([2.01, 0.3, 0.5], 1.0), ([-0.95, -1.0, 0.45], 0.25)] {
        let [whole, scaled] = [whole, quarter]
            .map(|matching| linearise(wall_and_ball(), &[point], &Isometry::identity(), &matching));
        assert_eq!((whole.matched, scaled.matched), (1, 1));
        assert!((whole.information * factor - scaled.information).norm() < 1e-9 * whole.information.norm());
        assert!((whole.gradient * factor - scaled.gradient).norm() < 1e-9 * whole.gradient.norm());
    }
}

/// A random information matrix: eigenvalues between 1 and 1e4 in random directions.
fn random_information(rng: &mut Rng) -> Matrix6 {
    let columns = Matrix6::from_fn(|_, _| rng.normal());
    let basis = columns.qr().q();
    let values = Vector6::from_fn(|_, _| 10.0_f64.powf(rng.range(0.0, 4.0)));
    basis * Matrix6::from_diagonal(&values) * basis.transpose()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_plane_jacobian_matches_central_differences(
        pose in pose(3.0, 5.0), point in vector(20.0), normal in direction(), mean in vector(5.0),
    ) {
        let residual = |pose: &Isometry| normal.dot(&(pose.rotation * point + pose.translation.vector - mean));
        let analytic = plane_jacobian(&point, &(pose.rotation.inverse() * normal));
        for axis in 0..6 {
            let mut step = Vector6::zeros();
            step[axis] = 1e-6;
            let numeric = (residual(&se3::retract(&pose, &step)) - residual(&se3::retract(&pose, &-step))) / 2e-6;
            prop_assert!((numeric - analytic[axis]).abs() < 1e-6);
        }
    }

    /// With a very wide kernel all weights are 1, and the gradient is half the derivative of the cost. The points stay away from the borders of
    /// cubes, where the surface changes.
    #[test]
    fn the_gradient_matches_central_differences_of_the_cost(
        height in -0.02..0.02_f64,
        along in (-0.6..1.3_f64, -0.4..1.5_f64),
        in_ball in (-0.05..0.1_f64, -0.1..0.09_f64, -0.08..0.1_f64),
    ) {
        let options = MatchingConfig { kernel_width: 1e4, ..MatchingConfig::default() };
        let points = [
            [2.0 + height, along.0, along.1].map(|c| c as f32),
            [in_ball.0 - 1.0, in_ball.1 - 1.0, in_ball.2 + 0.4].map(|c| c as f32),
        ];
        let map = wall_and_ball();
        let at = linearise(map, &points, &Isometry::identity(), &options);
        prop_assert_eq!((at.matched, at.inliers), (2, 2));
        let cost = |step: &Vector6| linearise(map, &points, &se3::retract(&Isometry::identity(), step), &options).cost;
        for axis in 0..6 {
            let mut step = Vector6::zeros();
            step[axis] = 1e-4;
            let numeric = (cost(&step) - cost(&-step)) / 2e-4 / 2.0;
            // Surfaces are stored as f32, so the cost is exact to about 1e-6 of the residuals.
            let scale = at.gradient.norm() + at.information.trace().sqrt();
            prop_assert!((numeric - at.gradient[axis]).abs() < 1e-2 * scale, "{axis}: {numeric} {}", at.gradient[axis]);
        }
    }

    /// Subtracts the same amount from every eigenvalue, but never below zero. Directions that remain keep their solution.
    #[test]
    fn shrinking_subtracts_the_same_amount_from_every_eigenvalue(seed in any::<u64>(), share in 1e-4..0.5_f64) {
        let mut rng = RngTree::new(seed).rng();
        let information = random_information(&mut rng);
        let solution = Vector6::from_fn(|_, _| rng.normal());
        let gradient = information * solution;
        let shrunk = shrink_eigenvalues(&information, &gradient, 1.0, share);
        let sorted = |matrix: &Matrix6| {
            let mut values: Vec<f64> = matrix.symmetric_eigenvalues().iter().copied().collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let (before, after) = (sorted(&information), sorted(&shrunk.information));
        for (before_value, after_value) in before.iter().zip(&after) {
            prop_assert!((after_value - (before_value - share * before[5]).max(0.0)).abs() < 1e-9 * before[5]);
        }
        // In the remaining directions the solution is unchanged.
        prop_assert!((shrunk.information * solution - shrunk.gradient).norm() < 1e-8 * before[5]);
    }

    /// The degenerate directions are those in which the covariance, with the rotation unknown, exceeds the limit.
    #[test]
    fn degenerate_directions_are_those_of_a_large_marginal_covariance(seed in any::<u64>(), limit_m in 0.01..1.0_f64) {
        let information = random_information(&mut RngTree::new(seed).rng());
        let covariance = information.try_inverse().unwrap().fixed_view::<3, 3>(3, 3).into_owned();
        let mut deviations: Vec<f64> = covariance.symmetric_eigenvalues().iter().map(|v| v.sqrt()).collect();
        deviations.sort_by(|a, b| b.total_cmp(a));
        prop_assume!(deviations.iter().all(|deviation| (deviation / limit_m - 1.0).abs() > 1e-6));
        let found = degenerate_directions(&information, limit_m);
        for (direction, deviation) in found.iter().zip(deviations) {
            prop_assert_eq!(direction.is_some(), deviation > limit_m);
            if let Some(axis) = direction {
                prop_assert!(((axis.transpose() * covariance * axis)[0].sqrt() - deviation).abs() < 1e-6 * deviation);
            }
        }
    }

    /// Planes whose normals are all perpendicular to an axis leave the translation along it undetermined.
    #[test]
    fn an_axis_perpendicular_to_all_normals_is_degenerate(seed in any::<u64>(), axis in direction(), also_end in any::<bool>()) {
        let mut rng = RngTree::new(seed).rng();
        let mut information = Matrix6::zeros();
        let frame = Rotation::rotation_between(&Vector3::x(), &axis).unwrap_or_else(|| so3::exp(&(Vector3::z() * std::f64::consts::PI)));
        for index in 0..400 {
            let angle = rng.range(0.0, std::f64::consts::TAU);
            let normal = match index {
                0..40 if also_end => Vector3::x(),
                _ => Vector3::new(0.0, angle.cos(), angle.sin()),
            };
            let point = Vector3::new(rng.range(-10.0, 10.0), rng.range(-2.0, 2.0), rng.range(-2.0, 2.0));
            let jacobian = plane_jacobian(&(frame * point), &(frame * normal));
            information += jacobian * jacobian.transpose() * 1e4;
        }
        let found = degenerate_directions(&information, 0.01);
        if also_end {
            prop_assert_eq!(found, [None; 3]);
        } else {
            prop_assert!(found[0].unwrap().dot(&axis).abs() > 0.999);
            prop_assert_eq!([found[1], found[2]], [None; 2]);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_known_pose_is_recovered_from_nearby(truth in pose(0.5, 0.5), error in pose(0.08, 0.1)) {
        let matching = MatchingConfig { gate_m: 0.2, noise_m: 0.03, ..MatchingConfig::default() };
        let found = refine(room_map(), &scan_from(&truth), &(truth * error), &matching, 25);
        prop_assert!(found.score > 0.8, "{}", found.score);
        prop_assert!(se3::local(&truth, &found.map_from_body).norm() < 0.02, "{}", found.map_from_body);
    }
}

/// 49 degrees of yaw and 0.5 m are too far for one initial pose, but not for many.
#[test]
fn multi_start_finds_a_rotated_scan_that_one_start_misses() {
    let truth = Isometry::new(Vector3::new(0.4, -0.3, 0.1), Vector3::new(0.05, -0.08, 0.85));
    let scan = scan_from(&truth);
    let matching = MatchingConfig { gate_m: 0.2, noise_m: 0.03, ..MatchingConfig::default() };
    let one = refine(room_map(), &scan, &Isometry::identity(), &matching, 20);
    let starts = [Isometry::identity()];
    let found = multi_start(room_map(), &scan, &starts, &matching, &MultiStartConfig::default()).unwrap();
    assert!(found.score > 0.8 && found.score > one.score, "{} {}", found.score, one.score);
    assert!(se3::local(&truth, &found.map_from_body).norm() < 0.05, "{}", found.map_from_body);
}
