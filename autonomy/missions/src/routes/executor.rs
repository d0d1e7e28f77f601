//! Brings the robot to nodes and docks: plans a route, walks it edge by edge, blocks what cannot be walked, and plans anew.
//!
//! An edge that stays blocked is left out of routes for a time that doubles with each failure ([`next_block`]); the edge back is left out with it, because
//! what stands in the way stands there for both. That the robot is charged is the only proof that it has docked.

use super::active_route::{ActiveRoute, Leg, RouteTarget};
use super::interface::{LegKind, LegResult, LegWalk, RouteAttempt, RouteEffect, RouteView};
use super::waits::{hold_of, waits_for};
use crate::action_time::ActionTimeConfig;
use crate::graph::{Closure, EdgeBlockConfig, NoRoute, RouteGraph};
use crate::ids::leg_id;
use crate::poses::{floor_distance_m, is_ahead, point_between};
use crate::runs::{GoalRequest, RouteGoalResult};
use crate::texts;
use site_model::{
    Edge, EdgeBlock, EdgeId, Node, NodeId, ObjectId, PoseTolerance, ReachFailure, RouteProgress, Site, ZoneId,
};
use std::collections::{BTreeMap, BTreeSet};
use vocab::{GoalId, LegId, Pose, Quat, Span, Stamp};

/// Parameters of [`RouteExecutor`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RouteExecutorConfig {
    /// How long edges are left out.
    pub blocks: EdgeBlockConfig,
    /// Attempts to dock, before another dock is tried. Chosen: one contact that fails and one marker that is hidden may come together. Each attempt takes up to a minute.
    pub max_dock_attempts: u32,
    /// Speed onto and out of docks, m/s. Chosen: a little above the speed with which the robot walks into the dock (`executive::DockingConfig`).
    pub dock_speed_m_s: f64,
    /// Time within which the charging current has to flow. Chosen: time for a charger to check its contacts.
    pub charge_time_limit: Span,
    /// Edges are walked in parts of this length at most, metres. Half of the distance to which the robot sees the ground, so that it plans on what it sees. It is half of
    /// the range of the elevation map, 12 m.
    pub max_part_length_m: f64,
    /// The place of the robot is looked for again after this time, if it is not known. Chosen: five looks at the place ([`Self::max_place_waits`]).
    pub place_wait: Span,
    /// As often as this. With that time it makes 20 s, in which a robot that stands finds its place after a start. Chosen: longer than the 15.6 s that the search of a
    /// map of 50 million points takes (docs/benchmarks/localisation.md).
    pub max_place_waits: u32,
    /// How long actions on entering and leaving an edge may take.
    pub action_time: ActionTimeConfig,
    /// Expected time of actions that the platform does not come with. Chosen: time for an elevator or a gate.
    pub expected_action_time: Span,
    /// Pose at the ends of stairs, in line with the flight: from beside it, the robot would walk into the end of a handrail. Across, a flight of 1 m leaves a robot of
    /// 0.76 m 0.12 m to each side. Chosen: across less than that room; 10 degrees move the front of the robot by less than 0.1 m; along, it need not be exact.
    pub stairs_tolerance: PoseTolerance,
    /// Speed by which routes beside the graph are compared with routes on it, m/s. Slower than on edges, which were checked for passage. Chosen: half of the usual speed
    /// on edges, so that a route on edges of up to twice the length is preferred.
    pub off_graph_speed_m_s: f64,
}

impl Default for RouteExecutorConfig {
    fn default() -> Self {
        Self {
            blocks: EdgeBlockConfig::default(),
            max_dock_attempts: 3,
            dock_speed_m_s: 0.2,
            charge_time_limit: Span::from_millis(4_000),
            max_part_length_m: 6.0,
            place_wait: Span::from_millis(1_000),
            max_place_waits: 20,
            action_time: ActionTimeConfig { margin: Span::ZERO, ..ActionTimeConfig::default() },
            expected_action_time: Span::from_millis(40_000),
            stairs_tolerance: PoseTolerance { along_m: 0.2, across_m: 0.1, yaw_rad: 0.175 },
            off_graph_speed_m_s: 0.35,
        }
    }
}

