//! On a level floor.

use super::*;
use geometry::so3;
use std::sync::Arc;

fn shifted(x: f64, y: f64) -> Isometry {
    Isometry::translation(x, y, 0.0)
}

/// A robot on a level floor with a post 1.5 m ahead.
fn on_a_floor() -> Motion {
    let mut motion = Motion::new(Some(0.5));
    let mut points: Vec<[f32; 3]> = Vec::new();
    for x in -40..=40_i8 {
        points.extend((-40..=40_i8).map(|y| [0.1 * f32::from(x), 0.1 * f32::from(y), -0.5]));
    }
    points.extend((0..20_u8).flat_map(|z| [[1.5, 0.0, 0.05 * f32::from(z) - 0.4]; 3]));
    for _ in 0..20 {
        motion.observe(Stamp::EPOCH, &Isometry::identity(), [0.0; 3], &points);
    }
    motion
}

/// Where the way ends and how near it passes to the post, by the published state.
fn way(motion: &mut Motion, frames: &Frames, post: (f64, f64)) -> ((f64, f64), f64) {
    let Some(MotionState::Walking { path, .. }) = motion.changed(frames) else { panic!("does not walk") };
    let mut nearest = f64::INFINITY;
    for pair in path.windows(2) {
        for step in 0..=20 {
            let share = f64::from(step) / 20.0;
            let [x, y] = [(pair[0].x, pair[1].x), (pair[0].y, pair[1].y)].map(|(a, b)| a + share * (b - a));
            nearest = nearest.min((x - post.0).hypot(y - post.1));
        }
    }
    path.last().map(|end| ((end.x, end.y), nearest)).unwrap_or(((f64::NAN, f64::NAN), nearest))
}

#[test]
fn a_map_that_moves_leaves_obstacles_where_they_are_and_the_goal_where_it_is_on_the_map() {
    let mut motion = on_a_floor();
    let mut frames = Frames { map_from_odom: shifted(10.0, 0.0), odom_from_base: Isometry::identity() };
    assert_eq!(motion.walk_to(Stamp::EPOCH, &frames, Vector3::new(13.0, 0.0, -0.5)), Ok(()));
    let (end, nearest) = way(&mut motion, &frames, (11.5, 0.0));
    assert!((end.0 - 13.0).hypot(end.1) < 0.15 && nearest > 0.2, "{end:?} {nearest}");
    // A loop moves the map by 0.6 m under the robot. The same instant: no time for planning as a matter of course.
    frames.map_from_odom = shifted(10.0, 0.6);
    assert!(
        motion.tick(Stamp::EPOCH, &frames, &ExplorationHint::default()).is_some_and(|drive| drive
            .velocity
            .linear
            .x
            >= 0.0)
    );
    let (end, nearest) = way(&mut motion, &frames, (11.5, 0.6));
    assert!((end.0 - 13.0).hypot(end.1) < 0.15 && nearest > 0.2, "{end:?} {nearest}");
    let Mode::Walking(walk) = &motion.mode else { panic!("does not walk") };
    assert!(walk.stuck.is_none() && (walk.planned_to.y + 0.6).abs() < 1e-9, "{walk:?}");
}

/// What a room of 8 by 8 metres shows of itself from its middle.
fn room() -> Vec<[f32; 3]> {
    let mut points: Vec<[f32; 3]> = Vec::new();
    for x in -40..=40_i8 {
        points.extend((-40..=40_i8).map(|y| [0.1 * f32::from(x), 0.1 * f32::from(y), -0.5]));
        for z in [-0.3, 0.0, 0.3] {
            let x = 0.1 * f32::from(x);
            points.extend([[x, -4.0, z], [x, 4.0, z], [-4.0, x, z], [4.0, x, z]]);
        }
    }
    points
}

/// Lets a robot move as it is told for so long, at 20 Hz; it sees the room unless it is dark. Returns where it went.
fn live(motion: &mut Motion, frames: &mut Frames, now: &mut Stamp, seconds: u32, dark: bool) -> Vec<Vector3> {
    let points = if dark { Vec::new() } else { room() };
    live_in(&points, &|_| true, motion, frames, now, seconds)
}

/// The same among points that it sees, in the dark if there are none, in places that it can come to.
fn live_in(
    points: &[[f32; 3]],
    is_open: &dyn Fn(&Vector3) -> bool,
    motion: &mut Motion,
    frames: &mut Frames,
    now: &mut Stamp,
    seconds: u32,
) -> Vec<Vector3> {
    live_by(&ExplorationHint::default(), points, is_open, motion, frames, now, seconds)
}

