//! The interface of recording files: a list of topics and a stream of messages.

mod bag_file;
mod database_file;
mod file_sequence;
mod mcap_file;
mod merge;
mod open;
mod scan_folder;

pub(crate) use open::{open, open_run};

use crate::error::ReadError;
use formats::cdr::Encoding;
use formats::scan_file::ScanFormat;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;
use vocab::Stamp;

/// How a topic's messages are encoded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum MessageEncoding {
    /// An encoding of ROS.
    Ros(Encoding),
    /// The whole file is the message.
    ScanFile(ScanFormat),
    /// The platform's own journal.
    Postcard,
    /// The platform's own sweeps.
    RangeImage,
    /// Another encoding, by its name in the file.
    Other(String),
}

/// Largest number of characters of a topic's or type's name; longer names are cut.
const MAX_NAME_CHARS: usize = 200;

/// The name of a topic or type as it appears in sentences for people.
pub(crate) fn legible_name(name: &str) -> String {
    vocab::legible(name, MAX_NAME_CHARS)
}

/// One topic of a recording.
#[derive(Clone, Debug)]
pub(crate) struct Topic {
    pub name: String,
    /// Type in the form of ROS 1, such as `sensor_msgs/Imu`. For the journal the name of its schema.
    pub type_name: String,
    pub encoding: MessageEncoding,
    pub count: u64,
}

/// One message, still encoded.
#[derive(Clone, Debug)]
pub(crate) struct RawMessage {
    /// Index into the container's topics.
    pub topic: usize,
    /// Log time.
    pub at: Stamp,
    /// The file, if the message is a whole file.
    pub file: Option<PathBuf>,
    bytes: Arc<Vec<u8>>,
    range: Range<usize>,
}

impl RawMessage {
    pub fn new(topic: usize, at: Stamp, bytes: Arc<Vec<u8>>, range: Range<usize>) -> Self {
        Self { topic, at, file: None, bytes, range }
    }

    /// A message that is a whole file.
    pub fn of_file(at: Stamp, file: PathBuf, bytes: Vec<u8>) -> Self {
        let range = 0..bytes.len();
        Self { topic: 0, at, file: Some(file), bytes: Arc::new(bytes), range }
    }

    pub fn bytes(&self) -> &[u8] {
        &self.bytes[self.range.clone()]
    }
}

/// The order in which messages are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MessageOrder {
    /// The order in the file, in which they were written.
    File,
    /// By log time; messages of the same time in the order of the file.
    LogTime,
}

/// A stream of messages.
pub(crate) type Messages = Box<dyn Iterator<Item = Result<RawMessage, ReadError>> + Send>;

/// The interface of every kind of recording file.
pub(crate) trait Container: Send + Sync {
    /// Its topics.
    fn topics(&self) -> &[Topic];

    /// Log times of the first and last message.
    fn span(&self) -> Option<(Stamp, Stamp)>;

    /// Damage of the file as a whole, one sentence each.
    fn warnings(&self) -> &[String];

    /// Value of a metadata entry.
    fn metadata(&self, _key: &str) -> Option<&str> {
        None
    }

    /// Streams the messages of the topics for which `wanted` is true. It opens the file again. Memory does not grow with the file's size.
    fn messages(&self, wanted: &[bool], order: MessageOrder) -> Messages;
}
