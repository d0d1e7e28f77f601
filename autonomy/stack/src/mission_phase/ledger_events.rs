//! What the ledger keeps of an event of missions: the event itself, from which the runner is made again, and the rows that people ask for: runs, steps, results and
//! slots of schedules.

use messages::{FiringRecord, LedgerEvent, ResultRecord, RunRecord, StepRecord};
use missions::{Records, RouteActionRecord, Run};
use serde::Serialize;
use serde_json::{Value, json};
use site_model::{
    InspectionPointId, MissionEvent, MissionEventKind, MissionId, ObjectId, PlannedTask, Revision,
    RouteActionEnd, RunId, RunState, Site, SlotDecision, TaskFailure, TaskId, TaskPlace, TaskState, TaskStep,
};
use vocab::{ActionCallId, Covariance6, Pose};

/// What is recorded with each result: where the robot was, as it knew.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct ResultPose {
    /// Base in the map.
    pub map_from_base: Option<Pose>,
    /// Its covariance.
    pub covariance: Option<Covariance6>,
    /// Whether the pose was known with nothing speaking against it.
    pub is_localised: bool,
}

/// The rows of an event, which is applied to the records of those before it.
pub(super) fn write(
    event: &MissionEvent,
    records: &mut Records,
    site: &Site,
    result_pose: &ResultPose,
) -> Vec<LedgerEvent> {
    // A run that has ended is not among the records any more.
    let is_end = matches!(event.kind, MissionEventKind::RunEnded { .. });
    let rows_of_end = is_end.then(|| ledger_events(event, records, site, result_pose));
    records.apply(event);
    rows_of_end.unwrap_or_else(|| ledger_events(event, records, site, result_pose))
}

fn ledger_events(
    event: &MissionEvent,
    records: &Records,
    site: &Site,
    result_pose: &ResultPose,
) -> Vec<LedgerEvent> {
    let mut events = vec![LedgerEvent::Mission(event.clone())];
    let run = event.kind.run();
    match &event.kind {
        MissionEventKind::RunQueued { .. }
        | MissionEventKind::RunBegan { .. }
        | MissionEventKind::RunChanged { .. }
        | MissionEventKind::RunEnding { .. }
        | MissionEventKind::RunSetOutToEnd { .. }
        | MissionEventKind::QuestionAnswered { .. } => {
            events.extend(run.and_then(|run| run_record(records, run, None)));
        }
        MissionEventKind::RunEnded { outcome, .. } => {
            events.extend(run.and_then(|run| run_record(records, run, Some(*outcome))));
        }
        MissionEventKind::Task { run, task, attempt, step } => {
            events.extend(task_records(event, records, (*run, *task), *attempt, step, site, result_pose));
        }
        MissionEventKind::RouteAction { run, call, .. } => {
            events.extend(route_action_records(event, records, (*run, *call), site, result_pose));
        }
        MissionEventKind::SlotDecided { schedule, slot, due, decision } => {
            let (run, outcome) = match decision {
                SlotDecision::Run(run) => (Some(*run), "run".to_owned()),
                SlotDecision::Skipped(reason) => (None, name_of(reason)),
            };
            let body = json!({ "slot": slot, "decision": decision }).to_string();
            let (schedule, due_utc_ns) = (*schedule, due.0);
            events.push(LedgerEvent::Firing(FiringRecord { schedule, due_utc_ns, run, outcome, body }));
        }
        MissionEventKind::SlotsMissed { schedule, first, last, last_due, count } => {
            let body = json!({ "first": first, "last": last, "count": count }).to_string();
            events.push(LedgerEvent::Firing(FiringRecord {
                schedule: *schedule,
                due_utc_ns: last_due.0,
                run: None,
                outcome: "missed".to_owned(),
                body,
            }));
        }
        MissionEventKind::ScheduleAdopted { .. }
        | MissionEventKind::MonitorChanged { .. }
        | MissionEventKind::DockingBegan { .. } => {}
    }
    events
}

fn run_record(records: &Records, id: RunId, ended: Option<RunState>) -> Option<LedgerEvent> {
    let run = records.runs.get(&id)?;
    let state = ended.unwrap_or(run.state);
    let body = json!({
        "cause": run.cause,
        "began": run.began,
        "tasks": run.tasks.len(),
        "outcome": run.ending.map(|(outcome, _)| outcome),
        "revisions": run.plan.as_ref().map(|plan| pinned(&plan.revisions)),
    });
    Some(LedgerEvent::Run(RunRecord {
        run: id,
        mission: run.mission,
        state: name_of(&state),
        is_ended: state.is_outcome(),
        body: body.to_string(),
    }))
}

/// Objects with their revisions, as people and programs read them.
fn pinned(revisions: &[(ObjectId, Revision)]) -> Vec<Value> {
    let entry = |(object, revision): &(ObjectId, Revision)| json!({ "kind": object.kind().name(), "id": object.uuid(), "revision": revision });
    revisions.iter().map(entry).collect()
}

fn task_records(
    event: &MissionEvent,
    records: &Records,
    (run, task): (RunId, TaskId),
    attempt: u32,
    step: &TaskStep,
    site: &Site,
    result_pose: &ResultPose,
) -> Vec<LedgerEvent> {
    let Some(known) = records.runs.get(&run) else { return Vec::new() };
    let Some(index) = known.index_of(task) else { return Vec::new() };
    let planned = &known.tasks[index].planned;
    let number = u32::try_from(index).unwrap_or(u32::MAX);
    let state = step.state();
    let action = planned.request.as_ref().map(|request| request.action.as_str());
    let body = json!({
        "task": task,
        "node": planned.node,
        "action": action,
        "step": step_without_result(step),
        "utc": event.utc,
    });
    let mut events = vec![LedgerEvent::Step(StepRecord {
        run,
        step: number,
        attempt,
        state: name_of(&state),
        is_done: state.is_outcome(),
        body: body.to_string(),
    })];
    if let TaskStep::Succeeded { result: Some(result) } = step {
        let about = json!({
            "task": task,
            "node": planned.node,
            "inspection_point": inspection_point(site, known.mission, planned),
            "parameters": planned.request.as_ref().map(|request| &request.parameters),
        });
        let kind = action.unwrap_or_default().to_owned();
        events.push(result_record(event, known, (number, attempt), kind, about, result, site, result_pose));
    }
    events
}

