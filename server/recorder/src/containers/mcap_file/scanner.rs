//! Scans an MCAP file without a usable summary from its start, up to the first record that cannot be understood.

use super::blocks::{ChunkRecords, MessageHeader, load_block, read_range};
use super::index::{Block, BlockKind, ChannelTable, Index, IndexedFile, RECORD_HEADER_LEN, read_metadata};
use crate::error::OpenError;
use crate::texts;
use formats::FormatError;
use mcap::records::op;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::Arc;
use vocab::Stamp;

/// Parameters of a [`FileScanner`].
#[derive(Clone, Copy, Debug)]
struct ScannerConfig {
    /// Messages outside of chunks are read in blocks of this size and up to one message more, bytes. Chosen: few reads, and little memory for each
    /// of the blocks that are read at a time.
    loose_block_bytes: u64,
}

const CONFIG: ScannerConfig = ScannerConfig { loose_block_bytes: 4 << 20 };

/// Scans a file without a usable summary from its start.
pub(super) struct FileScanner<'a> {
    path: &'a Path,
    file: File,
    size: u64,
    channel_table: ChannelTable,
    blocks: Vec<Block>,
    span: Option<(Stamp, Stamp)>,
    warnings: Vec<String>,
    metadata: BTreeMap<String, String>,
}

impl<'a> FileScanner<'a> {
    pub fn new(path: &'a Path, file: File, size: u64) -> Self {
        Self {
            path,
            file,
            size,
            channel_table: ChannelTable::default(),
            blocks: Vec::new(),
            span: None,
            warnings: Vec::new(),
            metadata: BTreeMap::new(),
        }
    }

    pub fn run(mut self) -> Result<IndexedFile, OpenError> {
        self.walk().map_err(|source| OpenError::Io { path: self.path.to_owned(), source })?;
        let index = Index {
            path: self.path.to_owned(),
            topics: self.channel_table.topics,
            channels: self.channel_table.channels,
            blocks: self.blocks,
        };
        let (span, warnings, metadata) = (self.span, self.warnings, self.metadata);
        Ok(IndexedFile { index: Arc::new(index), span, warnings, metadata })
    }

    fn walk(&mut self) -> std::io::Result<()> {
        let mut at = mcap::MAGIC.len() as u64;
        loop {
            let mut head = [0; RECORD_HEADER_LEN as usize];
            if self.size - at < RECORD_HEADER_LEN {
                self.warn_truncated(at);
                return Ok(());
            }
            self.file.seek(SeekFrom::Start(at))?;
            self.file.read_exact(&mut head)?;
            let [opcode, length @ ..] = head;
            let length = u64::from_le_bytes(length);
            let available = self.size - at - RECORD_HEADER_LEN;
            if opcode == 0 || length > available && opcode != op::CHUNK {
                self.warn_truncated(at);
                return Ok(());
            }
            let content = at + RECORD_HEADER_LEN;
            match opcode {
                op::DATA_END | op::FOOTER => return self.check_end(),
                op::CHUNK => self.chunk(content, length.min(available)),
                op::MESSAGE => self.loose_message(at, length),
                op::SCHEMA | op::CHANNEL | op::METADATA => self.declaration(opcode, content, length),
                _ => {}
            }
            if length > available {
                self.warn_truncated(at);
                return Ok(());
            }
            at = content + length;
        }
    }

    /// Warns if the last bytes of the file are missing. A missing index needs no warning.
    fn check_end(&mut self) -> std::io::Result<()> {
        let mut end = [0; 8];
        self.file.seek(SeekFrom::End(-8))?;
        self.file.read_exact(&mut end)?;
        if end != mcap::MAGIC {
            self.warnings.push(texts::INDEX_DAMAGED.to_owned());
        }
        Ok(())
    }

    fn warn_truncated(&mut self, at: u64) {
        self.warnings.push(texts::file_cut_off(at, self.size));
    }

    fn declaration(&mut self, opcode: u8, offset: u64, length: u64) {
        let Ok(record) = read_range(&mut self.file, self.size, offset, length) else { return };
        let result = match opcode {
            op::SCHEMA => self.channel_table.add_schema(&record),
            op::CHANNEL => self.channel_table.add_channel(&record),
            _ => read_metadata(&record, &mut self.metadata),
        };
        if let Err(error) = result {
            self.warnings.push(texts::unreadable_declaration(offset, &error));
        }
    }

    fn chunk(&mut self, offset: u64, length: u64) {
        let mut block =
            Block { offset, length, kind: BlockKind::Chunk, start: Stamp::EPOCH, channels: BTreeSet::new() };
        // An unreadable chunk is reported when its messages are read; here its readable part is counted.
        let Ok((records, _)) = load_block(&mut self.file, self.size, &block) else { return };
        let mut earliest = None;
        for (opcode, range) in ChunkRecords::new(&records) {
            let record = &records[range];
            let _ = match opcode {
                op::SCHEMA => self.channel_table.add_schema(record),
                op::CHANNEL => self.channel_table.add_channel(record),
                op::MESSAGE => self.count(record, &mut block, &mut earliest),
                _ => Ok(()),
            };
        }
        if let Some(earliest) = earliest {
            block.start = earliest;
            self.blocks.push(block);
        }
    }

    fn loose_message(&mut self, at: u64, length: u64) {
        let Ok(head) = read_range(&mut self.file, self.size, at + RECORD_HEADER_LEN, length.min(22)) else {
            return;
        };
        let grows = |block: &Block| {
            block.kind == BlockKind::Loose
                && block.offset + block.length == at
                && block.length < CONFIG.loose_block_bytes
        };
        let mut block = match self.blocks.pop_if(|block| grows(block)) {
            Some(block) => block,
            None => Block {
                offset: at,
                length: 0,
                kind: BlockKind::Loose,
                start: Stamp::from_nanos(i64::MAX),
                channels: BTreeSet::new(),
            },
        };
        let mut earliest = Some(block.start);
        let counted = self.count(&head, &mut block, &mut earliest);
        block.length += RECORD_HEADER_LEN + length;
        block.start = earliest.unwrap_or_default();
        if counted.is_ok() || block.length > RECORD_HEADER_LEN + length {
            self.blocks.push(block);
        }
    }

    fn count(
        &mut self,
        record: &[u8],
        block: &mut Block,
        earliest: &mut Option<Stamp>,
    ) -> Result<(), FormatError> {
        let head = MessageHeader::read(record)?;
        if let Some(topic) = self.channel_table.channels.get(&head.channel) {
            self.channel_table.topics[*topic].count += 1;
            block.channels.insert(head.channel);
            *earliest = Some(earliest.map_or(head.at, |stamp| stamp.min(head.at)));
            let (first, last) = self.span.unwrap_or((head.at, head.at));
            self.span = Some((first.min(head.at), last.max(head.at)));
        }
        Ok(())
    }
}
