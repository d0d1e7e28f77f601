//! Runs in the panel.

use crate::screens;
use crate::test_support::{TestClient, click, value};
use api::{Event, SiteParts, SiteState};
use client_model::{ClientCommand, ClientEvent, ClientTime, RunContent, RunQuery, SiteEdit};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use site_model::{
    ActionRequest, EditId, EndedRun, InspectionPoint, InspectionPointId, Mission, MissionCommandKind,
    MissionId, MissionStatus, Node, NodeId, NodeKind, Object, PoseTolerance, QuestionAnswer, ReachFailure,
    ReadingLimits, RunCause, RunId, RunState, RunStatus, Site, Task, TaskFailure, TaskId, TaskPlace,
    TaskState, TaskStatus,
};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{CommandId, Pose, Vec3};

const MISSION: MissionId = MissionId(Uuid::from_u128(11));
const RUN: RunId = RunId(Uuid::from_u128(12));
const NAMES: [&str; 5] = ["Pump hall", "Cable tray", "Gauge east", "Tank", "Door east"];

fn node_id(index: usize) -> NodeId {
    NodeId(Uuid::from_u128(100 + index as u128))
}

fn task_id(index: usize) -> TaskId {
    TaskId(Uuid::from_u128(200 + index as u128))
}

fn site() -> Site {
    let nodes = NAMES.iter().enumerate().map(|(index, name)| {
        Object::Node(Node {
            id: node_id(index),
            name: (*name).to_owned(),
            kind: NodeKind::Inspection,
            map_from_node: Pose::IDENTITY,
            anchor: None,
            tolerance: PoseTolerance::default(),
            influence_area_m: Vec::new(),
            floor: 0,
            tags: Default::default(),
            properties: Default::default(),
        })
    });
    let photo = || ActionRequest { action: "photo".into(), parameters: Default::default() };
    let tasks = (0..NAMES.len()).map(|index| Task {
        id: task_id(index),
        place: TaskPlace::Node { node: node_id(index), request: Some(photo()) },
        on_unreachable: Default::default(),
        on_action_failure: Default::default(),
    });
    let mission = Mission {
        id: MISSION,
        name: "Round A".into(),
        tasks: tasks.collect(),
        order: Default::default(),
        order_constraints: Vec::new(),
        end: Default::default(),
    };
    let mut site = Site::default();
    for (number, object) in nodes.chain([Object::Mission(mission)]).enumerate() {
        let id = EditId(Uuid::from_u128(number as u128));
        let edit = site.put(id, object);
        site.apply(&edit, id).unwrap();
    }
    site
}

fn run(state: RunState, tasks: [TaskState; 5]) -> RunStatus {
    let task = |(index, state): (usize, TaskState)| TaskStatus {
        task: task_id(index),
        node: Some(node_id(index)),
        action: Some("photo".into()),
        state,
        attempt: 1,
        failure: matches!(state, TaskState::Failed | TaskState::Retriable)
            .then_some(TaskFailure::NotReached(ReachFailure::PathBlocked)),
    };
    RunStatus {
        run: RUN,
        mission: MISSION,
        cause: RunCause::Account { command: CommandId(Uuid::nil()), account: "anna".to_owned() },
        state,
        outcome: None,
        began: None,
        tasks: tasks.into_iter().enumerate().map(task).collect(),
        question: None,
    }
}

const TASK_STATES: [TaskState; 5] =
    [TaskState::Succeeded, TaskState::Failed, TaskState::Navigating, TaskState::Waiting, TaskState::Waiting];

pub(super) fn client(status: MissionStatus) -> TestClient {
    let state = SiteState { site: site(), ..SiteState::default() };
    TestClient::connected()
        .event(Event::SitePart(SiteParts::new(Arc::new(state)).next_part()))
        .event(Event::Missions(status))
        .on(screens::RUNS)
}

fn running() -> MissionStatus {
    MissionStatus { runs: vec![run(RunState::Running, TASK_STATES)], ..MissionStatus::default() }
}

fn asked(harness: &Harness<'_, TestClient>, kind: MissionCommandKind) -> bool {
    harness.state().emitted(&ClientCommand::Run(kind))
}

#[test]
fn the_active_run_shows_each_task_with_its_state_in_words() {
    let harness = client(running()).shown(1440.0, 900.0);
    for name in ["Pump hall, done", "Cable tray, failed", "Gauge east, on the way", "Tank, waiting"] {
        assert!(harness.query_by_label(name).is_some(), "{name}");
    }
    assert!(value(&harness, "Progress").starts_with("2 of 5"), "{}", value(&harness, "Progress"));
}

