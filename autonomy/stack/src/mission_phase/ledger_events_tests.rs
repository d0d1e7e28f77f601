//! A run with one task from the queue to its end, and a slot of a schedule, as rows of the ledger.

use super::*;
use site_model::{
    ActionRequest, EndPlace, FailurePolicy, LocalDate, LocalDateTime, LocalTime, MissionEnd, NodeId,
    Parameters, RunCause, RunPlan, ScheduleId, SkipReason, TaskFailure, Utc,
};
use uuid::Uuid;
use vocab::{ActionCallId, CommandId, GoalId};

const RUN: RunId = RunId(Uuid::from_u128(1));
const TASK: TaskId = TaskId(Uuid::from_u128(2));

fn event(kind: MissionEventKind) -> MissionEvent {
    MissionEvent { utc: Some(Utc(5)), command: None, kind }
}

/// The rows of events that follow each other, without the events themselves.
fn rows(kinds: Vec<MissionEventKind>) -> Vec<LedgerEvent> {
    let (mut records, site) = (Records::default(), Site::default());
    let result_pose =
        ResultPose { map_from_base: Some(Pose::IDENTITY), covariance: None, is_localised: true };
    let written = kinds.into_iter().flat_map(|kind| {
        let event = event(kind);
        let mut rows = write(&event, &mut records, &site, &result_pose);
        assert_eq!(rows.remove(0), LedgerEvent::Mission(event), "the event itself is first");
        rows
    });
    written.collect()
}

/// A run that has begun, with a photo at a node.
fn begun() -> Vec<MissionEventKind> {
    let mission = MissionId(Uuid::from_u128(3));
    let request = ActionRequest { action: "photo".to_owned(), parameters: Parameters::new() };
    let task = PlannedTask {
        task: TASK,
        node: Some(NodeId(Uuid::from_u128(4))),
        request: Some(request),
        is_idempotent: true,
        on_unreachable: FailurePolicy::default(),
        on_action_failure: FailurePolicy::default(),
    };
    let revisions = vec![(ObjectId::Mission(mission), Revision(7))];
    let plan = RunPlan { tasks: vec![task], revisions, end: MissionEnd::Stay };
    vec![
        MissionEventKind::RunQueued {
            run: RUN,
            mission,
            cause: RunCause::Account { command: CommandId(Uuid::nil()), account: "anna".to_owned() },
            priority: 0,
        },
        MissionEventKind::RunBegan { run: RUN, plan },
    ]
}

fn step(step: TaskStep) -> MissionEventKind {
    MissionEventKind::Task { run: RUN, task: TASK, attempt: 1, step }
}

fn json(body: &str) -> Value {
    serde_json::from_str(body).unwrap_or_else(|error| panic!("{error}: {body}"))
}

#[test]
fn a_run_is_a_row_with_its_state_and_the_revisions_of_its_plan() {
    let ended = [
        MissionEventKind::RunEnding { run: RUN, outcome: RunState::Succeeded, place: EndPlace::Here },
        MissionEventKind::RunEnded { run: RUN, outcome: RunState::Succeeded },
    ];
    let rows = rows(begun().into_iter().chain(ended).collect());
    let runs: Vec<&RunRecord> = rows
        .iter()
        .map(|row| match row {
            LedgerEvent::Run(run) => run,
            other => panic!("{other:?}"),
        })
        .collect();
    let states: Vec<(&str, bool)> = runs.iter().map(|run| (run.state.as_str(), run.is_ended)).collect();
    assert_eq!(states, [("queued", false), ("running", false), ("ending", false), ("succeeded", true)]);
    assert_eq!(json(&runs[0].body)["revisions"], Value::Null);
    assert_eq!(json(&runs[3].body)["revisions"][0]["kind"], "mission");
    assert_eq!(json(&runs[3].body)["tasks"], 1);
    assert!(runs.iter().all(|run| json(&run.body)["cause"]["account"]["account"] == "anna"));
}

#[test]
fn a_task_is_a_row_for_each_step_and_its_result_has_one_of_its_own() {
    let hash = "ab".repeat(32);
    let result = json!({ "files": [{ "blob": hash }, { "blob": "no hash" }] }).to_string();
    let steps = [
        step(TaskStep::SetsOut { goal: GoalId(Uuid::from_u128(9)) }),
        step(TaskStep::Acts { call: ActionCallId(Uuid::from_u128(8)) }),
        step(TaskStep::Succeeded { result: Some(result) }),
    ];
    let rows = rows(begun().into_iter().chain(steps).collect());
    let mut states = Vec::new();
    let mut results = Vec::new();
    for row in &rows[2..] {
        match row {
            LedgerEvent::Step(step) => states.push((step.state.as_str(), step.is_done, json(&step.body))),
            LedgerEvent::Result(result) => results.push(result),
            other => panic!("{other:?}"),
        }
    }
    let words: Vec<(&str, bool)> = states.iter().map(|(state, done, _)| (*state, *done)).collect();
    assert_eq!(words, [("navigating", false), ("running", false), ("succeeded", true)]);
    assert_eq!(states[2].2["step"], "succeeded", "the result stands in its own row only");
    let [result] = results[..] else { panic!("{results:?}") };
    assert_eq!((result.kind.as_str(), result.blob), ("photo", Some([0xab; 32])));
    let body = json(&result.body);
    assert_eq!(body["whereabouts"]["is_localised"], true);
    assert_eq!(body["value"]["files"][1]["blob"], "no hash");
    assert_eq!(body["revisions"][0]["revision"], 7);
}

#[test]
fn a_failed_task_says_why_and_a_result_that_is_no_json_is_kept_as_text() {
    let failed = step(TaskStep::Failed(TaskFailure::ActionTimedOut));
    let rows_of_failure = rows(begun().into_iter().chain([failed]).collect());
    let Some(LedgerEvent::Step(record)) = rows_of_failure.last() else { panic!("{rows_of_failure:?}") };
    assert!(record.is_done && record.body.contains("timed_out"), "{}", record.body);

    let text = step(TaskStep::Succeeded { result: Some("not JSON".to_owned()) });
    let rows = rows(begun().into_iter().chain([text]).collect());
    let Some(LedgerEvent::Result(result)) = rows.last() else { panic!("{rows:?}") };
    assert_eq!((json(&result.body)["value"].as_str(), result.blob), (Some("not JSON"), None));
}

#[test]
fn a_slot_is_a_row_with_its_decision() {
    let schedule = ScheduleId(Uuid::from_u128(6));
    let slot = LocalDateTime {
        date: LocalDate { year: 2026, month: 3, day: 2 },
        time: LocalTime { hour: 11, minute: 0 },
    };
    let decided = |decision| MissionEventKind::SlotDecided { schedule, slot, due: Utc(1_000), decision };
    let rows =
        rows(vec![decided(SlotDecision::Run(RUN)), decided(SlotDecision::Skipped(SkipReason::Missed))]);
    let firings: Vec<_> = rows
        .iter()
        .map(|row| match row {
            LedgerEvent::Firing(firing) => (firing.outcome.as_str(), firing.run, firing.due_utc_ns),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(firings, [("run", Some(RUN), 1_000), ("missed", None, 1_000)]);
}

#[test]
fn a_hash_is_64_hexadecimal_digits() {
    assert_eq!(parse_hash(&"0f".repeat(32)), Some([0x0f; 32]));
    for text in ["", "0f", &"0f".repeat(33), &"zz".repeat(32), &"0f0".repeat(21), &"ä".repeat(32)] {
        assert_eq!(parse_hash(text), None, "{text}");
    }
}