/// The executor. It has one goal at a time.
#[derive(Clone, Debug, Default)]
pub struct RouteExecutor {
    pub(super) config: RouteExecutorConfig,
    pub(super) active: Option<ActiveRoute>,
    /// Blocks that the site may not show yet.
    pub(super) blocks: BTreeMap<EdgeId, EdgeBlock>,
    /// Those of them that the site has shown. One that it shows no more was lifted by a person.
    pub(super) shown_blocks: BTreeSet<EdgeId>,
    /// Zones with an action in which the robot is, also between goals.
    pub(super) inside: BTreeSet<ZoneId>,
    pub(super) effects: Vec<RouteEffect>,
}

impl RouteExecutor {
    /// Without a goal.
    pub fn new(config: RouteExecutorConfig) -> Self {
        Self { config, ..Self::default() }
    }

    /// The active goal.
    pub fn goal(&self) -> Option<GoalId> {
        self.active.as_ref().map(|active| active.goal)
    }

    /// The route that is left.
    pub fn progress(&self, view: &RouteView<'_>) -> Option<RouteProgress> {
        let active = self.active.as_ref()?;
        let target = match active.target {
            RouteTarget::Node(node) | RouteTarget::Dock { node, .. } => node,
            RouteTarget::OutOfDock => return None,
        };
        let costs = active.route.iter().filter_map(|edge| view.graph.cost(*edge));
        let (remaining_s, remaining_m) =
            costs.fold((0.0, 0.0), |(time_s, length_m), (s, m)| (time_s + s, length_m + m));
        let edges = active.route.clone();
        let waits_for = active.leg.and_then(|(_, leg)| waits_for(leg, view));
        Some(RouteProgress { goal: active.goal, target, edges, remaining_s, remaining_m, waits_for })
    }

    /// Begins a goal. One that is active ends as cancelled.
    pub fn begin(
        &mut self,
        at: Stamp,
        goal: GoalId,
        request: GoalRequest,
        view: &RouteView<'_>,
    ) -> Vec<RouteEffect> {
        self.end(RouteGoalResult::Cancelled);
        let target =
            match request {
                GoalRequest::Route(node) => view.site.node(node).map(|node| RouteTarget::Node(node.id)),
                GoalRequest::Dock(dock) => view.site.docks().find(|known| known.id == dock).map(|dock| {
                    RouteTarget::Dock { dock: dock.id, node: dock.node, approach: dock.approach }
                }),
                GoalRequest::Undock => Some(RouteTarget::OutOfDock),
            };
        match target {
            None => {
                let missing = RouteGoalResult::Failed(ReachFailure::NoSuchPlace);
                self.effects.push(RouteEffect::Ended(goal, missing));
            }
            Some(target) => {
                self.active = Some(ActiveRoute::new(at, goal, target));
                self.next_leg(at, view);
            }
        }
        std::mem::take(&mut self.effects)
    }

    /// Ends a goal, if it is the one that is active.
    pub fn cancel(&mut self, goal: GoalId) -> Vec<RouteEffect> {
        if self.goal() == Some(goal) {
            self.end(RouteGoalResult::Cancelled);
        }
        std::mem::take(&mut self.effects)
    }

    /// A walk of the executive has ended. Walks that are not active change nothing.
    pub fn end_leg(
        &mut self,
        at: Stamp,
        walk: LegId,
        result: LegResult,
        view: &RouteView<'_>,
    ) -> Vec<RouteEffect> {
        let leg = match &mut self.active {
            Some(active) if active.leg.is_some_and(|(known, _)| known == walk) => active.leg.take(),
            _ => None,
        };
        if let Some((_, leg)) = leg {
            match result {
                LegResult::Reached => self.handle_reached(at, leg, view),
                LegResult::Failed(ReachFailure::PathBlocked) => self.handle_blocked(at, leg, view),
                LegResult::Failed(ReachFailure::DockNotSeen) if leg == Leg::OntoDock => {
                    self.handle_no_charge(ReachFailure::DockNotSeen, view);
                }
                LegResult::Failed(reason) => self.end(RouteGoalResult::Failed(reason)),
            }
        }
        std::mem::take(&mut self.effects)
    }

