//! The journal: inputs of the stack are written before the stack processes them.

use messages::Input;
use std::path::Path;
use vocab::Stamp;

/// Why an input could not be written.
#[derive(Debug, thiserror::Error)]
#[error("the recording could not be written")]
pub struct JournalError(#[source] pub Box<dyn std::error::Error + Send + Sync>);

/// Records every input with its time, in order, so that the run can be replayed bit for bit.
pub trait Journal: Send {
    /// Writes one input. An implementation must lose at most 1 s of robot time in a crash, or when the power fails.
    fn append(&mut self, at: Stamp, input: &Input) -> Result<(), JournalError>;

    /// Writes the end of the file and closes it.
    fn finish(self: Box<Self>) -> Result<(), JournalError>;
}

/// One file of the recording of a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Segment {
    /// Name of the run.
    pub run: String,
    /// Its number, counted from 0.
    pub number: u32,
    /// Whether it begins with the input after the last one of the segment before. Without a gap, the segments of a run can be replayed in a row
    /// from its boot.
    pub continues: bool,
}

/// Creates the files of a run's recording.
pub trait SegmentWriter: Send {
    /// Creates the file of a segment.
    ///
    /// # Errors
    /// When the disk fails.
    fn create(&mut self, path: &Path, segment: &Segment) -> Result<Box<dyn Journal>, JournalError>;
}
