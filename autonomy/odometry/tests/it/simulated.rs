//! Half a minute of walking through the test hall with every useful combination of sources, LiDAR outages and a carried robot.

use crate::support::{Walk, b1, carried, config, narrow_doors, poses, run};
use geometry::Vector3;
use messages::Sensor;
use odometry::{FindingKind, OdometryEvent};
use std::sync::Arc;
use vocab::Span;

#[test]
fn all_sources_together_stay_within_millimetres() {
    let walk = b1();
    let events = run(config(walk, &[]), walk.messages.iter().cloned());
    let found = poses(&events);
    let scans = walk.messages.iter().filter(|message| matches!(message, Sensor::Scan(_))).count();
    assert_eq!(found.len(), scans);
    let error = walk.error(&found);
    assert!(error < 0.005, "{error}");
    let findings: Vec<_> = events.iter().filter(|event| matches!(event, OdometryEvent::Finding(_))).collect();
    assert!(findings.is_empty(), "{findings:?}");
    // The pose at the scan's own stamp is as accurate.
    let start = &found[200];
    let moved = found[199].estimate.odom_from_base.inverse() * start.odom_from_base_at_scan;
    let truth = walk.truth_at(found[199].estimate.stamp).inverse() * walk.truth_at(start.scan_stamp);
    assert!((moved.translation.vector - truth.translation.vector).norm() < 0.005);
}

#[test]
fn the_covariance_has_the_size_of_the_error() {
    let walk = b1();
    let found = poses(&run(config(walk, &[]), walk.messages.iter().cloned()));
    let first = &found[5].estimate;
    let site_from_odom = walk.truth_at(first.stamp) * first.odom_from_base.inverse();
    let deviation = |index: usize| found[index].estimate.covariance.fixed_view::<3, 3>(3, 3).trace().sqrt();
    let error = |index: usize| {
        let estimate = &found[index].estimate;
        let placed = site_from_odom * estimate.odom_from_base;
        (placed.translation.vector - walk.truth_at(estimate.stamp).translation.vector).norm()
    };
    let last = found.len() - 1;
    assert!(error(last) < 10.0 * deviation(last) + 0.005, "{} {}", error(last), deviation(last));
}

#[test]
fn lidar_alone_lidar_with_imu_and_lidar_with_legs_are_enough() {
    let walk = b1();
    for (sources, limit) in
        [(vec!["lidar"], 0.1), (vec!["lidar", "imu"], 0.005), (vec!["lidar", "legs"], 0.1)]
    {
        let found = poses(&run(config(walk, &sources), walk.messages.iter().cloned()));
        let error = walk.error(&found);
        assert!(error < limit, "{sources:?}: {error}");
    }
}

#[test]
fn the_lidar_alone_tracks_through_doors_into_unseen_rooms() {
    let walk = narrow_doors();
    let found = poses(&run(config(walk, &["lidar"]), walk.messages.iter().cloned()));
    let error = walk.error(&found);
    assert!(error < 0.1, "{error}");
}

#[test]
fn lost_tracking_is_reported_and_the_estimate_restarts() {
    // Ten seconds at one place, then immediately scans of another place.
    let (here, there) = (b1(), narrow_doors());
    let lidar = |message: &&Sensor| matches!(message, Sensor::Scan(_));
    let before = here.messages.iter().filter(lidar).take(100);
    let last = before.clone().last().unwrap().stamp();
    let first = there.messages.iter().find(lidar).unwrap().stamp();
    let later = (last + Span::from_millis(100)) - first;
    let after = there.messages.iter().filter(lidar).filter_map(|message| match message {
        Sensor::Scan(scan) => Some(Sensor::Scan(Arc::new(messages::Scan {
            stamp: scan.stamp + later,
            ..scan.as_ref().clone()
        }))),
        _ => None,
    });
    let events = run(config(here, &["lidar"]), before.cloned().chain(after.take(300)));
    let lost = |event: &OdometryEvent| matches!(event, OdometryEvent::Finding(f) if f.kind == FindingKind::TrackingLost);
    assert!(events.iter().any(lost));
    let found = poses(&events);
    // Some seconds after the restart, the motion is tracked again.
    let (a, b) = (&found[found.len() - 150], found.last().unwrap());
    assert!(!b.registration.rejected);
    let moved = a.estimate.odom_from_base.inverse() * b.estimate.odom_from_base;
    let at = |stamp: vocab::Stamp| there.truth_at(stamp - later);
    let truth = at(a.estimate.stamp).inverse() * at(b.estimate.stamp);
    let error = (moved.translation.vector - truth.translation.vector).norm();
    assert!(error < 0.1, "{error} of {}", truth.translation.vector.norm());
    // The covariance contains the unknown distance between the two places.
    assert!(b.estimate.covariance[(3, 3)].sqrt() > 0.3, "{}", b.estimate.covariance);
}

