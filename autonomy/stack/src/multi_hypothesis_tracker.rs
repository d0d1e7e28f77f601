//! Places where the robot may be, tracked side by side until what it sees as it moves leaves one.
//!
//! Look-alikes differ by little in each scan, and scans from one spot all say the same. So evidence is counted by the way walked: each
//! rival gains what its scans fit, for every [`LOOK`] once, and is out when it has fallen too far behind the best one. A robot that
//! stands still before look-alikes never chooses.

use crate::relocalisation_request::SearchableMap;
use geometry::{Isometry, Matrix6, Vector6};
use localisation::{
    DownsampledScan, LocalisationStatus, PoseHypothesis, PoseTracker, RelocalisationResult, TrackedPose,
    classify_hypotheses, is_same_place,
};
use mapping::UncertainPose;
use std::sync::Arc;
use vocab::{Span, Stamp};

/// A place that one scan was recognised by is so vague where the scan does not see it, as along a corridor: radians and metres.
const RECOGNISED: (f64, f64) = (0.05, 0.4);
/// What is seen is something new after so many metres.
const LOOK: f64 = 0.4;
/// A place is out when all that fitted there, share by look, is so much less than at the best one: what is asked of one scan that
/// tells two places apart at once, and a third more, since a tracked scan is noisier than a settled one.
const BEHIND: f64 = 0.2;
/// The last one is believed after so many scans.
const SCANS: u32 = 5;
/// So many metres after the whole map was searched, what was found there may not be all that looks like what is seen now.
const FRESH: f64 = 1.0;
/// Another place challenges the last one if it fits as well and is not one that is out, to metres and radians. It begins so far behind.
const THE_SAME: (f64, f64) = (1.0, 0.3);
const CHALLENGER: f64 = 0.1;
/// Where something has spoken against every place for so long, and over so many metres, the robot is at none of them. A scan stands for so long at
/// most.
const NOWHERE: (Span, f64) = (Span::from_millis(3_000), 1.0);
const SCAN: Span = Span::from_millis(800);
/// Fewer points than this see nothing.
const DARK: usize = 60;

/// The places.
#[derive(Debug, Default)]
pub(crate) struct MultiHypothesisTracker {
    rivals: Vec<TrackedHypothesis>,
    /// Where odometry's frame was in the map at places that are out.
    out: Vec<Isometry>,
    /// Metres since the map was searched.
    walked: f64,
    /// Of the last scan.
    odom_from_base: Option<Isometry>,
    /// For how long something has spoken against every place, and over how many metres.
    unsure: (Span, f64),
    /// Of the last scan.
    stamp: Option<Stamp>,
}

#[derive(Debug)]
struct TrackedHypothesis {
    tracker: PoseTracker,
    /// How well its scans fit, summed over looks.
    support: f64,
    scans: u32,
    /// Whether nothing speaks against it now.
    sure: bool,
}

impl MultiHypothesisTracker {
    /// Between these places, of a scan that was taken at a moment of odometry. Each begins with what that scan fits there; the one that
    /// was held until now begins level with the best, because one scan weighs little against all those before.
    pub fn new(
        ground: &SearchableMap,
        places: &[PoseHypothesis],
        held: Option<&Isometry>,
        odom_from_base: &Isometry,
    ) -> Self {
        let best = places.iter().map(PoseHypothesis::quality).fold(0.0, f64::max);
        let begin = |place: &PoseHypothesis| {
            let held = held.is_some_and(|held| is_same_place(&place.map_from_base, held));
            let support = if held { best } else { place.quality() };
            TrackedHypothesis::new(ground, place, support, odom_from_base)
        };
        let rivals = places.iter().map(begin).collect();
        Self { rivals, odom_from_base: Some(*odom_from_base), ..Self::default() }
    }

    /// How many are left.
    pub fn len(&self) -> usize {
        self.rivals.len()
    }

    /// Whether none is left.
    pub fn is_empty(&self) -> bool {
        self.rivals.is_empty()
    }

