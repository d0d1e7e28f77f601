//! Sparse linear least squares: ordering, symbolic analysis, factorisation, substitution.

pub mod assembly;
pub mod dense;
#[cfg(test)]
mod dense_tests;
pub mod dissection;
pub mod factorisation;
pub mod ordering;
#[cfg(test)]
mod ordering_tests;
pub mod symbolic;
