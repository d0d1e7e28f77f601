//! The recorder as the runtime's journal.

use messages::{Input, Mounting};
use ports::{Journal, JournalError, Segment, SegmentWriter};
use recorder::{RecordingMeta, RecordingWriter, WriteError, WriterConfig};
use std::path::Path;
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

/// Creates the MCAP files of a run.
pub struct McapSegments {
    /// What all files say of their origin.
    pub meta: RecordingMeta,
    /// The mounting of the sensors.
    pub mounting: Mounting,
}

impl SegmentWriter for McapSegments {
    fn create(&mut self, path: &Path, segment: &Segment) -> Result<Box<dyn Journal>, JournalError> {
        let meta = RecordingMeta { segment: Some(segment.clone()), ..self.meta.clone() };
        let config = WriterConfig { sync: true, ..WriterConfig::default() };
        let writer = RecordingWriter::create_with(path, &meta, &self.mounting, &config).map_err(failed)?;
        Ok(Box::new(McapJournal(writer)))
    }
}

fn failed(error: WriteError) -> JournalError {
    JournalError(Box::new(error))
}
