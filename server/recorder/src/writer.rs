//! Writes a recording: standard MCAP with ROS 2 messages that is at the same time the journal of the stack.
//!
//! Sensor inputs are written as ROS messages, sweeps on the grid of the sensor as range images ([`scan_codec`]), and every other input unchanged to [`topics::INPUT`]. Some sensor messages cannot be restored bit
//! for bit from their ROS type, for example with a stamp outside 1970 to 2038, a point at the origin, columns of unequal length. They are written to
//! [`topics::INPUT`] too, so that reading the file always yields exactly the inputs of the stack.

use crate::error::WriteError;
use crate::topics;
use formats::cdr::Encoding;
use formats::ros::{self, Header, RosMessage};
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use messages::{Estimate, Input, Mounting, Publication, Scan, Sensor};
use ports::Segment;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use vocab::{Pose, Span, Stamp};

/// Keys of the metadata that say which part of a run a file is.
pub(crate) const RUN_KEY: &str = "run";
pub(crate) const SEGMENT_KEY: &str = "segment";
pub(crate) const CONTINUES_KEY: &str = "continues";

/// Parameters of a [`RecordingWriter`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WriterConfig {
    /// Compression of chunks. The default is that of the recorder.
    pub compression: ChunkCompression,
    /// Size at which a chunk is closed, bytes before compression. A full-resolution sweep is 1.4 MB, so a chunk holds a few of them and the small
    /// messages between them. Chosen: larger chunks compress hardly better, and lose more of a file that is cut.
    pub chunk_bytes: u64,
    /// Longest time that recorded data stays in memory, on the recording's clock. A crash loses at most the data of this time. Chosen: a second; shorter ones write more
    /// blocks that are not full.
    pub flush_interval: Span,
    /// How sweeps are written. The default keeps all of a sweep.
    pub scans: ScanMessage,
    /// Whether a flush waits until the data is on the disk. Then a power cut loses no more than a crash does. The core sets it; the default is for tools.
    pub sync: bool,
}

/// How sweeps are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ScanMessage {
    /// As range images where they are on the grid of the sensor, else as `sensor_msgs/PointCloud2`.
    #[default]
    RangeImage,
    /// As `sensor_msgs/PointCloud2`, for other programs.
    PointCloud2,
}

impl Default for WriterConfig {
    fn default() -> Self {
        Self {
            compression: ChunkCompression::default(),
            chunk_bytes: 4 << 20,
            flush_interval: Span::from_millis(1000),
            scans: ScanMessage::default(),
            sync: false,
        }
    }
}

/// Origin of a recording, written into it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecordingMeta {
    /// Name of the robot.
    pub robot: String,
    /// Source of the data, such as "simulated site b1, seed 3" or "live".
    pub origin: String,
    /// Which part of a run it is, if it is one of several files.
    pub segment: Option<Segment>,
}

/// Compression of a recording. `cargo bench -p recorder` prints the cost of each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ChunkCompression {
    /// zstd level 1: smallest files.
    #[default]
    Zstd,
    /// lz4: less CPU time than zstd.
    Lz4,
    /// No compression: least CPU time, largest files.
    None,
}

/// Writes one recording. [`RecordingWriter::finish`] completes the file. An incomplete file can be read up to the last flush.
pub struct RecordingWriter {
    path: PathBuf,
    mcap: Writer<BufWriter<File>>,
    channels: Channels,
    mounting_to_write: Option<Mounting>,
    sequence: u32,
    flush_interval: Span,
    scans: ScanMessage,
    /// The file, if flushes wait for the disk.
    synced: Option<File>,
    flushed_at: Option<Stamp>,
    /// Reused for every message.
    buffer: Vec<u8>,
}

struct Channels {
    lidar: u16,
    range_image: u16,
    imu: u16,
    legs: u16,
    external: u16,
    battery: u16,
    tf_static: u16,
    truth: u16,
    pose: u16,
    input: u16,
}

