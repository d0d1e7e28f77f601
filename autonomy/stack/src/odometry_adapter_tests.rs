//! Messages of a standing robot in a room, and mountings that are no poses.

use super::*;
use messages::{Mounting as PlainMounting, Scan, Sources as PlainSources};
use vocab::{Pose, Span, Vec3};

const SWEEP: Span = Span::from_millis(100);

/// A scan of a closed room of 8 m by 6 m by 3 m, taken in its middle.
fn scan(number: i64) -> Sensor {
    let mut xyz = Vec::new();
    for row in -30..=30_i16 {
        for column in -30..=30_i16 {
            let (a, b) = (f32::from(row) / 30.0, f32::from(column) / 30.0);
            xyz.extend([[4.0, 3.0 * a, 1.5 * b], [-4.0, 3.0 * a, 1.5 * b]]);
            xyz.extend([[4.0 * a, 3.0, 1.5 * b], [4.0 * a, -3.0, 1.5 * b]]);
            xyz.extend([[4.0 * a, 3.0 * b, 1.5], [4.0 * a, 3.0 * b, -1.5]]);
        }
    }
    let stamp = Stamp::from_parts(10, 0) + Span::from_nanos(SWEEP.nanos() * number);
    let intensity = vec![7.0; xyz.len()];
    let last = xyz.len() as i64 - 1;
    let offset_ns = (0..=last).map(|index| (SWEEP.nanos() * index / last) as i32).collect();
    Sensor::Scan(Arc::new(Scan { stamp, xyz, intensity, offset_ns, ring: Vec::new() }))
}

fn lidar_only() -> BootRecord {
    let sources = PlainSources { lidar: true, imu: false, legs: false, external: false };
    BootRecord { sources, ..BootRecord::default() }
}

#[test]
fn a_standing_robot_gets_a_frame_and_then_located_scans() {
    let mut adapter = OdometryAdapter::new(&lidar_only());
    let mut events = Vec::new();
    assert!(!adapter.is_tracking());
    for number in 0..5 {
        adapter.update(&scan(number), &mut events);
    }
    adapter.flush(&mut events);
    assert!(adapter.is_tracking());
    assert!(matches!(events.first(), Some(OdometryEvent::FrameReset)), "the frame comes first");
    let scans: Vec<&LocatedScan> = events
        .iter()
        .filter_map(|event| match event {
            OdometryEvent::Scan(located) => Some(located.as_ref()),
            _ => None,
        })
        .collect();
    assert!(scans.len() >= 4, "{} scans", scans.len());
    for located in &scans {
        assert!(located.odom_from_base.translation.vector.norm() < 0.02, "{:?}", located.odom_from_base);
        assert_eq!(located.stamp - located.scan_stamp, SWEEP, "the pose is that of the sweep's end");
        assert_eq!(located.cloud.xyz.len(), located.cloud.intensity.len());
    }
    let last = scans[scans.len() - 1];
    let predicted = adapter.predict(last.stamp + Span::from_millis(50), last);
    assert!(predicted.stamp > last.stamp);
    assert_eq!(predicted.scan_stamp, last.scan_stamp, "the scan stays the same");
    assert!(Arc::ptr_eq(&predicted.cloud, &last.cloud));
}

#[test]
fn a_mounting_that_is_no_pose_is_a_finding() {
    let not_finite = Pose { position: Vec3::new(f64::NAN, 0.0, 0.0), ..Pose::IDENTITY };
    let mut record = lidar_only();
    assert_eq!(OdometryAdapter::mounting_findings(&record), []);
    record.mounting = PlainMounting {
        base_from_lidar: Some(Pose::IDENTITY),
        base_from_imu: Some(not_finite),
        ..PlainMounting::default()
    };
    let findings = OdometryAdapter::mounting_findings(&record);
    assert_eq!(findings.len(), 1, "{findings:?}");
    assert_eq!(findings[0].what, texts::mounting_not_finite("IMU"));
    assert_eq!(findings[0].severity, Severity::Error);
}
