//! Incremental smoothing (iSAM2): the solution is kept up to date while variables and factors are added and removed.
//!
//! The square root of the information matrix is kept as a *Bayes tree*: cliques of variables, each conditioned on variables of its parent. A new
//! factor changes only the cliques of its variables and those above them, up to the root. These cliques are turned back into factors, ordered
//! anew and eliminated again. The newest variables are ordered last, so they stay near the root. The subtrees below are kept: each enters as the
//! normal equations over its separator. Variables that have moved far from their linearisation point are treated like newly measured ones.
//!
//! Source: Kaess, Johannsson, Roberts, Ila, Leonard, Dellaert, *iSAM2: Incremental smoothing and mapping using the Bayes tree*,
//! IJRR 31, 2012.

mod covariance;
mod forget;
mod snapshot;
mod tree;
mod update;

use crate::error::{FactorError, SolveError};
use crate::factor::Factor;
use crate::graph::{Entry, FactorGraph};
use crate::kernel::Kernel;
use crate::linear::assembly::Assembly;
use crate::names::{FactorId, Key};
use crate::texts;
use crate::value::{Value, Values};
use std::sync::Arc;
use tree::Tree;

pub use snapshot::IncrementalSnapshot;

/// Thresholds of relinearisation and of back-substitution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IncrementalConfig {
    /// A variable is relinearised once an angle of its error exceeds this value, radians. Chosen: 3 degrees. Smaller values linearise more factors again at each update;
    /// docs/maths/factors.md has the chi-squared that the defaults reach.
    pub relinearise_angle_rad: f64,
    /// The same for every other component (metres, metres per second…). Chosen: at a distance of 4 m, what [`Self::relinearise_angle_rad`] moves.
    pub relinearise_length_m: f64,
    /// Back-substitution stops at changes of the solution smaller than this value (radians, metres). Chosen: a millimetre and a milliradian, below the noise of
    /// measurements. Smaller values update more variables each time.
    pub min_change: f64,
    /// An update that affects more than this share of the variables solves for all of them again. Chosen: to keep less than a third of the tree saves little.
    pub batch_share: f64,
}

impl Default for IncrementalConfig {
    fn default() -> Self {
        Self { relinearise_angle_rad: 0.05, relinearise_length_m: 0.2, min_change: 1e-3, batch_share: 0.7 }
    }
}

/// Numbers of one update.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Updated {
    /// Variables whose factors were linearised again.
    pub relinearised: usize,
    /// Variables eliminated again.
    pub eliminated: usize,
    /// Variables whose solution was computed again.
    pub solved: usize,
    /// Cliques in the tree afterwards.
    pub cliques: usize,
}

/// An incremental solver.
///
/// [`Self::insert`], [`Self::add`] and [`Self::remove`] stage changes. [`Self::update`] applies all of them; when it fails, it drops all of
/// them.
///
/// Cost of an update: elimination of the variables between the changed ones and the root. Exploration costs the same at any map size. A loop
/// closure costs about as much as eliminating its loop's separators. Memory is that of the factor (see [`Self::memory`]).
#[derive(Debug, Default)]
pub struct Incremental {
    config: IncrementalConfig,
    graph: FactorGraph,
    /// Linearisation points.
    values: Values,
    /// Solution relative to `values`, all scalars in the keys' order.
    delta: Vec<f64>,
    dimensions: Vec<u8>,
    /// First scalar of each variable. The last entry is the number of scalars.
    starts: Vec<usize>,
    /// Factors of each variable, ascending.
    factors_of: Vec<Vec<FactorId>>,
    /// Packed normal equations of each factor at `values`.
    linear: Vec<Vec<f64>>,
    tree: Tree,
    /// Marginalised variables.
    forgotten: Vec<bool>,
    assembly: Assembly,
    staged: Staged,
}

/// Changes waiting for the next update.
#[derive(Debug, Default)]
struct Staged {
    values: Vec<Value>,
    entries: Vec<Entry>,
    removals: Vec<FactorId>,
}

