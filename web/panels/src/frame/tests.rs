//! What the frame shows on every screen and window.

use crate::screens::{self, SCREENS};
use crate::test_support::{OTHER, TestClient, click};
use api::{Control, Event, Motion, Platform};
use client_model::ClientCommand;
use egui::{Rect, Role};
use egui_kittest::Harness;
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

/// A client whose top bar has the most to say: a site, a long name of another operator, a stopped robot, an uncertain position.
fn with_full_top_bar(is_stopped: bool) -> TestClient {
    let motion = if is_stopped { Motion::Stopped { by: Some(OTHER) } } else { Motion::Idle };
    let mut covariance = api::Estimate::default().covariance;
    covariance.0[0][0] = 4.0;
    TestClient::connected()
        .event(Event::Platform(Platform {
            robot: "Rex".into(),
            site: Some("torus".into()),
            ..Platform::default()
        }))
        .event(Event::Battery(api::Battery {
            charge: 0.83,
            left: Some(vocab::Span::from_millis(4_000_000)),
            ..api::Battery::default()
        }))
        .event(Event::Estimate(api::Estimate { covariance, ..api::Estimate::default() }))
        .event(Event::Control(Control { owner: Some(OTHER), name: "Ada Lovelace".into(), request: None }))
        .event(Event::Motion(motion))
}

/// Rectangles of what the top bar shows with this role, in its order.
fn in_top_bar(harness: &Harness<'_, TestClient>, role: Role) -> Vec<Rect> {
    let nodes = harness.query_all_by(move |node| node.role() == role && node.bounding_box().is_some());
    nodes.map(|node| node.rect()).filter(|rect| rect.bottom() < 72.0).collect()
}

#[test]
fn no_status_of_the_top_bar_is_cut_in_any_window() {
    let widths = [700.0, 820.0, 900.0, 1024.0, 1099.0, 1100.0, 1280.0, 1440.0];
    for (width, is_stopped) in widths.into_iter().flat_map(|width| [(width, false), (width, true)]) {
        let harness = with_full_top_bar(is_stopped).shown(width, 900.0);
        let left_button = in_top_bar(&harness, Role::Button).iter().map(Rect::left).fold(width, f32::min);
        let statuses = in_top_bar(&harness, Role::Status);
        assert!(statuses.len() >= 3, "position, battery and link at least: {statuses:?}");
        for (left, right) in statuses.iter().zip(&statuses[1..]) {
            assert!(left.right() < right.left(), "{left:?} and {right:?} at {width}");
        }
        let right = statuses.iter().map(Rect::right).fold(0.0, f32::max);
        assert!(right < left_button, "status to {right}, button from {left_button}, window {width}");
    }
}

#[test]
fn wider_top_bars_show_more() {
    let count = |width| {
        let harness = with_full_top_bar(false).shown(width, 900.0);
        in_top_bar(&harness, Role::Status).len()
    };
    assert!(count(700.0) < count(1440.0));
    assert_eq!(count(1440.0), 7, "product, demonstration, robot, position, battery, link, control");
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
