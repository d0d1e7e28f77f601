//! Monitors the reliability of a pose in a known map.
//!
//! One contradicting scan is no proof: people may stand around the robot, or a door may have been closed. Evidence against the pose counts only if it
//! lasts.

use crate::localisation_map::FreeSpaceCheck;
use vocab::{Span, Stamp};

/// Parameters of [`LocalisationMonitor`]. Its threshold is what the whole crate means by a gap between scans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalisationMonitorConfig {
    /// Longest time between two scans of a LiDAR that works. Slow LiDARs turn twice a second. Chosen: longer than the half second between two scans of those.
    pub max_scan_gap: Span,
    /// A scan contradicts the pose if its share of free-space violations is greater. Chosen: three times what a pose may have when it is found
    /// ([`AcceptanceConfig::max_violation_share`](crate::AcceptanceConfig)), because people crowd round a robot on its way.
    pub max_violation_share: f64,
    /// The share of free-space violations counts if the keyframes can decide on this many points. Dense scans hide most of what is behind
    /// their nearest points. Chosen: a share of 0.3 of fewer points is uncertain by more than 0.1.
    pub min_decided_points: usize,
    /// A scan also contradicts the pose if a smaller share of the points near known surfaces lie on them. In the test hall with six people,
    /// 0.90 to 0.94 lie on them at the right pose, and 0.41 at a local minimum 0.28 m beside it. Chosen between them, nearer to the wrong one.
    pub min_matched_share: f64,
    /// That share counts if this share of all points is near known surfaces. With a smaller one the pose is uncertain: the robot has left
    /// the map. Chosen as a round number: below it, the share on surfaces is of too few points.
    pub min_mapped_share: f64,
    /// The pose is uncertain if the standard deviation of its position is greater, metres. Chosen: twice the room that the default robot has to each side in a doorway of
    /// 0.9 m (0.07 m).
    pub uncertain_std_m: f64,
    /// The pose is lost if the standard deviation of its position is greater, metres. Chosen: a little less than the 1 m that the search round a known pose covers
    /// ([`GlobalLocaliserConfig::prior_offsets_m`](crate::GlobalLocaliserConfig)).
    pub lost_std_m: f64,
    /// The pose is uncertain after contradictions for this time. Chosen: five scans at 10 Hz; a person who walks past closely contradicts for less.
    pub uncertain_after: Span,
    /// The pose is lost after contradictions for this time. Chosen: five times [`Self::uncertain_after`]; at walking speed the robot goes 2 m in it.
    pub lost_after: Span,
    /// A contradiction ends after this time without a scan that contradicts the pose. Chosen: more than [`Self::max_scan_gap`], so that two scans of a slow LiDAR count
    /// together.
    pub contradiction_timeout: Span,
    /// A pose that was uncertain, or had no scan for a while, is trusted again after this time without evidence against it. Chosen: as [`Self::uncertain_after`].
    pub recovery_time: Span,
}

impl Default for LocalisationMonitorConfig {
    fn default() -> Self {
        Self {
            max_scan_gap: Span::from_millis(800),
            max_violation_share: 0.3,
            min_decided_points: 20,
            min_matched_share: 0.55,
            min_mapped_share: 0.3,
            uncertain_std_m: 0.15,
            lost_std_m: 0.8,
            uncertain_after: Span::from_millis(500),
            lost_after: Span::from_millis(2_500),
            contradiction_timeout: Span::from_millis(1_000),
            recovery_time: Span::from_millis(500),
        }
    }
}

/// Evidence of one scan for and against the pose at which it was aligned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseEvidence {
    /// Whether the scan had enough points to be aligned with the map. A scan of fewer points shows nothing.
    pub is_aligned: bool,
    /// Share of the points that lie on known surfaces.
    pub matched_share: f64,
    /// Share of the points that are near known surfaces, on them or not.
    pub mapped_share: f64,
    /// Comparison of the points with the range images of the nearest keyframes.
    pub free_space: FreeSpaceCheck,
    /// Standard deviation of the position in its least certain direction, metres.
    pub position_std_m: f64,
}

/// Whether the pose can be trusted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LocalisationStatus {
    /// It can.
    Localised,
    /// There is evidence against the pose.
    Uncertain(DegradationReason),
    /// It cannot.
    Lost(DegradationReason),
}

/// Evidence against the pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DegradationReason {
    /// The scan does not match the map there.
    MapMismatch {
        /// Share of the points that do not match.
        share: f64,
    },
    /// The position may be far off.
    PoseUncertain {
        /// One standard deviation, metres.
        position_std_m: f64,
    },
    /// The LiDAR sees nothing.
    LidarBlind,
    /// The map has no surfaces where the LiDAR sees some, because the robot has left the map.
    Unmapped,
    /// The pose was given, and the rest of the map has not been searched yet for poses that look alike.
    Unconfirmed,
}

