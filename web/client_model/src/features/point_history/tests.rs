//! The history of a point: pages, what is compared, judgements, and the table.

use super::*;
use crate::StoredResultDetails;
use crate::testing::TestClient;
use api::{Event, SiteParts, SiteState};
use site_model::{
    ActionReport, ActionRequest, EditId, NodeId, Object, PictureComparison, PictureComparisonOutcome,
    Reading, ReadingLimits, ReportFile, RunId, Site, SiteSettings,
};
use std::sync::Arc;
use std::time::Instant;
use uuid::Uuid;
use vocab::{BlobHash, Stamp, Vec3};

const POINT: InspectionPointId = InspectionPointId(Uuid::from_u128(5));
const OTHER: InspectionPointId = InspectionPointId(Uuid::from_u128(6));
/// 2026-07-01T10:00 UTC, 12:00 in Rome.
const FIRST_NS: i64 = 1_782_900_000_000_000_000;
const DAY_NS: i64 = 86_400_000_000_000;

fn site(limits: Option<ReadingLimits>) -> SiteState {
    let mut site = Site::default();
    let point = InspectionPoint {
        id: POINT,
        name: "Pump 7, inlet".into(),
        asset: None,
        node: NodeId(Uuid::from_u128(9)),
        target_m: Vec3::new(0.0, 0.0, 0.0),
        request: ActionRequest { action: "temperature".into(), parameters: Default::default() },
        limits,
        gauge: None,
    };
    let settings = SiteSettings { name: "Works".into(), time_zone: "Europe/Rome".into(), map: None };
    for (number, object) in (1..).zip([Object::Settings(settings), Object::InspectionPoint(point)]) {
        let id = EditId(Uuid::from_u128(number));
        let edit = site.put(id, object);
        site.apply(&edit, id).unwrap();
    }
    SiteState { site, ..SiteState::default() }
}

fn client(limits: Option<ReadingLimits>) -> TestClient {
    let mut client = TestClient::connected();
    client.event(Event::SitePart(SiteParts::new(Arc::new(site(limits))).next_part()));
    client.take_effects();
    client
}

fn report(celsius: f64) -> ActionReport {
    let reading =
        Reading { name: "temperature".into(), value: celsius, standard_deviation: None, unit: "°C".into() };
    ActionReport { readings: vec![reading], ..ActionReport::default() }
}

/// One result a day; the first one has number 1.
fn result(number: u64, report: &ActionReport) -> StoredResult {
    StoredResult {
        number,
        at: Utc(FIRST_NS + (number as i64 - 1) * DAY_NS),
        run: RunId(Uuid::from_u128(number.into())),
        kind: "temperature".to_owned(),
        step: 0,
        attempt: 1,
        details: StoredResultDetails {
            value: serde_json::to_value(report).unwrap(),
            inspection_point: Some(POINT),
        },
        comparison: None,
    }
}

/// 20.0 to 20.4 °C in turn.
fn calm(number: u64) -> f64 {
    20.0 + 0.1 * (number * 3 % 5) as f64
}

/// Results with these numbers, the newest first, as the robot sends them.
fn page(numbers: std::ops::RangeInclusive<u64>, next: Option<u64>) -> StoredPage<StoredResult> {
    let items = numbers.rev().map(|number| result(number, &report(calm(number)))).collect();
    StoredPage { items, next: next.map(|next| next.to_string()) }
}

fn answer(client: &mut TestClient, before: Option<&str>, page: StoredPage<StoredResult>) {
    let before = before.map(str::to_owned);
    client.apply(ClientEvent::PointResultsFetched { point: POINT, before, result: Ok(page) });
}

fn ask(client: &mut TestClient, command: PointHistoryCommand) {
    client.command(ClientCommand::PointHistory(command));
}

fn fetch(before: Option<&str>) -> ClientEffect {
    ClientEffect::FetchPointResults { point: POINT, before: before.map(str::to_owned) }
}

/// A client with results 1 to 60, of which the older pages are fetched as they are asked for.
fn opened(limits: Option<ReadingLimits>) -> TestClient {
    let mut client = client(limits);
    ask(&mut client, PointHistoryCommand::Open(POINT));
    assert_eq!(client.take_effects(), [fetch(None)]);
    answer(&mut client, None, page(41..=60, Some(41)));
    client
}

