//! Broken inputs of every kind: each gives one clear sentence, causes no panic and needs little memory.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may panic at the first error, and prints its results"
)]

mod support;

use formats::cdr::{Encoding, Writer};
use formats::ros::{self, RosMessage};
use messages::Sensor;
use proptest::prelude::*;
use recorder::{Recording, TopicSelection};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use support::{START, imu, one_of_each, open, scan, write_recording};
use vocab::{Span, Stamp};

/// Result of reading a broken input: the number of sensor messages, and every sentence.
struct Outcome {
    sensors: usize,
    sentences: Vec<String>,
}

/// Opens a recording and reads it to the end.
fn drain(path: &Path) -> Outcome {
    let mut outcome = Outcome { sensors: 0, sentences: Vec::new() };
    let recording = match Recording::open(path, &TopicSelection::default()) {
        Ok(recording) => recording,
        Err(error) => {
            outcome.sentences.push(error.to_string());
            return outcome;
        }
    };
    outcome.sentences.extend(recording.info().warnings);
    outcome.sentences.extend(recording.require_scans().err().map(|error| error.to_string()));
    for item in recording.inputs() {
        match item {
            Ok(_) => outcome.sensors += 1,
            Err(error) => outcome.sentences.push(error.to_string()),
        }
    }
    outcome
}

/// Asserts that a sentence is for people: one line of 26 to 419 bytes, without debug output.
fn assert_clear(sentence: &str) {
    assert!(!sentence.contains('\n') && sentence.len() < 420, "{sentence}");
    assert!(!sentence.contains("Err(") && !sentence.contains("Some("), "{sentence}");
    assert!(sentence.len() > 25, "{sentence}");
}

