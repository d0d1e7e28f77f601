//! Fixed-lag smoothing: old variables are marginalised, so memory and time depend on the lag and not on the length of the walk.

use super::Incremental;
use crate::error::SolveError;
use crate::graph::Entry;
use crate::kernel::Kernel;
use crate::measurements::Marginal;
use crate::names::{FactorId, Key};
use crate::value::Value;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

impl Incremental {
    /// Removes variables from the problem and returns the [`Marginal`] factors that replace them. Estimates of the other variables stay the
    /// same. Staged changes are applied first.
    ///
    /// Cost: elimination of the cliques that contain the variables and of those above. The oldest variables of a walk lie at the leaves, so
    /// they are cheap.
    ///
    /// # Errors
    /// When a variable is not part of the solution, or the update fails. Nothing is removed then.
    pub fn marginalise(&mut self, keys: &[Key]) -> Result<Vec<FactorId>, SolveError> {
        self.update()?;
        let mut around = Vec::new();
        for &key in keys {
            if self.tree.clique_of(key.0).is_none() {
                return Err(SolveError::UnknownVariable { key });
            }
            self.tree.containing(key.0, &mut around);
        }
        let seeds: Vec<u32> =
            around.iter().filter_map(|&number| self.tree.get(number)?.frontal.first().copied()).collect();
        let top = self.top(&seeds);
        let goes = |variable: u32| keys.contains(&Key(variable));
        let groups: Vec<u8> = top.variables.iter().map(|&variable| u8::from(!goes(variable))).collect();
        let eliminated = self.eliminate(&top, &groups, &groups);
        let mut eliminated = eliminated.map_err(|bad| SolveError::Undetermined { key: Key(bad.0) })?;

        // The cliques of the removed variables form subtrees at the leaves. The Schur complement of each subtree's uppermost clique is its
        // marginal.
        let (parting, staying): (Vec<_>, Vec<_>) = std::mem::take(&mut eliminated.cliques)
            .into_iter()
            .partition(|clique| clique.frontal.first().is_some_and(|&first| goes(first)));
        let stays = |variable: &u32| !goes(*variable);
        let mut summaries = Vec::new();
        for clique in parting.iter().filter(|clique| clique.separator.first().is_some_and(stays)) {
            let keys: Vec<Key> = clique.separator.iter().map(|&variable| Key(variable)).collect();
            summaries.push((self.summary(keys, &clique.update)?, clique.update.clone()));
        }
        eliminated.cliques = staying;
        self.put_back(&top, eliminated);
        self.forget(keys);
        Ok(summaries.into_iter().map(|(factor, packed)| self.add_linear(factor, packed)).collect())
    }

    /// Packed normal equations at the present linearisation points as a factor.
    fn summary(&self, keys: Vec<Key>, packed: &[f64]) -> Result<Marginal, SolveError> {
        let at: Vec<Value> = keys.iter().filter_map(|&key| self.values.get(key).copied()).collect();
        let size = keys.iter().map(|key| usize::from(self.dimensions[key.index()])).sum();
        let mut information = DMatrix::zeros(size, size);
        let mut right_hand_side = DVector::zeros(size);
        let mut rest = packed;
        for column in 0..size {
            let (entries, after) = rest.split_at(size - column + 1);
            rest = after;
            for (row, &entry) in (column..size).zip(entries) {
                information[(row, column)] = entry;
                information[(column, row)] = entry;
            }
            right_hand_side[column] = entries[size - column];
        }
        let first = keys.first().copied().unwrap_or(Key(0));
        Marginal::new(keys, at, &information, &right_hand_side)
            .map_err(|_| SolveError::Undetermined { key: first })
    }

    /// Removes the factors of the marginalised variables and freezes their estimates.
    fn forget(&mut self, keys: &[Key]) {
        for &key in keys {
            for id in std::mem::take(&mut self.factors_of[key.index()]) {
                if let Ok(entry) = self.graph.remove(id) {
                    for other in entry.factor.keys() {
                        self.factors_of[other.index()].retain(|&own| own != id);
                    }
                    self.linear[id.index()] = Vec::new();
                }
            }
            let range = self.starts[key.index()]..self.starts[key.index() + 1];
            self.values.retract_one(key, &self.delta[range.clone()]);
            self.delta[range].fill(0.0);
            self.forgotten[key.index()] = true;
        }
    }

    fn add_linear(&mut self, factor: Marginal, packed: Vec<f64>) -> FactorId {
        let entry = Entry { factor: Arc::new(factor), kernel: Kernel::None, weight: 1.0 };
        let keys = entry.factor.keys().to_vec();
        let id = self.graph.push(entry);
        for key in keys {
            self.factors_of[key.index()].push(id);
        }
        self.linear.push(packed);
        id
    }
}
