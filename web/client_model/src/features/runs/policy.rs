//! The policy of a route: from each node of the topological map the edge on the cheapest route to where the robot goes. From wherever it comes to stand, it goes on so.

use crate::features::site::SiteFeature;
use missions::{RouteConditions, RouteConfig, RouteGraph};
use site_model::{EdgeId, NodeId, RouteProgress};
use vocab::Stamp;

/// The policy, kept until site or route have changed.
#[derive(Clone, Debug, Default)]
pub(super) struct RoutePolicy {
    /// Revision of the site, the node at the end of the route, and the edges that were left when the policy was found.
    found_for: Option<(u64, NodeId, Vec<EdgeId>)>,
    steps: Vec<[NodeId; 2]>,
}

impl RoutePolicy {
    /// The steps from node to node, in the order of their ids.
    pub(super) fn steps(&self) -> &[[NodeId; 2]] {
        &self.steps
    }

    /// Finds the policy anew if site or route have changed: one search of the graph. Without the robot's clock every block counts.
    pub(super) fn update(
        &mut self,
        feature: &SiteFeature,
        route: Option<&RouteProgress>,
        now: Option<Stamp>,
    ) {
        let Some((site, route)) = feature.site().zip(route) else {
            *self = Self::default();
            return;
        };
        let is_same = |(revision, target, edges): &(u64, NodeId, Vec<EdgeId>)| {
            *revision == feature.revision() && *target == route.target && *edges == route.edges
        };
        if self.found_for.as_ref().is_some_and(is_same) {
            return;
        }
        self.found_for = Some((feature.revision(), route.target, route.edges.clone()));
        let conditions = RouteConditions { now: now.unwrap_or(Stamp::EPOCH), ..RouteConditions::default() };
        let graph = RouteGraph::new(site, &conditions, &RouteConfig::default());
        let edges = graph.routes_to(route.target).map(|tree| tree.policy()).unwrap_or_default();
        let ends = |edge: EdgeId| site.edge(edge).map(|edge| [edge.from, edge.to]);
        self.steps = edges.into_values().filter_map(ends).collect();
    }
}
