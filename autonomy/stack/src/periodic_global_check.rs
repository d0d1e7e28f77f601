//! A robot that believes to know its place asks now and then whether another one looks more like what it sees.
//!
//! Where a site repeats itself, nothing that a tracker sees need ever contradict the wrong place: all that is there stands where it
//! should. Only the right place shows that it is wrong, by fitting better. Whoever was carried to a look-alike unseen finds out this way.

use crate::odometry_adapter::LocatedScan;
use geometry::Isometry;
use localisation::{PoseHypothesis, RelocalisationResult, classify_hypotheses, is_same_place};

/// Asked so many metres after the place was found, and again after so many.
const FIRST: f64 = 2.0;
const AGAIN: f64 = 10.0;
/// The place is in doubt when it fits less than such a share of what another one does.
const OUTDONE: f64 = 0.93;

/// When to ask.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PeriodicGlobalCheck {
    last: Option<Isometry>,
    /// Metres to go.
    left: f64,
}

impl Default for PeriodicGlobalCheck {
    fn default() -> Self {
        Self { last: None, left: FIRST }
    }
}

impl PeriodicGlobalCheck {
    /// Goes on to a scan that odometry has located; says whether to ask about it.
    pub fn is_due(&mut self, located: &LocatedScan) -> bool {
        let at = located.odom_from_base;
        let before = self.last.replace(at).unwrap_or(at);
        self.left -= (at.translation.vector - before.translation.vector).norm();
        self.left <= 0.0
    }

    /// It has been asked.
    pub fn ask(&mut self) {
        self.left = AGAIN;
    }
}

/// The places between which it has to be decided anew, if another one outdoes that which is held; that is among them, unless nothing fits
/// there at all.
pub(crate) fn find_contradicting_hypotheses(
    held: &Isometry,
    found: &[PoseHypothesis],
) -> Option<Vec<PoseHypothesis>> {
    let own = found.iter().find(|one| is_same_place(&one.map_from_base, held));
    let mut places = match classify_hypotheses(found) {
        RelocalisationResult::Unique(best) => vec![best],
        RelocalisationResult::Ambiguous(several) => several,
        RelocalisationResult::LowConfidence(_) | RelocalisationResult::NotFound => return None,
    };
    let best = places.iter().find(|one| !is_same_place(&one.map_from_base, held))?;
    if own.is_some_and(|own| own.quality() >= OUTDONE * best.quality()) {
        return None;
    }
    let poor = own.filter(|own| !places.contains(own)).copied();
    places.extend(poor);
    Some(places)
}

/// Whether nothing that was found anywhere fits clearly better than the place that is held, and something fits there.
pub(crate) fn is_confirmed(held: &Isometry, found: &[PoseHypothesis]) -> bool {
    let best = found.iter().map(PoseHypothesis::quality).fold(0.0, f64::max);
    let own = found.iter().find(|one| is_same_place(&one.map_from_base, held));
    own.is_some_and(|own| own.quality() >= OUTDONE * best)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, fit: f64) -> PoseHypothesis {
        PoseHypothesis { map_from_base: Isometry::translation(x, 0.0, 0.0), fit, contradicted: 0.0 }
    }

    #[test]
    fn a_place_is_in_doubt_only_where_another_fits_clearly_better_and_stays_in_the_running_then() {
        let held = Isometry::translation(0.1, 0.0, 0.0);
        assert_eq!(find_contradicting_hypotheses(&held, &[at(0.0, 0.9), at(20.0, 0.89)]), None);
        assert_eq!(
            find_contradicting_hypotheses(&held, &[at(20.0, 0.92), at(0.0, 0.88)]),
            None,
            "as good as alike"
        );
        let (better, alike) = (at(20.0, 0.95), at(0.0, 0.85));
        assert_eq!(find_contradicting_hypotheses(&held, &[better, alike]), Some(vec![better, alike]));
        let poor = at(0.0, 0.4);
        assert_eq!(
            find_contradicting_hypotheses(&held, &[better, poor]),
            Some(vec![better, poor]),
            "it is not dropped by one scan"
        );
        assert_eq!(find_contradicting_hypotheses(&held, &[better]), Some(vec![better]));
        assert_eq!(
            find_contradicting_hypotheses(&held, &[at(20.0, 0.6), poor]),
            None,
            "what fits nowhere well says nothing"
        );
        assert_eq!(find_contradicting_hypotheses(&held, &[]), None);
        assert!(is_confirmed(&held, &[at(0.0, 0.9), at(20.0, 0.91)]) && is_confirmed(&held, &[poor]));
        assert!(
            !is_confirmed(&held, &[])
                && !is_confirmed(&held, &[at(20.0, 0.6), poor])
                && !is_confirmed(&held, &[better])
        );
    }
}
