//! A robot of 0.2 m radius among obstacles that are drawn as for the planner.

use super::*;
use crate::planner::tests::elevation_map;
use geometry::so3;

/// Shares allowed at 0.9 m/s towards a wall, from this distance between wall and footprint, metres.
fn towards_wall(distance_m: f64) -> f64 {
    // The face of the wall is at x = 5.125.
    let (elevation_map, ..) = elevation_map(&"....................#\n".repeat(13));
    let position = Vector3::new(5.125 - 0.2 - distance_m, -1.6, 0.0);
    let guard = MotionGuard::new(MotionGuardConfig::default(), &elevation_map, &position, 0.9);
    guard.allowed_share(&Isometry::translation(position.x, position.y, 0.0), [0.9, 0.0], 0.0)
}

#[test]
fn the_robot_slows_down_so_that_it_can_stop_in_front_of_a_wall() {
    assert!(towards_wall(0.8) >= 1.0, "0.58 m to stop, and 0.11 m of room");
    let mut last = 1.0;
    for centimetres in (0..80).rev() {
        let distance_m = f64::from(centimetres) / 100.0;
        let share = towards_wall(distance_m);
        assert!(share <= last, "{distance_m}");
        let config = MotionGuardConfig::default();
        assert!(config.stopping_distance_m(0.9 * share) <= distance_m + 0.01, "{share} at {distance_m} m");
        last = share;
    }
    assert_eq!(last, 0.0);
}

#[test]
fn a_robot_that_walks_away_turns_or_passes_with_room_is_not_slowed_down() {
    let (elevation_map, ..) =
        elevation_map("....................\n.........#..........\n....................");
    let share = |x: f64, y: f64, yaw: f64, linear: [f64; 2], turn: f64| {
        let position = Vector3::new(x, y, 0.0);
        let guard = MotionGuard::new(MotionGuardConfig::default(), &elevation_map, &position, 0.9);
        let pose = Isometry::from_parts(position.into(), so3::exp(&(Vector3::z() * yaw)));
        guard.allowed_share(&pose, linear, turn)
    };
    // The post is at (2.375, -0.375).
    let beside = |room_m: f64| -0.375 + 0.2 + room_m;
    assert_eq!(share(1.9, beside(0.15), 0.0, [0.9, 0.0], 0.0), 1.0, "past it with 15 cm");
    let narrow = share(2.3, beside(0.03), 0.0, [0.9, 0.0], 0.0);
    assert!((0.1..0.5).contains(&narrow), "past it with 3 cm: {narrow}");
    assert_eq!(share(2.375, beside(-0.02), 0.0, [0.0, 0.0], 0.9), 1.0, "in place");
    assert_eq!(share(2.375, beside(-0.02), 0.0, [0.0, -0.2], 0.0), 0.0, "sideways into it");
    assert!(share(2.375, beside(-0.02), 0.0, [0.0, 0.2], 0.0) > 0.5, "away from it");
    assert_eq!(
        share(2.375 - 0.7, -0.375, std::f64::consts::PI, [-0.9, 0.0], 0.0),
        share(2.375 - 0.7, -0.375, 0.0, [0.9, 0.0], 0.0)
    );
    // An arc that leads past the post, and one that ends in it.
    let (free, blocked) = (share(2.0, -0.1, 0.0, [0.6, 0.0], 0.6), share(2.0, -0.1, 0.0, [0.6, 0.0], -0.9));
    assert!(free >= 1.0 && blocked < 1.0, "{free} {blocked}");
}

#[test]
fn a_line_is_free_if_the_robot_touches_nothing_on_it() {
    let (elevation_map, ..) =
        elevation_map("....................\n.........#..........\n....................");
    let guard =
        MotionGuard::new(MotionGuardConfig::default(), &elevation_map, &Vector3::new(2.375, 0.0, 0.0), 0.9);
    assert!(guard.is_line_free([1.9, -0.15], [2.8, -0.15]));
    assert!(!guard.is_line_free([1.9, -0.2], [2.8, -0.2]));
    assert!(guard.is_line_free([2.375, -0.2], [2.375, 0.1]), "away from it");
}
