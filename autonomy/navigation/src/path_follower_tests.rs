//! Follows paths with an ideal body.

use super::*;
use crate::planner::tests::elevation_map;
use crate::{MotionGuard, MotionGuardConfig, PlannerConfig, plan};
use geometry::so3;

/// Without obstacles.
fn open_ground() -> MotionGuard {
    let (elevation_map, ..) = elevation_map("...");
    MotionGuard::new(MotionGuardConfig::default(), &elevation_map, &Vector3::zeros(), 0.9)
}

fn walk(path: &[[f64; 2]], start_yaw: f64) -> (Isometry, f64, usize) {
    let path: Vec<Vector3> = path.iter().map(|p| Vector3::new(p[0], p[1], 0.0)).collect();
    let mut pose = Isometry::from_parts(path[0].into(), so3::exp(&(Vector3::z() * start_yaw)));
    let follower = PathFollower::new(PathFollowerConfig::new(0.9, 0.9), path.clone());
    let (mut worst, mut steps) = (0.0_f64, 0);
    let guard = open_ground();
    while let Some(velocity) = follower.velocity(&pose, &guard) {
        pose.translation.vector += pose.rotation * Vector3::x() * velocity.forward * 0.05;
        pose.rotation *= so3::exp(&(Vector3::z() * velocity.turn * 0.05));
        let off = path
            .windows(2)
            .map(|pair| {
                let along = ((pose.translation.vector - pair[0]).dot(&(pair[1] - pair[0]))
                    / (pair[1] - pair[0]).norm_squared())
                .clamp(0.0, 1.0);
                (pair[0].lerp(&pair[1], along) - pose.translation.vector).norm()
            })
            .fold(f64::INFINITY, f64::min);
        worst = worst.max(off);
        steps += 1;
        assert!(steps < 4000, "the body does not arrive");
    }
    (pose, worst, steps)
}

#[test]
fn the_follower_arrives_and_stays_near_the_path() {
    for yaw in [0.0, 1.5, 3.1, -2.0] {
        let (end, worst, _) = walk(&[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [1.0, 3.0]], yaw);
        assert!((end.translation.vector.xy() - Vector3::new(1.0, 3.0, 0.0).xy()).norm() < 0.16);
        assert!(worst < 0.35, "cut a corner by {worst} m");
    }
}

#[test]
fn the_remaining_distance_is_measured_along_the_path() {
    let path = vec![Vector3::zeros(), Vector3::new(3.0, 0.0, 0.0), Vector3::new(3.0, 4.0, 0.0)];
    let follower = PathFollower::new(PathFollowerConfig::new(0.9, 0.9), path);
    let at = |x: f64, y: f64| follower.remaining(&Isometry::translation(x, y, 0.0));
    assert!((at(0.0, 0.0) - 7.0).abs() < 1e-9);
    assert!((at(3.0, 2.5) - 1.5).abs() < 1e-9);
}

#[test]
fn a_corner_is_walked_round_with_room_beside_the_robot() {
    // Cells of 0.25 m. Looking 0.7 m ahead cuts the corner of the machine.
    let picture = "
..................
..................
..S...............
..................
######............
######............
######............
......G...........
..................";
    let (elevation_map, from, to) = elevation_map(picture.trim_matches('\n'));
    let path = plan(&PlannerConfig::default(), &elevation_map, &from, &to).expect("a path round the machine");
    let follower = PathFollower::new(PathFollowerConfig::new(0.9, 0.9), path);
    let mut pose = Isometry::translation(from.x, from.y, from.z);
    let guard = |pose: &Isometry| {
        MotionGuard::new(MotionGuardConfig::default(), &elevation_map, &pose.translation.vector, 0.9)
    };
    let mut steps = 0;
    while let Some(velocity) = follower.velocity(&pose, &guard(&pose)) {
        pose.translation.vector += pose.rotation * Vector3::x() * velocity.forward * 0.05;
        pose.rotation *= so3::exp(&(Vector3::z() * velocity.turn * 0.05));
        let room_m = guard(&pose).room_m([pose.translation.x, pose.translation.y]);
        assert!(room_m > 0.0, "{room_m} m at {}", pose.translation);
        steps += 1;
        assert!(steps < 600, "the robot does not arrive");
    }
}
