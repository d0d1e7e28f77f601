//! Clauses that people read as the reason of a failed job, by key. English.

/// A map was read for a part of the stack that reads none.
pub(crate) const NOBODY_WAITS_FOR_MAP: &str = "nobody waits for this map";
/// There was no time for a job, or its input is not wanted any more.
pub const NO_TIME_FOR_JOB: &str = "there was no time for it";
