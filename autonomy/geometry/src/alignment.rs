//! Least-squares alignment of an estimated trajectory or point set with the true one.
//!
//! Source: S. Umeyama, "Least-Squares Estimation of Transformation Parameters Between Two Point Patterns", IEEE TPAMI
//! 13(4), 1991.

use crate::{Isometry, Matrix3, Rotation, Vector3};
use nalgebra::{Point3, Rotation3, Translation3};

/// A similarity transform: a scale, then a rigid motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// Factor applied to the estimate's translations first.
    pub scale: f64,
    /// Rigid motion applied after the scale.
    pub truth_from_estimate: Isometry,
}

impl Similarity {
    /// Scale 1 and no motion.
    pub fn identity() -> Self {
        Self { scale: 1.0, truth_from_estimate: Isometry::identity() }
    }

    /// An estimated pose expressed in the frame of the truth.
    pub fn apply(&self, pose: &Isometry) -> Isometry {
        let scaled =
            Isometry::from_parts(Translation3::from(pose.translation.vector * self.scale), pose.rotation);
        self.truth_from_estimate * scaled
    }
}

/// The similarity that minimises the sum of squared distances between the truth and the transformed estimate. With `with_scale` false, its scale
/// is 1. `None` for fewer than three points or for points on one line, because both leave a rotation undetermined.
///
/// - `pairs`: (truth, estimate), metres.
pub fn umeyama(pairs: &[(Vector3, Vector3)], with_scale: bool) -> Option<Similarity> {
    if pairs.len() < 3 {
        return None;
    }
    let count = pairs.len() as f64;
    let mean = |pick: fn(&(Vector3, Vector3)) -> Vector3| pairs.iter().map(pick).sum::<Vector3>() / count;
    let (truth_mean, estimate_mean) = (mean(|pair| pair.0), mean(|pair| pair.1));
    // Equations 36 to 38.
    let mut covariance = Matrix3::zeros();
    let mut variance = 0.0;
    for (truth, estimate) in pairs {
        let centred = estimate - estimate_mean;
        covariance += (truth - truth_mean) * centred.transpose() / count;
        variance += centred.norm_squared() / count;
    }
    let svd = covariance.svd(true, true);
    let (u, v_transposed) = (svd.u?, svd.v_t?);
    if svd.singular_values[1] <= 1e-9 * svd.singular_values[0].max(1e-9) {
        return None;
    }
    // Equation 39: no reflection.
    let mut sign = Vector3::new(1.0, 1.0, 1.0);
    if u.determinant() * v_transposed.determinant() < 0.0 {
        sign.z = -1.0;
    }
    // Equations 40 to 42.
    let rotation = u * Matrix3::from_diagonal(&sign) * v_transposed;
    let scale = if with_scale { svd.singular_values.dot(&sign) / variance } else { 1.0 };
    let translation = truth_mean - rotation * estimate_mean * scale;
    let rotation = Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
    let truth_from_estimate = Isometry::from_parts(Translation3::from(translation), rotation);
    Some(Similarity { scale, truth_from_estimate })
}

/// The rotation about z and the translation that minimise the sum of squared distances between the truth and the transformed estimate. For two
/// frames whose z axes are vertical. `None` for fewer than two points, or for points that all lie on one vertical line, because both leave the
/// yaw undetermined.
///
/// - `pairs`: (truth, estimate), metres.
pub fn align_yaw_only(pairs: &[(Vector3, Vector3)]) -> Option<Isometry> {
    let count = pairs.len() as f64;
    let mean = |pick: fn(&(Vector3, Vector3)) -> Vector3| pairs.iter().map(pick).sum::<Vector3>() / count;
    let (truth_mean, estimate_mean) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let (mut along, mut across, mut spread) = (0.0, 0.0, 0.0);
    for (truth, estimate) in pairs {
        let (t, e) = ((truth - truth_mean).xy(), (estimate - estimate_mean).xy());
        along += t.dot(&e);
        across += e.perp(&t);
        spread += t.norm_squared() + e.norm_squared();
    }
    if pairs.len() < 2 || along.hypot(across) <= 1e-9 * spread.max(1e-9) {
        return None;
    }
    let yaw = Rotation::from_axis_angle(&Vector3::z_axis(), across.atan2(along));
    Some(Isometry::from_parts(Translation3::from(truth_mean - yaw * estimate_mean), yaw))
}

