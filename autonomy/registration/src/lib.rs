//! Aligning scans with a map of Gaussians: residuals and their derivatives, degeneracy, and a search for lost scans.
//!
//! Poses are perturbed on the right, order `[rotation; translation]`, metres and radians.

pub mod degeneracy;
pub mod linearise;
pub mod search;

pub use degeneracy::{Conditioned, blind_directions, condition};
pub use linearise::{MatchOptions, NormalEquations, linearise};
pub use search::{Fit, SearchOptions, refine, score, search};