impl RecordingWriter {
    /// Creates the file and replaces a file of the same name.
    ///
    /// # Errors
    /// When the file cannot be created or written.
    pub fn create(path: &Path, meta: &RecordingMeta, mounting: &Mounting) -> Result<Self, WriteError> {
        Self::create_with(path, meta, mounting, &WriterConfig::default())
    }

    /// [`RecordingWriter::create`] with other parameters.
    ///
    /// # Errors
    /// When the file cannot be created or written.
    pub fn create_with(
        path: &Path,
        meta: &RecordingMeta,
        mounting: &Mounting,
        config: &WriterConfig,
    ) -> Result<Self, WriteError> {
        let file =
            File::create(path).map_err(|source| WriteError::Create { path: path.to_owned(), source })?;
        let synced = if config.sync { Some(synced(path, &file)?) } else { None };
        let failed = |source| WriteError::Mcap { path: path.to_owned(), source };
        let mut mcap = options(config).create(BufWriter::with_capacity(1 << 20, file)).map_err(failed)?;
        mcap.write_metadata(&metadata(meta, mounting)).map_err(failed)?;
        let channels = Channels::declare(&mut mcap).map_err(failed)?;
        Ok(Self {
            path: path.to_owned(),
            mcap,
            channels,
            mounting_to_write: Some(*mounting),
            sequence: 0,
            flush_interval: config.flush_interval,
            scans: config.scans,
            synced,
            flushed_at: None,
            buffer: Vec::new(),
        })
    }