/// Decides scan after scan whether the pose can be trusted.
#[derive(Clone, Debug)]
pub(crate) struct LocalisationMonitor {
    config: LocalisationMonitorConfig,
    /// The first and the latest scan of the present contradiction.
    contradiction: Option<(Stamp, Stamp)>,
    /// Stamp of the latest scan.
    latest_scan: Option<Stamp>,
    /// The latest evidence against the pose, until the recovery time has passed.
    degradation: Option<(DegradationReason, Stamp)>,
}

impl LocalisationMonitor {
    /// A monitor of a pose without evidence against it.
    pub fn new(config: LocalisationMonitorConfig) -> Self {
        Self { config, contradiction: None, latest_scan: None, degradation: None }
    }

    /// Updates by the evidence of the scan at `at`.
    pub fn update(&mut self, at: Stamp, evidence: &PoseEvidence) -> LocalisationStatus {
        if self.latest_scan.replace(at).is_some_and(|last| at - last > self.config.max_scan_gap) {
            self.degradation = Some((DegradationReason::LidarBlind, at));
        }
        let mismatch = self.mismatch(evidence).map(|share| DegradationReason::MapMismatch { share });
        self.update_contradiction(at, mismatch.is_some());
        let status = self.instantaneous_status(evidence, mismatch);
        let reason = match status {
            LocalisationStatus::Uncertain(reason) | LocalisationStatus::Lost(reason) => Some(reason),
            // During recovery a single mismatch starts the recovery time again.
            LocalisationStatus::Localised => mismatch.filter(|_| self.degradation.is_some()),
        };
        if let Some(reason) = reason {
            self.degradation = Some((reason, at));
        }
        self.degradation = self.degradation.filter(|(_, since)| at - *since < self.config.recovery_time);
        match (status, self.degradation) {
            (LocalisationStatus::Localised, Some((reason, _))) => LocalisationStatus::Uncertain(reason),
            _ => status,
        }
    }

    /// Share of the points that contradict the pose, if it is too large. Free space is checked first, then surfaces.
    fn mismatch(&self, evidence: &PoseEvidence) -> Option<f64> {
        let config = &self.config;
        let violation_share = (evidence.free_space.decided() >= config.min_decided_points)
            .then(|| evidence.free_space.violation_share())
            .filter(|share| *share > config.max_violation_share);
        let unmatched = 1.0 - evidence.matched_share / evidence.mapped_share.max(1e-9);
        let unmatched_share = (evidence.mapped_share >= config.min_mapped_share
            && unmatched > 1.0 - config.min_matched_share)
            .then_some(unmatched);
        violation_share.or(unmatched_share)
    }

    fn update_contradiction(&mut self, at: Stamp, contradicted: bool) {
        let timeout = self.config.contradiction_timeout;
        self.contradiction = match (self.contradiction, contradicted) {
            (Some((since, last)), true) if at - last <= timeout => Some((since, at)),
            (_, true) => Some((at, at)),
            (Some((_, last)), false) if at - last > timeout => None,
            (held, false) => held,
        };
    }

