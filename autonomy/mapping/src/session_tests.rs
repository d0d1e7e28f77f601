//! Sessions: which scans become keyframes, the information of edges, and corrections of the keyframes.

use super::*;
use crate::testing::KEYFRAMES;
use geometry::Vector3;
use nalgebra::Translation3;

/// Least standard deviation of an edge.
const FLOOR_RAD: f64 = 5e-4;
const FLOOR_M: f64 = 5e-3;

fn at(x: f64, yaw: f64) -> Isometry {
    Isometry::from_parts(Translation3::new(x, 0.0, 0.0), so3::exp(&(Vector3::z() * yaw)))
}

fn scan(stamp: Stamp, pose: &Isometry, is_degenerate: bool) -> ScanPose {
    ScanPose {
        stamp,
        odom_from_base: *pose,
        scan_stamp: stamp,
        odom_from_base_at_scan: *pose,
        covariance: Matrix6::zeros(),
        covariance_inflation: Matrix6::zeros(),
        is_degenerate,
        is_gravity_measured: false,
        is_dead_reckoned: false,
    }
}

fn walk(session: &mut Session, poses: impl Iterator<Item = Isometry>) {
    for (index, pose) in poses.enumerate() {
        session.add_scan(&scan(Stamp::from_nanos(index as i64 * 100_000_000), &pose, false));
    }
}

#[test]
fn the_map_frame_is_the_first_base_pose_with_vertical_z_and_zero_yaw() {
    let tilted = Isometry::from_parts(
        Translation3::new(3.0, -2.0, 0.5),
        so3::exp(&(Vector3::z() * 1.1)) * so3::exp(&(Vector3::x() * 0.2)),
    );
    let mut session = Session::new(&tilted, SessionConfig::new(KEYFRAMES));
    let node = session.add_scan(&scan(Stamp::EPOCH, &tilted, false)).expect("first keyframe");
    assert!(node.map_from_keyframe.translation.vector.norm() < 1e-12);
    let rotation = node.map_from_keyframe.rotation;
    assert!((rotation.inverse() * so3::exp(&(Vector3::x() * 0.2))).angle() < 1e-12);
}

#[test]
fn keyframes_follow_distance_and_rotation() {
    let mut session = Session::new(
        &at(0.0, 0.0),
        SessionConfig::new(KeyframePolicy { distance_m: 1.0, rotation_rad: 0.5 }),
    );
    walk(&mut session, (0..=50).map(|i| at(f64::from(i) * 0.1, 0.0)));
    assert_eq!(session.graph().nodes().len(), 5, "0.0, 1.1, 2.2, 3.3, 4.4");
    assert!((session.distance_m() - 5.0).abs() < 1e-9);
    walk(&mut session, (0..=20).map(|i| at(5.0, f64::from(i) * 0.05)));
    assert_eq!(
        session.graph().nodes().len(),
        6,
        "one more keyframe after a rotation of more than half a radian"
    );
    assert_eq!(session.graph().edges().len(), 5);
}

