//! Aligning scans with a map of Gaussians: residuals and their derivatives, degeneracy, the Gauss-Newton iteration, and a search
//! from many starts.
//!
//! Errors of poses are on the right, order `[rotation; translation]`, radians and metres. Equations: docs/maths/odometry.md,
//! section "Scan registration".

pub mod degeneracy;
pub mod gauss_newton;
pub mod linearise;
pub mod multi_start;

pub use degeneracy::{ScanInformationConfig, ShrunkEquations, degenerate_directions, shrink_eigenvalues};
pub use gauss_newton::{GaussNewtonConfig, WidthSchedule, gauss_newton};
pub use linearise::{MatchingConfig, NormalEquations, linearise, linearise_from_viewpoint};
pub use multi_start::{
    Fit, MultiStartConfig, multi_start, refine, refine_from_viewpoint, score, score_from_viewpoint,
};
