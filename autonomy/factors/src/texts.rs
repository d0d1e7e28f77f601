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

// What is wrong with an information matrix: clauses for [`information`].

pub(crate) const NOT_FINITE_ENTRIES: &str = "has entries that are not finite";
pub(crate) const NOT_SYMMETRIC: &str = "is not symmetric";
pub(crate) const NEGATIVE_EIGENVALUE: &str = "has a negative eigenvalue";
pub(crate) const OTHER_DIMENSION: &str = "does not fit the variables";

// Which number is not usable: subjects of [`not_usable`].

pub(crate) const STANDARD_DEVIATION: &str = "a standard deviation";
pub(crate) const MEASURED_POSE: &str = "the measured pose";
pub(crate) const NOISE_DENSITY: &str = "a noise density";
pub(crate) const TIME_OF_READING: &str = "the time of a reading";
pub(crate) const READING: &str = "a reading";
pub(crate) const BIAS: &str = "the bias";
pub(crate) const BEARING: &str = "the bearing";
pub(crate) const RANGE: &str = "the range";
pub(crate) const KERNEL_PARAMETER: &str = "the kernel's parameter";
pub(crate) const SEEN_POINT: &str = "the seen point";
pub(crate) const MEASURED_VELOCITY: &str = "the measured velocity";
pub(crate) const KNOWN_POSE: &str = "the known pose";
pub(crate) const KNOWN_VECTOR: &str = "the known vector";

// Why a factor constrains nothing: reasons for [`degenerate`].

pub(crate) const TOO_FEW_READINGS: &str = "too few inertial readings";
pub(crate) const POINT_AT_POSE: &str = "the point is at the pose";
pub(crate) const NO_DIRECTION: &str = "a vector without direction";
