//! Periodic comparison of the tracked pose with every other pose of the map.
//!
//! Where parts of a site look alike, the pose tracker may never find a contradiction at a wrong pose, because the surfaces around it match the map.
//! Only a comparison with the right pose, which fits better, reveals the error. This detects that a robot was carried to a part that looks alike
//! without noticing it.

use crate::pose_hypothesis::{AcceptanceConfig, PoseHypothesis};
use geometry::Isometry;

/// Parameters of [`PeriodicGlobalCheck`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodicGlobalCheckConfig {
    /// Distance walked from where the pose was found to the first check, metres. Chosen: five times the distance after which a scan counts as new.
    pub first_check_m: f64,
    /// Distance walked between two checks, metres. A check takes a fifth of a second of another thread. Chosen: 11 s at walking speed. Less costs time of that thread,
    /// more leaves a wrong pose for longer.
    pub check_interval_m: f64,
}

impl Default for PeriodicGlobalCheckConfig {
    fn default() -> Self {
        Self { first_check_m: 2.0, check_interval_m: 10.0 }
    }
}

/// Schedule of the checks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PeriodicGlobalCheck {
    config: PeriodicGlobalCheckConfig,
    odom_from_base: Option<Isometry>,
    /// Distance to walk until the next check, metres.
    remaining_m: f64,
}

impl PeriodicGlobalCheck {
    /// A schedule that begins where the pose was found.
    pub fn new(config: PeriodicGlobalCheckConfig) -> Self {
        Self { config, odom_from_base: None, remaining_m: config.first_check_m }
    }

    /// Moves on to the next scan's pose by odometry. Returns whether a check is due.
    pub fn update(&mut self, odom_from_base: &Isometry) -> bool {
        let previous = self.odom_from_base.replace(*odom_from_base).unwrap_or(*odom_from_base);
        self.remaining_m -= (odom_from_base.translation.vector - previous.translation.vector).norm();
        self.remaining_m <= 0.0
    }

    /// A check has been requested.
    pub fn restart(&mut self) {
        self.remaining_m = self.config.check_interval_m;
    }
}

/// Result of a search of the whole map for the tracked pose.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum GlobalCheckResult {
    /// The scan fits at the tracked pose, and nowhere clearly better.
    Confirmed,
    /// Another pose fits clearly better. These are the poses to decide between; the tracked one is among them if the scan fits there at
    /// all.
    Contradicted(Vec<PoseHypothesis>),
    /// Neither of the two.
    Inconclusive,
}

