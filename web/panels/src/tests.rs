//! The panels by the names of their controls, and the words they use.

mod goals;
mod loops;
mod text_input;

use crate::{Layout, PanelState, Width, theme, words};
use api::{
    CommandOutcome, Control, MapSummary, Mapping, Motion, Quality, ServerMessage, SurveyReason, SurveyTarget,
};
use client_model::{
    ClientCommand, ClientEffect, ClientEvent, ClientTime, Ids, Model, Screen, Socket, Theme, ViewSettings,
};
use egui::{Color32, Rect, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use uuid::Uuid;
use vocab::{ClientId, MapId, SessionId, Stamp, Vec3};

const ME: ClientId = ClientId(Uuid::from_u128(1));
const OTHER: ClientId = ClientId(Uuid::from_u128(2));

/// A model, the panels' state, and what they asked for.
struct Desk {
    model: Model,
    state: PanelState,
    asked: Vec<ClientCommand>,
    sequence: u64,
    dressed: bool,
}

impl Desk {
    fn connected() -> Self {
        let now = ClientTime(1.0);
        let mut model = Model::new(ME, Ids::new(1), ViewSettings::default(), now);
        let mut effects: Vec<ClientEffect> = Vec::new();
        model.handle_event(now, ClientEvent::SocketOpened(Socket::Control), &mut effects);
        let mut desk =
            Self { model, state: PanelState::default(), asked: Vec::new(), sequence: 0, dressed: false };
        desk.server(ServerMessage::Welcome { version: api::VERSION, program: "1".into() });
        desk
    }

    fn server(&mut self, message: ServerMessage) {
        self.model.handle_event(ClientTime(1.0), ClientEvent::Server { message, bytes: 10 }, &mut Vec::new());
    }

    fn event(mut self, event: api::Event) -> Self {
        self.sequence += 1;
        self.server(ServerMessage::Event { sequence: self.sequence, event });
        self
    }

    fn on(mut self, screen: Screen) -> Self {
        self.model.handle_event(
            ClientTime(1.0),
            ClientEvent::Command(ClientCommand::ShowScreen(screen)),
            &mut Vec::new(),
        );
        self
    }

    fn shown<'a>(self, width: f32, height: f32) -> Harness<'a, Self> {
        let mut harness = Harness::builder().with_size(vec2(width, height)).build_ui_state(
            |ui, desk: &mut Self| {
                let ctx = ui.ctx().clone();
                if desk.dressed {
                    crate::show(&ctx, &desk.model, &mut desk.state, &mut desk.asked);
                } else {
                    // Fonts are there from the next frame on.
                    theme::install_fonts(&ctx);
                    theme::install(&ctx, Theme::Dark);
                    desk.dressed = true;
                }
            },
            self,
        );
        harness.run_steps(3);
        harness
    }
}

fn running() -> Mapping {
    let session = SessionId(Uuid::from_u128(5));
    Mapping::Running {
        session,
        extends: None,
        since: Stamp::EPOCH,
        distance: 12.3,
        keyframes: 41,
        on_known_ground: false,
    }
}

fn map(number: u128, name: &str) -> MapSummary {
    MapSummary {
        id: MapId(Uuid::from_u128(number)),
        name: name.into(),
        created: Stamp::from_secs_f64(1_795_257_600.0),
        distance: 120.0,
        keyframes: 60,
        points: 2_345_678,
        bytes: 7_000_000,
        has_pose_graph: true,
    }
}

#[test]
fn stop_motion_is_there_on_every_screen_and_size_and_stops() {
    for (width, height) in [(1440.0, 900.0), (1024.0, 768.0), (390.0, 844.0)] {
        for screen in [Screen::Live, Screen::Map] {
            let mut harness = Desk::connected().on(screen).shown(width, height);
            let rect = harness.get_by_label("Stop motion").rect();
            assert!(rect.right() > width - 24.0 && rect.height() >= 40.0, "far right and large: {rect:?}");
            harness.get_by_label("Stop motion").click();
            harness.run_steps(2);
            assert!(harness.state().asked.contains(&ClientCommand::StopMotion));
        }
    }
}

#[test]
fn escape_stops() {
    let mut harness = Desk::connected().shown(1440.0, 900.0);
    harness.key_press(egui::Key::Escape);
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::StopMotion));
}