/// The same with something known of where it may be.
fn live_by(
    exploration_hint: &ExplorationHint,
    points: &[[f32; 3]],
    is_open: &dyn Fn(&Vector3) -> bool,
    motion: &mut Motion,
    frames: &mut Frames,
    now: &mut Stamp,
    seconds: u32,
) -> Vec<Vector3> {
    let mut way = Vec::new();
    for _ in 0..seconds * 20 {
        *now += Span::from_millis(50);
        if !points.is_empty() {
            let base_from_odom = frames.odom_from_base.inverse();
            let points = points.iter().map(|point| {
                let [x, y, z] = point.map(f64::from);
                let seen =
                    base_from_odom.rotation * Vector3::new(x, y, z) + base_from_odom.translation.vector;
                [seen.x as f32, seen.y as f32, seen.z as f32]
            });
            motion.observe(*now, &frames.odom_from_base, [0.0; 3], &points.collect::<Vec<_>>());
        }
        if let Some(drive) = motion.tick(*now, frames, exploration_hint) {
            let turned = so3::exp(&Vector3::new(0.0, 0.0, 0.05 * drive.velocity.angular.z));
            let step =
                Isometry::from_parts(Vector3::new(0.05 * drive.velocity.linear.x, 0.0, 0.0).into(), turned);
            let next = frames.odom_from_base * step;
            if is_open(&next.translation.vector) {
                frames.odom_from_base = next;
            } else {
                frames.odom_from_base.rotation = next.rotation;
            }
        }
        way.push(frames.odom_from_base.translation.vector);
    }
    way
}

#[test]
fn who_sees_nothing_waits_and_goes_on_when_it_sees() {
    let mut motion = Motion::new(Some(0.5));
    let (mut frames, mut now) =
        (Frames { map_from_odom: shifted(10.0, 0.0), odom_from_base: shifted(0.0, 0.0) }, Stamp::EPOCH);
    live(&mut motion, &mut frames, &mut now, 1, false);
    assert_eq!(motion.walk_to(now, &frames, Vector3::new(13.0, 0.0, -0.5)), Ok(()));
    live(&mut motion, &mut frames, &mut now, 1, false);
    let before = frames.odom_from_base.translation.vector;
    live(&mut motion, &mut frames, &mut now, 20, true);
    assert!(matches!(motion.changed(&frames), Some(MotionState::Waiting { .. })));
    let after = frames.odom_from_base.translation.vector;
    assert!((after - before).norm() < 1.4 && after.x < 2.3, "{after}");
    live(&mut motion, &mut frames, &mut now, 5, false);
    assert_eq!(motion.changed(&frames), Some(MotionState::Idle));
    assert!((frames.map_from_base().translation.x - 13.0).abs() < 0.2);
}

#[test]
fn who_loses_its_place_looks_about_within_what_it_sees_and_goes_on_to_its_goal() {
    let mut motion = Motion::new(Some(0.5));
    let (mut frames, mut now) =
        (Frames { map_from_odom: shifted(10.0, 0.0), odom_from_base: shifted(0.0, 0.0) }, Stamp::EPOCH);
    live(&mut motion, &mut frames, &mut now, 1, false);
    assert_eq!(motion.walk_to(now, &frames, Vector3::new(13.0, 0.0, -0.5)), Ok(()));
    assert_eq!(motion.lose_place(now), Some(Drive::default()));
    let way = live(&mut motion, &mut frames, &mut now, 2, false);
    assert!(
        way.iter().all(|place| place.norm() < 0.01),
        "it stands first, so that it can be told where it is"
    );
    let way = live(&mut motion, &mut frames, &mut now, 20, false);
    assert!(matches!(motion.changed(&frames), Some(MotionState::Looking { goal: Some(_) })));
    let far = way.iter().map(|place| place.norm()).fold(0.0, f64::max);
    assert!(far > 2.0 && way.iter().all(|place| place.x.abs().max(place.y.abs()) < 3.6), "{far}");
    // The map turns out to lie elsewhere.
    frames.map_from_odom = shifted(11.0, 0.0);
    assert!(motion.go_on(now, &frames));
    live(&mut motion, &mut frames, &mut now, 12, false);
    assert_eq!(motion.changed(&frames), Some(MotionState::Idle));
    assert!((frames.map_from_base().translation.vector - Vector3::new(13.0, 0.0, 0.0)).norm() < 0.2);
}

#[test]
fn who_does_not_find_its_place_gives_up_and_says_so_and_a_stop_is_a_stop() {
    let mut motion = Motion::new(Some(0.5));
    let (mut frames, mut now) =
        (Frames { map_from_odom: shifted(0.0, 0.0), odom_from_base: shifted(0.0, 0.0) }, Stamp::EPOCH);
    live(&mut motion, &mut frames, &mut now, 1, false);
    assert_eq!(motion.walk_to(now, &frames, Vector3::new(3.0, 0.0, -0.5)), Ok(()));
    motion.lose_place(now);
    live(&mut motion, &mut frames, &mut now, 180, false);
    assert!(matches!(motion.changed(&frames), Some(MotionState::Blocked { .. })));
    assert_eq!(motion.look_about(now), Ok(()));
    motion.stop(None);
    assert!(!motion.go_on(now, &frames) && motion.look_about(now).is_err());
    let at = frames.odom_from_base.translation.vector;
    assert!(
        live(&mut motion, &mut frames, &mut now, 5, false).iter().all(|place| (place - at).norm() < 1e-9)
    );
}

