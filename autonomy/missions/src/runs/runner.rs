//! The mission runner: state, inputs and outputs. What it does next is decided in `advance.rs`.

use super::interface::{
    ActionInfo, ActionResult, GoalRequest, MissionEffect, MissionInput, MissionNotice, MissionSituation,
    RouteGoalResult,
};
use super::monitors::MonitorBank;
use super::records::Records;
use super::runner_config::RunnerConfig;
use super::scheduler::Scheduler;
use super::table::{RunTrigger, TaskTrigger};
use crate::graph::{LearnedTimes, RouteConditions, RouteGraph, active_zones};
use site_model::{
    DockId, EndPlace, LocalTime, MissionEvent, MissionEventKind, MonitorId, ReachFailure, RunChangeReason,
    RunId, Site, TaskFailure, Utc, Zone,
};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;
use vocab::{ActionCallId, CommandId, GoalId, Stamp};

/// What the robot does for missions now.
#[derive(Clone, Debug)]
pub(super) enum Activity {
    /// It goes somewhere.
    Leg(RunLeg),
    /// It performs the action of a task.
    Action(ActionInProgress),
}

/// A goal that was requested, or waits for its commit.
#[derive(Clone, Copy, Debug)]
pub(super) struct RunLeg {
    pub goal: GoalId,
    pub purpose: Purpose,
    /// Whether the robot leaves its dock first.
    pub is_undocking: bool,
}

/// What a leg is for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Purpose {
    Task(RunId, usize),
    End(RunId, EndPlace),
    /// A monitor sends the robot to a dock.
    MonitorDocking(DockId),
}

/// An action that was called, or waits for its commit.
#[derive(Clone, Copy, Debug)]
pub(super) struct ActionInProgress {
    pub run: RunId,
    pub task: usize,
    pub call: ActionCallId,
    pub deadline: Stamp,
    /// Why it was cancelled, if it was.
    pub stop: Option<ActionCancelReason>,
}

/// Why an action was cancelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ActionCancelReason {
    ForSkip,
    ForEnd,
    ForInterrupt,
    TimedOut,
}

/// Attempts to dock for a monitor.
#[derive(Clone, Debug, Default)]
pub(super) struct MonitorDocking {
    pub tried: BTreeSet<DockId>,
    pub failures: u32,
    pub retry_at: Option<Stamp>,
}

/// Runs missions: a state machine without clock, files or random numbers. Inputs go in, effects come out, and whatever acts waits until the events before it
/// are durable.
#[derive(Clone, Debug)]
pub struct MissionRunner {
    pub(super) config: RunnerConfig,
    /// The newest site.
    pub(super) site: Arc<Site>,
    /// The site on which routes are planned: the newest, unless it lacks what the run under way needs.
    pub(super) route_site: Arc<Site>,
    pub(super) graph: RouteGraph,
    pub(super) learned: LearnedTimes,
    pub(super) actions: BTreeMap<String, ActionInfo>,
    pub(super) situation: MissionSituation,
    pub(super) utc: Option<Utc>,
    pub(super) records: Records,
    pub(super) activity: Option<Activity>,
    pub(super) monitor_docking: MonitorDocking,
    /// The open question with the end of its time.
    pub(super) question: Option<(RunId, usize, Stamp)>,
    pub(super) scheduler: Scheduler,
    pub(super) monitors: MonitorBank,
    /// Whether people were told that the clock is not synchronised.
    pub(super) is_clock_reported: bool,
    pub(super) at: Stamp,
    /// The command that is handled now.
    pub(super) command: Option<CommandId>,
    /// Whether the first update still has to take up what a restart left.
    is_restarting: bool,
    /// Events of this update.
    events: Vec<MissionEvent>,
    /// Effects that wait until they are durable.
    acts: Vec<MissionEffect>,
    /// Effects that do not wait.
    pub(super) effects: Vec<MissionEffect>,
    /// Effects of earlier updates, with the number of the commit that they wait for.
    held: VecDeque<(u64, Vec<MissionEffect>)>,
    next_commit: u64,
    /// Rows of both tables that were taken.
    #[cfg(test)]
    pub(super) taken: BTreeSet<(char, usize)>,
}

