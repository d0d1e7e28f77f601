//! Recordings of runs: range images and segments, their replay, and how much space they take.

use crate::program::{json, refused, text};
use lockstep::{Lockstep, replay};
use messages::{Command, CommandKind, Input, Mounting, Principal, Sensor};
use ports::Segment;
use recorder::{Recording, RecordingMeta, RecordingWriter, TopicSelection};
use sim::{FULL_COLUMNS, SimConfig, SiteName};
use stack::Stack;
use std::path::Path;
use uuid::Uuid;
use vocab::{ClientId, CommandId, SessionId, Span, Stamp, Twist, Vec3};

/// Lets a robot at full resolution stand and then walk. Returns its inputs and the fingerprint of what its stack did.
fn stand_and_walk() -> (Vec<(Stamp, Input)>, String) {
    let config = SimConfig { lidar_columns: FULL_COLUMNS, ..SimConfig::new(SiteName::B1, 3) };
    let mut lockstep = Lockstep::new(config, Some(SessionId(Uuid::from_u128(1))), true);
    let by = Principal::operator(ClientId(Uuid::from_u128(1)));
    let velocity = Twist { linear: Vec3::new(0.6, 0.0, 0.0), angular: Vec3::new(0.0, 0.0, 0.3) };
    for tenth in 0..70_u128 {
        let kind = match tenth {
            0 => Some(CommandKind::TakeControl { name: "Ada".to_owned() }),
            40.. => Some(CommandKind::Teleoperate(velocity)),
            _ => None,
        };
        let id = CommandId(Uuid::from_u128(tenth));
        let command = kind.map(|kind| Input::Command(Command { id, by: by.clone(), kind }));
        command.into_iter().for_each(|command| lockstep.give(command));
        lockstep.advance(lockstep.now() + Span::from_millis(100), &mut |_, _| {});
    }
    (lockstep.log().to_vec(), lockstep.digest().hex())
}

/// Writes inputs as segments of three seconds, as the platform does.
fn write_segments(folder: &Path, log: &[(Stamp, Input)]) {
    let begins = log[0].0;
    let segment_of = |at: Stamp| ((at - begins).secs_f64() / 3.0) as u32;
    for part in log.chunk_by(|(a, _), (b, _)| segment_of(*a) == segment_of(*b)) {
        let number = segment_of(part[0].0);
        let segment = Some(Segment { run: "run".to_owned(), number, continues: true });
        let meta = RecordingMeta { segment, ..RecordingMeta::default() };
        let path = folder.join(format!("{number:06}.mcap"));
        let mut writer = RecordingWriter::create(&path, &meta, &Mounting::default()).expect("created");
        part.iter().for_each(|(at, input)| writer.input(*at, input).expect("written"));
        writer.finish().expect("finished");
    }
}

