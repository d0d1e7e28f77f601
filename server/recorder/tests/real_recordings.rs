//! Compares every real recording with the counts of an independent reader.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may panic at the first error, and prints its results"
)]

mod support;

use messages::Sensor;
use recorder::{OpenError, Recording, TopicRole, TopicSelection};
use support::{open, real};

/// Asserts the number of messages of the named topics.
fn check_counts(recording: &Recording, expected: &[(&str, u64)]) {
    let info = recording.info();
    for (name, count) in expected {
        let found: Vec<u64> =
            info.topics.iter().filter(|topic| topic.name == *name).map(|topic| topic.count).collect();
        assert_eq!(found, [*count], "{name} in {info}");
    }
}

/// Numbers of scans, IMU samples, odometry messages, and points of all scans.
fn tally(recording: &Recording) -> (usize, usize, usize, usize) {
    let mut tally = (0, 0, 0, 0);
    let mut last = None;
    for item in recording.inputs() {
        let (at, sensor) = item.unwrap_or_else(|error| panic!("{error}"));
        assert!(last.is_none_or(|last| last <= at), "log order");
        last = Some(at);
        match sensor {
            Sensor::Scan(scan) => {
                tally.0 += 1;
                tally.3 += scan.xyz.len();
            }
            Sensor::Imu(_) => tally.1 += 1,
            Sensor::Legs(_) | Sensor::Odometry(_) => tally.2 += 1,
            Sensor::Battery(_) => {}
        }
    }
    tally
}

#[test]
fn a_rosbag2_folder_with_lidar_and_odometry_is_read() {
    let Some(path) = real("hilti-uzh-run2/bag") else { return };
    let recording = open(&path);
    check_counts(&recording, &[("/lidar/points", 100), ("/vo/odometry", 482), ("/tf_static", 1)]);
    assert_eq!(tally(&recording), (100, 0, 482, 1_200_000));
    let info = recording.info();
    assert!((info.duration - 49.5).abs() < 2.0, "{info}");
    let mounting = recording.mounting();
    assert_eq!(mounting.base_from_lidar, Some(vocab::Pose::IDENTITY), "the LiDAR is the base");
    let external = mounting.base_from_external.expect("the odometry's frame is the IMU's");
    assert!(external.orientation.w.abs() < 0.1, "near 180 degrees about x: {external:?}");
    assert!(info.missing.iter().any(|line| line.contains("Points carry no time")), "{info}");
    assert!(info.missing.iter().any(|line| line.contains("no IMU")), "{info}");
}

#[test]
fn an_mcap_file_with_ros1_messages_is_read() {
    let Some(path) = real("bags/ouster_ros1_in_mcap.mcap") else { return };
    let recording = open(&path);
    check_counts(&recording, &[("/os1_cloud_node/points", 2), ("/os1_cloud_node/imu", 17)]);
    let (scans, samples, _, points) = tally(&recording);
    assert_eq!((scans, samples), (2, 17));
    let scan = recording
        .inputs()
        .find_map(|item| match item {
            Ok((_, Sensor::Scan(scan))) => Some(scan),
            _ => None,
        })
        .unwrap();
    assert!(points > 50_000 && points < 2 * 64 * 2048);
    assert_eq!(scan.offset_ns.len(), scan.xyz.len());
    assert_eq!(scan.ring.iter().max(), Some(&63));
    let last = *scan.offset_ns.iter().max().unwrap();
    assert!((90_000_000..101_000_000).contains(&last), "a 10 Hz sweep lasts {last} ns");
}

#[test]
fn mcap_files_of_nav2_and_synthetic_ones_are_read() {
    if let Some(path) = real("bags/nav2_turtlebot.mcap") {
        let recording = open(&path);
        check_counts(&recording, &[("/odom", 2639), ("/tf", 5422), ("/tf_static", 1), ("/amcl_pose", 135)]);
        assert_eq!(tally(&recording), (0, 0, 2639, 0));
        assert!((recording.info().duration - 97.4).abs() < 0.1);
    }
    if let Some(path) = real("bags/all_sensor_msgs.mcap") {
        let info = open(&path).info();
        assert_eq!(info.topics.iter().map(|topic| topic.count).sum::<u64>(), 194, "{info}");
    }
}

#[test]
fn ros1_bags_are_read() {
    if let Some(path) = real("bags/tf_example.bag") {
        let recording = open(&path);
        check_counts(&recording, &[("/tf", 517), ("/tf_static", 1)]);
        assert!((recording.info().duration - 51.7).abs() < 0.1);
    }
    if let Some(path) = real("bags/turtlesim-bz2.bag") {
        let info = open(&path).info();
        assert_eq!(info.topics.iter().map(|topic| topic.count).sum::<u64>(), 8647, "{info}");
        assert!((info.duration - 21.7).abs() < 0.1, "{info}");
    }
}

#[test]
fn rosbag2_databases_are_read() {
    if let Some(path) = real("bags/tf_example_db3") {
        check_counts(&open(&path), &[("/tf", 517), ("/tf_static", 1)]);
        check_counts(&open(&path.join("tf_example.db3")), &[("/tf", 517)]);
    }
    if let Some(path) = real("hesai-xt32/1673400677802009732") {
        let info = open(&path).info();
        assert_eq!(info.topics.len(), 1);
        assert_eq!((info.topics[0].count, info.topics[0].role), (4, None));
        assert!(info.missing.iter().any(|line| line.contains("raw packets")), "{info}");
    }
}

