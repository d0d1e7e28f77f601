//! The topological map as a graph with costs: what can be walked now, and how long it takes.

use super::distance::distance_m;
use super::is_blocked;
use super::zones::{ZoneRules, rules_on_edge};
use site_model::{Edge, EdgeBlock, EdgeCost, EdgeId, LocalTime, NodeId, Site, Traversal, ZoneId};
use std::collections::BTreeMap;
use vocab::{Stamp, Vec3};

/// Parameters of [`RouteGraph`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RouteConfig {
    /// Usual speed on flat ground, m/s. Chosen: that of the simulated legged robot on free ground.
    pub usual_speed_m_s: f64,
    /// Factor on that speed on stairs. Chosen: legged robots climb at a third of their walking speed.
    pub stairs_speed_ratio: f64,
    /// Factor on that speed on edges that are walked slowly, and through doors. Chosen: half, the time to look at a door or to place the feet; it is replaced by what was
    /// learned.
    pub slow_speed_ratio: f64,
    /// Time to align with a dock and to get onto it, seconds. Chosen: the walk in takes 3 s, and aligning and looking take some seconds each; it is replaced by what was
    /// learned.
    pub docking_s: f64,
    /// Weight of the newest traversal in a learned time. At 0.2, the last ten traversals make nine tenths of it. Chosen: with more, one person in the way changes routes;
    /// with less, a change of the site is learned slowly.
    pub learning_rate: f64,
    /// Distance between the points of an edge at which zones are looked up, metres. Chosen: less than the radius of a robot's footprint, so that no zone of its size is
    /// passed over.
    pub zone_step_m: f64,
}

impl Default for RouteConfig {
    fn default() -> Self {
        Self {
            usual_speed_m_s: 0.7,
            stairs_speed_ratio: 0.33,
            slow_speed_ratio: 0.5,
            docking_s: 20.0,
            learning_rate: 0.2,
            zone_step_m: 0.25,
        }
    }
}

/// Time that traversals of an edge took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LearnedTime {
    /// Weighted mean, seconds.
    pub mean_s: f64,
    /// Weighted variance, s².
    pub variance_s2: f64,
    /// Number of traversals.
    pub count: u32,
}

impl LearnedTime {
    /// Adds a traversal.
    pub fn add(&mut self, duration_s: f64, config: &RouteConfig) {
        // The plain mean until the weight of the newest would be smaller than the learning rate.
        let weight = config.learning_rate.max(1.0 / f64::from(self.count + 1));
        let difference = duration_s - self.mean_s;
        self.mean_s += weight * difference;
        self.variance_s2 = (1.0 - weight) * (self.variance_s2 + weight * difference * difference);
        self.count += 1;
    }
}

/// Learned times of edges.
pub type LearnedTimes = BTreeMap<EdgeId, LearnedTime>;

/// What holds now, besides the site.
#[derive(Clone, Copy, Debug, Default)]
pub struct RouteConditions<'a> {
    /// Present time on the robot's clock, by which blocks end.
    pub now: Stamp,
    /// Time of day in the site's zone, for zones that hold for a part of the day. None: such zones hold.
    pub time_of_day: Option<LocalTime>,
    /// Times of earlier traversals.
    pub learned: Option<&'a LearnedTimes>,
}

/// Why an edge cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub enum Closure {
    /// It is disabled.
    Disabled,
    /// It could not be walked.
    Blocked(EdgeBlock),
    /// It leads through a keep-out zone.
    KeepOut(ZoneId),
}

/// An edge of the graph.
#[derive(Clone, Debug)]
pub(super) struct RouteEdge {
    pub id: EdgeId,
    pub from: usize,
    pub to: usize,
    pub length_m: f64,
    /// Whole microseconds, so that sums are exact.
    pub cost_us: u64,
    pub speed_m_s: f64,
    pub closure: Option<Closure>,
}

/// A graph of the nodes and edges of a site. Edges of which an end does not exist are left out.
#[derive(Clone, Debug, Default)]
pub struct RouteGraph {
    pub(super) nodes: Vec<NodeId>,
    pub(super) positions: Vec<Vec3>,
    pub(super) index: BTreeMap<NodeId, usize>,
    pub(super) edges: Vec<RouteEdge>,
    pub(super) edge_index: BTreeMap<EdgeId, usize>,
    /// Edges that end at each node.
    pub(super) incoming: Vec<Vec<usize>>,
}

