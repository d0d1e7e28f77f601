//! Seeds of recordings and of ROS messages.

use crate::clouds::Seed;
use formats::cdr::Encoding;
use formats::ros::{
    self, BatteryState, Header, Imu, Odometry, PoseStamped, RosMessage, TfMessage, TransformStamped,
};
use messages::{ImuSample, Input, Mounting, Scan, Sensor};
use recorder::{RecordingMeta, RecordingWriter};
use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;
use std::sync::Arc;
use vocab::{Pose, Stamp, Vec3};

const START: Stamp = Stamp::from_parts(1_700_000_000, 5);

pub fn seeds() -> Vec<Seed> {
    [message_seeds(), mcap_seeds(), ros1_seeds(), ros2_seeds(), journal_seeds(), range_image_seeds()].concat()
}

fn scan() -> Scan {
    Scan {
        stamp: START,
        xyz: vec![[1.0, 2.0, 3.0], [0.0; 3], [f32::NAN, 1.0, 2.0]],
        intensity: vec![1.0, 2.0, 3.0],
        offset_ns: vec![0, 1_000, -2_000],
        ring: vec![0, 1, 31],
    }
}

fn imu() -> Imu {
    let sample = ImuSample {
        stamp: START,
        angular_velocity: Vec3::default(),
        specific_force: Vec3::new(0.0, 0.0, 9.81),
    };
    Imu::from_sample(&sample, "imu")
}

fn header() -> Header {
    Header { stamp: START, frame_id: "base_link".into() }
}

fn bytes_of(encoding: Encoding, message: &impl RosMessage) -> Vec<u8> {
    let mut bytes = Vec::new();
    message.to_bytes(encoding, &mut bytes);
    bytes
}

fn cloud(encoding: Encoding) -> Vec<u8> {
    let mut bytes = Vec::new();
    ros::write_scan(&scan(), "lidar", encoding, &mut bytes);
    bytes
}

fn message_seeds() -> Vec<Seed> {
    let odometry = Odometry { header: header(), child_frame_id: "base".into(), ..Odometry::default() };
    let transform = TransformStamped {
        header: header(),
        child_frame_id: "lidar".into(),
        parent_from_child: Pose::IDENTITY,
    };
    let transforms = TfMessage { transforms: vec![transform] };
    let battery = BatteryState { header: header(), percentage: 0.5, ..BatteryState::default() };
    let pose = PoseStamped { header: header(), pose: Pose::IDENTITY };
    let mut seeds = Vec::new();
    for (encoding, bit, names) in [
        (Encoding::Cdr, 0, ["imu", "odometry", "tf", "battery", "pose", "cloud"]),
        (Encoding::Ros1, 0x80, ["imu_1", "odometry_1", "tf_1", "battery_1", "pose_1", "cloud_1"]),
    ] {
        let messages = [
            bytes_of(encoding, &imu()),
            bytes_of(encoding, &odometry),
            bytes_of(encoding, &transforms),
            bytes_of(encoding, &battery),
            bytes_of(encoding, &pose),
            cloud(encoding),
        ];
        for (kind, (name, message)) in (0..).zip(names.into_iter().zip(messages)) {
            seeds.push(("cdr", name, [&[kind | bit], message.as_slice()].concat()));
        }
    }
    seeds
}

/// The same two messages in a raw file without checksums, which a fuzzer cannot correct, and in one of the platform.
fn mcap_seeds() -> Vec<Seed> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.mcap");
    let meta = RecordingMeta { robot: "seed".into(), origin: "made by a test".into(), segment: None };
    let mut own = RecordingWriter::create(&path, &meta, &Mounting::default()).unwrap();
    own.input(START, &Input::Sensor(Sensor::Scan(Arc::new(scan())))).unwrap();
    own.input(START, &Input::Tick).unwrap();
    own.truth(START, &Pose::IDENTITY).unwrap();
    own.finish().unwrap();
    let raw = |chunks: bool| {
        let mut file = Cursor::new(Vec::new());
        let options = mcap::WriteOptions::new()
            .profile("ros2")
            .compression(None)
            .use_chunks(chunks)
            .calculate_chunk_crcs(false)
            .calculate_data_section_crc(false)
            .calculate_summary_section_crc(false);
        let mut writer = options.create(&mut file).unwrap();
        for (topic, kind, data) in [
            ("/points", "sensor_msgs/msg/PointCloud2", cloud(Encoding::Cdr)),
            ("/imu", "sensor_msgs/msg/Imu", bytes_of(Encoding::Cdr, &imu())),
        ] {
            let schema = writer.add_schema(kind, "ros2msg", b"").unwrap();
            let channel_id = writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap();
            let time = START.nanos() as u64;
            let header =
                mcap::records::MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
            writer.write_to_known_channel(&header, &data).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        file.into_inner()
    };
    let chunked = raw(true);
    // Without its summary it is scanned from the start.
    let cut = chunked[..chunked.len() / 2].to_vec();
    vec![
        ("recording", "own", fs::read(path).unwrap()),
        ("recording", "chunked", chunked),
        ("recording", "loose", raw(false)),
        ("recording", "cut", cut),
    ]
}

/// A record of a ROS 1 bag.
fn record(fields: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let mut header = Vec::new();
    for (name, value) in fields {
        header.extend((name.len() as u32 + 1 + value.len() as u32).to_le_bytes());
        header.extend([name.as_bytes(), b"=", value].concat());
    }
    let lengths = [header.len() as u32, data.len() as u32].map(u32::to_le_bytes);
    [&lengths[0], header.as_slice(), &lengths[1], data].concat()
}

