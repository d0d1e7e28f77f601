//! Recordings: reading MCAP files, ROS bags and folders of scans as one kind of thing, and writing MCAP that is
//! at once a standard recording and the exact journal of the stack.

mod containers;
mod decode;
mod display;
mod error;
mod frames;
mod info;
mod legacy;
mod problems;
mod recording;
mod selection;
pub mod topics;
mod writer;

pub use error::{OpenError, ReadError, WriteError};
pub use info::{RecordingInfo, TopicInfo};
pub use problems::ReadProblems;
pub use recording::{Inputs, Recording};
pub use selection::{TopicRole, TopicSelection};
pub use writer::{ChunkCompression, RecordingMeta, RecordingWriter};

/// What the writer put on this topic of its own file, if it belongs to the journal.
fn journal_role(topic: &str) -> Option<TopicRole> {
    Some(match topic {
        topics::LIDAR => TopicRole::Lidar,
        topics::IMU => TopicRole::Imu,
        topics::LEGS => TopicRole::Legs,
        topics::EXTERNAL => TopicRole::External,
        topics::BATTERY => TopicRole::Battery,
        topics::INPUT => TopicRole::Journal,
        _ => return None,
    })
}
