//! Runs as the robot reports them, and what is asked of them.

use super::*;
use crate::testing::TestClient;
use api::Event;
use site_model::{
    EdgeId, EdgeStage, EndedRun, LocalDate, LocalTime, MissionId, RouteActionPlace, RouteProgress, TaskId,
    TaskState, TaskStatus,
};
use std::collections::BTreeSet;
use uuid::Uuid;
use vocab::GoalId;

const MISSION: MissionId = MissionId(Uuid::from_u128(1));
const RUN: RunId = RunId(Uuid::from_u128(2));
const SCHEDULE: ScheduleId = ScheduleId(Uuid::from_u128(3));

fn slot() -> LocalDateTime {
    LocalDateTime {
        date: LocalDate { year: 2026, month: 11, day: 24 },
        time: LocalTime { hour: 11, minute: 0 },
    }
}

fn task(number: u128, state: TaskState) -> TaskStatus {
    let task = TaskId(Uuid::from_u128(number));
    TaskStatus { task, node: None, action: None, state, attempt: 1, failure: None }
}

fn run(state: RunState) -> RunStatus {
    RunStatus {
        run: RUN,
        mission: MISSION,
        cause: RunCause::Schedule { schedule: SCHEDULE, slot: slot() },
        state,
        outcome: None,
        began: None,
        tasks: vec![
            task(1, TaskState::Succeeded),
            task(2, TaskState::Navigating),
            task(3, TaskState::Waiting),
        ],
        question: None,
    }
}

fn fetches() -> [ClientEffect; 2] {
    let query = RunQuery::default();
    [ClientEffect::FetchRuns { query, before: None }, ClientEffect::FetchSlots]
}

#[test]
fn a_run_is_followed_from_the_queue_to_its_outcome() {
    let mut client = TestClient::connected();
    assert!(client.model.runs.status().is_none());
    let queued = MissionStatus { runs: vec![run(RunState::Queued)], ..MissionStatus::default() };
    client.event(Event::Missions(queued));
    assert_eq!((client.model.runs.current(), client.model.runs.queue().count()), (None, 1));
    let running = MissionStatus { runs: vec![run(RunState::Running)], ..MissionStatus::default() };
    client.event(Event::Missions(running));
    assert_eq!(client.model.runs.current().map(|run| run.run), Some(RUN));
    assert_eq!(client.model.runs.slot(SCHEDULE, slot()), Some(RunState::Running));
    let ended = EndedRun { run: RUN, mission: MISSION, outcome: RunState::PartiallySucceeded };
    client.event(Event::Missions(MissionStatus { ended: vec![ended], ..MissionStatus::default() }));
    let past: Vec<_> = client.model.runs.past().collect();
    assert_eq!(past[0].report.map(|report| report.tasks.len()), Some(3), "its tasks are kept");
    assert_eq!(client.model.runs.slot(SCHEDULE, slot()), Some(RunState::PartiallySucceeded));
    client.lose_connection();
    client.wait(10.0);
    client.connect();
    assert!(client.model.runs.status().is_none(), "another snapshot comes");
}

#[test]
fn what_the_operator_asks_is_sent_with_ids_of_its_own() {
    let mut client = TestClient::connected();
    client.command(ClientCommand::StartMission { mission: MISSION, is_queued: false });
    client.command(ClientCommand::StartMission { mission: MISSION, is_queued: true });
    client.command(ClientCommand::Run(MissionCommandKind::Pause(RUN)));
    let commands = client.take_commands();
    let starts: Vec<_> = commands
        .iter()
        .filter_map(|command| match command {
            Command::Mission(MissionCommandKind::Start { run, mode, .. }) => Some((*run, *mode)),
            _ => None,
        })
        .collect();
    assert_eq!(starts.iter().map(|start| start.1).collect::<Vec<_>>(), [StartMode::Now, StartMode::Queue]);
    assert_ne!(starts[0].0, starts[1].0);
    assert!(commands.contains(&Command::Mission(MissionCommandKind::Pause(RUN))));
}

