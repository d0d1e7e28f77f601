//! Recordings. MCAP files, ROS bags and folders of scans are read through one interface. MCAP files are written; each is a standard
//! recording and at the same time the exact journal of the stack.

mod containers;
mod decode;
mod display;
mod error;
mod frames;
mod info;
mod json_writer;
mod legacy;
mod legacy_site;
mod problems;
mod recording;
mod selection;
mod texts;
pub mod topics;
mod writer;

pub use decode::{decode_journal_entry, journal_schemas};
pub use error::{OpenError, ReadError, WriteError};
pub use info::{RecordingInfo, TopicInfo};
pub use json_writer::{JsonMcapWriter, JsonSchema};
pub use problems::ReadProblems;
pub use recording::{Inputs, Recording};
pub use selection::{TopicRole, TopicSelection};
pub use writer::{ChunkCompression, RecordingMeta, RecordingWriter, ScanMessage, WriterConfig};

/// Role of a topic in a file of [`RecordingWriter`]; `None` if it does not belong to the journal.
fn journal_role(topic: &str) -> Option<TopicRole> {
    Some(match topic {
        topics::LIDAR | topics::RANGE_IMAGE => TopicRole::Lidar,
        topics::IMU => TopicRole::Imu,
        topics::LEGS => TopicRole::Legs,
        topics::EXTERNAL => TopicRole::External,
        topics::BATTERY => TopicRole::Battery,
        topics::INPUT => TopicRole::Journal,
        _ => return None,
    })
}
