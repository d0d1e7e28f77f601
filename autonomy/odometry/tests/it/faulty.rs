//! Faulty sensors and setups. Each fault must be reported. None may cause a panic or impair the other sensors.

use crate::support::{b1, config, feed, poses, run};
use geometry::{Isometry, Transform, Vector3};
use messages::Sensor;
use odometry::{FindingKind, Odometry, OdometryConfig, OdometryEvent, ScanView};
use std::sync::Arc;
use vocab::{Span, Stamp, Vec3};

fn kinds(events: &[OdometryEvent]) -> Vec<FindingKind> {
    let kind = |event: &OdometryEvent| match event {
        OdometryEvent::Finding(finding) => {
            assert!(finding.what.ends_with('.') && finding.remedy.ends_with('.'), "{finding:?}");
            Some(finding.kind)
        }
        _ => None,
    };
    events.iter().filter_map(kind).collect()
}

/// The first messages of the walk, with changed IMU readings.
fn with_imu(count: usize, change: impl Fn(&mut messages::ImuSample)) -> impl Iterator<Item = Sensor> {
    b1().messages.iter().take(count).cloned().map(move |mut message| {
        if let Sensor::Imu(imu) = &mut message {
            change(imu);
        }
        message
    })
}

#[test]
fn an_imu_mounted_upside_down_is_reported() {
    let mut upside_down = config(b1(), &[]);
    let half_turn = Isometry::rotation(Vector3::x() * std::f64::consts::PI);
    let upright = upside_down.mounting.base_from_imu;
    upside_down.mounting.base_from_imu = Transform::new(half_turn * upright.isometry());
    let events = run(upside_down, with_imu(2_000, |_| {}));
    assert!(kinds(&events).contains(&FindingKind::MountingTilted));
}

#[test]
fn an_accelerometer_in_multiples_of_gravity_is_reported() {
    let events = run(
        config(b1(), &[]),
        with_imu(2_000, |imu| {
            let scale = 1.0 / 9.80665;
            let force = imu.specific_force;
            imu.specific_force = Vec3::new(force.x * scale, force.y * scale, force.z * scale);
        }),
    );
    assert!(kinds(&events).contains(&FindingKind::GravityImplausible));
}

#[test]
fn a_saturated_gyroscope_is_reported_and_tolerated() {
    let events = run(
        config(b1(), &[]),
        with_imu(12_000, |imu| {
            // The gyroscope's range ends at two turns a second. A shock reaches it once a second.
            if imu.stamp.nanos() % 1_000_000_000 < 12_000_000 {
                imu.angular_velocity.y = 12.566;
            }
        }),
    );
    assert!(kinds(&events).contains(&FindingKind::ImuSaturated));
    let error = b1().error(&poses(&events));
    assert!(error < 0.05, "{error}");
}

#[test]
fn clocks_without_common_time_are_reported_and_the_lidar_goes_on() {
    let events = run(
        config(b1(), &["lidar", "imu"]),
        with_imu(14_000, |imu| imu.stamp += Span::from_millis(86_400_000)),
    );
    assert_eq!(kinds(&events), [FindingKind::ClocksApart]);
    let found = poses(&events);
    assert!(found.len() > 150 && b1().error(&found) < 0.1);
}

#[test]
fn a_lagging_imu_is_reported() {
    let events = run(config(b1(), &[]), with_imu(usize::MAX, |imu| imu.stamp += Span::from_millis(40)));
    assert_eq!(kinds(&events), [FindingKind::ImuLag]);
}

#[test]
fn missing_point_times_are_reported() {
    let untimed = b1().messages.iter().take(2_000).map(|message| match message {
        Sensor::Scan(scan) => {
            Sensor::Scan(Arc::new(messages::Scan { offset_ns: Vec::new(), ..(**scan).clone() }))
        }
        other => other.clone(),
    });
    assert_eq!(kinds(&run(config(b1(), &[]), untimed)), [FindingKind::MissingPointTimes]);
}

