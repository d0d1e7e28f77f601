//! Sensors: rates, ages, silence, and findings with their remedies.

use crate::test_support::{TestClient, value};
use api::{Event, Finding, Health, SensorHealth, Severity};
use client_model::{ClientEvent, ClientTime};
use egui_kittest::kittest::Queryable;
use vocab::Span;

fn reported(findings: Vec<Finding>) -> TestClient {
    let sensor = |name: &str, rate_hz, age_s| SensorHealth {
        name: name.into(),
        rate_hz,
        age: Span::from_secs_f64(age_s),
    };
    let sensors = vec![sensor("LiDAR", 9.9, 0.1), sensor("IMU", 0.0, 14.0)];
    TestClient::connected().event(Event::Health(Health { sensors, findings, points_used: 0 }))
}

#[test]
fn every_sensor_shows_its_rate_and_a_silent_one_its_age() {
    let before = TestClient::connected().shown(1440.0, 900.0);
    assert!(before.query_all_by_value("No sensor has reported yet.").next().is_some());
    let harness = reported(Vec::new()).shown(1440.0, 900.0);
    assert_eq!(value(&harness, "LiDAR"), "9.9 Hz");
    assert_eq!(value(&harness, "IMU"), "silent, 14 s old");
}

#[test]
fn an_old_report_makes_all_sensors_old() {
    let mut client = reported(Vec::new());
    client.model.handle_event(ClientTime(21.0), ClientEvent::Tick, &mut Vec::new());
    let harness = client.shown(1440.0, 900.0);
    assert_eq!(value(&harness, "LiDAR"), "9.9 Hz, 20 s old");
}

#[test]
fn a_finding_is_an_alert_with_its_remedy() {
    let finding = Finding {
        severity: Severity::Warning,
        what: "The LiDAR is covered.".into(),
        remedy: "Wipe its window.".into(),
    };
    let harness = reported(vec![finding]).shown(1440.0, 900.0);
    let alert = harness.get_by(|node| node.role() == egui::Role::Alert);
    assert_eq!(alert.value().as_deref(), Some("Warning: The LiDAR is covered. Wipe its window."));
}
