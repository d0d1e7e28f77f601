//! A room that is visited twice, with boxes that appear, go, move and stay. Rays are cast exactly, so that occlusion is right.

use super::*;

const ROOM_M: [f64; 3] = [12.0, 8.0, 3.0];

fn at(x: f64, y: f64, size_m: [f64; 3], yaw_rad: f64) -> UprightBox {
    UprightBox { centre_m: Vector3::new(x, y, size_m[2] / 2.0), size_m, yaw_rad }
}

/// The distance at which a ray meets the room or a box.
fn range_m(sensor: &Vector3, direction: &Vector3, boxes: &[UprightBox]) -> f64 {
    let room = UprightBox { centre_m: Vector3::new(0.0, 0.0, ROOM_M[2] / 2.0), size_m: ROOM_M, yaw_rad: 0.0 };
    let wall = room.crossed_by(sensor, direction).map_or(f64::INFINITY, |[_, leaves_m]| leaves_m);
    let met = boxes.iter().filter_map(|one| one.crossed_by(sensor, direction)).map(|[enters_m, _]| enters_m);
    met.fold(wall, f64::min)
}

/// A walk along the room with a view every metre, with rays every 1.5 degrees.
fn visit(boxes: &[UprightBox], until_x: f64) -> Visit {
    let step_rad = 1.5_f64.to_radians();
    let mut visit = Visit::default();
    let mut x = -5.0;
    while x <= until_x {
        let sensor = Vector3::new(x, -2.5 + 0.1 * x, 0.7);
        let mut points = Vec::new();
        for row in -20..=20 {
            for column in 0..240 {
                let (azimuth, elevation) = (f64::from(column) * step_rad, f64::from(row) * step_rad);
                let flat = elevation.cos();
                let direction = Vector3::new(flat * azimuth.cos(), flat * azimuth.sin(), elevation.sin());
                let point = sensor + direction * range_m(&sensor, &direction, boxes);
                points.push([point.x, point.y, point.z].map(|at| at as f32));
            }
        }
        visit.views.push(SensorView { sensor, points });
        x += 1.0;
    }
    visit
}

use crate::SensorView;

fn is_at(object: &UprightBox, expected: &UprightBox) -> bool {
    let sides = object.size_m.iter().zip(expected.size_m);
    (object.centre_m - expected.centre_m).norm() < 0.15
        && sides.into_iter().all(|(a, b)| (a - b).abs() < 0.2 * b + 0.02)
}

#[test]
fn what_appeared_was_removed_and_moved_is_found_and_what_stayed_is_not_named() {
    let stays = at(-2.0, 1.0, [0.5, 0.5, 0.9], 0.4);
    let gone = at(0.5, 0.5, [0.8, 0.5, 0.6], 0.2);
    let new = at(3.0, 0.0, [0.4, 0.4, 0.5], 0.7);
    let (from, to) = (at(-4.0, 0.5, [0.6, 0.4, 1.1], 0.1), at(1.5, 2.0, [0.6, 0.4, 1.1], 1.0));
    let before = visit(&[stays, gone, from], 5.0);
    let after = visit(&[stays, new, to], 5.0);
    let found = detect_changes(&before, &after, &ChangesConfig::default());
    assert_eq!(found.objects.len(), 3, "{:#?}", found.objects);
    let is_of_room = |point: &[f32; 3]| {
        found.objects.iter().all(|object| !object.place.holds(&Vector3::from(point.map(f64::from)), -0.1))
    };
    assert!(found.unchanged.len() > 1_000 && found.unchanged.iter().all(is_of_room));
    let of = |wanted: fn(&Change) -> bool| {
        found.objects.iter().find(|object| wanted(&object.change)).expect("found")
    };
    assert!(is_at(&of(|change| matches!(change, Change::Appeared)).place, &new));
    assert!(is_at(&of(|change| matches!(change, Change::Removed)).place, &gone));
    let moved = of(|change| matches!(change, Change::Moved { .. }));
    assert!(is_at(&moved.place, &to), "{moved:?}");
    assert!(matches!(&moved.change, Change::Moved { from: was } if is_at(was, &from)), "{moved:?}");
    assert!(found.objects.iter().all(|object| object.confidence > 0.99));
    let back = detect_changes(&after, &before, &ChangesConfig::default());
    assert_eq!(back.objects.len(), 3, "the other way round too");
}

#[test]
fn nothing_is_said_of_places_that_one_visit_did_not_see() {
    let wall = at(1.0, 1.5, [0.2, 5.0, 2.9], 0.0);
    let hidden = at(3.0, 2.5, [0.5, 0.5, 0.9], 0.0);
    // The first visit ends before it sees behind the wall.
    let before = visit(&[wall], -3.0);
    let after = visit(&[wall, hidden], 5.0);
    let objects =
        |before: &Visit, after: &Visit| detect_changes(before, after, &ChangesConfig::default()).objects;
    assert_eq!(objects(&before, &after), []);
    assert_eq!(objects(&before, &Visit::default()), []);
    assert_eq!(objects(&Visit::default(), &after), []);
}

#[test]
fn the_same_visits_give_the_same_bits() {
    let (before, after) = (visit(&[], 2.0), visit(&[at(2.0, 1.0, [0.5, 0.4, 0.8], 0.3)], 2.0));
    let config = ChangesConfig::default();
    let found = detect_changes(&before, &after, &config);
    assert_eq!(found.objects.len(), 1, "{found:?}");
    assert_eq!(found, detect_changes(&before, &after, &config));
}