#[test]
fn a_run_is_paused_resumed_cancelled_and_a_task_skipped_and_done_again() {
    let mut harness = client(running()).shown(1440.0, 900.0);
    click(&mut harness, "Pause");
    assert!(asked(&harness, MissionCommandKind::Pause(RUN)));
    click(&mut harness, "Skip task");
    assert!(asked(&harness, MissionCommandKind::SkipTask(RUN, task_id(2))));
    click(&mut harness, "Cancel run");
    assert!(asked(&harness, MissionCommandKind::Cancel(RUN)));
    click(&mut harness, "Cable tray, failed");
    assert!(harness.query_by_label("The path stayed blocked.").is_some());
    click(&mut harness, "Redo task Cable tray");
    assert!(asked(&harness, MissionCommandKind::RedoTask(RUN, task_id(1))));
    click(&mut harness, "Tank, waiting");
    click(&mut harness, "Skip task Tank");
    assert!(asked(&harness, MissionCommandKind::SkipTask(RUN, task_id(3))));

    let paused = MissionStatus { runs: vec![run(RunState::Paused, TASK_STATES)], ..MissionStatus::default() };
    let mut harness = client(paused).shown(1440.0, 900.0);
    click(&mut harness, "Resume");
    assert!(asked(&harness, MissionCommandKind::Resume(RUN)));
}

#[test]
fn to_abort_is_asked_once_more_and_escape_takes_it_back_without_a_stop() {
    let mut harness = client(running()).shown(1440.0, 900.0);
    click(&mut harness, "Abort…");
    assert!(!asked(&harness, MissionCommandKind::Abort(RUN)));
    harness.key_press(egui::Key::Escape);
    harness.run_steps(2);
    assert!(harness.query_by_label("Abort run").is_none());
    assert!(!harness.state().emitted(&ClientCommand::StopMotion));
    click(&mut harness, "Abort…");
    click(&mut harness, "Abort run");
    assert!(asked(&harness, MissionCommandKind::Abort(RUN)));
}

#[test]
fn a_question_is_answered_and_told_on_every_other_screen() {
    let mut asking = running();
    asking.runs[0].tasks[2].state = TaskState::Retriable;
    asking.runs[0].tasks[2].failure = Some(TaskFailure::NotReached(ReachFailure::PathBlocked));
    asking.runs[0].question = Some(task_id(2));
    let mut harness = client(asking.clone()).shown(1440.0, 900.0);
    assert!(harness.query_by_label("Gauge east: The path stayed blocked. What now?").is_some());
    click(&mut harness, "End at a dock");
    assert!(asked(&harness, MissionCommandKind::Answer(RUN, task_id(2), QuestionAnswer::EndAtDock)));
    let mut harness = client(asking).on(screens::MAP).shown(1440.0, 900.0);
    click(&mut harness, "Answer");
    assert!(harness.state().emitted(&ClientCommand::ShowScreen(screens::RUNS)));
}

#[test]
fn a_mission_is_started_where_none_runs_and_the_queue_is_shortened() {
    let mut harness = client(MissionStatus::default()).shown(1440.0, 900.0);
    click(&mut harness, "Run Round A");
    assert!(harness.state().emitted(&ClientCommand::StartMission { mission: MISSION, is_queued: false }));
    let mut queued = run(RunState::Queued, TASK_STATES);
    queued.tasks.clear();
    let mut harness =
        client(MissionStatus { runs: vec![queued], ..MissionStatus::default() }).shown(1440.0, 900.0);
    click(&mut harness, "Remove Round A from the queue");
    assert!(asked(&harness, MissionCommandKind::Cancel(RUN)));
}

