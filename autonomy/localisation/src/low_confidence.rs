//! Acceptance of a pose that fits only partly, by repeated recognition while the robot walks.
//!
//! Near the end of a map, much of a scan is in no map, so that the right pose fits no better than a wrong one may by chance. A wrong pose, however,
//! does not move with the robot. Each search is independent of the previous ones. A pose that is found each time where the last one and odometry
//! predict it is therefore the right one.

use crate::pose_hypothesis::HypothesisTolerance;
use geometry::Isometry;

/// Parameters of [`LowConfidenceConfirmation`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowConfidenceConfig {
    /// Distance over which the pose has to be found repeatedly, metres. Chosen: three times the distance after which a scan counts as new
    /// ([`MultiHypothesisConfig::update_distance_m`](crate::MultiHypothesisConfig)).
    pub confirmation_distance_m: f64,
}

impl Default for LowConfidenceConfig {
    fn default() -> Self {
        Self { confirmation_distance_m: 1.2 }
    }
}

/// Confirms a pose of low confidence by the distance over which it moves with odometry.
#[derive(Debug)]
pub(crate) struct LowConfidenceConfirmation {
    config: LowConfidenceConfig,
    /// Pose of the base when it was found last, in the map and by odometry.
    latest: Option<(Isometry, Isometry)>,
    /// Distance over which the found poses agree with odometry, metres.
    confirmed_m: f64,
}

impl LowConfidenceConfirmation {
    /// Without a found pose.
    pub fn new(config: LowConfidenceConfig) -> Self {
        Self { config, latest: None, confirmed_m: 0.0 }
    }

    /// Updates by a pose of low confidence, of a scan taken at a moment of odometry. Returns whether the pose is confirmed now. `same_pose` says how
    /// near to its prediction it has to be.
    pub fn update(
        &mut self,
        map_from_base: &Isometry,
        odom_from_base: &Isometry,
        same_pose: &HypothesisTolerance,
    ) -> bool {
        let previous = self.latest.replace((*map_from_base, *odom_from_base));
        let Some((map_from_previous, odom_from_previous)) = previous else { return false };
        let motion = odom_from_previous.inverse() * odom_from_base;
        let agrees = same_pose.contains(&(map_from_previous * motion), map_from_base);
        self.confirmed_m = if agrees { self.confirmed_m + motion.translation.vector.norm() } else { 0.0 };
        self.confirmed_m >= self.config.confirmation_distance_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose_hypothesis::AcceptanceConfig;

    fn at(x: f64) -> Isometry {
        Isometry::translation(x, 0.0, 0.0)
    }

    /// Whether each of these poses (x in the map, x by odometry) confirms.
    fn confirmed(poses: &[(f64, f64)]) -> Vec<bool> {
        let mut confirmation = LowConfidenceConfirmation::new(LowConfidenceConfig::default());
        let same_pose = AcceptanceConfig::default().same_pose;
        poses.iter().map(|(map, odom)| confirmation.update(&at(*map), &at(*odom), &same_pose)).collect()
    }

    #[test]
    fn a_pose_that_moves_with_odometry_is_confirmed_by_distance() {
        let walk = [(10.0, 0.0), (10.5, 0.5), (11.0, 1.0), (11.5, 1.5)];
        assert_eq!(confirmed(&walk), [false, false, false, true]);
        assert_eq!(confirmed(&[(10.0, 0.0), (12.3, 2.3)]), [false, true], "fast robots are seen less often");
    }

    #[test]
    fn a_pose_that_stands_still_or_jumps_is_not_confirmed() {
        assert_eq!(confirmed(&[(10.0, 0.0); 6]), [false; 6], "the robot stands");
        let jump = [(10.0, 0.0), (10.5, 0.5), (11.0, 1.0), (30.0, 1.5), (30.5, 2.0), (31.0, 2.5)];
        assert_eq!(confirmed(&jump), [false; 6], "the distance begins anew");
        assert_eq!(confirmed(&[(10.0, 0.0), (10.0, 0.8), (10.0, 1.6), (10.0, 2.4), (10.0, 3.2)]), [false; 5]);
    }
}
