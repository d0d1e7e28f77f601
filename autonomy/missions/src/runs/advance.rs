//! What the robot does next.

use super::interface::{ActionResult, GoalRequest, MissionNotice};
use super::records::{Run, TaskRecord};
use super::runner::{ActionCancelReason, Activity, MissionRunner, MonitorDocking, Purpose, RunLeg};
use super::table::{RunTrigger, TaskTrigger};
use crate::ids::{goal_id, monitor_docking_goal_id};
use crate::order::{node_of, order_tasks};
use site_model::{
    ActionDescription, ActionRequest, AskDefault, DockAction, DockId, EndPlace, InspectionPoint, Mission,
    MissionEventKind, ObjectId, Parameter, PlannedTask, QuestionAnswer, Resumption, RunCause,
    RunChangeReason, RunId, RunPlan, RunState, Site, Task, TaskPlace, describe_action,
};
use vocab::Vec3;

/// Steps that one update takes at most. Each is a change of state, and no input leads to more than a few.
const MAX_STEPS: usize = 10_000;

impl MissionRunner {
    /// Takes steps until the robot has something to do or has to wait.
    pub(super) fn advance(&mut self) {
        for _ in 0..MAX_STEPS {
            if !self.interrupt() && !self.advance_once() {
                return;
            }
        }
    }

    /// Lets a monitor interrupt what the robot does. Whether anything has changed.
    fn interrupt(&mut self) -> bool {
        let Some((monitor, afterwards)) = self.monitors.sends_to_dock(&self.records.monitors) else {
            return false;
        };
        let Some(run) = self.records.active() else { return false };
        let (id, before) = (run.id, self.record_count());
        let goes_elsewhere = matches!(run.ending, Some((_, EndPlace::Node(_))));
        match (run.state, afterwards) {
            (RunState::Running, Resumption::Resume) => {
                let reason = RunChangeReason::MonitorHolds(monitor);
                self.fire_run_because(id, RunTrigger::InterruptBegan, reason);
            }
            (RunState::Running, Resumption::Drop) => self.fire_run(id, RunTrigger::InterruptDrops),
            (RunState::Ending, _) if goes_elsewhere => self.fire_run(id, RunTrigger::InterruptBegan),
            _ => {}
        }
        self.record_count() != before
    }

    /// Does one step. Returns whether there was one.
    fn advance_once(&mut self) -> bool {
        let active = self.records.active().map(|run| (run.id, run.state, run.ending));
        let is_on_errand =
            matches!(&self.activity, Some(Activity::Leg(RunLeg { purpose: Purpose::MonitorDocking(_), .. })));
        if let (true, Some((run, RunState::Ending, Some((_, EndPlace::Here))))) = (is_on_errand, active) {
            // The robot goes to a dock for a monitor, and the run ends without it.
            self.fire_run(run, RunTrigger::EndReached);
            return true;
        }
        if self.activity.is_some() {
            return self.end_dock_action();
        }
        match active {
            Some((run, RunState::Ending, Some((_, place)))) => {
                return self.finish(run, place);
            }
            Some((run, RunState::Restarted, _)) if self.situation.is_localised => {
                self.fire_run_because(run, RunTrigger::PlaceKnown, RunChangeReason::PlaceKnown);
                return true;
            }
            _ => {}
        }
        if !self.situation.is_localised || !self.situation.can_move {
            return false;
        }
        if self.monitors.sends_to_dock(&self.records.monitors).is_some() {
            return self.begin_errand();
        }
        match active {
            Some((run, RunState::Running, _)) => self.do_next_task(run),
            Some(_) => false,
            None => self.resume_suspended() || self.begin_queued(),
        }
    }

    fn do_next_task(&mut self, id: RunId) -> bool {
        let Some(run) = self.records.runs.get(&id) else { return false };
        if run.question.is_some() {
            return false;
        }
        match run.next_task() {
            Some(task) => self.fire_task(id, task, TaskTrigger::SetOut, None),
            None => self.fire_run(id, RunTrigger::TasksDone),
        }
        true
    }

    /// Brings a run that ends to its end. Whether there was a step.
    fn finish(&mut self, run: RunId, place: EndPlace) -> bool {
        let is_there = match place {
            EndPlace::Here => true,
            EndPlace::NearestDock => self.situation.docked.is_some(),
            EndPlace::Node(node) => self.situation.place.at == Some(node),
        };
        if is_there {
            self.fire_run(run, RunTrigger::EndReached);
            return true;
        }
        if !self.situation.is_localised || !self.situation.can_move {
            return false;
        }
        let tried = self.records.runs.get(&run).map(|run| run.docks_tried.clone()).unwrap_or_default();
        let dock = match place {
            EndPlace::NearestDock => self.docks_by_distance().into_iter().find(|dock| !tried.contains(dock)),
            _ => None,
        };
        if place == EndPlace::NearestDock && dock.is_none() {
            // A site without docks has nothing to report.
            if self.route_site.docks().next().is_some() {
                self.notify(MissionNotice::NoDockReached);
            }
            self.fire_run(run, RunTrigger::EndReached);
            return true;
        }
        self.begin_end_leg(run, place, dock, self.situation.docked.is_some());
        true
    }

