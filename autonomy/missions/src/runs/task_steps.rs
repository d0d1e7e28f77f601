//! Steps of tasks: applies the task table.

use super::interface::{ActionInfo, GoalRequest, MissionEffect, MissionNotice};
use super::records::{Run, TaskRecord};
use super::runner::{ActionCancelReason, ActionInProgress, Activity, MissionRunner, Purpose, RunLeg};
use super::table::{RunTrigger, TASK_TABLE, TaskAction, TaskGuard, TaskTransition, TaskTrigger};
use crate::graph::{NoRoute, RouteTree};
use crate::ids::{call_id, goal_id};
use site_model::{
    ActionRequest, DockId, FailureStep, MissionEventKind, NodeId, ReachFailure, RunId, RunState, TaskFailure,
    TaskState, TaskStep, describe_action,
};
use vocab::Span;

impl MissionRunner {
    /// A task that robot or action is at work on.
    pub(super) fn current_task(&self, run: RunId) -> Option<usize> {
        let is_current = |task: &TaskRecord| matches!(task.state, TaskState::Navigating | TaskState::Running);
        self.records.runs.get(&run)?.tasks.iter().position(is_current)
    }

    pub(super) fn fire_current_task(&mut self, run: RunId, trigger: TaskTrigger) {
        if let Some(task) = self.current_task(run) {
            self.fire_task(run, task, trigger, None);
        }
    }

    /// All tasks that have not ended are cancelled.
    pub(super) fn cancel_tasks(&mut self, run: RunId) {
        let count = self.records.runs.get(&run).map_or(0, |run| run.tasks.len());
        for task in 0..count {
            self.fire_task(run, task, TaskTrigger::RunStops, None);
        }
    }

    pub(super) fn succeed_task(&mut self, run: RunId, task: usize, result: Option<String>) {
        self.fire(run, task, TaskTrigger::ActionSucceeded, None, result);
    }

    /// Applies a row of the task table; a trigger without one changes nothing.
    pub(super) fn fire_task(
        &mut self,
        run: RunId,
        task: usize,
        trigger: TaskTrigger,
        failure: Option<TaskFailure>,
    ) {
        self.fire(run, task, trigger, failure, None);
    }

    fn fire(
        &mut self,
        id: RunId,
        task: usize,
        trigger: TaskTrigger,
        failure: Option<TaskFailure>,
        result: Option<String>,
    ) {
        let Some(run) = self.records.runs.get(&id) else { return };
        let Some(record) = run.tasks.get(task) else { return };
        let fits = |row: &TaskTransition| {
            row.from == record.state
                && row.trigger == trigger
                && self.holds(row.guard, run, record, failure.as_ref())
        };
        let Some(number) = TASK_TABLE.iter().position(fits) else { return };
        #[cfg(test)]
        self.taken.insert(('t', number));
        let row = &TASK_TABLE[number];
        let (goal, call) = (goal_id(id, run.steps), call_id(id, run.steps));
        let before = (record.goal, record.call);
        let step = match row.to {
            TaskState::Waiting => Some(TaskStep::Waits),
            TaskState::Navigating => Some(TaskStep::SetsOut { goal }),
            TaskState::Running if row.actions.contains(&TaskAction::CallAction) => {
                Some(TaskStep::Acts { call })
            }
            TaskState::Running => None,
            TaskState::Paused => Some(TaskStep::Paused),
            TaskState::Retriable => {
                let failure = failure.clone().unwrap_or(TaskFailure::OutcomeUnknown);
                Some(match row.guard {
                    TaskGuard::RetriesLeft => TaskStep::TriesAgain(failure),
                    TaskGuard::TriesLater => TaskStep::TriesLater(failure),
                    _ => TaskStep::Asks(failure),
                })
            }
            TaskState::Succeeded => Some(TaskStep::Succeeded { result }),
            TaskState::Failed => Some(TaskStep::Failed(
                failure.or_else(|| last_failure(record)).unwrap_or(TaskFailure::OutcomeUnknown),
            )),
            TaskState::Skipped => Some(TaskStep::Skipped),
            TaskState::Cancelled => Some(TaskStep::Cancelled),
        };
        if let Some(step) = step {
            let attempt = match step {
                TaskStep::Waits | TaskStep::SetsOut { .. } => record.next_attempt,
                _ => record.attempt.max(1),
            };
            let task = record.planned.task;
            self.emit(MissionEventKind::Task { run: id, task, attempt, step });
        }
        for action in row.actions {
            match action {
                TaskAction::RequestGoal => {
                    self.request_task_goal(id, task, goal, trigger == TaskTrigger::Undocked)
                }
                TaskAction::CallAction => self.call_action(id, task, call),
                TaskAction::CancelGoal => before.0.into_iter().for_each(|goal| self.cancel_goal(goal)),
                TaskAction::CancelAction => self.cancel_action(stop_reason(trigger)),
                TaskAction::Ask => {
                    let task = self.records.runs[&id].tasks[task].planned.task;
                    self.notify(MissionNotice::Question(id, task));
                }
                TaskAction::EndRunAtDock => self.fire_run(id, RunTrigger::TaskEndsAtDock),
                TaskAction::EndRunHere => self.fire_run(id, RunTrigger::TaskEndsHere),
            }
        }
    }

