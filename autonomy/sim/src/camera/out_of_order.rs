//! Plates of a site whose condition has changed: gauges that drift or are stuck, and plates on doors that stand at another angle.

use super::fixtures::{Face, Fixture, SimulatedQuantity};
use crate::site::{ConditionChange, SimulatedSite};

/// A plate this near to a door leaf hangs on it, metres.
const ON_LEAF_M: f64 = 0.005;
/// Seconds of a day.
const DAY_S: f64 = 86_400.0;

/// The plates as they are on a changed site; `usual` is how they hang on the usual one.
pub(super) fn changed(mut usual: Vec<Fixture>, site: &SimulatedSite) -> Vec<Fixture> {
    for (leaf, motion) in site.turned_leaves() {
        for fixture in &mut usual {
            let plate = fixture.site_from_plate.translation.vector;
            if leaf.iter().any(|solid| solid.shape.clearance(&plate).distance < ON_LEAF_M) {
                fixture.site_from_plate = motion * fixture.site_from_plate;
            }
        }
    }
    for change in site.condition_changes() {
        let (ConditionChange::GaugeDrifts { tag, .. } | ConditionChange::GaugeStuck { tag, .. }) = change
        else {
            continue;
        };
        for fixture in usual.iter_mut().filter(|fixture| fixture.tag == *tag) {
            if let Face::Gauge { reading, .. } = &mut fixture.face {
                *reading = shown(*reading, change);
            }
        }
    }
    usual
}

/// What a gauge shows after a change.
fn shown(reading: SimulatedQuantity, change: &ConditionChange) -> SimulatedQuantity {
    match *change {
        ConditionChange::GaugeDrifts { per_day, begun_days_ago, .. } => SimulatedQuantity {
            mean: reading.mean + per_day * begun_days_ago,
            rise_per_s: reading.rise_per_s + per_day / DAY_S,
            ..reading
        },
        ConditionChange::GaugeStuck { value, .. } => {
            SimulatedQuantity { mean: value, amplitude: 0.0, rise_per_s: 0.0, ..reading }
        }
        _ => reading,
    }
}
