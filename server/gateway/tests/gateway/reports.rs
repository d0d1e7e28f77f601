//! Reports over HTTP: what they come with, what is refused, and what happens when the core fails meanwhile.

use crate::support::{Gateway, TestCore, soon};
use api::{
    CoreMessage, Event, GatewayMessage, Query, QueryReply, SiteParts, SiteState, StoredResult, StoredRun,
    StoredStep,
};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;
use site_model::{Change, Edit, EditId, MissionId, Object, RunId};
use std::sync::Arc;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use uuid::Uuid;
use vocab::Stamp;

const RUN: RunId = RunId(Uuid::from_u128(1));
const DAY_NS: i64 = 24 * 3_600_000_000_000;
const POLICY: &str =
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'";

fn report_path(run: RunId) -> String {
    api::paths::RUN_REPORT_PATH.replace("{run}", &run.to_string())
}

fn period_path(from_ns: i64, to_ns: i64) -> String {
    format!("{}?from_ns={from_ns}&to_ns={to_ns}", api::paths::REPORT_PATH)
}

fn run(number: u128) -> StoredRun {
    StoredRun {
        run: RunId(Uuid::from_u128(number)),
        mission: MissionId(Uuid::from_u128(2)),
        state: "succeeded".into(),
        is_ended: true,
        body: json!({ "began": DAY_NS, "tasks": 1 }).to_string(),
        began: Stamp::from_nanos(DAY_NS),
        changed: Stamp::from_nanos(2 * DAY_NS),
    }
}

/// A picture that is longer than what is sent at a time.
fn picture() -> Vec<u8> {
    let rest = (0..200_000_u32).map(|number| (number % 251) as u8);
    b"\xff\xd8\xff".iter().copied().chain(rest).collect()
}

/// The result with the picture.
fn photo() -> StoredResult {
    let file =
        json!({ "name": "photo.jpg", "media_type": "image/jpeg", "blob": "ab".repeat(32), "bytes": 200_003 });
    let at = json!({ "robot_time": 0, "utc_ns": 3, "is_synchronised": true });
    let body = json!({ "value": { "at": at, "files": [file] } }).to_string();
    let at = Stamp::from_nanos(DAY_NS);
    StoredResult {
        number: 7,
        run: RUN,
        step: 0,
        attempt: 1,
        kind: "photo".into(),
        blob: None,
        body,
        comparison: None,
        at,
    }
}

/// Sends a site with a mission.
async fn send_site(core: &mut TestCore) {
    let id = |number: u128| Uuid::from_u128(number).to_string();
    let objects = [
        json!({ "settings": { "name": "Works 3", "time_zone": "Europe/Paris" } }),
        json!({ "mission": { "id": id(2), "name": "Round <A>", "tasks": [] } }),
    ];
    let put = |object| Change::Put {
        base: None,
        object: serde_json::from_value::<Object>(object).expect("an object"),
    };
    let edit = Edit { id: EditId(Uuid::from_u128(4)), changes: objects.map(put).into() };
    let mut state = SiteState { revision: 1, ..SiteState::default() };
    state.site.apply(&edit, edit.id).expect("fits");
    core.publish(Event::SitePart(SiteParts::new(Arc::new(state)).next_part())).await;
}

/// Answers this many questions; `runs` is how many runs there are in any time.
async fn play(mut core: TestCore, questions: usize, runs: u128) -> Vec<Query> {
    send_site(&mut core).await;
    let mut asked = Vec::new();
    while asked.len() < questions {
        let GatewayMessage::Query { number, query, .. } = core.receive().await else { continue };
        let result = Ok(match query {
            Query::Run(id) => QueryReply::Runs((id == RUN).then(|| run(1)).into_iter().collect()),
            Query::Runs { before, limit, .. } => {
                let newest = before.map_or(runs, |before| before.0.as_u128() - 1);
                QueryReply::Runs((1..=newest).rev().take(limit as usize).map(run).collect())
            }
            Query::Steps { after: None, .. } => QueryReply::Steps(vec![StoredStep {
                step: 0,
                attempt: 1,
                state: "succeeded".into(),
                body: "{}".into(),
                intended: Stamp::from_nanos(DAY_NS),
                done: None,
            }]),
            Query::Steps { .. } => QueryReply::Steps(Vec::new()),
            Query::Results { run: RUN, after: None, .. } => QueryReply::Results(vec![photo()]),
            Query::Results { .. } => QueryReply::Results(Vec::new()),
            ref other => panic!("not asked for a report: {other:?}"),
        });
        asked.push(query);
        core.send(&CoreMessage::Reply { number, result }).await;
    }
    asked
}

