//! MCAP files, finished or cut off: where their blocks lie, and the messages in them.
//!
//! A finished file says in its summary where its chunks are. Any other is walked once from the start, as far as it
//! can be understood. Either way messages are then read block by block. Source: mcap.dev/spec.

use super::merge::{Blocks, Merged};
use super::{Container, MessageEncoding, Messages, Order, RawMessage, Topic};
use crate::error::{OpenError, ReadError};
use crate::topics;
use formats::FormatError;
use formats::cdr::{Encoding, Reader};
use mcap::records::op;
use mcap::sans_io::{SummaryReadEvent, SummaryReader, SummaryReaderOptions};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vocab::Stamp;

/// Opcode and length before every record.
const RECORD_HEAD: u64 = 9;
/// Largest chunk, packed or not, that is read.
const LARGEST_CHUNK: u64 = 1 << 30;
/// Messages outside of chunks are read in blocks of about this many bytes.
const LOOSE_BLOCK: u64 = 4 << 20;

/// An MCAP file whose blocks are known.
pub(crate) struct McapFile {
    index: Arc<Index>,
    span: Option<(Stamp, Stamp)>,
    complaints: Vec<String>,
    metadata: BTreeMap<String, String>,
}

/// What is needed to read messages.
struct Index {
    path: PathBuf,
    topics: Vec<Topic>,
    /// Topic of each channel id.
    channels: BTreeMap<u16, usize>,
    /// In file order.
    blocks: Vec<Block>,
}

/// A run of bytes that holds messages.
#[derive(Clone, Debug)]
struct Block {
    /// Of a chunk: its record's content. Of loose messages: the first record's head.
    offset: u64,
    length: u64,
    kind: BlockKind,
    start: Stamp,
    /// Channels with messages in it; empty when not known.
    channels: BTreeSet<u16>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BlockKind {
    Chunk,
    Loose,
}

impl McapFile {
    /// Opens a file and finds its blocks.
    ///
    /// # Errors
    /// When it cannot be read or does not begin as an MCAP file does.
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        let io = |source| OpenError::Io { path: path.to_owned(), source };
        let mut file = File::open(path).map_err(io)?;
        let size = file.metadata().map_err(io)?.len();
        let mut magic = [0; 8];
        if size < 8 || file.read_exact(&mut magic).is_err() || magic != mcap::MAGIC {
            let problem = "it does not begin as an MCAP file does".to_owned();
            return Err(OpenError::NotARecording { path: path.to_owned(), problem });
        }
        if let Some(indexed) = from_summary(path, &mut file, size) {
            return Ok(indexed);
        }
        Survey::new(path, file, size).run()
    }

    /// Whether a file that starts with these bytes is an MCAP file.
    pub fn is_mcap(start: &[u8]) -> bool {
        start.starts_with(mcap::MAGIC)
    }
}

impl Container for McapFile {
    fn topics(&self) -> &[Topic] {
        &self.index.topics
    }

    fn span(&self) -> Option<(Stamp, Stamp)> {
        self.span
    }

    fn complaints(&self) -> &[String] {
        &self.complaints
    }

    fn metadata(&self, key: &str) -> Option<&str> {
        self.metadata.get(key).map(String::as_str)
    }

    fn messages(&self, wanted: &[bool], order: Order) -> Messages {
        match BlockReader::open(self.index.clone(), wanted.to_vec(), order) {
            Ok(reader) => Box::new(Merged::new(reader, order)),
            Err(error) => Box::new(std::iter::once(Err(error))),
        }
    }
}

