//! Places where the robot may be, tracked side by side until what it sees as it moves leaves one.
//!
//! Look-alikes differ by little in each scan, and scans from one spot all say the same. So evidence is counted by the way walked: each
//! rival gains what its scans fit, for every [`LOOK`] once, and is out when it has fallen too far behind the best one. A robot that
//! stands still before look-alikes never chooses.

use crate::question::Ground;
use geometry::{Isometry, Matrix6, Vector6};
use localisation::{Fix, Hypothesis, Scan, Tracker, Trust, is_same_place};
use mapping::Uncertain;
use std::sync::Arc;

/// A place that one scan was recognised by is so vague where the scan does not see it, as along a corridor: radians and metres.
const RECOGNISED: (f64, f64) = (0.05, 0.4);
/// What is seen is something new after so many metres.
const LOOK: f64 = 0.4;
/// A place is out when all that fitted there, share by look, is so much less than at the best one: what is asked of one scan that
/// tells two places apart at once, and a third more, since a tracked scan is noisier than a settled one.
const BEHIND: f64 = 0.2;
/// The last one is believed after so many scans.
const SCANS: u32 = 5;

/// The places.
#[derive(Debug, Default)]
pub(crate) struct Contest {
    rivals: Vec<Rival>,
    /// Of the last scan.
    odom_from_base: Option<Isometry>,
}

#[derive(Debug)]
struct Rival {
    tracker: Tracker,
    /// How well its scans fit, summed over looks.
    support: f64,
    scans: u32,
    /// Whether nothing speaks against it now.
    sure: bool,
}

impl Contest {
    /// Between these places, of a scan that was taken at a moment of odometry. Each begins with what that scan fits there; the one that
    /// was held until now begins level with the best, because one scan weighs little against all those before.
    pub fn new(
        ground: &Ground,
        places: &[Hypothesis],
        held: Option<&Isometry>,
        odom_from_base: &Isometry,
    ) -> Self {
        let best = places.iter().map(Hypothesis::quality).fold(0.0, f64::max);
        let begin = |place: &Hypothesis| {
            let held = held.is_some_and(|held| is_same_place(&place.map_from_base, held));
            let support = if held { best } else { place.quality() };
            Rival::new(ground, place, support, odom_from_base)
        };
        Self { rivals: places.iter().map(begin).collect(), odom_from_base: Some(*odom_from_base) }
    }

    /// How many are left.
    pub fn len(&self) -> usize {
        self.rivals.len()
    }

    /// Whether none is left.
    pub fn is_empty(&self) -> bool {
        self.rivals.is_empty()
    }

    /// Tracks all places by another scan; those are out that it contradicts, or that have fallen behind. Costs a tracked scan for each.
    pub fn take(&mut self, scan: &Scan) {
        let before = self.odom_from_base.replace(scan.odom_from_base).unwrap_or(scan.odom_from_base);
        let moved = (scan.odom_from_base.translation.vector - before.translation.vector).norm();
        let look = (moved / LOOK).min(1.0);
        self.rivals.retain_mut(|rival| rival.take(scan, look));
        let best = self.rivals.iter().map(|rival| rival.support).fold(0.0, f64::max);
        self.rivals.retain(|rival| best - rival.support <= BEHIND);
    }

    /// The only one left, once enough speaks for it and nothing against.
    pub fn winner(&self) -> Option<&Tracker> {
        match self.rivals.as_slice() {
            [Rival { tracker, scans: SCANS.., sure: true, .. }] => Some(tracker),
            _ => None,
        }
    }
}

impl Rival {
    fn new(ground: &Ground, place: &Hypothesis, support: f64, odom_from_base: &Isometry) -> Self {
        let (turn, vague) = (RECOGNISED.0 * RECOGNISED.0, RECOGNISED.1 * RECOGNISED.1);
        let covariance = Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, vague, vague, vague));
        let map_from_base = Uncertain { pose: place.map_from_base, covariance };
        // Odometry's own doubt counts from the first scan on.
        let tracker = Tracker::new(Arc::clone(ground.guide()), map_from_base, odom_from_base, None);
        Self { tracker, support, scans: 0, sure: false }
    }

    /// Takes a scan in that is worth so much of a look; says whether the robot may still be there.
    fn take(&mut self, scan: &Scan, look: f64) -> bool {
        let Fix { trust, evidence, .. } = self.tracker.track(scan);
        self.support += look * evidence.matched * (1.0 - evidence.sightings.share());
        self.scans += 1;
        self.sure = trust == Trust::Localised;
        !matches!(trust, Trust::Lost(_))
    }
}