#[test]
fn the_remaining_time_counts_what_is_left() {
    let ids: Vec<TaskId> = (1..4).map(|number| TaskId(Uuid::from_u128(number))).collect();
    let estimate = RunEstimate {
        tasks_s: ids.iter().map(|id| (*id, 60.0)).collect(),
        actions_s: ids.iter().map(|id| (*id, 10.0)).collect(),
        end_s: 30.0,
    };
    let mut route = RouteStatus::default();
    assert_eq!(estimate.remaining_s(&run(RunState::Running), &route), 60.0 + 60.0 + 30.0);
    route.route = Some(RouteProgress {
        goal: GoalId(Uuid::nil()),
        target: NodeId(Uuid::nil()),
        edges: Vec::new(),
        remaining_s: 20.0,
        remaining_m: 15.0,
        waits_for: None,
    });
    assert_eq!(estimate.remaining_s(&run(RunState::Running), &route), 20.0 + 10.0 + 60.0 + 30.0);
}

#[test]
fn a_file_of_a_result_is_fetched_as_a_view_asks_for_it() {
    let mut client = TestClient::connected();
    let (blob, kind) = (vocab::BlobHash([7; 32]), ResultFileKind::Temperatures);
    client.command(ClientCommand::FetchResultFile { blob, kind });
    assert_eq!(client.take_effects(), [ClientEffect::FetchResultFile { blob, kind }]);
}

#[test]
fn stored_runs_are_fetched_when_one_has_ended_and_their_slots_are_known() {
    let mut client = TestClient::connected();
    client.event(Event::Missions(MissionStatus::default()));
    assert_eq!(client.take_effects(), fetches());
    let running = MissionStatus { runs: vec![run(RunState::Running)], ..MissionStatus::default() };
    client.event(Event::Missions(running));
    assert_eq!(client.take_effects(), [ClientEffect::FetchRun(RUN)], "nothing has ended");
    let ended = EndedRun { run: RUN, mission: MISSION, outcome: RunState::Succeeded };
    client.event(Event::Missions(MissionStatus { ended: vec![ended], ..MissionStatus::default() }));
    assert_eq!(client.take_effects(), fetches());
    // As the gateway answers.
    let page: StoredPage<StoredRun> = serde_json::from_str(
        r#"{ "items": [{
            "run": "00000000-0000-0000-0000-000000000002", "mission": "00000000-0000-0000-0000-000000000001",
            "state": "partially_succeeded", "is_ended": true, "asked_ns": 5, "changed_ns": 9,
            "details": {
                "cause": { "schedule": { "schedule": "00000000-0000-0000-0000-000000000003",
                    "slot": { "date": { "year": 2026, "month": 11, "day": 23 }, "time": { "hour": 11, "minute": 0 } } } },
                "began": 7, "tasks": 3, "outcome": null, "revisions": null }
        }], "next": null }"#,
    )
    .unwrap();
    client.apply(ClientEvent::RunsListed { query: RunQuery::default(), before: None, result: Ok(page) });
    let monday = LocalDateTime { date: LocalDate { day: 23, ..slot().date }, ..slot() };
    assert_eq!(client.model.runs.slot(SCHEDULE, monday), Some(RunState::PartiallySucceeded));
    let past: Vec<_> = client.model.runs.past().collect();
    assert_eq!(past.len(), 1, "each run once");
    assert_eq!((past[0].began, past[0].ended), (Some(Utc(7)), Some(Utc(9))));
}

