//! Index of an MCAP file: its blocks with messages, its channels, and what its metadata says.

use crate::containers::{MessageEncoding, Topic, legible_name};
use crate::topics;
use formats::FormatError;
use formats::cdr::{CdrReader, Encoding};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;
use vocab::Stamp;

/// Opcode and length before every record.
pub(super) const RECORD_HEADER_LEN: u64 = 9;

/// What is known of a file before its messages are read.
pub(super) struct IndexedFile {
    pub index: Arc<Index>,
    /// First and last message.
    pub span: Option<(Stamp, Stamp)>,
    /// Damage of the file, one sentence each.
    pub warnings: Vec<String>,
    pub metadata: BTreeMap<String, String>,
}

/// Index for reading messages.
pub(super) struct Index {
    pub path: PathBuf,
    pub topics: Vec<Topic>,
    /// Topic of each channel id.
    pub channels: BTreeMap<u16, usize>,
    /// In file order.
    pub blocks: Vec<Block>,
}

/// A range of bytes with messages.
#[derive(Clone, Debug)]
pub(super) struct Block {
    /// Offset in the file: of a chunk's record content, or of the first record's header for messages outside of chunks.
    pub offset: u64,
    pub length: u64,
    pub kind: BlockKind,
    pub start: Stamp,
    /// Channels with messages in it; empty when not known.
    pub channels: BTreeSet<u16>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BlockKind {
    Chunk,
    Loose,
}

/// Channels seen so far, joined to topics by name and type.
#[derive(Default)]
pub(super) struct ChannelTable {
    pub topics: Vec<Topic>,
    pub channels: BTreeMap<u16, usize>,
    /// Name and encoding of each schema.
    schemas: BTreeMap<u16, (String, String)>,
}

impl ChannelTable {
    /// Adds a channel; returns its topic.
    pub fn add(&mut self, id: u16, name: &str, encoding: &str, schema: &str, schema_encoding: &str) -> usize {
        let encoding = match (encoding, schema_encoding) {
            ("cdr", _) | ("", "ros2msg" | "ros2idl") => MessageEncoding::Ros(Encoding::Cdr),
            ("ros1", _) | ("", "ros1msg") => MessageEncoding::Ros(Encoding::Ros1),
            (topics::INPUT_ENCODING, _) => MessageEncoding::Postcard,
            (topics::RANGE_IMAGE_ENCODING, _) if schema == topics::RANGE_IMAGE_SCHEMA => {
                MessageEncoding::RangeImage
            }
            (other, _) => MessageEncoding::Other(other.to_owned()),
        };
        let name = legible_name(name);
        let type_name = legible_name(&formats::ros::plain_type_name(schema));
        let same =
            |topic: &Topic| topic.name == name && topic.type_name == type_name && topic.encoding == encoding;
        let topic = self.topics.iter().position(same).unwrap_or_else(|| {
            self.topics.push(Topic { name, type_name, encoding, count: 0 });
            self.topics.len() - 1
        });
        self.channels.insert(id, topic);
        topic
    }

    /// Adds a schema record.
    pub fn add_schema(&mut self, record: &[u8]) -> Result<(), FormatError> {
        let mut reader = CdrReader::new(Encoding::Ros1, record, "MCAP schema")?;
        let id = reader.u16()?;
        self.schemas.insert(id, (reader.string()?, reader.string()?));
        Ok(())
    }

    /// Adds a channel record.
    pub fn add_channel(&mut self, record: &[u8]) -> Result<(), FormatError> {
        let mut reader = CdrReader::new(Encoding::Ros1, record, "MCAP channel")?;
        let (id, schema) = (reader.u16()?, reader.u16()?);
        let (topic, encoding) = (reader.string()?, reader.string()?);
        let (schema, schema_encoding) = self.schemas.get(&schema).cloned().unwrap_or_default();
        self.add(id, &topic, &encoding, &schema, &schema_encoding);
        Ok(())
    }
}

/// Adds the entries of a metadata record that the platform wrote.
pub(super) fn read_metadata(record: &[u8], into: &mut BTreeMap<String, String>) -> Result<(), FormatError> {
    let mut reader = CdrReader::new(Encoding::Ros1, record, "MCAP metadata")?;
    if reader.string()? != "autoinspect" {
        return Ok(());
    }
    let end = reader.u32()? as usize;
    let before = reader.remaining();
    while before - reader.remaining() < end {
        into.insert(reader.string()?, reader.string()?);
    }
    Ok(())
}

/// A stamp of the format.
pub(super) fn stamp(nanos: u64) -> Stamp {
    Stamp::from_nanos(nanos as i64)
}
