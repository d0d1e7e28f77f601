//! What is left of a route, for the progress of its goal: how far it is beyond the leg that is walked, and why the robot stands if it waits.

use super::active_route::{ActiveRoute, Leg, RouteTarget};
use super::executor::RouteExecutor;
use super::interface::RouteView;
use super::waits::waits_for;
use crate::poses::floor_distance_m;
use site_model::{EdgeId, EdgeStage, NodeId, RouteWait};

/// What is left of a route besides the leg that is walked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RouteRemaining {
    /// Distance from the end of the leg to the goal, metres; from the robot where it stands. None while no route is known.
    pub beyond_leg_m: Option<f64>,
    /// Why the robot waits, if it does.
    pub waits_for: Option<RouteWait>,
}

impl RouteExecutor {
    /// What is left of the active goal. Without a goal nothing is known.
    pub fn remaining(&self, view: &RouteView<'_>) -> RouteRemaining {
        let Some(active) = &self.active else { return RouteRemaining::default() };
        let Some((_, leg)) = active.leg else { return RouteRemaining::default() };
        RouteRemaining { beyond_leg_m: self.beyond_leg_m(active, leg, view), waits_for: waits_for(leg, view) }
    }

    fn beyond_leg_m(&self, active: &ActiveRoute, leg: Leg, view: &RouteView<'_>) -> Option<f64> {
        let on_route_m = match leg {
            Leg::Edge(edge) => {
                let share = f64::from(active.edge_parts + 1) / f64::from(self.parts(edge, view));
                (1.0 - share).max(0.0) * length_m(edge, view) + after_m(active, edge, view)
            }
            Leg::Act { edge, stage: EdgeStage::Leave, .. } => after_m(active, edge, view),
            // The edge that was left out, or is to be walked next, is a part of the route.
            Leg::Act { edge, .. } | Leg::Wait { edge, .. } | Leg::WaitForHold { edge } => {
                length_m(edge, view) + after_m(active, edge, view)
            }
            Leg::ToGraph(node) | Leg::OutOfDock(node) => route_m(active.target, node, view)?,
            Leg::IntoPose(_) | Leg::BackOff(_) => 0.0,
            Leg::OntoDock | Leg::Charge { .. } => return Some(0.0),
            Leg::WaitForBlock { .. } | Leg::WaitForPlace { .. } => return None,
        };
        Some(on_route_m + into_dock_m(active.target, view))
    }
}

/// Length of the edges of the route after this one.
fn after_m(active: &ActiveRoute, edge: EdgeId, view: &RouteView<'_>) -> f64 {
    let later = active.route.iter().skip_while(|known| **known != edge).skip(1);
    later.map(|edge| length_m(*edge, view)).sum()
}

fn length_m(edge: EdgeId, view: &RouteView<'_>) -> f64 {
    view.graph.cost(edge).map_or(0.0, |(_, length_m)| length_m)
}

/// Length of the route from a node to the end of the route; none if there is no open one.
fn route_m(target: RouteTarget, from: NodeId, view: &RouteView<'_>) -> Option<f64> {
    let Some(end) = target.route_end() else { return Some(0.0) };
    Some(view.graph.routes_to(end)?.route(from).ok()?.length_m)
}

/// Length of the walk from the end of the route into the dock.
fn into_dock_m(target: RouteTarget, view: &RouteView<'_>) -> f64 {
    let RouteTarget::Dock { node, approach, .. } = target else { return 0.0 };
    match (view.site.node(node), view.site.node(approach)) {
        (Some(node), Some(approach)) => floor_distance_m(&node.map_from_node, &approach.map_from_node),
        _ => 0.0,
    }
}
