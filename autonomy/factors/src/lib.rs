//! Factor graphs: they estimate poses, landmarks, velocities and biases from measurements that each constrain a few of them.
//!
//! [`Values`] hold the variables, a [`FactorGraph`] the factors. [`optimise`] solves a whole graph (Gauss-Newton, Levenberg-Marquardt or Dogleg).
//! [`Incremental`] keeps a solution up to date while variables and factors are added and removed (iSAM2).
//!
//! Conventions: metres, radians, seconds. Errors move poses on the right. SE(3) errors are `[rotation; translation]`, SE(2) errors are
//! `[x; y; yaw]`. Equal input gives equal bits on equal processors. Nothing panics on input: a graph that cannot be solved gives an error that
//! names the variable. docs/maths/factors.md has the equations.

mod batch;
mod error;
mod factor;
mod graph;
mod incremental;
mod information;
mod initialise;
mod kernel;
mod linear;
mod marginals;
mod measurements;
mod names;
mod robust;
mod texts;
mod value;

pub use batch::{BatchConfig, DampingConfig, Method, Solution, TrustRegionConfig, optimise};
pub use error::{FactorError, SolveError};
pub use factor::{Factor, Linearised, RelativePose};
pub use graph::{Entry, FactorGraph};
pub use incremental::{Incremental, IncrementalConfig, IncrementalSnapshot, Updated};
pub use information::Whitening;
pub use initialise::{ChordalConfig, chordal};
pub use kernel::Kernel;
pub use marginals::Marginals;
pub use measurements::{
    BearingRange, Between, BodyVelocity, GravityDirection, Inertial, InertialNoise, Landmark, Marginal,
    PlanarBetween, PlanarPrior, Preintegrated, Prior, RandomWalk, Residual, VectorPrior,
};
pub use names::{FactorId, Key, VariableKind};
pub use robust::{RobustConfig, RobustSolution, optimise_robustly};
pub use value::{Planar, Value, Values};
