//! A relative pose with the covariance of its error, and how such poses compose (docs/maths/loops.md, equations 1 to 3).

use geometry::{Isometry, Matrix6, Vector6, se3};

/// Variance of a direction without information, rad² or m². Its standard deviation of 100 is larger than any error that a gate of this
/// crate accepts, and small enough for the covariance to stay well conditioned.
const UNKNOWN_VARIANCE: f64 = 1e4;

/// Threshold for squared Mahalanobis distances of six-dimensional errors: the 99.9 % quantile of the chi-squared distribution with six
/// degrees of freedom.
pub const CHI_SQUARED_6_999: f64 = 22.46;

/// When an estimate of a relative pose is certain: it tells a place from the next one that looks like it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseCertaintyConfig {
    /// Greatest standard deviation of the position, metres. A third of the least distance at which things repeat (racks, columns, doors).
    pub max_std_m: f64,
}

impl Default for PoseCertaintyConfig {
    fn default() -> Self {
        Self { max_std_m: 0.4 }
    }
}

/// A relative pose with the covariance of its error, `[rotation; translation]` in rad and m, perturbed on the right: the error is
/// expressed in the frame of the child.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UncertainPose {
    /// Pose of the child in the parent.
    pub pose: Isometry,
    /// Covariance of `retract(pose, error)`.
    pub covariance: Matrix6,
}

impl UncertainPose {
    /// The identity with zero covariance.
    pub fn identity() -> Self {
        Self { pose: Isometry::identity(), covariance: Matrix6::zeros() }
    }

    /// From a pose and its information matrix. Directions without information get a variance of 1e4 rad² or m².
    pub fn from_information(pose: Isometry, information: &Matrix6) -> Self {
        let held = information + Matrix6::identity() / UNKNOWN_VARIANCE;
        let covariance = held
            .cholesky()
            .map_or_else(|| Matrix6::identity() * UNKNOWN_VARIANCE, |factor| symmetric(&factor.inverse()));
        Self { pose, covariance }
    }

    /// Pose of the parent in the child. The covariance is propagated to first order.
    pub fn inverse(&self) -> Self {
        let ad = se3::adjoint(&self.pose);
        Self { pose: self.pose.inverse(), covariance: symmetric(&(ad * self.covariance * ad.transpose())) }
    }

    /// Composition `self * next`. The errors are taken as independent and the covariance is propagated to first order (equation 2).
    pub fn compose(&self, next: &Self) -> Self {
        let ad = se3::adjoint(&next.pose.inverse());
        let moved = ad * self.covariance * ad.transpose();
        Self { pose: self.pose * next.pose, covariance: symmetric(&(moved + next.covariance)) }
    }

    /// Squared Mahalanobis distance of another estimate of the same relative pose (equation 3). The errors are taken as independent.
    /// `None` when the sum of the covariances is not positive definite or a number is not finite.
    pub fn mahalanobis_squared(&self, other: &Self) -> Option<f64> {
        let error = se3::local(&self.pose, &other.pose);
        let factor = (self.covariance + other.covariance).cholesky()?;
        let squared = error.dot(&factor.solve(&error));
        squared.is_finite().then_some(squared)
    }

    /// The information matrix, as [`Self::from_information`] takes it. Zero if the covariance has no inverse.
    pub fn information(&self) -> Matrix6 {
        self.covariance.cholesky().map_or_else(Matrix6::zeros, |factor| symmetric(&factor.inverse()))
    }

    /// Standard deviation of the child's position in its least certain direction, metres.
    pub fn translation_std_m(&self) -> f64 {
        let block = self.covariance.fixed_view::<3, 3>(3, 3).into_owned();
        block.symmetric_eigenvalues().max().max(0.0).sqrt()
    }
}

/// Covariance without correlations: the same standard deviation for all rotations (radians) and for all translations (metres).
pub(crate) fn diagonal_covariance(rotation_std_rad: f64, translation_std_m: f64) -> Matrix6 {
    let (rotation, translation) =
        (rotation_std_rad * rotation_std_rad, translation_std_m * translation_std_m);
    Matrix6::from_diagonal(&Vector6::new(rotation, rotation, rotation, translation, translation, translation))
}

fn symmetric(matrix: &Matrix6) -> Matrix6 {
    (matrix + matrix.transpose()) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    /// Mean square of many drawn errors against the covariance that composition predicts.
    #[test]
    fn composition_and_inversion_match_sampled_errors() {
        let mut rng = RngTree::new(8).child("uncertain").rng();
        let mut random = |scale: f64| Vector6::from_fn(|_, _| rng.normal() * scale);
        let diagonal = |v: f64| Matrix6::from_diagonal(&Vector6::from_fn(|i, _| v * (1.0 + i as f64)));
        let a = UncertainPose {
            pose: se3::retract(&Isometry::identity(), &random(1.0)),
            covariance: diagonal(1e-5),
        };
        let b = UncertainPose {
            pose: se3::retract(&Isometry::identity(), &random(1.0)),
            covariance: diagonal(3e-5),
        };
        let expected = a.compose(&b).inverse();
        let mut sampled = Matrix6::zeros();
        let count = 20_000;
        for _ in 0..count {
            let mut draw = |u: &UncertainPose| {
                let unit = random(1.0);
                se3::retract(&u.pose, &u.covariance.map_diagonal(f64::sqrt).component_mul(&unit))
            };
            let error = se3::local(&expected.pose, &(draw(&a) * draw(&b)).inverse());
            sampled += error * error.transpose() / f64::from(count);
        }
        let difference = (sampled - expected.covariance).norm() / expected.covariance.norm();
        assert!(difference < 0.05, "{difference}");
    }

    #[test]
    fn unknown_directions_are_wide_and_garbage_has_no_distance() {
        let mut information = Matrix6::identity() * 1e4;
        information[(3, 3)] = 0.0;
        let corridor = UncertainPose::from_information(Isometry::identity(), &information);
        assert!(corridor.translation_std_m() > 50.0);
        assert!((corridor.information()[(4, 4)] - 1e4).abs() < 1.0 && corridor.information()[(3, 3)] < 2e-4);
        assert_eq!(UncertainPose::identity().information(), Matrix6::zeros());
        let mut shifted = corridor;
        shifted.pose.translation.vector.x = 5.0;
        assert!(corridor.mahalanobis_squared(&shifted).is_some_and(|d| d < 0.1));
        shifted.pose.translation.vector.y = 0.5;
        assert!(corridor.mahalanobis_squared(&shifted).is_some_and(|d| d > 100.0));
        shifted.pose.translation.vector.z = f64::NAN;
        assert_eq!(corridor.mahalanobis_squared(&shifted), None);
        assert_eq!(UncertainPose::identity().mahalanobis_squared(&UncertainPose::identity()), None);
    }
}
