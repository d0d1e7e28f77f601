//! How far a pose in a known map can be believed.
//!
//! One scan proves nothing: people stand about the robot, a door was closed. What speaks against the pose has to last.

use crate::localisation_map::FreeSpaceCheck;
use vocab::{Span, Stamp};

/// A scan contradicts the pose if the keyframes saw through such a share of the points that they can speak of.
const CONTRADICTED: f64 = 0.3;
/// Or if such a share at most of the points that have known surfaces about lie on them, where that is such a share of all at least.
const FITTING: f64 = 0.55;
const MAPPED: f64 = 0.3;
/// The pose is unsure, and lost, if it may be so far off, metres.
const UNSURE: f64 = 0.15;
const LOST: f64 = 0.8;
/// A contradiction makes the pose unsure after so long, and lost.
const UNSURE_AFTER: Span = Span::from_millis(500);
const LOST_AFTER: Span = Span::from_millis(2_500);
/// And is forgotten after so long without one.
const FORGOTTEN: Span = Span::from_millis(1_000);
/// Once something has spoken against the pose, or no scan has come for a while, it is believed again when nothing has for so long.
const CONFIRMED_AFTER: Span = Span::from_millis(500);
/// Slow LiDARs turn twice a second.
const GAP: Span = Span::from_millis(800);
/// Fewer points than this see nothing.
const DARK: usize = 60;

/// What speaks for and against a pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseEvidence {
    /// Points of the scan.
    pub seen: usize,
    /// Share of them on known surfaces, and share of them that have any about.
    pub matched: f64,
    /// See [`Self::matched`].
    pub mapped: f64,
    /// What the keyframes about saw where they are.
    pub sightings: FreeSpaceCheck,
    /// Standard deviation of the place in its least certain direction, metres.
    pub deviation: f64,
}

impl PoseEvidence {
    /// Share of the points that have known surfaces about and lie on none, if that is too much.
    fn misfit(&self) -> Option<f64> {
        let share = 1.0 - self.matched / self.mapped.max(1e-9);
        (self.mapped >= MAPPED && share > 1.0 - FITTING).then_some(share)
    }
}

/// Whether the pose can be believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LocalisationStatus {
    /// It can.
    Localised,
    /// Not quite.
    Uncertain(DegradationReason),
    /// It cannot.
    Lost(DegradationReason),
}

/// What speaks against a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DegradationReason {
    /// What is seen is not what the map shows there.
    MapMismatch {
        /// Share of the points.
        share: f64,
    },
    /// It may be far off, metres.
    PoseUncertain {
        /// One standard deviation.
        deviation: f64,
    },
    /// The LiDAR sees nothing.
    LidarBlind,
    /// The map shows nothing of what is seen: the robot has left it.
    Unmapped,
}

/// Judges scan after scan.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LocalisationMonitor {
    /// Since when scans contradict the pose, and when the last one did.
    contradicted: Option<(Stamp, Stamp)>,
    /// The last scan.
    last: Option<Stamp>,
    /// What spoke against the pose last, and when; forgotten once nothing has for long enough.
    doubted: Option<(DegradationReason, Stamp)>,
}

impl LocalisationMonitor {
    /// Takes in what speaks for and against the pose at a scan.
    pub fn judge(&mut self, at: Stamp, evidence: &PoseEvidence) -> LocalisationStatus {
        if self.last.replace(at).is_some_and(|last| at - last > GAP) {
            self.doubted = Some((DegradationReason::LidarBlind, at));
        }
        let contradiction =
            evidence.sightings.contradicted().filter(|share| *share > CONTRADICTED).or(evidence.misfit());
        self.remember(at, contradiction.is_some());
        let contradiction = contradiction.map(|share| DegradationReason::MapMismatch { share });
        let trust = self.weigh(evidence, contradiction);
        let spoken = match trust {
            LocalisationStatus::Uncertain(doubt) | LocalisationStatus::Lost(doubt) => Some(doubt),
            LocalisationStatus::Localised => contradiction.filter(|_| self.doubted.is_some()),
        };
        if let Some(doubt) = spoken {
            self.doubted = Some((doubt, at));
        }
        self.doubted = self.doubted.filter(|(_, since)| at - *since < CONFIRMED_AFTER);
        match (trust, self.doubted) {
            (LocalisationStatus::Localised, Some((doubt, _))) => LocalisationStatus::Uncertain(doubt),
            _ => trust,
        }
    }

    fn remember(&mut self, at: Stamp, contradicted: bool) {
        self.contradicted = match (self.contradicted, contradicted) {
            (Some((since, last)), true) if at - last <= FORGOTTEN => Some((since, at)),
            (_, true) => Some((at, at)),
            (Some((_, last)), false) if at - last > FORGOTTEN => None,
            (held, false) => held,
        };
    }

