//! Reads MCAP files, finished or truncated: their blocks, and the messages in them.
//!
//! A finished file has the positions of its chunks in its summary. Any other file is scanned once from its start, up to the first record that
//! cannot be understood. In both cases messages are then read block by block. Source: mcap.dev/spec.

mod blocks;
mod index;
mod scanner;

use super::merge::MergedMessages;
use super::{Container, Messages, Order, Topic};
use crate::error::OpenError;
use crate::texts;
use blocks::{BlockReader, read_range};
use formats::CHUNK_BYTES_MAX;
use index::{Block, BlockKind, ChannelTable, Index, IndexedFile, RECORD_HEADER_LEN, read_metadata, stamp};
use mcap::sans_io::{SummaryReadEvent, SummaryReader, SummaryReaderOptions};
use scanner::FileScanner;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;
use std::sync::Arc;
use vocab::Stamp;

/// An MCAP file with the index of its blocks.
pub(crate) struct McapFile(IndexedFile);

impl McapFile {
    /// Opens a file and finds its blocks.
    ///
    /// # Errors
    /// When it cannot be read or does not begin with MCAP's magic bytes.
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        let io = |source| OpenError::Io { path: path.to_owned(), source };
        let mut file = File::open(path).map_err(io)?;
        let size = file.metadata().map_err(io)?.len();
        let mut magic = [0; 8];
        if size < 8 || file.read_exact(&mut magic).is_err() || magic != mcap::MAGIC {
            let problem = texts::NOT_MCAP.to_owned();
            return Err(OpenError::NotARecording { path: path.to_owned(), problem });
        }
        if let Some(indexed) = from_summary(path, &mut file, size) {
            return Ok(Self(indexed));
        }
        FileScanner::new(path, file, size).run().map(Self)
    }

    /// Whether a file that starts with these bytes is an MCAP file.
    pub fn is_mcap(start: &[u8]) -> bool {
        start.starts_with(mcap::MAGIC)
    }
}

impl Container for McapFile {
    fn topics(&self) -> &[Topic] {
        &self.0.index.topics
    }

    fn span(&self) -> Option<(Stamp, Stamp)> {
        self.0.span
    }

    fn warnings(&self) -> &[String] {
        &self.0.warnings
    }

    fn metadata(&self, key: &str) -> Option<&str> {
        self.0.metadata.get(key).map(String::as_str)
    }

    fn messages(&self, wanted: &[bool], order: Order) -> Messages {
        match BlockReader::open(self.0.index.clone(), wanted.to_vec(), order) {
            Ok(reader) => Box::new(MergedMessages::new(reader, order)),
            Err(error) => Box::new(std::iter::once(Err(error))),
        }
    }
}

/// Reads the index from the file's summary; `None` if there is no usable summary.
fn from_summary(path: &Path, file: &mut File, size: u64) -> Option<IndexedFile> {
    let summary = read_summary(file, size)?;
    let statistics = summary.stats.as_ref()?;
    if statistics.message_count > 0 && (summary.chunk_indexes.is_empty() || summary.channels.is_empty()) {
        return None;
    }
    let mut channel_table = ChannelTable::default();
    let ordered: BTreeMap<_, _> = summary.channels.iter().collect();
    for (id, channel) in ordered {
        let schema = channel.schema.as_ref();
        let topic = channel_table.add(
            *id,
            &channel.topic,
            &channel.message_encoding,
            schema.map_or("", |schema| &schema.name),
            schema.map_or("", |schema| &schema.encoding),
        );
        channel_table.topics[topic].count += statistics.channel_message_counts.get(id).copied().unwrap_or(0);
    }
    let mut blocks = Vec::with_capacity(summary.chunk_indexes.len());
    for chunk in &summary.chunk_indexes {
        let end = chunk.chunk_start_offset.checked_add(chunk.chunk_length)?;
        let length = chunk.chunk_length.checked_sub(RECORD_HEADER_LEN)?;
        if end > size {
            return None;
        }
        blocks.push(Block {
            offset: chunk.chunk_start_offset + RECORD_HEADER_LEN,
            length,
            kind: BlockKind::Chunk,
            start: stamp(chunk.message_start_time),
            channels: chunk.message_index_offsets.keys().copied().collect(),
        });
    }
    blocks.sort_by_key(|block| block.offset);
    let mut metadata = BTreeMap::new();
    for index in &summary.metadata_indexes {
        let body =
            index.offset.checked_add(RECORD_HEADER_LEN).zip(index.length.checked_sub(RECORD_HEADER_LEN));
        if let Some(bytes) = body.and_then(|(offset, length)| read_range(file, size, offset, length).ok()) {
            let _ = read_metadata(&bytes, &mut metadata);
        }
    }
    let span = (statistics.message_count > 0)
        .then(|| (stamp(statistics.message_start_time), stamp(statistics.message_end_time)));
    let index = Index {
        path: path.to_owned(),
        topics: channel_table.topics,
        channels: channel_table.channels,
        blocks,
    };
    Some(IndexedFile { index: Arc::new(index), span, warnings: Vec::new(), metadata })
}

fn read_summary(file: &mut File, size: u64) -> Option<mcap::Summary> {
    let options = SummaryReaderOptions::default()
        .with_file_size(size)
        .with_record_length_limit(usize::try_from(size.min(CHUNK_BYTES_MAX)).ok()?);
    let mut reader = SummaryReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event.ok()? {
            SummaryReadEvent::ReadRequest(length) => {
                let read = file.read(reader.insert(length)).ok()?;
                reader.notify_read(read);
            }
            SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(file.seek(to).ok()?),
        }
    }
    reader.finish()
}