#[test]
fn folders_of_scans_are_read() {
    if let Some(path) = real("kaist03-keyframes") {
        let recording = open(&path);
        let (scans, _, _, points) = tally(&recording);
        assert_eq!(scans, 21);
        assert!((21 * 36_000..21 * 38_000).contains(&points), "{points}");
        let first = recording.info().start.unwrap();
        assert!(first.secs_f64() > 1.5e9, "times.txt beside the folder is used, not 10 Hz: {first:?}");
    }
    if let Some(path) = real("gicp-pair") {
        let recording = open(&path);
        let mut inputs = recording.inputs();
        let points: usize = inputs
            .by_ref()
            .map(|item| match item {
                Ok((_, Sensor::Scan(scan))) => scan.xyz.len(),
                other => panic!("{other:?}"),
            })
            .sum();
        assert_eq!(points as u64 + inputs.dropped_points(), 69_792 + 69_088);
    }
}

#[test]
fn single_scans_are_read() {
    for (name, points) in [
        ("map-import/automotive_ring_timestamp_compressed.pcd", Some(80_787)),
        ("map-import/autzen-utm.pcd", None),
        ("hesai-xt32/1673400678101968885.pcd", Some(63_021)),
        ("change-rgbd-tabletop/learn37.pcd", None),
    ] {
        let Some(path) = real(name) else { continue };
        let recording = open(&path);
        let mut inputs = recording.inputs();
        let Some(Ok((_, Sensor::Scan(scan)))) = inputs.next() else { panic!("{name} holds no scan") };
        assert!(inputs.next().is_none());
        if let Some(points) = points {
            assert_eq!(scan.xyz.len() as u64 + inputs.dropped_points(), points, "{name}");
        }
        if name.contains("ring_timestamp") {
            assert!(scan.ring.len() == scan.xyz.len() && scan.offset_ns.len() == scan.xyz.len());
            let span = scan.offset_ns.iter().max().unwrap() - scan.offset_ns.iter().min().unwrap();
            assert!((50_000_000..210_000_000).contains(&span), "{span} ns");
        }
    }
}

#[test]
fn bags_of_two_sessions_are_read() {
    for session in ["session_a", "session_b"] {
        let Some(path) = real(&format!("change-lidar-inserted/{session}")) else { continue };
        let (scans, _, odometry, points) = tally(&open(&path));
        assert_eq!((scans, odometry, points), (35, 35, 35 * 9000));
    }
}

#[test]
fn a_message_with_absolute_point_times_is_read() {
    let Some(path) = real("bags/pointcloud2_cdr_message.bin") else { return };
    let bytes = std::fs::read(path).unwrap();
    let cloud = formats::ros::PointCloud2::from_bytes(formats::cdr::Encoding::Cdr, &bytes).unwrap();
    assert_eq!(cloud.table.len(), 64_000);
    let (scan, report) = cloud.table.to_scan(Some(cloud.header.stamp)).unwrap();
    assert_eq!(scan.xyz.len() + report.dropped.total(), 64_000);
    let (first, last) = (scan.offset_ns.iter().min().unwrap(), scan.offset_ns.iter().max().unwrap());
    // Its points span half a rotation at 10 Hz.
    assert!((45_000_000..55_000_000).contains(&(last - first)), "{first} to {last} ns");
}

#[test]
fn other_files_are_rejected_as_recordings() {
    for name in [
        "map-import/simple.las",
        "map-import/indoor.laz",
        "map-import/bunnyFloat.e57",
        "map-import/1.2-with-color.ptx",
        "map-import/malformed/corrupt_crc.e57",
        "map-import/malformed/read_error.e57",
        "map-import/malformed/garbage_nVariableLength.las",
        "map-import/malformed/spurious.las",
        "map-import/malformed/bad-geotiff-keys.las",
        "hesai-xt32/xt32_derived.pcap",
        "pose-graphs/intel.g2o",
        "trajectories",
    ] {
        let Some(path) = real(name) else { continue };
        match Recording::open(&path, &TopicSelection::default()) {
            Err(error @ OpenError::NotARecording { .. }) => println!("{error}"),
            Err(error) => panic!("{name}: {error}"),
            Ok(recording) => panic!("{name} opened as {}", recording.info()),
        }
    }
}

#[test]
fn a_role_can_be_assigned_another_topic() {
    let Some(path) = real("hilti-uzh-run2/bag") else { return };
    let mut selection = TopicSelection::default();
    selection.choose("legs=/vo/odometry").unwrap();
    let recording = Recording::open(&path, &selection).unwrap();
    let used = recording.info().topics.into_iter().find(|topic| topic.name == "/vo/odometry").unwrap();
    assert_eq!(used.role, Some(TopicRole::Legs));
    selection.choose("lidar=/nowhere").unwrap();
    let error = Recording::open(&path, &selection).err().unwrap().to_string();
    assert!(error.contains("/lidar/points"), "names the existing topics: {error}");
    selection.choose("lidar=/vo/odometry").unwrap();
    assert!(matches!(Recording::open(&path, &selection), Err(OpenError::WrongTopicType { .. })));
}
