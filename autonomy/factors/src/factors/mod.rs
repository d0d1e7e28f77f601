//! Measurements.

mod between;
mod prior;

pub use between::{Between, PlanarBetween, Residual};
pub use prior::{PlanarPrior, Prior, VectorPrior};