    /// Records one input of the stack with the time `at` of its step.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn input(&mut self, at: Stamp, input: &Input) -> Result<(), WriteError> {
        self.write_mounting_once(at)?;
        self.buffer.clear();
        let channel = match input {
            Input::Sensor(Sensor::Scan(scan))
                if self.scans == ScanMessage::RangeImage && scan_codec::encode(scan, &mut self.buffer) =>
            {
                self.channels.range_image
            }
            Input::Sensor(sensor) if ros_can_hold(sensor) => self.encode_sensor(sensor),
            _ => {
                self.buffer = postcard::to_extend(input, std::mem::take(&mut self.buffer))?;
                self.channels.input
            }
        };
        self.write_buffer(channel, at)?;
        self.flush_if_due(at)
    }

    /// Records the ground truth (simulation only).
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn truth(&mut self, at: Stamp, world_from_base: &Pose) -> Result<(), WriteError> {
        self.write_pose(self.channels.truth, at, "world", world_from_base)
    }

    /// Records the estimated poses, which take little space. A replay computes all other publications.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn publication(&mut self, at: Stamp, publication: &Publication) -> Result<(), WriteError> {
        match publication {
            Publication::Estimate(Estimate { map_from_base, .. }) => {
                self.write_pose(self.channels.pose, at, "map", map_from_base)
            }
            _ => Ok(()),
        }
    }

    /// Completes the file with its index.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> Result<(), WriteError> {
        self.mcap.finish().map_err(|source| self.failed(source))?;
        self.sync()
    }

    fn encode_sensor(&mut self, sensor: &Sensor) -> u16 {
        let out = &mut self.buffer;
        match sensor {
            Sensor::Scan(scan) => {
                ros::write_scan(scan, topics::LIDAR_FRAME, Encoding::Cdr, out);
                self.channels.lidar
            }
            Sensor::Imu(sample) => {
                ros::Imu::from_sample(sample, topics::IMU_FRAME).to_bytes(Encoding::Cdr, out);
                self.channels.imu
            }
            Sensor::Legs(legs) => {
                ros::Odometry::from_legs(legs, "odom", topics::BASE_FRAME).to_bytes(Encoding::Cdr, out);
                self.channels.legs
            }
            Sensor::Odometry(external) => {
                ros::Odometry::from_external(external, "external_odom", topics::EXTERNAL_FRAME)
                    .to_bytes(Encoding::Cdr, out);
                self.channels.external
            }
            Sensor::Battery(battery) => {
                ros::BatteryState::from(battery).to_bytes(Encoding::Cdr, out);
                self.channels.battery
            }
        }
    }

    /// Writes the mounting of the sensors once, at the time of the first message, so that the recording spans its data only.
    fn write_mounting_once(&mut self, at: Stamp) -> Result<(), WriteError> {
        let Some(mounting) = self.mounting_to_write.take() else { return Ok(()) };
        let sensors = [
            (topics::LIDAR_FRAME, mounting.base_from_lidar),
            (topics::IMU_FRAME, mounting.base_from_imu),
            (topics::EXTERNAL_FRAME, mounting.base_from_external),
        ];
        let transform = |(child, pose): (&str, Option<Pose>)| {
            pose.map(|parent_from_child| ros::TransformStamped {
                header: Header { stamp: at, frame_id: topics::BASE_FRAME.into() },
                child_frame_id: child.into(),
                parent_from_child,
            })
        };
        let message = ros::TfMessage { transforms: sensors.into_iter().filter_map(transform).collect() };
        self.buffer.clear();
        message.to_bytes(Encoding::Cdr, &mut self.buffer);
        self.write_buffer(self.channels.tf_static, at)
    }

    fn write_pose(&mut self, channel: u16, at: Stamp, frame: &str, pose: &Pose) -> Result<(), WriteError> {
        self.write_mounting_once(at)?;
        self.buffer.clear();
        let header = Header { stamp: at, frame_id: frame.into() };
        ros::PoseStamped { header, pose: *pose }.to_bytes(Encoding::Cdr, &mut self.buffer);
        self.write_buffer(channel, at)
    }

    fn write_buffer(&mut self, channel_id: u16, at: Stamp) -> Result<(), WriteError> {
        // A stamp before 1970 wraps here and wraps back when read.
        let time = at.nanos() as u64;
        let header =
            MessageHeader { channel_id, sequence: self.sequence, log_time: time, publish_time: time };
        self.sequence = self.sequence.wrapping_add(1);
        let written = self.mcap.write_to_known_channel(&header, &self.buffer);
        written.map_err(|source| self.failed(source))
    }

    fn flush_if_due(&mut self, at: Stamp) -> Result<(), WriteError> {
        let since = *self.flushed_at.get_or_insert(at);
        if at - since >= self.flush_interval || at < since {
            self.flushed_at = Some(at);
            self.mcap.flush().map_err(|source| self.failed(source))?;
            self.sync()?;
        }
        Ok(())
    }

    /// Waits until what was flushed is on the disk, if that is wanted.
    fn sync(&self) -> Result<(), WriteError> {
        let synced = self.synced.as_ref().map_or(Ok(()), File::sync_data);
        synced.map_err(|source| self.failed(source.into()))
    }

    fn failed(&self, source: mcap::McapError) -> WriteError {
        WriteError::Mcap { path: self.path.clone(), source }
    }
}

/// A second handle of the file, after its name is on the disk.
fn synced(path: &Path, file: &File) -> Result<File, WriteError> {
    let directory = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    let synced = directory.map_or(Ok(()), |directory| File::open(directory)?.sync_all());
    let handle = synced.and_then(|()| file.try_clone());
    handle.map_err(|source| WriteError::Create { path: path.to_owned(), source })
}

