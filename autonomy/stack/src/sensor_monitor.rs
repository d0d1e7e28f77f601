//! Which sensors speak, how often, and what is wrong.

use crate::texts;
use messages::{Finding, Health, Sensor, SensorHealth, Severity};
use std::collections::VecDeque;
use vocab::{Span, Stamp};

/// Rates are counted over this long.
const WINDOW: Span = Span::from_millis(2_000);
/// A sensor silent for this long is reported.
const SILENT: Span = Span::from_millis(1_500);
/// Health is published this often.
const EVERY: Span = Span::from_millis(1_000);

/// Kinds of sensors in the order of the list shown.
const NAMES: [&str; 5] = ["LiDAR", "IMU", "Legs", "External odometry", "Battery"];
/// Whether silence of the kind matters: a battery may speak as seldom as it likes.
const WATCHED: [bool; 5] = [true, true, true, true, false];

/// Bookkeeping of all sensors.
#[derive(Debug, Default)]
pub(crate) struct SensorMonitor {
    heard: [VecDeque<Stamp>; 5],
    last: [Option<Stamp>; 5],
    findings: Vec<Finding>,
    published: Option<Stamp>,
    dirty: bool,
}

impl SensorMonitor {
    /// Notes that a sensor spoke at `at`. Amortised constant time.
    pub fn on_message(&mut self, at: Stamp, sensor: &Sensor) {
        let kind = match sensor {
            Sensor::Scan(_) => 0,
            Sensor::Imu(_) => 1,
            Sensor::Legs(_) => 2,
            Sensor::Odometry(_) => 3,
            Sensor::Battery(_) => 4,
        };
        self.dirty |= self.last[kind].is_none();
        self.last[kind] = Some(at);
        self.heard[kind].push_back(at);
        while self.heard[kind].front().is_some_and(|&old| at - old > WINDOW) {
            self.heard[kind].pop_front();
        }
    }

    /// Adds a finding, or renews the one that says the same.
    pub fn add_finding(&mut self, finding: Finding) {
        if !self.findings.contains(&finding) {
            self.findings.push(finding);
            self.findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
            self.dirty = true;
        }
    }

    /// The report, when it is due.
    pub fn report(&mut self, at: Stamp, points_used: u32) -> Option<Health> {
        let due = self.dirty || self.published.is_none_or(|last| at - last >= EVERY);
        if !due {
            return None;
        }
        self.dirty = false;
        self.published = Some(at);
        let mut findings = self.silences(at);
        findings.extend(self.findings.iter().cloned());
        Some(Health { sensors: self.sensors(at), findings, points_used })
    }

    fn sensors(&mut self, at: Stamp) -> Vec<SensorHealth> {
        let mut sensors = Vec::new();
        for kind in 0..NAMES.len() {
            let Some(last) = self.last[kind] else { continue };
            while self.heard[kind].front().is_some_and(|&old| at - old > WINDOW) {
                self.heard[kind].pop_front();
            }
            let rate_hz = self.heard[kind].len() as f32 / WINDOW.secs_f64() as f32;
            sensors.push(SensorHealth { name: NAMES[kind].to_owned(), rate_hz, age: at - last });
        }
        sensors
    }

    fn silences(&self, at: Stamp) -> Vec<Finding> {
        (0..NAMES.len())
            .filter(|&kind| WATCHED[kind])
            .filter_map(|kind| {
                let age = at - self.last[kind]?;
                (age > SILENT).then(|| Finding {
                    severity: Severity::Error,
                    what: texts::sensor_silent(NAMES[kind], age.secs_f64()),
                    remedy: texts::SILENT_SENSOR_REMEDY.to_owned(),
                })
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::ImuSample;

    #[test]
    fn rates_are_counted_and_silence_is_said() {
        let mut monitor = SensorMonitor::default();
        let at = |ms: i64| Stamp::from_nanos(ms * 1_000_000);
        for ms in (0..4_000).step_by(10) {
            monitor.on_message(at(ms), &Sensor::Imu(ImuSample { stamp: at(ms), ..ImuSample::default() }));
        }
        let health = monitor.report(at(4_000), 0).expect("first report");
        assert!((health.sensors[0].rate_hz - 100.0).abs() < 1.5, "{}", health.sensors[0].rate_hz);
        assert!(health.findings.is_empty());
        assert!(monitor.report(at(4_500), 0).is_none(), "nothing new yet");
        let health = monitor.report(at(6_000), 0).expect("due");
        assert_eq!(health.sensors[0].rate_hz, 0.0);
        assert!(health.findings[0].what.contains("IMU"), "{:?}", health.findings);
    }
}