    /// Where the base may be, the likeliest first.
    pub fn places(&self) -> Vec<Isometry> {
        let mut rivals: Vec<&TrackedHypothesis> = self.rivals.iter().collect();
        rivals.sort_by(|a, b| b.support.total_cmp(&a.support));
        rivals.into_iter().map(|rival| rival.tracker.map_from_base().pose).collect()
    }

    /// Tracks all places by another scan; those are out that it contradicts, or that have fallen behind, and all of them where none has been
    /// right for long. Costs a tracked scan for each.
    pub fn take(&mut self, scan: &DownsampledScan) {
        let before = self.odom_from_base.replace(scan.odom_from_base).unwrap_or(scan.odom_from_base);
        let moved = (scan.odom_from_base.translation.vector - before.translation.vector).norm();
        let look = (moved / LOOK).min(1.0);
        self.walked += moved;
        let mut stays: Vec<bool> = self.rivals.iter_mut().map(|rival| rival.take(scan, look)).collect();
        let staying = self.rivals.iter().zip(&stays).filter(|(_, stays)| **stays);
        let best = staying.map(|(rival, _)| rival.support).fold(0.0, f64::max);
        for (rival, stays) in self.rivals.iter().zip(&mut stays) {
            *stays &= best - rival.support <= BEHIND;
            if !*stays {
                self.out.push(rival.tracker.map_from_odom());
            }
        }
        let mut stays = stays.into_iter();
        self.rivals.retain(|_| stays.next().unwrap_or(false));
        let passed = self.stamp.replace(scan.stamp).map_or(Span::from_millis(0), |last| scan.stamp - last);
        if self.rivals.iter().any(|rival| rival.sure) {
            self.unsure = (Span::from_millis(0), 0.0);
        } else if scan.points.len() >= DARK {
            self.unsure = (self.unsure.0 + passed.min(SCAN), self.unsure.1 + moved);
        }
        if self.unsure.0 > NOWHERE.0 && self.unsure.1 > NOWHERE.1 {
            self.rivals.clear();
        }
    }

    /// Whether nothing but the places in it, and those that are out, can look like what is seen.
    pub fn is_fresh(&self) -> bool {
        self.walked <= FRESH
    }

    /// The whole map has been searched for what was seen at a moment of odometry, while one place was left. Others that fit as well, and are
    /// not out already, come in beside it: the robot may be at none of those that looked alike where it began.
    pub fn inject_hypotheses(
        &mut self,
        ground: &SearchableMap,
        found: &[PoseHypothesis],
        held: &Isometry,
        odom_from_base: &Isometry,
    ) {
        self.walked = 0.0;
        let own = found.iter().find(|one| is_same_place(&one.map_from_base, held));
        let least = own.map_or(0.0, PoseHypothesis::quality);
        let places = match classify_hypotheses(found) {
            RelocalisationResult::Unique(best) => vec![best],
            RelocalisationResult::Ambiguous(several) => several,
            RelocalisationResult::LowConfidence(_) | RelocalisationResult::NotFound => return,
        };
        let is_out = |place: &Isometry| {
            self.out.iter().any(|map_from_odom| {
                let off = (map_from_odom * odom_from_base).inverse() * place;
                off.translation.vector.norm() <= THE_SAME.0 && off.rotation.angle() <= THE_SAME.1
            })
        };
        let challengers = places.iter().filter(|one| {
            one.quality() >= least && !is_same_place(&one.map_from_base, held) && !is_out(&one.map_from_base)
        });
        let best = self.rivals.iter().map(|rival| rival.support).fold(0.0, f64::max);
        let challengers: Vec<TrackedHypothesis> = challengers
            .map(|place| TrackedHypothesis::new(ground, place, best - CHALLENGER, odom_from_base))
            .collect();
        self.rivals.extend(challengers);
    }

    /// The only one left, once enough speaks for it and nothing against.
    pub fn winner(&self) -> Option<&PoseTracker> {
        match self.rivals.as_slice() {
            [TrackedHypothesis { tracker, scans: SCANS.., sure: true, .. }] => Some(tracker),
            _ => None,
        }
    }
}

