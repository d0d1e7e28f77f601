//! The journal: inputs of the stack are written before the stack processes them.

use messages::Input;
use vocab::Stamp;

/// Why an input could not be written.
#[derive(Debug, thiserror::Error)]
#[error("the recording could not be written")]
pub struct JournalError(#[source] pub Box<dyn std::error::Error + Send + Sync>);

/// Records every input with its time, in order, so that the run can be replayed bit for bit.
pub trait Journal: Send {
    /// Writes one input. An implementation must lose at most 1 s of robot time in a crash.
    fn append(&mut self, at: Stamp, input: &Input) -> Result<(), JournalError>;

    /// Writes the end of the file and closes it.
    fn finish(self: Box<Self>) -> Result<(), JournalError>;
}
