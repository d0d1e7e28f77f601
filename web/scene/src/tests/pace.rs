//! Slow machines draw less while things move, and everything once they rest.

use crate::{Options, Pace};

fn run(pace: &mut Pace, from: f64, interval: f64, frames: u32) -> f64 {
    (1..=frames).fold(from, |_, i| {
        let now = from + interval * f64::from(i);
        pace.drew(now);
        now
    })
}

#[test]
fn late_frames_cost_points_and_a_rest_brings_them_back() {
    let mut pace = Pace::default();
    let options = Options::default();
    assert_eq!(pace.apply(&options), options);
    let now = run(&mut pace, 0.0, 0.5, 12);
    let slow = pace.apply(&options);
    assert!(slow.point_budget < 150_000 && slow.resolution < 0.5, "{slow:?}");
    assert!(!pace.refine(now + 0.1));
    assert!(pace.refine(now + 0.5), "a still picture is refined");
    assert!(!pace.refine(now + 0.6), "and only once");
}

#[test]
fn frames_in_time_restore_the_effort_and_scans_at_ten_hertz_do_not_lower_it() {
    let mut pace = Pace::default();
    let now = run(&mut pace, 0.0, 0.3, 8);
    let now = run(&mut pace, now, 0.016, 80);
    assert_eq!(pace.apply(&Options::default()), Options::default());
    let now = run(&mut pace, now, 0.1, 50);
    assert_eq!(pace.apply(&Options::default()), Options::default());
    assert_eq!(pace.refine_in(now), None);
}

#[test]
fn a_pause_says_nothing_about_speed() {
    let mut pace = Pace::default();
    run(&mut pace, 0.0, 10.0, 20);
    assert_eq!(pace.apply(&Options::default()), Options::default());
}
