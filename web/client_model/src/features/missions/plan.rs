//! What it takes to run a mission: the route from task to task over the topological map, its time, and what cannot be reached. With the code that the robot
//! uses.

use crate::features::site::{ActionForms, ParameterField, ParameterProblem};
use api::OfferedAction;
use missions::{
    BatteryConfig, NoRoute, RouteConditions, RouteConfig, RouteCost, RouteGraph, TourConfig, node_of,
    order_tasks,
};
use site_model::{
    ActionRequest, DockId, Mission, MissionEnd, NodeId, Site, Task, TaskId, TaskOrder, TaskPlace,
    describe_action,
};
use std::collections::BTreeMap;
use std::sync::Arc;
use vocab::{Stamp, Vec3};

/// Parameters of [`plan`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MissionPlanConfig {
    /// Interval in which a plan is made anew while edges are blocked, seconds: blocks end. Chosen: the shortest block is a minute, so that a plan is late by a sixth of
    /// it.
    pub(crate) blocks_interval_s: f64,
    /// Least gain of another order that is worth a proposal, seconds of walking. Chosen: below a second, times of edges are not known.
    pub(crate) min_gain_s: f64,
}

impl Default for MissionPlanConfig {
    fn default() -> Self {
        Self { blocks_interval_s: 10.0, min_gain_s: 1.0 }
    }
}

/// A mission with its route.
#[derive(Clone, Debug, PartialEq)]
pub struct MissionPlan {
    /// As it is shown: with the drag that has not ended, or in the order that is proposed.
    pub mission: Mission,
    /// Where the route begins; `None` if the site has no node for it.
    pub start: Option<(PlanStart, NodeId)>,
    /// The tasks in the order in which they are done.
    pub stops: Vec<PlannedStop>,
    /// The route after the last task.
    pub end: PlannedEnd,
    /// Expected time of all, seconds.
    pub time_s: f64,
    /// Length of the route, metres.
    pub length_m: f64,
    /// Share of the battery's charge that all is expected to use, 0 to 1 and more.
    pub charge_used: f64,
    /// What the shortest order would gain, if it would gain anything; for a mission that is always run in the shortest order, what that gains over the list.
    pub gain: Option<OrderGain>,
}

impl MissionPlan {
    /// Expected time of all, seconds, and length of the route, metres.
    pub fn cost(&self) -> RouteCost {
        RouteCost { time_s: self.time_s, length_m: self.length_m }
    }

    /// What is planned for a task, and its number on the way, from 1.
    pub fn stop_of(&self, task: TaskId) -> Option<(usize, &PlannedStop)> {
        (1..).zip(&self.stops).find(|(_, stop)| stop.task == task)
    }
}

/// Where the route of a plan begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanStart {
    /// At a dock: missions begin there as a rule.
    Dock(DockId),
    /// At the node nearest to the robot, where the site has no dock.
    Robot,
    /// At the first task, where the robot's place is not known either.
    FirstTask,
}

/// A task on the way.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedStop {
    /// Which task.
    pub task: TaskId,
    /// Where; `None` if the site lacks its place.
    pub node: Option<NodeId>,
    /// The nodes of the route from the stop before, with both ends; empty if there is no route.
    pub route: Vec<NodeId>,
    /// What that route takes.
    pub walk: RouteCost,
    /// Expected time of the action, seconds.
    pub action_s: f64,
    /// Energy that the action is expected to take besides what the standing robot takes, joules.
    pub action_j: f64,
    /// Why it cannot be done.
    pub problem: Option<StopProblem>,
}

/// Why a task cannot be done.
#[derive(Clone, Debug, PartialEq)]
pub enum StopProblem {
    /// The site lacks its inspection point or node.
    NoPlace,
    /// There is no route from here.
    NoRoute(NodeId, NoRoute),
    /// A parameter of its action is wrong.
    Parameter(Arc<ParameterField>, ParameterProblem),
}

/// The route after the last task.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlannedEnd {
    /// Its nodes, with both ends; empty if the mission ends where the last task is, or there is no route.
    pub route: Vec<NodeId>,
    /// What it takes.
    pub walk: RouteCost,
    /// Why there is no route.
    pub problem: Option<EndProblem>,
}

/// Why a mission cannot end where it should.
#[derive(Clone, Debug, PartialEq)]
pub enum EndProblem {
    /// The site has no dock.
    NoDock,
    /// There is no route from here.
    NoRoute(NodeId, NoRoute),
}

/// What the shortest order gains over that of the list.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderGain {
    /// Time, seconds, and length, metres.
    pub saved: RouteCost,
    /// All tasks in that order.
    pub order: Vec<TaskId>,
    /// Whether no order is shorter. Otherwise a shorter one may exist.
    pub is_shortest: bool,
}