    /// Time has passed, or the site has changed. To be called also between goals, so that it is known which zones the robot enters.
    pub fn tick(&mut self, at: Stamp, view: &RouteView<'_>) -> Vec<RouteEffect> {
        self.enter_zones(view);
        let is_any_lifted = self.forget_lifted_blocks(view);
        let Some(ActiveRoute { leg: Some((walk, leg)), target, .. }) = &self.active else {
            return std::mem::take(&mut self.effects);
        };
        let (walk, leg, target) = (*walk, *leg, *target);
        match leg {
            Leg::OntoDock | Leg::Charge { .. } if is_charged(target, view) => {
                if leg.is_walk() {
                    self.effects.push(RouteEffect::CancelWalk(walk));
                }
                self.end_as_reached();
            }
            Leg::Charge { until } if at >= until => self.handle_no_charge(ReachFailure::NotDocked, view),
            Leg::Wait { edge, until } if at >= until => {
                self.end_wait(at, RouteAttempt::WaitedForEdge);
                self.walk_edge(at, edge, view);
            }
            Leg::WaitForHold { edge } if self.is_closed(edge, view) => {
                self.end_wait(at, RouteAttempt::WaitedForEdge);
                self.forget_place();
                self.next_leg(at, view);
            }
            Leg::WaitForHold { edge } if hold_of(edge, view).is_none() => {
                self.end_wait(at, RouteAttempt::WaitedForEdge);
                self.walk_edge(at, edge, view);
            }
            Leg::WaitForBlock { until } if at >= until || is_any_lifted => {
                self.end_wait(at, RouteAttempt::WaitedForEdge);
                self.forget_place();
                self.next_leg(at, view);
            }
            Leg::WaitForPlace { until } if at >= until => {
                self.end_wait(at, RouteAttempt::WaitedForPlace);
                self.forget_place();
                self.next_leg(at, view);
            }
            Leg::Act { call, until, .. } if at >= until => {
                self.effects.push(RouteEffect::CancelAction(call));
                self.handle_action_end(at, call, Err(texts::ACTION_SILENT.to_owned()), view);
            }
            Leg::Edge(edge) if self.is_closed(edge, view) => {
                // Somebody has closed or deleted it.
                self.effects.push(RouteEffect::CancelWalk(walk));
                self.drop_leg();
                self.forget_place();
                self.next_leg(at, view);
            }
            _ => {}
        }
        std::mem::take(&mut self.effects)
    }

    /// The robot stands for a leg.
    pub(super) fn stand(&mut self, at: Stamp, leg: Leg) {
        if let Some(active) = &mut self.active {
            active.leg = Some((leg_id(active.goal, active.walks), leg));
            active.stands_since = at;
        }
    }

    /// The robot has waited.
    fn end_wait(&mut self, at: Stamp, attempt: impl FnOnce(Span) -> RouteAttempt) {
        if let Some(active) = &self.active {
            self.effects.push(RouteEffect::Tried(attempt(at - active.stands_since)));
        }
        self.drop_leg();
    }

    pub(super) fn drop_leg(&mut self) {
        if let Some(active) = &mut self.active {
            active.leg = None;
        }
    }

    /// The robot is not at the node that it reached last any more.
    pub(super) fn forget_place(&mut self) {
        self.leave_edge();
        if let Some(active) = &mut self.active {
            (active.current, active.is_at_end) = (None, false);
            active.route.clear();
        }
    }

    pub(super) fn end(&mut self, result: RouteGoalResult) {
        self.leave_edge();
        let Some(active) = self.active.take() else { return };
        if result != RouteGoalResult::Reached {
            // What was begun on entering a zone is not wanted any more.
            self.effects.extend(active.during.iter().map(|open| RouteEffect::CancelAction(open.call)));
        }
        if let Some((_, Leg::Act { call, .. })) = active.leg {
            self.effects.push(RouteEffect::CancelAction(call));
        }
        if let Some((walk, leg)) = active.leg
            && leg.is_walk()
        {
            self.effects.push(RouteEffect::CancelWalk(walk));
        }
        self.effects.push(RouteEffect::Ended(active.goal, result));
    }

    fn end_as_reached(&mut self) {
        self.drop_leg();
        self.end(RouteGoalResult::Reached);
    }

