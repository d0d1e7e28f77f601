//! Clauses for people, by key: why a graph cannot be built or solved.

use crate::names::{FactorId, Key, VariableKind};

pub(crate) fn information(problem: &str) -> String {
    format!("the information matrix {problem}")
}
pub(crate) fn not_usable(what: &str) -> String {
    format!("{what} is not a usable number")
}
pub(crate) fn wrong_kind(key: Key, found: VariableKind, needed: VariableKind) -> String {
    format!("variable {key} is a {found:?}, but the factor needs a {needed:?}")
}
pub(crate) fn unknown_variable(key: Key) -> String {
    format!("there is no variable {key}")
}
pub(crate) fn repeated(key: Key) -> String {
    format!("the factor names variable {key} twice")
}
pub(crate) fn degenerate(key: Key, reason: &str) -> String {
    format!("the factor on variable {key} is degenerate: {reason}")
}
pub(crate) fn undetermined(key: Key) -> String {
    format!("the factors do not determine variable {key}; a prior or a connection to the rest is missing")
}
pub(crate) fn not_finite(factor: FactorId, key: Key) -> String {
    format!("factor {factor} on variable {key} is not finite at the estimate")
}
pub(crate) fn not_evaluated(factor: FactorId) -> String {
    format!("factor {factor} could not be evaluated")
}
pub(crate) fn unknown_factor(factor: FactorId) -> String {
    format!("there is no factor {factor}")
}
pub(crate) fn disconnected(key: Key) -> String {
    format!("no chain of relative poses connects variable {key} to an anchored pose")
}
