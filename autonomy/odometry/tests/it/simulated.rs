//! Half a minute of walking through the test hall, with every combination of sources that makes sense.

use crate::support::{b1, carried, config, narrow_doors, poses, run};
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
    // At the scan's own stamp too.
    let start = &found[200];
    let moved = found[199].estimate.odom_from_base.inverse() * start.odom_from_base_at_scan;
    let truth = walk.truth_at(found[199].estimate.stamp).inverse() * walk.truth_at(start.scan_stamp);
    assert!((moved.translation.vector - truth.translation.vector).norm() < 0.005);
}

#[test]
fn the_stated_covariance_is_of_the_size_of_the_error() {
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
fn lidar_alone_lidar_with_imu_and_lidar_with_legs_work() {
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
fn the_lidar_alone_keeps_its_way_where_half_of_what_it_sees_is_new() {
    let walk = narrow_doors();
    let found = poses(&run(config(walk, &["lidar"]), walk.messages.iter().cloned()));
    let error = walk.error(&found);
    assert!(error < 0.1, "{error}");
}

#[test]
fn lost_for_good_it_begins_anew_and_says_so() {
    // Carried with covered eyes: the first half minute here, then at once somewhere else.
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
    let lost =
        |event: &OdometryEvent| matches!(event, OdometryEvent::Finding(f) if f.kind == FindingKind::LostWay);
    assert!(events.iter().any(lost));
    let found = poses(&events);
    // From well after the beginning on, the way is followed again.
    let (a, b) = (&found[found.len() - 150], found.last().unwrap());
    assert!(!b.registration.rejected);
    let moved = a.estimate.odom_from_base.inverse() * b.estimate.odom_from_base;
    let at = |stamp: vocab::Stamp| there.truth_at(stamp - later);
    let truth = at(a.estimate.stamp).inverse() * at(b.estimate.stamp);
    let error = (moved.translation.vector - truth.translation.vector).norm();
    assert!(error < 0.1, "{error} of {}", truth.translation.vector.norm());
    // And how far it was carried is no certainty.
    assert!(b.estimate.covariance[(3, 3)].sqrt() > 0.3, "{}", b.estimate.covariance);
}

/// Legs at rest in somebody's arms contradict an IMU that moves, and no scan says which is right.
#[test]
fn carried_away_in_the_dark_odometry_begins_anew_and_stands_still_where_it_was_put_down() {
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
    assert_eq!(lost, [FindingKind::LostWay]);
    let after = |seconds: f64| {
        let at = *put_down + Span::from_secs_f64(seconds);
        found.iter().find(|pose| pose.estimate.stamp >= at).unwrap().estimate
    };
    // It stands, upright, from five seconds on.
    let (first, last) = (after(5.0), found.last().unwrap().estimate);
    let moved = first.odom_from_base.inverse() * last.odom_from_base;
    assert!(moved.translation.vector.norm() < 0.02, "{moved}");
    assert!(moved.rotation.angle() < 0.01, "{moved}");
    let truth = walk.truth_at(last.stamp).rotation.inverse() * Vector3::z();
    let up = last.odom_from_base.rotation.inverse() * Vector3::z();
    assert!(up.angle(&truth) < 0.01, "{}", up.angle(&truth));
    assert!(found.last().unwrap().registration.inlier_share > 0.8);
    // Where that is, it does not claim to know.
    assert!(last.covariance[(3, 3)].sqrt() > 5.0 && last.covariance[(2, 2)].sqrt() > 0.5);
}

#[test]
fn legs_and_imu_carry_on_while_the_lidar_is_blind() {
    let walk = b1();
    let first = walk.messages[0].stamp();
    let covered = first + Span::from_millis(10_000)..first + Span::from_millis(30_000);
    let blind = |message: &Sensor| match message {
        Sensor::Scan(scan) if covered.contains(&scan.stamp) => {
            let empty = messages::Scan { stamp: scan.stamp, ..messages::Scan::default() };
            Sensor::Scan(Arc::new(empty))
        }
        other => other.clone(),
    };
    let found = poses(&run(config(walk, &[]), walk.messages.iter().map(blind)));
    let last = found.last().unwrap();
    let before = found.iter().rfind(|pose| pose.scan_stamp < covered.start).unwrap();
    let moved = before.estimate.odom_from_base.inverse() * last.estimate.odom_from_base;
    let truth = walk.truth_at(before.estimate.stamp).inverse() * walk.truth_at(last.estimate.stamp);
    let error = (moved.translation.vector - truth.translation.vector).norm();
    let distance = truth.translation.vector.norm();
    assert!(distance > 5.0 && error < 0.04 * distance, "{error} of {distance}");
    assert!(last.registration.rejected && last.degenerate[2].is_some());
    let deviation =
        |pose: &odometry::PoseEvent| pose.estimate.covariance.fixed_view::<3, 3>(3, 3).trace().sqrt();
    assert!(deviation(last) > 10.0 * deviation(before), "{} {}", deviation(last), deviation(before));
    assert!(error < 5.0 * deviation(last));
}

#[test]
fn starting_in_full_walk_is_possible() {
    let walk = b1();
    let begin = walk.messages[0].stamp() + Span::from_millis(12_000);
    let found = poses(&run(config(walk, &[]), walk.messages.iter().filter(|m| m.stamp() > begin).cloned()));
    let error = walk.error(&found);
    assert!(error < 0.02, "{error}");
    // The frame is level within a few degrees, though gravity was seen only while moving.
    let up = walk.truth_at(found[0].estimate.stamp).rotation.inverse() * Vector3::z();
    let guessed = found[0].estimate.odom_from_base.rotation.inverse() * Vector3::z();
    assert!(up.angle(&guessed) < 0.1, "{}", up.angle(&guessed));
}

#[test]
fn an_imu_that_falls_silent_is_done_without_and_taken_back() {
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
fn same_messages_same_bits() {
    let walk = b1();
    let once = || run(config(walk, &[]), walk.messages.iter().take(6_000).cloned());
    let (first, second) = (once(), once());
    assert!(first.len() > 100);
    assert_eq!(format!("{first:?}"), format!("{second:?}"));
}

/// Between scans the pose runs on with the IMU.
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