    fn handle_reached(&mut self, at: Stamp, leg: Leg, view: &RouteView<'_>) {
        let parts = match leg {
            Leg::Edge(edge) => self.parts(edge, view),
            _ => 1,
        };
        let Some(active) = &mut self.active else { return };
        match leg {
            Leg::ToGraph(node) | Leg::OutOfDock(node) => {
                active.current = Some(node);
                if active.target == RouteTarget::OutOfDock {
                    return self.end_as_reached();
                }
            }
            Leg::IntoPose(node) => (active.current, active.is_at_end) = (Some(node), true),
            Leg::Edge(edge) if active.edge_parts + 1 < parts => {
                active.edge_parts += 1;
                return self.walk_edge(at, edge, view);
            }
            Leg::Edge(edge) => {
                let end = view.site.edge(edge).map(|edge| edge.to);
                active.is_at_end = end.is_some() && end == active.target.route_end();
                (active.current, active.edge_failures) = (end, 0);
                active.unreachable.clear();
                self.effects.push(RouteEffect::Traversed(edge, at - active.edge_began));
                let was_blocked = self.blocks.remove(&edge).is_some();
                if was_blocked || view.site.get(ObjectId::EdgeBlock(edge)).is_some() {
                    self.effects.push(RouteEffect::Unblock(edge));
                }
                self.leave_edge();
                return self.act_on_leaving(at, edge, 0, view);
            }
            Leg::OntoDock => {
                let until = at + self.config.charge_time_limit;
                return self.stand(at, Leg::Charge { until });
            }
            Leg::BackOff(node) => {
                (active.current, active.is_at_end) = (Some(node), true);
                if active.dock_failures >= self.config.max_dock_attempts {
                    let reason = active.dock_failure.take().unwrap_or(ReachFailure::NotDocked);
                    return self.end(RouteGoalResult::Failed(reason));
                }
            }
            Leg::Charge { .. }
            | Leg::Wait { .. }
            | Leg::WaitForBlock { .. }
            | Leg::WaitForPlace { .. }
            | Leg::WaitForHold { .. }
            | Leg::Act { .. } => {}
        }
        self.next_leg(at, view);
    }

    fn handle_blocked(&mut self, at: Stamp, leg: Leg, view: &RouteView<'_>) {
        let Some(active) = &mut self.active else { return };
        match leg {
            Leg::Edge(edge) => return self.handle_blocked_edge(at, edge, None, view),
            Leg::ToGraph(node) | Leg::IntoPose(node) => {
                let is_new = active.unreachable.insert(node);
                if !is_new || Some(node) == active.target.route_end() {
                    return self.end(RouteGoalResult::Failed(ReachFailure::PathBlocked));
                }
                self.forget_place();
            }
            Leg::OutOfDock(_) => return self.end(RouteGoalResult::Failed(ReachFailure::NotUndocked)),
            Leg::OntoDock => return self.handle_no_charge(ReachFailure::NotDocked, view),
            Leg::BackOff(_) => return self.end(RouteGoalResult::Failed(ReachFailure::NotDocked)),
            Leg::Charge { .. }
            | Leg::Wait { .. }
            | Leg::WaitForBlock { .. }
            | Leg::WaitForPlace { .. }
            | Leg::WaitForHold { .. }
            | Leg::Act { .. } => {}
        }
        self.next_leg(at, view);
    }

    /// The dock does not charge, or was not reached: the robot backs off and tries again.
    fn handle_no_charge(&mut self, reason: ReachFailure, view: &RouteView<'_>) {
        let Some(active) = &mut self.active else { return };
        active.dock_failures += 1;
        self.effects.push(RouteEffect::Tried(RouteAttempt::Docking));
        // A dock that was seen and does not charge says more than that it was hidden at another attempt.
        if active.dock_failure != Some(ReachFailure::NotDocked) {
            active.dock_failure = Some(reason);
        }
        let RouteTarget::Dock { approach, .. } = active.target else { return };
        let Some(node) = view.site.node(approach) else {
            return self.end(RouteGoalResult::Failed(ReachFailure::NotDocked));
        };
        self.begin_walk(Leg::BackOff(approach), self.straight_walk(node.map_from_node, node.tolerance));
    }

