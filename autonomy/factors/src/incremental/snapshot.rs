//! The graph and the estimates of one moment, to be solved once more elsewhere while the solver goes on.

use super::{Incremental, IncrementalConfig};
use crate::error::SolveError;
use crate::graph::FactorGraph;
use crate::value::{Value, Values};

/// Factors and estimates of an [`Incremental`], without its tree.
#[derive(Clone, Debug)]
pub struct IncrementalSnapshot {
    config: IncrementalConfig,
    graph: FactorGraph,
    values: Values,
    forgotten: Vec<bool>,
}

impl Incremental {
    /// The factors and the present estimates. Staged changes are left out. Linear in the graph: estimates are copied, factors are shared.
    pub fn snapshot(&self) -> IncrementalSnapshot {
        let mut values = Values::default();
        for (key, value) in self.values.iter() {
            let delta = &self.delta[self.starts[key.index()]..self.starts[key.index() + 1]];
            // As in an update, a value that has not moved stays the same to the last bit.
            let is_moved = delta.iter().any(|component| component.abs() > 0.0);
            values.insert(if is_moved { value.retract(delta) } else { *value });
        }
        let (graph, forgotten) = (self.graph.clone(), self.forgotten.clone());
        IncrementalSnapshot { config: self.config, graph, values, forgotten }
    }
}

impl IncrementalSnapshot {
    /// Linearises every factor at the estimates, solves afresh, and returns the new estimates: to the last bit what
    /// [`Incremental::relinearise_all`] would have led to.
    ///
    /// # Errors
    /// When a variable is not determined or a factor cannot be evaluated.
    pub fn relinearise(self) -> Result<Values, SolveError> {
        let Self { config, graph, values, forgotten } = self;
        let mut solver = Incremental::new(config);
        for value in values.iter().map(|(_, value)| value) {
            let dimension = Value::kind(value).dimension();
            solver.dimensions.push(dimension as u8);
            solver.delta.resize(solver.delta.len() + dimension, 0.0);
            solver.starts.push(solver.delta.len());
        }
        solver.factors_of = vec![Vec::new(); values.len()];
        for (id, entry) in graph.iter() {
            for key in entry.factor.keys() {
                solver.factors_of[key.index()].push(id);
            }
        }
        solver.linear = vec![Vec::new(); graph.ids()];
        solver.tree.resize(values.len());
        (solver.graph, solver.values, solver.forgotten) = (graph, values, forgotten);
        solver.relinearise_all()?;
        Ok(solver.estimates())
    }
}
