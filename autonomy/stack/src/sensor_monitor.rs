//! Rates and silences of the sensors, and findings about them, as the health report that clients see.

use crate::texts;
use messages::{Finding, Health, Sensor, SensorHealth, Severity};
use std::collections::VecDeque;
use vocab::{Span, Stamp};

/// Parameters of the [`SensorMonitor`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SensorMonitorConfig {
    /// Time over which messages are counted for a rate. At 10 Hz, the usual rate of a LiDAR, it holds 20 messages. Chosen: a rate is then good to 5 %.
    pub rate_window: Span,
    /// A sensor without a message for this time is reported as silent. 15 periods of a LiDAR at 10 Hz. Chosen: three scans of the slowest LiDARs, which turn twice a
    /// second.
    pub silence_timeout: Span,
    /// Time between two reports while nothing changes. Chosen: people see that the report lives.
    pub report_period: Span,
}

impl Default for SensorMonitorConfig {
    fn default() -> Self {
        Self {
            rate_window: Span::from_millis(2_000),
            silence_timeout: Span::from_millis(1_500),
            report_period: Span::from_millis(1_000),
        }
    }
}

/// Kinds of sensors with their names for people, in the order of the report.
const KINDS: [&str; 5] = ["LiDAR", "IMU", "Legs", "External odometry", "Battery"];
/// Index of the battery in [`KINDS`]. It is never reported as silent, because batteries send at any rate.
const BATTERY: usize = 4;

/// Collects the stamps of sensor messages and the findings about sensors.
#[derive(Debug, Default)]
pub(crate) struct SensorMonitor {
    config: SensorMonitorConfig,
    /// Of each kind, the stamps within the rate window.
    recent: [VecDeque<Stamp>; KINDS.len()],
    /// Of each kind, the stamp of the last message.
    last: [Option<Stamp>; KINDS.len()],
    findings: Vec<Finding>,
    published: Option<Stamp>,
    /// Whether a sensor or a finding is new since the last report.
    has_changed: bool,
}

impl SensorMonitor {
    /// Counts a message that arrived at `at`. Amortised constant time.
    pub fn on_message(&mut self, at: Stamp, sensor: &Sensor) {
        let kind = match sensor {
            Sensor::Scan(_) => 0,
            Sensor::Imu(_) => 1,
            Sensor::Legs(_) => 2,
            Sensor::Odometry(_) => 3,
            Sensor::Battery(_) => BATTERY,
        };
        self.has_changed |= self.last[kind].is_none();
        self.last[kind] = Some(at);
        self.recent[kind].push_back(at);
        self.forget_old(kind, at);
    }

    /// Adds a finding, unless there is the same already.
    pub fn add_finding(&mut self, finding: Finding) {
        if !self.findings.contains(&finding) {
            self.findings.push(finding);
            self.findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
            self.has_changed = true;
        }
    }

    /// The report, if something is new or the period has passed.
    pub fn report(&mut self, at: Stamp, points_used: u32) -> Option<Health> {
        let period = self.config.report_period;
        let is_due = self.has_changed || self.published.is_none_or(|last| at - last >= period);
        if !is_due {
            return None;
        }
        self.has_changed = false;
        self.published = Some(at);
        let mut findings = self.silences(at);
        findings.extend(self.findings.iter().cloned());
        Some(Health { sensors: self.sensors(at), findings, points_used })
    }

    fn sensors(&mut self, at: Stamp) -> Vec<SensorHealth> {
        let mut sensors = Vec::new();
        for (kind, name) in KINDS.into_iter().enumerate() {
            let Some(last) = self.last[kind] else { continue };
            self.forget_old(kind, at);
            let rate_hz = self.recent[kind].len() as f32 / self.config.rate_window.secs_f64() as f32;
            sensors.push(SensorHealth { name: name.to_owned(), rate_hz, age: at - last });
        }
        sensors
    }

    fn forget_old(&mut self, kind: usize, at: Stamp) {
        let window = self.config.rate_window;
        while self.recent[kind].front().is_some_and(|&old| at - old > window) {
            self.recent[kind].pop_front();
        }
    }

    fn silences(&self, at: Stamp) -> Vec<Finding> {
        let silence = |(kind, name): (usize, &str)| {
            let age = at - self.last[kind]?;
            (kind != BATTERY && age > self.config.silence_timeout).then(|| Finding {
                severity: Severity::Error,
                what: texts::sensor_silent(name, age.secs_f64()),
                remedy: texts::SILENT_SENSOR_REMEDY.to_owned(),
            })
        };
        KINDS.into_iter().enumerate().filter_map(silence).collect()
    }
}

#[cfg(test)]
#[path = "sensor_monitor_tests.rs"]
mod tests;