    /// Whether an edge cannot be used now.
    fn is_closed(&self, edge: EdgeId, view: &RouteView<'_>) -> bool {
        view.graph.cost(edge).is_none()
            || matches!(view.graph.closure(edge), Some(Closure::Disabled | Closure::KeepOut(_)))
    }

    /// Decides what is done next for the goal.
    pub(super) fn next_leg(&mut self, at: Stamp, view: &RouteView<'_>) {
        let Some(active) = &self.active else { return };
        let target = active.target;
        if is_charged(target, view) {
            return self.end_as_reached();
        }
        if let Some(dock) = view.docked {
            return match view.site.docks().find(|known| known.id == dock) {
                Some(dock) if active.walks == 0 => self.leave_dock(dock.approach, view),
                _ => self.end(RouteGoalResult::Failed(ReachFailure::NotUndocked)),
            };
        }
        let Some(end) = target.route_end() else { return self.end_as_reached() };
        if active.is_at_end {
            return match target {
                RouteTarget::Dock { node, approach, .. } => self.walk_onto_dock(node, approach, view),
                _ => self.end_as_reached(),
            };
        }
        let mut graph = view.graph.clone();
        for block in self.blocks.values().filter(|block| at < block.until) {
            graph.close(block.edge, Closure::Blocked(block.clone()));
        }
        match active.current.or(view.place.at) {
            Some(node) if node == end => self.walk_into_pose(end, view),
            Some(node) => self.walk_next_edge(at, node, end, &graph, view),
            None => self.walk_to_graph(at, end, &graph, view),
        }
    }

    fn walk_next_edge(
        &mut self,
        at: Stamp,
        from: NodeId,
        end: NodeId,
        graph: &RouteGraph,
        view: &RouteView<'_>,
    ) {
        let Some(tree) = graph.routes_to(end) else {
            return self.end(RouteGoalResult::Failed(ReachFailure::NoSuchPlace));
        };
        match tree.route(from) {
            Err(reason) => self.handle_no_route(at, from, end, graph, no_route(reason)),
            Ok(route) => {
                let Some(edge) = route.edges.first().copied() else { return };
                if let Some(active) = &mut self.active {
                    (active.current, active.route) = (Some(from), route.edges);
                    (active.edge_began, active.edge_parts) = (at, 0);
                }
                self.walk_edge(at, edge, view);
            }
        }
    }

    /// Waits, if a route opens soon. Otherwise the goal has failed.
    fn handle_no_route(
        &mut self,
        at: Stamp,
        from: NodeId,
        end: NodeId,
        graph: &RouteGraph,
        reason: ReachFailure,
    ) {
        let mut soon = graph.clone();
        let first_end = soon.open_blocks_until(at + self.config.blocks.max_wait);
        let opens = soon.routes_to(end).is_some_and(|tree| tree.cost_s(from).is_some());
        match first_end {
            Some(until) if opens => self.stand(at, Leg::WaitForBlock { until }),
            _ => self.end(RouteGoalResult::Failed(reason)),
        }
    }

    pub(super) fn walk_edge(&mut self, at: Stamp, edge: EdgeId, view: &RouteView<'_>) {
        let Some(active) = &self.active else { return };
        if active.entered != Some(edge) {
            if hold_of(edge, view).is_some() {
                // As long as it takes: people see who holds it.
                return self.stand(at, Leg::WaitForHold { edge });
            }
            return self.act_on_entering(at, edge, 0, view);
        }
        let end = active.target.route_end();
        let nodes = view.site.edge(edge).map(|edge| [edge.from, edge.to].map(|id| view.site.node(id)));
        let Some([Some(from), Some(to)]) = nodes else {
            self.forget_place();
            return self.next_leg(at, view);
        };
        let (part, parts) = (active.edge_parts + 1, self.parts(edge, view));
        let is_last = part >= parts && Some(to.id) == end;
        let (map_from_goal, tolerance) = match part < parts {
            true => (
                point_between(&from.map_from_node, &to.map_from_node, f64::from(part) / f64::from(parts)),
                None,
            ),
            false if is_last => (to.map_from_node, Some(standing_tolerance(to))),
            false => match flight_at_end(edge, active.route.get(1).copied(), view.site) {
                Some(along) => (along, Some(self.config.stairs_tolerance)),
                None => (to.map_from_node, None),
            },
        };
        let walk = LegWalk {
            map_from_goal,
            tolerance,
            max_speed_m_s: view.graph.speed_m_s(edge).filter(|_| self.limits_speed(edge, view.site)),
            kind: LegKind::Path,
        };
        self.begin_walk(Leg::Edge(edge), walk);
    }