#[test]
fn the_empty_map_screen_says_what_to_do_first() {
    let mut harness =
        Desk::connected().event(api::Event::Maps(Vec::new())).on(Screen::Map).shown(1440.0, 900.0);
    harness.get_by_label("Start mapping").click();
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::StartMapping));
}

#[test]
fn mapping_shows_its_figures_and_saves_under_the_name_typed() {
    let desk = Desk::connected().event(api::Event::Maps(Vec::new())).event(api::Event::Mapping(running()));
    let mut harness = desk.on(Screen::Map).shown(1440.0, 900.0);
    assert_eq!(harness.get_by_label("Keyframes").value().as_deref(), Some("41"));
    assert_eq!(harness.get_by_label("Ground").value().as_deref(), Some("New"));
    assert_eq!(harness.get_by_label("Distance").value().as_deref(), Some("12.3 m"));
    harness.state_mut().state.map_name = " Pump hall ".into();
    harness.get_by_label("Finish and save").click();
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::FinishMapping { name: "Pump hall".into() }));
}

#[test]
fn discarding_is_asked_for_twice() {
    let mut harness =
        Desk::connected().event(api::Event::Mapping(running())).on(Screen::Map).shown(1440.0, 900.0);
    harness.get_by_label("Discard").click();
    harness.run_steps(2);
    assert!(!harness.state().asked.contains(&ClientCommand::DiscardMapping));
    harness.get_by_label("Discard map").click();
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::DiscardMapping));
}

#[test]
fn saved_maps_can_be_viewed_by_name() {
    let desk = Desk::connected().event(api::Event::Maps(vec![map(9, "Hall"), map(8, "Cellar")]));
    let mut harness = desk.on(Screen::Map).shown(1440.0, 900.0);
    harness.get_by_label("View Cellar").click();
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::ViewMap(Some(MapId(Uuid::from_u128(8))))));
}

#[test]
fn the_map_that_is_looked_at_can_be_used_and_left() {
    let maps = || api::Event::Maps(vec![map(9, "Hall"), map(8, "Cellar")]);
    let cellar = MapId(Uuid::from_u128(8));
    let look = |mut desk: Desk| {
        desk.model.handle_event(
            ClientTime(1.0),
            ClientEvent::Command(ClientCommand::ViewMap(Some(cellar))),
            &mut Vec::new(),
        );
        desk.on(Screen::Map).shown(1440.0, 900.0)
    };
    let mut harness = look(Desk::connected().event(maps()));
    assert!(harness.query_by_label("Use Hall").is_none(), "it is not looked at");
    harness.get_by_label("Use Cellar").click();
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::UseMap(cellar)));

    let known = api::Localisation::Localised { map: cellar, doubt: None };
    let mut harness = look(Desk::connected().event(maps()).event(api::Event::Localisation(known)));
    assert!(harness.query_by_label("Use Cellar").is_none(), "it is in use");
    harness.get_by_label("Leave Cellar").click();
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::LeaveMap));
}