    /// As if nothing had ever spoken against the pose but what does now, and for how long.
    fn weigh(&self, evidence: &PoseEvidence, contradiction: Option<DegradationReason>) -> LocalisationStatus {
        let lasted = self.contradicted.map_or(Span::ZERO, |(since, last)| last - since);
        let deviation = evidence.deviation;
        match contradiction {
            Some(doubt) if lasted >= LOST_AFTER => LocalisationStatus::Lost(doubt),
            _ if deviation > LOST => LocalisationStatus::Lost(DegradationReason::PoseUncertain { deviation }),
            Some(doubt) if lasted >= UNSURE_AFTER => LocalisationStatus::Uncertain(doubt),
            _ if evidence.seen < DARK => LocalisationStatus::Uncertain(DegradationReason::LidarBlind),
            _ if deviation > UNSURE => {
                LocalisationStatus::Uncertain(DegradationReason::PoseUncertain { deviation })
            }
            _ if evidence.mapped < MAPPED => LocalisationStatus::Uncertain(DegradationReason::Unmapped),
            _ => LocalisationStatus::Localised,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(millis: i64) -> Stamp {
        Stamp::from_parts(100, 0) + Span::from_millis(millis)
    }

    fn evidence(agreed: usize, through: usize) -> PoseEvidence {
        let sightings = FreeSpaceCheck { agreed, through };
        PoseEvidence { seen: 4_000, matched: 0.8, mapped: 1.0, sightings, deviation: 0.01 }
    }

    #[test]
    fn people_about_the_robot_do_not_shake_it_and_another_place_does_when_it_lasts() {
        let mut judge = LocalisationMonitor::default();
        assert_eq!(judge.judge(at(0), &evidence(300, 60)), LocalisationStatus::Localised);
        for millis in (100..=400).step_by(100) {
            assert_eq!(
                judge.judge(at(millis), &evidence(150, 200)),
                LocalisationStatus::Localised,
                "{millis}"
            );
        }
        assert_eq!(judge.judge(at(500), &evidence(300, 60)), LocalisationStatus::Localised);
        for millis in (600..2_000).step_by(100) {
            assert_eq!(
                judge.judge(at(millis), &evidence(300, 60)),
                LocalisationStatus::Localised,
                "{millis}"
            );
        }
        for millis in (2_000..2_500).step_by(100) {
            assert_eq!(
                judge.judge(at(millis), &evidence(150, 200)),
                LocalisationStatus::Localised,
                "{millis}"
            );
        }
        let share = 200.0 / 350.0;
        for millis in (2_500..4_500).step_by(100) {
            let unsure = LocalisationStatus::Uncertain(DegradationReason::MapMismatch { share });
            assert_eq!(judge.judge(at(millis), &evidence(150, 200)), unsure, "{millis}");
        }
        assert_eq!(
            judge.judge(at(4_500), &evidence(150, 200)),
            LocalisationStatus::Lost(DegradationReason::MapMismatch { share })
        );
        for millis in (4_600..5_000).step_by(100) {
            let unsure = LocalisationStatus::Uncertain(DegradationReason::MapMismatch { share });
            assert_eq!(judge.judge(at(millis), &evidence(300, 60)), unsure, "{millis}");
        }
        assert_eq!(judge.judge(at(5_000), &evidence(300, 60)), LocalisationStatus::Localised);
    }

    #[test]
    fn after_darkness_the_place_has_to_be_confirmed() {
        let mut judge = LocalisationMonitor::default();
        assert_eq!(judge.judge(at(0), &evidence(300, 0)), LocalisationStatus::Localised);
        let dark = LocalisationStatus::Uncertain(DegradationReason::LidarBlind);
        assert_eq!(judge.judge(at(3_000), &evidence(300, 0)), dark);
        let contradicted =
            LocalisationStatus::Uncertain(DegradationReason::MapMismatch { share: 200.0 / 350.0 });
        assert_eq!(judge.judge(at(3_100), &evidence(150, 200)), contradicted);
        assert_eq!(judge.judge(at(3_500), &evidence(300, 0)), contradicted);
        assert_eq!(judge.judge(at(3_600), &evidence(300, 0)), LocalisationStatus::Localised);
    }

    #[test]
    fn what_it_cannot_know_it_says() {
        let mut judge = LocalisationMonitor::default();
        let vague = |deviation| PoseEvidence { deviation, ..evidence(300, 0) };
        assert_eq!(
            judge.judge(at(0), &vague(0.3)),
            LocalisationStatus::Uncertain(DegradationReason::PoseUncertain { deviation: 0.3 })
        );
        assert_eq!(
            judge.judge(at(0), &vague(1.0)),
            LocalisationStatus::Lost(DegradationReason::PoseUncertain { deviation: 1.0 })
        );
        let dark = PoseEvidence { deviation: 0.01, ..PoseEvidence::default() };
        assert_eq!(judge.judge(at(0), &dark), LocalisationStatus::Uncertain(DegradationReason::LidarBlind));
        let unmapped = PoseEvidence { matched: 0.1, mapped: 0.15, ..evidence(5, 5) };
        assert_eq!(judge.judge(at(0), &unmapped), LocalisationStatus::Uncertain(DegradationReason::Unmapped));
    }
}