impl MissionRunner {
    /// A runner that takes up what these events leave. They are those of [`super::events_for_restart`], or all that were ever committed.
    pub fn restore<'a>(config: RunnerConfig, events: impl IntoIterator<Item = &'a MissionEvent>) -> Self {
        let records = Records::from_events(events);
        Self {
            scheduler: Scheduler::new(config.scheduler),
            monitors: MonitorBank::new(&config.battery),
            config,
            site: Arc::default(),
            route_site: Arc::default(),
            graph: RouteGraph::default(),
            learned: LearnedTimes::new(),
            actions: BTreeMap::new(),
            situation: MissionSituation::default(),
            utc: None,
            is_restarting: !records.runs.is_empty(),
            records,
            activity: None,
            monitor_docking: MonitorDocking::default(),
            question: None,
            is_clock_reported: false,
            at: Stamp::EPOCH,
            command: None,
            events: Vec::new(),
            acts: Vec::new(),
            effects: Vec::new(),
            held: VecDeque::new(),
            next_commit: 0,
            #[cfg(test)]
            taken: BTreeSet::new(),
        }
    }

    /// All records: runs with their tasks and results, decided slots, monitors.
    pub fn records(&self) -> &Records {
        &self.records
    }

    /// Why schedules wait now, if they do: the first monitor that blocks missions.
    pub fn blocked_by(&self) -> Option<MonitorId> {
        self.monitors.blocking(&self.records.monitors)
    }

    /// Handles one input. `at` is a clock that never steps.
    pub fn update(&mut self, at: Stamp, input: MissionInput) -> Vec<MissionEffect> {
        self.at = at;
        if std::mem::take(&mut self.is_restarting) {
            self.recover_runs();
        }
        match input {
            MissionInput::Tick => {}
            MissionInput::Command(command) => self.handle_command(&command),
            MissionInput::Goal { goal, result } => self.handle_goal(goal, result),
            MissionInput::Action { call, result } => self.handle_action(call, result),
            MissionInput::Committed(number) => self.release(number),
            MissionInput::Clock { utc, is_synchronised } => self.handle_clock(utc, is_synchronised),
            MissionInput::Situation(situation) => self.situation = situation,
            MissionInput::Signal { name, value } => self.handle_signal(&name, value),
            MissionInput::Site(site) => self.handle_site(site),
            MissionInput::Actions(actions) => self.actions = actions,
            MissionInput::RouteActionWanted { goal, call, place, request } => {
                self.handle_route_action(goal, call, place, request);
            }
            MissionInput::RouteActionEnded { call, result } => self.handle_route_action_end(call, result),
            MissionInput::RouteActionCancelled(call) => self.cancel_route_action(call),
            MissionInput::Traversed { edge, duration } => {
                self.learned.entry(edge).or_default().add(duration.secs_f64(), &self.config.routes);
            }
        }
        self.update_route_site();
        self.check_monitors();
        self.check_times();
        self.advance();
        self.command = None;
        self.flush()
    }

    fn handle_site(&mut self, site: Arc<Site>) {
        self.site = site;
        self.scheduler.forget();
        self.monitors.set(self.site.monitors(), &self.config.battery);
        if self.lacks_what_a_run_needs()
            && let Some(run) = self.records.active().map(|run| run.id)
        {
            self.notify(MissionNotice::PlanKept(run));
        }
        self.update_route_site();
    }

    /// Whether the newest site lacks a node of the run under way that the site of its routes has.
    fn lacks_what_a_run_needs(&self) -> bool {
        let tasks = self.records.active().into_iter().flat_map(|run| &run.tasks);
        let mut nodes = tasks.filter(|task| !task.state.is_outcome()).filter_map(|task| task.planned.node);
        nodes.any(|node| self.site.node(node).is_none() && self.route_site.node(node).is_some())
    }

    /// Plans routes on the newest site, as soon as that has what the run under way needs.
    pub(super) fn update_route_site(&mut self) {
        if !Arc::ptr_eq(&self.site, &self.route_site) && !self.lacks_what_a_run_needs() {
            self.route_site = self.site.clone();
            self.rebuild_graph();
        }
    }

    /// The site on which routes are planned: the newest, unless that lacks a place of the run under way.
    pub fn route_site(&self) -> &Arc<Site> {
        &self.route_site
    }

    /// The graph of [`Self::route_site`], with the blocks, zones and times that hold now. Linear in nodes and edges.
    pub fn route_graph(&mut self, at: Stamp) -> &RouteGraph {
        self.at = at;
        self.rebuild_graph();
        &self.graph
    }

    /// The zones that hold now. Linear in the zones.
    pub fn active_zones(&self) -> impl Iterator<Item = &Zone> {
        active_zones(&self.site, self.time_of_day())
    }

    /// The newest site, whatever site routes are planned on.
    pub fn newest_site(&self) -> &Arc<Site> {
        &self.site
    }

    /// The time of day in the site's time zone; none while it is not known.
    pub fn time_of_day(&self) -> Option<LocalTime> {
        self.scheduler.time_of_day(self.utc?)
    }

    /// The schedules as they are followed, for previews.
    pub fn scheduler(&self) -> &Scheduler {
        &self.scheduler
    }

    /// The graph with the blocks that hold now.
    pub(super) fn rebuild_graph(&mut self) {
        let time_of_day = self.time_of_day();
        let conditions = RouteConditions { now: self.at, time_of_day, learned: Some(&self.learned) };
        self.graph = RouteGraph::new(&self.route_site, &conditions, &self.config.routes);
    }

    fn handle_goal(&mut self, goal: GoalId, result: RouteGoalResult) {
        let Some(Activity::Leg(leg)) = self
            .activity
            .clone()
            .filter(|activity| matches!(activity, Activity::Leg(leg) if leg.goal == goal))
        else {
            return;
        };
        self.activity = None;
        match leg.purpose {
            Purpose::Task(run, task) => self.handle_task_leg(run, task, leg.is_undocking, result),
            Purpose::End(run, place) => match result {
                RouteGoalResult::Reached if leg.is_undocking => self.begin_end_leg(run, place, None, false),
                RouteGoalResult::Reached => self.fire_run(run, RunTrigger::EndReached),
                RouteGoalResult::MotionTaken | RouteGoalResult::Cancelled => {
                    self.fire_run(run, RunTrigger::MotionTaken);
                }
                // The next dock, if there is one.
                RouteGoalResult::Failed(_) if place == EndPlace::NearestDock => {}
                RouteGoalResult::Failed(_) => self.fire_run(run, RunTrigger::EndReached),
            },
            Purpose::MonitorDocking(dock) => match result {
                RouteGoalResult::Reached => self.monitor_docking = MonitorDocking::default(),
                RouteGoalResult::Failed(_) => {
                    self.monitor_docking.tried.insert(dock);
                }
                // It is begun anew as soon as the robot can move.
                RouteGoalResult::MotionTaken | RouteGoalResult::Cancelled => {}
            },
        }
    }

    fn handle_task_leg(&mut self, run: RunId, task: usize, is_undocking: bool, result: RouteGoalResult) {
        match result {
            RouteGoalResult::Reached if is_undocking => {
                self.fire_task(run, task, TaskTrigger::Undocked, None)
            }
            RouteGoalResult::Reached => self.fire_task(run, task, TaskTrigger::Reached, None),
            RouteGoalResult::Failed(reason) => {
                let reason = if is_undocking { ReachFailure::NotUndocked } else { reason };
                let failure = TaskFailure::NotReached(reason);
                self.fire_task(run, task, TaskTrigger::ReachFailed, Some(failure));
            }
            RouteGoalResult::MotionTaken | RouteGoalResult::Cancelled => {
                self.fire_run_because(run, RunTrigger::MotionTaken, RunChangeReason::MotionTaken);
            }
        }
    }

    fn handle_action(&mut self, call: ActionCallId, result: ActionResult) {
        let Some(Activity::Action(acting)) = self
            .activity
            .clone()
            .filter(|activity| matches!(activity, Activity::Action(acting) if acting.call == call))
        else {
            return;
        };
        self.end_action(&acting, result);
    }

    /// Ends the action of the present activity. The reason for which it was cancelled is a condition of the table, so the activity ends afterwards.
    pub(super) fn end_action(&mut self, acting: &ActionInProgress, result: ActionResult) {
        let (run, task) = (acting.run, acting.task);
        let failed = |failure| (TaskTrigger::ActionFailed, Some(failure));
        let (trigger, failure) = match (result, acting.stop) {
            (ActionResult::Succeeded(result), _) => {
                self.activity = None;
                self.succeed_task(run, task, result);
                return;
            }
            (ActionResult::Cancelled, Some(ActionCancelReason::TimedOut)) => {
                failed(TaskFailure::ActionTimedOut)
            }
            (ActionResult::Cancelled, Some(_)) => (TaskTrigger::ActionCancelled, None),
            (ActionResult::Cancelled, None) => {
                failed(TaskFailure::ActionFailed(crate::texts::CANCELLED_BY_PROGRAM.to_owned()))
            }
            // What was cancelled on purpose counts as cancelled, whatever is reported.
            (ActionResult::Failed(_), Some(ActionCancelReason::ForSkip | ActionCancelReason::ForEnd)) => {
                (TaskTrigger::ActionCancelled, None)
            }
            (ActionResult::Failed(reason), _) => failed(TaskFailure::ActionFailed(reason)),
            (ActionResult::Unavailable, Some(ActionCancelReason::ForSkip | ActionCancelReason::ForEnd)) => {
                (TaskTrigger::ActionCancelled, None)
            }
            (ActionResult::Unavailable, _) => failed(TaskFailure::ActionUnavailable),
        };
        self.fire_task(run, task, trigger, failure);
        if matches!(&self.activity, Some(Activity::Action(other)) if other.call == acting.call) {
            self.activity = None;
        }
    }

    /// Records an event, which is committed at the end of this update.
    pub(super) fn emit(&mut self, kind: MissionEventKind) {
        let event = MissionEvent { utc: self.utc, command: self.command, kind };
        self.records.apply(&event);
        self.events.push(event);
    }

    /// An effect that waits until all events so far are durable.
    pub(super) fn act(&mut self, effect: MissionEffect) {
        self.acts.push(effect);
    }

    /// Tells people, once what led to it is durable.
    pub(super) fn notify(&mut self, notice: MissionNotice) {
        self.act(MissionEffect::Notice(notice));
    }

    /// Requests a goal once that is durable. It is what the robot does now.
    pub(super) fn begin_leg(&mut self, leg: RunLeg, request: GoalRequest) {
        self.activity = Some(Activity::Leg(leg));
        self.act(MissionEffect::RequestGoal { goal: leg.goal, request });
    }

    /// Ends a goal that was requested, or will not be requested any more.
    pub(super) fn cancel_goal(&mut self, goal: GoalId) {
        if matches!(&self.activity, Some(Activity::Leg(leg)) if leg.goal == goal) {
            self.activity = None;
        }
        let is_request = |effect: &MissionEffect| matches!(effect, MissionEffect::RequestGoal { goal: held, .. } if *held == goal);
        if !self.withdraw(is_request) {
            self.effects.push(MissionEffect::CancelGoal(goal));
        }
    }

    /// Takes back an effect that waits for its commit. Whether there was one.
    pub(super) fn withdraw(&mut self, is_it: impl Fn(&MissionEffect) -> bool) -> bool {
        let waiting = self.held.iter_mut().map(|(_, effects)| effects);
        for effects in waiting.chain(std::iter::once(&mut self.acts)) {
            if let Some(index) = effects.iter().position(&is_it) {
                effects.remove(index);
                return true;
            }
        }
        false
    }

    /// A commit is durable: what waited for it is done.
    fn release(&mut self, number: u64) {
        while let Some((_, effects)) = self.held.pop_front_if(|(waiting, _)| *waiting <= number) {
            self.effects.extend(effects);
        }
    }

    fn flush(&mut self) -> Vec<MissionEffect> {
        let acts = std::mem::take(&mut self.acts);
        if !self.events.is_empty() {
            let number = self.next_commit;
            self.next_commit += 1;
            let events = std::mem::take(&mut self.events);
            self.effects.push(MissionEffect::Commit { number, events });
            self.held.push_back((number, acts));
        } else if let Some((_, last)) = self.held.back_mut() {
            last.extend(acts);
        } else {
            self.effects.extend(acts);
        }
        std::mem::take(&mut self.effects)
    }
}
