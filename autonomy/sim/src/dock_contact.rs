//! The contacts of a dock: they touch in the right pose only, and even there they fail at times.

use crate::site::SimulatedSite;
use geometry::{Isometry, Rng};
use std::collections::BTreeMap;

/// The contacts between robot and docks.
#[derive(Clone, Debug)]
pub(crate) struct DockContact {
    /// Share of the attempts to dock at which no current flows although the contacts touch.
    failure_share: f64,
    rng: Rng,
    /// The dock at which the robot tries, and whether current can flow.
    attempt: Option<(usize, bool)>,
    /// Most failed attempts in a row. After that an attempt works: the failed ones have rubbed the contacts clean.
    max_failures_in_a_row: u32,
    /// For each dock whose contacts failed at the last attempt: the number of failed attempts in a row.
    failed: BTreeMap<usize, u32>,
}

impl DockContact {
    /// A robot that begins in this pose. Where that is a dock, it is charged.
    pub(crate) fn new(
        failure_share: f64,
        max_failures_in_a_row: u32,
        rng: Rng,
        site: &SimulatedSite,
        site_from_base: &Isometry,
    ) -> Self {
        let attempt = site.dock_in_contact(site_from_base).map(|dock| (dock, true));
        Self { failure_share, rng, attempt, max_failures_in_a_row, failed: BTreeMap::new() }
    }

    /// Takes the present pose. Returns whether the contacts carry current.
    pub(crate) fn update(&mut self, site: &SimulatedSite, site_from_base: &Isometry) -> bool {
        self.attempt = self.attempt.filter(|(dock, _)| site.is_docking(*dock, site_from_base));
        let Some(dock) = site.dock_in_contact(site_from_base) else { return false };
        let (_, works) = match self.attempt {
            Some(attempt) => attempt,
            None => {
                // Drawn in any case, so that the numbers of later attempts do not depend on this one.
                let (is_bad, failures) =
                    (self.rng.uniform() < self.failure_share, self.failed.remove(&dock).unwrap_or(0));
                let is_failure = is_bad && failures < self.max_failures_in_a_row;
                if is_failure {
                    self.failed.insert(dock, failures + 1);
                }
                *self.attempt.insert((dock, !is_failure))
            }
        };
        works
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::site::SiteName;
    use geometry::{RngTree, Rotation};
    use nalgebra::Translation3;

    /// A base at b1's dock, displaced as a docked robot looks.
    fn base(forward_m: f64, left_m: f64, turn_deg: f64) -> Isometry {
        let place = Translation3::new(16.4 + forward_m, 23.5 + left_m, 0.52);
        Isometry::from_parts(place, Rotation::from_euler_angles(0.0, 0.0, turn_deg.to_radians()))
    }

    fn contact(site: &SimulatedSite, failure_share: f64, begins: &Isometry) -> DockContact {
        DockContact::new(failure_share, 1, RngTree::new(1).rng(), site, begins)
    }

    #[test]
    fn current_flows_within_3_cm_and_3_degrees_only() {
        let site = SimulatedSite::new(SiteName::B1);
        for (forward_m, left_m, turn_deg, flows) in [
            (0.0, 0.0, 0.0, true),
            (0.02, -0.02, 2.9, true),
            (0.031, 0.0, 0.0, false),
            (0.0, 0.031, 0.0, false),
            (0.0, 0.0, -3.1, false),
            (0.0, 0.0, 180.0, false),
        ] {
            let mut contact = contact(&site, 0.0, &base(2.0, 0.0, 0.0));
            assert_eq!(
                contact.update(&site, &base(forward_m, left_m, turn_deg)),
                flows,
                "{forward_m} {left_m} {turn_deg}"
            );
        }
        let moved = site.with_moved_dock(0, 0.1, 0.1, 0.1);
        assert!(!contact(&moved, 0.0, &base(2.0, 0.0, 0.0)).update(&moved, &base(0.0, 0.0, 0.0)));
        assert!(contact(&moved, 0.0, &base(2.0, 0.0, 0.0)).update(&moved, &base(0.1, 0.1, 5.7)));
        assert!(
            !contact(&site.without_dock(0), 0.0, &base(0.0, 0.0, 0.0))
                .update(&site.without_dock(0), &base(0.0, 0.0, 0.0))
        );
    }

    #[test]
    fn contacts_that_fail_work_at_the_next_attempt() {
        let site = SimulatedSite::new(SiteName::B1);
        let (away, nearly, docked) = (base(1.0, 0.0, 0.0), base(0.1, 0.0, 0.0), base(0.0, 0.0, 0.0));
        let mut contact = contact(&site, 1.0, &away);
        assert!(!contact.update(&site, &docked) && !contact.update(&site, &nearly));
        assert!(!contact.update(&site, &docked), "still the same attempt");
        assert!(!contact.update(&site, &away) && contact.update(&site, &docked));
        assert!(!contact.update(&site, &nearly) && contact.update(&site, &docked));
        assert!(
            !contact.update(&site, &away) && !contact.update(&site, &docked),
            "and fail again after that"
        );
        // A robot that begins in a dock is charged.
        assert!(self::contact(&site, 1.0, &docked).update(&site, &docked));
    }
    #[test]
    fn contacts_may_fail_several_times_in_a_row() {
        let site = SimulatedSite::new(SiteName::B1);
        let (away, docked) = (base(1.0, 0.0, 0.0), base(0.0, 0.0, 0.0));
        let mut contact = DockContact::new(1.0, 2, RngTree::new(1).rng(), &site, &away);
        let charges = [(); 6].map(|()| !contact.update(&site, &away) && contact.update(&site, &docked));
        assert_eq!(charges, [false, false, true, false, false, true]);
    }
}
