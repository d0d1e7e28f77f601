//! ROS 1 bags, format 2.0: chunks unpacked, packed with bzip2 or with lz4, with an index or cut off.
//!
//! A complete bag ends with an index of its chunks. A bag without a usable index is read once from the start, so that only the data which the
//! recorder had not written is lost. Source: ROS wiki, "Bags/Format/2.0".

mod records;

use crate::{FormatError, MAX_CHUNK_BYTES, texts};
use records::{Record, WHAT, op};
use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use vocab::Stamp;

const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// Characters of a name in the file that an error shows, at most.
const MAX_SHOWN_NAME_CHARS: usize = 40;

/// One publisher's topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BagConnection {
    /// Its topic.
    pub topic: String,
    /// ROS type, e.g. `sensor_msgs/Imu`.
    pub type_name: String,
}

/// Position and content of a chunk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// Byte offset of its record.
    pub position: u64,
    /// Earliest and latest message.
    pub span: (Stamp, Stamp),
    /// Messages of each connection.
    pub counts: BTreeMap<u32, u64>,
}

/// The index of a bag: its content without messages.
#[derive(Clone, Debug, Default)]
pub struct BagIndex {
    /// Connections by number.
    pub connections: BTreeMap<u32, BagConnection>,
    /// Chunks in file order.
    pub chunks: Vec<Chunk>,
    /// Damage of the file, one sentence each.
    pub warnings: Vec<String>,
}

/// A message in an unpacked chunk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BagMessage {
    /// Connection it came on.
    pub connection: u32,
    /// When it was recorded.
    pub at: Stamp,
    /// Its bytes in [`UnpackedChunk::bytes`].
    pub range: Range<usize>,
}

/// A chunk's content.
#[derive(Clone, Debug, Default)]
pub struct UnpackedChunk {
    /// The records.
    pub bytes: Vec<u8>,
    /// The messages among them, in file order.
    pub messages: Vec<BagMessage>,
    /// Connections declared among them.
    pub connections: BTreeMap<u32, BagConnection>,
    /// The loss, if not all could be unpacked.
    pub warning: Option<String>,
}

/// Whether a file that starts with these bytes is a ROS 1 bag, of any version.
pub fn is_bag(start: &[u8]) -> bool {
    start.starts_with(b"#ROSBAG V")
}

/// Reads the index of a bag.
///
/// # Errors
/// When the bytes are no bag of format 2.0 or cannot be read. A cut or damaged bag is no error: what it holds up to
/// there is given, with a warning.
pub fn read_index(file: &mut (impl Read + Seek)) -> Result<BagIndex, FormatError> {
    let size = file.seek(SeekFrom::End(0))?;
    check_magic(file, size)?;
    let indexed = read_header(file, size).and_then(|header| read_chunk_infos(file, size, &header));
    match indexed {
        Ok(index) => Ok(index),
        Err(_) => scan_records(file, size),
    }
}

/// Unpacks the chunk at `position`; of a chunk that is cut off, the part that is there.
///
/// # Errors
/// When there is no chunk or nothing of it can be unpacked.
pub fn read_chunk(file: &mut (impl Read + Seek), position: u64) -> Result<UnpackedChunk, FormatError> {
    let size = file.seek(SeekFrom::End(0))?;
    let record = records::read_head(file, size, position)?;
    if record.op() != Some(op::CHUNK) {
        return Err(FormatError::at_byte(WHAT, position, texts::NO_CHUNK));
    }
    unpack(file, size, &record)
}

fn check_magic(file: &mut (impl Read + Seek), size: u64) -> Result<(), FormatError> {
    let start = records::read_bytes(file, size, 0, size.min(MAGIC.len() as u64))?;
    if start == MAGIC {
        return Ok(());
    }
    let found = match is_bag(&start) {
        true => texts::OLD_BAG.to_owned(),
        false => texts::NO_BAG.to_owned(),
    };
    Err(FormatError::WrongKind { expected: texts::ROS1_BAG, found })
}

/// The first record: position and counts of the index.
struct BagHeader {
    /// 0 in a bag that was not closed.
    index_position: u64,
    connections: u32,
    chunks: u32,
}

fn read_header(file: &mut (impl Read + Seek), size: u64) -> Result<BagHeader, FormatError> {
    let record = records::read_head(file, size, MAGIC.len() as u64)?;
    Ok(BagHeader {
        index_position: record.u64("index_pos")?,
        connections: record.u32("conn_count")?,
        chunks: record.u32("chunk_count")?,
    })
}

/// Reads the index. An incomplete index is an error: a bag cut between two of its records would lose chunks unnoticed.
fn read_chunk_infos(
    file: &mut (impl Read + Seek),
    size: u64,
    header: &BagHeader,
) -> Result<BagIndex, FormatError> {
    let incomplete = || FormatError::at_byte(WHAT, header.index_position, texts::BAG_INDEX_INCOMPLETE);
    if header.index_position == 0 {
        return Err(incomplete());
    }
    let mut index = BagIndex::default();
    let mut at = header.index_position;
    while at < size {
        let record = records::read_head(file, size, at)?;
        let data = records::read_bytes(file, size, record.data_start, record.data_length)?;
        match record.op() {
            Some(op::CONNECTION) => {
                index.connections.insert(record.u32("conn")?, connection(&record, &data));
            }
            Some(op::CHUNK_INFO) => {
                let pairs = data.chunks_exact(8).map(|pair| {
                    let number = |bytes: &[u8]| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
                    (number(pair), u64::from(number(&pair[4..])))
                });
                let position = record.u64("chunk_pos")?;
                if position >= size {
                    return Err(FormatError::at_byte(WHAT, at, texts::CHUNK_BEYOND_END));
                }
                let span = (record.time("start_time")?, record.time("end_time")?);
                index.chunks.push(Chunk { position, span, counts: pairs.collect() });
            }
            _ => {}
        }
        at = record.end();
    }
    if index.chunks.len() != header.chunks as usize || index.connections.len() < header.connections as usize {
        return Err(incomplete());
    }
    index.chunks.sort_by_key(|chunk| chunk.position);
    Ok(index)
}

