//! Settings by their panel.

use crate::test_support::{TestClient, click, map, value};
use crate::{PageClock, screens};
use api::{Event, SiteParts, SiteState};
use client_model::{ClientCommand, ClientEvent, ClientTime};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use site_model::Utc;
use std::sync::Arc;

fn client() -> TestClient {
    let part = SiteParts::new(Arc::new(SiteState::default())).next_part();
    let mut client = TestClient::connected()
        .event(Event::SitePart(part))
        .event(Event::Maps(vec![map(1, "Hall")]))
        .on(screens::SETTINGS);
    // 2026-07-01 12:00 UTC.
    let clock =
        PageClock { utc: Utc(1_782_907_200_000_000_000), utc_offset_s: 0, zone: "Europe/Berlin".into() };
    client.panels.clock = clock;
    client
}

fn press(harness: &mut Harness<'_, TestClient>, name: &str) {
    click(harness, name);
    let client = harness.state_mut();
    for command in std::mem::take(&mut client.commands) {
        client.model.handle_event(ClientTime(1.0), ClientEvent::Command(command), &mut Vec::new());
    }
    harness.run_steps(2);
}

#[test]
fn the_site_gets_a_name_and_a_time_zone_and_both_are_undone() {
    let mut harness = client().shown(1440.0, 1_200.0);
    assert_eq!(value(&harness, "Time zone"), "UTC");
    press(&mut harness, "Use yours: Europe/Berlin");
    assert_eq!(
        (value(&harness, "Time zone"), value(&harness, "Time there")),
        ("Europe/Berlin".into(), "14:00".into())
    );
    press(&mut harness, "Choose a time zone");
    harness.get_by_label("Find a time zone").focus();
    harness.run_steps(2);
    harness.get_by_label("Find a time zone").type_text("new york");
    harness.run_steps(2);
    press(&mut harness, "Time zone America/New_York");
    assert_eq!(value(&harness, "Time there"), "08:00");
    assert!(harness.query_by_label("Find a time zone").is_none(), "the choice is made");
    harness.get_by_label("Site name").focus();
    harness.run_steps(2);
    harness.get_by_label("Site name").type_text(" north");
    harness.run_steps(2);
    press(&mut harness, "Rename site");
    let name = |harness: &Harness<'_, TestClient>| {
        harness.state().model.site.site().unwrap().settings().map(|settings| settings.name.clone())
    };
    assert_eq!(name(&harness), Some("Site north".into()));
    for _ in 0..3 {
        harness.state_mut().commands.push(ClientCommand::Undo);
        let client = harness.state_mut();
        for command in std::mem::take(&mut client.commands) {
            client.model.handle_event(ClientTime(1.0), ClientEvent::Command(command), &mut Vec::new());
        }
    }
    harness.run_steps(2);
    assert_eq!(name(&harness), None);
    assert_eq!(value(&harness, "Time zone"), "UTC");
}

#[test]
fn data_and_robot_are_shown_as_they_were_told() {
    let harness = client().shown(1440.0, 1_200.0);
    assert_eq!(value(&harness, "Saved maps"), "1 · 7.0 MB");
    assert_eq!(value(&harness, "Plan"), "0 missions, 0 schedules");
    assert!(harness.query_by_label("The robot has not told anything of itself yet.").is_some());
}

#[test]
fn profile_and_disk_are_shown_each_number_with_its_unit() {
    let speeds = |forward_m_s| api::SpeedLimits { forward_m_s, sideways_m_s: 0.5, turn_rad_s: 1.0 };
    let report = api::Platform {
        robot: "Rex".into(),
        disk_free_bytes: 90_000_000_000,
        manual_limits: Some(speeds(1.2)),
        autonomous_limits: Some(speeds(0.9)),
        body: Some(api::RobotBody {
            footprint_radius_m: 0.38,
            clearance_height_m: 0.95,
            standing_height_m: 0.55,
            step_height_m: 0.22,
            camera_head: vocab::CameraHead::COMMON,
        }),
        disk: Some(api::DiskUse {
            total_bytes: 250_000_000_000,
            recordings_bytes: 3_000_000_000,
            max_recordings_bytes: 46_500_000_000,
        }),
        ..api::Platform::default()
    };
    let harness = client().event(Event::Platform(report)).shown(1440.0, 1_600.0);
    for (name, expected) in [
        ("By hand, ahead", "1.2 m/s"),
        ("By itself, ahead", "0.9 m/s"),
        ("By itself, turning", "57 °/s"),
        ("Turns within, radius", "0.38 m"),
        ("Highest step", "0.22 m"),
        ("Camera, pan", "-170° to 170°"),
        ("Camera, tilt", "-40° to 80°"),
        ("Camera, greatest zoom", "20×"),
        ("Disk in use", "160.0 GB of 250.0 GB"),
        ("Recordings", "3.0 GB of 46.5 GB"),
    ] {
        assert_eq!(value(&harness, name), expected, "{name}");
    }
    assert_eq!(value(&harness, "Free disk"), "90.0 GB");
}
