//! Where the robot is on the graph: at a node, on an edge, and which node is nearest. With hysteresis, so that a pose that is noisy does not make these flicker.

use super::RouteGraph;
use crate::poses::{heading_rad, turn_between_rad};
use site_model::{EdgeId, Node, NodeId, Site};
use vocab::{Pose, Vec3, is_in_polygon};

/// Parameters of [`GraphLocaliser`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraphLocaliserConfig {
    /// The robot leaves a node once it is this many times its tolerance away from it. Chosen: half more, so that noise at the border does not change the node.
    pub leave_ratio: f64,
    /// Least distance beyond the tolerance at which it leaves a node, metres. Chosen: five times the noise of localisation.
    pub leave_margin_m: f64,
    /// A node has to be nearer than the present nearest one by this distance to replace it, metres. Chosen: a robot in the middle of two nodes does not change between
    /// them by its sway.
    pub nearest_margin_m: f64,
    /// Greatest distance from the line of an edge at which the robot is on it, metres. Chosen: the greatest width of a corridor to either side
    /// ([`site_model::Corridor`]).
    pub edge_distance_m: f64,
    /// An edge has to be nearer than the present one by this distance to replace it, metres. Chosen: as [`Self::nearest_margin_m`].
    pub edge_margin_m: f64,
    /// An edge along which the robot would walk backwards counts as farther away by this, metres. More than the margin, so that of a pair the edge ahead is taken.
    /// Chosen: 0.2 m more.
    pub backwards_penalty_m: f64,
    /// A node or edge that is higher or lower than the robot by more than this is on another floor, metres: less than half a storey. Its default is that of generated
    /// maps.
    pub floor_separation_m: f64,
}

impl GraphLocaliserConfig {
    /// With the separation of floors by which the robot walks.
    pub fn new(floor_separation_m: f64) -> Self {
        Self {
            leave_ratio: 1.5,
            leave_margin_m: 0.05,
            nearest_margin_m: 0.3,
            edge_distance_m: 1.0,
            edge_margin_m: 0.3,
            backwards_penalty_m: 0.5,
            floor_separation_m,
        }
    }
}

/// Where the robot is on the graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GraphPlace {
    /// The node that it is at.
    pub at: Option<NodeId>,
    /// The nearest node on its floor.
    pub nearest: Option<NodeId>,
    /// The edge that it is on, if it is at no node. Of a pair, the one that leads where the robot faces.
    pub on: Option<EdgeId>,
}

/// Follows the robot on the graph.
#[derive(Clone, Debug)]
pub struct GraphLocaliser {
    config: GraphLocaliserConfig,
    place: GraphPlace,
}

impl GraphLocaliser {
    /// With these parameters.
    pub fn new(config: GraphLocaliserConfig) -> Self {
        Self { config, place: GraphPlace::default() }
    }

    /// Where the robot was at the last update.
    pub fn place(&self) -> GraphPlace {
        self.place
    }

    /// Follows the robot to a pose, the base in the map. Linear in nodes and edges.
    pub fn update(&mut self, site: &Site, graph: &RouteGraph, map_from_base: &Pose) -> GraphPlace {
        let at = self.find_at(site, map_from_base);
        let nearest = at.or_else(|| self.find_nearest(site, map_from_base));
        let on = if at.is_some() { None } else { self.find_edge(graph, map_from_base) };
        self.place = GraphPlace { at, nearest, on };
        self.place
    }

    fn find_at(&self, site: &Site, pose: &Pose) -> Option<NodeId> {
        let stays = self
            .place
            .at
            .and_then(|id| site.node(id))
            .filter(|node| self.is_at(node, pose, self.config.leave_ratio, self.config.leave_margin_m));
        let arrives = || {
            let reached = site.nodes().filter(|node| self.is_at(node, pose, 1.0, 0.0));
            let distance = |node: &&Node| offset_m(node, pose).iter().map(|c| c * c).sum::<f64>();
            reached.min_by(|a, b| distance(a).total_cmp(&distance(b)))
        };
        stays.or_else(arrives).map(|node| node.id)
    }