/// Takes what the summary says, or `None` where the file has none or an unusable one.
fn from_summary(path: &Path, file: &mut File, size: u64) -> Option<McapFile> {
    let summary = read_summary(file, size)?;
    let statistics = summary.stats.as_ref()?;
    if statistics.message_count > 0 && (summary.chunk_indexes.is_empty() || summary.channels.is_empty()) {
        return None;
    }
    let mut directory = Directory::default();
    let ordered: BTreeMap<_, _> = summary.channels.iter().collect();
    for (id, channel) in ordered {
        let schema = channel.schema.as_ref();
        let topic = directory.add(
            *id,
            &channel.topic,
            &channel.message_encoding,
            schema.map_or("", |schema| &schema.name),
            schema.map_or("", |schema| &schema.encoding),
        );
        directory.topics[topic].count += statistics.channel_message_counts.get(id).copied().unwrap_or(0);
    }
    let mut blocks = Vec::with_capacity(summary.chunk_indexes.len());
    for chunk in &summary.chunk_indexes {
        let end = chunk.chunk_start_offset.checked_add(chunk.chunk_length)?;
        let length = chunk.chunk_length.checked_sub(RECORD_HEAD)?;
        if end > size {
            return None;
        }
        blocks.push(Block {
            offset: chunk.chunk_start_offset + RECORD_HEAD,
            length,
            kind: BlockKind::Chunk,
            start: stamp(chunk.message_start_time),
            channels: chunk.message_index_offsets.keys().copied().collect(),
        });
    }
    blocks.sort_by_key(|block| block.offset);
    let mut metadata = BTreeMap::new();
    for index in &summary.metadata_indexes {
        let body = index.offset.checked_add(RECORD_HEAD).zip(index.length.checked_sub(RECORD_HEAD));
        if let Some(bytes) = body.and_then(|(offset, length)| read_range(file, size, offset, length).ok()) {
            let _ = read_metadata(&bytes, &mut metadata);
        }
    }
    let span = (statistics.message_count > 0)
        .then(|| (stamp(statistics.message_start_time), stamp(statistics.message_end_time)));
    let index =
        Index { path: path.to_owned(), topics: directory.topics, channels: directory.channels, blocks };
    Some(McapFile { index: Arc::new(index), span, complaints: Vec::new(), metadata })
}

fn read_summary(file: &mut File, size: u64) -> Option<mcap::Summary> {
    let options = SummaryReaderOptions::default()
        .with_file_size(size)
        .with_record_length_limit(usize::try_from(size.min(LARGEST_CHUNK)).ok()?);
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

/// Channels seen so far, joined to topics by name and type.
#[derive(Default)]
struct Directory {
    topics: Vec<Topic>,
    channels: BTreeMap<u16, usize>,
    /// Name and encoding of each schema.
    schemas: BTreeMap<u16, (String, String)>,
}

impl Directory {
    fn add(&mut self, id: u16, name: &str, encoding: &str, schema: &str, schema_encoding: &str) -> usize {
        let encoding = match (encoding, schema_encoding) {
            ("cdr", _) | ("", "ros2msg" | "ros2idl") => MessageEncoding::Ros(Encoding::Cdr),
            ("ros1", _) | ("", "ros1msg") => MessageEncoding::Ros(Encoding::Ros1),
            (topics::INPUT_ENCODING, _) => MessageEncoding::Postcard,
            (other, _) => MessageEncoding::Other(other.to_owned()),
        };
        let type_name = formats::ros::plain_type_name(schema);
        let same =
            |topic: &Topic| topic.name == name && topic.type_name == type_name && topic.encoding == encoding;
        let topic = self.topics.iter().position(same).unwrap_or_else(|| {
            self.topics.push(Topic { name: name.to_owned(), type_name, encoding, count: 0 });
            self.topics.len() - 1
        });
        self.channels.insert(id, topic);
        topic
    }

    fn add_schema(&mut self, record: &[u8]) -> Result<(), FormatError> {
        let mut reader = Reader::new(Encoding::Ros1, record, "MCAP schema")?;
        let id = reader.u16()?;
        self.schemas.insert(id, (reader.string()?, reader.string()?));
        Ok(())
    }

    fn add_channel(&mut self, record: &[u8]) -> Result<(), FormatError> {
        let mut reader = Reader::new(Encoding::Ros1, record, "MCAP channel")?;
        let (id, schema) = (reader.u16()?, reader.u16()?);
        let (topic, encoding) = (reader.string()?, reader.string()?);
        let (schema, schema_encoding) = self.schemas.get(&schema).cloned().unwrap_or_default();
        self.add(id, &topic, &encoding, &schema, &schema_encoding);
        Ok(())
    }
}

/// Walks a file without a usable summary from its start.
struct Survey<'a> {
    path: &'a Path,
    file: File,
    size: u64,
    directory: Directory,
    blocks: Vec<Block>,
    span: Option<(Stamp, Stamp)>,
    complaints: Vec<String>,
    metadata: BTreeMap<String, String>,
}