#[test]
fn ended_runs_are_listed_filtered_and_opened_with_what_was_gathered() {
    let ended = |run, outcome| EndedRun { run, mission: MISSION, outcome };
    let other = RunId(Uuid::from_u128(77));
    let ended = vec![ended(other, RunState::Failed), ended(RUN, RunState::Succeeded)];
    let status = MissionStatus { ended, ..MissionStatus::default() };
    let mut harness = client(status).shown(1440.0, 900.0);
    click(&mut harness, "History");
    let failed = "Round A, Failed, Ended a moment ago";
    assert!(harness.query_by_label(failed).is_some());
    click(&mut harness, "Round A, Succeeded, Ended a moment ago");
    assert!(harness.state().emitted(&ClientCommand::OpenRun(RUN)));
    let attempt = format!(
        r#"{{ "step": 4, "attempt": 1, "state": "succeeded", "intended_ns": 0, "done_ns": 42000000000,
            "details": {{ "task": "{}", "node": "{}", "action": "gamma_spectrum" }} }}"#,
        task_id(4),
        node_id(4)
    );
    let result = r#"{ "number": 1, "run": "00000000-0000-0000-0000-00000000000c", "at_ns": 3, "step": 4, "attempt": 1, "details": { "value": {
        "at": { "robot_time": 0, "utc_ns": 3, "is_synchronised": true },
        "readings": [{ "name": "dose_rate", "value": 0.11, "standard_deviation": 0.02, "unit": "µSv/h" }] } } }"#;
    let content = RunContent {
        attempts: vec![serde_json::from_str(&attempt).unwrap()],
        results: vec![serde_json::from_str(result).unwrap()],
    };
    let event = ClientEvent::RunFetched { run: RUN, result: Ok(content) };
    harness.state_mut().model.handle_event(ClientTime(2.0), event, &mut Vec::new());
    harness.run_steps(2);
    assert!(harness.query_by_label("Door east, done").is_some());
    assert_eq!(value(&harness, "Dose rate"), "0.11 ± 0.02 µSv/h");

    // The limits of its inspection point judge it.
    let point = InspectionPoint {
        id: InspectionPointId(Uuid::from_u128(40)),
        name: "Door".into(),
        asset: None,
        node: node_id(4),
        target_m: Vec3::default(),
        request: ActionRequest { action: "gamma_spectrum".into(), parameters: Default::default() },
        limits: Some(ReadingLimits { min: None, max: Some(0.1), unit: "µSv/h".into() }),
        gauge: None,
    };
    let with_point = result.replace(
        r#""details": { "value""#,
        &format!(r#""details": {{ "inspection_point": "{}", "value""#, point.id),
    );
    let edit = SiteEdit { put: vec![Object::InspectionPoint(point)], removed: Vec::new() };
    let event = ClientEvent::Command(ClientCommand::EditSite(edit));
    harness.state_mut().model.handle_event(ClientTime(2.0), event, &mut Vec::new());
    let content = RunContent {
        attempts: vec![serde_json::from_str(&attempt).unwrap()],
        results: vec![serde_json::from_str(&with_point).unwrap()],
    };
    let event = ClientEvent::RunFetched { run: RUN, result: Ok(content) };
    harness.state_mut().model.handle_event(ClientTime(3.0), event, &mut Vec::new());
    harness.run_steps(2);
    assert_eq!(value(&harness, "Dose rate"), "0.11 ± 0.02 µSv/h, above 0.10 µSv/h");
}

/// Presses a button. Returns the addresses that are opened.
fn opened(harness: &mut Harness<'_, TestClient>, name: &str) -> Vec<String> {
    harness.get_by_label(name).click();
    let mut addresses = Vec::new();
    for _ in 0..3 {
        harness.step();
        for command in &harness.output().platform_output.commands {
            if let egui::OutputCommand::OpenUrl(open) = command {
                assert!(open.new_tab, "an error would replace this page");
                addresses.push(open.url.clone());
            }
        }
    }
    addresses
}

#[test]
fn the_archive_and_the_reports_are_fetched_as_files() {
    let ended = vec![EndedRun { run: RUN, mission: MISSION, outcome: RunState::Succeeded }];
    let status = MissionStatus { ended, ..MissionStatus::default() };
    let mut harness = client(status).shown(1440.0, 900.0);
    click(&mut harness, "History");
    click(&mut harness, "Round A, Succeeded, Ended a moment ago");
    let [download, report, mcap, week] =
        ["Download the run", "Report", "Download for Foxglove", "Report of the week"]
            .map(|name| harness.get_by_label(name).rect());
    assert!(download.right() < report.left() && report.right() < mcap.left(), "beside each other");
    assert!(mcap.right() <= week.right() + 0.5);
    assert_eq!(download.y_range(), mcap.y_range());
    let run = format!("/api/v1/runs/{RUN}");
    assert_eq!(opened(&mut harness, "Report"), [format!("{run}/report")]);
    assert_eq!(opened(&mut harness, "Download the run"), [format!("{run}/download")]);
    assert_eq!(opened(&mut harness, "Download for Foxglove"), [format!("{run}/mcap")]);
    let week_ns = 604_800_000_000_000;
    harness.state_mut().panels.clock.utc = site_model::Utc(week_ns + 5);
    let address = format!("/api/v1/report?from_ns=5&to_ns={}", week_ns + 5);
    assert_eq!(opened(&mut harness, "Report of the week"), [address]);
}

