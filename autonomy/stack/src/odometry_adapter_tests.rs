//! Messages of a standing robot in a room, and mountings that are no poses.

use super::*;
use crate::testing::{SWEEP, lidar_only, room_scan};
use messages::Mounting as PlainMounting;
use vocab::{Pose, Span, Vec3};

#[test]
fn a_standing_robot_gets_a_frame_and_then_located_scans() {
    let mut adapter = OdometryAdapter::new(&lidar_only());
    let mut events = Vec::new();
    assert!(!adapter.is_tracking());
    for number in 0..5 {
        adapter.update(&room_scan(number), &mut events);
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