/// What holds besides the site when a plan is made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PlanConditions<'a> {
    /// Time on the robot's clock, by which blocks of edges end; `None` if it is not known.
    pub(crate) now: Option<Stamp>,
    /// Position of the robot in the site's map, metres.
    pub(crate) robot: Option<Vec3>,
    /// The forms of actions, and those that the robot offers; `None`: parameters are not looked at, and no action is known but those of the platform.
    pub(crate) forms: Option<&'a ActionForms>,
}

/// Whether a plan is made for a mission at rest, and in which order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PlanOrder {
    /// While tasks are dragged: other orders are not looked for.
    Dragged,
    /// As the mission says.
    Own,
    /// In the order that is proposed.
    Proposed,
}

/// Where a plan for a mission begins.
pub(crate) fn start_of(
    site: &Site,
    mission: &Mission,
    conditions: &PlanConditions<'_>,
) -> Option<(PlanStart, NodeId)> {
    let dock = site.docks().find(|dock| site.node(dock.node).is_some());
    let squared_m2 = |at: Vec3, node: &site_model::Node| {
        let position = node.map_from_node.position;
        (position.x - at.x).powi(2) + (position.y - at.y).powi(2) + (position.z - at.z).powi(2)
    };
    let nearest = |at: Vec3| {
        let by_distance =
            |a: &&site_model::Node, b: &&site_model::Node| squared_m2(at, a).total_cmp(&squared_m2(at, b));
        site.nodes().min_by(by_distance).map(|node| node.id)
    };
    let of_dock = dock.map(|dock| (PlanStart::Dock(dock.id), dock.node));
    let of_robot = || Some((PlanStart::Robot, nearest(conditions.robot?)?));
    let of_task = || mission.tasks.iter().find_map(|task| Some((PlanStart::FirstTask, node_of(site, task)?)));
    of_dock.or_else(of_robot).or_else(of_task)
}

/// Plans a mission. One search of the graph for each task.
pub(crate) fn plan(
    site: &Site,
    mission: Mission,
    order: PlanOrder,
    conditions: &PlanConditions<'_>,
    config: &MissionPlanConfig,
) -> MissionPlan {
    // Without the robot's clock every block counts.
    let now = conditions.now.unwrap_or(Stamp::EPOCH);
    let graph = RouteGraph::new(
        site,
        &RouteConditions { now, ..RouteConditions::default() },
        &RouteConfig::default(),
    );
    let start = start_of(site, &mission, conditions);
    let node = start.map(|(_, node)| node);
    let gain = node
        .filter(|_| order != PlanOrder::Dragged)
        .and_then(|node| find_gain(site, &graph, &mission, node, config.min_gain_s));
    let mut shown = mission;
    if let (PlanOrder::Proposed, Some(gain)) = (order, &gain) {
        put_in_order(&mut shown, &gain.order);
    }
    let walked = match (shown.order, node) {
        (TaskOrder::Shortest { .. }, Some(node)) => {
            order_tasks(site, &graph, &shown, node, &TourConfig::default()).order
        }
        _ => shown.tasks.iter().map(|task| task.id).collect(),
    };
    let tasks: BTreeMap<TaskId, &Task> = shown.tasks.iter().map(|task| (task.id, task)).collect();
    let mut place = node;
    let stops: Vec<PlannedStop> = walked
        .iter()
        .filter_map(|id| tasks.get(id))
        .map(|task| {
            let stop = plan_stop(site, &graph, task, place, conditions.forms);
            if stop.problem.is_none() || !stop.route.is_empty() {
                place = stop.node.or(place);
            }
            stop
        })
        .collect();
    let end =
        if shown.tasks.is_empty() { PlannedEnd::default() } else { plan_end(site, &graph, shown.end, place) };
    let time_s = stops.iter().map(|stop| stop.walk.time_s + stop.action_s).sum::<f64>() + end.walk.time_s;
    let length_m = stops.iter().map(|stop| stop.walk.length_m).sum::<f64>() + end.walk.length_m;
    let walk_s = stops.iter().map(|stop| stop.walk.time_s).sum::<f64>() + end.walk.time_s;
    let action_s = stops.iter().map(|stop| stop.action_s).sum::<f64>();
    let action_j = stops.iter().map(|stop| stop.action_j).sum::<f64>();
    let charge_used = BatteryConfig::default().charge_used(walk_s, action_s, action_j);
    MissionPlan { mission: shown, start, stops, end, time_s, length_m, charge_used, gain }
}