    fn holds(&self, guard: TaskGuard, run: &Run, task: &TaskRecord, failure: Option<&TaskFailure>) -> bool {
        let stop = match &self.activity {
            Some(Activity::Action(acting)) => acting.stop,
            _ => None,
        };
        let policy = failure.map(|failure| task.policy_for(failure));
        let is_over = policy.is_none_or(|(policy, failures)| failures >= u32::from(policy.retries));
        let then = policy.map(|(policy, _)| policy.then);
        // While a run ends, nothing is tried again and nobody is asked.
        let is_ending = run.state == RunState::Ending;
        match guard {
            TaskGuard::Always => true,
            TaskGuard::WithAction => task.planned.request.is_some(),
            TaskGuard::WithoutAction => task.planned.request.is_none(),
            TaskGuard::RetriesLeft => !is_ending && !is_over,
            TaskGuard::TriesLater => !is_ending && then == Some(FailureStep::TryLater) && !task.is_later,
            TaskGuard::Asks => !is_ending && matches!(then, Some(FailureStep::Ask { .. })),
            TaskGuard::EndsAtDock => !is_ending && then == Some(FailureStep::EndAtDock),
            TaskGuard::EndsHere => !is_ending && then == Some(FailureStep::EndHere),
            TaskGuard::GoesOn => {
                is_ending
                    || then == Some(FailureStep::Skip)
                    || (then == Some(FailureStep::TryLater) && task.is_later)
            }
            TaskGuard::Idempotent => task.planned.is_idempotent,
            TaskGuard::NotIdempotent => !task.planned.is_idempotent,
            TaskGuard::ForSkip => stop == Some(ActionCancelReason::ForSkip),
            TaskGuard::ForEnd => stop == Some(ActionCancelReason::ForEnd),
            TaskGuard::ForInterrupt => stop == Some(ActionCancelReason::ForInterrupt),
        }
    }

    /// The robot goes to the place of a task, and leaves its dock first.
    fn request_task_goal(&mut self, run: RunId, task: usize, goal: vocab::GoalId, is_undocked: bool) {
        let purpose = Purpose::Task(run, task);
        let node = self.records.runs[&run].tasks[task].planned.node;
        let fail = |runner: &mut Self, failure| {
            let failure = Some(TaskFailure::NotReached(failure));
            runner.fire_task(run, task, TaskTrigger::ReachFailed, failure);
        };
        let Some(node) = node.filter(|node| self.graph.contains(*node)) else {
            return fail(self, ReachFailure::NoSuchPlace);
        };
        let request = self.goal_to(node);
        if let GoalRequest::Dock(dock) = request
            && self.situation.docked == Some(dock)
        {
            return self.fire_task(run, task, TaskTrigger::Reached, None);
        }
        if self.situation.docked.is_some() && !is_undocked {
            return self.begin_leg(RunLeg { goal, purpose, is_undocking: true }, GoalRequest::Undock);
        }
        match self.find_closed(node) {
            Some(failure) => fail(self, failure),
            None => self.begin_leg(RunLeg { goal, purpose, is_undocking: false }, request),
        }
    }

    /// The goal that brings the robot to a node.
    pub(super) fn goal_to(&self, node: NodeId) -> GoalRequest {
        let dock = self.route_site.docks().find(|dock| dock.node == node);
        dock.map_or(GoalRequest::Route(node), |dock| GoalRequest::Dock(dock.id))
    }

    /// Why no route leads to a node now; none if one does or opens soon, or if it is not known where the robot is.
    fn find_closed(&mut self, node: NodeId) -> Option<ReachFailure> {
        self.open_short_blocks();
        let from = self.situation.place.nearest?;
        match self.graph.routes_to(node).map(|tree| tree.route(from)) {
            Some(Err(NoRoute::Closed { edges })) => {
                let closed = edges.into_iter().map(|(edge, _)| edge).collect();
                Some(ReachFailure::NoRoute { closed })
            }
            Some(Err(NoRoute::NotConnected)) => Some(ReachFailure::NoRoute { closed: Vec::new() }),
            Some(Err(NoRoute::NoSuchNode(_))) => None,
            Some(Ok(_)) => None,
            None => Some(ReachFailure::NoSuchPlace),
        }
    }

