//! Instants of the calendar clock.

use serde::{Deserialize, Serialize};

/// An instant of the calendar clock: nanoseconds since 1970-01-01 UTC. Time-outs never use it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Utc(pub i64);
