//! The rules of zones along an edge.

use site_model::{LocalTime, Site, Zone, ZoneEffect, ZoneId};
use vocab::Vec3;

/// What zones say of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ZoneRules {
    pub keep_out: Option<ZoneId>,
    pub speed_limit_m_s: Option<f64>,
    /// Factor on the cost. The greatest of all zones counts for the whole edge.
    pub penalty: f64,
}

/// The rules of all zones that hold now and that an edge passes. Of several rules, the strictest counts.
pub(super) fn rules_on_edge(
    site: &Site,
    (from, to): (Vec3, Vec3),
    time_of_day: Option<LocalTime>,
    step_m: f64,
) -> ZoneRules {
    let mut rules = ZoneRules { keep_out: None, speed_limit_m_s: None, penalty: 1.0 };
    let length_m = super::distance::distance_m(from, to);
    let steps = (length_m / step_m.max(0.01)).ceil().clamp(1.0, 10_000.0) as u32;
    for zone in site.zones().filter(|zone| holds(zone, time_of_day)) {
        let mut points = (0..=steps).map(|step| between(from, to, f64::from(step) / f64::from(steps)));
        if !points.any(|point| contains(zone, point)) {
            continue;
        }
        match zone.effect {
            ZoneEffect::KeepOut => rules.keep_out = rules.keep_out.or(Some(zone.id)),
            ZoneEffect::SpeedLimit(limit) => {
                rules.speed_limit_m_s = Some(rules.speed_limit_m_s.unwrap_or(f64::INFINITY).min(limit));
            }
            ZoneEffect::Penalty(factor) => rules.penalty = rules.penalty.max(factor),
            ZoneEffect::Action(_) => {}
        }
    }
    rules
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

fn between(from: Vec3, to: Vec3, share: f64) -> Vec3 {
    let mix = |a: f64, b: f64| a + share * (b - a);
    Vec3::new(mix(from.x, to.x), mix(from.y, to.y), mix(from.z, to.z))
}

/// Whether a point is in a zone: even-odd rule over its corners.
fn contains(zone: &Zone, point: Vec3) -> bool {
    if zone.height_m.is_some_and(|[low, high]| point.z < low || point.z > high) {
        return false;
    }
    is_inside(&zone.corners_m, [point.x, point.y])
}

/// Whether a point is inside a polygon, by the even-odd rule. Linear in the corners.
pub(super) fn is_inside(corners: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let mut inside = false;
    for (index, a) in corners.iter().enumerate() {
        let b = corners[(index + 1) % corners.len()];
        if (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
            inside = !inside;
        }
    }
    inside
}
