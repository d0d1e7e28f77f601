//! Reads the summary at the end of a finished MCAP file. No length in it is believed before the bytes are there.

use super::blocks::{ChunkRecords, read_range};
use super::index::{ChannelTable, RECORD_HEADER_LEN};
use formats::FormatError;
use formats::cdr::{CdrReader, Encoding};
use mcap::records::op;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::ops::Range;

/// Bytes of the footer's content: start of the summary, start of its offsets, checksum.
const FOOTER_LEN: u64 = 20;

/// What the summary says.
pub(super) struct McapSummary {
    pub channel_table: ChannelTable,
    pub statistics: Statistics,
    pub chunks: Vec<ChunkIndex>,
    /// Offset and length of each metadata record.
    pub metadata: Vec<(u64, u64)>,
}

/// Counts of the whole file.
pub(super) struct Statistics {
    pub messages: u64,
    /// Log times of the first and last message.
    pub span: (u64, u64),
    /// Messages of each channel.
    pub channels: BTreeMap<u16, u64>,
}

/// Position of a chunk's record, with its header.
pub(super) struct ChunkIndex {
    pub offset: u64,
    pub length: u64,
    /// Log time of its first message.
    pub start: u64,
    /// Channels with messages in it.
    pub channels: BTreeSet<u16>,
}

impl McapSummary {
    /// Reads the summary of a file of `size` bytes; `None` if there is none that can be used.
    pub fn read(file: &mut File, size: u64) -> Option<Self> {
        let magic = mcap::MAGIC.len() as u64;
        let footer_at = size.checked_sub(magic + FOOTER_LEN + RECORD_HEADER_LEN)?;
        let end = read_range(file, size, footer_at, size - footer_at).ok()?;
        let (footer, end) = end.split_at((RECORD_HEADER_LEN + FOOTER_LEN) as usize);
        let (head, content) = footer.split_at(RECORD_HEADER_LEN as usize);
        let [opcode, length @ ..] = head.first_chunk::<{ RECORD_HEADER_LEN as usize }>()?;
        if end != mcap::MAGIC || *opcode != op::FOOTER || u64::from_le_bytes(*length) != FOOTER_LEN {
            return None;
        }
        let start = u64::from_le_bytes(*content.first_chunk()?);
        // Zero says that there is no summary.
        let length = footer_at.checked_sub(start).filter(|_| start > 0)?;
        let bytes = read_range(file, size, start, length).ok()?;
        let mut records = ChunkRecords::new(&bytes);
        let ranges: Vec<(u8, Range<usize>)> = records.by_ref().collect();
        if records.is_cut() {
            return None;
        }
        Self::of_records(ranges.iter().map(|(opcode, range)| (*opcode, &bytes[range.clone()]))).ok()?
    }

    fn of_records<'a>(records: impl Iterator<Item = (u8, &'a [u8])>) -> Result<Option<Self>, FormatError> {
        let mut channel_table = ChannelTable::default();
        let (mut statistics, mut chunks, mut metadata) = (None, Vec::new(), Vec::new());
        // In the order of their ids, whatever that in the file is.
        let mut channels = BTreeMap::new();
        for (opcode, record) in records {
            let mut reader = CdrReader::new(Encoding::Ros1, record, "MCAP summary")?;
            match opcode {
                op::SCHEMA => channel_table.add_schema(record)?,
                op::CHANNEL => {
                    channels.insert(reader.u16()?, record);
                }
                op::CHUNK_INDEX => chunks.push(ChunkIndex::read(&mut reader)?),
                op::STATISTICS => statistics = Some(Statistics::read(&mut reader)?),
                op::METADATA_INDEX => metadata.push((reader.u64()?, reader.u64()?)),
                _ => {}
            }
        }
        for record in channels.into_values() {
            channel_table.add_channel(record)?;
        }
        Ok(statistics.map(|statistics| Self { channel_table, statistics, chunks, metadata }))
    }
}

impl Statistics {
    fn read(reader: &mut CdrReader<'_>) -> Result<Self, FormatError> {
        let messages = reader.u64()?;
        let _schemas = reader.u16()?;
        for _channels_attachments_metadata_chunks in 0..4 {
            reader.u32()?;
        }
        let span = (reader.u64()?, reader.u64()?);
        Ok(Self { messages, span, channels: numbers_by_channel(reader)? })
    }
}

impl ChunkIndex {
    fn read(reader: &mut CdrReader<'_>) -> Result<Self, FormatError> {
        let (start, _end) = (reader.u64()?, reader.u64()?);
        let (offset, length) = (reader.u64()?, reader.u64()?);
        let channels = numbers_by_channel(reader)?.into_keys().collect();
        Ok(Self { offset, length, start, channels })
    }
}

/// A map from channels to numbers, after its length in bytes.
fn numbers_by_channel(reader: &mut CdrReader<'_>) -> Result<BTreeMap<u16, u64>, FormatError> {
    let bytes = reader.byte_sequence()?;
    let mut entries = CdrReader::new(Encoding::Ros1, bytes, "MCAP summary")?;
    let mut numbers = BTreeMap::new();
    while entries.remaining() > 0 {
        numbers.insert(entries.u16()?, entries.u64()?);
    }
    Ok(numbers)
}
