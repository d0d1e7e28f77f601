//! A room that is visited twice, with boxes that appear, go, move and stay.

use super::*;
use crate::room::{FINE, Rays, at, view, visit, visit_with_rays};

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

/// A visit in which somebody stands at a place while the robot takes the view from `x`.
fn visit_with_person(boxes: &[UprightBox], person: &UprightBox, x: f64) -> Visit {
    let mut visit = visit_with_rays(boxes, 5.0, &FINE);
    let passed = visit.views.iter_mut().find(|view| (view.sensor.x - x).abs() < 1e-9).expect("a view there");
    *passed = view(passed.sensor, &FINE, &[boxes, &[*person]].concat());
    visit
}

#[test]
fn a_person_on_the_visit_before_hides_no_part_of_an_object() {
    let put = at(1.0, 0.0, [1.2, 0.5, 0.5], 0.0);
    let before = visit_with_person(&[], &at(1.0, -0.05, [0.8, 0.4, 1.7], 0.0), 1.0);
    let found =
        detect_changes(&before, &visit_with_rays(&[put], 5.0, &FINE), &ChangesConfig::default()).objects;
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].change == Change::Appeared && is_at(&found[0].place, &put), "{:?}", found[0].place);
}

#[test]
fn a_person_beside_an_object_does_not_make_it_larger() {
    let put = at(1.0, 0.0, [0.6, 0.5, 0.8], 0.3);
    let after = visit_with_person(&[put], &at(1.65, 0.0, [0.5, 0.4, 1.7], 0.0), 1.0);
    let found = detect_changes(&visit_with_rays(&[], 5.0, &FINE), &after, &ChangesConfig::default()).objects;
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(is_at(&found[0].place, &put), "{:?}", found[0].place);
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

#[test]
fn nothing_is_named_between_the_rays_of_a_sparse_sensor_that_stands() {
    // Edges about 6.5 m away, where the columns of the sensor are 0.2 m apart. Each sweep has other columns.
    let cupboard = |yaw_rad: f64| at(2.5, 1.2, [1.0, 2.0, 2.6], yaw_rad);
    let post = at(2.2, 1.2, [0.2, 0.2, 2.6], 0.6);
    let many = [0.0, 0.05, 0.1, 0.15, 0.2, 0.25];
    let cases: [(UprightBox, &[f64]); 4] = [
        (cupboard(0.0), &[0.0, 0.2]),
        (cupboard(0.0), &many),
        (cupboard(0.6), &[0.0, 0.2, 0.4]),
        (post, &many),
    ];
    for (stands, of_before) in cases {
        let sweep = |first_deg: f64| {
            let (first_rad, row_rad) = (first_deg.to_radians(), 1.0_f64.to_radians());
            let rays = Rays { columns: 200, first_rad, rows: [-16, 15], row_rad };
            view(Vector3::new(-4.4, -0.5, 0.7), &rays, &[stands])
        };
        let before = Visit { views: of_before.iter().map(|first_deg| sweep(*first_deg)).collect() };
        for step in 0..18 {
            let from_deg = 0.2 * f64::from(step);
            let after = Visit { views: many.iter().map(|more| sweep(from_deg + more)).collect() };
            let found = detect_changes(&before, &after, &ChangesConfig::default());
            assert_eq!(found.objects, [], "{stands:?}, columns from {from_deg} degrees");
        }
    }
}

#[test]
fn an_object_on_a_platform_stands_on_the_platform() {
    let platform = at(1.0, 1.0, [2.4, 2.0, 0.3], 0.2);
    let mut put = at(1.0, 1.0, [0.6, 0.5, 0.5], 0.5);
    put.centre_m.z += 0.3;
    let (before, after) = (visit(&[platform], 5.0), visit(&[platform, put], 5.0));
    let found = detect_changes(&before, &after, &ChangesConfig::default()).objects;
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(is_at(&found[0].place, &put), "{:?}", found[0].place);
}

#[test]
fn a_thing_that_was_turned_where_it_stands_is_one_that_was_moved() {
    let (from, to) = (at(0.5, 0.5, [1.0, 0.7, 0.9], 0.2), at(0.5, 0.5, [1.0, 0.7, 0.9], 0.8));
    let (before, after) = (visit(&[from], 5.0), visit(&[to], 5.0));
    let found = detect_changes(&before, &after, &ChangesConfig::default()).objects;
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        is_at(&found[0].place, &to) && (found[0].place.yaw_rad - 0.8).abs() < 0.1,
        "{:?}",
        found[0].place
    );
    let was = if let Change::Moved { from } = &found[0].change { Some(from) } else { None };
    assert!(was.is_some_and(|was| is_at(was, &from) && (was.yaw_rad - 0.2).abs() < 0.1), "{was:?}");
}

#[test]
fn a_small_thing_of_which_no_part_differs_is_turned() {
    let of = |yaw_rad: f64| visit_with_rays(&[at(0.5, 0.5, [0.45, 0.4, 0.6], yaw_rad)], 5.0, &FINE);
    let (before, after) = (of(0.2), of(0.8));
    let config = ChangesConfig::default();
    let found = detect_changes(&before, &after, &config).objects;
    assert_eq!(found.len(), 1, "{found:?}");
    let was = if let Change::Moved { from } = &found[0].change { Some(from) } else { None };
    assert!(was.is_some_and(|was| (was.yaw_rad - 0.2).abs() < 0.1), "{was:?}");
    assert!((found[0].place.yaw_rad - 0.8).abs() < 0.1, "{:?}", found[0].place);
    let parts_alone = ChangesConfig { min_turn_evidence_of_point: f64::INFINITY, ..config };
    assert_eq!(detect_changes(&before, &after, &parts_alone).objects, [], "a part of it differs");
    assert_eq!(detect_changes(&before, &of(0.2), &config).objects, [], "it stands as before");
}

#[test]
fn a_cube_of_fifteen_centimetres_that_was_turned_is_found() {
    let of = |yaw_rad: f64| visit_with_rays(&[at(0.5, -1.2, [0.15; 3], yaw_rad)], 5.0, &FINE);
    let (before, after) = (of(0.1), of(0.7));
    let found = detect_changes(&before, &after, &ChangesConfig::default()).objects;
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(matches!(found[0].change, Change::Moved { .. }), "{found:?}");
    assert!((found[0].place.centre_m - Vector3::new(0.5, -1.2, 0.075)).norm() < 0.03, "{:?}", found[0].place);
    assert_eq!(detect_changes(&before, &of(0.1), &ChangesConfig::default()).objects, []);
}

#[test]
fn a_person_who_turns_round_is_no_thing_that_was_turned() {
    let person = |yaw_rad: f64| at(1.0, -0.05, [0.6, 0.4, 1.3], yaw_rad);
    let (before, after) =
        (visit_with_person(&[], &person(0.5), 1.0), visit_with_person(&[], &person(1.2), 1.0));
    let found = detect_changes(&before, &after, &ChangesConfig::default()).objects;
    assert_eq!(found, []);
}