#[test]
fn a_correction_moves_the_trajectory_rigidly_with_its_keyframes() {
    let mut session = Session::new(&at(0.0, 0.0), SessionConfig::new(KEYFRAMES));
    walk(&mut session, (0..=40).map(|i| at(f64::from(i) * 0.1, 0.0)));
    let (before, stretch) = (session.graph().nodes().to_vec(), session.trajectory().to_vec());
    // The correction was computed before the last keyframe was added. It rotates the others about the first and shifts one.
    let turn = at(0.0, 0.3);
    let mut poses: Vec<Isometry> = before[..3].iter().map(|n| turn * n.map_from_keyframe).collect();
    poses[1].translation.vector.z += 0.2;
    session.move_keyframes(&poses);
    assert!(session.graph().nodes().iter().zip(&poses).all(|(node, pose)| node.map_from_keyframe == *pose));
    let near = |a: &Isometry, b: &Isometry| (a.inverse() * b).translation.vector.norm() < 1e-9;
    // The last keyframe and the robot keep their pose relative to the last corrected keyframe.
    assert!(near(&session.graph().nodes()[3].map_from_keyframe, &(turn * before[3].map_from_keyframe)));
    assert!(near(session.map_from_odom(), &turn));
    let last = stretch.len() - 1;
    assert!(near(&session.trajectory()[last].1, &(turn * stretch[last].1)));
    assert!(
        (session.trajectory()[15].1.translation.vector.z - 0.2).abs() < 1e-9,
        "poses after the second keyframe must follow its shift"
    );
    // The correction does not affect later measurements.
    let next = session.add_scan(&scan(Stamp::from_nanos(1), &at(5.0, 0.0), false));
    assert!(next.is_some_and(|node| near(&node.map_from_keyframe, &(turn * at(5.0, 0.0)))));
    let edge = session.graph().edges()[3].from_from_to;
    assert!((edge.translation.vector.x - (5.0 - 3.3)).abs() < 1e-9, "{edge}");
    // A pose that is not finite changes nothing.
    let held = session.graph().nodes().to_vec();
    session.move_keyframes(&[at(f64::NAN, 0.0)]);
    assert_eq!(session.graph().nodes(), held);
}

/// Poses chained over the session's own edges are set again and again, as on a long walk with many loops.
#[test]
fn rounding_errors_do_not_accumulate_over_hundreds_of_closed_loops() {
    let mut session = Session::new(&at(0.0, 0.0), SessionConfig::new(KEYFRAMES));
    let step =
        Isometry::from_parts(Translation3::new(1.2, 0.1, 0.03), so3::exp(&Vector3::new(0.01, -0.02, 0.3)));
    let (mut odom, mut found) = (Isometry::identity(), Vec::new());
    for index in 0..300 {
        session.add_scan(&scan(Stamp::from_nanos(index), &odom, false));
        odom *= step;
        let pose = match (found.last(), session.graph().edges().last()) {
            (Some(last), Some(edge)) => last * edge.from_from_to,
            _ => at(0.0, 0.0),
        };
        found.push(pose);
        session.move_keyframes(&found);
    }
    assert_eq!(session.graph().edges().len(), 299);
    for edge in session.graph().edges() {
        let error = edge.from_from_to.inverse() * step;
        assert!((edge.from_from_to.rotation.norm() - 1.0).abs() < 1e-14, "{edge:?}");
        assert!(error.translation.vector.norm() < 1e-9 && error.rotation.angle() < 1e-7, "{edge:?}");
    }
}

#[test]
fn loops_are_added_and_removed() {
    let mut session = Session::new(&at(0.0, 0.0), SessionConfig::new(KEYFRAMES));
    walk(&mut session, (0..=40).map(|i| at(f64::from(i) * 0.1, 0.0)));
    let edge = PoseGraphEdge { from: KeyframeId(0), to: KeyframeId(3), ..session.graph().edges()[0] };
    let revision = session.graph().revision();
    session.graph_mut().add_loop(&edge);
    assert_eq!((session.graph().loops(), session.graph().revision()), (&[edge][..], revision + 1));
    assert!(
        session.graph_mut().remove_loop(edge.from, edge.to)
            && !session.graph_mut().remove_loop(edge.from, edge.to)
    );
    assert!(session.graph().loops().is_empty());
}

#[test]
fn an_edge_has_the_covariance_by_which_the_filter_grew_or_shrank() {
    let mut grown = Matrix6::zeros();
    grown[(3, 3)] = 0.25;
    let information = edge_information(
        &Matrix6::zeros(),
        &grown,
        &at(1.0, 0.0),
        &Vector6::zeros(),
        &SessionConfig::new(KEYFRAMES),
    );
    assert!((information[(3, 3)] - 4.0).abs() < 1e-9);
    assert!((information[(4, 4)] - 1.0 / (FLOOR_M * FLOOR_M)).abs() < 1e-3);
    // The covariance may also shrink, after the pose was found again.
    let information = edge_information(
        &grown,
        &Matrix6::zeros(),
        &at(1.0, 0.0),
        &Vector6::zeros(),
        &SessionConfig::new(KEYFRAMES),
    );
    assert!((information[(3, 3)] - 4.0).abs() < 1e-9);
}

