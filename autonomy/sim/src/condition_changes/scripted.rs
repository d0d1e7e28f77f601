//! Changes that are asked for: each must name something that the site has.

use super::{ChangeableThings, ConditionChangeError, rounded};
use crate::site::{ConditionChange, Leak, SimulatedSite};
use geometry::{Vector3, vec_from_plain};
use std::f64::consts::PI;
use vocab::Vec3;

/// Greatest distance from a point that names a lamp to the lamp, metres. Lamps are at least 3 m apart.
const LAMP_WITHIN_M: f64 = 1.0;
/// Greatest vertical distance from the middle of a puddle to its floor, metres.
const FLOOR_WITHIN_M: f64 = 0.3;
/// Least and greatest radius of a leak, metres.
const RADIUS_M: [f64; 2] = [0.02, 10.0];
/// Least and greatest excess temperature of a leak, kelvin.
const WARMER_K: [f64; 2] = [-200.0, 500.0];
/// Least and greatest value on a gauge, and drift per day.
const VALUE: [f64; 2] = [-1e9, 1e9];
/// Least and greatest age of a drift, days.
const DRIFT_DAYS: [f64; 2] = [0.0, 36_525.0];
/// Least and greatest angle of a door, radians.
const TURN_RAD: [f64; 2] = [-PI, PI];

impl SimulatedSite {
    /// The site after these changes of its condition, besides those that it has already. A point names the door or the lamp nearest to it. [`Self::condition_changes`] of the result
    /// says where they are exactly.
    ///
    /// # Errors
    /// When a change names nothing that the site has, or something that is changed already, or has a number that makes no sense.
    pub fn with_condition_changes(&self, changes: &[ConditionChange]) -> Result<Self, ConditionChangeError> {
        if changes.is_empty() {
            return Ok(self.clone());
        }
        let things = self.changeable_things();
        let mut all = self.condition_changes().to_vec();
        for change in changes {
            let exact = self.exact(change, &things)?;
            match named(&exact) {
                Some(name) if all.iter().any(|other| named(other).as_ref() == Some(&name)) => {
                    return Err(ConditionChangeError::Twice { what: name });
                }
                _ => all.push(exact),
            }
        }
        Ok(self.with_conditions(all))
    }

    /// The change with the exact position of what it names.
    fn exact(
        &self,
        change: &ConditionChange,
        things: &ChangeableThings,
    ) -> Result<ConditionChange, ConditionChangeError> {
        match change {
            ConditionChange::DoorTurned { hinge, turn_rad } => {
                check("the angle of a door (radians)", *turn_rad, TURN_RAD)?;
                let at = hinge.to_array();
                let leaf = self.door_leaf(*hinge).ok_or(ConditionChangeError::NoDoor { at })?;
                Ok(ConditionChange::DoorTurned { hinge: things.doors[leaf], turn_rad: *turn_rad })
            }
            ConditionChange::Leak(leak) => self.exact_leak(leak).map(ConditionChange::Leak),
            ConditionChange::GaugeDrifts { tag, per_day, begun_days_ago } => {
                check("the drift of a gauge per day", *per_day, VALUE)?;
                check("the age of a drift (days)", *begun_days_ago, DRIFT_DAYS)?;
                gauge(tag, things).map(|()| change.clone())
            }
            ConditionChange::GaugeStuck { tag, value } => {
                check("the value of a stuck gauge", *value, VALUE)?;
                gauge(tag, things).map(|()| change.clone())
            }
            ConditionChange::LampOut { lamp } => {
                let (at, point) = (lamp.to_array(), vec_from_plain(*lamp));
                let away = |lamp: &Vec3| (vec_from_plain(*lamp) - point).norm();
                let nearest = things.lamps.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
                let near = nearest.filter(|lamp| away(lamp) <= LAMP_WITHIN_M);
                let lamp = near.ok_or(ConditionChangeError::NoLamp { at, within_m: LAMP_WITHIN_M })?;
                Ok(ConditionChange::LampOut { lamp: *lamp })
            }
        }
    }

    /// The leak with its middle on the floor, if it is a puddle.
    fn exact_leak(&self, leak: &Leak) -> Result<Leak, ConditionChangeError> {
        check("the radius of a leak (metres)", leak.radius_m, RADIUS_M)?;
        check("the warmth of a leak (kelvin)", leak.warmer_k, WARMER_K)?;
        let none = ConditionChangeError::NoSurface { at: leak.place.to_array() };
        let place = vec_from_plain(leak.place);
        if !leak.place.is_finite() {
            return Err(none);
        }
        if leak.liquid.is_none() {
            return self.distance(&place, leak.radius_m).map(|_| *leak).ok_or(none);
        }
        let above = place + Vector3::z() * FLOOR_WITHIN_M;
        let floor = self.cast_ray(&above, &-Vector3::z(), 2.0 * FLOOR_WITHIN_M);
        let (down_m, _) = floor.ok_or(none)?;
        let place = Vec3 { z: rounded(above.z - down_m), ..leak.place };
        Ok(Leak { place, ..*leak })
    }
}

fn check(what: &'static str, number: f64, limits: [f64; 2]) -> Result<(), ConditionChangeError> {
    let is_within = number.is_finite() && (limits[0]..=limits[1]).contains(&number);
    if is_within { Ok(()) } else { Err(ConditionChangeError::OutOfRange { what, limits }) }
}

fn gauge(tag: &str, things: &ChangeableThings) -> Result<(), ConditionChangeError> {
    let known = || things.gauges.iter().map(|gauge| gauge.tag.clone());
    let is_there = known().any(|known| known == tag);
    if is_there {
        Ok(())
    } else {
        Err(ConditionChangeError::NoGauge { tag: tag.to_owned(), known: known().collect() })
    }
}

/// The thing that a change is of, if it can change once only.
fn named(change: &ConditionChange) -> Option<String> {
    let at = |point: &Vec3| format!("({:.2}, {:.2}, {:.2})", point.x, point.y, point.z);
    match change {
        ConditionChange::DoorTurned { hinge, .. } => Some(format!("the door at {}", at(hinge))),
        ConditionChange::LampOut { lamp } => Some(format!("the lamp at {}", at(lamp))),
        ConditionChange::GaugeDrifts { tag, .. } | ConditionChange::GaugeStuck { tag, .. } => {
            Some(format!("the gauge {tag}"))
        }
        ConditionChange::Leak(_) => None,
    }
}
