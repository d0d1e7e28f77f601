//! Planning on the topological map.

mod distance;
mod docks;
mod edge_blocks;
mod graph_localiser;
mod route_graph;
mod route_tree;
#[cfg(test)]
mod tests;
mod zones;

pub use docks::{DockConfig, DockOffset, docked_at};
pub use edge_blocks::{EdgeBlockConfig, is_blocked, next_block};
pub use graph_localiser::{GraphLocaliser, GraphLocaliserConfig, GraphPlace};
pub use route_graph::{Closure, LearnedTime, LearnedTimes, RouteConditions, RouteConfig, RouteGraph};
pub use route_tree::{NoRoute, Route, RouteTree};
pub(crate) use zones::{active_zones, zones_with_actions};
