//! Sentences about recordings that the program shows to people, by key. English.

use std::path::Path;

/// Kinds of recordings, where the format of one file does not name them.
pub(crate) const SEGMENTS_OF_RUN: &str = "segments of a run";
pub(crate) const FOLDER_OF_SCANS: &str = "folder of scans";
pub(crate) const FOLDER_OF_BAGS: &str = "folder of bags";
/// A message that goes on after its value: a reason.
pub(crate) const BYTES_LEFT_OVER: &str = "bytes are left over";
/// A file without a byte.
pub(crate) const EMPTY_FILE: &str = "the file is empty; record or copy it again";
/// LAS, LAZ or E57.
pub(crate) const FINISHED_CLOUD: &str = "it is a finished point cloud (LAS, LAZ or E57) without the motion of a sensor; a recording is MCAP, a ROS \
     bag, or a folder of PCD, PLY or KITTI scans";
/// A file that is compressed as a whole.
pub(crate) const PACKED_WITH_ZSTD: &str = "it is packed with zstd as a whole; unpack it first (zstd -d)";
/// The same with gzip.
pub(crate) const PACKED_WITH_GZIP: &str = "it is packed with gzip; unpack it first (gunzip)";
/// pcap or pcapng.
pub(crate) const NETWORK_CAPTURE: &str =
    "it is a capture of network packets, which is not read yet; convert it to MCAP with the LiDAR's driver";
/// Nothing that is known.
pub(crate) const UNKNOWN_KIND: &str = "its first bytes are those of no known kind; a recording is MCAP, a ROS bag, or a folder of PCD, PLY or \
     KITTI scans";
/// A folder of rosbag2 without its files.
pub(crate) const BAG_WITHOUT_FILES: &str =
    "its metadata.yaml names no file that is there; copy the whole folder";

/// A folder of rosbag2 that is compressed.
pub(crate) fn packed_bag(compression: &str) -> String {
    format!(
        "its metadata.yaml says that files or messages are packed with {compression}; unpack it with 'ros2 bag convert'"
    )
}

/// A file of rosbag2 that is not there.
pub(crate) fn bag_file_missing(path: &Path) -> String {
    format!("{} is named in metadata.yaml but is not there; copy the whole folder", path.display())
}

/// Raw packets instead of scans.
pub(crate) fn only_packets(topic: &str, type_name: &str) -> String {
    format!(
        "There are no LiDAR scans but raw packets on {topic} ({type_name}), which are not decoded; record the driver's \
         sensor_msgs/PointCloud2 too."
    )
}

/// No LiDAR topic.
pub(crate) const NO_SCANS: &str =
    "There are no LiDAR scans, so no map can be made; record sensor_msgs/PointCloud2.";
/// Points without times.
pub(crate) const NO_POINT_TIMES: &str = "Points carry no time, so motion within a sweep is not taken out and fast turns blur the map; switch \
     the time field on in the LiDAR driver (t, time, timestamp or offset_time).";
/// No IMU topic.
pub(crate) const NO_IMU: &str = "There is no IMU, so tilt comes from the first scan and fast turns are harder to follow; record \
     sensor_msgs/Imu at 100 Hz or more.";
/// No leg odometry and no other odometry.
pub(crate) const NO_ODOMETRY: &str = "There is no odometry beside the LiDAR, so long featureless corridors may shrink; record the robot's \
     nav_msgs/Odometry.";
/// An IMU without a static transform.
pub(crate) const NO_IMU_MOUNTING: &str = "Nothing says where the IMU sits, so it is taken to sit at the base without rotation; record /tf_static or \
     give a calibration.";
/// An odometry without a static transform.
pub(crate) const NO_ODOMETRY_MOUNTING: &str = "Nothing says where the frame of the odometry sits, so it is taken to be the base; record /tf_static or \
     give a calibration.";

/// A recording without messages.
pub(crate) const NO_MESSAGES: &str = "it has no messages at all; record or copy it again";

