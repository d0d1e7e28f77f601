//! Runs, results and slots from the core, and the download of a run.

use crate::support::{Gateway, TestCore};
use api::{CoreMessage, GatewayMessage, Query, QueryReply, RunFilter, StoredResult, StoredRun, StoredSlot};
use site_model::{InspectionPointId, MissionId, RunId, RunState, ScheduleId};
use uuid::Uuid;
use vocab::Stamp;

const RUN: RunId = RunId(Uuid::from_u128(1));
const POINT: InspectionPointId = InspectionPointId(Uuid::from_u128(3));
const SCHEDULE: ScheduleId = ScheduleId(Uuid::from_u128(4));

fn run() -> StoredRun {
    StoredRun {
        run: RUN,
        mission: MissionId(Uuid::from_u128(2)),
        state: "succeeded".into(),
        is_ended: true,
        body: "{}".into(),
        began: Stamp::from_nanos(5),
        changed: Stamp::from_nanos(6),
    }
}

fn result(number: u64) -> StoredResult {
    let (kind, body) = ("photo".to_owned(), "{}".to_owned());
    StoredResult {
        number,
        run: RUN,
        step: 0,
        attempt: 1,
        kind,
        blob: None,
        body,
        comparison: None,
        at: Stamp::from_nanos(7),
    }
}

/// Answers questions until the gateway ends. Returns them.
async fn play(mut core: TestCore, questions: usize) -> Vec<Query> {
    let mut asked = Vec::new();
    while asked.len() < questions {
        let GatewayMessage::Query { number, query, .. } = core.receive().await else { continue };
        let result = Ok(match query {
            Query::Runs { .. } => QueryReply::Runs(vec![run()]),
            Query::Run(id) => QueryReply::Runs((id == RUN).then(run).into_iter().collect()),
            Query::Steps { .. } => QueryReply::Steps(Vec::new()),
            Query::Results { after, .. } => {
                QueryReply::Results(after.is_none().then(|| result(8)).into_iter().collect())
            }
            Query::PointResults { before, .. } => QueryReply::Results(vec![result(before.unwrap_or(9) - 1)]),
            Query::PictureComparison { before, .. } => {
                let found = (before == 3).then(|| "{\"before\":3}".to_owned());
                QueryReply::PictureComparison(found)
            }
            Query::Audit { .. } => QueryReply::Audit(Vec::new()),
            Query::Slots { .. } => QueryReply::Slots(vec![StoredSlot {
                schedule: SCHEDULE,
                due: Stamp::from_nanos(5),
                run: None,
                outcome: "queue_full".into(),
                body: "{}".into(),
            }]),
            Query::Revisions { .. } => QueryReply::Revisions(Vec::new()),
        });
        asked.push(query);
        core.send(&CoreMessage::Reply { number, result }).await;
    }
    asked
}

#[tokio::test]
async fn lists_are_filtered_by_the_core_and_go_on_where_a_page_ends() {
    let gateway = Gateway::start().await;
    let core = tokio::spawn(play(gateway.core().await, 3));
    let mission = MissionId(Uuid::from_u128(2));
    let path = format!("/api/v1/runs?mission={mission}&state=failed&from_ns=5&to_ns=9&limit=1");
    let runs = gateway.get(&path, &[]).await.json();
    assert_eq!(runs["next"], RUN.to_string(), "a full page");
    let path = format!("/api/v1/inspection-points/{POINT}/results?before=8&limit=1");
    let results = gateway.get(&path, &[]).await.json();
    assert_eq!((&results["items"][0]["number"], &results["next"]), (&7.into(), &"7".into()));
    assert_eq!(results["items"][0]["run"], RUN.to_string());
    let path = format!("/api/v1/slots?before=5.{SCHEDULE}");
    let slots = gateway.get(&path, &[]).await.json();
    assert_eq!((&slots["items"][0]["outcome"], &slots["next"]), (&"queue_full".into(), &().into()));
    let asked = core.await.expect("no panic");
    let at = |nanos| Some(Stamp::from_nanos(nanos));
    let filter = RunFilter { mission: Some(mission), state: Some(RunState::Failed), from: at(5), to: at(9) };
    assert_eq!(
        asked,
        [
            Query::Runs { filter, before: None, limit: 1 },
            Query::PointResults { point: POINT, before: Some(8), limit: 1 },
            Query::Slots { before: Some((Stamp::from_nanos(5), SCHEDULE)), limit: 100 },
        ]
    );
    for path in ["/api/v1/slots?before=5", "/api/v1/runs?state=well", "/api/v1/inspection-points/7/results"] {
        gateway.get(path, &[]).await.expect_problem(400);
    }
}

