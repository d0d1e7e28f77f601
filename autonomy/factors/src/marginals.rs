//! Marginal covariances of a whole graph.

use crate::batch::LinearisedProblem;
use crate::error::SolveError;
use crate::graph::FactorGraph;
use crate::names::Key;
use crate::value::Values;
use nalgebra::DMatrix;

/// Marginal covariances of a graph at some values.
#[derive(Debug)]
pub struct Marginals<'a> {
    problem: LinearisedProblem<'a>,
    variables: usize,
}

impl<'a> Marginals<'a> {
    /// Linearises and factorises the graph.
    ///
    /// # Errors
    /// When a variable is not determined, or a factor cannot be evaluated.
    pub fn new(graph: &'a FactorGraph, values: &Values) -> Result<Self, SolveError> {
        let mut problem = LinearisedProblem::<f64>::new(graph, values);
        problem.linearise(values)?;
        problem.factorise(&[])?;
        Ok(Self { problem, variables: values.len() })
    }

    /// Joint covariance of some variables, in the order of `keys`. Each block refers to the variable's own error.
    ///
    /// Cost: one forward substitution along the path to the root for each scalar.
    ///
    /// # Errors
    /// When there is no such variable.
    pub fn covariance(&self, keys: &[Key]) -> Result<DMatrix<f64>, SolveError> {
        match keys.iter().find(|key| key.index() >= self.variables) {
            Some(&key) => Err(SolveError::UnknownVariable { key }),
            None => Ok(self.problem.covariance(keys)),
        }
    }
}