#[test]
fn pages_are_fetched_until_the_part_that_is_shown_is_covered() {
    let mut client = opened(None);
    assert_eq!(client.take_effects(), [fetch(Some("41"))], "20 days of 31 are there");
    assert!(client.model.point_history.is_fetching());
    answer(&mut client, Some("7"), page(1..=6, None));
    assert_eq!(client.model.point_history.results().len(), 20, "nobody waits for that page");
    answer(&mut client, Some("41"), page(21..=40, Some(21)));
    assert_eq!(client.take_effects(), [], "40 days are there");
    let history = &client.model.point_history;
    let numbers: Vec<u64> = history.results().iter().map(|result| result.number).collect();
    assert_eq!(numbers, (21..=60).collect::<Vec<_>>(), "the oldest first");
    assert!(!history.is_whole() && !history.is_fetching());
    let [from, to] = history.range().unwrap();
    assert_eq!((to.0 - from.0, to), (31 * DAY_NS, history.results()[39].at));
    ask(&mut client, PointHistoryCommand::ShowSpan(HistorySpan::Day));
    assert_eq!(client.take_effects(), []);
    ask(&mut client, PointHistoryCommand::ShowSpan(HistorySpan::All));
    assert_eq!(client.take_effects(), [fetch(Some("21"))]);
    answer(&mut client, Some("21"), page(1..=20, None));
    assert!(client.model.point_history.is_whole());
    assert_eq!(client.model.point_history.range().unwrap()[0], Utc(FIRST_NS));
}

#[test]
fn what_cannot_be_fetched_is_told_and_fetched_again() {
    let mut client = opened(None);
    client.take_effects();
    let sentence = "The server does not answer.".to_owned();
    let failed = |before: &str| ClientEvent::PointResultsFetched {
        point: POINT,
        before: Some(before.to_owned()),
        result: Err(sentence.clone()),
    };
    client.apply(failed("41"));
    assert_eq!(client.model.point_history.problem(), Some(&*sentence));
    assert_eq!(client.take_effects(), [], "not by itself");
    ask(&mut client, PointHistoryCommand::Retry);
    assert_eq!(
        (client.take_effects(), client.model.point_history.problem()),
        (vec![fetch(Some("41"))], None)
    );
    // A page without results is the last one.
    answer(&mut client, Some("41"), StoredPage { items: Vec::new(), next: Some("41".into()) });
    assert!(client.model.point_history.is_whole());
    assert_eq!(client.take_effects(), []);
}

#[test]
fn the_newest_is_compared_with_the_one_before_until_others_are_chosen() {
    let mut client = opened(None);
    let numbers = |client: &TestClient| {
        let history = &client.model.point_history;
        (history.earlier().map(|it| it.number), history.later().map(|it| it.number))
    };
    assert_eq!(numbers(&client), (Some(59), Some(60)));
    ask(&mut client, PointHistoryCommand::Step(1));
    assert_eq!(numbers(&client), (Some(59), Some(60)), "it is the newest");
    assert!(!client.model.point_history.can_step(1) && client.model.point_history.can_step(-1));
    ask(&mut client, PointHistoryCommand::Step(-1));
    assert_eq!(numbers(&client), (Some(58), Some(59)));
    ask(&mut client, PointHistoryCommand::Keep(Some(59)));
    ask(&mut client, PointHistoryCommand::Choose(45));
    assert_eq!(numbers(&client), (Some(59), Some(45)), "also one that is later");
    ask(&mut client, PointHistoryCommand::Keep(None));
    ask(&mut client, PointHistoryCommand::Choose(41));
    client.apply(ClientEvent::Tick);
    assert_eq!(numbers(&client), (None, Some(41)), "the one before was not fetched yet");
    answer(&mut client, Some("41"), page(21..=40, Some(21)));
    client.take_effects();
    ask(&mut client, PointHistoryCommand::Choose(21));
    assert!(client.model.point_history.can_step(-1));
    ask(&mut client, PointHistoryCommand::Step(-1));
    assert_eq!(client.take_effects(), [fetch(Some("21"))], "older ones are fetched");
    assert_eq!(numbers(&client), (None, Some(21)));
}