#[test]
fn stamps_that_go_backwards_are_reported_and_ignored() {
    let mut messages: Vec<Sensor> = b1().messages.iter().take(6_000).cloned().collect();
    messages.swap(3_000, 3_050);
    let events = run(config(b1(), &[]), messages.into_iter());
    assert_eq!(kinds(&events), [FindingKind::StampsBackwards]);
    assert!(b1().error(&poses(&events)) < 0.01);
}

#[test]
fn a_source_that_falls_silent_is_reported() {
    let until = b1().messages[0].stamp() + Span::from_millis(5_000);
    let messages =
        b1().messages.iter().filter(|m| !matches!(m, Sensor::Imu(_)) || m.stamp() < until).take(4_000);
    assert_eq!(kinds(&run(config(b1(), &[]), messages.cloned())), [FindingKind::SourceSilent]);
}

#[test]
fn invalid_input_neither_panics_nor_moves_the_robot() {
    let mut odometry = Odometry::new(OdometryConfig::default());
    let mut out = Vec::new();
    let nan = f32::NAN;
    let scans: [(&[[f32; 3]], &[i32]); 5] = [
        (&[], &[]),
        (&[[nan, nan, nan]; 3], &[0, 1, 2]),
        (&[[1e30, 1.0, 1.0], [f32::INFINITY, 0.0, 0.0]], &[i32::MIN, i32::MAX]),
        (&[[1.0, 1.0, 1.0]; 500], &[5]),
        (&[[2.0, 0.0, 0.0]; 500], &[0; 500]),
    ];
    for (index, (xyz, offset_ns)) in scans.into_iter().enumerate() {
        let stamp = Stamp::from_nanos(1_000_000_000 + index as i64 * 5_000_000_000);
        odometry.insert_scan(ScanView { stamp, xyz, intensity: &[1.0], offset_ns }, &mut out);
        odometry.insert_imu(stamp, Vector3::repeat(f64::NAN), Vector3::zeros(), &mut out);
        odometry.insert_leg_velocity(stamp, [Vector3::repeat(f64::INFINITY), Vector3::zeros()], &mut out);
        odometry.insert_leg_velocity(stamp, [Vector3::zeros(), Vector3::repeat(f64::NAN)], &mut out);
        odometry.insert_external_pose(stamp, Isometry::translation(f64::NAN, 0.0, 0.0), &mut out);
    }
    odometry.insert_scan(
        ScanView { stamp: Stamp::from_nanos(i64::MAX), xyz: &[], intensity: &[], offset_ns: &[] },
        &mut out,
    );
    odometry.insert_scan(
        ScanView { stamp: Stamp::from_nanos(i64::MIN), xyz: &[], intensity: &[], offset_ns: &[] },
        &mut out,
    );
    odometry.flush(&mut out);
    for pose in poses(&out) {
        assert!(
            pose.estimate.odom_from_base.translation.vector.norm() < 0.1,
            "{}",
            pose.estimate.odom_from_base
        );
    }
}

/// Without scans, legs and IMU are still processed.
#[test]
fn legs_and_imu_are_processed_without_scans() {
    let mut odometry = Odometry::new(config(b1(), &[]));
    let mut out = Vec::new();
    for message in b1().messages.iter().filter(|message| !matches!(message, Sensor::Scan(_))) {
        feed(&mut odometry, message, &mut out);
    }
    let last = b1().messages.last().unwrap().stamp();
    // Dead reckoning by legs and IMU has an error of a few percent of the distance.
    let estimate = odometry.predict(last);
    let truth = b1().truth_at(b1().messages[0].stamp()).inverse() * b1().truth_at(last);
    let error = (estimate.odom_from_base.translation.vector - truth.translation.vector).norm();
    assert!(error < 0.05 * 30.0, "{error}");
}