#[test]
fn what_is_stored_of_a_run_is_read_as_the_gateway_writes_it() {
    let attempts: StoredPage<StoredAttempt> = serde_json::from_str(
        r#"{ "items": [
            { "step": 0, "attempt": 1, "state": "retriable", "intended_ns": 1, "done_ns": null,
              "details": { "task": "00000000-0000-0000-0000-000000000001", "node": null, "action": "photo", "step": "waits", "utc": 1 } },
            { "step": 0, "attempt": 2, "state": "succeeded", "intended_ns": 2, "done_ns": 3,
              "details": { "task": "00000000-0000-0000-0000-000000000001", "node": null, "action": "photo", "step": "succeeded", "utc": 3 } },
            { "step": 1, "attempt": 1, "state": "succeeded", "intended_ns": 4, "done_ns": 5,
              "details": { "place": { "edge": { "edge": "00000000-0000-0000-0000-000000000007", "stage": "enter", "index": 0 } }, "task": null,
                "action": "open", "step": "succeeded", "utc": 5, "map_from_base": null } }
        ], "next": null }"#,
    )
    .unwrap();
    let results: StoredPage<StoredResult> = serde_json::from_str(
        r#"{ "items": [{ "number": 1, "run": "00000000-0000-0000-0000-000000000002", "step": 0, "attempt": 2, "kind": "gamma", "blob": null, "at_ns": 3,
            "details": { "value": { "at": { "robot_time": 0, "utc_ns": 3, "is_synchronised": true },
                "readings": [{ "name": "dose_rate", "value": 0.11, "unit": "µSv/h" }] } } }], "next": null }"#,
    )
    .unwrap();
    let content = RunContent { attempts: attempts.items, results: results.items };
    let last: Vec<_> = content.last_attempts().collect();
    assert_eq!(last.iter().map(|attempt| attempt.attempt).collect::<Vec<_>>(), [2, 1]);
    assert_eq!((last[0].details.place, last[1].details.task), (None, None));
    let is_on_edge = matches!(
        last[1].details.place,
        Some(RouteActionPlace::Edge { stage: EdgeStage::Enter, index: 0, .. })
    );
    assert!(is_on_edge, "an action on the way: {:?}", last[1]);
    let report = content.results_of(last[0]).next().and_then(StoredResult::report).unwrap();
    assert_eq!(report.readings[0].unit, "µSv/h");
    let mut client = TestClient::connected();
    client.command(ClientCommand::OpenRun(RUN));
    assert_eq!(client.take_effects(), [ClientEffect::FetchRun(RUN)]);
    client.apply(ClientEvent::RunFetched { run: RUN, result: Ok(content.clone()) });
    assert_eq!(client.model.runs.content(RUN), Some(&Ok(content)));
}

fn page(runs: std::ops::Range<u128>, next: Option<&str>) -> StoredPage<StoredRun> {
    let run = |number| StoredRun {
        run: RunId(Uuid::from_u128(number)),
        mission: MISSION,
        state: RunState::Failed,
        is_ended: true,
        details: None,
        asked: Utc(5),
        changed: Utc(9),
    };
    StoredPage { items: runs.map(run).collect(), next: next.map(str::to_owned) }
}

#[test]
fn the_list_is_fetched_anew_for_another_filter_and_goes_on_with_older_runs() {
    let mut client = TestClient::connected();
    let ended = EndedRun { run: RUN, mission: MISSION, outcome: RunState::Succeeded };
    client.event(Event::Missions(MissionStatus { ended: vec![ended], ..MissionStatus::default() }));
    client.take_effects();
    let query = RunQuery { outcome: Some(RunState::Failed), ..RunQuery::default() };
    client.command(ClientCommand::ListRuns(query));
    client.command(ClientCommand::ListRuns(query));
    assert_eq!(client.take_effects(), [ClientEffect::FetchRuns { query, before: None }], "once");
    assert!(!client.model.runs.is_listed());
    assert_eq!(client.model.runs.past().count(), 0, "the other one has succeeded");
    let listed = |before: Option<&str>, page| ClientEvent::RunsListed {
        query,
        before: before.map(str::to_owned),
        result: Ok(page),
    };
    client.apply(ClientEvent::RunsListed {
        query: RunQuery::default(),
        before: None,
        result: Ok(page(90..95, None)),
    });
    assert!(!client.model.runs.is_listed(), "the answer to an earlier question");
    client.apply(listed(None, page(10..12, Some("b"))));
    assert!(client.model.runs.has_older());
    client.command(ClientCommand::ListOlderRuns);
    let before = Some("b".to_owned());
    assert_eq!(client.take_effects(), [ClientEffect::FetchRuns { query, before }]);
    client.apply(listed(Some("b"), page(12..14, None)));
    client.apply(listed(Some("b"), page(12..14, None)));
    assert_eq!((client.model.runs.past().count(), client.model.runs.has_older()), (4, false));
}