    /// Sets out to where a run ends.
    pub(super) fn begin_end_leg(
        &mut self,
        run: RunId,
        place: EndPlace,
        dock: Option<DockId>,
        is_undocking: bool,
    ) {
        let Some(steps) = self.records.runs.get(&run).map(|run| run.steps) else { return };
        let goal = goal_id(run, steps);
        let request = match (is_undocking, dock, place) {
            (true, ..) => GoalRequest::Undock,
            (_, Some(dock), _) => GoalRequest::Dock(dock),
            (_, None, EndPlace::Node(node)) => self.goal_to(node),
            (_, None, EndPlace::Here | EndPlace::NearestDock) => return,
        };
        self.emit(MissionEventKind::RunSetOutToEnd { run, goal, dock });
        self.begin_leg(RunLeg { goal, purpose: Purpose::End(run, place), is_undocking }, request);
    }

    /// Sends the robot to a dock for a monitor. Whether it set out.
    fn begin_errand(&mut self) -> bool {
        if self.situation.docked.is_some() {
            self.monitor_docking = MonitorDocking::default();
            return false;
        }
        if self.monitor_docking.retry_at.is_some_and(|retry_at| self.at < retry_at) {
            return false;
        }
        let docks = self.docks_by_distance();
        let Some(dock) = docks.into_iter().find(|dock| !self.monitor_docking.tried.contains(dock)) else {
            let doublings = self.monitor_docking.failures.min(20);
            let wait = (self.config.dock_retry * (1_i64 << doublings)).min(self.config.max_dock_retry);
            self.monitor_docking.failures += 1;
            self.monitor_docking.retry_at = Some(self.at + wait);
            self.monitor_docking.tried.clear();
            self.notify(MissionNotice::NoDockReached);
            return false;
        };
        self.monitor_docking.retry_at = None;
        let number = self.records.dockings;
        let goal = monitor_docking_goal_id(number);
        self.emit(MissionEventKind::DockingBegan { number, dock, goal });
        let leg = RunLeg { goal, purpose: Purpose::MonitorDocking(dock), is_undocking: false };
        self.begin_leg(leg, GoalRequest::Dock(dock));
        true
    }

    fn resume_suspended(&mut self) -> bool {
        let Some(run) = self.records.suspended().map(|run| run.id) else { return false };
        // The mission of a monitor comes first.
        if self.queued_by_monitor().is_some() {
            return false;
        }
        self.fire_run_because(run, RunTrigger::InterruptEnded, RunChangeReason::MonitorsReleased);
        true
    }

    fn queued_by_monitor(&self) -> Option<RunId> {
        let is_by_monitor = |run: &RunId| matches!(self.records.runs[run].cause, RunCause::Monitor(_));
        self.records.queue().into_iter().find(is_by_monitor)
    }

    fn begin_queued(&mut self) -> bool {
        let is_blocked = self.blocked_by().is_some();
        let next = match is_blocked {
            true => self.queued_by_monitor(),
            false => self.records.queue().first().copied(),
        };
        let Some(run) = next else { return false };
        self.begin_run(run);
        true
    }

    fn begin_run(&mut self, id: RunId) {
        let site = self.site.clone();
        let Some(mission) = self.records.runs.get(&id).and_then(|run| site.mission(run.mission)) else {
            return self.fire_run(id, RunTrigger::MissionMissing);
        };
        let plan = self.plan(&site, mission);
        // The table has one row for this, and its event carries the plan.
        #[cfg(test)]
        self.taken.insert(('r', 0));
        self.emit(MissionEventKind::RunBegan { run: id, plan });
    }

    fn plan(&mut self, site: &Site, mission: &Mission) -> RunPlan {
        self.rebuild_graph();
        let order = match self.situation.place.nearest {
            Some(start) => order_tasks(site, &self.graph, mission, start, &self.config.tour).order,
            None => mission.tasks.iter().map(|task| task.id).collect(),
        };
        let task = |id| mission.tasks.iter().find(|task| task.id == id);
        let tasks: Vec<&Task> = order.into_iter().filter_map(task).collect();
        let mut revisions = vec![ObjectId::Mission(mission.id)];
        for task in &tasks {
            if let TaskPlace::InspectionPoint(point) = task.place {
                revisions.push(ObjectId::InspectionPoint(point));
            }
            revisions.extend(node_of(site, task).map(ObjectId::Node));
        }
        revisions.sort_unstable();
        revisions.dedup();
        let revisions = revisions.into_iter().filter_map(|id| Some((id, site.revision(id)?)));
        RunPlan {
            tasks: tasks.into_iter().map(|task| self.plan_task(site, task)).collect(),
            revisions: revisions.collect(),
            end: mission.end,
        }
    }

