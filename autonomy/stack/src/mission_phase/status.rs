//! What people are shown of missions.

use missions::{MissionRunner, Records, Run, TaskRecord};
use site_model::{EndedRun, MAX_ENDED_RUNS, MissionStatus, RunId, RunState, RunStatus, TaskStatus};

/// State of all missions.
pub(super) fn mission_status(runner: &MissionRunner) -> MissionStatus {
    let records = runner.records();
    let queue = records.queue();
    let active = records.active().map(|run| run.id);
    let suspended = records.runs.values().filter(|run| run.state == RunState::Suspended);
    let ids: Vec<RunId> = active.into_iter().chain(suspended.map(|run| run.id)).chain(queue).collect();
    let ended = records.ended.iter().rev().take(MAX_ENDED_RUNS).rev();
    MissionStatus {
        runs: ids.iter().filter_map(|id| records.runs.get(id)).map(run_status).collect(),
        ended: ended.map(|(run, mission, outcome)| ended_run(*run, *mission, *outcome)).collect(),
        blocked_by: runner.blocked_by(),
        monitors: monitors(records),
    }
}

fn monitors(records: &Records) -> Vec<site_model::MonitorId> {
    records.monitors.iter().copied().collect()
}

fn ended_run(run: RunId, mission: site_model::MissionId, outcome: RunState) -> EndedRun {
    EndedRun { run, mission, outcome }
}

fn run_status(run: &Run) -> RunStatus {
    RunStatus {
        run: run.id,
        mission: run.mission,
        cause: run.cause.clone(),
        state: run.state,
        outcome: run.ending.map(|(outcome, _)| outcome),
        began: run.began,
        tasks: run.tasks.iter().map(task_status).collect(),
        question: run.question.and_then(|index| Some(run.tasks.get(index)?.planned.task)),
    }
}

fn task_status(task: &TaskRecord) -> TaskStatus {
    TaskStatus {
        task: task.planned.task,
        node: task.planned.node,
        action: task.planned.request.as_ref().map(|request| request.action.clone()),
        state: task.state,
        attempt: task.attempt,
        failure: task.results.last().and_then(|(_, step)| step.failure()).cloned(),
    }
}
