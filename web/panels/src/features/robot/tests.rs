//! What the robot reports of itself: motion, map, estimate, battery.

use crate::test_support::{TestClient, map, value};
use api::{Battery, Estimate, Event, Localisation, Motion};
use egui_kittest::kittest::Queryable;
use vocab::{Pose, Span, Twist, Vec3};

#[test]
fn every_state_of_motion_has_words() {
    let goal = Vec3::default();
    for (motion, words) in [
        (Motion::Idle, "Standing"),
        (Motion::Stopped { by: None }, "Motion stopped"),
        (Motion::Teleoperated, "Driven by hand"),
        (Motion::Walking { goal, path: Vec::new(), remaining_m: 3.0 }, "Walking"),
        (Motion::Waiting { goal }, "Waiting to see"),
        (Motion::Relocalising { goal: None }, "Relocalising"),
        (Motion::Blocked { goal, reason: "A door is closed.".into() }, "Path blocked"),
    ] {
        let is_blocked = matches!(motion, Motion::Blocked { .. });
        let harness = TestClient::connected().event(Event::Motion(motion)).shown(1440.0, 900.0);
        assert_eq!(value(&harness, "Motion"), words);
        assert_eq!(harness.query_all_by_value("A door is closed.").next().is_some(), is_blocked, "{words}");
    }
}

#[test]
fn the_estimate_is_shown_with_its_units() {
    let before = TestClient::connected().shown(1440.0, 900.0);
    assert!(before.query_all_by_value("The robot has not reported its position yet.").next().is_some());
    let estimate = Estimate {
        map_from_base: Pose { position: Vec3::new(1.25, -3.0, 0.5), ..Pose::IDENTITY },
        velocity: Twist { linear: Vec3::new(0.3, 0.4, 0.0), ..Twist::default() },
        distance_m: 1240.0,
        ..Estimate::default()
    };
    let harness = TestClient::connected().event(Event::Estimate(estimate)).shown(1440.0, 900.0);
    assert_eq!(value(&harness, "Speed"), "0.5 m/s");
    assert_eq!(value(&harness, "Position in the map"), "1.3, -3.0, 0.5 m");
    assert_eq!(value(&harness, "Walked"), "1.24 km");
}

#[test]
fn the_map_in_use_is_named() {
    let localised = |map| Event::Localisation(Localisation::Localised { map, degradation: None });
    let client = || TestClient::connected().event(Event::Maps(vec![map(8, "Cellar")]));
    let known = client().event(localised(map(8, "Cellar").id)).shown(1440.0, 900.0);
    assert!(known.query_all_by_value("Cellar").next().is_some());
    let deleted = client().event(localised(map(9, "Hall").id)).shown(1440.0, 900.0);
    assert!(deleted.query_all_by_value("One that was deleted").next().is_some());
}

#[test]
fn the_battery_shows_its_charge_and_the_time_left() {
    let left = Some(Span::from_secs_f64(45.0 * 60.0));
    for (charging, expected) in [(false, "63 % 45 min left"), (true, "63 % full in 45 min")] {
        let battery = Battery { charge: 0.63, left, charging, ..Battery::default() };
        let harness = TestClient::connected().event(Event::Battery(battery)).shown(1440.0, 900.0);
        assert_eq!(value(&harness, "Battery"), expected);
    }
}