impl TrackedHypothesis {
    fn new(ground: &SearchableMap, place: &PoseHypothesis, support: f64, odom_from_base: &Isometry) -> Self {
        let (turn, vague) = (RECOGNISED.0 * RECOGNISED.0, RECOGNISED.1 * RECOGNISED.1);
        let covariance = Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, vague, vague, vague));
        let map_from_base = UncertainPose { pose: place.map_from_base, covariance };
        // Odometry's own doubt counts from the first scan on.
        let tracker = PoseTracker::new(Arc::clone(ground.guide()), map_from_base, odom_from_base, None);
        Self { tracker, support, scans: 0, sure: false }
    }

    /// Takes a scan in that is worth so much of a look; says whether the robot may still be there.
    fn take(&mut self, scan: &DownsampledScan, look: f64) -> bool {
        let TrackedPose { trust, evidence, .. } = self.tracker.track(scan);
        self.support += look * evidence.matched * (1.0 - evidence.sightings.share());
        self.scans += 1;
        self.sure = trust == LocalisationStatus::Localised;
        !matches!(trust, LocalisationStatus::Lost(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(x: f64, fit: f64) -> PoseHypothesis {
        PoseHypothesis { map_from_base: Isometry::translation(x, 0.0, 0.0), fit, contradicted: 0.0 }
    }

    /// A scan that shows nothing, of a robot that has walked so far.
    fn dark(stamp: Stamp, metres: f64) -> DownsampledScan<'static> {
        let odom_from_base = Isometry::translation(metres, 0.0, 0.0);
        DownsampledScan { stamp, odom_from_base, covariance: Matrix6::identity() * 1e-6, points: &[] }
    }

    #[test]
    fn where_none_of_the_places_is_right_for_long_all_are_let_go() {
        // Points in the middle of nowhere: the map is empty.
        let points: Vec<[f32; 3]> = (0..100_u8).map(|x| [f32::from(x) * 0.1, 1.0, 0.0]).collect();
        let ground = SearchableMap::new(Vec::new());
        let scans_until_none = |metres: f64, points: &[[f32; 3]]| {
            let places = [place(0.0, 0.9), place(5.0, 0.9)];
            let mut contest = MultiHypothesisTracker::new(&ground, &places, None, &Isometry::identity());
            (0..100).find(|&scan| {
                let at = dark(Stamp::EPOCH + Span::from_millis(100 * scan), metres * scan as f64 / 50.0);
                contest.take(&DownsampledScan { points, ..at });
                assert!(contest.winner().is_none());
                contest.is_empty()
            })
        };
        let scans = scans_until_none(2.0, &points);
        assert!(scans.is_some_and(|scans| (25..40).contains(&scans)), "{scans:?}");
        assert_eq!(scans_until_none(0.0, &points), None, "from one spot it knows no better");
        assert_eq!(scans_until_none(0.1, &[]), None, "and in the dark not at all");
    }

    #[test]
    fn the_last_place_is_challenged_by_others_that_fit_as_well_and_are_not_out() {
        let ground = SearchableMap::new(Vec::new());
        let start = Isometry::identity();
        let mut contest =
            MultiHypothesisTracker::new(&ground, &[place(0.0, 0.9), place(5.0, 0.5)], None, &start);
        contest.take(&dark(Stamp::EPOCH, 0.0));
        assert_eq!(contest.len(), 1, "the other fits so much less");
        contest.take(&dark(Stamp::EPOCH + Span::from_millis(100), 1.5));
        assert!(!contest.is_fresh());
        let (here, held) = (Isometry::translation(1.5, 0.0, 0.0), Isometry::translation(1.5, 0.0, 0.0));
        let found = [place(20.0, 0.95), place(6.5, 0.94), place(30.0, 0.92), place(1.5, 0.93)];
        contest.inject_hypotheses(&ground, &found, &held, &here);
        assert!(contest.is_fresh());
        let places: Vec<f64> = contest.places().iter().map(|place| place.translation.x).collect();
        assert_eq!(places, [1.5, 20.0], "6.5 is out, and 30 fits less");
        contest.inject_hypotheses(&ground, &[place(1.5, 0.4)], &held, &here);
        assert_eq!(contest.len(), 2, "what fits nowhere well challenges nothing");
    }
}