#[test]
fn a_chosen_result_that_is_old_is_sought_and_the_part_that_is_shown_moves_to_it() {
    let mut client = opened(None);
    client.take_effects();
    ask(&mut client, PointHistoryCommand::ShowSpan(HistorySpan::Week));
    ask(&mut client, PointHistoryCommand::Choose(11));
    answer(&mut client, Some("41"), page(21..=40, Some(21)));
    assert_eq!(client.take_effects(), [fetch(Some("21"))], "although a week is there");
    assert_eq!(client.model.point_history.later().unwrap().number, 60, "meanwhile the newest");
    answer(&mut client, Some("21"), page(1..=20, Some(1)));
    let history = &client.model.point_history;
    assert_eq!(history.later().unwrap().number, 11);
    let at = history.later().unwrap().at.0;
    assert_eq!(history.range().unwrap().map(|it| it.0 - at), [-7 * DAY_NS / 2, 7 * DAY_NS / 2]);
    assert_eq!(client.take_effects(), []);
    ask(&mut client, PointHistoryCommand::Choose(999));
    assert_eq!(client.take_effects(), [fetch(Some("1"))]);
    answer(&mut client, Some("1"), StoredPage { items: Vec::new(), next: None });
    assert_eq!(client.take_effects(), [], "there is no such result");
    assert_eq!(client.model.point_history.later().unwrap().number, 60);
}

#[test]
fn a_result_that_is_stored_meanwhile_is_there_at_once_and_after_a_reconnection_the_newest_are_fetched() {
    let mut client = opened(None);
    answer(&mut client, Some("41"), page(21..=40, Some(21)));
    let stored = |number: u64, point: InspectionPointId| {
        let details = serde_json::json!({ "inspection_point": point, "value": report(20.0) });
        let (run, kind) = (RunId(Uuid::from_u128(number.into())), "temperature".to_owned());
        let at = Stamp::from_nanos(FIRST_NS + 60 * DAY_NS);
        let body = details.to_string();
        Event::ResultStored(api::StoredResult {
            number,
            run,
            step: 0,
            attempt: 1,
            kind,
            blob: None,
            body,
            comparison: None,
            at,
        })
    };
    client.event(stored(61, OTHER));
    assert_eq!(client.model.point_history.results().len(), 40);
    client.event(stored(62, POINT));
    client.event(stored(62, POINT));
    assert_eq!(client.model.point_history.results().len(), 41);
    assert_eq!(client.model.point_history.later().unwrap().number, 62);
    assert_eq!(client.model.point_history.series()[0].values.len(), 41);
    client.take_effects();
    client.lose_connection();
    client.wait(10.0);
    client.connect();
    assert!(client.take_effects().contains(&fetch(None)));
    assert_eq!(client.model.point_history.results().len(), 41, "they stay meanwhile");
    answer(&mut client, None, page(42..=61, Some(42)));
    let numbers: Vec<u64> = client.model.point_history.results().iter().map(|it| it.number).collect();
    assert_eq!(numbers, (21..=62).collect::<Vec<_>>(), "nothing is missing between them");
    // A page without any that is known: what lies between is missing.
    client.lose_connection();
    client.wait(10.0);
    client.connect();
    answer(&mut client, None, page(90..=99, Some(90)));
    let numbers: Vec<u64> = client.model.point_history.results().iter().map(|it| it.number).collect();
    assert_eq!(numbers, (90..=99).collect::<Vec<_>>());
}

#[test]
fn a_result_is_judged_by_the_limits_of_the_point_and_by_the_others() {
    let mut client = client(None);
    ask(&mut client, PointHistoryCommand::Open(POINT));
    let mut items = page(1..=40, None).items;
    // The newest first: number 40 is at place 0.
    items[10] = result(30, &report(27.0));
    items[20] = result(20, &ActionReport::default());
    let page = StoredPage { items, next: None };
    answer(&mut client, None, page.clone());
    let judged = |client: &TestClient| {
        let history = &client.model.point_history;
        [30, 20, 1].map(|number| history.judgement(number))
    };
    let [unusual, not_judged, usual] =
        [ResultJudgement::Unusual, ResultJudgement::NotJudged, ResultJudgement::Usual];
    assert_eq!(judged(&client), [unusual, not_judged, usual]);
    let series = &client.model.point_history.series()[0];
    assert_eq!((series.values.len(), series.limits.as_ref()), (39, None));
    assert!((series.trend_at(Utc(FIRST_NS)).unwrap() - 20.2).abs() < 0.1);
    assert_eq!(series.values[0].hour, 12, "by the clock of the site");
    let limits = ReadingLimits { min: None, max: Some(26.0), unit: "°C".into() };
    let mut client = self::client(Some(limits));
    ask(&mut client, PointHistoryCommand::Open(POINT));
    answer(&mut client, None, page);
    assert_eq!(judged(&client), [ResultJudgement::OutsideLimits, not_judged, usual]);
}

