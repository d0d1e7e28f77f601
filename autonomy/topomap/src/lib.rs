//! The topological map of a site, made from its metric map.
//!
//! [`generate`] takes the path that the robot has walked and the clouds of the keyframes ([`FloorBuilder`]), and makes nodes, edges and docks:
//!
//! 1. `floor`: ground and obstacles of all storeys;
//! 2. `path`: the walked path with its stairs, or `survey`: paths over the walkable floor of a survey that nobody walked;
//! 3. `path_graph`: paths that come back to the same places share them; small loops and dead ends go, junctions near to each other become one;
//! 4. `simplify`: nodes at junctions, bends and regular distances, with straight edges between them, each checked by `corridor`;
//! 5. `objects`: the objects of [`site_model`], anchored to keyframes.
//!
//! Everything is a pure function: the same input gives the same bits, ids included. docs/maths/topomap.md describes the method. [`MapMotion`] moves a
//! site with the keyframes of its map.

mod config;
mod corridor;
mod docks;
mod floor;
mod follow;
mod objects;
mod path;
mod path_graph;
mod simplify;
mod site_edit;
mod survey;
mod texts;

pub use config::{NodeToleranceConfig, TopomapConfig};
pub use floor::FloorBuilder;
pub use follow::{FollowConfig, Following, MapMotion};
pub use navigation::RobotShape;
pub use path_graph::{BlockedBy, BlockedSegment};
pub use site_edit::Replacement;

use corridor::Passage;
use geometry::Isometry;
use path::Path;
use path_graph::PathGraph;
use site_model::{Dock, Edge, Node, Object};
use std::collections::BTreeMap;
use vocab::{KeyframeId, MapId, Stamp};

/// What a topological map is made from, besides the clouds.
#[derive(Clone, Copy, Debug)]
pub struct TopomapInput<'a> {
    /// The map. The ids of all objects follow from it.
    pub map: MapId,
    /// Keyframes with their poses in the map.
    pub keyframes: &'a [(KeyframeId, Isometry)],
    /// Poses of the base with their times, in the order in which the robot walked. Empty: a survey that nobody walked.
    pub path: &'a [(Stamp, Isometry)],
    /// Poses of the base on docks.
    pub docks: &'a [Isometry],
    /// Shape of the robot.
    pub robot: RobotShape,
}

/// A topological map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GeneratedMap {
    /// Nodes, in the order in which the robot came to them.
    pub nodes: Vec<Node>,
    /// Edges, in pairs: one for each direction.
    pub edges: Vec<Edge>,
    /// Docks that are joined to a path.
    pub docks: Vec<Dock>,
    /// Stretches of the path where the map shows an obstacle. They have no edge.
    pub blocked: Vec<BlockedSegment>,
    /// Number of connected pieces; 1 if every node can be reached from every other.
    pub pieces: usize,
}

impl GeneratedMap {
    /// All objects.
    pub fn objects(&self) -> impl Iterator<Item = Object> + '_ {
        let nodes = self.nodes.iter().cloned().map(Object::Node);
        let edges = self.edges.iter().cloned().map(Object::Edge);
        nodes.chain(edges).chain(self.docks.iter().cloned().map(Object::Dock))
    }

    /// Length of all edges, one direction of each, metres.
    pub fn length_m(&self) -> f64 {
        let positions: BTreeMap<_, _> =
            self.nodes.iter().map(|node| (node.id, node.map_from_node.position)).collect();
        let length_m = |edge: &Edge| {
            let (a, b) = (positions.get(&edge.from)?, positions.get(&edge.to)?);
            Some((a.x - b.x).hypot(a.y - b.y).hypot(a.z - b.z))
        };
        self.edges.iter().filter_map(length_m).sum::<f64>() / 2.0
    }
}

/// Makes a topological map. `floor` holds the clouds of the keyframes. Takes about a second for a hall of 60 m x 40 m.
pub fn generate(input: &TopomapInput<'_>, floor: FloorBuilder, config: &TopomapConfig) -> GeneratedMap {
    let path = Path::new(input.path, input.robot.standing_height_m, config);
    let floor = floor.build(&path.positions);
    let passage = Passage { floor: &floor, path: &path };
    let mut graph = PathGraph::new(config);
    docks::add_docks(&mut graph, input, &passage);
    if path.walks.is_empty() {
        for feet in survey::survey_paths(&floor) {
            graph.add_walk(&path::virtual_walk(&feet, config), &passage);
        }
        // Nobody has walked there.
        graph.blocked.clear();
    } else {
        for walk in &path.walks {
            graph.add_walk(walk, &passage);
        }
    }
    docks::join_docks(&mut graph, &passage);
    graph.remove_small_loops(config);
    graph.remove_dead_ends(config);
    graph.merge_junctions(&passage);
    graph.remove_small_loops(config);
    let mut straight = simplify::straight_edges(&graph, &passage);
    simplify::merge_near_nodes(&mut straight, &graph, &passage);
    // Where an edge leads past an obstacle, the path is not blocked.
    let is_cut = |segment: &BlockedSegment| {
        !simplify::has_edge_past(&straight, &graph, segment, config.merge_distance_m)
    };
    let blocked = graph.blocked.iter().copied().filter(is_cut).collect();
    GeneratedMap { blocked, ..objects::objects(input, &graph, &straight, &passage) }
}

#[cfg(test)]
mod tests;
