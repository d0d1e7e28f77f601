//! Relative poses that know how wrong they may be, and how such poses compose.

use geometry::{Isometry, Matrix6, se3};

/// Variance given to a direction about which nothing is known, (m or rad)²: farther than any site is wide.
const UNKNOWN: f64 = 1e4;

/// A relative pose with the covariance of its error, `[rotation; translation]`, perturbed on the right (so in the frame
/// of the child).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UncertainPose {
    /// Pose of the child in the parent.
    pub pose: Isometry,
    /// Covariance of `retract(pose, error)`.
    pub covariance: Matrix6,
}

impl UncertainPose {
    /// The child is the parent, without doubt.
    pub fn identity() -> Self {
        Self { pose: Isometry::identity(), covariance: Matrix6::zeros() }
    }

    /// From a pose and its information; directions without information get a variance of 1e4.
    pub fn from_information(pose: Isometry, information: &Matrix6) -> Self {
        let held = information + Matrix6::identity() / UNKNOWN;
        let covariance = held
            .cholesky()
            .map_or_else(|| Matrix6::identity() * UNKNOWN, |factor| symmetric(&factor.inverse()));
        Self { pose, covariance }
    }

    /// The parent in the child. First order.
    pub fn inverse(&self) -> Self {
        let ad = se3::adjoint(&self.pose);
        Self { pose: self.pose.inverse(), covariance: symmetric(&(ad * self.covariance * ad.transpose())) }
    }

    /// This, then `next`; both errors independent. First order.
    pub fn then(&self, next: &Self) -> Self {
        let ad = se3::adjoint(&next.pose.inverse());
        let moved = ad * self.covariance * ad.transpose();
        Self { pose: self.pose * next.pose, covariance: symmetric(&(moved + next.covariance)) }
    }

    /// Squared Mahalanobis distance of another estimate of the same relative pose, both errors independent. `None` when
    /// their joint covariance is not positive definite or a number is not finite.
    pub fn distance_squared(&self, other: &Self) -> Option<f64> {
        let error = se3::local(&self.pose, &other.pose);
        let factor = (self.covariance + other.covariance).cholesky()?;
        let squared = error.dot(&factor.solve(&error));
        squared.is_finite().then_some(squared)
    }

    /// Its information: what [`Self::from_information`] takes. Zero where the covariance has no inverse.
    pub fn information(&self) -> Matrix6 {
        self.covariance.cholesky().map_or_else(Matrix6::zeros, |factor| symmetric(&factor.inverse()))
    }

    /// Standard deviation of the child's place in its least certain direction, metres.
    pub fn translation_std_m(&self) -> f64 {
        let block = self.covariance.fixed_view::<3, 3>(3, 3).into_owned();
        block.symmetric_eigenvalues().max().max(0.0).sqrt()
    }
}

fn symmetric(matrix: &Matrix6) -> Matrix6 {
    (matrix + matrix.transpose()) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{RngTree, Vector6};

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
        let expected = a.then(&b).inverse();
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
        assert!(corridor.distance_squared(&shifted).is_some_and(|d| d < 0.1));
        shifted.pose.translation.vector.y = 0.5;
        assert!(corridor.distance_squared(&shifted).is_some_and(|d| d > 100.0));
        shifted.pose.translation.vector.z = f64::NAN;
        assert_eq!(corridor.distance_squared(&shifted), None);
        assert_eq!(UncertainPose::identity().distance_squared(&UncertainPose::identity()), None);
    }
}