impl<'a> Survey<'a> {
    fn new(path: &'a Path, file: File, size: u64) -> Self {
        Self {
            path,
            file,
            size,
            directory: Directory::default(),
            blocks: Vec::new(),
            span: None,
            complaints: Vec::new(),
            metadata: BTreeMap::new(),
        }
    }

    fn run(mut self) -> Result<McapFile, OpenError> {
        self.walk().map_err(|source| OpenError::Io { path: self.path.to_owned(), source })?;
        let index = Index {
            path: self.path.to_owned(),
            topics: self.directory.topics,
            channels: self.directory.channels,
            blocks: self.blocks,
        };
        let (span, complaints, metadata) = (self.span, self.complaints, self.metadata);
        Ok(McapFile { index: Arc::new(index), span, complaints, metadata })
    }

    fn walk(&mut self) -> std::io::Result<()> {
        let mut at = mcap::MAGIC.len() as u64;
        loop {
            let mut head = [0; RECORD_HEAD as usize];
            if self.size - at < RECORD_HEAD {
                self.complain_cut(at);
                return Ok(());
            }
            self.file.seek(SeekFrom::Start(at))?;
            self.file.read_exact(&mut head)?;
            let [opcode, length @ ..] = head;
            let length = u64::from_le_bytes(length);
            let available = self.size - at - RECORD_HEAD;
            if opcode == 0 || length > available && opcode != op::CHUNK {
                self.complain_cut(at);
                return Ok(());
            }
            let content = at + RECORD_HEAD;
            match opcode {
                op::DATA_END | op::FOOTER => return Ok(()),
                op::CHUNK => self.chunk(content, length.min(available)),
                op::MESSAGE => self.loose_message(at, length),
                op::SCHEMA | op::CHANNEL | op::METADATA => self.declaration(opcode, content, length),
                _ => {}
            }
            if length > available {
                self.complain_cut(at);
                return Ok(());
            }
            at = content + length;
        }
    }

    fn complain_cut(&mut self, at: u64) {
        self.complaints.push(format!(
            "the file is cut off or damaged at byte {at} of {}: everything before that is used; if the recorder \
             was stopped hard this is normal, else copy the file again",
            self.size
        ));
    }

    fn declaration(&mut self, opcode: u8, offset: u64, length: u64) {
        let Ok(record) = read_range(&mut self.file, self.size, offset, length) else { return };
        let result = match opcode {
            op::SCHEMA => self.directory.add_schema(&record),
            op::CHANNEL => self.directory.add_channel(&record),
            _ => read_metadata(&record, &mut self.metadata),
        };
        if let Err(error) = result {
            self.complaints
                .push(format!("a declaration at byte {offset} is unreadable and ignored: {error}"));
        }
    }