/// Brings the list of a mission into an order. Tasks that the order lacks come last.
pub fn put_in_order(mission: &mut Mission, order: &[TaskId]) {
    let place = |task: &Task| order.iter().position(|id| *id == task.id).unwrap_or(order.len());
    mission.tasks.sort_by_key(place);
}

/// What the shortest order gains over the list, unless that is less than `min_gain_s`.
fn find_gain(
    site: &Site,
    graph: &RouteGraph,
    mission: &Mission,
    start: NodeId,
    min_gain_s: f64,
) -> Option<OrderGain> {
    let order = match mission.order {
        TaskOrder::AsListed => TaskOrder::Shortest { keep_first: false, keep_last: false },
        kept @ TaskOrder::Shortest { .. } => kept,
    };
    let shortest = Mission { order, ..mission.clone() };
    let preview = order_tasks(site, graph, &shortest, start, &TourConfig::default());
    let saved = preview.gain().filter(|saved| saved.time_s >= min_gain_s)?;
    Some(OrderGain { saved, order: preview.order, is_shortest: preview.is_shortest })
}

/// The action of a task; `None` for a visit, or where the site lacks the inspection point.
pub fn request_of<'a>(site: &'a Site, task: &'a Task) -> Option<&'a ActionRequest> {
    match &task.place {
        TaskPlace::InspectionPoint(point) => Some(&site.inspection_point(*point)?.request),
        TaskPlace::Node { request, .. } => request.as_ref(),
    }
}

/// Expected time, seconds, and energy, joules, of an action: by the catalogue of the platform, or as the robot offers it.
fn expected_of(request: &ActionRequest, offered: &[OfferedAction]) -> (f64, f64) {
    let registered = || offered.iter().find(|action| action.name == request.action);
    match describe_action(&request.action) {
        Some(known) => {
            (known.expected_time_s(&request.parameters), known.expected_energy_j(&request.parameters))
        }
        None => registered()
            .map_or((0.0, 0.0), |action| (action.expected.secs_f64(), f64::from(action.expected_energy_j))),
    }
}

fn plan_stop(
    site: &Site,
    graph: &RouteGraph,
    task: &Task,
    from: Option<NodeId>,
    forms: Option<&ActionForms>,
) -> PlannedStop {
    let request = request_of(site, task);
    let offered = forms.map_or(&[][..], ActionForms::offered);
    let (action_s, action_j) = request.map_or((0.0, 0.0), |request| expected_of(request, offered));
    let node = node_of(site, task);
    let (route, walk, problem) = match (node, from) {
        (Some(node), Some(from)) => find_route(graph, from, node, StopProblem::NoRoute),
        (Some(node), None) => (vec![node], RouteCost::default(), None),
        (None, _) => (Vec::new(), RouteCost::default(), Some(StopProblem::NoPlace)),
    };
    let of_parameters = || {
        let (field, problem) = forms?.problem(request?)?;
        Some(StopProblem::Parameter(field, problem))
    };
    let problem = problem.or_else(of_parameters);
    PlannedStop { task: task.id, node, route, walk, action_s, action_j, problem }
}

/// The cheapest route between two nodes, or `problem` with the reason.
fn find_route<P>(
    graph: &RouteGraph,
    from: NodeId,
    to: NodeId,
    problem: impl FnOnce(NodeId, NoRoute) -> P,
) -> (Vec<NodeId>, RouteCost, Option<P>) {
    let route = graph.routes_to(to).ok_or(NoRoute::NoSuchNode(to)).and_then(|tree| tree.route(from));
    match route {
        Ok(route) => (route.nodes, RouteCost { time_s: route.cost_s, length_m: route.length_m }, None),
        Err(reason) => (Vec::new(), RouteCost::default(), Some(problem(from, reason))),
    }
}

fn plan_end(site: &Site, graph: &RouteGraph, end: MissionEnd, from: Option<NodeId>) -> PlannedEnd {
    let Some(from) = from else { return PlannedEnd::default() };
    let goals: Vec<NodeId> = match end {
        MissionEnd::Stay => return PlannedEnd::default(),
        MissionEnd::Node(node) => vec![node],
        MissionEnd::NearestDock => site.docks().map(|dock| dock.node).collect(),
    };
    let routes = goals.into_iter().map(|goal| find_route(graph, from, goal, EndProblem::NoRoute));
    let better = |a: &(_, RouteCost, Option<_>), b: &(_, RouteCost, Option<_>)| {
        a.2.is_some().cmp(&b.2.is_some()).then(a.1.time_s.total_cmp(&b.1.time_s))
    };
    match routes.min_by(better) {
        Some((route, walk, problem)) => PlannedEnd { route, walk, problem },
        None => PlannedEnd { problem: Some(EndProblem::NoDock), ..PlannedEnd::default() },
    }
}
