//! The robot's computer: load, name of the robot, a control program that does not answer.

use crate::test_support::{TestClient, value};
use api::{Event, Platform};
use egui_kittest::kittest::Queryable;

fn reported(core_connected: bool) -> TestClient {
    TestClient::connected().event(Event::Platform(Platform {
        robot: "Rex".into(),
        site: Some("b1".into()),
        real_time_factor: 0.98,
        cpu_cores: 1.25,
        memory_bytes: 412_000_000,
        disk_free_bytes: 73_400_000_000,
        core_connected,
        clients: 3,
        ..Platform::default()
    }))
}

#[test]
fn the_load_is_shown_with_its_units() {
    let harness = reported(true).shown(1440.0, 1200.0);
    for (name, expected) in [
        ("Processing", "0.98 × real time"),
        ("Processor", "1.25 cores"),
        ("Memory", "412.0 MB"),
        ("Free disk", "73.4 GB"),
        ("Clients", "3"),
        ("Version", "1"),
    ] {
        assert_eq!(value(&harness, name), expected, "{name}");
    }
}

#[test]
fn the_top_bar_names_the_robot_and_its_simulated_site() {
    let harness = reported(true).shown(1440.0, 900.0);
    let name =
        harness.get_by(|node| node.role() == egui::Role::Status && node.label().as_deref() == Some("Robot"));
    assert_eq!(name.value().as_deref(), Some("Rex · b1"));
}

#[test]
fn a_control_program_that_does_not_answer_is_said() {
    let says_so = |core_connected| {
        let harness = reported(core_connected).shown(1440.0, 1200.0);
        harness
            .query_all_by(|node| node.value().is_some_and(|text| text.contains("does not answer")))
            .next()
            .is_some()
    };
    assert!(says_so(false) && !says_so(true));
}