impl Channels {
    fn declare<W: std::io::Write + std::io::Seek>(mcap: &mut Writer<W>) -> mcap::McapResult<Self> {
        let mut ros_channel = |topic: &str, type_name: &str| {
            let definition = ros::definition(type_name).unwrap_or_default();
            let ros2_name = type_name.replacen('/', "/msg/", 1);
            let schema = mcap.add_schema(&ros2_name, "ros2msg", definition.as_bytes())?;
            mcap.add_channel(schema, topic, "cdr", &latched(topic))
        };
        Ok(Self {
            lidar: ros_channel(topics::LIDAR, ros::PointCloud2::TYPE)?,
            imu: ros_channel(topics::IMU, ros::Imu::TYPE)?,
            legs: ros_channel(topics::LEGS, ros::Odometry::TYPE)?,
            external: ros_channel(topics::EXTERNAL, ros::Odometry::TYPE)?,
            battery: ros_channel(topics::BATTERY, ros::BatteryState::TYPE)?,
            tf_static: ros_channel(topics::TF_STATIC, ros::TfMessage::TYPE)?,
            truth: ros_channel(topics::TRUTH, ros::PoseStamped::TYPE)?,
            pose: ros_channel(topics::POSE, ros::PoseStamped::TYPE)?,
            range_image: {
                let (name, encoding) = (topics::RANGE_IMAGE_SCHEMA, topics::RANGE_IMAGE_ENCODING);
                let schema = mcap.add_schema(name, encoding, b"")?;
                mcap.add_channel(schema, topics::RANGE_IMAGE, encoding, &BTreeMap::new())?
            },
            input: {
                let schema = mcap.add_schema(topics::INPUT_SCHEMA, topics::INPUT_ENCODING, b"")?;
                mcap.add_channel(schema, topics::INPUT, topics::INPUT_ENCODING, &BTreeMap::new())?
            },
        })
    }
}

/// Metadata that marks a latched topic. Without it, ROS 2 players do not send the topic to late subscribers.
fn latched(topic: &str) -> BTreeMap<String, String> {
    const TRANSIENT_LOCAL: &str = "- history: 3\n  depth: 0\n  reliability: 1\n  durability: 1\n";
    let profile =
        (topic == topics::TF_STATIC).then(|| ("offered_qos_profiles".into(), TRANSIENT_LOCAL.into()));
    profile.into_iter().collect()
}

fn options(config: &WriterConfig) -> WriteOptions {
    let compression = match config.compression {
        ChunkCompression::Zstd => Some(Compression::Zstd),
        ChunkCompression::Lz4 => Some(Compression::Lz4),
        ChunkCompression::None => None,
    };
    WriteOptions::new()
        .profile("ros2")
        .library(concat!("autoinspect ", env!("CARGO_PKG_VERSION")))
        .compression(compression)
        .compression_level(1)
        // Compression on the caller's thread makes memory and bytes independent of the computer.
        .compression_threads(0)
        .chunk_size(Some(config.chunk_bytes))
}

fn metadata(meta: &RecordingMeta, mounting: &Mounting) -> mcap::records::Metadata {
    let mut entries = BTreeMap::from([
        ("robot".to_owned(), meta.robot.clone()),
        ("origin".to_owned(), meta.origin.clone()),
        ("version".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
    ]);
    // `Debug` of an f64 is the shortest text that reads back to the same bits.
    entries.extend(
        mounting.standing_height_m.map(|height| ("standing_height_m".to_owned(), format!("{height:?}"))),
    );
    if let Some(Segment { run, number, continues }) = &meta.segment {
        entries.insert(RUN_KEY.to_owned(), run.clone());
        entries.insert(SEGMENT_KEY.to_owned(), number.to_string());
        entries.insert(CONTINUES_KEY.to_owned(), continues.to_string());
    }
    mcap::records::Metadata { name: "autoinspect".into(), metadata: entries }
}

/// Whether the ROS message restores this sensor message bit for bit.
fn ros_can_hold(sensor: &Sensor) -> bool {
    Header::can_hold(sensor.stamp())
        && match sensor {
            Sensor::Scan(scan) => scan_is_plain(scan),
            // The ROS types of leg odometry, external odometry, IMU and battery keep every number.
            _ => true,
        }
}

fn scan_is_plain(scan: &Scan) -> bool {
    let count = scan.xyz.len();
    let full_or_empty = |length: usize| length == 0 || length == count;
    full_or_empty(scan.intensity.len())
        && full_or_empty(scan.offset_ns.len())
        && full_or_empty(scan.ring.len())
        && count <= (u32::MAX / 32) as usize
        && scan.xyz.iter().all(|p| p.iter().all(|c| c.is_finite()) && *p != [0.0; 3])
}
