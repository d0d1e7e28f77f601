//! Following routes: a goal on the topological map is walked edge by edge, each edge a goal of the executive.

mod edge_actions;
mod edge_failures;
mod executor;
mod interface;
mod journey;
#[cfg(test)]
mod tests;

pub use executor::{RouteExecutor, RouteExecutorConfig};
pub use interface::{LegResult, LegWalk, LegWay, RouteEffect, RouteView};
