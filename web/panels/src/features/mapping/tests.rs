//! Starting, finishing and discarding a mapping session, and extending a saved map.

use crate::screens;
use crate::test_support::{OTHER, TestClient, click, map, running, value};
use api::{Control, Event, Mapping, Quality, SurveyReason, SurveyTarget};
use client_model::ClientCommand;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use vocab::Vec3;

/// A client on the Map screen with one saved map, `Cellar`, in this state of mapping.
fn with_cellar(mapping: Mapping) -> TestClient {
    let maps = Event::Maps(vec![map(8, "Cellar")]);
    TestClient::connected().event(maps).event(Event::Mapping(mapping)).on(screens::MAP)
}

#[test]
fn without_any_map_mapping_can_be_started() {
    let mut harness =
        TestClient::connected().event(Event::Maps(Vec::new())).on(screens::MAP).shown(1440.0, 900.0);
    click(&mut harness, "Start mapping");
    assert!(harness.state().emitted(&ClientCommand::StartMapping));
}

#[test]
fn mapping_shows_its_figures_and_saves_under_the_name_typed() {
    let client = TestClient::connected().event(Event::Maps(Vec::new())).event(Event::Mapping(running()));
    let mut harness = client.on(screens::MAP).shown(1440.0, 900.0);
    assert_eq!(value(&harness, "Keyframes"), "41");
    assert_eq!(value(&harness, "Ground"), "New");
    assert_eq!(value(&harness, "Distance"), "12.3 m");
    harness.state_mut().panels.features.mapping.map_name = " Pump hall ".into();
    click(&mut harness, "Finish and save");
    assert!(harness.state().emitted(&ClientCommand::FinishMapping { name: "Pump hall".into() }));
}

#[test]
fn discarding_must_be_confirmed() {
    let mut harness =
        TestClient::connected().event(Event::Mapping(running())).on(screens::MAP).shown(1440.0, 900.0);
    click(&mut harness, "Discard");
    assert!(!harness.state().emitted(&ClientCommand::DiscardMapping));
    click(&mut harness, "Discard map");
    assert!(harness.state().emitted(&ClientCommand::DiscardMapping));
}

#[test]
fn buttons_stay_in_their_place_while_walks_are_suggested() {
    let mut harness =
        TestClient::connected().event(Event::Mapping(running())).on(screens::MAP).shown(1440.0, 900.0);
    let place = |harness: &Harness<'_, TestClient>, name| harness.get_by_label(name).rect();
    let before = (place(&harness, "Finish and save"), place(&harness, "Discard"));
    let target = SurveyTarget { at: Vec3::default(), why: SurveyReason::FromAfar { area_m2: 34.0 } };
    let quality =
        Quality { covered_m2: 412.3, deviations_m: vec![0.1], targets: vec![target], ..Default::default() };
    harness.state_mut().receive_event(Event::Quality(quality));
    harness.run();
    assert_eq!(value(&harness, "Suggested walk 1"), "34 m² seen from afar only");
    assert_eq!((place(&harness, "Finish and save"), place(&harness, "Discard")), before);
}

#[test]
fn a_client_without_control_cannot_map_but_can_take_control() {
    let control = Control { owner: Some(OTHER), name: "Anna".into(), request: None };
    let mut harness =
        TestClient::connected().event(Event::Control(control)).on(screens::MAP).shown(1440.0, 900.0);
    click(&mut harness, "Start mapping");
    click(&mut harness, "Take control");
    let client = harness.state();
    assert!(
        client.emitted(&ClientCommand::TakeControl) && !client.emitted(&ClientCommand::StartMapping),
        "{:?}",
        client.commands
    );
}

#[test]
fn an_extension_first_localises_in_the_map_and_can_be_cancelled() {
    let Mapping::Running { session, .. } = running() else { panic!("`running` is a running session") };
    let finding = |distance_m, ambiguous| {
        let map = map(8, "Cellar").id;
        with_cellar(Mapping::Finding { session, map, distance_m, ambiguous }).shown(1440.0, 900.0)
    };
    let mut harness = finding(6.0, false);
    harness.get_by_label_contains("through a part that Cellar shows");
    assert_eq!(value(&harness, "Driven so far"), "6.0 m");
    click(&mut harness, "Cancel mapping");
    assert!(harness.state().emitted(&ClientCommand::DiscardMapping));
    finding(31.0, true).get_by_label_contains("fit Cellar in two places");
}

#[test]
fn an_extension_keeps_the_name_of_the_map_if_none_is_typed() {
    let mut mapping = running();
    if let Mapping::Running { extends, .. } = &mut mapping {
        *extends = Some(map(8, "Cellar").id);
    }
    let mut harness = with_cellar(mapping).shown(1440.0, 900.0);
    assert_eq!(value(&harness, "Extends"), "Cellar");
    click(&mut harness, "Finish and save");
    assert!(harness.state().emitted(&ClientCommand::FinishMapping { name: "Cellar".into() }));
}
