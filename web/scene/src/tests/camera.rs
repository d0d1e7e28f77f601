//! Projection, gestures, limits and fitting of the camera.

use crate::{Camera, CameraPose, CameraProjection, FreeArea, SceneCameraConfig};
use glam::{DVec2, DVec3, Vec4Swizzles};
use proptest::prelude::*;

fn any_pose() -> impl Strategy<Value = CameraPose> {
    let place = prop::array::uniform3(-500.0..500.0);
    (place, 0.0..6.2_f64, -1.4..1.57_f64, 0.5..200.0_f64).prop_map(|(target, yaw, pitch, distance)| {
        CameraPose { target: DVec3::from_array(target), yaw, pitch, distance }
    })
}

const VIEWPORT: [u32; 2] = [1200, 800];
const FLIGHT_S: f64 = 0.3;

proptest! {
    #[test]
    fn the_ray_through_a_pixel_and_the_projection_are_inverse(
        pose in any_pose(), x in 0.0..1200.0_f64, y in 0.0..800.0_f64, away in 0.2..300.0_f64,
    ) {
        let projection = CameraProjection::new(pose, VIEWPORT);
        let ray = projection.ray(DVec2::new(x, y));
        let (pixel, depth) = projection.project(ray.origin + ray.direction * away).unwrap();
        prop_assert!(pixel.distance(DVec2::new(x, y)) < 1e-6);
        prop_assert!((depth - projection.depth(ray.origin + ray.direction * away)).abs() < 1e-9);
    }

    #[test]
    fn clip_matrix_and_projection_give_the_same_pixel(pose in any_pose(), x in 0.0..1200.0_f64, y in 0.0..800.0_f64) {
        let projection = CameraProjection::new(pose, VIEWPORT);
        let ray = projection.ray(DVec2::new(x, y));
        let clip = projection.clip_from_relative() * (ray.direction * 10.0).as_vec3().extend(1.0);
        let pixel = (clip.xy() / clip.w * glam::Vec2::new(0.5, -0.5) + 0.5) * glam::Vec2::new(1200.0, 800.0);
        prop_assert!(pixel.distance(DVec2::new(x, y).as_vec2()) < 0.05);
        prop_assert!(clip.z > 0.0 && clip.z <= clip.w);
    }

    #[test]
    fn spheres_with_a_visible_point_are_seen(
        pose in any_pose(), x in 0.0..1200.0_f64, y in 0.0..800.0_f64, away in 0.2..300.0_f64, radius in 0.0..50.0_f64,
        side in prop::array::uniform3(-1.0..1.0_f64),
    ) {
        let projection = CameraProjection::new(pose, VIEWPORT);
        let ray = projection.ray(DVec2::new(x, y));
        let offset = DVec3::from_array(side).normalize_or_zero() * radius * 0.99;
        prop_assert!(projection.sees_sphere(ray.origin + ray.direction * away + offset, radius));
    }

    #[test]
    fn zooming_keeps_the_focus_under_the_pointer(pose in any_pose(), factor in 0.5..2.0_f64, away in 1.0..50.0_f64) {
        let mut camera = Camera::new(SceneCameraConfig::default(), pose);
        let pixel = DVec2::new(300.0, 500.0);
        let ray = CameraProjection::new(camera.pose(), VIEWPORT).ray(pixel);
        let focus = ray.origin + ray.direction * away;
        camera.zoom(factor, focus);
        let (after, _) = CameraProjection::new(camera.pose(), VIEWPORT).project(focus).unwrap();
        prop_assert!(after.distance(pixel) < 1e-3);
    }

    #[test]
    fn a_fitted_box_fills_the_free_area_and_stays_inside(
        pose in any_pose(), min in prop::array::uniform3(-100.0..100.0_f64), size in prop::array::uniform3(1.0..80.0_f64),
        left in 0.0..300.0_f64, right in 700.0..1200.0_f64, top in 0.0..200.0_f64, bottom in 500.0..800.0_f64,
    ) {
        let (min, max) = (DVec3::from_array(min), DVec3::from_array(min) + DVec3::from_array(size));
        let free = FreeArea { min_px: DVec2::new(left, top), max_px: DVec2::new(right, bottom) };
        let fitted = Camera::new(SceneCameraConfig::default(), pose).pose_fitting(min, max, VIEWPORT, free);
        let projection = CameraProjection::new(fitted, VIEWPORT);
        let (middle, _) = projection.project(0.5 * (min + max)).unwrap();
        prop_assert!(middle.distance(0.5 * (free.min_px + free.max_px)) < 1e-3);
        let mut used = DVec2::ZERO;
        for corner in 0..8 {
            let pick = |bit: usize, axis: usize| if corner >> bit & 1 == 1 { max[axis] } else { min[axis] };
            let (at, _) = projection.project(DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2))).unwrap();
            prop_assert!(at.cmpge(free.min_px).all() && at.cmple(free.max_px).all(), "{at}");
            used = used.max((at - middle).abs() / (0.5 * (free.max_px - free.min_px)));
        }
        prop_assert!((used.max_element() - SceneCameraConfig::default().fitted_share).abs() < 1e-3, "{used}");
    }
}

