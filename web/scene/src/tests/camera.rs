//! Projection and gestures keep their promises for any camera.

use crate::camera::FLIGHT_SECONDS;
use crate::{Camera, CameraPose, Eye};
use glam::{DVec2, DVec3, Vec4Swizzles};
use proptest::prelude::*;

fn any_pose() -> impl Strategy<Value = CameraPose> {
    let place = prop::array::uniform3(-500.0..500.0);
    (place, 0.0..6.2_f64, -1.4..1.57_f64, 0.5..200.0_f64).prop_map(|(target, yaw, pitch, distance)| {
        CameraPose { target: DVec3::from_array(target), yaw, pitch, distance }
    })
}

const VIEWPORT: [u32; 2] = [1200, 800];

proptest! {
    #[test]
    fn the_ray_through_a_projected_point_meets_it(
        pose in any_pose(), x in 0.0..1200.0_f64, y in 0.0..800.0_f64, away in 0.2..300.0_f64,
    ) {
        let eye = Eye::new(pose, VIEWPORT);
        let ray = eye.ray(DVec2::new(x, y));
        let (pixel, depth) = eye.project(ray.origin + ray.direction * away).unwrap();
        prop_assert!(pixel.distance(DVec2::new(x, y)) < 1e-6);
        prop_assert!((depth - eye.depth(ray.origin + ray.direction * away)).abs() < 1e-9);
    }

    #[test]
    fn the_matrix_and_the_projection_agree(pose in any_pose(), x in 0.0..1200.0_f64, y in 0.0..800.0_f64) {
        let eye = Eye::new(pose, VIEWPORT);
        let ray = eye.ray(DVec2::new(x, y));
        let clip = eye.clip_from_relative() * (ray.direction * 10.0).as_vec3().extend(1.0);
        let pixel = (clip.xy() / clip.w * glam::Vec2::new(0.5, -0.5) + 0.5) * glam::Vec2::new(1200.0, 800.0);
        prop_assert!(pixel.distance(DVec2::new(x, y).as_vec2()) < 0.05);
        prop_assert!(clip.z > 0.0 && clip.z <= clip.w);
    }

    #[test]
    fn balls_with_a_visible_point_are_seen(
        pose in any_pose(), x in 0.0..1200.0_f64, y in 0.0..800.0_f64, away in 0.2..300.0_f64, radius in 0.0..50.0_f64,
        side in prop::array::uniform3(-1.0..1.0_f64),
    ) {
        let eye = Eye::new(pose, VIEWPORT);
        let ray = eye.ray(DVec2::new(x, y));
        let offset = DVec3::from_array(side).normalize_or_zero() * radius * 0.99;
        prop_assert!(eye.sees_ball(ray.origin + ray.direction * away + offset, radius));
    }

    #[test]
    fn zooming_keeps_the_focus_under_the_pointer(pose in any_pose(), factor in 0.5..2.0_f64, away in 1.0..50.0_f64) {
        let mut camera = Camera::new(pose);
        let pixel = DVec2::new(300.0, 500.0);
        let ray = Eye::new(camera.pose(), VIEWPORT).ray(pixel);
        let focus = ray.origin + ray.direction * away;
        camera.zoom(factor, focus);
        let (after, _) = Eye::new(camera.pose(), VIEWPORT).project(focus).unwrap();
        prop_assert!(after.distance(pixel) < 1e-3);
    }

    #[test]
    fn a_fitted_box_is_in_the_picture(
        pose in any_pose(), min in prop::array::uniform3(-100.0..100.0_f64), size in prop::array::uniform3(1.0..80.0_f64),
    ) {
        let (min, max) = (DVec3::from_array(min), DVec3::from_array(min) + DVec3::from_array(size));
        let eye = Eye::new(Camera::new(pose).fitting(min, max, VIEWPORT), VIEWPORT);
        let (middle, _) = eye.project(0.5 * (min + max)).unwrap();
        prop_assert!(middle.distance(DVec2::new(600.0, 400.0)) < 1e-3);
        // 15 % of the enclosing ball may leave the picture; the corners of a box then still stay near it.
        for corner in 0..8 {
            let pick = |bit: usize, axis: usize| if corner >> bit & 1 == 1 { max[axis] } else { min[axis] };
            let (at, _) = eye.project(DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2))).unwrap();
            prop_assert!((at - DVec2::new(600.0, 400.0)).abs().cmple(DVec2::new(780.0, 560.0)).all(), "{at}");
        }
    }
}

#[test]
fn a_flight_arrives_on_time_the_short_way_round() {
    let start = CameraPose { yaw: 6.2, ..CameraPose::default() };
    let end = CameraPose { yaw: 0.1, target: DVec3::new(5.0, 0.0, 1.0), ..start };
    let mut camera = Camera::new(start);
    camera.fly_to(end);
    assert!(camera.advance(FLIGHT_SECONDS / 2.0) && camera.flying());
    let middle = camera.pose().yaw;
    assert!(!(0.2..=6.1).contains(&middle), "turned the long way: {middle}");
    assert!(camera.advance(FLIGHT_SECONDS / 2.0 + 1e-9) && !camera.flying());
    assert!(camera.pose().target.distance(end.target) < 1e-9 && (camera.pose().yaw - 0.1).abs() < 1e-9);
    assert!(!camera.advance(1.0));
}

#[test]
fn a_gesture_ends_a_flight_and_nonsense_changes_nothing() {
    let mut camera = Camera::new(CameraPose::default());
    camera.fly_to(CameraPose { distance: 5.0, ..CameraPose::default() });
    camera.orbit(DVec2::new(10.0, 0.0));
    assert!(!camera.flying());
    let before = camera.pose();
    camera.orbit(DVec2::NAN);
    camera.pan(DVec2::INFINITY, 0.0);
    camera.zoom(0.0, DVec3::ZERO);
    camera.zoom(2.0, DVec3::NAN);
    camera.jump_to(CameraPose { distance: f64::NAN, ..before });
    assert_eq!(camera.pose(), before);
}

#[test]
fn panning_moves_the_ground_with_the_pointer() {
    let mut camera = Camera::new(CameraPose { pitch: 1.2, ..CameraPose::default() });
    let middle = DVec2::new(600.0, 400.0);
    let drag = DVec2::new(30.0, 20.0);
    let held = Eye::new(camera.pose(), VIEWPORT).ray(middle).at_height(0.0).unwrap();
    camera.pan(drag, 800.0);
    let (now, _) = Eye::new(camera.pose(), VIEWPORT).project(held).unwrap();
    assert!(now.distance(middle + drag) < 2.0, "{now}");
}
