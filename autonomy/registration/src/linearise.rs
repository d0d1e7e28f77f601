//! One linearised look at how well a scan fits a map: the normal equations of all its points.
//!
//! Point to plane where the map is flat, point to distribution where it is not, each weighted by the inverse of its
//! variance and a robust kernel (Geman-McClure). Source of the residuals: Segal et al., *Generalized-ICP*, RSS 2009;
//! of the kernel's use as weights: Chebrolu et al., *Adaptive Robust Kernels*, RA-L 2021.

use geometry::{Isometry, Matrix3, Matrix6, Vector3, Vector6, so3};
use points::{Surface, SurfaceMap};

/// How points are matched and weighted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatchingConfig {
    /// A plane within this distance is taken without looking for a better one, metres.
    pub gate_m: f32,
    /// Residuals of this many standard deviations get a quarter of their weight.
    pub kernel_width: f32,
    /// Standard deviation of a point about its surface that the map cannot know, metres: range noise, motion.
    pub noise_m: f32,
    /// Whether cells that are not flat take part.
    pub use_distributions: bool,
    /// Whether planes that turn their other side to the body are left out: only maps that know from where their points were seen tell.
    pub front_facing_only: bool,
}

impl Default for MatchingConfig {
    fn default() -> Self {
        Self {
            gate_m: 0.1,
            kernel_width: 3.0,
            noise_m: 0.01,
            use_distributions: true,
            front_facing_only: false,
        }
    }
}

/// Normal equations of a scan at one pose, for a perturbation on the right, order `[rotation; translation]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalEquations {
    /// `sum w J' J`: information, if all points were independent.
    pub information: Matrix6,
    /// `sum w J' r`: half the gradient of the cost.
    pub gradient: Vector6,
    /// Sum of the robust costs, each at most `kernel²` (variances).
    pub cost: f64,
    /// Points that found a surface.
    pub matched: usize,
    /// Points within the kernel's width of their surface.
    pub inliers: usize,
}

impl Default for NormalEquations {
    fn default() -> Self {
        Self { information: Matrix6::zeros(), gradient: Vector6::zeros(), cost: 0.0, matched: 0, inliers: 0 }
    }
}

/// Residual of one point against a plane, and its 1x6 Jacobian for a right perturbation `[rotation; translation]` of
/// `map_from_body`.
///
/// - `point`: in the body frame, metres. - `normal_body`: the plane's unit normal turned into the body frame.
///
/// The residual is the signed distance, so its derivative by a translation in the body frame is the normal and by a
/// rotation `point x normal`. Total.
pub fn plane_jacobian(point: &Vector3, normal_body: &Vector3) -> Vector6 {
    let turn = point.cross(normal_body);
    Vector6::new(turn.x, turn.y, turn.z, normal_body.x, normal_body.y, normal_body.z)
}

/// Matches every point (body frame, metres) at a pose and sums the normal equations, in the points' order.
pub fn linearise<'a>(
    map: &impl SurfaceMap,
    points: impl IntoIterator<Item = &'a [f32; 3]>,
    map_from_body: &Isometry,
    options: &MatchingConfig,
) -> NormalEquations {
    let rotation = map_from_body.rotation.to_rotation_matrix().into_inner();
    let translation = map_from_body.translation.vector;
    let noise = options.noise_m * options.noise_m;
    let mut sum = NormalEquations::default();
    // Upper triangle of the planes' information; the matrix is filled at the end.
    let mut upper = [0.0_f64; 21];
    for point in points {
        let in_body = Vector3::new(f64::from(point[0]), f64::from(point[1]), f64::from(point[2]));
        let in_map = rotation * in_body + translation;
        let at = [in_map.x, in_map.y, in_map.z];
        let surface = match options.front_facing_only {
            true => map.find_surface_facing(&at, translation.as_ref(), options.gate_m),
            false => map.find_surface(&at, options.gate_m),
        };
        match surface {
            Some(Surface::Plane { normal, distance, variance }) => {
                let variance = f64::from(variance + noise);
                let distance = f64::from(distance);
                let weight = sum.count(distance * distance / variance, options.kernel_width) / variance;
                let normal = Vector3::new(f64::from(normal[0]), f64::from(normal[1]), f64::from(normal[2]));
                let jacobian = plane_jacobian(&in_body, &rotation.tr_mul(&normal));
                add_outer(&mut upper, &jacobian, weight);
                sum.gradient += jacobian * (weight * distance);
            }
            Some(Surface::Distribution { offset, covariance }) if options.use_distributions => {
                let offset = Vector3::new(f64::from(offset[0]), f64::from(offset[1]), f64::from(offset[2]));
                sum.add_distribution_residual(
                    &in_body,
                    &rotation,
                    &offset,
                    &covariance.map(f64::from),
                    f64::from(noise),
                    options,
                );
            }
            Some(Surface::Distribution { .. }) | None => {}
        }
    }
    let mut index = 0;
    for row in 0..6 {
        for column in row..6 {
            sum.information[(row, column)] += upper[index];
            if row != column {
                sum.information[(column, row)] += upper[index];
            }
            index += 1;
        }
    }
    sum
}