#[test]
fn an_edge_without_scans_is_less_certain() {
    let mut session = Session::new(&at(0.0, 0.0), SessionConfig::new(KEYFRAMES));
    for (index, seconds) in [(0, 0), (1, 1), (2, 2), (3, 10), (4, 11)] {
        let pose = at(4.0 * f64::from(index), 0.0);
        session.add_scan(&scan(Stamp::from_parts(seconds, 0), &pose, false));
    }
    let deviations: Vec<f64> =
        session.graph().edges().iter().map(|e| e.information[(4, 4)].powf(-0.5)).collect();
    let expected = [FLOOR_M, FLOOR_M, FLOOR_M.hypot(0.12), FLOOR_M];
    assert!(deviations.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{deviations:?}");
    let heading = session.graph().edges()[2].information[(0, 0)].powf(-0.5);
    assert!((heading - FLOOR_RAD).abs() < 1e-12, "the IMU must keep the heading certain: {heading}");
}

#[test]
fn dead_reckoned_scans_are_no_keyframes_and_make_the_edge_uncertain() {
    let mut session = Session::new(&at(0.0, 0.0), SessionConfig::new(KEYFRAMES));
    for tenth in 0..=100_i64 {
        let pose = at(tenth as f64 * 0.1, 0.0);
        let is_dead_reckoned = (13..90).contains(&tenth);
        let scan = scan(Stamp::from_nanos(tenth * 100_000_000), &pose, false);
        session.add_scan(&ScanPose { is_dead_reckoned, ..scan });
    }
    let places: Vec<f64> =
        session.graph().nodes().iter().map(|node| node.map_from_keyframe.translation.x).collect();
    assert_eq!(places.len(), 3, "{places:?}");
    assert!((places[2] - 9.0).abs() < 1e-9);
    let vague = session.graph().edges()[1].information[(4, 4)].powf(-0.5);
    assert!(vague > 0.03 * 6.5 && vague < 0.03 * 8.5, "{vague}");
}

#[test]
fn covariance_inflation_affects_one_edge_only() {
    let mut session = Session::new(&at(0.0, 0.0), SessionConfig::new(KEYFRAMES));
    let variances = Vector6::new(0.25, 0.25, 0.25, 25.0, 25.0, 25.0);
    for index in 0..4_i64 {
        let guessed = if index < 2 { Matrix6::zeros() } else { Matrix6::from_diagonal(&variances) };
        let pose = at(2.0 * index as f64, 0.3 * index as f64);
        let scan = scan(Stamp::from_nanos(index * 100_000_000), &pose, false);
        session.add_scan(&ScanPose { covariance: guessed, covariance_inflation: guessed, ..scan });
    }
    let deviation =
        |edge: usize, row: usize| session.graph().edges()[edge].information[(row, row)].powf(-0.5);
    for row in 3..6 {
        assert!((deviation(0, row) - FLOOR_M).abs() < 1e-9 && (deviation(2, row) - FLOOR_M).abs() < 1e-9);
        assert!((deviation(1, row) - 5.0).abs() < 1e-3);
    }
    assert!((deviation(1, 2) - 0.5).abs() < 1e-3 && (deviation(2, 2) - FLOOR_RAD).abs() < 1e-9);
}

#[test]
fn consecutive_degenerate_scans_form_segments() {
    let mut session = Session::new(&at(0.0, 0.0), SessionConfig::new(KEYFRAMES));
    for index in 0..60_i64 {
        let degenerate = (10..20).contains(&index) || (40..45).contains(&index);
        let pose = at(index as f64 * 0.1, 0.0);
        session.add_scan(&scan(Stamp::from_nanos(index * 100_000_000), &pose, degenerate));
    }
    let lengths: Vec<f64> = session.degenerate_segments().iter().map(|s| s.distance_m).collect();
    assert_eq!(lengths.len(), 2);
    assert!((lengths[0] - 0.9).abs() < 1e-9 && (lengths[1] - 0.4).abs() < 1e-9, "{lengths:?}");
}