    /// Number of parts in which an edge is walked.
    pub(super) fn parts(&self, edge: EdgeId, view: &RouteView<'_>) -> u32 {
        let length_m = view.graph.cost(edge).map_or(0.0, |(_, length_m)| length_m);
        (length_m / self.config.max_part_length_m).ceil().clamp(1.0, 1_000.0) as u32
    }

    /// Whether an edge is walked more slowly than the robot walks by itself.
    fn limits_speed(&self, edge: EdgeId, site: &Site) -> bool {
        use site_model::Traversal::{Door, Slow, Stairs};
        let is_slow =
            |edge: &Edge| edge.max_speed_m_s.is_some() || matches!(edge.traversal, Stairs | Slow | Door);
        site.edge(edge).is_some_and(is_slow)
    }

    /// From beside the graph, or the middle of an edge: to the node from which the end is reached soonest.
    fn walk_to_graph(&mut self, at: Stamp, end: NodeId, graph: &RouteGraph, view: &RouteView<'_>) {
        let Some(active) = &self.active else { return };
        let Some(tree) = graph.routes_to(end) else {
            return self.end(RouteGoalResult::Failed(ReachFailure::NoSuchPlace));
        };
        let nearest = view.place.nearest;
        let on = view.place.on.and_then(|edge| view.site.edge(edge));
        let ends = on.into_iter().flat_map(|edge| {
            let is_open = graph.closure(edge.id).is_none();
            [is_open.then_some(edge.to), Some(edge.from)]
        });
        let candidates = ends.flatten().chain(nearest.filter(|_| on.is_none()));
        let candidates = candidates.filter(|node| !active.unreachable.contains(node));
        let cost_s = |node: NodeId| {
            let off_graph_m = match (view.map_from_base, view.site.node(node)) {
                (Some(base), Some(node)) => floor_distance_m(&base, &node.map_from_node),
                _ => 0.0,
            };
            Some(off_graph_m / self.config.off_graph_speed_m_s + tree.cost_s(node)?)
        };
        let best =
            candidates.filter_map(|node| Some((cost_s(node)?, node))).min_by(|(a, _), (b, _)| a.total_cmp(b));
        let reason = match (best, nearest) {
            (Some((_, node)), _) => {
                let Some(node) = view.site.node(node) else { return };
                let is_last = node.id == end;
                let tolerance = is_last.then(|| standing_tolerance(node));
                let goal = node.map_from_node;
                let leg = if is_last { Leg::IntoPose(node.id) } else { Leg::ToGraph(node.id) };
                return self.begin_walk(leg, path_walk(goal, tolerance));
            }
            (None, Some(_)) if !active.unreachable.is_empty() => ReachFailure::PathBlocked,
            (None, Some(nearest)) => match tree.route(nearest) {
                Err(reason) => {
                    let from = on.map_or(nearest, |edge| edge.from);
                    return self.handle_no_route(at, from, end, graph, no_route(reason));
                }
                Ok(_) => ReachFailure::PathBlocked,
            },
            (None, None) => return self.wait_for_place(at),
        };
        self.end(RouteGoalResult::Failed(reason));
    }

    /// Waits until it is known where the robot is, which it is not just after a start. The goal fails if that takes too long.
    fn wait_for_place(&mut self, at: Stamp) {
        let until = at + self.config.place_wait;
        match &mut self.active {
            Some(active) if active.place_waits < self.config.max_place_waits => {
                active.place_waits += 1;
                self.stand(at, Leg::WaitForPlace { until });
            }
            _ => self.end(RouteGoalResult::Failed(ReachFailure::PoseNotFound)),
        }
    }

    fn walk_into_pose(&mut self, node: NodeId, view: &RouteView<'_>) {
        let Some(node) = view.site.node(node) else {
            return self.end(RouteGoalResult::Failed(ReachFailure::NoSuchPlace));
        };
        let walk = path_walk(node.map_from_node, Some(standing_tolerance(node)));
        self.begin_walk(Leg::IntoPose(node.id), walk);
    }

