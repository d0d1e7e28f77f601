//! What the frame shows on every screen and window.

use crate::screens::{self, SCREENS};
use crate::test_support::{TestClient, click};
use client_model::ClientCommand;
use egui_kittest::kittest::Queryable;

#[test]
fn stop_motion_is_there_on_every_screen_and_size_and_stops() {
    for (width, height) in [(1440.0, 900.0), (1024.0, 768.0), (390.0, 844.0)] {
        for (screen, _) in SCREENS {
            let mut harness = TestClient::connected().on(*screen).shown(width, height);
            let rect = harness.get_by_label("Stop motion").rect();
            assert!(rect.right() > width - 24.0 && rect.height() >= 40.0, "far right and large: {rect:?}");
            click(&mut harness, "Stop motion");
            assert!(harness.state().emitted(&ClientCommand::StopMotion));
        }
    }
}

#[test]
fn escape_stops() {
    let mut harness = TestClient::connected().shown(1440.0, 900.0);
    harness.key_press(egui::Key::Escape);
    harness.run_steps(2);
    assert!(harness.state().emitted(&ClientCommand::StopMotion));
}

#[test]
fn the_question_mark_opens_the_list_of_shortcuts_and_its_button_closes_it() {
    let mut harness = TestClient::connected().shown(1440.0, 900.0);
    assert!(harness.query_by_label("Undo: the view, loops, the site").is_none());
    harness.key_press(egui::Key::Questionmark);
    harness.run_steps(2);
    assert!(harness.query_by_label("Undo: the view, loops, the site").is_some());
    click(&mut harness, "Close");
    assert!(harness.query_by_label("Undo: the view, loops, the site").is_none());
}

#[test]
fn the_rail_opens_a_screen_and_the_choice_of_tabs_its_tabs() {
    let mut harness = TestClient::connected().shown(1440.0, 900.0);
    assert!(harness.query_by_label("Loops").is_none(), "Live has one tab");
    click(&mut harness, "Map");
    assert!(harness.state().emitted(&ClientCommand::ShowScreen(screens::MAP)));

    let mut harness = TestClient::connected().on(screens::MAP).shown(1440.0, 900.0);
    assert!(harness.query_by_label("Accepted loops").is_none());
    click(&mut harness, "Loops");
    assert!(harness.query_by_label("Accepted loops").is_some());
    click(&mut harness, "Session");
    assert!(harness.query_by_label("Accepted loops").is_none());
}

#[test]
fn every_listed_screen_has_a_button_on_the_rail_and_a_side_card_of_its_name() {
    for (screen, description) in SCREENS {
        let mut harness = TestClient::connected().shown(1440.0, 900.0);
        click(&mut harness, description.name);
        assert!(harness.state().emitted(&ClientCommand::ShowScreen(*screen)), "{}", description.name);
        let harness = TestClient::connected().on(*screen).shown(1440.0, 900.0);
        assert_eq!(screens::description_of(*screen).side_card, description.side_card);
        assert!(harness.query_by_label(description.side_card).is_some(), "{}", description.side_card);
    }
    let harness = TestClient::connected().shown(1440.0, 900.0);
    let first = screens::description_of(screens::FIRST);
    assert!(harness.query_by_label(first.side_card).is_some(), "shown before the operator chooses");
}
