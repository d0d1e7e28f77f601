//! A runner with a world around it: what is durable, where the robot is, and what it was told to do.

use super::interface::{
    ActionInfo, ActionResult, GoalRequest, MissionEffect, MissionInput, MissionSituation, RouteGoalResult,
};
use super::runner::MissionRunner;
use super::runner_config::RunnerConfig;
use crate::graph::GraphPlace;
use crate::testing::{SiteBuilder, edge_id, node_id};
use site_model::{
    ActionRequest, DockId, EdgeStage, FailurePolicy, FailureStep, Mission, MissionCommand,
    MissionCommandKind, MissionEnd, MissionEvent, MissionId, NodeId, Object, Parameters, RouteActionPlace,
    RunId, SiteSettings, Task, TaskId, TaskOrder, TaskPlace, Utc,
};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{ActionCallId, CommandId, GoalId, Span, Stamp};

pub(super) fn run_id(number: u128) -> RunId {
    RunId(Uuid::from_u128(number))
}

pub(super) fn mission_id(number: u128) -> MissionId {
    MissionId(Uuid::from_u128(number))
}

/// Task of a mission, both counted from 1.
pub(super) fn task_id(mission: u128, task: u128) -> TaskId {
    TaskId(Uuid::from_u128(mission * 100 + task))
}

pub(super) fn dock_id(number: u128) -> DockId {
    DockId(Uuid::from_u128(number))
}

pub(super) fn task(
    mission: u128,
    number: u128,
    node: u128,
    action: Option<&str>,
    policies: [FailurePolicy; 2],
) -> Task {
    let request =
        action.map(|action| ActionRequest { action: action.to_owned(), parameters: Parameters::new() });
    Task {
        id: task_id(mission, number),
        place: TaskPlace::Node { node: node_id(node), request },
        on_unreachable: policies[0],
        on_action_failure: policies[1],
    }
}

pub(super) fn mission(number: u128, tasks: Vec<Task>, end: MissionEnd) -> Mission {
    let name = format!("Mission {number}");
    let (order, order_constraints) = (TaskOrder::AsListed, Vec::new());
    Mission { id: mission_id(number), name, tasks, order, order_constraints, end }
}

pub(super) fn policy(retries: u8, then: FailureStep) -> FailurePolicy {
    FailurePolicy { retries, then }
}

/// Dock 91 at node 1, before it node 2; places 3, 4 and 5 along a corridor; dock 92 at node 7, before it node 6.
pub(super) fn corridor() -> SiteBuilder {
    let mut builder = SiteBuilder::new();
    builder.put(Object::Settings(SiteSettings {
        name: "Corridor".to_owned(),
        time_zone: "Europe/London".to_owned(),
        map: None,
    }));
    for number in 1..=7 {
        builder.node(number, 7.0 * number as f64, 0.0);
    }
    for number in 1..7 {
        builder.pair(number, number + 1);
    }
    builder.dock(91, 1, 2).dock(92, 7, 6);
    builder
}

/// A runner in its world.
pub(super) struct Rig {
    pub runner: MissionRunner,
    pub config: RunnerConfig,
    pub now: Stamp,
    pub site: SiteBuilder,
    pub situation: MissionSituation,
    pub actions: BTreeMap<String, ActionInfo>,
    /// What was committed and survives a restart.
    pub durable: Vec<MissionEvent>,
    /// Commits that are not durable yet.
    pub waiting: Vec<(u64, Vec<MissionEvent>)>,
    pub holds_commits: bool,
    /// The goal under way.
    pub goal: Option<(GoalId, GoalRequest)>,
    /// The action under way, with its task, and whether it was cancelled.
    pub call: Option<(ActionCallId, RunId, TaskId, ActionRequest, bool)>,
    /// All calls that were ever made.
    pub calls: Vec<(RunId, TaskId, ActionCallId)>,
    /// Actions on the way that were called.
    pub route_calls: Vec<(ActionCallId, String)>,
    pub commands: u128,
    /// Effects since they were last looked at.
    pub seen: Vec<MissionEffect>,
    /// Rows that were taken by earlier runners.
    pub taken: BTreeSet<(char, usize)>,
}

impl Rig {
    /// The robot stands in dock 91 of the corridor.
    pub fn new() -> Self {
        let info = |is_idempotent, seconds: i64| ActionInfo {
            is_idempotent,
            expected: Span::from_millis(seconds * 1000),
        };
        let actions = [("photo", info(true, 10)), ("spectrum", info(false, 60))];
        let place = GraphPlace { at: Some(node_id(1)), nearest: Some(node_id(1)), on: None };
        let config = RunnerConfig::default();
        let mut rig = Self {
            runner: MissionRunner::restore(config.clone(), []),
            config,
            now: Stamp::EPOCH,
            site: corridor(),
            situation: MissionSituation {
                place,
                is_localised: true,
                can_move: true,
                docked: Some(dock_id(91)),
            },
            actions: actions.map(|(name, info)| (name.to_owned(), info)).into(),
            durable: Vec::new(),
            waiting: Vec::new(),
            holds_commits: false,
            goal: None,
            call: None,
            calls: Vec::new(),
            route_calls: Vec::new(),
            commands: 0,
            seen: Vec::new(),
            taken: BTreeSet::new(),
        };
        rig.introduce();
        rig
    }

