//! Reads the messages of an MCAP file block by block.

use super::index::{Block, BlockKind, Index, RECORD_HEADER_LEN, stamp};
use crate::containers::merge::BlockSource;
use crate::containers::{MessageOrder, RawMessage};
use crate::error::ReadError;
use crate::texts;
use formats::cdr::{CdrReader, Encoding};
use formats::{FormatError, MAX_CHUNK_BYTES};
use mcap::records::op;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::sync::Arc;
use vocab::{Stamp, legible};

/// Reads the wanted messages block by block.
pub(super) struct BlockReader {
    file: File,
    size: u64,
    index: Arc<Index>,
    wanted: Vec<bool>,
    /// Numbers of the blocks to read, last first.
    queue: Vec<usize>,
}

impl BlockReader {
    pub fn open(index: Arc<Index>, wanted: Vec<bool>, order: MessageOrder) -> Result<Self, ReadError> {
        let io = |source| ReadError::Io { path: index.path.clone(), source };
        let file = File::open(&index.path).map_err(io)?;
        let size = file.metadata().map_err(io)?.len();
        let is_wanted = |channel: &u16| index.channels.get(channel).is_some_and(|topic| wanted[*topic]);
        let holds_wanted = |block: &Block| block.channels.is_empty() || block.channels.iter().any(is_wanted);
        let mut queue: Vec<usize> =
            (0..index.blocks.len()).filter(|number| holds_wanted(&index.blocks[*number])).collect();
        if order == MessageOrder::LogTime {
            queue.sort_by_key(|number| (index.blocks[*number].start, *number));
        }
        queue.reverse();
        Ok(Self { file, size, index, wanted, queue })
    }
}

impl BlockSource for BlockReader {
    fn next_start(&self) -> Option<Stamp> {
        self.queue.last().map(|number| self.index.blocks[*number].start)
    }

    fn load_next(&mut self, messages: &mut Vec<(u64, RawMessage)>) -> Result<(), ReadError> {
        let Some(number) = self.queue.pop() else { return Ok(()) };
        let block = &self.index.blocks[number];
        let damaged =
            |problem| ReadError::Damaged { path: self.index.path.clone(), at: block.offset, problem };
        let (records, warning) = load_block(&mut self.file, self.size, block).map_err(damaged)?;
        let records = Arc::new(records);
        let mut walk = ChunkRecords::new(&records);
        for (opcode, range) in walk.by_ref() {
            if opcode != op::MESSAGE {
                continue;
            }
            let Ok(head) = MessageHeader::read(&records[range.clone()]) else { continue };
            let topic = self.index.channels.get(&head.channel).filter(|topic| self.wanted[**topic]);
            if let Some(topic) = topic {
                let place = ((number as u64) << 32) | messages.len() as u64;
                let body = range.start + MessageHeader::LENGTH..range.end;
                messages.push((place, RawMessage::new(*topic, head.at, records.clone(), body)));
            }
        }
        let cut = walk.cut.then(|| texts::BLOCK_ENDS_EARLY.to_owned());
        warning.or(cut).map_or(Ok(()), |problem| Err(damaged(problem)))
    }
}

/// The header of a message record.
pub(super) struct MessageHeader {
    pub channel: u16,
    pub at: Stamp,
}

impl MessageHeader {
    const LENGTH: usize = 22;

    pub fn read(record: &[u8]) -> Result<Self, FormatError> {
        let mut reader = CdrReader::new(Encoding::Ros1, record, "MCAP message")?;
        let (channel, _sequence) = (reader.u16()?, reader.u32()?);
        let at = stamp(reader.u64()?);
        reader.u64()?;
        Ok(Self { channel, at })
    }
}

/// The records in the content of a chunk: opcode and range of each.
pub(super) struct ChunkRecords<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Whether the last record was incomplete.
    cut: bool,
}

