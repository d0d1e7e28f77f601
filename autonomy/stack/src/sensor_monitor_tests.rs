//! Rates, silences, the order of findings, and when a report is published.

use super::*;
use messages::{BatteryState, ImuSample};

fn at(ms: i64) -> Stamp {
    Stamp::from_nanos(ms * 1_000_000)
}

fn imu(ms: i64) -> Sensor {
    Sensor::Imu(ImuSample { stamp: at(ms), ..ImuSample::default() })
}

fn finding(severity: Severity, what: &str) -> Finding {
    Finding { severity, what: what.to_owned(), remedy: String::new() }
}

#[test]
fn rates_are_counted_over_the_window_and_a_silence_is_reported() {
    let mut monitor = SensorMonitor::default();
    for ms in (0..4_000).step_by(10) {
        monitor.on_message(at(ms), &imu(ms));
    }
    let health = monitor.report(at(4_000), 0).expect("first report");
    assert!((health.sensors[0].rate_hz - 100.0).abs() < 1.5, "{}", health.sensors[0].rate_hz);
    assert!(health.findings.is_empty());
    assert!(monitor.report(at(4_500), 0).is_none(), "the period has not passed");
    let health = monitor.report(at(6_000), 0).expect("due");
    assert_eq!(health.sensors[0].rate_hz, 0.0);
    assert!(health.findings[0].what.contains("IMU"), "{:?}", health.findings);
}

#[test]
fn a_new_sensor_and_a_new_finding_are_reported_at_once_and_the_same_one_is_not() {
    let mut monitor = SensorMonitor::default();
    monitor.report(at(0), 0).expect("first report");
    monitor.on_message(at(10), &imu(10));
    let health = monitor.report(at(10), 7).expect("a sensor is new");
    assert_eq!((health.sensors.len(), health.points_used), (1, 7));
    monitor.on_message(at(20), &imu(20));
    assert!(monitor.report(at(20), 0).is_none());
    monitor.add_finding(finding(Severity::Warning, "tilted"));
    monitor.report(at(30), 0).expect("a finding is new");
    monitor.add_finding(finding(Severity::Warning, "tilted"));
    assert!(monitor.report(at(40), 0).is_none());
}

#[test]
fn findings_are_in_the_order_of_their_severity_after_the_silences() {
    let mut monitor = SensorMonitor::default();
    monitor.on_message(at(0), &imu(0));
    for (severity, what) in [(Severity::Info, "a"), (Severity::Error, "b"), (Severity::Warning, "c")] {
        monitor.add_finding(finding(severity, what));
    }
    let health = monitor.report(at(2_000), 0).expect("due");
    let whats: Vec<&str> = health.findings.iter().map(|finding| finding.what.as_str()).collect();
    assert_eq!(whats, [&texts::sensor_silent("IMU", 2.0), "b", "c", "a"]);
}

#[test]
fn a_battery_is_never_silent() {
    let mut monitor = SensorMonitor::default();
    monitor.on_message(at(0), &Sensor::Battery(BatteryState::default()));
    let health = monitor.report(at(60_000), 0).expect("due");
    assert_eq!(health.sensors[0].name, "Battery");
    assert_eq!(health.findings, []);
}
