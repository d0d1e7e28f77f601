//! Tasks that dock and undock. The runner does them itself: the robot moves by goals for docks, as it does for the end of a run, and the action, which follows, waits for the
//! charge. Nothing else is called, so after a restart such a task is begun anew without harm.

use super::battery::CHARGE_SIGNAL;
use super::interface::{ActionResult, GoalRequest};
use super::records::TaskRecord;
use super::runner::{ActionInProgress, Activity, MissionRunner, Purpose, RunLeg};
use super::table::TaskTrigger;
use super::task_docking::TaskDocking;
use crate::texts;
use site_model::{ActionReport, DockAction, DockId, ReachFailure, Reading, ReportTime, RunId, TaskFailure};
use vocab::{GoalId, Span};

impl TaskRecord {
    /// What the task asks for, if it docks or undocks.
    pub(super) fn dock_action(&self) -> Option<DockAction> {
        DockAction::of(self.planned.request.as_ref()?)
    }
}

impl MissionRunner {
    /// The robot goes to where a task docks, or out of its dock. It leaves another dock first.
    pub(super) fn request_dock_goal(
        &mut self,
        (run, task): (RunId, usize),
        goal: GoalId,
        action: DockAction,
        is_undocked: bool,
    ) {
        self.task_docking.dock = None;
        let purpose = Purpose::Task(run, task);
        let docked = self.situation.docked;
        let DockAction::Dock { dock: wanted, .. } = action else {
            return match docked {
                Some(_) => {
                    self.begin_leg(RunLeg { goal, purpose, is_undocking: false }, GoalRequest::Undock);
                }
                None => self.fire_task(run, task, TaskTrigger::Reached, None),
            };
        };
        if docked.is_some_and(|docked| wanted.is_none_or(|wanted| wanted == docked)) {
            return self.fire_task(run, task, TaskTrigger::Reached, None);
        }
        match self.choose_dock(run, task, wanted) {
            Ok(_) if docked.is_some() && !is_undocked => {
                self.begin_leg(RunLeg { goal, purpose, is_undocking: true }, GoalRequest::Undock);
            }
            Ok(dock) => {
                self.task_docking.dock = Some(dock);
                self.begin_leg(RunLeg { goal, purpose, is_undocking: false }, GoalRequest::Dock(dock));
            }
            Err(failure) => {
                let failure = Some(TaskFailure::NotReached(failure));
                self.fire_task(run, task, TaskTrigger::ReachFailed, failure);
            }
        }
    }

    /// The dock that a task goes to: the one that it names, or else the nearest of those that it has not failed to reach. Once all have failed, they are tried anew.
    ///
    /// # Errors
    /// The site lacks the dock, or no route leads there.
    fn choose_dock(
        &mut self,
        run: RunId,
        task: usize,
        wanted: Option<DockId>,
    ) -> Result<DockId, ReachFailure> {
        let of = Some((run, self.records.runs[&run].tasks[task].planned.task));
        if self.task_docking.of != of {
            self.task_docking = TaskDocking { of, ..TaskDocking::default() };
        }
        if wanted.is_none() {
            let reachable = self.docks_by_distance();
            if reachable.iter().all(|dock| self.task_docking.failed.contains(dock)) {
                self.task_docking.failed.clear();
            }
            let untried = |dock: &DockId| !self.task_docking.failed.contains(dock);
            if let Some(dock) = reachable.into_iter().find(untried) {
                return Ok(dock);
            }
        }
        let site = self.route_site.clone();
        let named = site.docks().find(|dock| wanted.is_none_or(|wanted| wanted == dock.id));
        let (dock, node) = named.map(|dock| (dock.id, dock.node)).ok_or(ReachFailure::NoSuchPlace)?;
        if !self.graph.contains(node) {
            return Err(ReachFailure::NoSuchPlace);
        }
        self.find_closed(node).map_or(Ok(dock), Err)
    }

    /// A goal of a task that docks has failed: another attempt begins with the next dock, if the task names none.
    pub(super) fn note_dock_failure(&mut self) {
        let dock = self.task_docking.dock.take();
        self.task_docking.failed.extend(dock);
    }

    /// How long the action of docking may take, as it is expected: the time of charging from the present charge.
    pub(super) fn expected_charging(&self, action: DockAction) -> Span {
        let DockAction::Dock { charge_until: Some(until), .. } = action else { return Span::ZERO };
        let charge = self.monitors.signal(CHARGE_SIGNAL).unwrap_or(0.0);
        Span::from_secs_f64(self.config.battery.charging_time_s(charge, until))
    }

    /// What the action under way asks for, if it is one of docking.
    pub(super) fn dock_action_of(&self, acting: &ActionInProgress) -> Option<DockAction> {
        self.records.runs.get(&acting.run)?.tasks.get(acting.task)?.dock_action()
    }

    /// Ends the docking or undocking that is under way, once it is done or has failed. Returns whether it has ended.
    pub(super) fn end_dock_action(&mut self) -> bool {
        let Some(Activity::Action(acting)) = self.activity else { return false };
        let Some(action) = self.dock_action_of(&acting) else { return false };
        let Some(result) = self.dock_result(action) else { return false };
        self.task_docking = TaskDocking::default();
        self.end_action(&acting, result);
        true
    }

    /// How docking or undocking has ended; none while the robot is charged and not full enough.
    fn dock_result(&mut self, action: DockAction) -> Option<ActionResult> {
        let DockAction::Dock { charge_until, .. } = action else {
            return Some(ActionResult::Succeeded(self.dock_report()));
        };
        if self.situation.docked.is_none() {
            let began = *self.task_docking.gap_began.get_or_insert(self.at);
            let has_failed = self.at - began >= self.config.dock_tasks.max_gap;
            return has_failed.then(|| ActionResult::Failed(texts::NOT_CHARGED_ANY_MORE.to_owned()));
        }
        self.task_docking.gap_began = None;
        let charge = self.monitors.signal(CHARGE_SIGNAL);
        let enough = charge_until.map(|until| until - self.config.dock_tasks.charge_tolerance);
        let is_charged = enough.is_none_or(|enough| charge.is_some_and(|charge| charge >= enough));
        is_charged.then(|| ActionResult::Succeeded(self.dock_report()))
    }

    /// The result: when it was done, and the charge.
    fn dock_report(&self) -> Option<String> {
        let charge = self.monitors.signal(CHARGE_SIGNAL);
        let reading = |charge: f64| Reading {
            name: "charge".to_owned(),
            // Tenths of a percent are what batteries tell.
            value: (charge * 1000.0).round() / 10.0,
            standard_deviation: None,
            unit: "%".to_owned(),
        };
        let at = ReportTime {
            robot_time: self.at,
            utc_ns: self.utc.map_or(0, |utc| utc.0),
            is_synchronised: self.is_clock_synchronised,
        };
        let report =
            ActionReport { at, readings: charge.map(reading).into_iter().collect(), ..Default::default() };
        serde_json::to_string(&report).ok()
    }
}
