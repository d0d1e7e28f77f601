//! The recording is the journal: every input of the stack is read back bit for bit and in order.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may panic at the first error, and prints its results"
)]

mod support;

use formats::cdr::Encoding;
use messages::{
    ActionOutcome, BatteryState, BootRecord, Command, CommandKind, ExternalOdometry, GoalKind, ImuSample,
    Input, JobDone, JobResult, LegOdometry, Principal, RobotProfile, Scan, Sensor, Sources,
};
use ports::Segment;
use proptest::prelude::*;
use recorder::{
    ReadError, Recording, RecordingMeta, RecordingWriter, ScanMessage, TopicRole, TopicSelection,
    WriterConfig,
};
use std::path::Path;
use std::sync::Arc;
use support::{START, mounting, one_of_each, open, pose, scan, write_recording};
use uuid::Uuid;
use vocab::{
    ActionCallId, ClientId, CommandId, GoalId, MapId, Pose, Quat, SessionId, Span, Stamp, Twist, Vec3,
};

/// Encoded for comparison, because NaN does not equal itself.
fn bytes(entry: &(Stamp, Input)) -> Vec<u8> {
    postcard::to_stdvec(entry).unwrap()
}

fn write(path: &Path, entries: &[(Stamp, Input)]) {
    let mut writer = RecordingWriter::create(path, &RecordingMeta::default(), &mounting()).unwrap();
    for (at, input) in entries {
        writer.input(*at, input).unwrap();
        writer.truth(*at, &pose()).unwrap();
    }
    writer.finish().unwrap();
}

fn read(recording: &Recording) -> Vec<(Stamp, Input)> {
    recording.journal().unwrap().map(|entry| entry.unwrap_or_else(|error| panic!("{error}"))).collect()
}

fn any_f64() -> impl Strategy<Value = f64> {
    any::<u64>().prop_map(f64::from_bits)
}

fn any_f32() -> impl Strategy<Value = f32> + Clone {
    any::<u32>().prop_map(f32::from_bits)
}

fn any_vec3() -> impl Strategy<Value = Vec3> {
    [any_f64(), any_f64(), any_f64()].prop_map(Vec3::from)
}

fn any_pose() -> impl Strategy<Value = Pose> {
    (any_vec3(), [any_f64(), any_f64(), any_f64(), any_f64()])
        .prop_map(|(position, [w, x, y, z])| Pose { position, orientation: Quat { w, x, y, z } })
}

fn any_twist() -> impl Strategy<Value = Twist> {
    (any_vec3(), any_vec3()).prop_map(|(linear, angular)| Twist { linear, angular })
}

/// Mostly a present time, sometimes one that ROS times cannot represent.
fn any_stamp() -> impl Strategy<Value = Stamp> {
    let today = 1_700_000_000_000_000_000i64;
    prop_oneof![8 => today..today + 10_000_000_000, 1 => any::<i64>()].prop_map(Stamp::from_nanos)
}

/// A column that is full, empty, or (rarely) of a wrong length.
fn any_column<T: std::fmt::Debug + Clone>(
    value: impl Strategy<Value = T> + Clone,
    length: usize,
) -> impl Strategy<Value = Vec<T>> {
    let wrong = length + 1;
    let sizes = prop_oneof![6 => Just(length), 2 => Just(0), 1 => Just(wrong)];
    sizes.prop_flat_map(move |size| prop::collection::vec(value.clone(), size))
}

fn any_scan() -> impl Strategy<Value = Scan> {
    let coordinate = prop_oneof![20 => -100f32..100f32, 1 => Just(0.0), 1 => any_f32()];
    let xyz = [coordinate.clone(), coordinate.clone(), coordinate];
    prop::collection::vec(xyz, 0..20).prop_flat_map(|xyz| {
        let length = xyz.len();
        let columns = (
            any_stamp(),
            any_column(any_f32(), length),
            any_column(any::<i32>(), length),
            any_column(any::<u16>(), length),
        );
        columns.prop_map(move |(stamp, intensity, offset_ns, ring)| Scan {
            stamp,
            xyz: xyz.clone(),
            intensity,
            offset_ns,
            ring,
        })
    })
}