#[test]
fn a_run_that_is_blocked_says_by_what_and_runs_fit_a_tablet() {
    let blocked_by = Some(site_model::MonitorId(Uuid::from_u128(5)));
    let status = MissionStatus { blocked_by, ..MissionStatus::default() };
    let mut harness = client(status).shown(1024.0, 768.0);
    click(&mut harness, "Open panel");
    assert!(harness.query_by_label_contains("keeps missions from beginning").is_some());
}

#[test]
fn live_shows_the_run_in_short() {
    let mut harness = client(running()).on(screens::LIVE).shown(1440.0, 900.0);
    assert!(harness.query_by_label("Gauge east, on the way").is_some());
    assert!(harness.query_by_label("Tank, waiting").is_none(), "what comes later is on the Runs screen");
    click(&mut harness, "Show the run");
    assert!(harness.state().emitted(&ClientCommand::ShowScreen(screens::RUNS)));
    let harness = client(MissionStatus::default()).on(screens::LIVE).shown(1440.0, 900.0);
    assert!(harness.query_by_label("Show the run").is_none());
}

fn photo_result(number: u64, blob: &str) -> String {
    format!(
        r#"{{ "number": {number}, "run": "00000000-0000-0000-0000-00000000000c", "at_ns": {number}000000000000, "step": {step}, "attempt": 1, "kind": "photo",
            "details": {{ "inspection_point": "00000000-0000-0000-0000-0000000001f4", "value": {{
                "at": {{ "robot_time": 0, "utc_ns": 3, "is_synchronised": true }},
                "files": [{{ "name": "photo.jpg", "media_type": "image/jpeg", "blob": "{hash}", "bytes": 5 }}] }} }} }}"#,
        step = number - 1,
        hash = blob.repeat(32),
    )
}

/// The history with an open run of two pictures.
fn with_pictures() -> Harness<'static, TestClient> {
    let ended = vec![EndedRun { run: RUN, mission: MISSION, outcome: RunState::Succeeded }];
    let status = MissionStatus { ended, ..MissionStatus::default() };
    let mut harness = client(status).shown(1440.0, 900.0);
    click(&mut harness, "History");
    click(&mut harness, "Round A, Succeeded, Ended a moment ago");
    let attempt = |index: usize| {
        format!(
            r#"{{ "step": {index}, "attempt": 1, "state": "succeeded", "intended_ns": 0, "done_ns": 42000000000,
                "details": {{ "task": "{}", "node": "{}", "action": "photo" }} }}"#,
            task_id(index),
            node_id(index)
        )
    };
    let content = RunContent {
        attempts: (0..2).map(|index| serde_json::from_str(&attempt(index)).unwrap()).collect(),
        results: [(1, "aa"), (2, "bb")]
            .map(|(number, blob)| serde_json::from_str(&photo_result(number, blob)).unwrap())
            .into(),
    };
    let event = ClientEvent::RunFetched { run: RUN, result: Ok(content) };
    harness.state_mut().model.handle_event(ClientTime(2.0), event, &mut Vec::new());
    harness.run_steps(2);
    harness
}

/// Opens a picture. A new layer is drawn in the second frame.
fn show_large(harness: &mut Harness<'_, TestClient>, name: &str) {
    click(harness, name);
    harness.run_steps(3);
}

#[test]
fn a_picture_is_shown_large_arrows_go_on_and_escape_closes_without_a_stop() {
    let mut harness = with_pictures();
    let wanted = harness.state_mut().panels.files.take_wanted();
    assert_eq!(wanted.iter().map(|(blob, _)| blob.0[0]).collect::<Vec<_>>(), [0xaa, 0xbb]);
    for (blob, _) in wanted {
        let image = egui::ColorImage::filled([64, 48], egui::Color32::RED);
        let ctx = harness.ctx.clone();
        harness.state_mut().panels.files.insert(&ctx, blob, Ok(crate::ResultFileContent::Picture(image)));
    }
    show_large(&mut harness, "Show photo.jpg of Pump hall");
    assert_eq!(value(&harness, "Picture"), "1 of 2: Pump hall, Photo");
    harness.key_press(egui::Key::ArrowRight);
    harness.run_steps(2);
    assert_eq!(value(&harness, "Picture"), "2 of 2: Cable tray, Photo");
    harness.key_press(egui::Key::ArrowRight);
    harness.run_steps(2);
    assert_eq!(value(&harness, "Picture"), "2 of 2: Cable tray, Photo", "it is the last one");
    click(&mut harness, "Previous picture");
    assert_eq!(value(&harness, "Picture"), "1 of 2: Pump hall, Photo");
    let drives = |command: &ClientCommand| matches!(command, ClientCommand::SetVelocity(_));
    assert!(!harness.state().commands.iter().any(drives), "arrow keys do not drive");
    harness.key_press(egui::Key::Escape);
    harness.run_steps(2);
    assert!(harness.query_by_label("Close the pictures").is_none());
    assert!(!harness.state().emitted(&ClientCommand::StopMotion));
}

