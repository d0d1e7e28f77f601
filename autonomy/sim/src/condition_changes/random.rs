//! Random changes of the condition of a site, all of them in places that are seen from its round.

use super::{ChangeableGauge, ChangeableThings, rounded};
use crate::random_changes::RoutePoints;
use crate::site::{ConditionChange, Leak, Liquid, SimulatedSite};
use geometry::{Rng, RngTree, Vector3, vec_from_plain, vec_to_plain};
use std::f64::consts::TAU;

/// Parameters of random changes of the condition of a site.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConditionChangesConfig {
    /// Least and greatest angle by which a door is turned, in either direction, radians. Chosen: from 17 to 80 degrees, as on another day.
    pub turn_rad: [f64; 2],
    /// Least and greatest radius of a leak, metres. Chosen: from a cup to a bucket of water on a level floor.
    pub leak_radius_m: [f64; 2],
    /// Least and greatest difference of a leak's temperature from that of its floor, kelvin. Chosen: far above the noise of the thermal camera (0.05 K).
    pub leak_k: [f64; 2],
    /// Share of the leaks that are colder than their floor. Chosen: most media of a plant are warm.
    pub cold_share: f64,
    /// Share of the puddles that are of oil. Chosen: half, as neither is known to be more frequent.
    pub oil_share: f64,
    /// Least and greatest distance of the middle of a leak from the nearest route, metres. Chosen: the robot does not walk through it, and a camera looks down on it.
    pub beside_route_m: [f64; 2],
    /// Least and greatest drift of a gauge per day, as a share of its scale, in either direction. Chosen: with [`Self::drift_days`] from barely readable to most of the scale.
    pub drift_share: [f64; 2],
    /// Least and greatest age of a drift, days. Chosen: between two rounds of maintenance.
    pub drift_days: [f64; 2],
    /// A lamp that goes out is at most this far from a route in the ground plan, metres. Chosen: within the reach of its light.
    pub lamp_within_m: f64,
    /// Height of the points above the floor from which leaks and lamps must be seen, metres. Chosen: that of the cameras on the robot's head.
    pub eye_height_m: f64,
    /// Places that are tried for a leak, and angles for a door. Chosen: it bounds the time at crowded sites; what finds no place is left out.
    pub max_tries: usize,
}

impl Default for ConditionChangesConfig {
    fn default() -> Self {
        Self {
            turn_rad: [0.3, 1.4],
            leak_radius_m: [0.15, 0.6],
            leak_k: [4.0, 25.0],
            cold_share: 0.3,
            oil_share: 0.5,
            beside_route_m: [0.8, 2.5],
            drift_share: [0.001, 0.01],
            drift_days: [5.0, 40.0],
            lamp_within_m: 6.0,
            eye_height_m: 0.8,
            max_tries: 500,
        }
    }
}

/// Kinds of changes, drawn alike.
const KINDS: usize = 5;
/// Most unevenness of the floor below a puddle, metres.
const FLAT_M: f64 = 0.01;
/// Least free height above a puddle, metres: nothing stands in it.
const CLEAR_M: f64 = 0.3;
/// Greatest distance from which something counts as seen, metres.
const SEEN_WITHIN_M: f64 = 8.0;

impl SimulatedSite {
    /// Random changes of the condition of doors, floors, gauges and lamps that are near the round and not changed yet, at most `count`: doors at other angles, which leave the routes free, leaks beside the round,
    /// gauges that drift or are stuck, and lamps that are out. The same seed gives the same changes.
    pub fn random_condition_changes(
        &self,
        seed: u64,
        count: usize,
        config: &ConditionChangesConfig,
    ) -> Vec<ConditionChange> {
        let mut draw = Draw {
            site: self,
            left: self.unchanged_things(config),
            route: RoutePoints::new(self),
            rng: RngTree::new(seed).child("changes of condition").rng(),
            config,
        };
        let mut changes = Vec::new();
        for _ in 0..count {
            let first = index(&mut draw.rng, KINDS);
            // If the site has nothing of a kind, the next kind is taken.
            changes.extend((0..KINDS).find_map(|further| draw.of_kind((first + further) % KINDS)));
        }
        changes
    }

