//! Slow machines draw less while things move, and more once they rest.

use super::view;
use crate::{CameraPose, Pace, View};

fn wanted() -> View {
    view(CameraPose::default(), [800, 600])
}

/// Draws changed frames at an interval; returns when the last was and what it was.
fn run(pace: &mut Pace, from: f64, interval: f64, frames: u32) -> (f64, View) {
    (1..=frames).fold((from, wanted()), |_, i| {
        let now = from + interval * f64::from(i);
        (now, pace.decide(now, &wanted(), true).0)
    })
}

#[test]
fn late_frames_cost_points_and_pixels_and_a_rest_brings_some_back() {
    let mut pace = Pace::default();
    assert_eq!(pace.decide(0.0, &wanted(), true), (wanted(), None));
    let (now, slow) = run(&mut pace, 0.0, 1.0, 6);
    assert!(slow.options.point_budget < 150_000 && slow.options.resolution <= 0.5, "{:?}", slow.options);
    let (same, due) = pace.decide(now + 0.1, &wanted(), false);
    assert_eq!(same, slow);
    assert!(due.is_some_and(|due| (0.25..0.35).contains(&due)), "{due:?}");
    let (still, due) = pace.decide(now + 0.45, &wanted(), false);
    assert!(still.options.point_budget > 2 * slow.options.point_budget && due.is_none());
    assert_eq!(pace.decide(now + 9.0, &wanted(), false), (still, None), "refined once only");
}

#[test]
fn frames_in_time_restore_the_effort_and_scans_at_ten_hertz_do_not_lower_it() {
    let mut pace = Pace::default();
    let (now, _) = run(&mut pace, 0.0, 0.3, 8);
    let (now, quick) = run(&mut pace, now, 0.016, 80);
    assert_eq!(quick, wanted());
    let (now, steady) = run(&mut pace, now, 0.12, 50);
    assert_eq!(steady, wanted());
    assert_eq!(pace.decide(now + 1.0, &wanted(), false), (wanted(), None));
}

#[test]
fn a_pause_says_nothing_about_speed_and_a_moved_camera_is_a_change() {
    let mut pace = Pace::default();
    assert_eq!(run(&mut pace, 0.0, 20.0, 20).1, wanted());
    let moved = View { pixels_per_point: 2.0, ..wanted() };
    assert_eq!(pace.decide(400.05, &moved, false).0, moved);
}