/// Compares the tracked pose with all poses that were found for the same scan, the best first. A pose fits clearly better if the tracked one
/// has less than `contradiction_ratio` of its quality (equation 9).
pub(crate) fn check_tracked_pose(
    config: &AcceptanceConfig,
    tracked: &Isometry,
    found: &[PoseHypothesis],
) -> GlobalCheckResult {
    let is_tracked = |one: &&PoseHypothesis| config.same_pose.contains(&one.map_from_base, tracked);
    let own = found.iter().find(is_tracked);
    let best = found.iter().map(PoseHypothesis::quality).fold(0.0, f64::max);
    if own.is_some_and(|own| own.quality() >= config.contradiction_ratio * best) {
        return GlobalCheckResult::Confirmed;
    }
    let mut poses = config.classify(found).into_accepted();
    let Some(other) = poses.iter().find(|one| !is_tracked(one)) else {
        return GlobalCheckResult::Inconclusive;
    };
    if own.is_some_and(|own| own.quality() >= config.contradiction_ratio * other.quality()) {
        return GlobalCheckResult::Inconclusive;
    }
    let dropped = own.filter(|own| !poses.contains(own)).copied();
    poses.extend(dropped);
    GlobalCheckResult::Contradicted(poses)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, fit: f64) -> PoseHypothesis {
        PoseHypothesis { map_from_base: Isometry::translation(x, 0.0, 0.0), fit, violation_share: 0.0 }
    }

    fn check(found: &[PoseHypothesis]) -> GlobalCheckResult {
        check_tracked_pose(&AcceptanceConfig::default(), &Isometry::translation(0.1, 0.0, 0.0), found)
    }

    #[test]
    fn a_pose_that_fits_as_well_as_any_other_is_confirmed() {
        assert_eq!(check(&[at(0.0, 0.9), at(20.0, 0.89)]), GlobalCheckResult::Confirmed);
        assert_eq!(check(&[at(20.0, 0.92), at(0.0, 0.88)]), GlobalCheckResult::Confirmed, "nearly as well");
        assert_eq!(check(&[at(0.0, 0.4)]), GlobalCheckResult::Confirmed, "poorly, and others not at all");
    }

    #[test]
    fn a_pose_that_fits_clearly_better_contradicts_and_the_tracked_one_stays_a_candidate() {
        let contradicted = GlobalCheckResult::Contradicted;
        let (better, tracked) = (at(20.0, 0.95), at(0.0, 0.85));
        assert_eq!(check(&[better, tracked]), contradicted(vec![better, tracked]));
        let poor = at(0.0, 0.4);
        assert_eq!(check(&[better, poor]), contradicted(vec![better, poor]), "one scan does not drop it");
        assert_eq!(check(&[better]), contradicted(vec![better]));
    }

    #[test]
    fn a_scan_that_fits_nowhere_well_is_inconclusive() {
        assert_eq!(check(&[at(20.0, 0.6), at(0.0, 0.4)]), GlobalCheckResult::Inconclusive);
        assert_eq!(check(&[]), GlobalCheckResult::Inconclusive);
    }

    /// Laws that hold for any list of poses.
    #[test]
    fn results_exclude_each_other_and_keep_the_tracked_pose_whatever_was_found() {
        let (config, tracked) = (AcceptanceConfig::default(), Isometry::identity());
        let mut counts = [0; 3];
        for seed in 0..2_000 {
            let mut rng = geometry::RngTree::new(seed).child("poses").rng();
            let mut found: Vec<PoseHypothesis> = (0..seed % 5)
                .map(|number| PoseHypothesis {
                    violation_share: rng.range(0.0, 0.15),
                    ..at(3.0 * number as f64, rng.range(0.3, 1.0))
                })
                .collect();
            found.sort_by(|a, b| b.quality().total_cmp(&a.quality()));
            let own = found.iter().find(|one| one.map_from_base == tracked);
            let is_confirmed =
                own.zip(found.first()).is_some_and(|(own, best)| own.quality() >= 0.93 * best.quality());
            let result = check_tracked_pose(&config, &tracked, &found);
            assert_eq!(result == GlobalCheckResult::Confirmed, is_confirmed, "{found:?}");
            match &result {
                GlobalCheckResult::Confirmed => counts[0] += 1,
                GlobalCheckResult::Inconclusive => counts[1] += 1,
                GlobalCheckResult::Contradicted(poses) => {
                    counts[2] += 1;
                    assert!(own.is_none_or(|own| poses.contains(own)), "{found:?}");
                    let better =
                        |one: &PoseHypothesis| own.is_none_or(|own| own.quality() < 0.93 * one.quality());
                    assert!(poses.iter().any(better), "{found:?}");
                    assert!(poses.iter().all(|one| found.contains(one)), "{found:?}");
                }
            }
        }
        assert!(counts.iter().all(|count| *count > 100), "{counts:?}");
    }

    #[test]
    fn checks_are_due_by_the_distance_walked() {
        let mut schedule = PeriodicGlobalCheck::new(PeriodicGlobalCheckConfig::default());
        let mut due_at = Vec::new();
        for step in 0..50 {
            let walked = 0.5 * f64::from(step);
            if schedule.update(&Isometry::translation(walked, 0.0, 0.0)) {
                due_at.push(walked);
                schedule.restart();
            }
        }
        assert_eq!(due_at, [2.0, 12.0, 22.0]);
    }
}
