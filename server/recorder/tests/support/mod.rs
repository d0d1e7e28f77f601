//! Paths of the real recordings, and synthetic recordings.

#![allow(dead_code, reason = "every test binary uses its own part")]

use messages::{BatteryState, ExternalOdometry, ImuSample, Input, LegOdometry, Mounting, Scan, Sensor};
use recorder::{Recording, RecordingMeta, RecordingWriter, TopicSelection};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vocab::{Pose, Quat, Span, Stamp, Twist, Vec3};

/// The path of a real recording; `None`, with a printed note, if it is missing.
pub fn real(relative: &str) -> Option<PathBuf> {
    let root = std::env::var_os("AUTOINSPECT_DATA")
        .map(PathBuf::from)
        .unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"));
    let path = root.join(relative);
    if !path.exists() {
        println!("skipped: {} is not here (set AUTOINSPECT_DATA)", path.display());
        return None;
    }
    Some(path)
}

/// Opens a recording with the default choice of topics.
pub fn open(path: &Path) -> Recording {
    Recording::open(path, &TopicSelection::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// A time that ROS can represent.
pub const START: Stamp = Stamp::from_parts(1_700_000_000, 5);

/// A scan with all columns.
pub fn scan(stamp: Stamp, points: usize) -> Sensor {
    Sensor::Scan(Arc::new(Scan {
        stamp,
        xyz: (0..points).map(|i| [1.0 + i as f32 * 0.01, (i % 7) as f32, -0.5]).collect(),
        intensity: (0..points).map(|i| (i % 255) as f32).collect(),
        offset_ns: (0..points).map(|i| i as i32 * 1000).collect(),
        ring: (0..points).map(|i| (i % 32) as u16).collect(),
    }))
}

/// An IMU sample at rest.
pub fn imu(stamp: Stamp) -> Sensor {
    let (angular_velocity, specific_force) = (Vec3::new(0.01, -0.02, 0.03), Vec3::new(0.1, 0.2, 9.81));
    Sensor::Imu(ImuSample { stamp, angular_velocity, specific_force })
}

/// An arbitrary pose.
pub fn pose() -> Pose {
    Pose { position: Vec3::new(0.1, -0.2, 0.35), orientation: Quat { w: 0.5, x: 0.5, y: -0.5, z: 0.5 } }
}

/// One of every kind of sensor message, 1 ms apart.
pub fn one_of_each(start: Stamp) -> Vec<Sensor> {
    let at = |millis| start + Span::from_millis(millis);
    let twist = Twist { linear: Vec3::new(0.5, 0.0, 0.1), angular: Vec3::new(0.0, 0.1, 0.2) };
    vec![
        scan(at(0), 50),
        imu(at(1)),
        Sensor::Legs(LegOdometry { stamp: at(2), base_velocity: twist, odom_from_base: pose() }),
        Sensor::Odometry(ExternalOdometry { stamp: at(3), odom_from_external: pose() }),
        Sensor::Battery(BatteryState {
            stamp: at(4),
            charge: 0.75,
            voltage_v: 48.5,
            current_a: -3.0,
            charging: false,
        }),
    ]
}

/// A mounting with the poses of all sensors.
pub fn mounting() -> Mounting {
    Mounting {
        base_from_lidar: Some(pose()),
        base_from_imu: Some(Pose { position: Vec3::new(0.0, 0.05, 0.0), ..Pose::IDENTITY }),
        base_from_external: Some(pose()),
        standing_height_m: Some(0.312_345_678_9),
    }
}

/// Writes a recording of `seconds` with one of each sensor ten times a second.
pub fn write_recording(path: &Path, seconds: i64) -> Vec<(Stamp, Input)> {
    let meta = RecordingMeta { robot: "test".into(), origin: "made by a test".into(), segment: None };
    let mut writer = RecordingWriter::create(path, &meta, &mounting()).unwrap();
    let mut written = Vec::new();
    for tenth in 0..seconds * 10 {
        let start = START + Span::from_millis(100 * tenth);
        for sensor in one_of_each(start) {
            let entry = (sensor.stamp(), Input::Sensor(sensor));
            writer.input(entry.0, &entry.1).unwrap();
            written.push(entry);
        }
        writer.truth(start, &pose()).unwrap();
    }
    writer.finish().unwrap();
    written
}
