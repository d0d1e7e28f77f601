//! A factor graph: factors with their kernels. Each factor is checked against the variables when it is added.

use crate::error::{FactorError, SolveError};
use crate::factor::{Factor, Linearised};
use crate::kernel::Kernel;
use crate::names::FactorId;
use crate::texts;
use crate::value::Values;
use std::sync::Arc;

/// A factor in a graph.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The measurement.
    pub factor: Arc<dyn Factor>,
    /// Robust kernel: limits the cost of a large residual.
    pub kernel: Kernel,
    /// Multiplies the cost. 1 unless robust estimation reduces the influence of an outlier.
    pub weight: f64,
}

impl Entry {
    /// Cost and weight at a squared whitened residual (docs/maths/factors.md, equations 3 and 4).
    pub(crate) fn evaluate(&self, squared: f64) -> (f64, f64) {
        let (cost, slope) = self.kernel.evaluate(squared);
        (cost * self.weight, slope * self.weight)
    }
}

/// The factors of a problem.
#[derive(Clone, Debug, Default)]
pub struct FactorGraph {
    entries: Vec<Option<Entry>>,
}

/// Checks that the variables of `factor` exist in `values`, have the right kinds and differ from each other.
///
/// # Errors
/// When one of these does not hold.
pub fn check(factor: &dyn Factor, values: &Values) -> Result<(), FactorError> {
    let keys = factor.keys();
    for (index, (&key, &needed)) in keys.iter().zip(factor.kinds()).enumerate() {
        let found = values.get(key).ok_or(FactorError::UnknownVariable { key })?.kind();
        if found != needed {
            return Err(FactorError::Kind { key, found, needed });
        }
        if keys[..index].contains(&key) {
            return Err(FactorError::Repeated { key });
        }
    }
    Ok(())
}

impl FactorGraph {
    /// Adds a factor over variables of `values`.
    ///
    /// # Errors
    /// When a variable is missing, of another kind or named twice.
    pub fn add(&mut self, factor: impl Factor + 'static, values: &Values) -> Result<FactorId, FactorError> {
        self.add_robust(factor, Kernel::None, values)
    }

    /// Adds a factor with a robust kernel.
    ///
    /// # Errors
    /// As for [`Self::add`], and when the kernel's parameter is not positive.
    pub fn add_robust(
        &mut self,
        factor: impl Factor + 'static,
        kernel: Kernel,
        values: &Values,
    ) -> Result<FactorId, FactorError> {
        check(&factor, values)?;
        if !kernel.is_valid() {
            return Err(FactorError::NotFinite { what: texts::KERNEL_PARAMETER });
        }
        Ok(self.push(Entry { factor: Arc::new(factor), kernel, weight: 1.0 }))
    }

    pub(crate) fn push(&mut self, entry: Entry) -> FactorId {
        self.entries.push(Some(entry));
        FactorId(self.entries.len() as u32 - 1)
    }

    /// Removes a factor.
    ///
    /// # Errors
    /// When there is no such factor.
    pub fn remove(&mut self, id: FactorId) -> Result<Entry, SolveError> {
        let slot = self.entries.get_mut(id.index());
        slot.and_then(Option::take).ok_or(SolveError::UnknownFactor { factor: id })
    }

    /// A factor.
    pub fn get(&self, id: FactorId) -> Option<&Entry> {
        self.entries.get(id.index()).and_then(Option::as_ref)
    }

    /// A factor, to change its kernel or weight.
    pub fn get_mut(&mut self, id: FactorId) -> Option<&mut Entry> {
        self.entries.get_mut(id.index()).and_then(Option::as_mut)
    }

    /// All factors, by id.
    pub fn iter(&self) -> impl Iterator<Item = (FactorId, &Entry)> {
        let named =
            |(index, entry): (usize, &'_ Option<Entry>)| entry.as_ref().map(|_| FactorId(index as u32));
        self.entries
            .iter()
            .enumerate()
            .filter_map(move |pair| named(pair).and_then(|id| pair.1.as_ref().map(|entry| (id, entry))))
    }

    /// Number of factors.
    pub fn len(&self) -> usize {
        self.entries.iter().flatten().count()
    }

    /// Whether there are no factors.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One past the greatest id ever given.
    pub(crate) fn ids(&self) -> usize {
        self.entries.len()
    }

    /// Removes every factor from `ids` on.
    pub(crate) fn truncate(&mut self, ids: usize) {
        self.entries.truncate(ids);
    }

    /// Puts a removed factor back.
    pub(crate) fn restore(&mut self, id: FactorId, entry: Entry) {
        if let Some(slot) = self.entries.get_mut(id.index()) {
            *slot = Some(entry);
        }
    }

    /// Sum of squared whitened residuals without kernels and weights: chi-squared.
    ///
    /// # Errors
    /// When a factor cannot be evaluated.
    pub fn chi_squared(&self, values: &Values) -> Result<f64, SolveError> {
        self.squared(values).map(|squares| squares.iter().map(|(_, square)| square).sum())
    }

    /// Squared whitened residual of every factor.
    ///
    /// # Errors
    /// When one cannot be evaluated.
    pub fn squared(&self, values: &Values) -> Result<Vec<(FactorId, f64)>, SolveError> {
        let mut scratch = Linearised::default();
        self.iter()
            .map(|(id, entry)| {
                scratch.reset(&*entry.factor);
                entry
                    .factor
                    .residual(values, &mut scratch)
                    .map_err(|source| SolveError::Factor { factor: id, source })?;
                Ok((id, scratch.squared()))
            })
            .collect()
    }
}
