//! What sensors say to the stack and what the stack answers: the schema of the log.
//!
//! Everything that may influence the stack is an [`Input`]; everything it does is an [`Effect`]. Both are plain
//! data, so a log of inputs replays the stack bit for bit. Metres, radians, seconds and SI throughout.

mod inputs;
mod known;
mod loops;
mod outputs;
mod sensors;

pub use inputs::*;
pub use known::*;
pub use loops::*;
pub use outputs::*;
pub use sensors::*;