/// An MCAP file of raw messages on PointCloud2, Imu and Odometry topics.
fn mcap_of(path: &Path, messages: &[(&str, &str, Stamp, Vec<u8>)]) {
    let file = std::io::BufWriter::new(fs::File::create(path).unwrap());
    let mut writer = mcap::WriteOptions::new().profile("ros2").create(file).unwrap();
    for (topic, type_name, at, data) in messages {
        let schema = writer.add_schema(type_name, "ros2msg", b"").unwrap();
        let channel_id = writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap();
        let time = at.nanos() as u64;
        let header =
            mcap::records::MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
}

/// A PointCloud2 of x, y, z with the given header fields, which may contradict the data.
fn cloud(width: u32, datatype: u8, step: u32, data: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut writer = Writer::new(Encoding::Cdr, &mut out);
    writer.i32(START.parts().0 as i32);
    writer.u32(0);
    writer.string("lidar");
    writer.u32(1);
    writer.u32(width);
    writer.u32(3);
    for (i, name) in ["x", "y", "z"].iter().enumerate() {
        writer.string(name);
        writer.u32(4 * i as u32);
        writer.u8(datatype);
        writer.u32(1);
    }
    writer.u8(0);
    writer.u32(step);
    writer.u32(step.wrapping_mul(width));
    writer.byte_sequence(data.len(), |out| out.extend_from_slice(data));
    writer.u8(1);
    out
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn cdr(message: &impl RosMessage) -> Vec<u8> {
    let mut out = Vec::new();
    message.to_bytes(Encoding::Cdr, &mut out);
    out
}

const CLOUD: &str = "sensor_msgs/msg/PointCloud2";

/// Name, function that writes the input, and text that the sentence must contain.
type Case = (&'static str, fn(&Path), &'static str);

const CASES: [Case; 28] = [
    ("empty.mcap", |p| fs::write(p, b"").unwrap(), "empty"),
    ("text.mcap", |p| fs::write(p, b"hello, this is not a recording").unwrap(), "not a recording"),
    ("magic_only.mcap", |p| fs::write(p, mcap::MAGIC).unwrap(), "cut off"),
    ("half.mcap", |p| cut(p, 0.5), "cut off"),
    ("last_byte.mcap", |p| cut(p, 0.999), "cut off"),
    ("absurd_record.mcap", |p| absurd_record(p, 4), "cut off"),
    ("absurd_chunk.mcap", |p| absurd_record(p, 6), "cut off"),
    ("flipped_chunk.mcap", flip_chunk, "lost"),
    (
        "no_lidar.mcap",
        |p| one_message(p, "/imu", "sensor_msgs/msg/Imu", cdr(&ros::Imu::default())),
        "no LiDAR",
    ),
    ("no_messages.mcap", |p| mcap_of(p, &[]), "no messages"),
    ("zero_points.mcap", |p| one_message(p, "/points", CLOUD, cloud(0, 7, 12, &[])), "no usable point"),
    (
        "nan_points.mcap",
        |p| one_message(p, "/points", CLOUD, cloud(2, 7, 12, &floats(&[f32::NAN; 6]))),
        "2 were not finite",
    ),
    ("unknown_type.mcap", |p| one_message(p, "/points", CLOUD, cloud(1, 99, 12, &[0; 12])), "data type 99"),
    ("field_too_far.mcap", |p| one_message(p, "/points", CLOUD, cloud(1, 8, 12, &[0; 12])), "field 'z'"),
    ("absurd_width.mcap", |p| one_message(p, "/points", CLOUD, cloud(u32::MAX, 7, 12, &[0; 12])), "cut off"),
    ("zero_step.mcap", |p| one_message(p, "/points", CLOUD, cloud(1 << 31, 7, 0, &[])), "field 'x'"),
    ("no_cdr.mcap", |p| one_message(p, "/points", CLOUD, vec![9; 40]), "CDR"),
    ("short_message.mcap", |p| one_message(p, "/points", CLOUD, vec![0, 1, 0, 0, 1]), "cut off"),
    ("backward.mcap", backward, "goes back in time"),
    ("empty.bag", |p| fs::write(p, b"").unwrap(), "empty"),
    ("old.bag", |p| fs::write(p, b"#ROSBAG V1.2\nxxxx").unwrap(), "rosbag fix"),
    ("cut.bag", |p| fs::write(p, b"#ROSBAG V2.0\n\x45\0\0\0\x10\0\0\0index_pos").unwrap(), "cut off"),
    ("header_only.db3", |p| fs::write(p, b"SQLite format 3\0rest is missing").unwrap(), "database"),
    (
        "bad_header.pcd",
        |p| fs::write(p, "# .PCD v0.7\nFIELDS x y z\nSIZE 4 4\nDATA ascii\n").unwrap(),
        "FIELDS",
    ),
    ("absurd.pcd", absurd_pcd, "absurd.pcd"),
    ("no_xyz.ply", |p| fs::write(p, NO_XYZ).unwrap(), "field 'x'"),
    ("absurd.ply", |p| fs::write(p, ABSURD_PLY).unwrap(), "absurd.ply"),
    ("partial.bin", |p| fs::write(p, [0; 17]).unwrap(), "partial.bin"),
];

const NO_XYZ: &str = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float a\nend_header\n1\n";
const ABSURD_PLY: &str = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n\
                          property float y\nproperty float z\nend_header\nabc";

fn cut(path: &Path, share: f64) {
    write_recording(path, 2);
    let bytes = fs::read(path).unwrap();
    fs::write(path, &bytes[..(bytes.len() as f64 * share) as usize]).unwrap();
}

fn absurd_record(path: &Path, opcode: u8) {
    let mut bytes = mcap::MAGIC.to_vec();
    bytes.push(opcode);
    bytes.extend((u64::MAX - 3).to_le_bytes());
    bytes.extend([7; 100]);
    fs::write(path, bytes).unwrap();
}

/// Changes a byte in the middle of the first compressed chunk; the index stays valid.
fn flip_chunk(path: &Path) {
    write_recording(path, 1);
    let mut bytes = fs::read(path).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let chunk = &summary.chunk_indexes[0];
    let middle = (chunk.compressed_data_offset().unwrap() + chunk.compressed_size / 2) as usize;
    bytes[middle..middle + 8].fill(0xff);
    fs::write(path, bytes).unwrap();
}

fn one_message(path: &Path, topic: &str, type_name: &str, data: Vec<u8>) {
    mcap_of(path, &[(topic, type_name, START, data)]);
}

fn backward(path: &Path) {
    let sample = |stamp: Stamp| {
        let Sensor::Imu(sample) = imu(stamp) else { unreachable!("imu() makes one") };
        cdr(&ros::Imu::from_sample(&sample, "imu"))
    };
    let entry = |log: i64, stamp: i64| {
        let at = |millis| START + Span::from_millis(millis);
        ("/imu", "sensor_msgs/msg/Imu", at(log), sample(at(stamp)))
    };
    mcap_of(path, &[entry(0, 0), entry(10, 10), entry(20, 5), entry(30, 30)]);
}

fn absurd_pcd(path: &Path) {
    let header = "# .PCD v0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 4000000000\nHEIGHT 1\n\
                  POINTS 4000000000\nDATA binary\nabc";
    fs::write(path, header).unwrap();
}

#[test]
fn every_malformed_input_gives_a_clear_sentence_and_little_memory() {
    let folder = tempfile::tempdir().unwrap();
    for (name, make, mention) in CASES {
        let path = folder.path().join(name);
        make(&path);
        let outcome = drain(&path);
        println!("{name}: {}", outcome.sentences.join(" | "));
        outcome.sentences.iter().for_each(|sentence| assert_clear(sentence));
        let mentioned = outcome.sentences.iter().any(|sentence| sentence.contains(mention));
        assert!(mentioned, "{name} should mention '{mention}': {:?}", outcome.sentences);
    }
    assert_little_memory();
}

/// Asserts a peak memory below 400 MiB. Allocating by a wrong count would need gigabytes.
fn assert_little_memory() {
    let Ok(status) = fs::read_to_string("/proc/self/status") else {
        println!("skipped: this system has no /proc/self/status to read the peak memory from");
        return;
    };
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or_default();
    let kib: u64 = peak.split_whitespace().next().and_then(|word| word.parse().ok()).unwrap_or(0);
    assert!(kib < 400 * 1024, "peak memory was {kib} KiB");
}

#[test]
fn errors_for_folders_without_recordings_name_the_expected_files() {
    let folder = tempfile::tempdir().unwrap();
    let said = |path: &Path| drain(path).sentences.join(" | ");
    assert!(said(folder.path()).contains("no scans"), "{}", said(folder.path()));
    assert!(said(&folder.path().join("nowhere")).contains("could not be opened"));
    fs::write(folder.path().join("metadata.yaml"), "relative_file_paths:\n  - gone.mcap\n").unwrap();
    assert!(said(folder.path()).contains("no file that is there"));
    fs::write(folder.path().join("metadata.yaml"), "compression_format: zstd\n").unwrap();
    assert!(said(folder.path()).contains("ros2 bag convert"));
}

#[test]
fn split_bags_are_read_in_order_and_a_missing_part_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    write_recording(&folder.path().join("a_0.mcap"), 1);
    fs::write(
        folder.path().join("metadata.yaml"),
        "relative_file_paths:\n  - a_0.mcap\n  - a_1.mcap\ncompression_format: \"\"\n",
    )
    .unwrap();
    let outcome = drain(folder.path());
    assert_eq!(outcome.sensors, 50);
    assert!(outcome.sentences[0].contains("a_1.mcap"), "{:?}", outcome.sentences);
}

/// A small recording with one message of each kind.
fn small_recording(folder: &Path) -> PathBuf {
    let path = folder.join("small.mcap");
    let meta = recorder::RecordingMeta::default();
    let mut writer = recorder::RecordingWriter::create(&path, &meta, &support::mounting()).unwrap();
    for second in 0..3 {
        for sensor in one_of_each(START + Span::from_millis(1000 * second)) {
            writer.input(sensor.stamp(), &messages::Input::Sensor(sensor)).unwrap();
        }
    }
    writer.finish().unwrap();
    path
}

#[test]
fn a_recording_cut_at_any_byte_gives_its_complete_messages() {
    let folder = tempfile::tempdir().unwrap();
    let whole = small_recording(folder.path());
    let all: Vec<_> = open(&whole).journal().unwrap().map(Result::unwrap).collect();
    let bytes = fs::read(&whole).unwrap();
    let cut_path = folder.path().join("cut.mcap");
    let mut best = 0;
    for cut in 0..bytes.len() {
        fs::write(&cut_path, &bytes[..cut]).unwrap();
        let Ok(recording) = Recording::open(&cut_path, &TopicSelection::default()) else {
            assert!(cut < mcap::MAGIC.len(), "cut at {cut}");
            continue;
        };
        assert!(!recording.info().warnings.is_empty(), "cut at {cut} unnoticed");
        let read: Vec<_> = match recording.journal() {
            Ok(journal) => journal.filter_map(Result::ok).collect(),
            Err(_) => Vec::new(),
        };
        assert_eq!(read, all[..read.len()], "cut at {cut}");
        assert!(read.len() >= best, "cut at {cut}: fewer messages than from a shorter file");
        best = read.len();
    }
    assert_eq!(best, all.len(), "without its summary nothing is lost");
}

#[test]
fn a_name_of_random_bytes_is_shown_short_and_on_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = small_recording(folder.path());
    let mut bytes = fs::read(&path).unwrap();
    let name = bytes.windows(8).position(|window| window == b"\x04\0\0\0zstd").unwrap();
    // The length of the compression's name now reaches into the compressed data.
    bytes[name] = 120;
    bytes[name + 9] = b'\n';
    fs::write(&path, bytes).unwrap();
    let outcome = drain(&path);
    assert!(outcome.sentences.iter().any(|s| s.contains("is packed with")), "{:?}", outcome.sentences);
    outcome.sentences.iter().for_each(|sentence| assert_clear(sentence));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_recording_with_any_bytes_changed_never_panics(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8)
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = small_recording(folder.path());
        let mut bytes = fs::read(&path).unwrap();
        for (index, value) in changes {
            let at = index.index(bytes.len());
            bytes[at] = value;
        }
        fs::write(&path, bytes).unwrap();
        drain(&path).sentences.iter().for_each(|sentence| assert_clear(sentence));
    }
}

