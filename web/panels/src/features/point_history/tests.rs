//! The history of an inspection point in the panel.

use super::plot;
use super::time_axis::TimeAxis;
use crate::screens;
use crate::test_support::missions::type_into;
use crate::test_support::{TestClient, click, value};
use api::{Event, SiteParts, SiteState};
use client_model::{
    ClientCommand, ClientEvent, ClientTime, HistorySpan, PointHistoryCommand, Selection, StoredPage,
    StoredResult,
};
use egui::{Key, Rect, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use site_model::{
    ActionRequest, Asset, AssetId, EditId, InspectionPoint, InspectionPointId, NodeId, Object, ReadingLimits,
    Site, SiteSettings, Utc,
};
use std::sync::Arc;
use std::time::Instant;
use uuid::Uuid;
use vocab::Vec3;

const PUMP: InspectionPointId = InspectionPointId(Uuid::from_u128(5));
const GATE: InspectionPointId = InspectionPointId(Uuid::from_u128(6));
/// 2026-07-01T10:00 UTC, 12:00 in Rome.
const FIRST_NS: i64 = 1_782_900_000_000_000_000;
const HOUR_NS: i64 = 3_600_000_000_000;

fn site() -> Site {
    let asset = AssetId(Uuid::from_u128(7));
    let point = |id, name: &str, asset| {
        Object::InspectionPoint(InspectionPoint {
            id,
            name: name.into(),
            asset,
            node: NodeId(Uuid::from_u128(9)),
            target_m: Vec3::new(0.0, 0.0, 0.0),
            request: ActionRequest { action: "thermal_photo".into(), parameters: Default::default() },
            limits: Some(ReadingLimits { min: None, max: Some(26.0), unit: "°C".into() }),
            gauge: None,
        })
    };
    let objects = [
        Object::Settings(SiteSettings { name: "Works".into(), time_zone: "Europe/Rome".into(), map: None }),
        Object::Asset(Asset { id: asset, name: "Cooling".into(), tags: Default::default() }),
        point(PUMP, "Pump 7", Some(asset)),
        point(GATE, "Gate valve", None),
    ];
    let mut site = Site::default();
    for (number, object) in (1..).zip(objects) {
        let id = EditId(Uuid::from_u128(number));
        let edit = site.put(id, object);
        site.apply(&edit, id).unwrap();
    }
    site
}

/// A result each hour, with a picture.
fn result(number: u64, celsius: f64) -> StoredResult {
    let at_ns = FIRST_NS + (number as i64 - 1) * HOUR_NS;
    let blob = format!("{number:064x}");
    serde_json::from_value(serde_json::json!({
        "number": number, "run": Uuid::from_u128(number.into()), "at_ns": at_ns, "step": 0, "attempt": 1, "kind": "photo",
        "details": { "inspection_point": PUMP, "value": {
            "at": { "robot_time": 0, "utc_ns": at_ns, "is_synchronised": true },
            "files": [{ "name": "photo.jpg", "media_type": "image/jpeg", "blob": blob, "bytes": 5 }],
            "readings": [{ "name": "temperature", "value": celsius, "unit": "°C" }] } }
    }))
    .unwrap()
}

/// 20.0 to 20.4 °C in turn; number 10 is unusual, number 20 outside the limits.
fn celsius(number: u64) -> f64 {
    match number {
        10 => 23.0,
        20 => 27.5,
        _ => 20.0 + 0.1 * (number * 3 % 5) as f64,
    }
}

fn client() -> TestClient {
    let state = SiteState { site: site(), ..SiteState::default() };
    let part = SiteParts::new(Arc::new(state)).next_part();
    TestClient::connected().event(Event::SitePart(part)).on(screens::RUNS)
}

/// Results 1 to `count` of the pump.
fn fetched(mut client: TestClient, count: u64) -> TestClient {
    client = client.command(ClientCommand::PointHistory(PointHistoryCommand::Open(PUMP)));
    let items = (1..=count).rev().map(|number| result(number, celsius(number))).collect();
    let page = StoredPage { items, next: None };
    let event = ClientEvent::PointResultsFetched { point: PUMP, before: None, result: Ok(page) };
    client.model.handle_event(ClientTime(2.0), event, &mut Vec::new());
    client
}

/// Carries out what the panels asked of the history, as the shell does.
fn obey(harness: &mut Harness<'_, TestClient>) {
    let client = harness.state_mut();
    for command in std::mem::take(&mut client.commands) {
        if matches!(command, ClientCommand::PointHistory(_)) {
            client.model.handle_event(ClientTime(2.0), ClientEvent::Command(command), &mut Vec::new());
        }
    }
    harness.run_steps(2);
}

fn asked(harness: &Harness<'_, TestClient>, command: PointHistoryCommand) -> bool {
    harness.state().emitted(&ClientCommand::PointHistory(command))
}

fn large(harness: &mut Harness<'_, TestClient>) {
    click(harness, "Compare large");
    harness.run_steps(3);
}

#[test]
fn a_point_is_chosen_below_its_asset() {
    let mut harness = client().shown(1440.0, 900.0);
    click(&mut harness, "Points");
    click(&mut harness, "Inspection point");
    for head in ["Cooling", "Without an asset"] {
        assert!(harness.query_by_label(head).is_some(), "{head}");
    }
    click(&mut harness, "Gate valve");
    assert!(asked(&harness, PointHistoryCommand::Open(GATE)));
    obey(&mut harness);
    assert!(harness.query_by_label("The results are fetched from the robot.").is_some());
}

#[test]
fn a_selected_point_leads_to_its_history() {
    let selection = Some(Selection::InspectionPoint(GATE));
    let client = client().on(screens::SITE).command(ClientCommand::Select(selection));
    let mut harness = client.shown(1440.0, 2_400.0);
    harness.run_steps(3);
    click(&mut harness, "History of this point");
    assert!(asked(&harness, PointHistoryCommand::Open(GATE)));
    obey(&mut harness);
    assert!(harness.state().emitted(&ClientCommand::ShowScreen(screens::RUNS)));
}

#[test]
fn the_time_line_counts_what_is_remarkable_and_arrow_keys_go_from_result_to_result() {
    let mut harness = fetched(client(), 40).shown(1440.0, 900.0);
    let line = value(&harness, "Time line");
    let told = "40 results, 1 unusual, 1 outside the limits. B: 3 Jul 2026, 03:00, usual.";
    assert_eq!(line, told, "times are those of the site");
    harness.get_by_label("Time line").focus();
    harness.run_steps(2);
    harness.key_press(Key::ArrowLeft);
    harness.run_steps(2);
    assert!(asked(&harness, PointHistoryCommand::Step(-1)));
    obey(&mut harness);
    assert!(value(&harness, "Time line").contains("B: 3 Jul 2026, 02:00"));
    let drives = |command: &ClientCommand| matches!(command, ClientCommand::SetVelocity(_));
    assert!(!harness.state().commands.iter().any(drives), "arrow keys do not drive");
    click(&mut harness, "Week");
    assert!(asked(&harness, PointHistoryCommand::ShowSpan(HistorySpan::Week)));
}

#[test]
fn of_one_result_there_is_none_before_and_none_after() {
    let harness = fetched(client(), 1).shown(1440.0, 900.0);
    for name in ["Previous result", "Next result"] {
        assert!(harness.get_by_label(name).accesskit_node().is_disabled(), "{name}");
    }
    assert!(harness.query_by_label("There is no earlier result to compare with.").is_some());
    assert_eq!(value(&harness, "Time line"), "1 result. B: 1 Jul 2026, 12:00, usual.");
}

#[test]
fn a_drag_over_the_time_line_zooms_in() {
    let all = ClientCommand::PointHistory(PointHistoryCommand::ShowSpan(HistorySpan::All));
    let mut harness = fetched(client(), 40).command(all).shown(1440.0, 900.0);
    let place = harness.get_by_label("Time line").rect();
    // Both ends have room for a letter.
    let place = place.shrink2(vec2(14.0, 0.0));
    let [from, to] = [0.25, 0.75].map(|share| pos2(place.left() + share * place.width(), place.center().y));
    harness.drag_at(from);
    harness.run_steps(1);
    harness.hover_at(to);
    harness.run_steps(1);
    harness.drop_at(to);
    harness.run_steps(2);
    let zoomed = harness.state().commands.iter().find_map(|command| match command {
        ClientCommand::PointHistory(PointHistoryCommand::ShowSpan(HistorySpan::Between(range))) => {
            Some(*range)
        }
        _ => None,
    });
    let [from, to] = zoomed.expect("a part is shown").map(|at| (at.0 - FIRST_NS) as f64 / HOUR_NS as f64);
    assert!((from - 0.25 * 39.0).abs() < 0.3 && (to - 0.75 * 39.0).abs() < 0.3, "{from} {to}");
}

#[test]
fn readings_are_told_with_their_trend_and_what_is_wrong() {
    let harness = fetched(client(), 40).shown(1440.0, 1600.0);
    let plot = value(&harness, "Temperature, °C");
    assert!(plot.starts_with("40 readings, newest 20.0"), "{plot}");
    assert!(plot.ends_with("1 unusual, 1 outside the limits"), "{plot}");
    assert_eq!(value(&harness, "Trend"), "none that is clear");
    assert!(value(&harness, "Limits").contains("at most 26.00 °C"));
    assert!(value(&harness, "Median").starts_with("20.2"), "{}", value(&harness, "Median"));
}

#[test]
fn two_pictures_are_shown_beside_each_other_wiped_and_in_turn() {
    let mut harness = fetched(client(), 40).shown(1440.0, 900.0);
    let wanted = harness.state_mut().panels.files.take_wanted();
    assert_eq!(wanted.len(), 2, "A and B");
    for (blob, _) in wanted {
        let image = egui::ColorImage::filled([64, 48], egui::Color32::RED);
        let ctx = harness.ctx.clone();
        harness.state_mut().panels.files.insert(&ctx, blob, Ok(crate::ResultFileContent::Picture(image)));
    }
    large(&mut harness);
    click(&mut harness, "Wipe");
    assert_eq!(value(&harness, "Divider"), "50 %");
    harness.get_by_label("Divider").focus();
    harness.run_steps(2);
    harness.key_press(Key::ArrowRight);
    harness.run_steps(2);
    assert_eq!(value(&harness, "Divider"), "52 %");
    click(&mut harness, "Blink");
    let first = value(&harness, "Shown");
    click(&mut harness, "Stop blinking");
    let stopped = value(&harness, "Shown");
    harness.run_steps(120);
    assert_eq!(value(&harness, "Shown"), stopped, "nothing changes by itself");
    click(&mut harness, "Show the other one");
    assert_ne!(value(&harness, "Shown"), stopped);
    assert!(first.starts_with("A · ") || first.starts_with("B · "), "{first}");
    click(&mut harness, "Side by side");
    assert!(harness.query_by_label("Divider").is_none());
    harness.key_press(Key::ArrowLeft);
    harness.run_steps(2);
    assert!(asked(&harness, PointHistoryCommand::Step(-1)));
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert!(harness.query_by_label("Close the comparison").is_none());
    assert!(!harness.state().emitted(&ClientCommand::StopMotion));
}

/// Two photos that differ in one place: B is displaced by 8 pixels to the right.
fn changed_photo(before: u64) -> serde_json::Value {
    serde_json::json!({ "before": before, "outcome": { "aligned": {
        "after_from_before": [[1.0, 0.0, 8.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "residual_px": 0.28,
        "before_size_px": [64, 48], "after_size_px": [64, 48],
        "changes": [{ "min_px": [10, 12], "max_px": [15, 20], "area_px": 40, "strength": 0.8 }] } } })
}

#[test]
fn aligned_photos_say_how_well_and_what_has_changed_and_keys_switch_that() {
    let mut client = client().command(ClientCommand::PointHistory(PointHistoryCommand::Open(PUMP)));
    let mut items: Vec<StoredResult> = (1..=3).rev().map(|number| result(number, 20.0)).collect();
    items[0].comparison = serde_json::from_value(changed_photo(2)).unwrap();
    let dark = serde_json::json!({ "before": 1, "outcome": { "not_aligned": "The pictures could not be aligned: dark." } });
    items[1].comparison = serde_json::from_value(dark).unwrap();
    let event = ClientEvent::PointResultsFetched {
        point: PUMP,
        before: None,
        result: Ok(StoredPage { items, next: None }),
    };
    client.model.handle_event(ClientTime(2.0), event, &mut Vec::new());
    let mut harness = client.shown(1440.0, 900.0);
    assert!(value(&harness, "Time line").starts_with("3 results, 1 with a changed photo. B: "));
    assert!(harness.query_by_label("The photo has changed in 1 place since the one before.").is_some());
    large(&mut harness);
    assert_eq!(value(&harness, "Alignment"), "Aligned, within 0.3 px · changed in 1 place");
    let is_on = |harness: &Harness<'_, TestClient>, name: &str| {
        harness.get_by_label(name).accesskit_node().toggled() == Some(egui::accesskit::Toggled::True)
    };
    for (key, name) in [(Key::L, "Aligned"), (Key::C, "Mark changes")] {
        assert!(is_on(&harness, name), "{name}");
        harness.key_press(key);
        harness.run_steps(2);
        assert!(!is_on(&harness, name), "{name}");
    }
    ask_of(&mut harness, PointHistoryCommand::Step(-1));
    assert_eq!(value(&harness, "Alignment"), "The pictures could not be aligned: dark.");
    assert!(harness.query_by_label("Aligned").is_none());
    // No neighbours: the robot is asked.
    ask_of(&mut harness, PointHistoryCommand::Choose(3));
    ask_of(&mut harness, PointHistoryCommand::Keep(Some(1)));
    assert!(asked(&harness, PointHistoryCommand::Align));
    obey(&mut harness);
    assert_eq!(value(&harness, "Alignment"), "The robot aligns the photos.");
}

/// Does what somebody asks of the history.
fn ask_of(harness: &mut Harness<'_, TestClient>, command: PointHistoryCommand) {
    let event = ClientEvent::Command(ClientCommand::PointHistory(command));
    harness.state_mut().model.handle_event(ClientTime(2.0), event, &mut Vec::new());
    harness.run_steps(2);
}

#[test]
fn pictures_blink_by_themselves_unless_the_system_asks_for_reduced_motion() {
    for is_reduced in [false, true] {
        let mut client = fetched(client(), 3);
        client.panels.is_motion_reduced = is_reduced;
        let mut harness = client.shown(1440.0, 900.0);
        large(&mut harness);
        click(&mut harness, "Blink");
        let mut seen = std::collections::BTreeSet::new();
        // A step is a quarter of a second.
        for _ in 0..12 {
            seen.insert(value(&harness, "Shown"));
            harness.run_steps(1);
        }
        assert_eq!(seen.len(), if is_reduced { 1 } else { 2 }, "{seen:?}");
    }
}

#[test]
fn the_chosen_result_is_kept_for_comparisons_and_everything_is_saved() {
    let mut harness = fetched(client(), 40).shown(1440.0, 1600.0);
    click(&mut harness, "Keep this one as A");
    assert!(asked(&harness, PointHistoryCommand::Keep(Some(40))));
    obey(&mut harness);
    click(&mut harness, "A is the one before");
    assert!(asked(&harness, PointHistoryCommand::Keep(None)));
    click(&mut harness, "Save all as a table (CSV)");
    assert!(asked(&harness, PointHistoryCommand::Export));
}

#[test]
fn what_could_not_be_fetched_is_fetched_again() {
    let mut client = client().command(ClientCommand::PointHistory(PointHistoryCommand::Open(PUMP)));
    let result = Err("The server does not answer.".to_owned());
    let event = ClientEvent::PointResultsFetched { point: PUMP, before: None, result };
    client.model.handle_event(ClientTime(2.0), event, &mut Vec::new());
    let mut harness = client.shown(1440.0, 900.0);
    assert!(harness.query_by_label("The server does not answer.").is_some());
    click(&mut harness, "Fetch again");
    assert!(asked(&harness, PointHistoryCommand::Retry));
}

/// The figures are for docs; the machine is shared, so none is asserted.
#[test]
fn a_plot_of_5_000_readings_has_a_mark_in_each_column_at_most() {
    let client = fetched(client(), 5_000)
        .command(ClientCommand::PointHistory(PointHistoryCommand::ShowSpan(HistorySpan::All)));
    let history = &client.model.point_history;
    let place = Rect::from_min_size(pos2(0.0, 0.0), vec2(320.0, 100.0));
    let axis = TimeAxis::new(history.range().unwrap(), place);
    assert_eq!(axis.to, Utc(FIRST_NS + 4_999 * HOUR_NS));
    let columns = plot::columns(&history.series()[0], &axis);
    assert_eq!((columns.len(), columns.iter().flatten().count()), (320, 320));
    let frame_ms = |client: TestClient| {
        let mut harness = client.shown(1440.0, 1600.0);
        let frames = 20_u32;
        let began = Instant::now();
        harness.run_steps(frames as usize);
        began.elapsed().as_secs_f64() * 1e3 / f64::from(frames)
    };
    let (many_ms, few_ms) = (frame_ms(client), frame_ms(fetched(self::client(), 40)));
    println!("a frame of the whole page: {few_ms:.2} ms with 40 results, {many_ms:.2} ms with 5,000");
}

/// The large photo of the gauge, and where a share of it is.
fn photo_of_gauge(harness: &Harness<'_, TestClient>) -> impl Fn(f32, f32) -> egui::Pos2 + use<> {
    let place = harness.get_by_label("Photo of the gauge").rect();
    // 64 x 48 pixels fill the height or the width.
    let size = vec2(64.0, 48.0) * (place.size() / vec2(64.0, 48.0)).min_elem();
    let shown = Rect::from_center_size(place.center(), size);
    move |x, y| shown.lerp_inside(vec2(x, y))
}

fn press_at(harness: &mut Harness<'_, TestClient>, at: egui::Pos2) {
    harness.hover_at(at);
    harness.drag_at(at);
    harness.run_steps(1);
    harness.drop_at(at);
    harness.run_steps(2);
}

#[test]
fn a_gauge_is_described_by_four_presses_and_saved_as_one_edit() {
    let mut harness = fetched(client(), 2).shown(1440.0, 1_600.0);
    for (blob, _) in harness.state_mut().panels.files.take_wanted() {
        let image = egui::ColorImage::filled([64, 48], egui::Color32::GRAY);
        let ctx = harness.ctx.clone();
        harness.state_mut().panels.files.insert(&ctx, blob, Ok(crate::ResultFileContent::Picture(image)));
    }
    click(&mut harness, "Describe the gauge");
    harness.run_steps(3);
    assert!(harness.get_by_label("Save the gauge").accesskit_node().is_disabled());
    let at = photo_of_gauge(&harness);
    for (x, y) in [(0.5, 0.5), (0.4, 0.7), (0.5, 0.2), (0.6, 0.7)] {
        press_at(&mut harness, at(x, y));
    }
    assert_eq!(value(&harness, "Centre of the scale"), "32, 24 px");
    // A mark that has the focus is moved by arrow keys.
    harness.get_by_label("Upper end of the scale").focus();
    harness.run_steps(2);
    harness.key_press(Key::ArrowRight);
    harness.run_steps(2);
    assert_eq!(value(&harness, "Upper end of the scale"), "39, 33 px");
    for (name, text) in [("At lower end", "0"), ("At upper end", "6")] {
        type_into(&mut harness, name, text);
    }
    click(&mut harness, "Unit");
    harness.run_steps(2);
    click(&mut harness, "bar");
    harness.run_steps(2);
    click(&mut harness, "Save the gauge");
    harness.run_steps(2);
    let saved = harness.state().commands.iter().find_map(|command| match command {
        ClientCommand::EditSite(edit) => edit.put.first(),
        _ => None,
    });
    let Some(Object::InspectionPoint(point)) = saved else { panic!("{:?}", harness.state().commands) };
    let dial = point.gauge.as_ref().expect("described");
    assert_eq!((dial.range, dial.unit.as_str(), dial.size_px), ([0.0, 6.0], "bar", [64, 48]));
    assert!((dial.centre_px[0] - 31.5).abs() < 0.2 && (dial.centre_px[1] - 23.5).abs() < 0.2, "{dial:?}");
    assert!(harness.query_by_label("Photo of the gauge").is_none(), "it is closed");
}

#[test]
fn escape_closes_the_gauge_and_saves_nothing() {
    let mut harness = fetched(client(), 2).shown(1440.0, 1_600.0);
    click(&mut harness, "Describe the gauge");
    harness.run_steps(3);
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    assert!(harness.query_by_label("Save the gauge").is_none());
    assert!(!harness.state().commands.iter().any(|command| matches!(command, ClientCommand::EditSite(_))));
}

#[test]
fn on_a_tablet_the_drawer_is_away_while_a_card_covers_the_page() {
    let mut client = fetched(client(), 2);
    client.panels.frame.drawer_open = true;
    let mut harness = client.shown(1024.0, 1_600.0);
    click(&mut harness, "Describe the gauge");
    harness.run_steps(3);
    assert!(harness.query_by_label("Describe the gauge").is_none(), "the drawer is away");
    harness.get_by_label("Save the gauge");
    harness.key_press(Key::Escape);
    harness.run_steps(3);
    harness.get_by_label("Describe the gauge");
    large(&mut harness);
    assert!(harness.query_by_label("Describe the gauge").is_none(), "nor is it over a comparison");
}