#[test]
fn the_map_that_is_looked_at_can_be_extended() {
    let maps = api::Event::Maps(vec![map(9, "Hall"), map(8, "Cellar")]);
    let mut desk = Desk::connected().event(maps);
    let cellar = MapId(Uuid::from_u128(8));
    desk.model.handle_event(
        ClientTime(1.0),
        ClientEvent::Command(ClientCommand::ViewMap(Some(cellar))),
        &mut Vec::new(),
    );
    let mut harness = desk.on(Screen::Map).shown(1440.0, 900.0);
    assert!(harness.query_by_label("Extend Hall").is_none(), "it is not looked at");
    harness.get_by_label("Extend Cellar").click();
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::ExtendMap(cellar)));

    let session = SessionId(Uuid::from_u128(5));
    let finding = |distance, ambiguous| {
        let finding = Mapping::Finding { session, map: cellar, distance, ambiguous };
        let maps = api::Event::Maps(vec![map(8, "Cellar")]);
        let desk = Desk::connected().event(maps).event(api::Event::Mapping(finding));
        desk.on(Screen::Map).shown(1440.0, 900.0)
    };
    let mut harness = finding(6.0, false);
    harness.get_by_label_contains("through a part that Cellar shows");
    assert_eq!(harness.get_by_label("Driven so far").value().as_deref(), Some("6.0 m"));
    harness.get_by_label("Cancel mapping").click();
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::DiscardMapping));
    finding(31.0, true).get_by_label_contains("fit Cellar in two places");

    let Mapping::Running { session, since, distance, keyframes, .. } = running() else {
        panic!("`running` is a running session")
    };
    let on_known_ground = false;
    let extends = Some(cellar);
    let extending = Mapping::Running { session, extends, since, distance, keyframes, on_known_ground };
    let desk = Desk::connected().event(api::Event::Maps(vec![map(8, "Cellar")]));
    let mut harness = desk.event(api::Event::Mapping(extending)).on(Screen::Map).shown(1440.0, 900.0);
    assert_eq!(harness.get_by_label("Extends").value().as_deref(), Some("Cellar"));
    harness.get_by_label("Finish and save").click();
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::FinishMapping { name: "Cellar".into() }));
}

#[test]
fn what_the_map_lacks_is_listed_and_can_be_walked_to() {
    let at = Vec3::new(4.0, 2.0, 0.0);
    let places = vec![
        SurveyTarget { at, why: SurveyReason::FromAfar(34.0) },
        SurveyTarget { at: Vec3::default(), why: SurveyReason::Unsure(0.42) },
    ];
    let quality = Quality { covered: 412.3, from_afar: 40.0, deviations: vec![0.0, 0.42, 0.1], places };
    let desk = Desk::connected().event(api::Event::Mapping(running())).event(api::Event::Quality(quality));
    let mut harness = desk.on(Screen::Map).shown(1440.0, 1200.0);
    assert_eq!(harness.get_by_label("Floor covered").value().as_deref(), Some("412 m²"));
    assert_eq!(harness.get_by_label("Known to").value().as_deref(), Some("0.42 m"));
    let first = harness.get_by_label("Place 1 worth a walk").value();
    assert_eq!(first.as_deref(), Some("34 m² seen from afar only"));
    assert!(
        harness.get_by_label("Place 2 worth a walk").value().is_some_and(|why| why.contains("0.42 m only"))
    );
    harness.get_by_label("Walk to place 1").click();
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::WalkTo(at)));
}

#[test]
fn who_does_not_control_cannot_map_but_can_take_control() {
    let control = Control { owner: Some(OTHER), name: "Anna".into() };
    let mut harness =
        Desk::connected().event(api::Event::Control(control)).on(Screen::Map).shown(1440.0, 900.0);
    harness.get_by_label("Start mapping").click();
    harness.get_by_label("Take control").click();
    harness.run_steps(2);
    let asked = &harness.state().asked;
    assert!(
        asked.contains(&ClientCommand::TakeControl) && !asked.contains(&ClientCommand::StartMapping),
        "{asked:?}"
    );
}

#[test]
fn a_stopped_robot_offers_to_allow_motion() {
    let stopped = api::Event::Motion(Motion::Stopped { by: Some(ME) });
    let mut harness = Desk::connected().event(stopped).shown(1024.0, 768.0);
    harness.get_by_label("Allow motion").click();
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::AllowMotion));
}