#[tokio::test]
async fn two_photos_are_compared_when_somebody_asks() {
    let gateway = Gateway::start().await;
    let core = tokio::spawn(play(gateway.core().await, 2));
    let answer = gateway.get("/api/v1/picture-comparison?before=3&after=7", &[]).await.json();
    assert_eq!(answer["before"], 3);
    gateway.get("/api/v1/picture-comparison?before=4&after=7", &[]).await.expect_problem(404);
    gateway.get("/api/v1/picture-comparison?before=4", &[]).await.expect_problem(400);
    let asked = core.await.expect("no panic");
    assert_eq!(asked[0], Query::PictureComparison { before: 3, after: 7 });
}

#[tokio::test]
async fn a_run_is_downloaded_as_one_archive() {
    let gateway = Gateway::start().await;
    let path = |run: RunId| api::paths::RUN_DOWNLOAD_PATH.replace("{run}", &run.to_string());
    gateway.get(&path(RUN), &[]).await.expect_problem(503);
    let core = tokio::spawn(play(gateway.core().await, 9));
    let archive = gateway.get(&path(RUN), &[]).await;
    assert_eq!((archive.status, archive.header("content-type")), (200, "application/zip"));
    let name = "attachment; filename=\"run_1970-01-01T0000.zip\"";
    assert_eq!(archive.header("content-disposition"), name);
    let text = String::from_utf8_lossy(&archive.body);
    for file in ["run.json", "steps.json", "results.json", "readings.csv"] {
        assert!(text.contains(&format!("run_1970-01-01T0000/{file}")), "{file}");
    }
    assert!(archive.body.starts_with(b"PK\x03\x04"));
    gateway.get(&path(RunId(Uuid::from_u128(9))), &[]).await.expect_problem(404);
    assert_eq!(core.await.expect("no panic").len(), 9);
}

#[tokio::test]
async fn each_mistake_in_a_request_of_a_run_is_named_and_the_core_hears_of_none() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    let (mission, task) = (Uuid::from_u128(2), Uuid::from_u128(5));
    let command = format!("/api/v1/runs/{RUN}/commands");
    let start =
        |document: &str| ("/api/v1/runs".to_owned(), document.replace("MISSION", &mission.to_string()));
    let case = |document: &str| (command.clone(), document.replace("TASK", &task.to_string()));
    let cases = [
        (start(""), ""),
        (start("{"), ""),
        (start("[]"), ""),
        (start(r#"{"mode": "now"}"#), "/mission"),
        (start(r#"{"mission": "round", "mode": "now"}"#), "/mission"),
        (start(r#"{"mission": 7, "mode": "now"}"#), "/mission"),
        (start(r#"{"mission": "MISSION"}"#), "/mode"),
        (start(r#"{"mission": "MISSION", "mode": "soon"}"#), "/mode"),
        (start(r#"{"mission": "MISSION", "mode": "now", "id": "first"}"#), "/id"),
        (start(r#"{"mission": "MISSION", "mode": "now", "at": 5}"#), "/at"),
        (start(r#"{"mission": "MISSION", "mode": "now"} {}"#), ""),
        (case(r#""pause""#), "/pause"),
        (case(r#"{"dance": {}}"#), ""),
        (case(r#"{"pause": {"for_s": 5}}"#), "/pause/for_s"),
        (case(r#"{"skip_task": {}}"#), "/skip_task/task"),
        (case(r#"{"redo_task": {"task": 3}}"#), "/redo_task/task"),
        (case(r#"{"answer": {"task": "TASK"}}"#), "/answer/answer"),
        (case(r#"{"answer": {"task": "TASK", "answer": "perhaps"}}"#), "/answer/answer"),
    ];
    for ((path, document), pointer) in cases {
        let length = format!("content-length: {}", document.len());
        let reply = gateway.send("POST", &path, &[&length], document.as_bytes()).await;
        reply.expect_problem(400);
        let problem = reply.json();
        assert_eq!(problem["errors"][0]["pointer"], pointer, "{document}: {problem}");
    }
    for (query, field) in [("state=well", "state"), ("limit=many", "limit"), ("mission=round", "mission")] {
        let reply = gateway.get(&format!("/api/v1/runs?{query}"), &[]).await;
        reply.expect_problem(400);
        let detail = reply.json()["detail"].to_string();
        assert!(detail.contains(field), "{query}: {detail}");
    }
    gateway
        .send("POST", "/api/v1/runs/round/commands", &["content-length: 13"], b"{\"pause\": {}}")
        .await
        .expect_problem(400);
    // What the core hears first is the right one.
    let (path, document) = case(r#"{"pause": {}}"#);
    let asked = async {
        let length = format!("content-length: {}", document.len());
        gateway.send("POST", &path, &[&length], document.as_bytes()).await
    };
    let heard = async {
        let GatewayMessage::Command { command, .. } = core.command().await else { panic!("another message") };
        drop(core);
        command
    };
    let (_, command) = tokio::join!(asked, heard);
    let expected = api::Command::Mission(site_model::MissionCommandKind::Pause(RUN));
    assert_eq!(command, expected);
}
