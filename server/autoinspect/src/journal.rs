//! The recorder as the runtime's journal.

use messages::Input;
use ports::{Journal, JournalError};
use recorder::{RecordingWriter, WriteError};
use vocab::Stamp;

/// Writes every input into an MCAP file.
pub struct McapJournal(pub RecordingWriter);

impl Journal for McapJournal {
    fn append(&mut self, at: Stamp, input: &Input) -> Result<(), JournalError> {
        self.0.input(at, input).map_err(failed)
    }

    fn finish(self: Box<Self>) -> Result<(), JournalError> {
        self.0.finish().map_err(failed)
    }
}

fn failed(error: WriteError) -> JournalError {
    JournalError(Box::new(error))
}