impl NormalEquations {
    /// Counts a match with that squared normalised residual; says its weight.
    #[inline]
    fn count(&mut self, squared: f64, kernel: f32) -> f64 {
        let width = f64::from(kernel).powi(2);
        let ratio = width / (width + squared);
        self.matched += 1;
        self.inliers += usize::from(squared < width);
        self.cost += squared * ratio;
        ratio * ratio
    }

    /// A point against a cell that is not flat: `r = p - mean`, weighted by the inverse covariance.
    fn add_distribution_residual(
        &mut self,
        in_body: &Vector3,
        rotation: &Matrix3,
        offset: &Vector3,
        covariance: &[f64; 6],
        noise: f64,
        options: &MatchingConfig,
    ) {
        let [xx, xy, xz, yy, yz, zz] = *covariance;
        let covariance = Matrix3::new(xx + noise, xy, xz, xy, yy + noise, yz, xz, yz, zz + noise);
        let Some(inverse) = covariance.try_inverse() else { return };
        let squared = offset.dot(&(inverse * offset));
        let weight = self.count(squared, options.kernel_width);
        // In the body frame: J = [-hat(p), I].
        let inverse_body = rotation.tr_mul(&inverse) * rotation * weight;
        let offset_body = rotation.tr_mul(offset);
        let hat = so3::hat(in_body);
        let pulled = inverse_body * offset_body;
        let corner = hat * inverse_body;
        let mut information = Matrix6::zeros();
        information.fixed_view_mut::<3, 3>(0, 0).copy_from(&(-corner * hat));
        information.fixed_view_mut::<3, 3>(0, 3).copy_from(&corner);
        information.fixed_view_mut::<3, 3>(3, 0).copy_from(&corner.transpose());
        information.fixed_view_mut::<3, 3>(3, 3).copy_from(&inverse_body);
        self.information += information;
        let turn = hat * pulled;
        self.gradient += Vector6::new(turn.x, turn.y, turn.z, pulled.x, pulled.y, pulled.z);
    }
}

#[inline]
fn add_outer(upper: &mut [f64; 21], jacobian: &Vector6, weight: f64) {
    let mut index = 0;
    for row in 0..6 {
        let scaled = jacobian[row] * weight;
        for column in row..6 {
            upper[index] += scaled * jacobian[column];
            index += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{RngTree, se3};
    use points::{GaussianMap, GaussianMapConfig};

    #[test]
    fn the_plane_jacobian_matches_central_differences() {
        let mut rng = RngTree::new(4).child("plane").rng();
        for _ in 0..100 {
            let mut random = || Vector3::new(rng.normal(), rng.normal(), rng.normal());
            let pose = Isometry::new(random(), random());
            let (point, normal, mean) = (random() * 5.0, random().normalize(), random());
            let residual =
                |pose: &Isometry| normal.dot(&(pose.rotation * point + pose.translation.vector - mean));
            let analytic = plane_jacobian(&point, &(pose.rotation.inverse() * normal));
            for axis in 0..6 {
                let mut step = Vector6::zeros();
                step[axis] = 1e-6;
                let numeric =
                    (residual(&se3::retract(&pose, &step)) - residual(&se3::retract(&pose, &-step))) / 2e-6;
                assert!((numeric - analytic[axis]).abs() < 1e-7);
            }
        }
    }

    /// The summed gradient is the derivative of half the summed squares while weights are held: with the kernel wide
    /// open, of the cost itself.
    #[test]
    fn the_gradient_matches_central_differences_of_the_cost() {
        let mut rng = RngTree::new(4).child("cost").rng();
        let mut map = GaussianMap::new(GaussianMapConfig::default());
        for _ in 0..30_000 {
            map.insert(&[2.0 + 0.01 * rng.normal(), rng.range(-3.0, 3.0), rng.range(-3.0, 3.0)]);
            map.insert(&[-1.0 + 0.15 * rng.normal(), -1.0 + 0.15 * rng.normal(), 0.4 + 0.15 * rng.normal()]);
        }
        let options = MatchingConfig { kernel_width: 1e4, gate_m: 0.3, ..MatchingConfig::default() };
        let points: Vec<[f32; 3]> =
            vec![[1.98, 0.2, 0.3], [2.03, -1.4, 0.6], [-1.03, -1.02, 0.42], [-1.1, -0.93, 0.35]];
        let pose = Isometry::identity();
        let at = linearise(&map, &points, &pose, &options);
        assert_eq!((at.matched, at.inliers), (4, 4));
        for axis in 0..6 {
            let mut step = Vector6::zeros();
            step[axis] = 1e-5;
            let cost = |step: &Vector6| linearise(&map, &points, &se3::retract(&pose, step), &options).cost;
            let numeric = (cost(&step) - cost(&-step)) / 2e-5 / 2.0;
            let scale = at.gradient.norm();
            assert!(
                (numeric - at.gradient[axis]).abs() < 2e-3 * scale,
                "{axis}: {numeric} {}",
                at.gradient[axis]
            );
        }
    }
}