#[test]
fn fitting_an_empty_box_or_area_keeps_the_pose() {
    let camera = Camera::new(SceneCameraConfig::default(), CameraPose::default());
    let covered = FreeArea { min_px: DVec2::splat(500.0), max_px: DVec2::splat(500.0) };
    let whole = FreeArea::whole(VIEWPORT);
    assert_eq!(camera.pose_fitting(DVec3::ONE, DVec3::ZERO, VIEWPORT, whole), camera.pose());
    assert_eq!(camera.pose_fitting(DVec3::ZERO, DVec3::ONE, VIEWPORT, covered), camera.pose());
}

#[test]
fn zooming_in_on_a_surface_ends_at_the_shortest_camera_distance() {
    let mut camera =
        Camera::new(SceneCameraConfig::default(), CameraPose { pitch: 0.5, ..CameraPose::default() });
    let pixel = DVec2::new(350.0, 300.0);
    let surface = CameraProjection::new(camera.pose(), VIEWPORT).ray(pixel).at_height(1.5).unwrap();
    for _ in 0..200 {
        camera.move_target_to_depth_of(surface);
        camera.zoom(1.2, surface);
    }
    let projection = CameraProjection::new(camera.pose(), VIEWPORT);
    let (at, depth) = projection.project(surface).unwrap();
    assert!((depth - 0.1).abs() < 1e-6, "{depth}");
    assert!(at.distance(pixel) < 1e-3, "{at}");
    for _ in 0..200 {
        camera.zoom(0.8, surface);
    }
    assert!((camera.pose().distance - 3000.0).abs() < 1e-6);
}

#[test]
fn moving_the_target_to_a_depth_changes_no_pixel() {
    let mut camera = Camera::new(SceneCameraConfig::default(), CameraPose::default());
    let point = DVec3::new(1.0, 2.0, 3.0);
    let before = CameraProjection::new(camera.pose(), VIEWPORT).project(point).unwrap();
    camera.move_target_to_depth_of(point);
    let after = CameraProjection::new(camera.pose(), VIEWPORT).project(point).unwrap();
    assert!(before.0.distance(after.0) < 1e-6);
    assert!((camera.pose().distance - after.1).abs() < 1e-9);
    let pose = camera.pose();
    camera.move_target_to_depth_of(pose.position() - pose.forward());
    assert_eq!(camera.pose(), pose, "a point behind the camera");
}

#[test]
fn a_flight_arrives_on_time_and_turns_by_the_smaller_angle() {
    let start = CameraPose { yaw: 6.2, ..CameraPose::default() };
    let end = CameraPose { yaw: 0.1, target: DVec3::new(5.0, 0.0, 1.0), ..start };
    let mut camera = Camera::new(SceneCameraConfig::default(), start);
    camera.fly_to(end);
    assert!(camera.advance(FLIGHT_S / 2.0) && camera.is_flying());
    let middle = camera.pose().yaw;
    assert!(!(0.2..=6.1).contains(&middle), "turned by the larger angle: {middle}");
    assert!(camera.advance(FLIGHT_S / 2.0 + 1e-9) && !camera.is_flying());
    assert!(camera.pose().target.distance(end.target) < 1e-9 && (camera.pose().yaw - 0.1).abs() < 1e-9);
    assert!(!camera.advance(1.0));
}

#[test]
fn a_gesture_ends_a_flight_and_invalid_input_changes_nothing() {
    let mut camera = Camera::new(SceneCameraConfig::default(), CameraPose::default());
    camera.fly_to(CameraPose { distance: 5.0, ..CameraPose::default() });
    camera.orbit(DVec2::new(10.0, 0.0));
    assert!(!camera.is_flying());
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
    let mut camera =
        Camera::new(SceneCameraConfig::default(), CameraPose { pitch: 1.2, ..CameraPose::default() });
    let middle = DVec2::new(600.0, 400.0);
    let drag = DVec2::new(30.0, 20.0);
    let held = CameraProjection::new(camera.pose(), VIEWPORT).ray(middle).at_height(0.0).unwrap();
    camera.pan(drag, 800.0);
    let (now, _) = CameraProjection::new(camera.pose(), VIEWPORT).project(held).unwrap();
    assert!(now.distance(middle + drag) < 2.0, "{now}");
}