impl RouteGraph {
    /// The graph of a site. Linear in nodes and edges, and in edges times zones.
    pub fn new(site: &Site, conditions: &RouteConditions<'_>, config: &RouteConfig) -> Self {
        let mut graph = Self::default();
        for node in site.nodes() {
            graph.index.insert(node.id, graph.nodes.len());
            graph.nodes.push(node.id);
            graph.positions.push(node.map_from_node.position);
        }
        graph.incoming = vec![Vec::new(); graph.nodes.len()];
        let blocks: BTreeMap<EdgeId, &EdgeBlock> =
            site.edge_blocks().map(|block| (block.edge, block)).collect();
        for edge in site.edges() {
            let (Some(from), Some(to)) = (graph.index_of(edge.from), graph.index_of(edge.to)) else {
                continue;
            };
            let ends = (graph.positions[from], graph.positions[to]);
            let speed_m_s = speed_m_s(edge, config);
            let (now, step_m) = (conditions.time_of_day, config.zone_step_m);
            let rules = rules_on_edge(site, ends, speed_m_s, now, step_m);
            let block = blocks.get(&edge.id).filter(|block| is_blocked(block, conditions.now));
            let closure = match (edge.is_enabled, block, rules.keep_out) {
                (false, ..) => Some(Closure::Disabled),
                (_, Some(block), _) => Some(Closure::Blocked((*block).clone())),
                (_, _, Some(zone)) => Some(Closure::KeepOut(zone)),
                (true, None, None) => None,
            };
            let length_m = distance_m(ends.0, ends.1);
            let learned = conditions.learned.and_then(|learned| learned.get(&edge.id));
            let cost_s = cost_s(edge, length_m, speed_m_s, learned, &rules, config);
            let cost_us = to_microseconds(cost_s);
            graph.incoming[to].push(graph.edges.len());
            graph.edge_index.insert(edge.id, graph.edges.len());
            graph.edges.push(RouteEdge { id: edge.id, from, to, length_m, cost_us, speed_m_s, closure });
        }
        graph
    }

    /// Whether the graph has this node.
    pub fn contains(&self, node: NodeId) -> bool {
        self.index.contains_key(&node)
    }

    /// Greatest speed on an edge, m/s: the least of the robot's and the edge's. Zones limit it where they are, not on the whole edge.
    pub fn speed_m_s(&self, edge: EdgeId) -> Option<f64> {
        Some(self.edges[*self.edge_index.get(&edge)?].speed_m_s)
    }

    /// Time that an edge takes, seconds, and its length, metres.
    pub fn cost(&self, edge: EdgeId) -> Option<(f64, f64)> {
        let edge = &self.edges[*self.edge_index.get(&edge)?];
        Some((to_seconds(edge.cost_us), edge.length_m))
    }

    /// Why an edge cannot be used; none if it can.
    pub fn closure(&self, edge: EdgeId) -> Option<&Closure> {
        self.edges[*self.edge_index.get(&edge)?].closure.as_ref()
    }

    /// Closes an edge that is open. Unknown ones change nothing.
    pub fn close(&mut self, edge: EdgeId, closure: Closure) {
        if let Some(index) = self.edge_index.get(&edge) {
            self.edges[*index].closure.get_or_insert(closure);
        }
    }

    /// Opens the edges that are blocked until an instant at most. Returns when the first of these blocks ends; none if there are none.
    pub fn open_blocks_until(&mut self, until: Stamp) -> Option<Stamp> {
        let mut first_end: Option<Stamp> = None;
        for edge in &mut self.edges {
            if let Some(Closure::Blocked(block)) = &edge.closure
                && block.until <= until
            {
                first_end = Some(first_end.map_or(block.until, |first| first.min(block.until)));
                edge.closure = None;
            }
        }
        first_end
    }

    pub(super) fn index_of(&self, node: NodeId) -> Option<usize> {
        self.index.get(&node).copied()
    }
}

/// Speed on an edge, m/s.
fn speed_m_s(edge: &Edge, config: &RouteConfig) -> f64 {
    let ratio = match edge.traversal {
        Traversal::Stairs => config.stairs_speed_ratio,
        Traversal::Slow | Traversal::Door => config.slow_speed_ratio,
        Traversal::Walk | Traversal::Dock | Traversal::Action { .. } => 1.0,
    };
    let own_m_s = config.usual_speed_m_s * ratio;
    edge.max_speed_m_s.map_or(own_m_s, |limit| limit.min(own_m_s))
}

/// Cost of an edge, seconds. Speed limits count for its length only: fixed and learned times include them already. Penalties count for all.
fn cost_s(
    edge: &Edge,
    length_m: f64,
    speed_m_s: f64,
    learned: Option<&LearnedTime>,
    rules: &ZoneRules,
    config: &RouteConfig,
) -> f64 {
    let docking_s = if edge.traversal == Traversal::Dock { config.docking_s } else { 0.0 };
    match (edge.cost, learned) {
        (EdgeCost::Fixed(time_s), _) => time_s * rules.penalty,
        (EdgeCost::Learned, Some(learned)) if learned.count > 0 => learned.mean_s * rules.penalty,
        (EdgeCost::Length | EdgeCost::Learned, _) => {
            length_m / speed_m_s.max(0.01) * rules.time_factor + docking_s
        }
    }
}

/// Rounded, from 0 to about 11 days, so that sums over any route do not overflow.
fn to_microseconds(seconds: f64) -> u64 {
    (seconds * 1e6).round().clamp(0.0, 1e12) as u64
}

pub(super) fn to_seconds(microseconds: u64) -> f64 {
    microseconds as f64 * 1e-6
}