    fn chunk(&mut self, offset: u64, length: u64) {
        let mut block =
            Block { offset, length, kind: BlockKind::Chunk, start: Stamp::EPOCH, channels: BTreeSet::new() };
        // An unreadable chunk is told of when its messages are read; here its readable part is counted.
        let Ok((records, _)) = load_block(&mut self.file, self.size, &block) else { return };
        let mut earliest = None;
        for (opcode, range) in Records::new(&records) {
            let record = &records[range];
            let _ = match opcode {
                op::SCHEMA => self.directory.add_schema(record),
                op::CHANNEL => self.directory.add_channel(record),
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
        let Ok(head) = read_range(&mut self.file, self.size, at + RECORD_HEAD, length.min(22)) else {
            return;
        };
        let grows = |block: &Block| {
            block.kind == BlockKind::Loose && block.offset + block.length == at && block.length < LOOSE_BLOCK
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
        block.length += RECORD_HEAD + length;
        block.start = earliest.unwrap_or_default();
        if counted.is_ok() || block.length > RECORD_HEAD + length {
            self.blocks.push(block);
        }
    }

    fn count(
        &mut self,
        record: &[u8],
        block: &mut Block,
        earliest: &mut Option<Stamp>,
    ) -> Result<(), FormatError> {
        let head = MessageHead::read(record)?;
        if let Some(topic) = self.directory.channels.get(&head.channel) {
            self.directory.topics[*topic].count += 1;
            block.channels.insert(head.channel);
            *earliest = Some(earliest.map_or(head.at, |stamp| stamp.min(head.at)));
            let (first, last) = self.span.unwrap_or((head.at, head.at));
            self.span = Some((first.min(head.at), last.max(head.at)));
        }
        Ok(())
    }
}

/// Reads the wanted messages block by block.
struct BlockReader {
    file: File,
    size: u64,
    index: Arc<Index>,
    wanted: Vec<bool>,
    /// Numbers of the blocks to read, last first.
    queue: Vec<usize>,
}

impl BlockReader {
    fn open(index: Arc<Index>, wanted: Vec<bool>, order: Order) -> Result<Self, ReadError> {
        let io = |source| ReadError::Io { path: index.path.clone(), source };
        let file = File::open(&index.path).map_err(io)?;
        let size = file.metadata().map_err(io)?.len();
        let is_wanted = |channel: &u16| index.channels.get(channel).is_some_and(|topic| wanted[*topic]);
        let holds_wanted = |block: &Block| block.channels.is_empty() || block.channels.iter().any(is_wanted);
        let mut queue: Vec<usize> =
            (0..index.blocks.len()).filter(|number| holds_wanted(&index.blocks[*number])).collect();
        if order == Order::LogTime {
            queue.sort_by_key(|number| (index.blocks[*number].start, *number));
        }
        queue.reverse();
        Ok(Self { file, size, index, wanted, queue })
    }
}

impl Blocks for BlockReader {
    fn next_start(&self) -> Option<Stamp> {
        self.queue.last().map(|number| self.index.blocks[*number].start)
    }

    fn load_next(&mut self, messages: &mut Vec<(u64, RawMessage)>) -> Result<(), ReadError> {
        let Some(number) = self.queue.pop() else { return Ok(()) };
        let block = &self.index.blocks[number];
        let damaged =
            |problem| ReadError::Damaged { path: self.index.path.clone(), at: block.offset, problem };
        let (records, complaint) = load_block(&mut self.file, self.size, block).map_err(damaged)?;
        let records = Arc::new(records);
        let mut walk = Records::new(&records);
        for (opcode, range) in walk.by_ref() {
            if opcode != op::MESSAGE {
                continue;
            }
            let Ok(head) = MessageHead::read(&records[range.clone()]) else { continue };
            let topic = self.index.channels.get(&head.channel).filter(|topic| self.wanted[**topic]);
            if let Some(topic) = topic {
                let place = ((number as u64) << 32) | messages.len() as u64;
                let body = range.start + MessageHead::LENGTH..range.end;
                messages.push((place, RawMessage::new(*topic, head.at, records.clone(), body)));
            }
        }
        let cut = walk.cut.then(|| "a block of messages ends early, its last message is lost".to_owned());
        complaint.or(cut).map_or(Ok(()), |problem| Err(damaged(problem)))
    }
}

struct MessageHead {
    channel: u16,
    at: Stamp,
}

impl MessageHead {
    const LENGTH: usize = 22;

    fn read(record: &[u8]) -> Result<Self, FormatError> {
        let mut reader = Reader::new(Encoding::Ros1, record, "MCAP message")?;
        let (channel, _sequence) = (reader.u16()?, reader.u32()?);
        let at = stamp(reader.u64()?);
        reader.u64()?;
        Ok(Self { channel, at })
    }
}

/// The records in the content of a chunk: opcode and range of each.
struct Records<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Whether the last record was incomplete.
    cut: bool,
}

impl<'a> Records<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, cut: false }
    }
}