impl<'a> ChunkRecords<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, cut: false }
    }

    /// Whether the last record was incomplete.
    pub fn is_cut(&self) -> bool {
        self.cut
    }
}

impl Iterator for ChunkRecords<'_> {
    type Item = (u8, std::ops::Range<usize>);

    fn next(&mut self) -> Option<Self::Item> {
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return None;
        }
        let head = rest.first_chunk::<{ RECORD_HEADER_LEN as usize }>();
        let sized = head.map(|[opcode, length @ ..]| (*opcode, u64::from_le_bytes(*length)));
        let start = self.at + RECORD_HEADER_LEN as usize;
        match sized {
            Some((opcode, length)) if length <= (self.bytes.len() - start) as u64 => {
                self.at = start + length as usize;
                Some((opcode, start..self.at))
            }
            _ => {
                self.at = self.bytes.len();
                self.cut = true;
                None
            }
        }
    }
}

/// The decompressed records of a block, and a warning if only a part could be read.
pub(super) fn load_block(
    file: &mut File,
    size: u64,
    block: &Block,
) -> Result<(Vec<u8>, Option<String>), String> {
    let bytes = read_range(file, size, block.offset, block.length)?;
    match block.kind {
        BlockKind::Loose => Ok((bytes, None)),
        BlockKind::Chunk => unpack_chunk(&bytes),
    }
}

fn unpack_chunk(record: &[u8]) -> Result<(Vec<u8>, Option<String>), String> {
    let unreadable = |error: FormatError| error.to_string();
    let mut reader = CdrReader::new(Encoding::Ros1, record, "MCAP chunk").map_err(unreadable)?;
    let mut head = || -> Result<_, FormatError> {
        let (_start, _end, unpacked, checksum) = (reader.u64()?, reader.u64()?, reader.u64()?, reader.u32()?);
        Ok((unpacked, checksum, reader.string()?, reader.u64()?))
    };
    let (unpacked, checksum, compression, packed) = head().map_err(unreadable)?;
    if unpacked > MAX_CHUNK_BYTES {
        return Err(texts::chunk_too_large(unpacked));
    }
    let data = &record[record.len() - reader.remaining()..];
    let data = &data[..data.len().min(usize::try_from(packed).unwrap_or(usize::MAX))];
    let mut out = Vec::with_capacity(unpacked.min(16 << 20).min(data.len() as u64 * 64) as usize);
    let result = match compression.as_str() {
        "" => data.take(unpacked).read_to_end(&mut out),
        "zstd" => zstd::stream::read::Decoder::with_buffer(data)
            .and_then(|decoder| decoder.take(unpacked).read_to_end(&mut out)),
        "lz4" => lz4_flex::frame::FrameDecoder::new(data).take(unpacked).read_to_end(&mut out),
        other => {
            return Err(texts::unknown_compression(&legible(other, 40)));
        }
    };
    let warning = match result {
        Err(error) => Some(texts::chunk_damaged(&error)),
        Ok(_) if (out.len() as u64) < unpacked => Some(texts::chunk_short(out.len(), unpacked)),
        // A chunk with a wrong checksum is dropped, because wrong data is worse than missing data. Zero means no checksum.
        Ok(_) if checksum != 0 && checksum != crc32fast::hash(&out) => {
            return Err(texts::WRONG_CHECKSUM.to_owned());
        }
        Ok(_) => None,
    };
    Ok((out, warning))
}

pub(super) fn read_range(file: &mut File, size: u64, offset: u64, length: u64) -> Result<Vec<u8>, String> {
    if length > MAX_CHUNK_BYTES || offset.checked_add(length).is_none_or(|end| end > size) {
        return Err(texts::length_too_large(length));
    }
    let mut bytes = vec![0; length as usize];
    let read = file.seek(SeekFrom::Start(offset)).and_then(|_| file.read_exact(&mut bytes));
    read.map_err(|error| texts::read_failed(&error))?;
    Ok(bytes)
}
