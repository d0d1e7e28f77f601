//! Directions of a pose that a scan does not observe, and normal equations without the information that only noise contributes.
//!
//! Measured surfaces are never perfectly flat. In a corridor without features, the noise of thousands of normals sums up to an
//! apparent information along its axis. It is a small share of the information about the strongest direction, so that share is
//! subtracted from all eigenvalues. Source of the analysis by eigenvalues: Zhang, Kaess, Singh, *On Degeneracy of
//! Optimization-based State Estimation Problems*, ICRA 2016.

use geometry::{Matrix3, Matrix6, Vector3, Vector6};
use nalgebra::SymmetricEigen;

/// Parameters that limit the information of a scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanInformationConfig {
    /// Scans with fewer downsampled points than this are not registered. Chosen: ten for each of the six components of a pose.
    pub min_points: usize,
    /// Information that noisy normals can contribute to an unobserved direction, as a share of the largest eigenvalue. Chosen: normals that err by 2 degrees contribute
    /// about a thousandth (the square of 0.03).
    pub eigenvalue_shrinkage: f64,
    /// Number of points that share one error (of map, calibration, timing) and therefore count as one. Chosen as a round number: with less, scans are trusted beyond
    /// their accuracy; with more, legs and IMU pull the pose. The graph uses it too (docs/maths/loops.md, equation 8).
    pub correlated_points: f64,
    /// Least lever arm at which rotations are compared with translations, metres. Chosen: the range of the nearest points that are used.
    pub min_lever_arm_m: f64,
}

impl Default for ScanInformationConfig {
    fn default() -> Self {
        Self { min_points: 60, eigenvalue_shrinkage: 1e-3, correlated_points: 10.0, min_lever_arm_m: 0.5 }
    }
}

/// Normal equations after [`shrink_eigenvalues`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShrunkEquations {
    /// Information, order `[rotation; translation]`.
    pub information: Matrix6,
    /// Gradient, reduced by the same factors in the same directions.
    pub gradient: Vector6,
}

/// Subtracts `share` of the largest eigenvalue from all eigenvalues (down to zero) and reduces the gradient in proportion
/// (docs/maths/odometry.md, equation 14). Rotations are compared with translations at `lever_arm_m` metres, the typical range of
/// the points.
pub fn shrink_eigenvalues(
    information: &Matrix6,
    gradient: &Vector6,
    lever_arm_m: f64,
    share: f64,
) -> ShrunkEquations {
    let scale = Vector6::new(1.0 / lever_arm_m, 1.0 / lever_arm_m, 1.0 / lever_arm_m, 1.0, 1.0, 1.0);
    let scaled = Matrix6::from_fn(|i, j| information[(i, j)] * scale[i] * scale[j]);
    let eigen = SymmetricEigen::new(scaled);
    let noise_floor = eigen.eigenvalues.max() * share;
    let mut kept_information = Matrix6::zeros();
    let mut kept_share = Matrix6::zeros();
    for index in 0..6 {
        let value = eigen.eigenvalues[index];
        let vector = eigen.eigenvectors.column(index);
        let rest = (value - noise_floor).max(0.0);
        let outer = vector * vector.transpose();
        kept_information += outer * rest;
        if value > 0.0 {
            kept_share += outer * (rest / value);
        }
    }
    let unscale = scale.map(|s| 1.0 / s);
    let gradient = (kept_share * gradient.component_mul(&scale)).component_mul(&unscale);
    let information = Matrix6::from_fn(|i, j| kept_information[(i, j)] * unscale[i] * unscale[j]);
    ShrunkEquations { information, gradient }
}

/// Directions of translation whose standard deviation, with the rotation unknown, exceeds `max_deviation_m` metres
/// (docs/maths/odometry.md, equation 18): unit vectors in the frame of the information, weakest first.
pub fn degenerate_directions(information: &Matrix6, max_deviation_m: f64) -> [Option<Vector3>; 3] {
    let rotation: Matrix3 = information.fixed_view::<3, 3>(0, 0).into();
    let coupling: Matrix3 = information.fixed_view::<3, 3>(0, 3).into();
    let translation: Matrix3 = information.fixed_view::<3, 3>(3, 3).into();
    let marginal = match rotation.try_inverse() {
        Some(inverse) => translation - coupling.transpose() * inverse * coupling,
        None => translation,
    };
    let eigen = SymmetricEigen::new((marginal + marginal.transpose()) * 0.5);
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    order.map(|index| {
        let is_degenerate = eigen.eigenvalues[index] * max_deviation_m * max_deviation_m < 1.0;
        is_degenerate.then(|| eigen.eigenvectors.column(index).into_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linearise::plane_jacobian;
    use geometry::RngTree;

    /// Points on floor, ceiling and walls of a corridor along x. Normals have an error of 0.01 rad. `end_points` more lie on a wall
    /// across the corridor.
    fn corridor(end_points: usize) -> (Matrix6, Vector6) {
        let mut rng = RngTree::new(1).child("corridor").rng();
        let mut information = Matrix6::zeros();
        let mut gradient = Vector6::zeros();
        let mut add = |point: Vector3, normal: Vector3, noise: Vector3| {
            let jacobian = plane_jacobian(&point, &(normal + noise * 0.01).normalize());
            information += jacobian * jacobian.transpose() * 1e4;
            gradient += jacobian * 1e4 * 0.003;
        };
        for index in 0..4_000 {
            let along = rng.range(-15.0, 15.0);
            let (y, z) = (rng.range(-1.2, 1.2), rng.range(-0.5, 2.0));
            let noise = Vector3::new(rng.normal(), rng.normal(), rng.normal());
            match index % 4 {
                0 => add(Vector3::new(along, y, -0.5), Vector3::z(), noise),
                1 => add(Vector3::new(along, y, 2.0), -Vector3::z(), noise),
                2 => add(Vector3::new(along, 1.2, z), -Vector3::y(), noise),
                _ => add(Vector3::new(along, -1.2, z), Vector3::y(), noise),
            }
        }
        for _ in 0..end_points {
            let (y, z) = (rng.range(-1.2, 1.2), rng.range(-0.5, 2.0));
            add(Vector3::new(18.0, y, z), -Vector3::x(), Vector3::zeros());
        }
        (information, gradient)
    }

    #[test]
    fn a_corridor_is_degenerate_along_its_axis_unless_its_end_is_visible() {
        let (information, gradient) = corridor(0);
        let open = shrink_eigenvalues(&information, &gradient, 8.0, 1e-3);
        let [Some(axis), None, None] = degenerate_directions(&open.information, 0.01) else {
            panic!("not one direction")
        };
        assert!(axis.x.abs() > 0.99, "{axis}");
        assert!(open.gradient[3].abs() < 0.05 * gradient.norm());

        let (information, gradient) = corridor(60);
        let closed = shrink_eigenvalues(&information, &gradient, 8.0, 1e-3);
        assert_eq!(degenerate_directions(&closed.information, 0.01), [None; 3]);
    }
}