#[test]
fn a_picture_is_compared_with_the_one_before_at_its_inspection_point() {
    let mut harness = with_pictures();
    show_large(&mut harness, "Show photo.jpg of Cable tray");
    let point = InspectionPointId(Uuid::from_u128(500));
    let asked = ClientCommand::OpenPrevious { point, before: 2 };
    assert!(!harness.state().emitted(&asked));
    click(&mut harness, "With the last one");
    assert!(harness.state().emitted(&asked));
    let earlier = serde_json::from_str(&photo_result(1, "cc")).unwrap();
    let event = ClientEvent::PreviousFetched { point, before: 2, result: Ok(Some(earlier)) };
    harness.state_mut().model.handle_event(ClientTime(2.0), event, &mut Vec::new());
    harness.run_steps(2);
    let wanted = harness.state_mut().panels.files.take_wanted();
    assert!(wanted.iter().any(|(blob, _)| blob.0[0] == 0xcc), "its picture is fetched: {wanted:?}");
}

#[test]
fn the_history_is_filtered_by_mission_outcome_and_days() {
    let mut harness = client(MissionStatus::default()).shown(1440.0, 900.0);
    click(&mut harness, "History");
    click(&mut harness, "Outcome");
    harness.key_press(egui::Key::Escape);
    harness.run_steps(3);
    assert!(harness.query_by_label("Cancelled").is_none(), "the list is closed");
    assert!(!harness.state().emitted(&ClientCommand::StopMotion), "and nothing is stopped");
    click(&mut harness, "Outcome");
    click(&mut harness, "Cancelled");
    click(&mut harness, "Mission");
    click(&mut harness, "Round A");
    let listed: Vec<_> = harness.state().commands.clone();
    let query =
        RunQuery { mission: Some(MISSION), outcome: Some(RunState::Cancelled), ..RunQuery::default() };
    assert!(listed.contains(&ClientCommand::ListRuns(query)), "{listed:?}");
    click(&mut harness, "Show all");
    assert!(harness.query_by_label("Show all").is_none());
}

#[test]
fn slots_that_were_skipped_stand_between_the_runs_with_the_reason() {
    let page = serde_json::from_str(
        r#"{ "items": [{
            "schedule": "00000000-0000-0000-0000-000000000063", "due_ns": 1795532400000000000, "run": null, "outcome": "queue_full",
            "details": {
                "slot": { "date": { "year": 2026, "month": 11, "day": 24 }, "time": { "hour": 11, "minute": 0 } },
                "decision": { "skipped": "queue_full" } }
        }] }"#,
    )
    .unwrap();
    let mut harness = client(MissionStatus::default()).shown(1440.0, 900.0);
    let event = ClientEvent::SlotsListed(Ok(page));
    harness.state_mut().model.handle_event(ClientTime(2.0), event, &mut Vec::new());
    click(&mut harness, "History");
    let facts = "24 Nov, 11:00 · Deleted schedule: the queue was full";
    assert!(harness.query_by_label(&format!("Deleted mission, Skipped, {facts}")).is_some());
}

#[test]
fn pictures_of_the_active_run_are_shown_as_they_come() {
    let mut harness = client(running()).shown(1440.0, 900.0);
    assert!(harness.query_by_label("Show photo.jpg of Pump hall").is_none());
    let attempt = format!(
        r#"{{ "step": 0, "attempt": 1, "state": "succeeded", "intended_ns": 0, "done_ns": 42000000000,
            "details": {{ "task": "{}", "node": "{}", "action": "photo" }} }}"#,
        task_id(0),
        node_id(0)
    );
    let content = RunContent {
        attempts: vec![serde_json::from_str(&attempt).unwrap()],
        results: vec![serde_json::from_str(&photo_result(1, "aa")).unwrap()],
    };
    let event = ClientEvent::RunFetched { run: RUN, result: Ok(content) };
    harness.state_mut().model.handle_event(ClientTime(2.0), event, &mut Vec::new());
    harness.run_steps(2);
    show_large(&mut harness, "Show photo.jpg of Pump hall");
    assert_eq!(value(&harness, "Picture"), "1 of 1: Pump hall, Photo");
}