/// While the robot is carried with a covered LiDAR, its legs report standstill and its IMU moves.
#[test]
fn after_being_carried_with_a_covered_lidar_the_estimate_restarts() {
    let (walk, put_down) = carried();
    let events = run(config(walk, &[]), walk.messages.iter().cloned());
    let lost: Vec<FindingKind> = events
        .iter()
        .filter_map(|event| match event {
            OdometryEvent::Finding(finding) => Some(finding.kind),
            _ => None,
        })
        .collect();
    let found = poses(&events);
    assert_eq!(lost, [FindingKind::TrackingLost]);
    let after = |seconds: f64| {
        let at = *put_down + Span::from_secs_f64(seconds);
        found.iter().find(|pose| pose.estimate.stamp >= at).unwrap().estimate
    };
    // The carrying is detected while the robot is carried.
    assert!(after(-4.0).covariance[(3, 3)].sqrt() > 3.0, "{}", after(-4.0).covariance);
    // Three seconds after the robot was put down, the estimate no longer moves and is upright.
    let (first, last) = (after(3.0), found.last().unwrap().estimate);
    let moved = first.odom_from_base.inverse() * last.odom_from_base;
    assert!(moved.translation.vector.norm() < 0.02, "{moved}");
    assert!(moved.rotation.angle() < 0.01, "{moved}");
    let truth = walk.truth_at(last.stamp).rotation.inverse() * Vector3::z();
    let up = last.odom_from_base.rotation.inverse() * Vector3::z();
    assert!(up.angle(&truth) < 0.01, "{}", up.angle(&truth));
    assert!(found.last().unwrap().registration.inlier_share > 0.8);
    // The robot's new position is unknown.
    assert!(last.covariance[(3, 3)].sqrt() > 5.0 && last.covariance[(2, 2)].sqrt() > 0.5);
}

#[test]
fn legs_and_imu_carry_on_during_a_lidar_outage() {
    let walk = b1();
    let found = poses(&run(config(walk, &[]), covered(walk, 20.0)));
    let covered_at = walk.messages[0].stamp() + Span::from_millis(10_000);
    let last = found.last().unwrap();
    let before = found.iter().rfind(|pose| pose.scan_stamp < covered_at).unwrap();
    let moved = before.estimate.odom_from_base.inverse() * last.estimate.odom_from_base;
    let truth = walk.truth_at(before.estimate.stamp).inverse() * walk.truth_at(last.estimate.stamp);
    let error = (moved.translation.vector - truth.translation.vector).norm();
    let distance = truth.translation.vector.norm();
    assert!(distance > 5.0 && error < 0.04 * distance, "{error} of {distance}");
    assert!(last.registration.rejected && last.degenerate_directions[2].is_some());
    let deviation =
        |pose: &odometry::PoseEvent| pose.estimate.covariance.fixed_view::<3, 3>(3, 3).trace().sqrt();
    assert!(deviation(last) > 10.0 * deviation(before), "{} {}", deviation(last), deviation(before));
    assert!(error < 5.0 * deviation(last));
}

/// The walk through b1, with the LiDAR covered for this number of seconds from its tenth second on.
fn covered(walk: &Walk, seconds: f64) -> impl Iterator<Item = Sensor> {
    let from = walk.messages[0].stamp() + Span::from_millis(10_000);
    let until = from + Span::from_secs_f64(seconds);
    walk.messages.iter().map(move |message| match message {
        Sensor::Scan(scan) if (from..until).contains(&scan.stamp) => {
            let empty = messages::Scan { stamp: scan.stamp, ..messages::Scan::default() };
            Sensor::Scan(Arc::new(empty))
        }
        other => other.clone(),
    })
}