#[test]
fn the_table_has_every_result_with_both_times_and_is_saved_once_all_are_there() {
    let mut client = opened(None);
    client.take_effects();
    ask(&mut client, PointHistoryCommand::Export);
    assert!(client.model.point_history.is_exporting());
    assert_eq!(client.take_effects(), [], "a page is on its way");
    answer(&mut client, Some("41"), page(3..=40, Some(3)));
    assert_eq!(client.take_effects(), [fetch(Some("3"))]);
    let blob = BlobHash([0xab; 32]);
    let file = ReportFile { name: "=a, b.jpg".into(), media_type: "image/jpeg".into(), blob, bytes: 1 };
    let without_readings = ActionReport { files: vec![file], ..ActionReport::default() };
    let items = vec![result(2, &report(20.25)), result(1, &without_readings)];
    answer(&mut client, Some("3"), StoredPage { items, next: None });
    let effects = client.take_effects();
    let [ClientEffect::SaveTable { name, text }] = &effects[..] else { panic!("{effects:?}") };
    assert_eq!(name, "history_Pump_7__inlet.csv");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 61, "the heads and a row for each result");
    let time = "2026-07-01T10:00:00.000Z,2026-07-01T12:00:00.000+02:00,\"Europe/Rome\",1,";
    assert!(lines[1].starts_with(time), "{}", lines[1]);
    let files = format!("\"'=a, b.jpg={blob}\"");
    assert!(lines[1].ends_with(&files), "{}", lines[1]);
    assert!(lines[2].contains("\"temperature\",20.25,,\"°C\",,"), "{}", lines[2]);
    assert!(lines.iter().all(|line| !line.is_empty()));
    assert!(!client.model.point_history.is_exporting());
}

#[test]
fn another_point_begins_anew_and_the_same_one_keeps_what_is_there() {
    let mut client = opened(None);
    client.take_effects();
    let between = HistorySpan::Between([Utc(FIRST_NS), Utc(FIRST_NS + DAY_NS)]);
    ask(&mut client, PointHistoryCommand::ShowSpan(between));
    ask(&mut client, PointHistoryCommand::Open(POINT));
    assert_eq!((client.model.point_history.opened(), client.model.point_history.results().len()), (2, 20));
    client.take_effects();
    ask(&mut client, PointHistoryCommand::Open(OTHER));
    let history = &client.model.point_history;
    assert_eq!((history.opened(), history.results().len(), history.series().len()), (3, 0, 0));
    assert_eq!(history.span(), HistorySpan::Month);
    assert_eq!(client.take_effects(), [ClientEffect::FetchPointResults { point: OTHER, before: None }]);
    answer(&mut client, Some("41"), page(21..=40, None));
    assert!(client.model.point_history.results().is_empty(), "an answer for the point before");
}