#[test]
fn scans_that_overlap_in_time_come_in_log_order() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.mcap");
    let file = std::io::BufWriter::new(fs::File::create(&path).unwrap());
    // Small chunks written out of order: 3, 1, 2, 0, 7, 5, 6, 4 ...
    let mut writer = mcap::WriteOptions::new().chunk_size(Some(600)).create(file).unwrap();
    let schema = writer.add_schema(CLOUD, "ros2msg", b"").unwrap();
    let channel_id = writer.add_channel(schema, "/points", "cdr", &BTreeMap::new()).unwrap();
    for i in (0..40i64).map(|i| i / 4 * 4 + [3, 1, 2, 0][(i % 4) as usize]) {
        let Sensor::Scan(scan) = scan(START + Span::from_millis(i), 5) else {
            unreachable!("scan() makes one")
        };
        let mut data = Vec::new();
        ros::write_scan(&scan, "lidar", Encoding::Cdr, &mut data);
        let time = scan.stamp.nanos() as u64;
        let header =
            mcap::records::MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, &data).unwrap();
    }
    writer.finish().unwrap();
    let times: Vec<Stamp> = open(&path).inputs().map(|item| item.unwrap().0).collect();
    assert_eq!(times.len(), 40);
    assert!(times.is_sorted());
}