#[test]
fn slots_that_were_skipped_say_why_and_are_asked_for_again_after_a_while() {
    let mut client = TestClient::connected();
    client.event(Event::Missions(MissionStatus::default()));
    client.take_effects();
    // As the gateway answers.
    let page = serde_json::from_str(
        r#"{ "items": [{
            "schedule": "00000000-0000-0000-0000-000000000003", "due_ns": 5, "run": null, "outcome": "blocked",
            "details": {
                "slot": { "date": { "year": 2026, "month": 11, "day": 24 }, "time": { "hour": 11, "minute": 0 } },
                "decision": { "skipped": { "blocked": "00000000-0000-0000-0000-000000000009" } } }
        }, {
            "schedule": "00000000-0000-0000-0000-000000000003", "due_ns": 2, "run": null, "outcome": "missed",
            "details": { "count": 3, "first": { "date": { "year": 2026, "month": 11, "day": 21 }, "time": { "hour": 11, "minute": 0 } },
                "last": { "date": { "year": 2026, "month": 11, "day": 23 }, "time": { "hour": 11, "minute": 0 } } }
        }], "next": null }"#,
    )
    .unwrap();
    client.apply(ClientEvent::SlotsListed(Ok(page)));
    let monitor = site_model::MonitorId(Uuid::from_u128(9));
    assert_eq!(client.model.runs.skipped_slot(SCHEDULE, slot()), Some(SkipReason::Blocked(monitor)));
    let monday = LocalDateTime { date: LocalDate { day: 23, ..slot().date }, ..slot() };
    assert_eq!(client.model.runs.skipped_slot(SCHEDULE, monday), Some(SkipReason::Missed));
    client.wait(30.0);
    let is_fetched = |client: &mut TestClient| client.take_effects().contains(&ClientEffect::FetchSlots);
    assert!(!is_fetched(&mut client));
    client.wait(31.0);
    assert!(is_fetched(&mut client));
}

#[test]
fn the_result_before_another_one_is_fetched() {
    let mut client = TestClient::connected();
    let point = InspectionPointId(Uuid::from_u128(8));
    client.command(ClientCommand::OpenPrevious { point, before: 7 });
    assert_eq!(client.take_effects(), [ClientEffect::FetchPrevious { point, before: 7 }]);
    assert_eq!(client.model.runs.previous(point, 7), None);
    client.apply(ClientEvent::PreviousFetched { point, before: 7, result: Ok(None) });
    assert_eq!(client.model.runs.previous(point, 7), Some(&Ok(None)));
}

