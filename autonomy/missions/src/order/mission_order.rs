//! The order of the tasks of a mission, and what it gains.

use super::{TourConfig, TourProblem, solve};
use crate::graph::{RouteGraph, RouteTree};
use site_model::{DockAction, Mission, MissionEnd, NodeId, Site, Task, TaskId, TaskOrder, TaskPlace};
use std::collections::BTreeMap;

/// What a route takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RouteCost {
    /// Expected time, seconds.
    pub time_s: f64,
    /// Length, metres.
    pub length_m: f64,
}

/// The order in which the tasks of a mission are done, beside that of its list. Both routes are those over the tasks that can be reached.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OrderPreview {
    /// All tasks in the order of the mission's setting. Those that cannot be reached are the last. A mission with a task that docks or undocks keeps its order, and nothing
    /// else is known of it here.
    pub order: Vec<TaskId>,
    /// Tasks that cannot be reached from the robot's place.
    pub unreachable: Vec<TaskId>,
    /// The route in the order of the list. None if it cannot be walked.
    pub listed: Option<RouteCost>,
    /// The route in the order above. None if it cannot be walked.
    pub chosen: Option<RouteCost>,
    /// Whether no order takes less time. False for an order as listed.
    pub is_shortest: bool,
}

impl OrderPreview {
    /// What the order gains over the list. None if one of both cannot be walked.
    pub fn gain(&self) -> Option<RouteCost> {
        let (listed, chosen) = (self.listed?, self.chosen?);
        Some(RouteCost { time_s: listed.time_s - chosen.time_s, length_m: listed.length_m - chosen.length_m })
    }
}

/// The node of a task. None if the site lacks it, or if it is found when the task is done: the nearest dock, or where the robot leaves its dock.
pub fn node_of(site: &Site, task: &Task) -> Option<NodeId> {
    let node = match &task.place {
        TaskPlace::InspectionPoint(point) => site.inspection_point(*point)?.node,
        TaskPlace::Node { node, .. } => *node,
        TaskPlace::ByAction { request } => {
            let dock = DockAction::of(request)?.dock()?;
            site.docks().find(|known| known.id == dock)?.node
        }
    };
    site.node(node).map(|node| node.id)
}

/// The nodes at one of which a mission ends. Empty if it ends anywhere.
fn end_nodes(site: &Site, end: MissionEnd) -> Vec<NodeId> {
    match end {
        MissionEnd::NearestDock => site.docks().map(|dock| dock.node).collect(),
        MissionEnd::Node(node) => vec![node],
        MissionEnd::Stay => Vec::new(),
    }
}

/// Puts the tasks of a mission in order, from the robot's place. One search of the graph for each task.
pub fn order_tasks(
    site: &Site,
    graph: &RouteGraph,
    mission: &Mission,
    start: NodeId,
    config: &TourConfig,
) -> OrderPreview {
    if mission.tasks.iter().any(|task| matches!(task.place, TaskPlace::ByAction { .. })) {
        // What is done before and after docking is part of the mission, and the place of the nearest dock follows from the tasks before it.
        let order = mission.tasks.iter().map(|task| task.id).collect();
        return OrderPreview { order, ..OrderPreview::default() };
    }
    let nodes: Vec<Option<NodeId>> = mission.tasks.iter().map(|task| node_of(site, task)).collect();
    let trees: Vec<Option<RouteTree<'_>>> = nodes.iter().map(|node| graph.routes_to((*node)?)).collect();
    let can_reach = |index: &usize| trees[*index].as_ref().is_some_and(|tree| tree.cost_s(start).is_some());
    let (reachable, unreachable): (Vec<usize>, Vec<usize>) = (0..nodes.len()).partition(can_reach);
    let ends: Vec<RouteTree<'_>> =
        end_nodes(site, mission.end).into_iter().filter_map(|node| graph.routes_to(node)).collect();
    let routes = TaskRoutes { start, nodes: &nodes, trees: &trees, ends: &ends };
    let problem = problem(mission, &reachable, &routes);
    let listed: Vec<usize> = (0..reachable.len()).collect();
    let tour = match mission.order {
        TaskOrder::AsListed => None,
        TaskOrder::Shortest { .. } => solve(&problem, config).ok(),
    };
    let order = tour.as_ref().map_or(&listed, |tour| &tour.order);
    let cost = |order: &[usize]| {
        let stops: Vec<usize> = order.iter().map(|&stop| reachable[stop]).collect();
        routes.cost(&stops)
    };
    let id = |index: &usize| mission.tasks[*index].id;
    OrderPreview {
        order: order
            .iter()
            .map(|&stop| reachable[stop])
            .chain(unreachable.iter().copied())
            .map(|index| id(&index))
            .collect(),
        unreachable: unreachable.iter().map(id).collect(),
        listed: cost(&listed),
        chosen: cost(order),
        is_shortest: tour.is_some_and(|tour| tour.is_exact),
    }
}