    /// Whether the base is within a multiple of a node's tolerance, and a margin, or in its influence area.
    fn is_at(&self, node: &Node, pose: &Pose, ratio: f64, margin_m: f64) -> bool {
        let [x, y] = offset_m(node, pose);
        if self.is_on_other_floor(node.map_from_node.position, pose.position) {
            return false;
        }
        if is_in_polygon(&node.influence_area_m, [x, y]) {
            return true;
        }
        let along_m = node.tolerance.along_m * ratio + margin_m;
        let across_m = node.tolerance.across_m * ratio + margin_m;
        let turn = turn_between_rad(heading_rad(&node.map_from_node), heading_rad(pose)).abs();
        (x / along_m).powi(2) + (y / across_m).powi(2) <= 1.0 && turn <= node.tolerance.yaw_rad * ratio
    }

    fn find_nearest(&self, site: &Site, pose: &Pose) -> Option<NodeId> {
        let distance = |node: &Node| super::distance::distance_m(node.map_from_node.position, pose.position);
        let on_floor =
            site.nodes().filter(|node| !self.is_on_other_floor(node.map_from_node.position, pose.position));
        let nearest = on_floor.min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        let before = self.place.nearest.and_then(|id| site.node(id));
        let keeps = before.filter(|before| {
            !self.is_on_other_floor(before.map_from_node.position, pose.position)
                && distance(before) < distance(nearest) + self.config.nearest_margin_m
        });
        Some(keeps.unwrap_or(nearest).id)
    }

    fn find_edge(&self, graph: &RouteGraph, pose: &Pose) -> Option<EdgeId> {
        let heading = heading_rad(pose);
        // Distance to the line, and more for an edge that leads backwards.
        let badness = |index: &usize| {
            let edge = &graph.edges[*index];
            let (from, to) = (graph.positions[edge.from], graph.positions[edge.to]);
            let (distance_m, height_m) = distance_to_line_m(from, to, pose.position);
            let is_near =
                distance_m <= self.config.edge_distance_m && height_m <= self.config.floor_separation_m;
            let direction = (to.y - from.y).atan2(to.x - from.x);
            let is_backwards = turn_between_rad(direction, heading).abs() > std::f64::consts::FRAC_PI_2;
            is_near.then_some(distance_m + if is_backwards { self.config.backwards_penalty_m } else { 0.0 })
        };
        let candidates = (0..graph.edges.len()).filter_map(|index| Some((index, badness(&index)?)));
        let (best, best_badness) = candidates.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let before = self.place.on.and_then(|id| graph.edge_index.get(&id));
        let keeps = before.filter(|index| {
            badness(index).is_some_and(|badness| badness < best_badness + self.config.edge_margin_m)
        });
        Some(graph.edges[*keeps.unwrap_or(&best)].id)
    }

    fn is_on_other_floor(&self, a: Vec3, b: Vec3) -> bool {
        (a.z - b.z).abs() > self.config.floor_separation_m
    }
}

/// The base in the horizontal frame of a node, metres.
fn offset_m(node: &Node, pose: &Pose) -> [f64; 2] {
    let (sin, cos) = heading_rad(&node.map_from_node).sin_cos();
    let (a, b) = (pose.position, node.map_from_node.position);
    let (x, y) = (a.x - b.x, a.y - b.y);
    [cos * x + sin * y, cos * y - sin * x]
}

/// Horizontal distance from a point to a line between two points, and difference in height to its nearest point, metres.
fn distance_to_line_m(from: Vec3, to: Vec3, point: Vec3) -> (f64, f64) {
    let (x, y) = (to.x - from.x, to.y - from.y);
    let length2 = x * x + y * y;
    let along = (point.x - from.x) * x + (point.y - from.y) * y;
    let share = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
    let (dx, dy) = (from.x + share * x - point.x, from.y + share * y - point.y);
    ((dx * dx + dy * dy).sqrt(), (from.z + share * (to.z - from.z) - point.z).abs())
}