    /// What is not changed yet, without lamps that nobody sees from the round.
    fn unchanged_things(&self, config: &ConditionChangesConfig) -> ChangeableThings {
        let mut left = self.changeable_things();
        for change in self.condition_changes() {
            match change {
                ConditionChange::DoorTurned { hinge, .. } => left.doors.retain(|door| door != hinge),
                ConditionChange::GaugeDrifts { tag, .. } | ConditionChange::GaugeStuck { tag, .. } => {
                    left.gauges.retain(|gauge| gauge.tag != *tag);
                }
                ConditionChange::LampOut { lamp: out } => left.lamps.retain(|lamp| lamp != out),
                ConditionChange::Leak(_) => {}
            }
        }
        let route = RoutePoints::new(self);
        left.lamps
            .retain(|lamp| self.is_seen_from(&route, &vec_from_plain(*lamp), config.lamp_within_m, config));
        left
    }

    /// Whether a point is seen from some point of a route within that distance in the ground plan.
    fn is_seen_from(
        &self,
        route: &RoutePoints,
        point: &Vector3,
        within_m: f64,
        config: &ConditionChangesConfig,
    ) -> bool {
        route.points.iter().any(|at| {
            let eye = at + Vector3::z() * config.eye_height_m;
            let offset = point - eye;
            let distance_m = offset.norm();
            offset.xy().norm() < within_m
                && distance_m < SEEN_WITHIN_M
                && distance_m > 0.1
                && self.cast_ray(&eye, &(offset / distance_m), distance_m - 0.05).is_none()
        })
    }
}

/// The state of drawing changes of a site.
struct Draw<'a> {
    site: &'a SimulatedSite,
    /// What is not changed yet.
    left: ChangeableThings,
    route: RoutePoints,
    rng: Rng,
    config: &'a ConditionChangesConfig,
}

impl Draw<'_> {
    /// A change of that kind; none if the site has nothing for it.
    fn of_kind(&mut self, kind: usize) -> Option<ConditionChange> {
        match kind {
            0 => self.door(),
            1 => self.leak().map(ConditionChange::Leak),
            2 => self.drift(),
            3 => {
                let gauge = taken(&mut self.left.gauges, &mut self.rng)?;
                let value = rounded(self.rng.range(gauge.scale[0], gauge.scale[1]));
                Some(ConditionChange::GaugeStuck { tag: gauge.tag, value })
            }
            _ => Some(ConditionChange::LampOut { lamp: taken(&mut self.left.lamps, &mut self.rng)? }),
        }
    }

    /// A door that leaves the routes free. Those that cannot are not tried again.
    fn door(&mut self) -> Option<ConditionChange> {
        while let Some(hinge) = taken(&mut self.left.doors, &mut self.rng) {
            for _ in 0..self.config.max_tries.min(8) {
                let turn_rad = self.signed(self.config.turn_rad);
                if self.site.stays_free(hinge, turn_rad) {
                    return Some(ConditionChange::DoorTurned { hinge, turn_rad });
                }
            }
        }
        None
    }

    fn drift(&mut self) -> Option<ConditionChange> {
        let ChangeableGauge { tag, scale, .. } = taken(&mut self.left.gauges, &mut self.rng)?;
        let per_day = rounded((scale[1] - scale[0]) * self.signed(self.config.drift_share));
        let [least, most] = self.config.drift_days;
        let begun_days_ago = rounded(self.rng.range(least, most));
        Some(ConditionChange::GaugeDrifts { tag, per_day, begun_days_ago })
    }

    /// A puddle on a free, level floor beside the route.
    fn leak(&mut self) -> Option<Leak> {
        let [nearest_m, farthest_m] = self.config.beside_route_m;
        for _ in 0..self.config.max_tries {
            let at = *self.route.points.get(index(&mut self.rng, self.route.points.len()))?;
            let (away_m, toward) = (self.rng.range(nearest_m, farthest_m), self.rng.range(0.0, TAU));
            let [least_m, most_m] = self.config.leak_radius_m;
            let radius_m = rounded(self.rng.range(least_m, most_m));
            let beside = at + Vector3::new(toward.cos(), toward.sin(), 0.0) * away_m;
            let Some(middle) = self.site.floor_below(&beside) else { continue };
            if self.route.distance_m(&middle) >= nearest_m && self.is_free_floor(&middle, radius_m) {
                let is_cold = self.rng.uniform() < self.config.cold_share;
                let kelvin = rounded(self.rng.range(self.config.leak_k[0], self.config.leak_k[1]));
                let is_oil = self.rng.uniform() < self.config.oil_share;
                return Some(Leak {
                    place: vec_to_plain(&middle.map(rounded)),
                    radius_m,
                    liquid: Some(if is_oil { Liquid::Oil } else { Liquid::Water }),
                    warmer_k: if is_cold { -kelvin } else { kelvin },
                });
            }
        }
        None
    }

    /// Whether a puddle there is on a level floor inside the site with nothing on it, and is seen from the route.
    fn is_free_floor(&self, middle: &Vector3, radius_m: f64) -> bool {
        let is_level = (0..8).all(|corner| {
            let toward = f64::from(corner) * TAU / 8.0;
            let at = middle + Vector3::new(toward.cos(), toward.sin(), 0.0) * radius_m;
            let is_flat =
                self.site.floor_below(&at).is_some_and(|floor| (floor.z - middle.z).abs() <= FLAT_M);
            is_flat && self.is_clear(&at)
        });
        is_level
            && self.is_clear(middle)
            && self.site.is_inside(middle)
            && self.site.is_seen_from(
                &self.route,
                &(middle + Vector3::z() * 0.05),
                self.config.beside_route_m[1] + 1.0,
                self.config,
            )
    }

    fn is_clear(&self, floor: &Vector3) -> bool {
        self.site.cast_ray(&(floor + Vector3::z() * FLAT_M), &Vector3::z(), CLEAR_M).is_none()
    }

    /// A number from a range, with a random sign.
    fn signed(&mut self, range: [f64; 2]) -> f64 {
        let size = self.rng.range(range[0], range[1]);
        if self.rng.uniform() < 0.5 { size } else { -size }
    }
}

