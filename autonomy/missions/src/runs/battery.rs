//! The built-in battery monitors. They are of the general kind: a signal, a condition with a hold time and a release, and what to do. A site replaces one by a monitor
//! of the same id.

use super::battery_texts;
use crate::graph::{LearnedTimes, Route};
use site_model::{Monitor, MonitorCondition, MonitorId, MonitorResponse, Resumption};
use uuid::Uuid;
use vocab::Span;

/// Id of the monitor of a low charge.
pub const LOW_CHARGE: MonitorId = MonitorId(Uuid::from_u128(0xba77_e210_0000_8000_8000_0000_0000_0001));
/// Id of the monitor of the reserve.
pub const RESERVE: MonitorId = MonitorId(Uuid::from_u128(0xba77_e210_0000_8000_8000_0000_0000_0002));

/// Signal of the charge, 0 to 1.
pub const CHARGE_SIGNAL: &str = "battery.charge";
/// Signal of the reserve: the charge less what the route to the nearest dock needs, and less the floor.
pub const RESERVE_SIGNAL: &str = "battery.reserve";

/// Quantile of the normal distribution below which 95 % lie.
const P95: f64 = 1.645;

/// Parameters of the battery monitors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatteryConfig {
    /// Charge below which the robot goes to a dock. Chosen: twice [`Self::floor`]. With less the robot may not reach a dock that is blocked at first, with more it works
    /// less.
    pub low: f64,
    /// Charge above which it goes on. Chosen: chargers slow down above it, so that the rest takes long.
    pub release: f64,
    /// Charge that is left at the dock at least. Chosen: robots switch off some time before their battery is empty.
    pub floor: f64,
    /// The reserve above which the robot goes on. More than 0, so that it does not turn round at once. Chosen: about half an hour of walking ([`Self::use_per_s`]).
    pub reserve_release: f64,
    /// Charge that walking uses in a second. Chosen: 90 minutes of walking for a full battery, as of common legged robots.
    pub use_per_s: f64,
    /// Charge that standing uses in a second. Chosen: 5 hours of standing for a full battery, as of common legged robots.
    pub standing_use_per_s: f64,
    /// Energy of the full battery, joules. Chosen: 930 Wh, as of common legged robots.
    pub capacity_j: f64,
    /// Standard deviation of the time of an edge that was not walked yet, as a share of that time. Chosen: half, because people and doors make a walk longer.
    pub time_std_ratio: f64,
    /// Time for which a low charge must hold. Longer than the drop of the voltage when the legs push hard. Chosen: less than a thousandth of the battery is used
    /// meanwhile, 0.2 %.
    pub hold: Span,
}

impl Default for BatteryConfig {
    fn default() -> Self {
        Self {
            low: 0.2,
            release: 0.8,
            floor: 0.1,
            reserve_release: 0.3,
            use_per_s: 1.0 / (90.0 * 60.0),
            standing_use_per_s: 1.0 / (5.0 * 3600.0),
            capacity_j: 930.0 * 3600.0,
            time_std_ratio: 0.5,
            hold: Span::from_millis(10_000),
        }
    }
}

impl BatteryConfig {
    /// Share of the charge that is expected to be used by walking and by actions, which take `action_j` besides what the standing robot takes.
    pub fn charge_used(&self, walk_s: f64, action_s: f64, action_j: f64) -> f64 {
        walk_s * self.use_per_s + action_s * self.standing_use_per_s + action_j / self.capacity_j
    }
}

/// The built-in monitors.
pub fn battery_monitors(config: &BatteryConfig) -> Vec<Monitor> {
    let monitor = |id, name: &str, signal: &str, threshold, release| Monitor {
        id,
        name: name.to_owned(),
        signal: signal.to_owned(),
        condition: MonitorCondition::Below { threshold, release },
        hold: config.hold,
        response: MonitorResponse::GoToDock { afterwards: Resumption::Resume },
        is_enabled: true,
    };
    vec![
        monitor(LOW_CHARGE, battery_texts::BATTERY_LOW, CHARGE_SIGNAL, config.low, config.release),
        monitor(RESERVE, battery_texts::BATTERY_RESERVE, RESERVE_SIGNAL, 0.0, config.reserve_release),
    ]
}

/// Time that the route to a dock takes in 95 of 100 cases, seconds: the sum of the edges' times, and their standard deviations as of independent times.
pub fn time_to_dock_p95_s(
    route: &Route,
    times_s: &[f64],
    learned: &LearnedTimes,
    config: &BatteryConfig,
) -> f64 {
    let variance = |(edge, time_s): (&site_model::EdgeId, &f64)| match learned.get(edge) {
        Some(learned) if learned.count > 1 => learned.variance_s2,
        _ => (config.time_std_ratio * time_s).powi(2),
    };
    let variance_s2: f64 = route.edges.iter().zip(times_s).map(variance).sum();
    route.cost_s + P95 * variance_s2.sqrt()
}

/// The charge that is left over the route to the dock and the floor.
pub(super) fn reserve(charge: f64, time_to_dock_s: f64, config: &BatteryConfig) -> f64 {
    charge - time_to_dock_s * config.use_per_s - config.floor
}
