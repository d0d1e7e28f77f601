//! Why a graph cannot be built or solved. Every error names the variable or factor it is about.

use crate::names::{FactorId, Key, Kind};

/// A factor that cannot be made or evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FactorError {
    /// The information matrix is not the inverse of a covariance.
    #[error("the information matrix {problem}")]
    Information {
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A measurement, noise or parameter is not a finite number, or is out of range.
    #[error("{what} is not a usable number")]
    NotFinite {
        /// Which one.
        what: &'static str,
    },
    /// The variable has another kind than the factor needs.
    #[error("variable {key} is a {found:?}, but the factor needs a {needed:?}")]
    Kind {
        /// The variable.
        key: Key,
        /// What it is.
        found: Kind,
        /// What it should be.
        needed: Kind,
    },
    /// There is no such variable.
    #[error("there is no variable {key}")]
    UnknownVariable {
        /// The variable.
        key: Key,
    },
    /// The factor names one variable twice.
    #[error("the factor names variable {key} twice")]
    Repeated {
        /// The variable.
        key: Key,
    },
    /// The measurement constrains nothing at this estimate, such as a bearing to a point at distance zero.
    #[error("the factor on variable {key} is degenerate: {reason}")]
    Degenerate {
        /// A variable of the factor.
        key: Key,
        /// Why.
        reason: &'static str,
    },
}

/// A graph that cannot be solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// The factors leave a direction of the variable undetermined (given the variables eliminated later).
    #[error("the factors do not determine variable {key}; a prior or a connection to the rest is missing")]
    Undetermined {
        /// The variable.
        key: Key,
    },
    /// A residual or Jacobian is not a finite number at the present estimate.
    #[error("factor {factor} on variable {key} is not finite at the estimate")]
    NotFinite {
        /// The factor.
        factor: FactorId,
        /// Its first variable.
        key: Key,
    },
    /// A factor could not be evaluated.
    #[error("factor {factor} could not be evaluated")]
    Factor {
        /// The factor.
        factor: FactorId,
        /// Why.
        #[source]
        source: FactorError,
    },
    /// There is no such factor, or it was removed before.
    #[error("there is no factor {factor}")]
    UnknownFactor {
        /// The factor.
        factor: FactorId,
    },
    /// There is no such variable, or it was marginalised.
    #[error("there is no variable {key}")]
    UnknownVariable {
        /// The variable.
        key: Key,
    },
    /// Chordal initialisation needs relative poses that connect every pose to an anchored one.
    #[error("no chain of relative poses connects variable {key} to an anchored pose")]
    Disconnected {
        /// The variable.
        key: Key,
    },
}