/// Thermal pictures have three readings each. The figures are for docs; the machine is shared, so none is asserted.
#[test]
fn a_history_of_5_000_results_is_followed_page_by_page() {
    let mut client = client(None);
    ask(&mut client, PointHistoryCommand::Open(POINT));
    ask(&mut client, PointHistoryCommand::ShowSpan(HistorySpan::All));
    let hourly = |number: u64| {
        let mut thermal = report(calm(number));
        for name in ["lowest_temperature", "highest_temperature"] {
            let reading = Reading { name: name.into(), ..thermal.readings[0].clone() };
            thermal.readings.push(reading);
        }
        let at = Utc(FIRST_NS + number as i64 * DAY_NS / 24);
        StoredResult { at, ..result(number, &thermal) }
    };
    let mut before: Option<String> = None;
    let (mut longest_s, mut last_s) = (0.0_f64, 0.0);
    for page in (0..50_u64).rev() {
        let next = (page > 0).then(|| (page * 100 + 1).to_string());
        let items = (page * 100 + 1..=page * 100 + 100).rev().map(hourly).collect();
        let began = Instant::now();
        answer(&mut client, before.as_deref(), StoredPage { items, next: next.clone() });
        last_s = began.elapsed().as_secs_f64();
        longest_s = longest_s.max(last_s);
        before = next;
    }
    println!(
        "5,000 results, three readings each: longest page {:.1} ms, last page {:.1} ms",
        1e3 * longest_s,
        1e3 * last_s
    );
    assert_eq!(client.model.point_history.results().len(), 5_000);
    assert!(client.model.point_history.is_whole());
    assert_eq!(client.model.point_history.series().len(), 3);
    ask(&mut client, PointHistoryCommand::Export);
    let effects = client.take_effects();
    let Some(ClientEffect::SaveTable { text, .. }) = effects.last() else { panic!("it is saved at once") };
    assert_eq!(text.lines().count(), 15_001);
}

fn photo(number: u64) -> StoredResult {
    let file = ReportFile {
        name: "photo.jpg".to_owned(),
        media_type: "image/jpeg".to_owned(),
        blob: BlobHash([1; 32]),
        bytes: 5,
    };
    let report = ActionReport { files: vec![file], ..ActionReport::default() };
    StoredResult { kind: "photo".to_owned(), ..result(number, &report) }
}

#[test]
fn the_alignment_of_two_photos_is_that_of_the_robot_or_is_asked_for_once() {
    let outcome = |sentence: &str| PictureComparisonOutcome::NotAligned(sentence.to_owned());
    let compared = |before: u64| PictureComparison { before, outcome: outcome("Dark.") };
    let mut client = client(None);
    ask(&mut client, PointHistoryCommand::Open(POINT));
    let items = vec![StoredResult { comparison: Some(compared(2)), ..photo(3) }, photo(2), photo(1)];
    answer(&mut client, None, StoredPage { items, next: None });
    client.take_effects();
    let align = |client: &mut TestClient| {
        client.command(ClientCommand::PointHistory(PointHistoryCommand::Align));
        client.take_effects()
    };
    assert_eq!(client.model.point_history.alignment(), PairAlignment::Known(&outcome("Dark.")));
    assert_eq!(align(&mut client), [], "it is known");
    client.command(ClientCommand::PointHistory(PointHistoryCommand::Keep(Some(1))));
    assert_eq!(client.model.point_history.alignment(), PairAlignment::NotAsked);
    assert_eq!(align(&mut client), [ClientEffect::ComparePictures { before: 1, after: 3 }]);
    assert_eq!(client.model.point_history.alignment(), PairAlignment::Awaited);
    assert_eq!(align(&mut client), [], "once");
    let answered = |result| ClientEvent::PicturesCompared { before: 1, after: 3, result };
    client.apply(answered(Err("The robot is busy.".to_owned())));
    assert_eq!(client.model.point_history.alignment(), PairAlignment::Failed("The robot is busy."));
    assert_eq!(align(&mut client).len(), 1, "again");
    client.apply(answered(Ok(PictureComparison { before: 1, outcome: outcome("Bare.") })));
    assert_eq!(client.model.point_history.alignment(), PairAlignment::Known(&outcome("Bare.")));
    // The robot has compared a photo that is there already.
    client.command(ClientCommand::PointHistory(PointHistoryCommand::Keep(None)));
    client.command(ClientCommand::PointHistory(PointHistoryCommand::Choose(2)));
    assert_eq!(client.model.point_history.alignment(), PairAlignment::NotAsked);
    let StoredResult { run, details, .. } = photo(2);
    let body = serde_json::json!({ "inspection_point": POINT, "value": details.value }).to_string();
    let comparison = serde_json::to_string(&compared(1)).ok();
    client.event(Event::ResultStored(api::StoredResult {
        number: 2,
        run,
        step: 0,
        attempt: 1,
        kind: "photo".to_owned(),
        blob: None,
        body,
        comparison,
        at: Stamp::from_nanos(FIRST_NS),
    }));
    assert_eq!(client.model.point_history.alignment(), PairAlignment::Known(&outcome("Dark.")));
    assert_eq!(client.model.point_history.results().len(), 3);
}
