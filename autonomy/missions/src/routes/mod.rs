//! Following routes: a goal on the topological map is walked edge by edge. Each edge is a leg of the goal, or several legs if it is long.

mod active_route;
mod edge_actions;
mod edge_failures;
mod executor;
mod interface;
mod remaining;
#[cfg(test)]
mod tests;
mod waits;

pub use executor::{RouteExecutor, RouteExecutorConfig};
pub use interface::{LegKind, LegResult, LegWalk, RouteAttempt, RouteEffect, RouteView};
pub use remaining::RouteRemaining;