    /// The graph as it is soon: whoever walks waits for the end of short blocks where there is no other way.
    fn open_short_blocks(&mut self) {
        self.rebuild_graph();
        self.graph.open_blocks_until(self.at + self.config.blocks.max_wait);
    }

    /// Docks that can be reached, the nearest first.
    pub(super) fn docks_by_distance(&mut self) -> Vec<DockId> {
        self.open_short_blocks();
        let Some(from) = self.situation.place.nearest else { return Vec::new() };
        let cost = |tree: RouteTree<'_>| tree.cost_s(from);
        let docks = self.route_site.docks();
        let reachable = docks.filter_map(|dock| Some((cost(self.graph.routes_to(dock.node)?)?, dock.id)));
        let mut reachable: Vec<_> = reachable.collect();
        reachable.sort_by(|a, b| a.0.total_cmp(&b.0));
        reachable.into_iter().map(|(_, dock)| dock).collect()
    }

    fn call_action(&mut self, run: RunId, task: usize, call: vocab::ActionCallId) {
        let planned = &self.records.runs[&run].tasks[task].planned;
        let Some(request) = planned.request.clone() else { return };
        let Some(info) = self.actions.get(&request.action) else {
            let failure = Some(TaskFailure::ActionUnavailable);
            return self.fire_task(run, task, TaskTrigger::ActionFailed, failure);
        };
        let deadline = self.at + self.config.action_time.limit(expected_time(info, &request));
        self.activity = Some(Activity::Action(ActionInProgress { run, task, call, deadline, stop: None }));
        let task = planned.task;
        self.act(MissionEffect::CallAction { call, run, task, request });
    }

    /// Cancels the present action. One that was not called yet is not called any more.
    pub(super) fn cancel_action(&mut self, stop: ActionCancelReason) {
        let limit = self.config.cancel_time_limit;
        let Some(Activity::Action(acting)) = &mut self.activity else { return };
        let is_first = acting.stop.is_none();
        acting.stop = Some(stop);
        let acting = *acting;
        if !is_first {
            return;
        }
        if let Some(Activity::Action(acting)) = &mut self.activity {
            acting.deadline = self.at + limit;
        }
        let is_call = |effect: &MissionEffect| matches!(effect, MissionEffect::CallAction { call, .. } if *call == acting.call);
        if self.withdraw(is_call) {
            self.end_action(&acting, super::interface::ActionResult::Cancelled);
        } else {
            self.effects.push(MissionEffect::CancelAction(acting.call));
        }
    }
}

/// How long an action is expected to take. A measurement for a time that the request says takes that time, and not what is usual.
fn expected_time(info: &ActionInfo, request: &ActionRequest) -> Span {
    let known_s =
        describe_action(&request.action).map_or(0.0, |known| known.expected_time_s(&request.parameters));
    info.expected.max(Span::from_secs_f64(known_s)).max(Span::ZERO)
}

fn stop_reason(trigger: TaskTrigger) -> ActionCancelReason {
    match trigger {
        TaskTrigger::SkipRequested => ActionCancelReason::ForSkip,
        TaskTrigger::RunInterrupted => ActionCancelReason::ForInterrupt,
        _ => ActionCancelReason::ForEnd,
    }
}

fn last_failure(task: &TaskRecord) -> Option<TaskFailure> {
    task.results.iter().rev().find_map(|(_, step)| match step {
        TaskStep::TriesAgain(failure) | TaskStep::TriesLater(failure) | TaskStep::Asks(failure) => {
            Some(failure.clone())
        }
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use site_model::Parameter;

    #[test]
    fn a_measurement_is_expected_to_take_the_time_that_its_request_says() {
        let info = ActionInfo { is_idempotent: true, expected: Span::from_millis(62_000) };
        let request = |action: &str, seconds| ActionRequest {
            action: action.to_owned(),
            parameters: [("duration_s".to_owned(), Parameter::Integer(seconds))].into(),
        };
        let long = expected_time(&info, &request("gamma_spectrum", 3_000));
        assert!(long >= Span::from_millis(3_000_000), "{long:?}");
        // A shorter one is given what is usual, and so is one that the platform does not know.
        assert_eq!(expected_time(&info, &request("gamma_spectrum", 1)), info.expected);
        assert_eq!(expected_time(&info, &request("sniff", 3_000)), info.expected);
    }
}