    /// The status by this scan and the duration of the present contradiction, without the recovery time.
    fn instantaneous_status(
        &self,
        evidence: &PoseEvidence,
        mismatch: Option<DegradationReason>,
    ) -> LocalisationStatus {
        let config = &self.config;
        let duration = self.contradiction.map_or(Span::ZERO, |(since, last)| last - since);
        let position_std_m = evidence.position_std_m;
        let uncertain_pose = DegradationReason::PoseUncertain { position_std_m };
        match mismatch {
            Some(reason) if duration >= config.lost_after => LocalisationStatus::Lost(reason),
            _ if position_std_m > config.lost_std_m => LocalisationStatus::Lost(uncertain_pose),
            Some(reason) if duration >= config.uncertain_after => LocalisationStatus::Uncertain(reason),
            _ if !evidence.is_aligned => LocalisationStatus::Uncertain(DegradationReason::LidarBlind),
            _ if position_std_m > config.uncertain_std_m => LocalisationStatus::Uncertain(uncertain_pose),
            _ if evidence.mapped_share < config.min_mapped_share => {
                LocalisationStatus::Uncertain(DegradationReason::Unmapped)
            }
            _ => LocalisationStatus::Localised,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn monitor() -> LocalisationMonitor {
        LocalisationMonitor::new(LocalisationMonitorConfig::default())
    }

    fn at(millis: i64) -> Stamp {
        Stamp::from_parts(100, 0) + Span::from_millis(millis)
    }

    fn evidence(consistent: usize, violations: usize) -> PoseEvidence {
        let free_space = FreeSpaceCheck { consistent, violations };
        PoseEvidence {
            is_aligned: true,
            matched_share: 0.8,
            mapped_share: 1.0,
            free_space,
            position_std_m: 0.01,
        }
    }

    #[test]
    fn people_around_the_robot_change_nothing_and_lasting_contradictions_lose_the_pose() {
        let mut monitor = monitor();
        assert_eq!(monitor.update(at(0), &evidence(300, 60)), LocalisationStatus::Localised);
        for millis in (100..=400).step_by(100) {
            let status = monitor.update(at(millis), &evidence(150, 200));
            assert_eq!(status, LocalisationStatus::Localised, "{millis}");
        }
        assert_eq!(monitor.update(at(500), &evidence(300, 60)), LocalisationStatus::Localised);
        for millis in (600..2_000).step_by(100) {
            let status = monitor.update(at(millis), &evidence(300, 60));
            assert_eq!(status, LocalisationStatus::Localised, "{millis}");
        }
        for millis in (2_000..2_500).step_by(100) {
            let status = monitor.update(at(millis), &evidence(150, 200));
            assert_eq!(status, LocalisationStatus::Localised, "{millis}");
        }
        let mismatch = DegradationReason::MapMismatch { share: 200.0 / 350.0 };
        for millis in (2_500..4_500).step_by(100) {
            let status = monitor.update(at(millis), &evidence(150, 200));
            assert_eq!(status, LocalisationStatus::Uncertain(mismatch), "{millis}");
        }
        assert_eq!(monitor.update(at(4_500), &evidence(150, 200)), LocalisationStatus::Lost(mismatch));
        for millis in (4_600..5_000).step_by(100) {
            let status = monitor.update(at(millis), &evidence(300, 60));
            assert_eq!(status, LocalisationStatus::Uncertain(mismatch), "{millis}");
        }
        assert_eq!(monitor.update(at(5_000), &evidence(300, 60)), LocalisationStatus::Localised);
    }

    #[test]
    fn after_a_gap_between_scans_the_pose_has_to_be_confirmed() {
        let mut monitor = monitor();
        assert_eq!(monitor.update(at(0), &evidence(300, 0)), LocalisationStatus::Localised);
        let blind = LocalisationStatus::Uncertain(DegradationReason::LidarBlind);
        assert_eq!(monitor.update(at(3_000), &evidence(300, 0)), blind);
        let share = 200.0 / 350.0;
        let mismatch = LocalisationStatus::Uncertain(DegradationReason::MapMismatch { share });
        assert_eq!(monitor.update(at(3_100), &evidence(150, 200)), mismatch);
        assert_eq!(monitor.update(at(3_500), &evidence(300, 0)), mismatch);
        assert_eq!(monitor.update(at(3_600), &evidence(300, 0)), LocalisationStatus::Localised);
    }

    #[test]
    fn each_kind_of_missing_evidence_has_its_reason() {
        let mut monitor = monitor();
        let vague = |position_std_m| PoseEvidence { position_std_m, ..evidence(300, 0) };
        let reason = |position_std_m| DegradationReason::PoseUncertain { position_std_m };
        assert_eq!(monitor.update(at(0), &vague(0.3)), LocalisationStatus::Uncertain(reason(0.3)));
        assert_eq!(monitor.update(at(0), &vague(1.0)), LocalisationStatus::Lost(reason(1.0)));
        let blind = PoseEvidence { position_std_m: 0.01, ..PoseEvidence::default() };
        let status = LocalisationStatus::Uncertain(DegradationReason::LidarBlind);
        assert_eq!(monitor.update(at(0), &blind), status);
        let unmapped = PoseEvidence { matched_share: 0.1, mapped_share: 0.15, ..evidence(5, 5) };
        let status = LocalisationStatus::Uncertain(DegradationReason::Unmapped);
        assert_eq!(monitor.update(at(0), &unmapped), status);
    }

    #[test]
    fn a_share_of_few_points_decides_nothing_and_poor_surfaces_contradict_by_themselves() {
        let monitor = monitor();
        assert_eq!(monitor.mismatch(&evidence(5, 14)), None);
        assert_eq!(monitor.mismatch(&evidence(6, 14)), Some(0.7));
        let poor = PoseEvidence { matched_share: 0.41, ..evidence(300, 0) };
        assert!(monitor.mismatch(&poor).is_some_and(|share| (share - 0.59).abs() < 1e-9));
    }
}