/// Root mean square distance after the best rigid motion, metres (absolute trajectory error). `None` where [`umeyama`] finds no
/// motion.
///
/// - `pairs`: (truth, estimate), metres.
pub fn aligned_rmse(pairs: &[(Vector3, Vector3)]) -> Option<f64> {
    Some(rms_distance(pairs, &umeyama(pairs, false)?.truth_from_estimate))
}

/// Root mean square distance of pairs (truth, estimate) after a given motion, metres. NaN for an empty slice.
pub fn rms_distance(pairs: &[(Vector3, Vector3)], truth_from_estimate: &Isometry) -> f64 {
    let square = |(truth, estimate): &(Vector3, Vector3)| {
        (truth_from_estimate.transform_point(&Point3::from(*estimate)).coords - truth).norm_squared()
    };
    (pairs.iter().map(square).sum::<f64>() / pairs.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn umeyama_recovers_a_known_motion_and_scale() {
        let motion = Isometry::from_parts(
            Translation3::new(3.0, -2.0, 0.5),
            Rotation::from_euler_angles(0.3, -0.8, 2.5),
        );
        let points: Vec<Vector3> =
            (0..20).map(f64::from).map(|t| Vector3::new(t.sin() * 4.0, t * 0.3, (0.7 * t).cos())).collect();
        let pairs: Vec<_> = points.iter().map(|p| (motion * Point3::from(p * 1.7), *p)).collect();
        let pairs: Vec<_> = pairs.into_iter().map(|(truth, estimate)| (truth.coords, estimate)).collect();
        let Some(found) = umeyama(&pairs, true) else { panic!("enough points") };
        assert!((found.scale - 1.7).abs() < 1e-9);
        assert!((found.truth_from_estimate.to_homogeneous() - motion.to_homogeneous()).norm() < 1e-9);
    }

    #[test]
    fn points_on_a_line_leave_a_rotation_undetermined() {
        let pairs: Vec<_> = (0..9).map(|i| Vector3::new(f64::from(i), 0.0, 0.0)).map(|p| (p, p)).collect();
        assert_eq!(umeyama(&pairs, false), None);
    }

    #[test]
    fn yaw_alignment_needs_two_points_that_are_not_above_each_other() {
        let motion = Isometry::from_parts(
            Translation3::new(3.0, -2.0, 0.5),
            Rotation::from_euler_angles(0.0, 0.0, -2.8),
        );
        let points =
            [Vector3::new(1.0, 2.0, 3.0), Vector3::new(-4.0, 1.0, 2.0), Vector3::new(2.0, 2.5, -1.0)];
        let pairs = points.map(|p| ((motion * Point3::from(p)).coords, p));
        for count in [2, 3] {
            let Some(found) = align_yaw_only(&pairs[..count]) else { panic!("enough points") };
            assert!((found.to_homogeneous() - motion.to_homogeneous()).norm() < 1e-9);
        }
        let above = [0.0, 1.0].map(|z| Vector3::new(1.0, 1.0, z)).map(|p| (p, p));
        assert_eq!((align_yaw_only(&pairs[..1]), align_yaw_only(&above)), (None, None));
        assert_eq!(align_yaw_only(&[]), None);
    }

    #[test]
    fn aligned_rmse_is_the_residual_that_remains_after_alignment() {
        let corners = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
        // The corners lie alternately 0.1 m above and below a plane. No rigid motion removes that.
        let pairs: Vec<_> = corners
            .map(|[x, y]| (Vector3::new(x, y, 0.1 * x * y), Vector3::new(5.0 - y, x, 2.0)))
            .into_iter()
            .collect();
        assert!(aligned_rmse(&pairs).is_some_and(|rmse| (rmse - 0.1).abs() < 1e-12));
    }
}