/// A robot in the room that looks about, and where it goes first.
fn looking() -> (Motion, Frames, Stamp, Vector3) {
    let mut motion = Motion::new(Some(0.5));
    let (mut frames, mut now) =
        (Frames { map_from_odom: shifted(0.0, 0.0), odom_from_base: shifted(0.0, 0.0) }, Stamp::EPOCH);
    live(&mut motion, &mut frames, &mut now, 1, false);
    assert_eq!(motion.look_about(now), Ok(()));
    live(&mut motion, &mut frames, &mut now, 3, false);
    let Mode::Looking(look) = &motion.mode else { panic!("does not look") };
    let Some(end) = look.goes_to() else { panic!("does not walk") };
    (motion, frames, now, end)
}

#[test]
fn who_looks_about_goes_round_what_comes_into_its_way() {
    let (mut motion, mut frames, mut now, end) = looking();
    let post = end * 0.6;
    let mut points = room();
    points.extend((0..20_u8).flat_map(|z| {
        let at = |x: f64, y: f64| [(post.x + x) as f32, (post.y + y) as f32, 0.05 * f32::from(z) - 0.4];
        [at(0.0, 0.0), at(0.1, 0.0), at(-0.1, 0.0), at(0.0, 0.1), at(0.0, -0.1)]
    }));
    let way = live_in(&points, &|_| true, &mut motion, &mut frames, &mut now, 15);
    let nearest = way.iter().map(|place| (place - post).xy().norm()).fold(f64::INFINITY, f64::min);
    let farthest = way.iter().map(|place| place.norm()).fold(0.0, f64::max);
    assert!(nearest > 0.3 && farthest > 1.5, "{nearest} m from it, {farthest} m away");
}

#[test]
fn who_looks_about_turns_elsewhere_where_something_unseen_stops_it() {
    let (mut motion, mut frames, mut now, end) = looking();
    let that_way = end.normalize();
    let is_open = |place: &Vector3| place.dot(&that_way) < 0.5;
    let way = live_in(&room(), &is_open, &mut motion, &mut frames, &mut now, 30);
    let farthest = way.iter().map(|place| place.norm()).fold(0.0, f64::max);
    assert!(farthest > 1.5, "{farthest} m");
}

/// A robot in the room that has been told to look about just now, with an exploration hint.
fn looking_by(exploration_hint: &ExplorationHint, seconds: u32) -> (Motion, Frames, Stamp, Vec<Vector3>) {
    let mut motion = Motion::new(Some(0.5));
    let (mut frames, mut now) =
        (Frames { map_from_odom: shifted(0.0, 0.0), odom_from_base: shifted(0.0, 0.0) }, Stamp::EPOCH);
    live(&mut motion, &mut frames, &mut now, 1, false);
    assert_eq!(motion.look_about(now), Ok(()));
    let way = live_by(exploration_hint, &room(), &|_| true, &mut motion, &mut frames, &mut now, seconds);
    (motion, frames, now, way)
}

/// Two places, and a way between them round two corners.
fn two_places() -> ExplorationHint {
    let way = [[0.0, 0.0], [0.0, 1.5], [0.0, 3.0], [-1.5, 3.0], [-3.0, 3.0]];
    ExplorationHint {
        hypotheses: 2,
        path: Some(way.map(|[x, y]| Vector3::new(x, y, -0.5)).into_iter().collect()),
    }
}

#[test]
fn who_may_be_in_two_places_walks_at_once_on_the_way_that_tells_them_apart() {
    let (_, _, _, way) = looking_by(&two_places(), 12);
    assert!(way[20..].windows(10).take(100).all(|part| part[0] != part[9]), "it does not stand on the way");
    let end = way[way.len() - 1];
    let near = |x: f64, y: f64| way.iter().map(|at| (at.x - x).hypot(at.y - y)).fold(f64::INFINITY, f64::min);
    assert!(near(-3.0, 3.0) < 0.6, "{end}");
    assert!(way.iter().take(160).all(|at| at.x < 0.6 && at.y > -0.6), "straight there");
}

#[test]
fn until_the_way_that_tells_them_apart_is_thought_out_it_stands() {
    let exploration_hint = ExplorationHint { hypotheses: 2, path: None };
    let (_, _, _, way) = looking_by(&exploration_hint, 2);
    assert!(way.iter().all(|at| at.norm() < 0.01));
    // None is found: it looks for itself.
    let exploration_hint = ExplorationHint { hypotheses: 2, path: Some(Arc::from([])) };
    let (_, _, _, way) = looking_by(&exploration_hint, 8);
    assert!(way.iter().any(|at| at.norm() > 2.0));
}

#[test]
fn where_the_way_that_tells_them_apart_is_barred_by_something_unseen_it_goes_elsewhere() {
    let (mut motion, mut frames, mut now, _) = looking_by(&two_places(), 1);
    let is_open = |at: &Vector3| at.y < 1.0;
    let way = live_by(&two_places(), &room(), &is_open, &mut motion, &mut frames, &mut now, 25);
    assert!(way.iter().any(|at| at.xy().norm() > 2.0), "it stays before it");
}