/// Indexes a bag without a usable index by reading all of its records.
fn scan_records(file: &mut (impl Read + Seek), size: u64) -> Result<BagIndex, FormatError> {
    let mut index = BagIndex::default();
    let mut at = MAGIC.len() as u64;
    while at < size {
        let Ok(record) = records::read_head(file, size, at) else { break };
        match record.op() {
            Some(op::CHUNK) => {
                if let Ok(chunk) = unpack(file, size, &record) {
                    index.connections.extend(chunk.connections.clone());
                    index.chunks.extend(summarise(at, &chunk));
                }
            }
            Some(op::CONNECTION) => {
                if let (Ok(number), Ok(data)) = (
                    record.u32("conn"),
                    records::read_bytes(file, size, record.data_start, record.data_length),
                ) {
                    index.connections.insert(number, connection(&record, &data));
                }
            }
            _ => {}
        }
        if record.end() > size {
            break;
        }
        at = record.end();
    }
    index.warnings.push(match at < size {
        true => texts::bag_cut_off(at, size),
        false => texts::BAG_WITHOUT_INDEX.to_owned(),
    });
    Ok(index)
}

fn summarise(position: u64, chunk: &UnpackedChunk) -> Option<Chunk> {
    let first = chunk.messages.iter().map(|message| message.at).min()?;
    let last = chunk.messages.iter().map(|message| message.at).max()?;
    let mut counts = BTreeMap::new();
    for message in &chunk.messages {
        *counts.entry(message.connection).or_insert(0) += 1;
    }
    Some(Chunk { position, span: (first, last), counts })
}

fn unpack(file: &mut (impl Read + Seek), size: u64, record: &Record) -> Result<UnpackedChunk, FormatError> {
    let available = size.saturating_sub(record.data_start).min(record.data_length);
    let packed = records::read_bytes(file, size, record.data_start, available)?;
    let unpacked = u64::from(record.u32("size")?);
    if unpacked > MAX_CHUNK_BYTES {
        let problem = texts::chunk_too_large(unpacked, MAX_CHUNK_BYTES);
        return Err(FormatError::at_byte(WHAT, record.data_start, problem));
    }
    let mut chunk = UnpackedChunk::default();
    let result = match record.text("compression").as_deref() {
        Some("none") => packed.take(unpacked).read_to_end(&mut chunk.bytes),
        Some("bz2") => {
            bzip2::read::BzDecoder::new(packed.as_slice()).take(unpacked).read_to_end(&mut chunk.bytes)
        }
        Some("lz4") => {
            lz4_flex::frame::FrameDecoder::new(packed.as_slice()).take(unpacked).read_to_end(&mut chunk.bytes)
        }
        other => {
            return Err(FormatError::Unsupported {
                what: texts::unknown_compression(&vocab::legible(
                    other.unwrap_or(texts::UNNAMED_COMPRESSION),
                    MAX_SHOWN_NAME_CHARS,
                )),
                remedy: texts::DECOMPRESS_BAG,
            });
        }
    };
    let complete = result.is_ok() && chunk.bytes.len() as u64 == unpacked;
    let walked = list_messages(&mut chunk);
    if !complete || walked.is_err() {
        chunk.warning = Some(texts::chunk_cut_off(record.data_start));
    }
    Ok(chunk)
}

fn list_messages(chunk: &mut UnpackedChunk) -> Result<(), FormatError> {
    let mut at = 0;
    while at < chunk.bytes.len() {
        let record = records::parse_head(&chunk.bytes, at)?;
        let range = checked_range(&chunk.bytes, &record)?;
        at = range.end;
        match record.op() {
            Some(op::MESSAGE) => {
                chunk.messages.push(BagMessage {
                    connection: record.u32("conn")?,
                    at: record.time("time")?,
                    range,
                });
            }
            Some(op::CONNECTION) => {
                let declared = connection(&record, &chunk.bytes[range]);
                chunk.connections.insert(record.u32("conn")?, declared);
            }
            _ => {}
        }
    }
    Ok(())
}

fn checked_range(bytes: &[u8], record: &Record) -> Result<Range<usize>, FormatError> {
    if record.end() > bytes.len() as u64 {
        let missing = record.end() - bytes.len() as u64;
        return Err(FormatError::Truncated { what: WHAT, at: record.data_start, missing });
    }
    Ok(record.data_start as usize..record.end() as usize)
}

fn connection(record: &Record, data: &[u8]) -> BagConnection {
    let fields = records::parse_fields(data).unwrap_or_default();
    let text = |name: &str| fields.get(name).map(|value| String::from_utf8_lossy(value).into_owned());
    BagConnection {
        topic: record.text("topic").or_else(|| text("topic")).unwrap_or_default(),
        type_name: text("type").unwrap_or_default(),
    }
}

#[cfg(test)]
#[path = "rosbag1_tests.rs"]
mod tests;
