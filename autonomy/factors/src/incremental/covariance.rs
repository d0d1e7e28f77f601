//! Marginal covariances from the Bayes tree.

use super::Incremental;
use crate::error::SolveError;
use crate::linear::assembly::{scalars, substitute_forward};
use crate::linear::factorisation::{gather, products, scatter};
use crate::names::Key;
use nalgebra::DMatrix;

impl Incremental {
    /// Joint covariance of some variables at the last update, in the order of `keys`. Each block refers to the variable's own error.
    ///
    /// With the information matrix `L Lᵀ`, a block of its inverse is `Yᵀ Y`. `L Y` are the unit vectors of the variables' scalars. `Y` is zero
    /// outside the paths from their cliques to the root. Cost: one forward substitution along the path for each scalar.
    ///
    /// # Errors
    /// When a variable is not (or no longer) part of the solution.
    pub fn covariance(&self, keys: &[Key]) -> Result<DMatrix<f64>, SolveError> {
        let mut columns = Vec::new();
        for &key in keys {
            if self.tree.clique_of(key.0).is_none() {
                return Err(SolveError::UnknownVariable { key });
            }
            let range = self.starts[key.index()]..self.starts[key.index() + 1];
            columns.extend(range.map(|scalar| self.forward(key, scalar)));
        }
        let size = columns.len();
        Ok(DMatrix::from_vec(size, size, products(&columns)))
    }

    /// Solution of `L y = unit vector`.
    fn forward(&self, key: Key, scalar: usize) -> Vec<f64> {
        let mut vector = vec![0.0; self.delta.len()];
        vector[scalar] = 1.0;
        let mut local = Vec::new();
        let mut next = self.tree.clique_of(key.0);
        while let Some(clique) = next.and_then(|number| self.tree.get(number)) {
            let all = || clique.frontal.iter().chain(&clique.separator);
            gather(&self.starts, all(), &vector, &mut local);
            substitute_forward(&clique.panel, scalars(&clique.frontal, &self.dimensions), 1, &mut local);
            scatter(&self.starts, all(), &local, &mut vector);
            next = clique.parent;
        }
        vector
    }
}
