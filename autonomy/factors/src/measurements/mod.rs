//! Measurements.

mod between;
mod marginal;
mod prior;

pub use between::{Between, PlanarBetween, Residual};
pub use marginal::Marginal;
pub use prior::{PlanarPrior, Prior, VectorPrior};
