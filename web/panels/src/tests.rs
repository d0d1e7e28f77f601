//! The panels by the names of their controls, and the words they use.

mod text_input;

use crate::test_support::{ME, TestClient, click, contrast};
use crate::{Layout, Width, theme, words};
use api::Motion;
use client_model::{ClientCommand, ClientEvent, ClientTime, Screen, Theme};
use egui::{Rect, pos2, vec2};
use egui_kittest::kittest::Queryable;
use vocab::{Stamp, Vec3};

#[test]
fn stop_motion_is_there_on_every_screen_and_size_and_stops() {
    for (width, height) in [(1440.0, 900.0), (1024.0, 768.0), (390.0, 844.0)] {
        for screen in [Screen::Live, Screen::Map] {
            let mut harness = TestClient::connected().on(screen).shown(width, height);
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
fn a_stopped_robot_offers_to_allow_motion() {
    let stopped = api::Event::Motion(Motion::Stopped { by: Some(ME) });
    let mut harness = TestClient::connected().event(stopped).shown(1024.0, 768.0);
    click(&mut harness, "Allow motion");
    assert!(harness.state().emitted(&ClientCommand::AllowMotion));
}

#[test]
fn the_w_key_drives_ahead_and_its_release_ends_it() {
    let mut harness = TestClient::connected().shown(1440.0, 900.0);
    harness.key_down(egui::Key::W);
    harness.run_steps(2);
    let ahead = harness.state().commands.iter().any(
        |command| matches!(command, ClientCommand::SetVelocity(Some(twist)) if twist.linear.x > 0.5 && twist.linear.y == 0.0),
    );
    assert!(ahead, "{:?}", harness.state().commands);

    let client = harness.state_mut();
    for command in std::mem::take(&mut client.commands) {
        client.model.handle_event(ClientTime(1.0), ClientEvent::Command(command), &mut Vec::new());
    }
    harness.key_up(egui::Key::W);
    harness.run_steps(2);
    assert!(harness.state().emitted(&ClientCommand::SetVelocity(None)), "{:?}", harness.state().commands);
}

#[test]
fn cards_keep_apart_and_inside_the_window() {
    for (width, height, expected) in
        [(1440.0, 900.0, Width::Wide), (1024.0, 768.0, Width::Medium), (390.0, 844.0, Width::Narrow)]
    {
        let window = Rect::from_min_size(pos2(0.0, 0.0), vec2(width, height));
        let layout = Layout::of(window);
        assert_eq!(layout.width, expected);
        for card in [layout.top, layout.rail, layout.card] {
            assert!(window.contains_rect(card), "{card:?} in {window:?}");
        }
        assert!(!layout.top.intersects(layout.card) && !layout.top.intersects(layout.rail));
        assert!(!layout.rail.intersects(layout.card));
    }
}

#[test]
fn texts_stand_out_in_every_theme() {
    for name in Theme::ALL {
        let tokens = theme::Tokens::of(name);
        let (card, least) = (tokens.card.to_opaque(), if name == Theme::Sunlight { 10.0 } else { 4.5 });
        for colour in [tokens.text, tokens.dim] {
            assert!(contrast(colour, card) >= least, "{name:?}: {colour:?} on {card:?}");
        }
        if name == Theme::Sunlight {
            for colour in [tokens.accent, tokens.good, tokens.warn, tokens.bad] {
                assert!(contrast(colour, card) >= least, "{name:?}: {colour:?} on {card:?}");
            }
        }
    }
}

#[test]
fn numbers_carry_units() {
    assert_eq!(words::distance(12.345), "12.3 m");
    assert_eq!(words::distance(1234.0), "1.23 km");
    assert_eq!(words::accuracy(0.014), "1.4 cm");
    assert_eq!(words::place(&Vec3::new(-0.04, 12.34, -5.0)), "0.0, 12.3, -5.0 m");
    assert_eq!(words::elapsed(3753.0), "1:02:33");
    assert_eq!(words::duration(7500.0), "2 h 05");
    assert_eq!(words::age(2.04), "2.0 s old");
    assert_eq!(words::points(2_345_678), "2.35 million");
    assert_eq!(words::bit_rate(1.84e6), "1.8 Mbit/s");
}

#[test]
fn dates_follow_the_calendar() {
    for (secs, expected) in [
        (0.0, "1 Jan 1970, 00:00"),
        (951_782_400.0, "29 Feb 2000, 00:00"),
        (1_709_251_140.0, "29 Feb 2024, 23:59"),
        (1_795_260_060.0, "21 Nov 2026, 11:21"),
        (-86_400.0, "31 Dec 1969, 00:00"),
    ] {
        assert_eq!(words::date(Stamp::from_secs_f64(secs), 0), expected);
    }
    assert_eq!(words::date(Stamp::EPOCH, -3600), "31 Dec 1969, 23:00");
}

#[test]
fn troubles_are_offered_with_simulated_robots_only() {
    let platform = |site: Option<&str>| {
        api::Event::Platform(api::Platform { site: site.map(str::to_owned), ..api::Platform::default() })
    };
    let harness = TestClient::connected().event(platform(None)).shown(1440.0, 1800.0);
    assert!(harness.query_by_label("Carry the robot away").is_none());
    let mut harness = TestClient::connected().event(platform(Some("b1"))).shown(1440.0, 1800.0);
    click(&mut harness, "Cover the LiDAR for 20 s");
    let dark = api::SimulatedFault::CoverLidar(vocab::Span::from_millis(20_000));
    assert!(harness.state().emitted(&ClientCommand::InjectFault(dark)));
}