#[test]
fn the_w_key_drives_ahead_and_its_release_ends_it() {
    let mut harness = Desk::connected().shown(1440.0, 900.0);
    harness.key_down(egui::Key::W);
    harness.run_steps(2);
    let ahead = harness.state().asked.iter().any(
        |command| matches!(command, ClientCommand::SetVelocity(Some(twist)) if twist.linear.x > 0.5 && twist.linear.y == 0.0),
    );
    assert!(ahead, "{:?}", harness.state().asked);

    let desk = harness.state_mut();
    for command in std::mem::take(&mut desk.asked) {
        desk.model.handle_event(ClientTime(1.0), ClientEvent::Command(command), &mut Vec::new());
    }
    harness.key_up(egui::Key::W);
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::SetVelocity(None)), "{:?}", harness.state().asked);
}

#[test]
fn a_refusal_is_an_alert_that_can_be_put_away() {
    let mut desk = Desk::connected();
    let mut effects = Vec::new();
    desk.model.handle_event(
        ClientTime(1.0),
        ClientEvent::Command(ClientCommand::ReleaseControl),
        &mut effects,
    );
    let id = effects.into_iter().find_map(|effect| match effect {
        ClientEffect::Send(api::ClientMessage::Command { id, .. }) => Some(id),
        _ => None,
    });
    let outcome = CommandOutcome::Refused("Not now. Wait a moment.".into());
    let desk = desk.event(api::Event::CommandDone { id: id.unwrap(), outcome });
    let mut harness = desk.shown(1440.0, 900.0);
    harness.get_by_label("Dismiss").click();
    harness.run_steps(2);
    assert!(harness.state().asked.iter().any(|command| matches!(command, ClientCommand::DismissNotice(_))));
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

/// Contrast of two colours as WCAG 2 defines it.
fn contrast(a: Color32, b: Color32) -> f32 {
    let luminance = |colour: Color32| {
        let linear = |channel: u8| {
            let c = f32::from(channel) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(colour.r()) + 0.7152 * linear(colour.g()) + 0.0722 * linear(colour.b())
    };
    let (a, b) = (luminance(a) + 0.05, luminance(b) + 0.05);
    (a / b).max(b / a)
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
    let harness = Desk::connected().event(platform(None)).shown(1440.0, 1800.0);
    assert!(harness.query_by_label("Carry the robot away").is_none());
    let mut harness = Desk::connected().event(platform(Some("b1"))).shown(1440.0, 1800.0);
    harness.get_by_label("Cover the LiDAR for 20 s").click();
    harness.run_steps(2);
    let dark = api::SimulatedFault::CoverLidar(vocab::Span::from_millis(20_000));
    assert!(harness.state().asked.contains(&ClientCommand::InjectFault(dark)));
}

#[test]
fn a_robot_that_does_not_find_itself_can_be_sent_to_look_about_or_be_shown_where_it_is() {
    let map = map(1, "Hall");
    let id = map.id;
    let lost = api::Event::Localisation(api::Localisation::Relocalising { map: id, places: 2 });
    let mut desk = Desk::connected().on(Screen::Map).event(api::Event::Maps(vec![map])).event(lost);
    desk.model.handle_event(
        ClientTime(1.0),
        ClientEvent::Command(ClientCommand::ViewMap(Some(id))),
        &mut Vec::new(),
    );
    let mut harness = desk.shown(1440.0, 900.0);
    harness.get_by_label("Relocalise").click();
    harness.run_steps(2);
    harness.get_by_label("Set the pose").click();
    harness.run_steps(2);
    let asked = &harness.state().asked;
    assert!(
        asked.contains(&ClientCommand::Relocalise) && asked.contains(&ClientCommand::PickPose(true)),
        "{asked:?}"
    );
}

#[test]
fn a_cloud_of_the_same_site_can_be_laid_into_the_map_that_is_looked_at() {
    let map = map(1, "Hall");
    let id = map.id;
    let desk = || Desk::connected().on(Screen::Map).event(api::Event::Maps(vec![map.clone()]));
    assert!(desk().shown(1440.0, 900.0).query_by_label("Import and align").is_none());
    let mut desk = desk();
    desk.model.handle_event(
        ClientTime(1.0),
        ClientEvent::Command(ClientCommand::ViewMap(Some(id))),
        &mut Vec::new(),
    );
    let mut harness = desk.shown(1440.0, 900.0);
    harness.get_by_label("Import and align").click();
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::ImportMap { frame: Some(id) }));
}