#[test]
fn a_run_in_segments_of_range_images_replays_with_the_fingerprint_of_the_run() {
    let (log, fingerprint) = stand_and_walk();
    let points: Vec<usize> = log
        .iter()
        .filter_map(|(_, input)| match input {
            Input::Sensor(Sensor::Scan(scan)) => Some(scan.xyz.len()),
            _ => None,
        })
        .collect();
    assert!(
        points.iter().any(|points| *points > 50_000)
            && points.iter().any(|points| (1..=8_000).contains(points))
    );

    let dir = tempfile::tempdir().expect("temporary directory");
    write_segments(dir.path(), &log);
    let first = dir.path().join("000000.mcap");
    for path in [dir.path(), &first] {
        let recording = Recording::open_run(path, &TopicSelection::default()).expect("opens");
        let counts = |name: &str| {
            let topics = recording.info().topics;
            topics.iter().find(|topic| topic.name == name).map_or(0, |topic| topic.count)
        };
        assert_eq!(
            counts(recorder::topics::RANGE_IMAGE),
            points.len() as u64,
            "every sweep is a range image"
        );
        assert_eq!(counts(recorder::topics::LIDAR), 0);
        let read = recording.journal().expect("a journal").map(|input| input.expect("readable"));
        assert_eq!(replay(read, &mut Stack::new()).hex(), fingerprint);
        assert_eq!(json(&["replay", text(path)])["fingerprint"], fingerprint.as_str());
    }
    let later = refused(&["replay", text(&dir.path().join("000001.mcap"))]);
    assert!(later.contains("is segment 1 of its run"), "{later}");

    // Other programs get the same points.
    let converted = dir.path().join("for_ros.mcap");
    let result = json(&["convert", text(dir.path()), "--out", text(&converted)]);
    assert_eq!(
        (result["scans"].as_u64(), result["unreadable"].as_u64()),
        (Some(points.len() as u64), Some(0))
    );
    let info = json(&["info", text(&converted)]);
    let lidar = info["topics"].as_array().expect("topics").iter().find(|topic| topic["meaning"] == "lidar");
    assert_eq!(lidar.expect("a LiDAR")["type_name"], "sensor_msgs/PointCloud2");
    let again = dir.path().join("again.mcap");
    let small = json(&["convert", text(&converted), "--scans", "range-image", "--out", text(&again)]);
    let bytes = |result: &serde_json::Value| result["bytes"].as_f64().expect("bytes");
    assert!(bytes(&small) * 5.0 < bytes(&result), "{small} {result}");

    std::fs::remove_file(dir.path().join("000001.mcap")).expect("removed");
    let gap = refused(&["replay", text(&first)]);
    assert!(gap.contains("inputs are missing before segment 2"), "{gap}");
}

mod nightly {
    use crate::core_process::CoreProcess;
    use crate::fake_gateway::FakeGateway;
    use crate::program::{json, text};
    use api::{Command, Event};
    use std::fs;
    use std::path::Path;
    use vocab::{Stamp, Twist, Vec3};

    /// Robot time of a measurement, seconds.
    const DURATION_S: f64 = 60.0;

    fn bytes_in(folder: &Path) -> u64 {
        fs::read_dir(folder)
            .expect("a folder")
            .map(|entry| entry.expect("readable"))
            .map(|entry| match entry.metadata().expect("metadata") {
                metadata if metadata.is_dir() => bytes_in(&entry.path()),
                metadata => metadata.len(),
            })
            .sum()
    }

    /// Megabytes for each second of the robot's clock that the platform records at full resolution.
    fn recorded_mb_per_s(velocity: Option<Twist>) -> f64 {
        let dir = tempfile::tempdir().expect("temporary directory");
        let mut core = CoreProcess::at_full_resolution(dir.path());
        let mut gateway = FakeGateway::connect(&core.socket);
        gateway.command(Command::TakeControl { name: "Test".to_owned() });
        let mut begin: Option<Stamp> = None;
        loop {
            if let Some(velocity) = velocity {
                gateway.command(Command::Teleoperate(velocity));
            }
            let now = gateway.event(|event| match event {
                Event::Estimate(estimate) => Some(estimate.stamp),
                _ => None,
            });
            if (now - *begin.get_or_insert(now)).secs_f64() > DURATION_S {
                break;
            }
        }
        core.stop();
        let recordings = dir.path().join("recordings");
        let run =
            fs::read_dir(&recordings).expect("recordings").next().expect("a run").expect("readable").path();
        let info = json(&["info", text(&run)]);
        bytes_in(&run) as f64 * 1e-6 / info["duration"].as_f64().expect("a duration")
    }

    #[test]
    fn a_second_of_a_recording_takes_1_5_mb_walking_and_0_2_mb_standing_at_most() {
        let walk = Twist { linear: Vec3::new(0.6, 0.0, 0.0), angular: Vec3::new(0.0, 0.0, 0.3) };
        let [standing, walking] = [None, Some(walk)].map(recorded_mb_per_s);
        eprintln!("recorded: {standing:.3} MB/s standing, {walking:.3} MB/s walking");
        assert!(walking <= 1.5 && standing <= 0.2, "{standing} MB/s standing, {walking} MB/s walking");
    }
}
