//! The normal equations of a scan against a map, linearised at one pose.
//!
//! Residuals are point to plane where the map is flat and point to distribution elsewhere. Each is weighted by its inverse variance
//! and a robust kernel (Geman-McClure). Equations: docs/maths/odometry.md, equations 10 to 13. Sources: Segal et al.,
//! *Generalized-ICP*, RSS 2009, for the residuals; Chebrolu et al., *Adaptive Robust Kernels*, RA-L 2021, for the kernel as a
//! weight.

use geometry::{Isometry, Matrix3, Matrix6, Vector3, Vector6, so3};
use points::{Surface, SurfaceMap};

/// How points are matched with surfaces and weighted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatchingConfig {
    /// The first plane within this distance of a point is its match, metres; without one, a nearest plane is searched for. Chosen: ten times [`Self::noise_m`].
    pub gate_m: f32,
    /// Width of the robust kernel in standard deviations. A residual of that size keeps a quarter of its weight. Source: the usual three standard deviations.
    pub kernel_width: f32,
    /// Standard deviation of a point about its surface beside the spread that the map has measured, metres: range noise, motion. Chosen: the noise of a LiDAR.
    pub noise_m: f32,
    /// Whether cells that are not flat are matched too. Chosen: edges and small surfaces are used too.
    pub use_distributions: bool,
    /// Share of its information with which a point against a cell that is not flat counts. 1 divided by the number of points that the scan has in such a
    /// cell: they share one error, because a scan sees another part of the cell's content than the map has seen.
    pub distribution_share: f64,
    /// Whether planes that face away from the viewpoint are left out. Needs a map whose points were inserted with their viewpoints. Chosen: other maps have no sides.
    pub front_facing_only: bool,
}

impl Default for MatchingConfig {
    fn default() -> Self {
        Self {
            gate_m: 0.1,
            kernel_width: 3.0,
            noise_m: 0.01,
            use_distributions: true,
            distribution_share: 1.0,
            front_facing_only: false,
        }
    }
}

impl MatchingConfig {
    /// For a first registration with the thinned clouds of keyframes, from a start that is wrong by some decimetres.
    pub fn coarse() -> Self {
        Self { gate_m: 0.25, noise_m: 0.05, ..Self::default() }
    }

    /// For the refinement of what [`Self::coarse`] has found.
    pub fn fine() -> Self {
        Self { gate_m: 0.15, noise_m: 0.02, ..Self::default() }
    }

    /// The same with gate and kernel wider by a factor.
    pub fn widened(&self, factor: f32) -> Self {
        Self { gate_m: self.gate_m * factor, kernel_width: self.kernel_width * factor, ..*self }
    }
}

/// Normal equations of a scan at one pose, for an error on the right, order `[rotation; translation]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalEquations {
    /// `H = sum w Jᵀ J`, rad and m: the information if all points were independent.
    pub information: Matrix6,
    /// `g = sum w Jᵀ r`: half the gradient of the cost.
    pub gradient: Vector6,
    /// Sum of the robust costs, each at most the squared kernel width (dimensionless).
    pub cost: f64,
    /// Number of points that found a surface.
    pub matched: usize,
    /// Number of points whose residual is less than the kernel width.
    pub inliers: usize,
    /// Sum of the robust weights of the matches with planes (dimensionless).
    plane_weight: f64,
    /// Sum of their squared distances, each with its robust weight, square metres.
    plane_squares_m2: f64,
}

impl Default for NormalEquations {
    fn default() -> Self {
        Self {
            information: Matrix6::zeros(),
            gradient: Vector6::zeros(),
            cost: 0.0,
            matched: 0,
            inliers: 0,
            plane_weight: 0.0,
            plane_squares_m2: 0.0,
        }
    }
}

/// Jacobian (1x6, as a column) of the point-to-plane residual for an error `[rotation; translation]` on the right of
/// `map_from_body` (docs/maths/odometry.md, equation 10).
///
/// - `point`: body frame, metres.
/// - `normal_body`: unit normal of the plane, rotated into the body frame.
///
/// The residual is the signed distance. Its derivative by a translation in the body frame is the normal, and by a rotation
/// `point × normal`.
pub fn plane_jacobian(point: &Vector3, normal_body: &Vector3) -> Vector6 {
    let by_rotation = point.cross(normal_body);
    Vector6::new(by_rotation.x, by_rotation.y, by_rotation.z, normal_body.x, normal_body.y, normal_body.z)
}

