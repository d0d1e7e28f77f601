//! The standard ROS messages the platform reads and writes, in both of ROS's encodings, and their conversion
//! to and from the stack's own messages.

mod convert;
mod point_cloud;
mod schemas;
mod standard;

pub use point_cloud::{PointCloud2, write_scan};
pub use schemas::definition;
pub use standard::{BatteryState, Header, Imu, Odometry, PoseStamped, TfMessage, TransformStamped};

use crate::FormatError;
use crate::cdr::{CdrReader, Encoding, Writer};

/// A message with a fixed ROS type.
pub trait RosMessage: Sized {
    /// Package and name, e.g. `sensor_msgs/Imu`.
    const TYPE: &'static str;

    /// Reads the message's fields.
    ///
    /// # Errors
    /// When the bytes end early.
    fn read(reader: &mut CdrReader<'_>) -> Result<Self, FormatError>;

    /// Writes the message's fields.
    fn write(&self, writer: &mut Writer<'_>);

    /// Reads a whole message.
    ///
    /// # Errors
    /// When the bytes end early or the encapsulation is unknown.
    fn from_bytes(encoding: Encoding, bytes: &[u8]) -> Result<Self, FormatError> {
        Self::read(&mut CdrReader::new(encoding, bytes, Self::TYPE)?)
    }

    /// Appends a whole message to `out`.
    fn to_bytes(&self, encoding: Encoding, out: &mut Vec<u8>) {
        self.write(&mut Writer::new(encoding, out));
    }
}

/// The type's name as ROS 1 writes it: `sensor_msgs/msg/Imu` and `sensor_msgs/Imu` both become the latter.
pub fn plain_type_name(name: &str) -> String {
    name.replacen("/msg/", "/", 1)
}
