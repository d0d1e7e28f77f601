//! Where the inputs of the stack are written before it sees them.

use messages::Input;
use vocab::Stamp;

/// Why an input could not be written.
#[derive(Debug, thiserror::Error)]
#[error("the recording could not be written")]
pub struct JournalError(#[source] pub Box<dyn std::error::Error + Send + Sync>);

/// Takes down every input with its instant, in order: enough to repeat the run bit for bit.
pub trait Journal: Send {
    /// Writes one input. Whoever implements this sees to it that a crash loses at most a second of robot time.
    fn append(&mut self, at: Stamp, input: &Input) -> Result<(), JournalError>;

    /// Writes what belongs at the end and closes.
    fn finish(self: Box<Self>) -> Result<(), JournalError>;
}