fn any_sensor() -> impl Strategy<Value = Sensor> {
    let battery = (any_stamp(), any_f32(), any_f32(), any_f32(), any::<bool>());
    prop_oneof![
        any_scan().prop_map(|scan| Sensor::Scan(Arc::new(scan))),
        (any_stamp(), any_vec3(), any_vec3()).prop_map(|(stamp, angular_velocity, specific_force)| {
            Sensor::Imu(ImuSample { stamp, angular_velocity, specific_force })
        }),
        (any_stamp(), any_twist(), any_pose()).prop_map(|(stamp, base_velocity, odom_from_base)| {
            Sensor::Legs(LegOdometry { stamp, base_velocity, odom_from_base })
        }),
        (any_stamp(), any_pose()).prop_map(|(stamp, odom_from_external)| {
            Sensor::Odometry(ExternalOdometry { stamp, odom_from_external })
        }),
        battery.prop_map(|(stamp, charge, voltage_v, current_a, charging)| {
            Sensor::Battery(BatteryState { stamp, charge, voltage_v, current_a, charging })
        }),
    ]
}

fn any_uuid() -> impl Strategy<Value = Uuid> {
    any::<u128>().prop_map(Uuid::from_u128)
}

fn any_command_kind() -> impl Strategy<Value = CommandKind> {
    prop_oneof![
        any::<String>().prop_map(|name| CommandKind::TakeControl { name }),
        any_uuid().prop_map(|id| CommandKind::StartMapping(SessionId(id))),
        (any_uuid(), any::<String>())
            .prop_map(|(id, name)| CommandKind::FinishMapping { map: MapId(id), name }),
        (any_uuid(), any_uuid())
            .prop_map(|(id, map)| CommandKind::ExtendMap { session: SessionId(id), map: MapId(map) }),
        (any_uuid(), any::<bool>(), any_pose()).prop_map(|(map, is_given, at)| CommandKind::Localise {
            map: MapId(map),
            at: is_given.then_some(at)
        }),
        any_twist().prop_map(CommandKind::Teleoperate),
        (any_uuid(), any_vec3()).prop_map(|(goal, point)| CommandKind::StartGoal {
            goal: GoalId(goal),
            kind: GoalKind::WalkTo(point)
        }),
        any_uuid().prop_map(|goal| CommandKind::CancelGoal(GoalId(goal))),
        Just(CommandKind::StopMotion),
    ]
}

fn any_input() -> impl Strategy<Value = Input> {
    prop_oneof![
        4 => any_sensor().prop_map(Input::Sensor),
        1 => Just(Input::Tick),
        1 => (any_uuid(), any_uuid(), any_command_kind()).prop_map(|(id, by, kind)| {
            Input::Command(Command { id: CommandId(id), by: Principal::operator(ClientId(by)), kind })
        }),
        1 => (any::<u64>(), any_uuid()).prop_map(|(number, map)| {
            Input::JobDone(JobDone { number, result: JobResult::MapSaving(Ok(MapId(map))) })
        }),
        1 => (any::<String>(), any::<bool>()).prop_map(|(robot, imu)| {
            let sources = Sources { imu, ..Sources::default() };
            let mounting = mounting();
            let profile = RobotProfile { name: robot, ..RobotProfile::default() };
            Input::Boot(Box::new(BootRecord { profile, mounting, sources, ..BootRecord::default() }))
        }),
        1 => (any::<i64>(), any::<bool>())
            .prop_map(|(utc_ns, synchronised)| Input::WallClock { utc_ns, synchronised }),
        1 => any::<u64>().prop_map(|seq| Input::Committed { seq }),
        1 => Just(Input::GraphRequested),
        1 => (any_uuid(), any::<Option<f32>>(), any::<String>()).prop_map(|(call, progress, text)| {
            Input::ActionFeedback { call: ActionCallId(call), progress, text }
        }),
        1 => (any_uuid(), any::<String>()).prop_map(|(call, result)| Input::ActionDone {
            call: ActionCallId(call),
            outcome: ActionOutcome::Succeeded { result },
        }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_input_is_read_back_bit_for_bit_in_order(
        entries in prop::collection::vec((any_stamp(), any_input()), 0..30)
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal.mcap");
        write(&path, &entries);
        let read = read(&open(&path));
        prop_assert_eq!(read.len(), entries.len());
        for (read, written) in read.iter().zip(&entries) {
            prop_assert_eq!(bytes(read), bytes(written));
        }
    }
}

#[test]
fn a_journal_is_also_a_standard_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.mcap");
    let written = write_recording(&path, 3);
    let recording = open(&path);
    let sensors: Vec<(Stamp, Input)> = recording
        .inputs()
        .map(|item| item.unwrap())
        .map(|(at, sensor)| (at, Input::Sensor(sensor)))
        .collect();
    assert_eq!(sensors, written);
    assert_eq!(recording.mounting(), mounting());
    let truth = recording.truth().unwrap().expect("truth was written");
    assert_eq!((truth.len(), truth[0]), (30, (START, pose())));
    let info = recording.info();
    assert!(info.warnings.is_empty() && info.missing.is_empty(), "{info}");
    for role in [TopicRole::Lidar, TopicRole::Imu, TopicRole::Legs, TopicRole::External, TopicRole::Battery] {
        let topic = info.topics.iter().find(|topic| topic.role == Some(role)).unwrap();
        assert_eq!(topic.count, 30, "{info}");
        assert!((topic.hz.unwrap() - 10.0).abs() < 0.1, "{info}");
    }
}

#[test]
fn a_sweep_is_on_the_lidar_topic_unless_ros_cannot_represent_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.mcap");
    let odd = Scan { stamp: START, xyz: vec![[0.0; 3]], ..Scan::default() };
    let entries = [scan(START, 10), Sensor::Scan(Arc::new(odd))].map(|sensor| (START, Input::Sensor(sensor)));
    write(&path, &entries);
    let counts = |name: &str| {
        let topics = open(&path).info().topics;
        topics.iter().find(|topic| topic.name == name).map(|topic| topic.count)
    };
    assert_eq!((counts(recorder::topics::LIDAR), counts(recorder::topics::INPUT)), (Some(1), Some(1)));
}

