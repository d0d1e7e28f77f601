//! Inputs and effects of the stack: the schema of the log.
//!
//! Everything that may influence the stack is an [`Input`]; everything it does is an [`StackEffect`]. Both are plain
//! data, so a log of inputs replays the stack bit for bit. Metres, radians, seconds and SI throughout.

mod goals;
mod graph;
mod inputs;
mod jobs;
mod ledger;
mod loops;
mod outputs;
mod prior_map;
mod profile;
mod sensors;
pub mod texts;
mod timing;

pub use goals::*;
pub use graph::GraphDelta;
pub use inputs::*;
pub use jobs::*;
pub use ledger::*;
pub use loops::*;
pub use outputs::*;
pub use prior_map::*;
pub use profile::*;
pub use sensors::*;
pub use timing::*;
pub use vocab::Role;