    fn plan_task(&self, site: &Site, task: &Task) -> PlannedTask {
        let request = match &task.place {
            TaskPlace::InspectionPoint(point) => site.inspection_point(*point).map(aimed_request),
            TaskPlace::Node { request, .. } => request.clone(),
            TaskPlace::ByAction { request } => Some(request.clone()),
        };
        let info = request.as_ref().and_then(|request| self.actions.get(&request.action));
        let docks = request.as_ref().is_some_and(|request| DockAction::of(request).is_some());
        PlannedTask {
            task: task.id,
            node: node_of(site, task),
            // What is not known to be harmless is not repeated.
            is_idempotent: docks || info.is_some_and(|info| info.is_idempotent),
            request,
            on_unreachable: task.on_unreachable,
            on_action_failure: task.on_action_failure,
        }
    }

    /// Ends what takes too long: actions, and questions that nobody answers.
    pub(super) fn check_times(&mut self) {
        if let Some(Activity::Action(acting)) = &self.activity
            && self.at >= acting.deadline
        {
            let acting = *acting;
            match acting.stop {
                None => self.cancel_action(ActionCancelReason::TimedOut),
                Some(stop) => {
                    self.notify(MissionNotice::ActionSilent(acting.call));
                    if stop == ActionCancelReason::ForInterrupt {
                        self.activity = None;
                        self.fire_task(acting.run, acting.task, TaskTrigger::OutcomeUnknown, None);
                    } else {
                        self.end_action(&acting, ActionResult::Cancelled);
                    }
                }
            }
        }
        let open = self.records.active().filter(|run| run.state == RunState::Running);
        let open = open.and_then(|run| Some((run.id, run.question?)));
        match (open, self.question) {
            (None, _) => self.question = None,
            (Some((run, task)), Some((asked_by, about, until))) if (asked_by, about) == (run, task) => {
                if self.at >= until {
                    self.question = None;
                    let (_, default) = self.question_of(run, task);
                    self.answer_question(run, task, default_answer(default), true);
                }
            }
            (Some((run, task)), _) => {
                let (time_limit, _) = self.question_of(run, task);
                self.question = Some((run, task, self.at + time_limit));
            }
        }
    }

    fn question_of(&self, run: RunId, task: usize) -> (vocab::Span, AskDefault) {
        let record: Option<&TaskRecord> = self.records.runs.get(&run).and_then(|run| run.tasks.get(task));
        let limit = self.config.question_time_limit;
        record.map_or((limit, AskDefault::Skip), |record| record.question(limit))
    }

    pub(super) fn answer_question(
        &mut self,
        run: RunId,
        task: usize,
        answer: QuestionAnswer,
        is_default: bool,
    ) {
        let id = self.records.runs[&run].tasks[task].planned.task;
        self.emit(MissionEventKind::QuestionAnswered { run, task: id, answer, is_default });
        let (trigger, end) = match answer {
            QuestionAnswer::TryAgain => (TaskTrigger::AnsweredTryAgain, None),
            QuestionAnswer::Skip => (TaskTrigger::AnsweredSkip, None),
            QuestionAnswer::EndAtDock => (TaskTrigger::AnsweredEnd, Some(RunTrigger::TaskEndsAtDock)),
            QuestionAnswer::EndHere => (TaskTrigger::AnsweredEnd, Some(RunTrigger::TaskEndsHere)),
        };
        self.fire_task(run, task, trigger, None);
        if let Some(trigger) = end {
            self.fire_run(run, trigger);
        }
    }

    /// Number of changes so far, to see whether anything has changed.
    fn record_count(&self) -> (u64, usize) {
        let steps = self.records.runs.values().map(|run: &Run| run.steps).sum();
        let stopped = matches!(&self.activity, Some(Activity::Action(acting)) if acting.stop.is_some());
        (steps, self.records.runs.len() + usize::from(stopped))
    }
}

/// The action of an inspection point, with its target where it is aimed at one, and with the gauge that is read.
fn aimed_request(point: &InspectionPoint) -> ActionRequest {
    let mut request = point.request.clone();
    let known = describe_action(&request.action);
    if let Some(dial) = &point.gauge
        && known.is_some_and(ActionDescription::takes_gauge)
    {
        request.parameters.insert(site_model::GAUGE_PARAMETER.to_owned(), dial.parameter());
    }
    if !known.is_none_or(ActionDescription::takes_target) {
        return request;
    }
    let Vec3 { x, y, z } = point.target_m;
    let target = Parameter::List([x, y, z].map(Parameter::Number).into());
    request.parameters.insert(site_model::TARGET_PARAMETER.to_owned(), target);
    request
}

fn default_answer(default: AskDefault) -> QuestionAnswer {
    match default {
        AskDefault::Skip => QuestionAnswer::Skip,
        AskDefault::EndAtDock => QuestionAnswer::EndAtDock,
        AskDefault::EndHere => QuestionAnswer::EndHere,
    }
}
