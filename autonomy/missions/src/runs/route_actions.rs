//! Actions on the way of a run: those of edges and zones. Their beginning is durable before they are called, and their end is recorded like that of a task.
//!
//! Of one that was begun before a restart it is not known how it ended. If it cannot be repeated without harm, it is not called again in this run until a person has
//! said so: the task to which the robot was on its way is asked about, and "try again" and a redo of that task permit it.

use super::interface::{ActionResult, MissionEffect};
use super::records::RouteActionRecord;
use super::runner::{Activity, MissionRunner, Purpose, RunLeg};
use super::table::TaskTrigger;
use crate::texts;
use site_model::{
    ActionRequest, MissionEventKind, RouteActionEnd, RouteActionPlace, RouteActionStep, RunId, TaskFailure,
    TaskId, TaskState,
};
use vocab::{ActionCallId, GoalId};

impl MissionRunner {
    /// Whether this is a call of an action on the way of a run that has not ended.
    pub fn is_route_action(&self, call: ActionCallId) -> bool {
        self.find_open_route_action(call).is_some()
    }

    fn find_open_route_action(&self, call: ActionCallId) -> Option<RunId> {
        let is_open = |action: &RouteActionRecord| action.call == call && action.end.is_none();
        self.records.runs.values().find(|run| run.route_actions.iter().any(is_open)).map(|run| run.id)
    }

    /// The route of a goal needs an action. It is called once that is durable, or refused.
    pub(super) fn handle_route_action(
        &mut self,
        goal: GoalId,
        call: ActionCallId,
        place: RouteActionPlace,
        request: ActionRequest,
    ) {
        let purpose = match &self.activity {
            Some(Activity::Leg(RunLeg { goal: known, purpose, .. })) if *known == goal => *purpose,
            // The goal has ended meanwhile.
            _ => return,
        };
        let (run, task) = match purpose {
            Purpose::Task(run, task) => (run, Some(task)),
            Purpose::End(run, _) => (run, None),
            // It belongs to no run.
            Purpose::MonitorDocking(_) => return self.act(MissionEffect::CallRouteAction { call, request }),
        };
        let Some(record) = self.records.runs.get(&run) else { return };
        let is_same =
            |known: &RouteActionRecord| known.place == place && known.request.action == request.action;
        if record.route_actions.iter().any(|known| is_same(known) && known.is_unknown()) {
            let reason = texts::ROUTE_ACTION_UNKNOWN.to_owned();
            return self.effects.push(MissionEffect::RefuseRouteAction { call, reason });
        }
        let task = task.and_then(|task| Some(record.tasks.get(task)?.planned.task));
        // What is not known to be harmless is not repeated.
        let is_idempotent = self.actions.get(&request.action).is_some_and(|info| info.is_idempotent);
        let step = RouteActionStep::Began { place, request: request.clone(), is_idempotent, task };
        self.emit(MissionEventKind::RouteAction { run, call, step });
        self.act(MissionEffect::CallRouteAction { call, request });
    }

    /// An action on the way has ended.
    pub(super) fn handle_route_action_end(&mut self, call: ActionCallId, result: ActionResult) {
        let Some(run) = self.find_open_route_action(call) else { return };
        let end = match result {
            ActionResult::Succeeded(result) => RouteActionEnd::Succeeded { result },
            ActionResult::Failed(reason) => RouteActionEnd::Failed(reason),
            ActionResult::Cancelled => RouteActionEnd::Cancelled,
            ActionResult::Unavailable => RouteActionEnd::Failed(texts::ACTION_NOT_OFFERED.to_owned()),
        };
        self.end_route_action(run, call, end);
    }

    /// An action on the way is not wanted any more. One that was not called yet is not called.
    pub(super) fn cancel_route_action(&mut self, call: ActionCallId) {
        let is_call = |effect: &MissionEffect| matches!(effect, MissionEffect::CallRouteAction { call: held, .. } if *held == call);
        let is_withdrawn = self.withdraw(is_call);
        let Some(run) = self.find_open_route_action(call) else { return };
        match is_withdrawn {
            true => self.end_route_action(run, call, RouteActionEnd::Cancelled),
            false => self.effects.push(MissionEffect::CancelAction(call)),
        }
    }

    fn end_route_action(&mut self, run: RunId, call: ActionCallId, end: RouteActionEnd) {
        let step = RouteActionStep::Ended(end);
        self.emit(MissionEventKind::RouteAction { run, call, step });
    }

    /// The program has started again, or the run ends: how its open actions end is not known. Returns one that must not be repeated, with the task to which the robot
    /// was on its way.
    pub(super) fn give_up_route_actions(&mut self, run: RunId) -> Option<(String, Option<TaskId>)> {
        let actions = self.records.runs.get(&run).map(|run| run.route_actions.clone()).unwrap_or_default();
        let mut unknown = None;
        for action in actions.into_iter().filter(|action| action.end.is_none()) {
            self.end_route_action(run, action.call, RouteActionEnd::OutcomeUnknown);
            if !action.is_idempotent {
                unknown = Some((action.request.action, action.task));
            }
        }
        unknown
    }

    /// After a restart: a person is asked about the task on whose way an action was begun that cannot be repeated without harm.
    pub(super) fn recover_route_actions(&mut self, run: RunId) {
        let Some((action, Some(task))) = self.give_up_route_actions(run) else { return };
        let Some(record) = self.records.runs.get(&run) else { return };
        let Some(index) = record.index_of(task) else { return };
        if record.tasks[index].state == TaskState::Navigating {
            let failure = Some(TaskFailure::RouteActionUnknown(action));
            self.fire_task(run, index, TaskTrigger::RouteActionUnknown, failure);
        }
    }
}