#[tokio::test]
async fn a_report_of_a_run_is_a_file_that_loads_nothing() {
    let gateway = Gateway::start().await;
    gateway.get(&report_path(RUN), &[]).await.expect_problem(503);
    gateway.write(&format!("data/blobs/ab/{}", "ab".repeat(32)), &picture());
    let core = tokio::spawn(play(gateway.core().await, 10, 0));
    let report = gateway.get(&report_path(RUN), &[]).await;
    assert_eq!((report.status, report.header("content-type")), (200, "text/html; charset=utf-8"));
    assert_eq!(
        report.header("content-disposition"),
        "attachment; filename=\"Round__A_1970-01-02T0000.html\""
    );
    assert_eq!(report.header("cache-control"), "no-store");
    assert_eq!(report.header("content-security-policy"), POLICY);
    assert_eq!(
        (report.header("x-frame-options"), report.header("x-content-type-options")),
        ("DENY", "nosniff")
    );
    let text = String::from_utf8(report.body).expect("UTF-8");
    assert!(text.contains("<h1>Round &lt;A&gt;</h1>") && text.ends_with("</html>\n"), "{text}");
    assert!(text.contains("Europe/Paris (UTC+01:00)") && text.contains("1 of 1"), "{text}");
    let shown = text.split_once("src=\"data:image/jpeg;base64,").expect("a picture").1;
    let shown = STANDARD.decode(shown.split('"').next().expect("an end")).expect("base64");
    assert!(shown == picture(), "{} bytes of the picture", shown.len());
    gateway.get(&report_path(RunId(Uuid::from_u128(9))), &[]).await.expect_problem(404);
    gateway.get("/api/v1/runs/7/report", &[]).await.expect_problem(400);
    // The run, then attempts and results twice: first what is counted, then each task.
    let asked = core.await.expect("no panic");
    let steps = asked.iter().filter(|query| matches!(query, Query::Steps { run: RUN, .. })).count();
    let results = asked.iter().filter(|query| matches!(query, Query::Results { run: RUN, .. })).count();
    assert_eq!((&asked[0], steps, results), (&Query::Run(RUN), 4, 4));
}

#[tokio::test]
async fn a_report_of_a_time_holds_its_runs_and_asks_for_no_others() {
    let gateway = Gateway::start().await;
    let core = tokio::spawn(play(gateway.core().await, 1 + 8 + 6, 2));
    let report = gateway.get(&period_path(DAY_NS, 8 * DAY_NS), &[]).await;
    assert_eq!((report.status, report.header("content-type")), (200, "text/html; charset=utf-8"));
    assert_eq!(report.header("content-security-policy"), POLICY);
    let name = "attachment; filename=\"report_1970-01-02_to_1970-01-09.html\"";
    assert_eq!(report.header("content-disposition"), name);
    let text = String::from_utf8(report.body).expect("UTF-8");
    let [older, newer] = [1, 2].map(|number| text.find(&RunId(Uuid::from_u128(number)).to_string()));
    assert!(older.is_some() && older < newer, "the oldest run first");
    assert!(text.contains("2 of 2") && text.ends_with("</html>\n"), "{text}");
    let asked = core.await.expect("no panic");
    let Query::Runs { filter, .. } = asked[0] else { panic!("{:?}", asked[0]) };
    let at = |days: i64| Some(Stamp::from_nanos(days * DAY_NS));
    assert_eq!((filter.from, filter.to, filter.mission, filter.state), (at(1), at(8), None, None));
}

#[tokio::test]
async fn a_time_that_is_malformed_or_too_long_or_has_too_many_runs_is_refused_with_its_reason() {
    let gateway = Gateway::start().await;
    let refused = async |path: String, status: u16, reason: &str| {
        let reply = gateway.get(&path, &[]).await;
        reply.expect_problem(status);
        let detail = reply.json()["detail"].to_string();
        assert!(detail.contains(reason), "{path}: {detail}");
    };
    let query = |query: &str| format!("{}?{query}", api::paths::REPORT_PATH);
    refused(api::paths::REPORT_PATH.to_owned(), 400, "from_ns").await;
    refused(query("from_ns=5"), 400, "to_ns").await;
    refused(query("from_ns=now&to_ns=5"), 400, "from_ns").await;
    refused(query("from_ns=1&to_ns=5&state=failed"), 400, "state").await;
    refused(period_path(5, 5), 400, "to_ns is not after from_ns").await;
    refused(period_path(0, 32 * DAY_NS), 422, "31 days").await;
    refused(period_path(i64::MIN, i64::MAX), 422, "31 days").await;
    let core = tokio::spawn(play(gateway.core().await, 6 + 5, 501));
    refused(period_path(0, 31 * DAY_NS), 422, "500 runs").await;
    drop(gateway);
    core.abort();
}

#[tokio::test]
async fn a_report_ends_with_an_error_where_the_core_fails() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    send_site(&mut core).await;
    let asked = format!("GET {} HTTP/1.1\r\nhost: {}\r\n\r\n", report_path(RUN), gateway.address);
    let mut client = TcpStream::connect(gateway.address).await.expect("a connection");
    client.write_all(asked.as_bytes()).await.expect("written");
    loop {
        let GatewayMessage::Query { number, query, .. } = core.receive().await else { continue };
        let is_run = matches!(query, Query::Run(_));
        let result =
            if is_run { Ok(QueryReply::Runs(vec![run(1)])) } else { Err("The disk fails.".to_owned()) };
        core.send(&CoreMessage::Reply { number, result }).await;
        if !is_run {
            break;
        }
    }
    let mut bytes = Vec::new();
    let _ = soon("the end of the connection", client.read_to_end(&mut bytes)).await;
    assert!(!bytes.ends_with(b"\r\n0\r\n\r\n"), "a part is taken for the whole");
    gateway.stop().await;
}

#[tokio::test]
async fn few_reports_and_downloads_are_made_at_a_time() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    let mut clients = Vec::new();
    for path in [report_path(RUN), report_path(RUN), period_path(0, DAY_NS), period_path(0, DAY_NS)] {
        let asked = format!("GET {path} HTTP/1.1\r\nhost: {}\r\n\r\n", gateway.address);
        let mut client = TcpStream::connect(gateway.address).await.expect("a connection");
        client.write_all(asked.as_bytes()).await.expect("written");
        clients.push(client);
        while !matches!(core.receive().await, GatewayMessage::Query { .. }) {}
    }
    gateway.get(&report_path(RUN), &[]).await.expect_problem(503);
    gateway.get(&period_path(0, DAY_NS), &[]).await.expect_problem(503);
    drop(clients);
}