    /// Tells a new runner of the world.
    fn introduce(&mut self) {
        self.input(MissionInput::Actions(self.actions.clone()));
        self.input(MissionInput::Site(Arc::new(self.site.site())));
        self.input(MissionInput::Situation(self.situation));
    }

    pub fn put(&mut self, object: Object) {
        self.site.put(object);
        self.input(MissionInput::Site(Arc::new(self.site.site())));
    }

    pub fn set_situation(&mut self, change: impl FnOnce(&mut MissionSituation)) {
        change(&mut self.situation);
        self.input(MissionInput::Situation(self.situation));
    }

    pub fn command(&mut self, kind: MissionCommandKind) {
        self.commands += 1;
        let id = CommandId(Uuid::from_u128(10_000 + self.commands));
        self.input(MissionInput::Command(MissionCommand { id, account: None, kind }));
    }

    pub fn clock(&mut self, utc: Utc, is_synchronised: bool) {
        self.input(MissionInput::Clock { utc, is_synchronised });
    }

    /// Gives an input to the runner, and applies its effects.
    pub fn input(&mut self, input: MissionInput) {
        let effects = self.runner.update(self.now, input);
        self.apply(effects);
        if !self.holds_commits {
            self.commit();
        }
    }

    /// Makes what was committed durable.
    pub fn commit(&mut self) {
        while !self.waiting.is_empty() {
            let (number, events) = self.waiting.remove(0);
            self.durable.extend(events);
            let effects = self.runner.update(self.now, MissionInput::Committed(number));
            self.apply(effects);
        }
    }

    fn apply(&mut self, effects: Vec<MissionEffect>) {
        for effect in effects {
            match &effect {
                MissionEffect::Commit { number, events } => self.waiting.push((*number, events.clone())),
                MissionEffect::RequestGoal { goal, request } => self.goal = Some((*goal, *request)),
                MissionEffect::CancelGoal(goal) => {
                    if self.goal.is_some_and(|(running, _)| running == *goal) {
                        self.goal = None;
                    }
                }
                MissionEffect::CallAction { call, run, task, request } => {
                    // One that does not end after it was cancelled is given up.
                    let is_over = self.call.as_ref().is_none_or(|(.., is_cancelled)| *is_cancelled);
                    assert!(is_over, "two actions at a time");
                    self.calls.push((*run, *task, *call));
                    self.call = Some((*call, *run, *task, request.clone(), false));
                }
                MissionEffect::CancelAction(call) => {
                    if let Some((running, .., is_cancelled)) = &mut self.call
                        && running == call
                    {
                        *is_cancelled = true;
                    }
                }
                MissionEffect::CallRouteAction { call, request } => {
                    self.route_calls.push((*call, request.action.clone()));
                }
                MissionEffect::RefuseRouteAction { .. }
                | MissionEffect::Answer { .. }
                | MissionEffect::Notice(_) => {}
            }
            self.seen.push(effect);
        }
    }

    /// The goal under way ends. If it is reached, the robot is there.
    pub fn end_goal(&mut self, result: RouteGoalResult) {
        let Some((goal, request)) = self.goal.take() else { return };
        if result == RouteGoalResult::Reached {
            let docks: BTreeMap<DockId, u128> = [(dock_id(91), 1), (dock_id(92), 7)].into();
            let place = |node: NodeId| GraphPlace { at: Some(node), nearest: Some(node), on: None };
            (self.situation.place, self.situation.docked) = match request {
                GoalRequest::Route(node) => (place(node), None),
                GoalRequest::Dock(dock) => (place(node_id(docks[&dock])), Some(dock)),
                GoalRequest::Undock => (self.situation.place, None),
            };
            self.input(MissionInput::Situation(self.situation));
        }
        self.input(MissionInput::Goal { goal, result });
    }

    /// The action under way ends.
    pub fn end_action(&mut self, result: ActionResult) {
        if let Some((call, ..)) = self.call.take() {
            self.input(MissionInput::Action { call, result });
        }
    }

    /// The route of the goal under way needs an action at the beginning of an edge.
    pub fn want_route_action(&mut self, number: u128, (from, to): (u128, u128), action: &str) {
        let Some((goal, _)) = self.goal else { return };
        let place = RouteActionPlace::Edge { edge: edge_id(from, to), stage: EdgeStage::Enter, index: 0 };
        let request = ActionRequest { action: action.to_owned(), parameters: Parameters::new() };
        let call = ActionCallId(Uuid::from_u128(20_000 + number));
        self.input(MissionInput::RouteActionWanted { goal, call, place, request });
    }

    /// The last action on the way ends.
    pub fn end_route_action(&mut self, result: ActionResult) {
        if let Some((call, _)) = self.route_calls.last().cloned() {
            self.input(MissionInput::RouteActionEnded { call, result });
        }
    }

    /// Time passes by whole seconds.
    pub fn wait(&mut self, seconds: u32) {
        for _ in 0..seconds {
            self.now += Span::from_millis(1000);
            self.input(MissionInput::Tick);
        }
    }

    /// The program ends, and begins again. What was not durable is lost; goals and actions end unheard.
    pub fn restart(&mut self) {
        self.waiting.clear();
        (self.goal, self.call) = (None, None);
        self.taken.extend(&self.runner.taken);
        self.runner = MissionRunner::restore(self.config.clone(), &super::events_for_restart(&self.durable));
        self.introduce();
    }
}
