//! Aligning scans with a map of Gaussians: residuals and their derivatives, degeneracy, and a search for lost scans.
//!
//! Poses are perturbed on the right, order `[rotation; translation]`, metres and radians.

pub mod degeneracy;
pub mod linearise;
pub mod multi_start;

pub use degeneracy::{ShrunkEquations, degenerate_directions, shrink_eigenvalues};
pub use linearise::{MatchingConfig, NormalEquations, linearise};
pub use multi_start::{Fit, MultiStartConfig, multi_start, refine, score};