/// A sweep on the grid of the sensor.
fn quantised(stamp: Stamp) -> Input {
    let Sensor::Scan(scan) = scan(stamp, 500) else { panic!("no scan") };
    let mut scan = Scan::clone(&scan);
    scan_codec::quantise(&mut scan);
    Input::Sensor(Sensor::Scan(Arc::new(scan)))
}

#[test]
fn a_sweep_on_the_grid_is_a_range_image_that_every_reader_takes_for_a_lidar() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.mcap");
    let entries: Vec<_> = (0..20)
        .map(|tenth| START + Span::from_millis(100 * tenth))
        .map(|stamp| (stamp, quantised(stamp)))
        .collect();
    write(&path, &entries);
    let recording = open(&path);
    assert_eq!(read(&recording), entries);
    let inputs: Vec<_> = recording.inputs().map(|item| item.unwrap()).collect();
    assert_eq!(inputs.len(), entries.len());
    recording.require_scans().unwrap();
    let info = recording.info();
    let lidar: Vec<_> = info.topics.iter().filter(|topic| topic.role == Some(TopicRole::Lidar)).collect();
    assert_eq!((lidar.len(), lidar[0].name.as_str(), lidar[0].count), (1, recorder::topics::RANGE_IMAGE, 20));
    assert!(info.sensors[0].contains("500 points a scan, with point times, with channels"), "{info}");

    // For other programs the same sweeps are written as PointCloud2.
    let other = folder.path().join("other.mcap");
    let config = WriterConfig { scans: ScanMessage::PointCloud2, ..WriterConfig::default() };
    let meta = RecordingMeta::default();
    let mut writer = RecordingWriter::create_with(&other, &meta, &mounting(), &config).unwrap();
    for (at, input) in &entries {
        writer.input(*at, input).unwrap();
    }
    writer.finish().unwrap();
    let topics = open(&other).info().topics;
    let counts = |name: &str| topics.iter().find(|topic| topic.name == name).map(|topic| topic.count);
    assert_eq!(counts(recorder::topics::LIDAR), Some(20));
    assert_eq!(counts(recorder::topics::RANGE_IMAGE), Some(0));
    assert_eq!(read(&open(&other)), entries);
}

/// Writes a segment with one tick each second.
fn write_segment(folder: &Path, segment: Segment, seconds: std::ops::Range<i64>) -> Vec<(Stamp, Input)> {
    let path = folder.join(format!("{:06}.mcap", segment.number));
    let meta = RecordingMeta { segment: Some(segment), ..RecordingMeta::default() };
    let mut writer = RecordingWriter::create(&path, &meta, &mounting()).unwrap();
    let entries: Vec<_> =
        seconds.map(|second| (START + Span::from_millis(1000 * second), Input::Tick)).collect();
    for (at, input) in &entries {
        writer.input(*at, input).unwrap();
    }
    writer.finish().unwrap();
    entries
}