/// A result of an action, with what there is to say of all of them. `about`: what the action was for.
#[allow(clippy::too_many_arguments, reason = "each is one part of the row")]
fn result_record(
    event: &MissionEvent,
    run: &Run,
    (step, attempt): (u32, u32),
    kind: String,
    mut about: Value,
    result: &str,
    site: &Site,
    result_pose: &ResultPose,
) -> LedgerEvent {
    let value: Value = serde_json::from_str(result).unwrap_or_else(|_| Value::String(result.to_owned()));
    // The first file is the most important one.
    let file = value.get("files").and_then(|files| files.get(0));
    let blob = file.and_then(|file| file.get("blob")).and_then(Value::as_str).and_then(parse_hash);
    about["value"] = value;
    about["utc"] = json!(event.utc);
    about["time_zone"] =
        json!(site.settings().map(|settings| settings.time_zone.as_str()).unwrap_or_default());
    // The key that the rows of earlier programs have.
    about["whereabouts"] = json!(result_pose);
    about["revisions"] = json!(run.plan.as_ref().map(|plan| pinned(&plan.revisions)));
    LedgerEvent::Result(ResultRecord { run: run.id, step, attempt, kind, blob, body: about.to_string() })
}

/// The rows of an action on the way. Their numbers follow those of the tasks.
fn route_action_records(
    event: &MissionEvent,
    records: &Records,
    (run, call): (RunId, ActionCallId),
    site: &Site,
    result_pose: &ResultPose,
) -> Vec<LedgerEvent> {
    let Some(known) = records.runs.get(&run) else { return Vec::new() };
    let Some(index) = known.route_actions.iter().position(|action| action.call == call) else {
        return Vec::new();
    };
    let action = &known.route_actions[index];
    let number = u32::try_from(known.tasks.len() + index).unwrap_or(u32::MAX);
    let (state, step) = route_action_state(action);
    let (place, name) = (action.place, &action.request.action);
    let body = json!({
        "place": place,
        "task": action.task,
        "action": name,
        "step": step,
        "utc": event.utc,
        "map_from_base": result_pose.map_from_base,
    });
    let mut events = vec![LedgerEvent::Step(StepRecord {
        run,
        step: number,
        attempt: 1,
        state: name_of(&state),
        is_done: state.is_outcome(),
        body: body.to_string(),
    })];
    if let Some(RouteActionEnd::Succeeded { result: Some(result) }) = &action.end {
        let about = json!({ "place": place, "task": action.task, "parameters": action.request.parameters });
        events.push(result_record(event, known, (number, 1), name.clone(), about, result, site, result_pose));
    }
    events
}

/// The state of an action on the way, in the words of tasks, and its step.
fn route_action_state(action: &RouteActionRecord) -> (TaskState, Value) {
    let failed = |failure: TaskFailure| (TaskState::Failed, json!({ "failed": failure }));
    match &action.end {
        None => (TaskState::Running, json!({ "acts": { "call": action.call } })),
        Some(RouteActionEnd::Succeeded { .. }) => (TaskState::Succeeded, json!("succeeded")),
        Some(RouteActionEnd::Failed(reason)) => failed(TaskFailure::ActionFailed(reason.clone())),
        Some(RouteActionEnd::Cancelled) => (TaskState::Cancelled, json!("cancelled")),
        Some(RouteActionEnd::OutcomeUnknown) => failed(TaskFailure::OutcomeUnknown),
    }
}

/// The inspection point of a task, by which results of several runs are compared. None if an edit has taken it from the mission while it ran.
fn inspection_point(site: &Site, mission: MissionId, planned: &PlannedTask) -> Option<InspectionPointId> {
    let task = site.mission(mission)?.tasks.iter().find(|task| task.id == planned.task)?;
    match task.place {
        TaskPlace::InspectionPoint(point) => {
            site.inspection_point(point).filter(|found| planned.node == Some(found.node)).map(|_| point)
        }
        TaskPlace::Node { .. } | TaskPlace::ByAction { .. } => None,
    }
}

/// The step without the result of the action, which has a row of its own.
fn step_without_result(step: &TaskStep) -> Value {
    match step {
        TaskStep::Succeeded { .. } => json!("succeeded"),
        step => serde_json::to_value(step).unwrap_or(Value::Null),
    }
}

/// The name of a state or reason, as JSON has it; of a reason with data, its kind.
fn name_of(value: &impl Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(Value::String(name)) => name,
        Ok(Value::Object(object)) => object.keys().next().cloned().unwrap_or_default(),
        _ => String::new(),
    }
}

/// A BLAKE3 hash in hexadecimal digits.
fn parse_hash(text: &str) -> Option<[u8; 32]> {
    let bytes: Option<Vec<u8>> =
        (0..text.len()).step_by(2).map(|at| u8::from_str_radix(text.get(at..at + 2)?, 16).ok()).collect();
    bytes?.try_into().ok()
}

#[cfg(test)]
#[path = "ledger_events_tests.rs"]
mod tests;
