//! Writes an MCAP file of JSON messages to any sink, in one pass: for exports, which are made while they are sent. It has chunks and an index like any other recording.

use mcap::records::{AttachmentHeader, MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Compression, McapError, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::io::{self, Read, Write};

/// Size at which a chunk is closed, bytes before compression. Chosen: a picture of a few MB as text fills one, and memory holds one chunk.
const CHUNK_BYTES: u64 = 4 << 20;
/// Bytes of an attachment that are copied at once. Chosen: as the copies of the standard library, times eight.
const COPY_BYTES: usize = 64 << 10;

/// Describes the messages of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JsonSchema {
    /// Name of the type, such as `foxglove.PoseInFrame`.
    pub name: &'static str,
    /// The JSON Schema.
    pub text: &'static str,
}

/// Writes one file. Without [`Self::finish`] it has no index, and can be read up to its last whole chunk.
pub struct JsonMcapWriter<W: Write> {
    mcap: Writer<NoSeek<W>>,
    channels: BTreeMap<String, u16>,
    sequence: u32,
}

impl<W: Write> JsonMcapWriter<W> {
    /// Begins a file.
    ///
    /// # Errors
    /// When the sink fails, here and below.
    pub fn new(sink: W) -> io::Result<Self> {
        let options = WriteOptions::new()
            .library(concat!("autoinspect ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            .compression_level(1)
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES))
            .disable_seeking(true);
        let mcap = options.create(NoSeek::new(sink)).map_err(io_error)?;
        Ok(Self { mcap, channels: BTreeMap::new(), sequence: 0 })
    }

    /// Writes a message of a topic, whose schema is that of its first message. `utc_ns`: when it was made, nanoseconds since 1970 UTC; one before 1970 counts as 1970.
    ///
    /// # Errors
    /// As for [`Self::new`].
    pub fn message(&mut self, topic: &str, schema: JsonSchema, utc_ns: i64, json: &[u8]) -> io::Result<()> {
        let channel_id = match self.channels.get(topic) {
            Some(known) => *known,
            None => {
                let schema = self.mcap.add_schema(schema.name, "jsonschema", schema.text.as_bytes());
                let schema = schema.map_err(io_error)?;
                let channel = self.mcap.add_channel(schema, topic, "json", &BTreeMap::new());
                let channel = channel.map_err(io_error)?;
                self.channels.insert(topic.to_owned(), channel);
                channel
            }
        };
        let time = u64::try_from(utc_ns).unwrap_or(0);
        let header =
            MessageHeader { channel_id, sequence: self.sequence, log_time: time, publish_time: time };
        self.sequence = self.sequence.wrapping_add(1);
        self.mcap.write_to_known_channel(&header, json).map_err(io_error)
    }

    /// Writes a file beside the messages. `content` has to have `length` bytes.
    ///
    /// # Errors
    /// When `content` is shorter or longer, or fails, and as for [`Self::new`].
    pub fn attachment(
        &mut self,
        name: &str,
        media_type: &str,
        utc_ns: i64,
        length: u64,
        mut content: impl Read,
    ) -> io::Result<()> {
        let time = u64::try_from(utc_ns).unwrap_or(0);
        let header = AttachmentHeader {
            log_time: time,
            create_time: time,
            name: name.to_owned(),
            media_type: media_type.to_owned(),
        };
        self.mcap.start_attachment(length, header).map_err(io_error)?;
        let mut buffer = vec![0; COPY_BYTES];
        loop {
            let read = content.read(&mut buffer)?;
            if read == 0 {
                return self.mcap.finish_attachment().map_err(io_error);
            }
            self.mcap.put_attachment_bytes(&buffer[..read]).map_err(io_error)?;
        }
    }

    /// Writes what holds for the whole file.
    ///
    /// # Errors
    /// As for [`Self::new`].
    pub fn metadata(&mut self, name: &str, entries: BTreeMap<String, String>) -> io::Result<()> {
        let metadata = Metadata { name: name.to_owned(), metadata: entries };
        self.mcap.write_metadata(&metadata).map_err(io_error)
    }

    /// Completes the file with its index.
    ///
    /// # Errors
    /// As for [`Self::new`].
    pub fn finish(mut self) -> io::Result<()> {
        self.mcap.finish().map_err(io_error)?;
        self.mcap.into_inner().into_inner().flush()
    }
}

/// An error of the sink as it is; another one of the library with its text.
fn io_error(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCHEMA: JsonSchema = JsonSchema { name: "Point", text: r#"{"type": "object"}"# };

    /// A sink that cannot seek and holds all that it was given.
    fn written() -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut writer = JsonMcapWriter::new(&mut bytes).expect("begun");
        for number in 0..3 {
            let json = format!(r#"{{"number": {number}}}"#);
            writer.message("/points", SCHEMA, 1_000 + number, json.as_bytes()).expect("written");
        }
        writer.message("/others", SCHEMA, -1, b"{}").expect("written");
        writer.attachment("cloud.ply", "model/ply", 5, 3, &b"ply"[..]).expect("written");
        writer
            .metadata("run", BTreeMap::from([("mission".to_owned(), "Round".to_owned())]))
            .expect("written");
        writer.finish().expect("finished");
        bytes
    }

    #[test]
    fn a_file_that_was_written_in_one_pass_reads_back_with_its_index() {
        let bytes = written();
        let messages: Vec<_> =
            mcap::MessageStream::new(&bytes).expect("a file").collect::<Result<_, _>>().expect("whole");
        let read: Vec<(&str, u64, &[u8])> = messages
            .iter()
            .map(|message| (message.channel.topic.as_str(), message.log_time, &*message.data))
            .collect();
        assert_eq!(read.len(), 4);
        assert_eq!(read[1], ("/points", 1_001, br#"{"number": 1}"#.as_slice()));
        assert_eq!(read[3], ("/others", 0, b"{}".as_slice()), "before 1970");
        let schema = messages[0].channel.schema.as_ref().expect("a schema");
        assert_eq!((schema.name.as_str(), schema.encoding.as_str()), ("Point", "jsonschema"));
        let summary = mcap::Summary::read(&bytes).expect("whole").expect("an index");
        assert_eq!((summary.attachment_indexes.len(), summary.metadata_indexes.len()), (1, 1));
        assert_eq!(summary.stats.map(|stats| stats.message_count), Some(4));
        let attached = mcap::read::attachment(&bytes, &summary.attachment_indexes[0]).expect("whole");
        assert_eq!((attached.name.as_str(), &*attached.data), ("cloud.ply", b"ply".as_slice()));
    }

    #[test]
    fn an_attachment_of_another_length_and_a_sink_that_fails_are_errors() {
        let mut writer = JsonMcapWriter::new(Vec::new()).expect("begun");
        assert!(writer.attachment("a", "b", 0, 4, &b"ply"[..]).is_err());
        let mut writer = JsonMcapWriter::new(Vec::new()).expect("begun");
        assert!(writer.attachment("a", "b", 0, 2, &b"ply"[..]).is_err());
        // A slice takes as many bytes as it has.
        let mut room = [0_u8; 40];
        let sent = JsonMcapWriter::new(&mut room[..]).and_then(|mut writer| {
            writer.message("/points", SCHEMA, 0, &[b' '; 100])?;
            writer.finish()
        });
        assert!(sent.is_err());
    }
}