#[test]
fn the_segments_of_a_run_are_one_journal_up_to_the_first_gap() {
    let folder = tempfile::tempdir().unwrap();
    let segment = |number, continues| Segment { run: "run".into(), number, continues };
    let mut entries = write_segment(folder.path(), segment(0, true), 0..5);
    entries.extend(write_segment(folder.path(), segment(1, true), 5..9));
    // A segment of another run in the same folder.
    write_segment(folder.path(), Segment { run: "other".into(), number: 7, continues: true }, 0..3);
    let first = folder.path().join("000000.mcap");
    let run = || Recording::open_run(&first, &TopicSelection::default()).unwrap();
    assert_eq!(read(&run()), entries);
    assert_eq!(read(&open(&first)), entries[..5], "a file is opened alone");

    write_segment(folder.path(), segment(2, false), 20..22);
    let replayed: Vec<_> = run().journal().unwrap().collect();
    assert_eq!(replayed.iter().take_while(|entry| entry.is_ok()).count(), entries.len());
    let error = replayed[entries.len()].as_ref().unwrap_err().to_string();
    assert!(error.contains("inputs are missing before segment 2 of run run"), "{error}");

    let later = open(&folder.path().join("000001.mcap"));
    assert!(matches!(later.journal().err(), Some(ReadError::NotFromBoot { .. })));
    std::fs::remove_file(folder.path().join("000001.mcap")).unwrap();
    let replayed: Vec<_> = run().journal().unwrap().collect();
    assert!(matches!(&replayed[5], Err(ReadError::MissingInputs { .. })), "{replayed:?}");
}

#[test]
fn a_recording_that_was_never_finished_is_read_up_to_the_last_flush() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.mcap");
    let mut writer = RecordingWriter::create(&path, &RecordingMeta::default(), &mounting()).unwrap();
    let mut written = Vec::new();
    for tenth in 0..25 {
        for sensor in one_of_each(START + Span::from_millis(100 * tenth)) {
            written.push((sensor.stamp(), Input::Sensor(sensor)));
            writer.input(written[written.len() - 1].0, &written[written.len() - 1].1).unwrap();
        }
    }
    // The unfinished file is what a killed recorder leaves.
    let copy = folder.path().join("killed.mcap");
    std::fs::copy(&path, &copy).unwrap();
    drop(writer);
    let recording = open(&copy);
    let read = read(&recording);
    assert!(read.len() >= written.len() * 20 / 25, "{} of {}", read.len(), written.len());
    assert_eq!(read, written[..read.len()]);
    assert!(recording.info().warnings[0].contains("cut off"), "{}", recording.info());
}

#[test]
fn other_recordings_and_unknown_versions_are_rejected_as_journals() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.mcap");
    let file = std::io::BufWriter::new(std::fs::File::create(&path).unwrap());
    let mut writer = mcap::Writer::new(file).unwrap();
    let schema = writer.add_schema("autoinspect.Input.v0", "postcard", b"").unwrap();
    let channel =
        writer.add_channel(schema, recorder::topics::INPUT, "postcard", &Default::default()).unwrap();
    let header =
        mcap::records::MessageHeader { channel_id: channel, sequence: 0, log_time: 1, publish_time: 1 };
    writer.write_to_known_channel(&header, b"?").unwrap();
    writer.finish().unwrap();
    assert!(matches!(open(&path).journal().err(), Some(ReadError::OtherJournalVersion { .. })));

    let scan_only = folder.path().join("scan.pcd");
    let mut out = Vec::new();
    formats::pcd::write(&mut out, [0.0; 3], &[[1.0, 2.0, 3.0]], &[]).unwrap();
    std::fs::write(&scan_only, out).unwrap();
    assert!(matches!(open(&scan_only).journal().err(), Some(ReadError::NotAJournal)));
}

#[test]
fn messages_have_standard_ros_types() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.mcap");
    write(&path, &[(START, Input::Sensor(scan(START, 3)))]);
    let file = std::fs::read(&path).unwrap();
    // The MCAP library's reader checks the whole file, checksums included.
    let messages: Vec<_> = mcap::MessageStream::new(&file).unwrap().map(Result::unwrap).collect();
    let cloud = messages.iter().find(|message| message.channel.topic == "/lidar/points").unwrap();
    let schema = cloud.channel.schema.as_ref().unwrap();
    assert_eq!((schema.name.as_str(), schema.encoding.as_str()), ("sensor_msgs/msg/PointCloud2", "ros2msg"));
    assert_eq!(cloud.channel.message_encoding, "cdr");
    assert_eq!(cloud.log_time, START.nanos() as u64);
    let decoded = formats::ros::PointCloud2::from_bytes(Encoding::Cdr, &cloud.data).unwrap();
    let names: Vec<&str> = decoded.table.fields().iter().map(|field| field.name.as_str()).collect();
    assert_eq!(names, ["x", "y", "z", "intensity", "t", "ring"]);
    let summary = mcap::Summary::read(&file).unwrap().expect("a finished file has a summary");
    assert!(summary.stats.is_some() && !summary.chunk_indexes[0].message_index_offsets.is_empty());
}
