//! Factors by kind of measurement.

mod between;
mod inertial;
mod landmark;
mod marginal;
mod motion;
mod prior;

pub use between::{Between, PlanarBetween, Residual};
pub use inertial::{Inertial, InertialNoise, Preintegrated};
pub use landmark::{BearingRange, Landmark};
pub use marginal::Marginal;
pub use motion::{BodyVelocity, GravityDirection, RandomWalk};
pub use prior::{PlanarPrior, Prior, VectorPrior};