/// Characters of a list of topics in a sentence, at most.
const MAX_LIST_CHARS: usize = 400;

/// A list of topics, cut where it is too long for a sentence.
pub(crate) fn list_of(topics: &[impl AsRef<str>]) -> String {
    let all: Vec<&str> = topics.iter().map(AsRef::as_ref).collect();
    vocab::legible(&all.join(", "), MAX_LIST_CHARS)
}

/// A recording with other topics only.
pub(crate) fn no_scans_among(topics: &str) -> String {
    format!(
        "there are no LiDAR scans (sensor_msgs/PointCloud2), only {topics}; record the LiDAR's points too"
    )
}

/// Several topics that can have the same role.
pub(crate) fn several_topics(count: usize, role: &str, chosen: &str, others: &str) -> String {
    format!("{count} topics could serve as {role}; '{chosen}' has most data and is used, not {others}")
}

/// A file whose index at the end is damaged.
pub(crate) const INDEX_DAMAGED: &str =
    "the index at the end of the file is cut off or damaged; no message is lost, but opening takes longer";

/// A truncated file.
pub(crate) fn file_cut_off(at: u64, size: u64) -> String {
    format!(
        "the file is cut off or damaged at byte {at} of {size}: everything before that is used; if the recorder \
         was stopped hard this is normal, else copy the file again"
    )
}

/// A schema, channel or metadata record that cannot be read.
pub(crate) fn unreadable_declaration(at: u64, error: &dyn std::fmt::Display) -> String {
    format!("a declaration at byte {at} is unreadable and ignored: {error}")
}

/// A file that does not begin with MCAP's magic bytes.
pub(crate) const NOT_MCAP: &str = "it does not begin as an MCAP file does";
/// A folder without anything to read.
pub(crate) const NOTHING_IN_FOLDER: &str =
    "the folder holds no recording (MCAP, db3, bag) and no scans (PCD, PLY, KITTI .bin)";

/// Scans without times.
pub(crate) fn no_scan_times(folder: &Path) -> String {
    format!(
        "nothing says when the scans were taken, so 10 scans a second are assumed; put a times.txt with \
         seconds, one line a scan, into {}",
        folder.display()
    )
}

/// Scans of several formats in a folder.
pub(crate) fn several_formats(folder: &Path, used: usize, format: &str, others: usize) -> String {
    format!(
        "{} holds scans of several formats; its {used} {format} files are used, {others} others are not",
        folder.display()
    )
}

/// A block whose last message is incomplete.
pub(crate) const BLOCK_ENDS_EARLY: &str = "a block of messages ends early, its last message is lost";
/// A chunk with a wrong checksum.
pub(crate) const WRONG_CHECKSUM: &str = "the checksum of a chunk does not fit, so all its messages are lost";

/// A chunk whose stated size is too large.
pub(crate) fn chunk_too_large(bytes: u64) -> String {
    format!("a chunk claims to unpack to {bytes} bytes, which is more than is read")
}

/// A chunk of an unknown compression.
pub(crate) fn unknown_compression(name: &str) -> String {
    format!("a chunk is packed with '{name}', which is not known")
}

/// A chunk whose compressed data is damaged.
pub(crate) fn chunk_damaged(error: &dyn std::fmt::Display) -> String {
    format!("a chunk does not unpack ({error}), the rest of it is lost")
}

/// A chunk whose decompressed data is shorter than stated.
pub(crate) fn chunk_short(bytes: usize, stated: u64) -> String {
    format!("a chunk holds {bytes} of its {stated} bytes, the rest is lost")
}

/// A length that exceeds the file.
pub(crate) fn length_too_large(bytes: u64) -> String {
    format!("{bytes} bytes were announced, more than the file holds or than is read")
}

/// A failed read.
pub(crate) fn read_failed(error: &dyn std::fmt::Display) -> String {
    format!("it could not be read: {error}")
}