#[test]
fn results_of_the_active_run_are_fetched_as_they_are_stored() {
    let mut client = TestClient::connected();
    let running = MissionStatus { runs: vec![run(RunState::Running)], ..MissionStatus::default() };
    let fetch = ClientEffect::FetchRun(RUN);
    client.event(Event::Missions(running.clone()));
    assert!(client.take_effects().contains(&fetch), "what was stored before this client came");
    client.event(Event::Missions(running));
    assert!(!client.take_effects().contains(&fetch), "once");
    let stored = |number| {
        Event::ResultStored(api::StoredResult {
            number,
            run: RUN,
            step: 0,
            attempt: 1,
            kind: "photo".to_owned(),
            blob: None,
            body: "{}".to_owned(),
            comparison: None,
            at: Stamp::EPOCH,
        })
    };
    let result = |number| StoredResult {
        number,
        at: Utc(0),
        run: RUN,
        kind: "photo".to_owned(),
        step: 0,
        attempt: 1,
        details: Default::default(),
        comparison: None,
    };
    client.event(stored(1));
    assert_eq!(client.take_effects(), [fetch]);
    let content = |numbers: &[u64]| RunContent {
        attempts: Vec::new(),
        results: numbers.iter().map(|n| result(*n)).collect(),
    };
    client.apply(ClientEvent::RunFetched { run: RUN, result: Ok(content(&[1, 2])) });
    client.event(stored(2));
    assert_eq!(client.take_effects(), [], "it is there already");
    client.apply(ClientEvent::RunFetched { run: RUN, result: Ok(content(&[1])) });
    assert_eq!(client.model.runs.content(RUN), Some(&Ok(content(&[1, 2]))), "an answer that comes late");
    client.event(Event::ResultStored(api::StoredResult {
        run: RunId(Uuid::from_u128(77)),
        ..match stored(3) {
            Event::ResultStored(result) => result,
            _ => unreachable!("made above"),
        }
    }));
    assert_eq!(client.take_effects(), [], "nobody looks at that run");
}

#[test]
fn the_route_leads_from_its_present_edge_over_the_ends_of_the_others() {
    let [a, b, c] = [1, 2, 3].map(|number| NodeId(Uuid::from_u128(number)));
    let [first, second, unknown] = [11, 12, 13].map(|number| EdgeId(Uuid::from_u128(number)));
    let mut site = Site::default();
    for (number, (id, from, to)) in (21..).zip([(first, a, b), (second, b, c)]) {
        let object = site_model::Object::Edge(site_model::Edge::walk(id, from, to));
        let edit = site.put(site_model::EditId(Uuid::from_u128(number)), object);
        site.apply(&edit, edit.id).expect("of this site");
    }
    let mut client = TestClient::connected();
    assert!(client.model.runs.route_nodes(&site).is_empty());
    client.event(route_to(c, vec![first, second, unknown]));
    assert_eq!(client.model.runs.route_nodes(&site), [a, b, c]);
}

/// A route to this node, over these edges.
fn route_to(target: NodeId, edges: Vec<EdgeId>) -> Event {
    let route = RouteProgress {
        goal: GoalId(Uuid::nil()),
        target,
        edges,
        remaining_s: 20.0,
        remaining_m: 15.0,
        waits_for: None,
    };
    Event::Route(RouteStatus { route: Some(route), ..RouteStatus::default() })
}

#[test]
fn the_policy_leads_from_every_node_to_where_the_robot_goes_and_follows_site_and_route() {
    let mut client = TestClient::connected();
    client.event(Event::SitePart(api::SiteParts::new(Default::default()).next_part()));
    let map = vocab::MapId(Uuid::nil());
    let mut nodes = Vec::new();
    for x in [0.0, 5.0, 10.0] {
        let (node, edit) =
            client.model.site.adding_node(vocab::Vec3::new(x, 0.0, 0.5), map, nodes.last().copied());
        client.command(ClientCommand::EditSite(edit));
        nodes.push(node);
    }
    let [a, b, c] = nodes[..] else { panic!("{nodes:?}") };
    assert!(client.model.runs.policy().is_empty(), "the robot follows no route");
    let steps = |client: &TestClient| client.model.runs.policy().iter().copied().collect::<BTreeSet<_>>();
    client.event(route_to(c, Vec::new()));
    assert_eq!(steps(&client), [[a, b], [b, c]].into());
    client.event(route_to(a, Vec::new()));
    assert_eq!(steps(&client), [[c, b], [b, a]].into());
    let site = client.model.site.site().expect("a site");
    let edge = site.edges().find(|edge| (edge.from, edge.to) == (c, b)).expect("joined").id;
    client.command(ClientCommand::EditSite(
        client.model.site.changing_edge(edge, |edge| edge.is_enabled = false),
    ));
    assert_eq!(steps(&client), [[b, a]].into(), "no way leads from there");
    client.event(Event::Route(RouteStatus::default()));
    assert!(client.model.runs.policy().is_empty());
}
