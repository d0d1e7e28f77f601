//! The cheapest routes from all nodes to one: the policy, single routes, and what blocks them.

use super::route_graph::{Closure, RouteGraph, to_seconds};
use pathfinding::directed::dijkstra::dijkstra_reach;
use site_model::{EdgeId, NodeId};
use std::collections::BTreeMap;

/// Cost of a closed edge when the route with the fewest closed edges is looked for. More than the cost of any route over open ones.
const CLOSED_US: u64 = 1_000_000_000_000_000;

/// The cheapest routes from all nodes to one.
#[derive(Clone, Debug)]
pub struct RouteTree<'a> {
    graph: &'a RouteGraph,
    goal: usize,
    /// For each node from which the goal can be reached: the next edge (none at the goal) and the cost of the rest.
    next: Vec<Option<(Option<usize>, u64)>>,
}

/// A route over edges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Route {
    /// In the order of walking.
    pub edges: Vec<EdgeId>,
    /// The nodes between and at the ends of them: one more than edges.
    pub nodes: Vec<NodeId>,
    /// Expected time, seconds.
    pub cost_s: f64,
    /// Length, metres.
    pub length_m: f64,
}

/// Why there is no route.
#[derive(Clone, Debug, PartialEq)]
pub enum NoRoute {
    /// There is no such node.
    NoSuchNode(NodeId),
    /// All routes are closed.
    Closed {
        /// The closed edges of the route that needs the fewest of them to open, in the order of walking.
        edges: Vec<(EdgeId, Closure)>,
    },
    /// No edges lead there, open or not.
    NotConnected,
}

impl RouteGraph {
    /// The cheapest routes from all nodes to one. None if there is no such node.
    pub fn routes_to(&self, goal: NodeId) -> Option<RouteTree<'_>> {
        Some(RouteTree::new(self, self.index_of(goal)?))
    }
}

impl<'a> RouteTree<'a> {
    /// Dijkstra's algorithm from the goal backwards.
    pub(super) fn new(graph: &'a RouteGraph, goal: usize) -> Self {
        let next = search(graph, goal, |edge| graph.edges[edge].closure.is_none());
        Self { graph, goal, next }
    }

    /// The policy: for each node from which the goal can be reached, the next edge. The goal itself has none.
    pub fn policy(&self) -> BTreeMap<NodeId, EdgeId> {
        let step = |(node, next): (usize, &Option<(Option<usize>, u64)>)| {
            let edge = (*next)?.0?;
            Some((self.graph.nodes[node], self.graph.edges[edge].id))
        };
        self.next.iter().enumerate().filter_map(step).collect()
    }

    /// Expected time from a node, seconds. None if the goal cannot be reached from there.
    pub fn cost_s(&self, from: NodeId) -> Option<f64> {
        Some(to_seconds(self.next[self.graph.index_of(from)?]?.1))
    }

    /// The route from a node.
    ///
    /// # Errors
    /// Why there is none, and what blocks it.
    pub fn route(&self, from: NodeId) -> Result<Route, NoRoute> {
        let start = self.graph.index_of(from).ok_or(NoRoute::NoSuchNode(from))?;
        if self.next[start].is_none() {
            return Err(self.find_closures(start));
        }
        let mut route = Route { nodes: vec![from], ..Route::default() };
        let mut cost_us = 0;
        for edge in walk(self.graph, &self.next, start) {
            let edge = &self.graph.edges[edge];
            route.edges.push(edge.id);
            route.nodes.push(self.graph.nodes[edge.to]);
            route.length_m += edge.length_m;
            cost_us += edge.cost_us;
        }
        route.cost_s = to_seconds(cost_us);
        Ok(route)
    }

    /// The closed edges of the route with the fewest of them.
    fn find_closures(&self, start: usize) -> NoRoute {
        let next = search(self.graph, self.goal, |_| true);
        let closed = walk(self.graph, &next, start).filter_map(|edge| {
            let edge = &self.graph.edges[edge];
            Some((edge.id, edge.closure.clone()?))
        });
        let edges: Vec<_> = closed.collect();
        if edges.is_empty() { NoRoute::NotConnected } else { NoRoute::Closed { edges } }
    }
}

/// For each node from which `goal` can be reached over usable edges, the next edge and the cost. Closed edges that may be used have the cost [`CLOSED_US`].
fn search(
    graph: &RouteGraph,
    goal: usize,
    may_use: impl Fn(usize) -> bool,
) -> Vec<Option<(Option<usize>, u64)>> {
    let cost_us = |edge: usize| {
        let edge = &graph.edges[edge];
        edge.cost_us + if edge.closure.is_some() { CLOSED_US } else { 0 }
    };
    let usable = |node: usize| graph.incoming[node].iter().copied().filter(|&edge| may_use(edge));
    let neighbours =
        |&node: &usize| usable(node).map(|edge| (graph.edges[edge].from, cost_us(edge))).collect::<Vec<_>>();
    let mut next = vec![None; graph.nodes.len()];
    for reached in dijkstra_reach(&goal, neighbours) {
        // Of several edges to the same node, the cheapest; of equal ones, the first.
        let edges = reached.parent.into_iter().flat_map(usable);
        let edges = edges.filter(|&edge| graph.edges[edge].from == reached.node);
        next[reached.node] = Some((edges.min_by_key(|&edge| cost_us(edge)), reached.total_cost));
    }
    next
}

/// The edges from a node to the goal. Empty if it cannot be reached.
fn walk<'a>(
    graph: &'a RouteGraph,
    next: &'a [Option<(Option<usize>, u64)>],
    start: usize,
) -> impl Iterator<Item = usize> + 'a {
    let step = move |node: usize| next[node].and_then(|(edge, _)| edge);
    std::iter::successors(step(start), move |&edge| step(graph.edges[edge].to))
}