    fn walk_onto_dock(&mut self, node: NodeId, approach: NodeId, view: &RouteView<'_>) {
        let (Some(node), Some(approach)) = (view.site.node(node), view.site.node(approach)) else {
            return self.end(RouteGoalResult::Failed(ReachFailure::NoSuchPlace));
        };
        let is_facing = is_ahead(&approach.map_from_node, &node.map_from_node);
        let walk = LegWalk {
            map_from_goal: node.map_from_node,
            // Where contacts touch is for the walk into the dock to say.
            tolerance: None,
            max_speed_m_s: Some(self.config.dock_speed_m_s),
            kind: LegKind::OntoDock { is_facing },
        };
        if let Some(active) = &mut self.active {
            active.route.clear();
        }
        self.begin_walk(Leg::OntoDock, walk);
    }

    fn leave_dock(&mut self, approach: NodeId, view: &RouteView<'_>) {
        let Some(node) = view.site.node(approach) else {
            return self.end(RouteGoalResult::Failed(ReachFailure::NotUndocked));
        };
        let walk = self.straight_walk(node.map_from_node, node.tolerance);
        self.begin_walk(Leg::OutOfDock(approach), walk);
    }

    fn straight_walk(&self, map_from_goal: Pose, tolerance: PoseTolerance) -> LegWalk {
        let max_speed_m_s = Some(self.config.dock_speed_m_s);
        LegWalk { map_from_goal, tolerance: Some(tolerance), max_speed_m_s, kind: LegKind::Straight }
    }

    fn begin_walk(&mut self, leg: Leg, walk: LegWalk) {
        let Some(active) = &mut self.active else { return };
        let id = leg_id(active.goal, active.walks);
        active.walks += 1;
        active.leg = Some((id, leg));
        self.effects.push(RouteEffect::Walk(id, walk));
    }
}

/// Tolerance at the end of a route: that of the node, and of a picture at most. Nodes that are passed have wide ones, in any heading.
fn standing_tolerance(node: &Node) -> PoseTolerance {
    let (own, picture) = (node.tolerance, PoseTolerance::default());
    PoseTolerance {
        along_m: own.along_m.min(picture.along_m),
        across_m: own.across_m.min(picture.across_m),
        yaw_rad: own.yaw_rad.min(picture.yaw_rad),
    }
}

/// The pose at the end of an edge, in line with the flight of stairs that begins or ends there on the route; none if there are no stairs.
fn flight_at_end(edge: EdgeId, next: Option<EdgeId>, site: &Site) -> Option<Pose> {
    let is_flight = |edge: &&Edge| edge.traversal == site_model::Traversal::Stairs;
    let flight = |id: Option<EdgeId>| site.edge(id?).filter(is_flight);
    let end = site.node(site.edge(edge)?.to)?.map_from_node;
    let flight = flight(next).or_else(|| flight(Some(edge)))?;
    let (a, b) =
        (site.node(flight.from)?.map_from_node.position, site.node(flight.to)?.map_from_node.position);
    let half_yaw = (b.y - a.y).atan2(b.x - a.x) / 2.0;
    let orientation = Quat { w: half_yaw.cos(), x: 0.0, y: 0.0, z: half_yaw.sin() };
    Some(Pose { position: end.position, orientation })
}

fn path_walk(map_from_goal: Pose, tolerance: Option<PoseTolerance>) -> LegWalk {
    LegWalk { map_from_goal, tolerance, max_speed_m_s: None, kind: LegKind::Path }
}

/// Whether the robot is charged in the dock of the target.
fn is_charged(target: RouteTarget, view: &RouteView<'_>) -> bool {
    matches!(target, RouteTarget::Dock { dock, .. } if view.docked == Some(dock))
}

fn no_route(reason: NoRoute) -> ReachFailure {
    match reason {
        NoRoute::NoSuchNode(_) => ReachFailure::NoSuchPlace,
        NoRoute::Closed { edges } => {
            ReachFailure::NoRoute { closed: edges.into_iter().map(|(edge, _)| edge).collect() }
        }
        NoRoute::NotConnected => ReachFailure::NoRoute { closed: Vec::new() },
    }
}