fn bag(compression: &str, pack: fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
    let connection = |number: u32, topic: &str, kind: &str| {
        let fields = record(&[("type", kind.as_bytes()), ("topic", topic.as_bytes())], &[]);
        let fields = &fields[4..fields.len() - 4];
        record(&[("op", &[7]), ("conn", &number.to_le_bytes()), ("topic", topic.as_bytes())], fields)
    };
    let message = |number: u32, data: &[u8]| {
        record(
            &[("op", &[2]), ("conn", &number.to_le_bytes()), ("time", &1_700_000_000_u64.to_le_bytes())],
            data,
        )
    };
    let connections =
        [connection(0, "/points", "sensor_msgs/PointCloud2"), connection(1, "/imu", "sensor_msgs/Imu")]
            .concat();
    let content = [
        connections.clone(),
        message(0, &cloud(Encoding::Ros1)),
        message(1, &bytes_of(Encoding::Ros1, &imu())),
    ]
    .concat();
    let header = |index: u64| {
        record(
            &[
                ("op", &[3]),
                ("index_pos", &index.to_le_bytes()),
                ("conn_count", &2_u32.to_le_bytes()),
                ("chunk_count", &1_u32.to_le_bytes()),
            ],
            b"    ",
        )
    };
    let start = MAGIC.len() + header(0).len();
    let size = (content.len() as u32).to_le_bytes();
    let chunk =
        record(&[("op", &[5]), ("compression", compression.as_bytes()), ("size", &size)], &pack(&content));
    let time = 1_700_000_000_u64.to_le_bytes();
    let chunk_position = (start as u64).to_le_bytes();
    let info = record(
        &[("op", &[6]), ("chunk_pos", &chunk_position), ("start_time", &time), ("end_time", &time)],
        &[0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0],
    );
    let index = header((start + chunk.len()) as u64);
    [MAGIC, &index, &chunk, &connections, &info].concat()
}

fn ros1_seeds() -> Vec<Seed> {
    let bz2 = |content: &[u8]| {
        let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
        encoder.write_all(content).unwrap();
        encoder.finish().unwrap()
    };
    let lz4 = |content: &[u8]| {
        let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
        encoder.write_all(content).unwrap();
        encoder.finish().unwrap()
    };
    let plain = bag("none", <[u8]>::to_vec);
    let cut = plain[..plain.len() - 40].to_vec();
    vec![
        ("rosbag1", "plain", plain),
        ("rosbag1", "bz2", bag("bz2", bz2)),
        ("rosbag1", "lz4", bag("lz4", lz4)),
        ("rosbag1", "cut", cut),
    ]
}

fn ros2_seeds() -> Vec<Seed> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bag.db3");
    let connection = rusqlite::Connection::open(&path).unwrap();
    // Small pages, so that mutations reach the rows.
    connection
        .execute_batch(
            "PRAGMA page_size = 512;
             CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT);
             CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);
             INSERT INTO topics VALUES (1, '/points', 'sensor_msgs/msg/PointCloud2', 'cdr'), (2, '/imu', 'sensor_msgs/msg/Imu', 'cdr');",
        )
        .unwrap();
    for (topic, data) in [(1, cloud(Encoding::Cdr)), (2, bytes_of(Encoding::Cdr, &imu()))] {
        let insert = "INSERT INTO messages(topic_id, timestamp, data) VALUES (?1, ?2, ?3)";
        connection.execute(insert, rusqlite::params![topic, START.nanos(), data]).unwrap();
    }
    drop(connection);
    let metadata =
        "rosbag2_bagfile_information:\n  relative_file_paths:\n    - a_0.db3\n  compression_format: zstd\n";
    vec![("rosbag2", "database", fs::read(path).unwrap()), ("rosbag2", "metadata", metadata.into())]
}

/// The bytes of entries that other tests keep, by version.
fn journal_seeds() -> Vec<Seed> {
    let layouts = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recorder/tests");
    let mut seeds: Vec<Seed> = Vec::new();
    for entry in fs::read_dir(layouts).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if !name.starts_with("journal_layout") || !name.ends_with(".txt") {
            continue;
        }
        let text = fs::read_to_string(&path).unwrap();
        let mut lines = text.lines();
        let schema = lines.next().unwrap();
        let choice = recorder::journal_schemas().iter().position(|known| *known == schema).unwrap();
        for (number, line) in lines.enumerate() {
            let bytes = [vec![choice as u8], crate::messages::bytes_of_hex(line)].concat();
            seeds.push(("journal", format!("{schema}-{number:02}").leak(), bytes));
        }
    }
    assert!(seeds.len() > 50, "{}", seeds.len());
    seeds
}

/// Two columns of three channels each, with all that a scan may have, and without.
fn range_image_seeds() -> Vec<Seed> {
    let point = |number: u16| {
        let azimuth = f32::from(number / 3) * 0.01;
        [5.0 * azimuth.cos(), 5.0 * azimuth.sin(), f32::from(number % 3) * 0.2]
    };
    let mut whole = Scan {
        stamp: START,
        xyz: (0..6).map(point).collect(),
        intensity: (0..6_u16).map(f32::from).collect(),
        offset_ns: (0..6).map(|number| number / 3 * 50_000).collect(),
        ring: (0..6).map(|number| number % 3).collect(),
    };
    scan_codec::quantise(&mut whole);
    let any = Scan { intensity: vec![0.5; 6], ..whole.clone() };
    let bare = Scan { intensity: Vec::new(), offset_ns: Vec::new(), ring: Vec::new(), ..whole.clone() };
    let encoded = |scan: &Scan| {
        let mut bytes = Vec::new();
        assert!(scan_codec::encode(scan, &mut bytes));
        bytes
    };
    vec![
        ("range_image", "whole", encoded(&whole)),
        ("range_image", "any", encoded(&any)),
        ("range_image", "bare", encoded(&bare)),
    ]
}