/// A random index below a length; 0 if that is 0.
fn index(rng: &mut Rng, length: usize) -> usize {
    ((rng.uniform() * length as f64) as usize).min(length.saturating_sub(1))
}

/// Takes a random one out of a list.
fn taken<T>(list: &mut Vec<T>, rng: &mut Rng) -> Option<T> {
    let place = index(rng, list.len());
    (!list.is_empty()).then(|| list.remove(place))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::site::SiteName;

    #[test]
    fn the_same_seed_gives_the_same_changes_of_what_the_site_has() {
        let config = ConditionChangesConfig::default();
        for name in [SiteName::B1, SiteName::Plant, SiteName::Generated(4)] {
            let site = SimulatedSite::new(name);
            let changes = site.random_condition_changes(4, 12, &config);
            assert_eq!(changes, site.random_condition_changes(4, 12, &config), "{name}");
            assert_ne!(changes, site.random_condition_changes(5, 12, &config), "{name}");
            assert_eq!(changes.len(), 12, "{name}");
            // All can be made as they are, so they name what is there, and nothing twice.
            let after = site.with_condition_changes(&changes).expect("changes of what is there");
            assert_eq!(after.condition_changes().len(), 12, "{name}");
            let kinds: std::collections::BTreeSet<_> = changes
                .iter()
                .map(|change| match change {
                    ConditionChange::DoorTurned { .. } => 0,
                    ConditionChange::Leak(_) => 1,
                    ConditionChange::GaugeDrifts { .. } => 2,
                    ConditionChange::GaugeStuck { .. } => 3,
                    ConditionChange::LampOut { .. } => 4,
                })
                .collect();
            assert!(kinds.len() >= 4, "{name}: {kinds:?}");
            let route = RoutePoints::new(&site);
            for change in &changes {
                if let ConditionChange::Leak(leak) = change {
                    let beside_m = route.distance_m(&vec_from_plain(leak.place));
                    assert!(beside_m >= config.beside_route_m[0] - 1e-4, "{name}: {leak:?}");
                }
            }
            // Further ones are of other things.
            let further = after.random_condition_changes(9, 5, &config);
            assert!(after.with_condition_changes(&further).is_ok(), "{name}: {further:?}");
        }
    }

    #[test]
    fn random_doors_leave_the_routes_free() {
        let mut doors = 0;
        for name in [SiteName::B1, SiteName::Plant, SiteName::Generated(4)] {
            let site = SimulatedSite::new(name);
            for change in site.random_condition_changes(2, 60, &ConditionChangesConfig::default()) {
                if let ConditionChange::DoorTurned { hinge, turn_rad } = change {
                    assert!(site.stays_free(hinge, turn_rad), "{name} {hinge:?}");
                    doors += 1;
                }
            }
        }
        assert!(doors >= 3, "{doors} doors");
    }
}
