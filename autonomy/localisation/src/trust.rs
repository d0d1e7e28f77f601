//! How far a pose in a known map can be believed.
//!
//! One scan proves nothing: people stand about the robot, a door was closed. What speaks against the pose has to last.

use crate::guide::Sightings;
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
pub struct Evidence {
    /// Points of the scan.
    pub seen: usize,
    /// Share of them on known surfaces, and share of them that have any about.
    pub matched: f64,
    /// See [`Self::matched`].
    pub mapped: f64,
    /// What the keyframes about saw where they are.
    pub sightings: Sightings,
    /// Standard deviation of the place in its least certain direction, metres.
    pub deviation: f64,
}

impl Evidence {
    /// Share of the points that have known surfaces about and lie on none, if that is too much.
    fn misfit(&self) -> Option<f64> {
        let share = 1.0 - self.matched / self.mapped.max(1e-9);
        (self.mapped >= MAPPED && share > 1.0 - FITTING).then_some(share)
    }
}

/// Whether the pose can be believed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trust {
    /// It can.
    Localised,
    /// Not quite.
    Uncertain(Doubt),
    /// It cannot.
    Lost(Doubt),
}

/// What speaks against a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doubt {
    /// What is seen is not what the map shows there.
    Contradicted {
        /// Share of the points.
        share: f64,
    },
    /// It may be far off, metres.
    Vague {
        /// One standard deviation.
        deviation: f64,
    },
    /// The LiDAR sees nothing.
    Dark,
    /// The map shows nothing of what is seen: the robot has left it.
    Unmapped,
}

/// Judges scan after scan.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Judge {
    /// Since when scans contradict the pose, and when the last one did.
    contradicted: Option<(Stamp, Stamp)>,
    /// The last scan.
    last: Option<Stamp>,
    /// What spoke against the pose last, and when; forgotten once nothing has for long enough.
    doubted: Option<(Doubt, Stamp)>,
}

impl Judge {
    /// Takes in what speaks for and against the pose at a scan.
    pub fn judge(&mut self, at: Stamp, evidence: &Evidence) -> Trust {
        if self.last.replace(at).is_some_and(|last| at - last > GAP) {
            self.doubted = Some((Doubt::Dark, at));
        }
        let contradiction =
            evidence.sightings.contradicted().filter(|share| *share > CONTRADICTED).or(evidence.misfit());
        self.remember(at, contradiction.is_some());
        let contradiction = contradiction.map(|share| Doubt::Contradicted { share });
        let trust = self.weigh(evidence, contradiction);
        let spoken = match trust {
            Trust::Uncertain(doubt) | Trust::Lost(doubt) => Some(doubt),
            Trust::Localised => contradiction.filter(|_| self.doubted.is_some()),
        };
        if let Some(doubt) = spoken {
            self.doubted = Some((doubt, at));
        }
        self.doubted = self.doubted.filter(|(_, since)| at - *since < CONFIRMED_AFTER);
        match (trust, self.doubted) {
            (Trust::Localised, Some((doubt, _))) => Trust::Uncertain(doubt),
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
    fn weigh(&self, evidence: &Evidence, contradiction: Option<Doubt>) -> Trust {
        let lasted = self.contradicted.map_or(Span::ZERO, |(since, last)| last - since);
        let deviation = evidence.deviation;
        match contradiction {
            Some(doubt) if lasted >= LOST_AFTER => Trust::Lost(doubt),
            _ if deviation > LOST => Trust::Lost(Doubt::Vague { deviation }),
            Some(doubt) if lasted >= UNSURE_AFTER => Trust::Uncertain(doubt),
            _ if evidence.seen < DARK => Trust::Uncertain(Doubt::Dark),
            _ if deviation > UNSURE => Trust::Uncertain(Doubt::Vague { deviation }),
            _ if evidence.mapped < MAPPED => Trust::Uncertain(Doubt::Unmapped),
            _ => Trust::Localised,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(millis: i64) -> Stamp {
        Stamp::from_parts(100, 0) + Span::from_millis(millis)
    }

    fn evidence(agreed: usize, through: usize) -> Evidence {
        let sightings = Sightings { agreed, through };
        Evidence { seen: 4_000, matched: 0.8, mapped: 1.0, sightings, deviation: 0.01 }
    }

    #[test]
    fn people_about_the_robot_do_not_shake_it_and_another_place_does_when_it_lasts() {
        let mut judge = Judge::default();
        assert_eq!(judge.judge(at(0), &evidence(300, 60)), Trust::Localised);
        for millis in (100..=400).step_by(100) {
            assert_eq!(judge.judge(at(millis), &evidence(150, 200)), Trust::Localised, "{millis}");
        }
        assert_eq!(judge.judge(at(500), &evidence(300, 60)), Trust::Localised);
        for millis in (600..2_000).step_by(100) {
            assert_eq!(judge.judge(at(millis), &evidence(300, 60)), Trust::Localised, "{millis}");
        }
        for millis in (2_000..2_500).step_by(100) {
            assert_eq!(judge.judge(at(millis), &evidence(150, 200)), Trust::Localised, "{millis}");
        }
        let share = 200.0 / 350.0;
        for millis in (2_500..4_500).step_by(100) {
            let unsure = Trust::Uncertain(Doubt::Contradicted { share });
            assert_eq!(judge.judge(at(millis), &evidence(150, 200)), unsure, "{millis}");
        }
        assert_eq!(judge.judge(at(4_500), &evidence(150, 200)), Trust::Lost(Doubt::Contradicted { share }));
        for millis in (4_600..5_000).step_by(100) {
            let unsure = Trust::Uncertain(Doubt::Contradicted { share });
            assert_eq!(judge.judge(at(millis), &evidence(300, 60)), unsure, "{millis}");
        }
        assert_eq!(judge.judge(at(5_000), &evidence(300, 60)), Trust::Localised);
    }

    #[test]
    fn after_darkness_the_place_has_to_be_confirmed() {
        let mut judge = Judge::default();
        assert_eq!(judge.judge(at(0), &evidence(300, 0)), Trust::Localised);
        let dark = Trust::Uncertain(Doubt::Dark);
        assert_eq!(judge.judge(at(3_000), &evidence(300, 0)), dark);
        let contradicted = Trust::Uncertain(Doubt::Contradicted { share: 200.0 / 350.0 });
        assert_eq!(judge.judge(at(3_100), &evidence(150, 200)), contradicted);
        assert_eq!(judge.judge(at(3_500), &evidence(300, 0)), contradicted);
        assert_eq!(judge.judge(at(3_600), &evidence(300, 0)), Trust::Localised);
    }

    #[test]
    fn what_it_cannot_know_it_says() {
        let mut judge = Judge::default();
        let vague = |deviation| Evidence { deviation, ..evidence(300, 0) };
        assert_eq!(judge.judge(at(0), &vague(0.3)), Trust::Uncertain(Doubt::Vague { deviation: 0.3 }));
        assert_eq!(judge.judge(at(0), &vague(1.0)), Trust::Lost(Doubt::Vague { deviation: 1.0 }));
        let dark = Evidence { deviation: 0.01, ..Evidence::default() };
        assert_eq!(judge.judge(at(0), &dark), Trust::Uncertain(Doubt::Dark));
        let unmapped = Evidence { matched: 0.1, mapped: 0.15, ..evidence(5, 5) };
        assert_eq!(judge.judge(at(0), &unmapped), Trust::Uncertain(Doubt::Unmapped));
    }
}
