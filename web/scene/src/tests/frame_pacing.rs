//! Tests: late frames lower the quality, and frames in time and rest raise it.

use super::view;
use crate::{CameraPose, FramePacer, View};

fn requested() -> View {
    view(CameraPose::default(), [800, 600])
}

/// Draws changed frames at an interval, s; returns the time (s) and the view of the last one.
fn run(pacer: &mut FramePacer, from: f64, interval: f64, frames: u32) -> (f64, View) {
    (1..=frames).fold((from, requested()), |_, i| {
        let now = from + interval * f64::from(i);
        (now, pacer.plan_frame(now, &requested(), true).0)
    })
}

#[test]
fn late_frames_lower_points_and_pixels_and_rest_raises_them() {
    let mut pacer = FramePacer::default();
    assert_eq!(pacer.plan_frame(0.0, &requested(), true), (requested(), None));
    let (now, slow) = run(&mut pacer, 0.0, 1.0, 6);
    assert!(slow.options.point_budget < 150_000 && slow.options.resolution <= 0.5, "{:?}", slow.options);
    let (same, due) = pacer.plan_frame(now + 0.1, &requested(), false);
    assert_eq!(same, slow);
    assert!(due.is_some_and(|due| (0.25..0.35).contains(&due)), "{due:?}");
    let (still, due) = pacer.plan_frame(now + 0.45, &requested(), false);
    assert!(still.options.point_budget > 2 * slow.options.point_budget && due.is_some());
    let (full, due) =
        (0..4).fold((still, due), |_, i| pacer.plan_frame(now + 1.0 + f64::from(i), &requested(), false));
    assert_eq!((full, due), (requested(), None), "refined up to the full quality");
    let (moved, _) = pacer.plan_frame(now + 5.0, &requested(), true);
    assert_eq!(moved, slow, "the time at rest does not change the quality");
}

#[test]
fn frames_in_time_restore_the_quality_and_scans_at_ten_hertz_do_not_lower_it() {
    let mut pacer = FramePacer::default();
    let (now, _) = run(&mut pacer, 0.0, 0.3, 8);
    let (now, quick) = run(&mut pacer, now, 0.016, 80);
    assert_eq!(quick, requested());
    let (now, steady) = run(&mut pacer, now, 0.12, 50);
    assert_eq!(steady, requested());
    assert_eq!(pacer.plan_frame(now + 1.0, &requested(), false), (requested(), None));
}

#[test]
fn frames_of_the_robot_come_seldom_only_where_the_lowest_quality_is_too_much() {
    let mut pacer = FramePacer::default();
    assert_eq!(pacer.stream_interval_s(), 0.09);
    let (now, _) = run(&mut pacer, 0.0, 0.2, 2);
    assert_eq!(pacer.stream_interval_s(), 0.09, "a lower quality may be enough");
    let (now, _) = run(&mut pacer, now, 0.3, 10);
    let seldom = pacer.stream_interval_s();
    assert_eq!(seldom, 0.35);
    let (now, slow) = run(&mut pacer, now, seldom, 5);
    let (still, _) = pacer.plan_frame(now + seldom, &requested(), false);
    assert_eq!(still, slow, "no refinement between two frames of the robot");
    // The pointer moves, and the frames that it asks for come in time.
    run(&mut pacer, now + seldom, 0.05, 2);
    assert_eq!(pacer.stream_interval_s(), 0.09);
}

#[test]
fn a_pause_does_not_lower_the_quality_and_a_moved_camera_is_a_change() {
    let mut pacer = FramePacer::default();
    assert_eq!(run(&mut pacer, 0.0, 20.0, 20).1, requested());
    let moved = View { pixels_per_point: 2.0, ..requested() };
    assert_eq!(pacer.plan_frame(400.05, &moved, false).0, moved);
}