#[test]
fn a_map_can_be_imported_and_one_sees_how_far_it_is() {
    let mut harness =
        Desk::connected().on(Screen::Map).event(api::Event::Maps(Vec::new())).shown(1440.0, 900.0);
    harness.get_by_label("Import a map").click();
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::ImportMap { frame: None }));

    let running = api::Import::Running {
        upload: vocab::UploadId(Uuid::from_u128(1)),
        name: "North wing".into(),
        stage: api::ImportStage::Looking,
        share: 0.42,
    };
    let desk = Desk::connected().on(Screen::Map).event(api::Event::Import(running));
    let mut harness = desk.shown(1440.0, 900.0);
    assert!(harness.query_by_label("Import a map").is_none());
    harness.get_by_label("Cancel import").click();
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::CancelImport));
}

#[test]
fn the_map_that_is_looked_at_can_be_laid_onto_another_by_points() {
    let [hall, cellar] = [9, 8].map(|number| MapId(Uuid::from_u128(number)));
    let align = |desk: &mut Desk, commands: &[ClientCommand]| {
        for command in commands {
            desk.model.handle_event(ClientTime(1.0), ClientEvent::Command(command.clone()), &mut Vec::new());
        }
    };
    let desk = |commands: &[ClientCommand]| {
        let mut desk = Desk::connected().event(api::Event::Maps(vec![map(9, "Hall"), map(8, "Cellar")]));
        align(&mut desk, commands);
        desk.on(Screen::Map).shown(1440.0, 1200.0)
    };
    let mut harness = desk(&[ClientCommand::ViewMap(Some(hall))]);
    harness.get_by_label("Align Hall").click();
    harness.run_steps(2);
    assert!(harness.state().asked.contains(&ClientCommand::AlignMap { map: hall, reference: None }));
    let mut harness = desk(&[ClientCommand::AlignMap { map: hall, reference: None }]);
    assert!(harness.query_by_label("Onto Hall").is_none(), "onto itself");
    harness.get_by_label("Onto Cellar").click();
    harness.run_steps(2);
    let onto = ClientCommand::AlignMap { map: hall, reference: Some(cellar) };
    assert!(harness.state().asked.contains(&onto));
    desk(std::slice::from_ref(&onto)).get_by_label("Align by what both look like");

    let pick = |x: f64, y: f64| ClientCommand::AddAlignmentPoint(Vec3::new(x, y, 0.0));
    let mut commands = vec![onto, pick(0.0, 0.0), pick(5.0, 5.0), pick(4.0, 0.0), pick(5.0, 9.0)];
    let mut harness = desk(&commands);
    assert_eq!(harness.get_by_label("Points picked in both").value().as_deref(), Some("2"));
    assert_eq!(harness.get_by_label("They agree to").value().as_deref(), Some("1 mm"));
    harness.get_by_label("Align by the points").click();
    harness.get_by_label("Look at Cellar").click();
    harness.run_steps(2);
    let asked = &harness.state().asked;
    assert!(
        asked.contains(&ClientCommand::StartAlignment)
            && asked.contains(&ClientCommand::ViewMap(Some(cellar))),
        "{asked:?}"
    );
    commands.extend([pick(0.0, 3.0), pick(5.0, 19.0)]);
    let mut harness = desk(&commands);
    harness.get_by_label_contains("contradict each other");
    harness.get_by_label("Align by the points").click();
    harness.run_steps(2);
    assert!(!harness.state().asked.contains(&ClientCommand::StartAlignment), "not by these");
}
