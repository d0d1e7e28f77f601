//! The program ends at every step of a mission, and the results of record are the same.

use super::interface::{ActionResult, RouteGoalResult};
use super::testing::*;
use site_model::*;
use std::collections::BTreeMap;

/// A mission with all kinds of tasks, in a world whose answers depend on the task and on the number of its failures only.
struct Script {
    rig: Rig,
    results: BTreeMap<TaskId, TaskStep>,
}

impl Script {
    fn new() -> Self {
        let mut rig = Rig::new();
        let later = policy(0, FailureStep::TryLater);
        let twice = policy(2, FailureStep::Skip);
        let tasks = vec![
            task(1, 1, 3, Some("photo"), [twice, twice]),
            task(1, 2, 4, Some("spectrum"), [twice, twice]),
            task(1, 3, 5, Some("photo"), [later, twice]),
            task(1, 4, 6, None, [twice, twice]),
            task(1, 5, 4, Some("photo"), [twice, policy(1, FailureStep::Skip)]),
            task(1, 6, 2, Some("spectrum"), [twice, twice]),
        ];
        rig.put(Object::Mission(mission(1, tasks, MissionEnd::NearestDock)));
        rig.seen.clear();
        Self { rig, results: BTreeMap::new() }
    }

    /// Number of inputs so far at which the program can end.
    fn inputs(&self) -> usize {
        self.rig.durable.len() + self.rig.waiting.len()
    }

    /// The world does one thing. Whether the run goes on.
    fn step(&mut self) -> bool {
        let records = self.rig.runner.records();
        let Some(run) = records.runs.values().next() else { return false };
        let failures = |task: &super::records::TaskRecord| (task.reach_failures, task.action_failures);
        let current =
            run.tasks.iter().find(|task| matches!(task.state, TaskState::Navigating | TaskState::Running));
        let current = current.map(|task| (task.planned.task, failures(task)));
        let fails = |task: u128, reach: u32, act: u32, is_reaching: bool| match (task, is_reaching) {
            // The first is reached in the second attempt, the third later, the fifth never photographed.
            (1, true) => reach < 1,
            (3, true) => reach < 1,
            (2, false) => act < 1,
            (5, false) => act < 5,
            _ => false,
        };
        if self.rig.goal.is_some() {
            let is_undocking = matches!(self.rig.goal, Some((_, super::interface::GoalRequest::Undock)));
            let fails = current.is_some_and(|(task, (reach, act))| {
                !is_undocking && fails(task.0.as_u128() % 100, reach, act, true)
            });
            let blocked = RouteGoalResult::Failed(ReachFailure::PathBlocked);
            self.rig.end_goal(if fails { blocked } else { RouteGoalResult::Reached });
        } else if self.rig.call.is_some() {
            let fails =
                current.is_some_and(|(task, (reach, act))| fails(task.0.as_u128() % 100, reach, act, false));
            let result = if fails {
                ActionResult::Failed("The lens is dirty.".to_owned())
            } else {
                ActionResult::Succeeded(None)
            };
            self.rig.end_action(result);
        } else {
            self.rig.wait(10);
        }
        true
    }

    fn finish(mut self) -> BTreeMap<TaskId, TaskStep> {
        for _ in 0..2_000 {
            if !self.step() {
                break;
            }
        }
        assert!(self.rig.runner.records().runs.is_empty(), "{:#?}", self.rig.runner.records().runs);
        for event in &self.rig.durable {
            if let MissionEventKind::Task { task, step, .. } = &event.kind
                && step.state().is_outcome()
            {
                assert_eq!(self.results.insert(*task, step.clone()), None, "two results of record");
            }
        }
        self.results
    }
}

#[test]
fn a_restart_at_any_step_gives_the_same_results_of_record() {
    let start = MissionCommandKind::Start { run: run_id(1), mission: mission_id(1), mode: StartMode::Now };
    let mut undisturbed = Script::new();
    undisturbed.rig.command(start);
    let mut steps = 0;
    while undisturbed.step() {
        steps += 1;
    }
    assert!(undisturbed.inputs() > 30 && steps > 15, "{steps}");
    let expected = undisturbed.finish();
    assert_eq!(expected.len(), 6);
    let mut asked = 0;
    for crash in 0..=steps {
        // What the last update committed is durable, or is not; and the robot has begun to act on it, or has not.
        for is_durable in [false, true] {
            for is_released in [false, true] {
                let mut script = Script::new();
                script.rig.command(start);
                for step in 0..crash {
                    script.rig.holds_commits = step + 1 == crash && !is_released;
                    script.step();
                }
                if is_durable {
                    for (_, events) in std::mem::take(&mut script.rig.waiting) {
                        script.rig.durable.extend(events);
                    }
                }
                // What is durable says that the action was begun, and not how it ended.
                let records = super::records::Records::from_events(&script.rig.durable);
                let is_open = |task: &&super::records::TaskRecord| task.state == TaskState::Running;
                let run = records.runs.values().next();
                let in_flight =
                    run.and_then(|run| run.tasks.iter().find(is_open)).map(|task| task.planned.task);
                script.rig.holds_commits = false;
                script.rig.restart();
                script.rig.wait(1);
                let calls = script.rig.calls.clone();
                let results = script.finish();
                for (task, step) in &expected {
                    let found = &results[task];
                    let is_unknown =
                        Some(*task) == in_flight && [task_id(1, 2), task_id(1, 6)].contains(task);
                    if is_unknown && *found == TaskStep::Skipped {
                        asked += 1;
                        let made = calls.iter().filter(|(_, called, _)| called == task).count();
                        assert!(made <= 2, "not called again");
                    } else {
                        assert_eq!(found, step, "{task}, crash after step {crash}");
                    }
                }
            }
        }
    }
    assert!(asked > 5, "an action that cannot be repeated was in flight at some of the crashes");
}