impl Iterator for Records<'_> {
    type Item = (u8, std::ops::Range<usize>);

    fn next(&mut self) -> Option<Self::Item> {
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return None;
        }
        let head = rest.first_chunk::<{ RECORD_HEAD as usize }>();
        let sized = head.map(|[opcode, length @ ..]| (*opcode, u64::from_le_bytes(*length)));
        let start = self.at + RECORD_HEAD as usize;
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

/// The records of a block, unpacked, and what is wrong with them where only a part could be had.
fn load_block(file: &mut File, size: u64, block: &Block) -> Result<(Vec<u8>, Option<String>), String> {
    let bytes = read_range(file, size, block.offset, block.length)?;
    match block.kind {
        BlockKind::Loose => Ok((bytes, None)),
        BlockKind::Chunk => unpack_chunk(&bytes),
    }
}

fn unpack_chunk(record: &[u8]) -> Result<(Vec<u8>, Option<String>), String> {
    let unreadable = |error: FormatError| error.to_string();
    let mut reader = Reader::new(Encoding::Ros1, record, "MCAP chunk").map_err(unreadable)?;
    let mut head = || -> Result<_, FormatError> {
        let (_start, _end, unpacked, _crc) = (reader.u64()?, reader.u64()?, reader.u64()?, reader.u32()?);
        Ok((unpacked, reader.string()?, reader.u64()?))
    };
    let (unpacked, compression, packed) = head().map_err(unreadable)?;
    if unpacked > LARGEST_CHUNK {
        return Err(format!("a chunk claims to unpack to {unpacked} bytes, which is more than is read"));
    }
    let data = &record[record.len() - reader.remaining()..];
    let data = &data[..data.len().min(usize::try_from(packed).unwrap_or(usize::MAX))];
    let mut out = Vec::with_capacity(unpacked.min(16 << 20).min(data.len() as u64 * 64) as usize);
    let result = match compression.as_str() {
        "" => data.take(unpacked).read_to_end(&mut out),
        "zstd" => zstd::stream::read::Decoder::with_buffer(data)
            .and_then(|decoder| decoder.take(unpacked).read_to_end(&mut out)),
        "lz4" => lz4_flex::frame::FrameDecoder::new(data).take(unpacked).read_to_end(&mut out),
        other => return Err(format!("a chunk is packed with '{other}', which is not known")),
    };
    let complaint = match result {
        Err(error) => Some(format!("a chunk does not unpack ({error}), the rest of it is lost")),
        Ok(_) if (out.len() as u64) < unpacked => {
            Some(format!("a chunk holds {} of its {unpacked} bytes, the rest is lost", out.len()))
        }
        Ok(_) => None,
    };
    Ok((out, complaint))
}

fn read_range(file: &mut File, size: u64, offset: u64, length: u64) -> Result<Vec<u8>, String> {
    if length > LARGEST_CHUNK || offset.checked_add(length).is_none_or(|end| end > size) {
        return Err(format!("{length} bytes were announced, more than the file holds or than is read"));
    }
    let mut bytes = vec![0; length as usize];
    let read = file.seek(SeekFrom::Start(offset)).and_then(|_| file.read_exact(&mut bytes));
    read.map_err(|error| format!("it could not be read: {error}"))?;
    Ok(bytes)
}

/// Adds the entries of a metadata record that the platform wrote.
fn read_metadata(record: &[u8], into: &mut BTreeMap<String, String>) -> Result<(), FormatError> {
    let mut reader = Reader::new(Encoding::Ros1, record, "MCAP metadata")?;
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

fn stamp(nanos: u64) -> Stamp {
    Stamp::from_nanos(nanos as i64)
}