impl Incremental {
    /// An empty solver.
    pub fn new(config: IncrementalConfig) -> Self {
        Self { config, starts: vec![0], ..Self::default() }
    }

    /// Stages a new variable with its first estimate. If the update fails, its key becomes free again.
    pub fn insert(&mut self, value: Value) -> Key {
        self.staged.values.push(value);
        Key((self.values.len() + self.staged.values.len() - 1) as u32)
    }

    /// Stages a factor over present and staged variables.
    ///
    /// # Errors
    /// When a variable is missing, of another kind or named twice.
    pub fn add(&mut self, factor: impl Factor + 'static) -> Result<FactorId, FactorError> {
        self.add_robust(factor, Kernel::None)
    }

    /// Stages a factor with a robust kernel. Its weight is computed again at each linearisation.
    ///
    /// # Errors
    /// As for [`Self::add`], and when the kernel's parameter is not positive.
    pub fn add_robust(
        &mut self,
        factor: impl Factor + 'static,
        kernel: Kernel,
    ) -> Result<FactorId, FactorError> {
        if !kernel.is_valid() {
            return Err(FactorError::NotFinite { what: texts::KERNEL_PARAMETER });
        }
        self.add_shared(&Entry { factor: Arc::new(factor), kernel, weight: 1.0 })
    }

    /// Stages a factor of another graph over the same keys. Both graphs share the factor.
    ///
    /// # Errors
    /// As for [`Self::add`].
    pub fn add_shared(&mut self, entry: &Entry) -> Result<FactorId, FactorError> {
        let factor = &entry.factor;
        let known = self.values.len();
        for (index, (&key, &needed)) in factor.keys().iter().zip(factor.kinds()).enumerate() {
            let staged = key.index().checked_sub(known).and_then(|place| self.staged.values.get(place));
            let value = self.values.get(key).or(staged).ok_or(FactorError::UnknownVariable { key })?;
            if self.forgotten.get(key.index()) == Some(&true) {
                return Err(FactorError::UnknownVariable { key });
            }
            if value.kind() != needed {
                return Err(FactorError::Kind { key, found: value.kind(), needed });
            }
            if factor.keys()[..index].contains(&key) {
                return Err(FactorError::Repeated { key });
            }
        }
        self.staged.entries.push(entry.clone());
        Ok(FactorId((self.graph.ids() + self.staged.entries.len() - 1) as u32))
    }

    /// Stages the removal of a factor.
    ///
    /// # Errors
    /// When there is no such factor.
    pub fn remove(&mut self, id: FactorId) -> Result<(), SolveError> {
        if self.graph.get(id).is_none() || self.staged.removals.contains(&id) {
            return Err(SolveError::UnknownFactor { factor: id });
        }
        self.staged.removals.push(id);
        Ok(())
    }

    /// Current estimate of a variable. A staged variable has its first estimate.
    ///
    /// # Errors
    /// When there is no such variable, or it was marginalised.
    pub fn estimate(&self, key: Key) -> Result<Value, SolveError> {
        let unknown = SolveError::UnknownVariable { key };
        if let Some(place) = key.index().checked_sub(self.values.len()) {
            return self.staged.values.get(place).copied().ok_or(unknown);
        }
        if self.forgotten[key.index()] {
            return Err(unknown);
        }
        let value = self.values.get(key).ok_or(unknown)?;
        Ok(value.retract(&self.delta[self.starts[key.index()]..self.starts[key.index() + 1]]))
    }

    /// Current estimates of all variables. Marginalised variables keep their last estimate.
    pub fn estimates(&self) -> Values {
        self.values.retract(&self.delta)
    }

    /// The factors after the last update.
    pub fn graph(&self) -> &FactorGraph {
        &self.graph
    }

    /// Memory of the tree and the linearised factors, bytes.
    pub fn memory(&self) -> usize {
        let linear: usize = self.linear.iter().map(Vec::len).sum();
        8 * (linear + self.tree.scalars() + self.delta.len())
    }
}
