//! Watches the conditions of monitors: threshold, hold time, hysteresis.

use super::battery::{BatteryConfig, battery_monitors};
use site_model::{Monitor, MonitorCondition, MonitorId, MonitorResponse, Resumption};
use std::collections::{BTreeMap, BTreeSet};
use vocab::{Span, Stamp};

/// All monitors of a site and the built-in ones, with their signals. Which conditions hold is recorded elsewhere, because it outlives a restart.
#[derive(Clone, Debug, Default)]
pub struct MonitorBank {
    monitors: BTreeMap<MonitorId, Monitor>,
    /// Value and arrival of each signal that came.
    signals: BTreeMap<String, (f64, Stamp)>,
    /// Since when a condition that does not hold yet has been true.
    pending: BTreeMap<MonitorId, Stamp>,
    /// When watching began, for signals that never came.
    began: Option<Stamp>,
}

impl MonitorBank {
    /// The built-in monitors.
    pub fn new(battery: &BatteryConfig) -> Self {
        let mut bank = Self::default();
        bank.set(std::iter::empty(), battery);
        bank
    }

    /// Watches these monitors, and the built-in ones that none of them replaces by its id.
    pub fn set<'a>(&mut self, monitors: impl Iterator<Item = &'a Monitor>, battery: &BatteryConfig) {
        let built_in = battery_monitors(battery).into_iter();
        self.monitors = built_in.chain(monitors.cloned()).map(|monitor| (monitor.id, monitor)).collect();
        self.pending.retain(|id, _| self.monitors.contains_key(id));
    }

    /// A monitor.
    pub fn get(&self, id: MonitorId) -> Option<&Monitor> {
        self.monitors.get(&id)
    }

    /// A signal has come. Values that are not finite count as none.
    pub fn set_signal(&mut self, name: &str, value: f64, at: Stamp) {
        if value.is_finite() {
            self.signals.insert(name.to_owned(), (value, at));
        }
    }

    /// The last value of a signal.
    pub fn signal(&self, name: &str) -> Option<f64> {
        self.signals.get(name).map(|(value, _)| *value)
    }

    /// The monitors whose condition began to hold or ended. `holding` are those that hold.
    pub fn update(&mut self, at: Stamp, holding: &BTreeSet<MonitorId>) -> Vec<(MonitorId, bool)> {
        let began = *self.began.get_or_insert(at);
        let mut changes = Vec::new();
        for (id, monitor) in &self.monitors {
            let signal = self.signals.get(&monitor.signal).copied();
            let holds = holding.contains(id);
            let is_true = monitor.is_enabled && is_true(monitor.condition, signal, holds, at, began);
            if holds {
                if !is_true {
                    changes.push((*id, false));
                }
                self.pending.remove(id);
            } else if !is_true {
                self.pending.remove(id);
            } else if at - *self.pending.entry(*id).or_insert(at) >= monitor.hold {
                self.pending.remove(id);
                changes.push((*id, true));
            }
        }
        // Monitors that were removed.
        changes.extend(holding.iter().filter(|id| !self.monitors.contains_key(id)).map(|id| (*id, false)));
        changes
    }

    /// The first monitor that sends the robot to a dock now, with what becomes of the run.
    pub fn sends_to_dock(&self, holding: &BTreeSet<MonitorId>) -> Option<(MonitorId, Resumption)> {
        self.responses(holding).find_map(|(id, response)| match response {
            MonitorResponse::GoToDock { afterwards } => Some((id, afterwards)),
            _ => None,
        })
    }

    /// The first monitor that lets no mission begin now.
    pub fn blocking(&self, holding: &BTreeSet<MonitorId>) -> Option<MonitorId> {
        let blocks = |response| {
            matches!(
                response,
                MonitorResponse::BlockMissions
                    | MonitorResponse::GoToDock { .. }
                    | MonitorResponse::Interrupt { .. }
            )
        };
        self.responses(holding).find(|(_, response)| blocks(*response)).map(|(id, _)| id)
    }

    fn responses(&self, holding: &BTreeSet<MonitorId>) -> impl Iterator<Item = (MonitorId, MonitorResponse)> {
        holding.iter().filter_map(|id| Some((*id, self.monitors.get(id)?.response)))
    }
}

/// Whether a condition is true. One that holds ends at its release.
fn is_true(
    condition: MonitorCondition,
    signal: Option<(f64, Stamp)>,
    holds: bool,
    at: Stamp,
    began: Stamp,
) -> bool {
    match (condition, signal) {
        (MonitorCondition::Below { threshold, release }, Some((value, _))) => {
            if holds {
                value <= release
            } else {
                value < threshold
            }
        }
        (MonitorCondition::Above { threshold, release }, Some((value, _))) => {
            if holds {
                value >= release
            } else {
                value > threshold
            }
        }
        // Without a signal, nothing changes.
        (MonitorCondition::Below { .. } | MonitorCondition::Above { .. }, None) => holds,
        (MonitorCondition::Silent(time), signal) => {
            let last = signal.map_or(began, |(_, last)| last);
            at - last >= time && time > Span::ZERO
        }
    }
}
