//! Reads MCAP files, finished or truncated: their blocks, and the messages in them.
//!
//! A finished file has the positions of its chunks in its summary. Any other file is scanned once from its start, up to the first record that
//! cannot be understood. In both cases messages are then read block by block. Source: mcap.dev/spec.

mod blocks;
mod index;
mod scanner;
mod summary;

use super::merge::MergedMessages;
use super::{Container, MessageOrder, Messages, Topic};
use crate::error::OpenError;
use crate::texts;
use blocks::{BlockReader, read_range};
use index::{Block, BlockKind, Index, IndexedFile, RECORD_HEADER_LEN, read_metadata, stamp};
use scanner::FileScanner;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use summary::McapSummary;
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

    fn messages(&self, wanted: &[bool], order: MessageOrder) -> Messages {
        match BlockReader::open(self.0.index.clone(), wanted.to_vec(), order) {
            Ok(reader) => Box::new(MergedMessages::new(reader, order)),
            Err(error) => Box::new(std::iter::once(Err(error))),
        }
    }
}

/// Reads the index from the file's summary; `None` if there is no usable summary.
fn from_summary(path: &Path, file: &mut File, size: u64) -> Option<IndexedFile> {
    let McapSummary { mut channel_table, statistics, chunks, metadata: entries } =
        McapSummary::read(file, size)?;
    if statistics.messages > 0 && (chunks.is_empty() || channel_table.channels.is_empty()) {
        return None;
    }
    for (channel, topic) in &channel_table.channels {
        let topic = &mut channel_table.topics[*topic];
        let count = statistics.channels.get(channel).copied().unwrap_or(0);
        topic.count = topic.count.saturating_add(count);
    }
    let mut blocks = Vec::with_capacity(chunks.len());
    for chunk in chunks {
        let end = chunk.offset.checked_add(chunk.length)?;
        let length = chunk.length.checked_sub(RECORD_HEADER_LEN)?;
        if end > size {
            return None;
        }
        blocks.push(Block {
            offset: chunk.offset + RECORD_HEADER_LEN,
            length,
            kind: BlockKind::Chunk,
            start: stamp(chunk.start),
            channels: chunk.channels,
        });
    }
    blocks.sort_by_key(|block| block.offset);
    let mut metadata = BTreeMap::new();
    for (offset, length) in entries {
        let body = offset.checked_add(RECORD_HEADER_LEN).zip(length.checked_sub(RECORD_HEADER_LEN));
        if let Some(bytes) = body.and_then(|(offset, length)| read_range(file, size, offset, length).ok()) {
            let _ = read_metadata(&bytes, &mut metadata);
        }
    }
    let (first, last) = statistics.span;
    let span = (statistics.messages > 0).then(|| (stamp(first), stamp(last)));
    let index = Index {
        path: path.to_owned(),
        topics: channel_table.topics,
        channels: channel_table.channels,
        blocks,
    };
    Some(IndexedFile { index: Arc::new(index), span, warnings: Vec::new(), metadata })
}