#[test]
fn after_a_lidar_outage_a_mostly_unmapped_scan_is_accepted() {
    let walk = b1();
    let events = run(config(walk, &[]), covered(walk, 16.0));
    assert!(
        !events.iter().any(|event| matches!(event, OdometryEvent::Finding(_))),
        "nothing must be reported, because the robot was not carried"
    );
    let found = poses(&events);
    let uncovered_at = walk.messages[0].stamp() + Span::from_millis(26_000);
    let before =
        found.iter().rfind(|pose| pose.scan_stamp < uncovered_at - Span::from_millis(16_000)).unwrap();
    let after = found.iter().filter(|pose| pose.scan_stamp >= uncovered_at);
    assert!(after.clone().count() > 20);
    for pose in after {
        assert!(!pose.registration.rejected, "{:?}", pose.registration);
        let moved = before.estimate.odom_from_base.inverse() * pose.estimate.odom_from_base;
        let truth = walk.truth_at(before.estimate.stamp).inverse() * walk.truth_at(pose.estimate.stamp);
        let error = (moved.translation.vector - truth.translation.vector).norm();
        assert!(error < 0.15 && truth.translation.vector.norm() > 3.0, "{error} of {truth}");
    }
}

#[test]
fn an_estimate_far_faster_than_the_legs_loses_tracking() {
    let walk = b1();
    let from = walk.messages[0].stamp() + Span::from_millis(12_000);
    let pushed = covered(walk, 10.0).map(|message| match message {
        Sensor::Imu(mut imu) if imu.stamp > from => {
            imu.specific_force.x += 6.0;
            Sensor::Imu(imu)
        }
        other => other,
    });
    let events = run(config(walk, &[]), pushed);
    let lost = |event: &OdometryEvent| matches!(event, OdometryEvent::Finding(f) if f.kind == FindingKind::TrackingLost);
    // Tracking must be lost with the first scans after the outage, not only after the time limit of rejected scans.
    let before = events.iter().take_while(|event| !lost(event)).cloned().collect::<Vec<_>>();
    assert!(before.len() < events.len());
    let seen = poses(&before).last().unwrap().scan_stamp - walk.messages[0].stamp();
    assert!(seen < Span::from_millis(21_000), "{seen:?}");
    let fastest = poses(&events).iter().map(|pose| pose.estimate.velocity.norm()).fold(0.0, f64::max);
    assert!((3.0..40.0).contains(&fastest), "{fastest} m/s");
}

#[test]
fn starting_while_walking_is_possible() {
    let walk = b1();
    let begin = walk.messages[0].stamp() + Span::from_millis(12_000);
    let found = poses(&run(config(walk, &[]), walk.messages.iter().filter(|m| m.stamp() > begin).cloned()));
    let error = walk.error(&found);
    assert!(error < 0.02, "{error}");
    // The frame is level within a few degrees, although gravity was measured only while walking.
    let up = walk.truth_at(found[0].estimate.stamp).rotation.inverse() * Vector3::z();
    let estimated_up = found[0].estimate.odom_from_base.rotation.inverse() * Vector3::z();
    assert!(up.angle(&estimated_up) < 0.1, "{}", up.angle(&estimated_up));
}

#[test]
fn an_imu_that_falls_silent_is_replaced_and_used_again() {
    let walk = b1();
    let first = walk.messages[0].stamp();
    let silent = first + Span::from_millis(12_000)..first + Span::from_millis(16_000);
    let messages = walk
        .messages
        .iter()
        .filter(|m| !(matches!(m, Sensor::Imu(_)) && silent.contains(&m.stamp())))
        .cloned();
    let error = walk.error(&poses(&run(config(walk, &[]), messages)));
    assert!(error < 0.03, "{error}");
}

#[test]
fn equal_messages_give_equal_bits() {
    let walk = b1();
    let once = || run(config(walk, &[]), walk.messages.iter().take(6_000).cloned());
    let (first, second) = (once(), once());
    assert!(first.len() > 100);
    assert_eq!(format!("{first:?}"), format!("{second:?}"));
}

/// Between scans the IMU propagates the pose.
#[test]
fn predictions_run_ahead_of_the_scans() {
    let walk = b1();
    let mut odometry = odometry::Odometry::new(config(walk, &[]));
    let mut out = Vec::new();
    let mut site_from_odom = None;
    let mut compared = 0;
    for message in &walk.messages {
        crate::support::feed(&mut odometry, message, &mut out);
        let Sensor::Imu(imu) = message else { continue };
        let (predicted, truth) = (odometry.predict(imu.stamp), walk.truth_at(imu.stamp));
        if site_from_odom.is_none() && poses(&out).len() > 20 {
            site_from_odom = Some(truth * predicted.odom_from_base.inverse());
        }
        if let Some(site_from_odom) = site_from_odom {
            let off =
                (site_from_odom * predicted.odom_from_base).translation.vector - truth.translation.vector;
            assert!(off.norm() < 0.02, "{off}");
            compared += 1;
        }
    }
    assert!(compared > 8_000, "{compared}");
}
