//! The order of tasks: as listed, or that of the shortest route.

mod mission_order;
mod tour;
mod tour_heuristic;
mod tour_problem;
#[cfg(test)]
mod tour_tests;

pub use mission_order::{OrderPreview, RouteCost, node_of, order_tasks};
pub use tour::solve;
pub use tour_problem::{Tour, TourConfig, TourError, TourProblem};