/// The routes between the tasks.
struct TaskRoutes<'a> {
    start: NodeId,
    nodes: &'a [Option<NodeId>],
    /// Routes to each task.
    trees: &'a [Option<RouteTree<'a>>],
    ends: &'a [RouteTree<'a>],
}

impl TaskRoutes<'_> {
    fn time_s(&self, from: Option<NodeId>, to: usize) -> f64 {
        let tree = self.trees[to].as_ref();
        from.and_then(|from| tree?.cost_s(from)).unwrap_or(f64::INFINITY)
    }

    /// Time to the nearest end. 0 if there is none that can be reached, because the tasks are done all the same.
    fn end(&self, from: Option<NodeId>) -> Option<(f64, &RouteTree<'_>)> {
        let times = self.ends.iter().filter_map(|tree| Some((tree.cost_s(from?)?, tree)));
        times.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// What an order of tasks takes, with the route to the end. None if it cannot be walked.
    fn cost(&self, order: &[usize]) -> Option<RouteCost> {
        let mut cost = RouteCost::default();
        let mut place = Some(self.start);
        for &stop in order {
            let route = self.trees[stop].as_ref()?.route(place?).ok()?;
            cost.time_s += route.cost_s;
            cost.length_m += route.length_m;
            place = self.nodes[stop];
        }
        if let Some((time_s, tree)) = self.end(place) {
            cost.time_s += time_s;
            cost.length_m += tree.route(place?).ok()?.length_m;
        }
        Some(cost)
    }
}

/// The tasks that can be reached as the stops of a tour.
fn problem(mission: &Mission, reachable: &[usize], routes: &TaskRoutes<'_>) -> TourProblem {
    let stops: BTreeMap<TaskId, usize> =
        reachable.iter().enumerate().map(|(stop, &index)| (mission.tasks[index].id, stop)).collect();
    let (keep_first, keep_last) = match mission.order {
        TaskOrder::Shortest { keep_first, keep_last } => (keep_first, keep_last),
        TaskOrder::AsListed => (false, false),
    };
    let pinned = |keeps: bool, task: Option<&Task>| {
        task.filter(|_| keeps).and_then(|task| stops.get(&task.id)).copied()
    };
    let constraints = mission.order_constraints.iter();
    let before = constraints.filter_map(|[first, second]| Some([*stops.get(first)?, *stops.get(second)?]));
    let first = pinned(keep_first, mission.tasks.first());
    // A single task is both.
    let last = pinned(keep_last, mission.tasks.last()).filter(|last| Some(*last) != first);
    let row = |&from: &usize| reachable.iter().map(|&to| routes.time_s(routes.nodes[from], to)).collect();
    TourProblem {
        from_start: reachable.iter().map(|&to| routes.time_s(Some(routes.start), to)).collect(),
        between: reachable.iter().map(row).collect(),
        to_end: reachable
            .iter()
            .map(|&from| routes.end(routes.nodes[from]).map_or(0.0, |end| end.0))
            .collect(),
        first,
        last,
        before: before.collect(),
    }
}
