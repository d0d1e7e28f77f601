//! The rules of zones along an edge.

use site_model::{LocalTime, Site, Zone, ZoneEffect, ZoneId};
use std::collections::BTreeSet;
use vocab::Vec3;

/// Parameters of zones with actions.
struct ZoneEntryConfig {
    /// Distance beyond the border of a zone at which the robot has left it, metres. Three times the error of localisation, so that a robot that walks along the border does not
    /// enter again and again.
    leave_margin_m: f64,
}

const CONFIG: ZoneEntryConfig = ZoneEntryConfig { leave_margin_m: 0.3 };

/// What zones say of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ZoneRules {
    pub keep_out: Option<ZoneId>,
    /// Mean of the factors on the time along the edge, by lower speeds and by penalties.
    pub time_factor: f64,
    /// Mean of the penalties alone.
    pub penalty: f64,
}

/// The rules of all zones that hold now, along an edge that is walked at `speed_m_s` elsewhere. Of several rules at a place, the strictest counts. Linear in the
/// zones and the length of the edge.
pub(super) fn rules_on_edge(
    site: &Site,
    (from, to): (Vec3, Vec3),
    speed_m_s: f64,
    time_of_day: Option<LocalTime>,
    step_m: f64,
) -> ZoneRules {
    let mut rules = ZoneRules { keep_out: None, time_factor: 1.0, penalty: 1.0 };
    let zones: Vec<&Zone> = active_zones(site, time_of_day).collect();
    if zones.is_empty() {
        return rules;
    }
    let length_m = super::distance::distance_m(from, to);
    let steps = (length_m / step_m.max(0.01)).ceil().clamp(1.0, 10_000.0) as u32;
    let (mut times, mut penalties) = (0.0, 0.0);
    for step in 0..=steps {
        let point = between(from, to, f64::from(step) / f64::from(steps));
        let (mut speed_here_m_s, mut penalty) = (speed_m_s, 1.0_f64);
        for zone in zones.iter().filter(|zone| zone.contains(point)) {
            match zone.effect {
                ZoneEffect::KeepOut => rules.keep_out = rules.keep_out.or(Some(zone.id)),
                ZoneEffect::SpeedLimit(limit_m_s) => speed_here_m_s = speed_here_m_s.min(limit_m_s),
                ZoneEffect::Penalty(factor) => penalty = penalty.max(factor),
                ZoneEffect::Action(_) => {}
            }
        }
        // Both ends count half, so that an edge is as long as its parts.
        let weight = if step == 0 || step == steps { 0.5 } else { 1.0 };
        times += weight * penalty * speed_m_s / speed_here_m_s.max(0.01);
        penalties += weight * penalty;
    }
    (rules.time_factor, rules.penalty) = (times / f64::from(steps), penalties / f64::from(steps));
    rules
}

/// The zones that hold at this time of day; without a time, all.
pub(crate) fn active_zones(site: &Site, time_of_day: Option<LocalTime>) -> impl Iterator<Item = &Zone> {
    site.zones().filter(move |zone| holds(zone, time_of_day))
}

/// Whether a zone holds at this time of day.
fn holds(zone: &Zone, time_of_day: Option<LocalTime>) -> bool {
    match (zone.daily, time_of_day) {
        (Some([from, until]), Some(now)) if from < until => (from..until).contains(&now),
        // Across midnight.
        (Some([from, until]), Some(now)) => now >= from || now < until,
        _ => true,
    }
}

/// Of the zones with an action, those that the robot has entered, and all in which it is. `inside`: those in which it was. Linear in the corners of the zones.
pub(crate) fn zones_with_actions<'a>(
    site: &'a Site,
    time_of_day: Option<LocalTime>,
    inside: &BTreeSet<ZoneId>,
    point: Vec3,
) -> (Vec<&'a Zone>, BTreeSet<ZoneId>) {
    let (mut entered, mut now) = (Vec::new(), BTreeSet::new());
    for zone in active_zones(site, time_of_day).filter(|zone| matches!(zone.effect, ZoneEffect::Action(_))) {
        let was_inside = inside.contains(&zone.id);
        let is_inside = zone.contains(point);
        if is_inside && !was_inside {
            entered.push(zone);
        }
        if is_inside || (was_inside && is_near(zone, point, CONFIG.leave_margin_m)) {
            now.insert(zone.id);
        }
    }
    (entered, now)
}

/// Whether a point is within a distance of the border of a zone and in its heights. Linear in the corners.
fn is_near(zone: &Zone, point: Vec3, distance_m: f64) -> bool {
    if zone.height_m.is_some_and(|[low, high]| point.z < low - distance_m || point.z > high + distance_m) {
        return false;
    }
    let corners = &zone.corners_m;
    (0..corners.len()).any(|index| {
        let ([ax, ay], [bx, by]) = (corners[index], corners[(index + 1) % corners.len()]);
        let (x, y) = (bx - ax, by - ay);
        let length2 = x * x + y * y;
        let along = (point.x - ax) * x + (point.y - ay) * y;
        let share = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
        (point.x - ax - share * x).hypot(point.y - ay - share * y) <= distance_m
    })
}

fn between(from: Vec3, to: Vec3, share: f64) -> Vec3 {
    let mix = |a: f64, b: f64| a + share * (b - a);
    Vec3::new(mix(from.x, to.x), mix(from.y, to.y), mix(from.z, to.z))
}