/// Matches every point (body frame, metres) with the map at a pose and sums up the normal equations, in the order of the points. The viewpoint is
/// the origin of the body.
pub fn linearise<'a>(
    map: &impl SurfaceMap,
    points: impl IntoIterator<Item = &'a [f32; 3]>,
    map_from_body: &Isometry,
    matching: &MatchingConfig,
) -> NormalEquations {
    linearise_from_viewpoint(map, points, map_from_body, &Vector3::zeros(), matching)
}

/// As [`linearise`], for points that were seen from a viewpoint (body frame, metres). It decides which side of a thin surface was seen.
pub fn linearise_from_viewpoint<'a>(
    map: &impl SurfaceMap,
    points: impl IntoIterator<Item = &'a [f32; 3]>,
    map_from_body: &Isometry,
    viewpoint: &Vector3,
    matching: &MatchingConfig,
) -> NormalEquations {
    let rotation = map_from_body.rotation.to_rotation_matrix().into_inner();
    let translation = map_from_body.translation.vector;
    let viewpoint = rotation * viewpoint + translation;
    let noise_variance = matching.noise_m * matching.noise_m;
    let mut sum = NormalEquations::default();
    // Upper triangle of the information of all planes. It is copied into the matrix at the end.
    let mut upper = [0.0_f64; 21];
    for point in points {
        let in_body = Vector3::new(f64::from(point[0]), f64::from(point[1]), f64::from(point[2]));
        let in_map = rotation * in_body + translation;
        let at = [in_map.x, in_map.y, in_map.z];
        let surface = match matching.front_facing_only {
            true => map.find_surface_facing(&at, viewpoint.as_ref(), matching.gate_m),
            false => map.find_surface(&at, matching.gate_m),
        };
        match surface {
            Some(Surface::Plane { normal, distance, variance }) => {
                let variance = f64::from(variance + noise_variance);
                let distance = f64::from(distance);
                let robust = sum.add_match(distance * distance / variance, matching.kernel_width);
                sum.plane_weight += robust;
                sum.plane_squares_m2 += robust * distance * distance;
                let weight = robust / variance;
                let normal = Vector3::new(f64::from(normal[0]), f64::from(normal[1]), f64::from(normal[2]));
                let jacobian = plane_jacobian(&in_body, &rotation.tr_mul(&normal));
                add_outer(&mut upper, &jacobian, weight);
                sum.gradient += jacobian * (weight * distance);
            }
            Some(Surface::Distribution { offset, covariance }) if matching.use_distributions => {
                let offset = Vector3::new(f64::from(offset[0]), f64::from(offset[1]), f64::from(offset[2]));
                sum.add_distribution(
                    &in_body,
                    &rotation,
                    &offset,
                    &covariance.map(f64::from),
                    f64::from(noise_variance),
                    matching,
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
    /// Standard deviation of the points about the planes that they are matched with, by their robust weights, metres: the noise of the sensor across surfaces,
    /// as it is after downsampling. None if no point is matched with a plane.
    pub fn plane_deviation_m(&self) -> Option<f64> {
        let variance_m2 = self.plane_squares_m2 / self.plane_weight;
        variance_m2.is_finite().then(|| variance_m2.sqrt())
    }

    /// Counts a match with a squared normalised residual and returns its robust weight (docs/maths/odometry.md, equation 12).
    #[inline]
    fn add_match(&mut self, squared: f64, kernel_width: f32) -> f64 {
        let width_squared = f64::from(kernel_width).powi(2);
        let ratio = width_squared / (width_squared + squared);
        self.matched += 1;
        self.inliers += usize::from(squared < width_squared);
        self.cost += squared * ratio;
        ratio * ratio
    }

    /// Adds a point against a cell that is not flat: `r = p - mean`, weighted by the inverse covariance (docs/maths/odometry.md,
    /// equation 11).
    fn add_distribution(
        &mut self,
        in_body: &Vector3,
        rotation: &Matrix3,
        offset: &Vector3,
        covariance: &[f64; 6],
        noise_variance: f64,
        matching: &MatchingConfig,
    ) {
        let [xx, xy, xz, yy, yz, zz] = *covariance;
        let covariance = Matrix3::new(
            xx + noise_variance,
            xy,
            xz,
            xy,
            yy + noise_variance,
            yz,
            xz,
            yz,
            zz + noise_variance,
        );
        let Some(inverse) = covariance.try_inverse() else { return };
        let squared = offset.dot(&(inverse * offset));
        let weight = self.add_match(squared, matching.kernel_width) * matching.distribution_share;
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
        let by_rotation = hat * pulled;
        self.gradient +=
            Vector6::new(by_rotation.x, by_rotation.y, by_rotation.z, pulled.x, pulled.y, pulled.z);
    }
}

/// Adds `weight * jacobian * jacobianᵀ` to an upper triangle, row by row.
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
