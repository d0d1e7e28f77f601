//! Why a graph cannot be built or solved. Every error names the variable or factor it is about; the texts stand in `texts.rs`.

use crate::names::{FactorId, Key, VariableKind};
use crate::texts;

/// A factor that cannot be made or evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FactorError {
    /// The information matrix is not the inverse of a covariance.
    #[error("{}", texts::information(problem))]
    Information {
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A measurement, noise or parameter is not a finite number, or is out of range.
    #[error("{}", texts::not_usable(what))]
    NotFinite {
        /// Which one.
        what: &'static str,
    },
    /// The variable has another kind than the factor needs.
    #[error("{}", texts::wrong_kind(*key, *found, *needed))]
    Kind {
        /// The variable.
        key: Key,
        /// What it is.
        found: VariableKind,
        /// What it should be.
        needed: VariableKind,
    },
    /// There is no such variable.
    #[error("{}", texts::unknown_variable(*key))]
    UnknownVariable {
        /// The variable.
        key: Key,
    },
    /// The factor names one variable twice.
    #[error("{}", texts::repeated(*key))]
    Repeated {
        /// The variable.
        key: Key,
    },
    /// The measurement constrains nothing at this estimate, such as a bearing to a point at distance zero.
    #[error("{}", texts::degenerate(*key, reason))]
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
    #[error("{}", texts::undetermined(*key))]
    Undetermined {
        /// The variable.
        key: Key,
    },
    /// A residual or Jacobian is not a finite number at the present estimate.
    #[error("{}", texts::not_finite(*factor, *key))]
    NotFinite {
        /// The factor.
        factor: FactorId,
        /// Its first variable.
        key: Key,
    },
    /// A factor could not be evaluated.
    #[error("{}", texts::not_evaluated(*factor))]
    Factor {
        /// The factor.
        factor: FactorId,
        /// Why.
        #[source]
        source: FactorError,
    },
    /// There is no such factor, or it was removed before.
    #[error("{}", texts::unknown_factor(*factor))]
    UnknownFactor {
        /// The factor.
        factor: FactorId,
    },
    /// There is no such variable, or it was marginalised.
    #[error("{}", texts::unknown_variable(*key))]
    UnknownVariable {
        /// The variable.
        key: Key,
    },
    /// Chordal initialisation needs relative poses that connect every pose to an anchored one.
    #[error("{}", texts::disconnected(*key))]
    Disconnected {
        /// The variable.
        key: Key,
    },
}
