//! The vertical as odometry measures it with an IMU, and what it says about the relative pose of two keyframes (docs/maths/loops.md, equation 7).
//!
//! A scan of a corridor or of a landing hardly observes its own tilt: floor and ceiling beyond a few metres are seen at a grazing angle, or not at
//! all. Gravity observes the tilt everywhere, and it does not drift. So a loop must not turn one storey against gravity. Source of the
//! idea: Qin, Li, Shen, *VINS-Mono*, T-RO 2018, whose pose graph has four degrees of freedom for the same reason.

use geometry::{Isometry, Matrix3, Matrix6, Vector3, Vector6};

/// The vertical at a waypoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredVertical {
    /// Unit vector that points up, base frame.
    pub up: Vector3,
    /// Variance of the rotation that was added when tracking was lost, rad². It is shared by all waypoints since.
    pub inflation_rad2: f64,
}

/// The vertical at two places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeTilt {
    /// Up at the older place, its base frame.
    older_up: Vector3,
    /// Up at the newer place, its base frame.
    newer_up: Vector3,
    /// Variance that lost tracking between them added, rad².
    inflation_rad2: f64,
}

impl RelativeTilt {
    /// Of an older and a newer place.
    pub fn new(older: &MeasuredVertical, newer: &MeasuredVertical) -> Self {
        let inflation_rad2 = (newer.inflation_rad2 - older.inflation_rad2).abs();
        Self { older_up: older.up, newer_up: newer.up, inflation_rad2 }
    }

    /// Information and gradient of the pose of the newer place in the older one, for an error on the right, order `[rotation; translation]`.
    /// `std_rad` is the standard deviation of the tilt without lost tracking.
    ///
    /// Equation 7: the residual is `R u_newer - u_older`, and the Jacobian `-R [u_newer]×`. The rotation about the vertical has no information.
    pub fn linearise(&self, older_from_newer: &Isometry, std_rad: f64) -> (Matrix6, Vector6) {
        let weight = 1.0 / (std_rad * std_rad + self.inflation_rad2);
        let up = &self.newer_up;
        let expected = older_from_newer.rotation.inverse() * self.older_up;
        let (mut information, mut gradient) = (Matrix6::zeros(), Vector6::zeros());
        let across = Matrix3::identity() - up * up.transpose();
        information.fixed_view_mut::<3, 3>(0, 0).copy_from(&(across * weight));
        gradient.fixed_rows_mut::<3>(0).copy_from(&(expected.cross(up) * weight));
        (information, gradient)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{RngTree, se3};

    fn random(seed: u64) -> Vector6 {
        let mut rng = RngTree::new(seed).child("vertical").rng();
        Vector6::from_fn(|_, _| rng.normal())
    }

    #[test]
    fn the_gradient_matches_central_differences_of_the_cost() {
        for seed in 0..20 {
            let pose = se3::retract(&Isometry::identity(), &(random(seed) * 0.5));
            let vertical = |seed| MeasuredVertical {
                up: random(seed).fixed_rows::<3>(0).normalize(),
                inflation_rad2: 0.0,
            };
            let (older, newer) = (vertical(seed + 100), vertical(seed + 200));
            let (_, gradient) = RelativeTilt::new(&older, &newer).linearise(&pose, 0.5);
            let cost = |step: &Vector6| {
                let residual = se3::retract(&pose, step).rotation * newer.up - older.up;
                0.5 * residual.norm_squared() / (0.5 * 0.5)
            };
            for axis in 0..6 {
                let mut step = Vector6::zeros();
                step[axis] = 1e-6;
                let numeric = (cost(&step) - cost(&-step)) / 2e-6;
                assert!((numeric - gradient[axis]).abs() < 1e-6, "{axis}: {numeric} {}", gradient[axis]);
            }
        }
    }

    #[test]
    fn one_step_levels_a_tilted_pose_and_keeps_its_heading() {
        let up = MeasuredVertical { up: Vector3::z(), inflation_rad2: 0.0 };
        let tilted = se3::retract(&Isometry::identity(), &Vector6::new(3e-3, -2e-3, 0.7, 1.0, 2.0, 3.0));
        let (information, gradient) = RelativeTilt::new(&up, &up).linearise(&tilted, 1e-3);
        let Some(step) = (information + Matrix6::identity() * 1e-3).try_inverse().map(|i| -i * gradient)
        else {
            panic!("singular")
        };
        let levelled = se3::retract(&tilted, &step);
        assert!((levelled.rotation * Vector3::z() - Vector3::z()).norm() < 1e-5, "{levelled}");
        assert!(step[2].abs() < 1e-9 && step.fixed_rows::<3>(3).norm() < 1e-12, "{step}");
    }

    #[test]
    fn lost_tracking_between_the_places_leaves_no_information() {
        let [before, after] =
            [0.0, 0.25].map(|inflation_rad2| MeasuredVertical { up: Vector3::z(), inflation_rad2 });
        let (information, _) = RelativeTilt::new(&before, &after).linearise(&Isometry::identity(), 1e-3);
        assert!(information[(0, 0)] < 5.0, "{information}");
        let (information, _) = RelativeTilt::new(&after, &after).linearise(&Isometry::identity(), 1e-3);
        assert!((information[(0, 0)] - 1e6).abs() < 1.0 && information[(2, 2)] == 0.0, "{information}");
    }
}
