//! A cloud without viewpoints, of two rooms with a door between them, a table and a cupboard.

use super::*;

/// Points 0.1 m apart on a rectangle.
fn plane(out: &mut Vec<[f32; 3]>, corner: [f32; 3], u: [f32; 3], v: [f32; 3]) {
    let count = |w: [f32; 3]| (w.iter().map(|c| c * c).sum::<f32>().sqrt() / 0.1).round() as usize;
    let (long, high) = (count(u), count(v));
    for i in 0..=long {
        for j in 0..=high {
            let (s, t) = (i as f32 / long as f32, j as f32 / high as f32);
            out.push(std::array::from_fn(|axis| corner[axis] + u[axis] * s + v[axis] * t + 0.02));
        }
    }
}

/// 12 m along x, 6 m along y, 2.6 m high. A wall at x = 6 m with a door from y = 2.5 m to 3.5 m, a table and a cupboard.
fn rooms() -> Vec<[f32; 3]> {
    let mut out = Vec::new();
    for z in [0.0, 2.6] {
        plane(&mut out, [0.0, 0.0, z], [12.0, 0.0, 0.0], [0.0, 6.0, 0.0]);
    }
    for y in [0.0, 6.0] {
        plane(&mut out, [0.0, y, 0.0], [12.0, 0.0, 0.0], [0.0, 0.0, 2.6]);
    }
    for x in [0.0, 12.0] {
        plane(&mut out, [x, 0.0, 0.0], [0.0, 6.0, 0.0], [0.0, 0.0, 2.6]);
    }
    plane(&mut out, [6.0, 0.0, 0.0], [0.0, 2.5, 0.0], [0.0, 0.0, 2.6]);
    plane(&mut out, [6.0, 3.5, 0.0], [0.0, 2.5, 0.0], [0.0, 0.0, 2.6]);
    plane(&mut out, [2.0, 4.0, 0.8], [1.4, 0.0, 0.0], [0.0, 0.8, 0.0]);
    plane(&mut out, [9.0, 5.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 2.0]);
    out
}

#[test]
fn viewpoints_are_on_the_floor_and_connections_go_through_the_door() {
    let cloud = rooms();
    let mut last = 0.0;
    let found = find_viewpoints(&cloud, &ViewpointConfig::default(), &mut |share| last = share);
    assert_eq!(last, 1.0);
    let places: Vec<Vector3> =
        found.viewpoints.iter().map(|place| place.map_from_base.translation.vector).collect();
    assert!((10..40).contains(&places.len()), "{}", places.len());
    for (place, seen) in places.iter().zip(&found.viewpoints) {
        // Neither the table nor the upper side of the ceiling is ground.
        assert!((place.z - 0.55).abs() < 0.11, "{place}");
        let on_table = place.z < 1.0 && (2.0..3.4).contains(&place.x) && (4.0..4.8).contains(&place.y);
        assert!(!on_table && seen.visible.len() > 100, "{place}: {}", seen.visible.len());
    }
    let crosses = |connection: &&[usize; 2]| {
        let [a, b] = connection.map(|index| places[index]);
        a.z < 1.0 && (a.x < 6.0) != (b.x < 6.0)
    };
    let through: Vec<_> = found.connections.iter().filter(crosses).collect();
    assert!(!through.is_empty());
    for [a, b] in through {
        let (a, b) = (places[*a], places[*b]);
        let y = a.y + (b.y - a.y) * (6.0 - a.x) / (b.x - a.x);
        assert!((2.4..3.6).contains(&y), "{a} {b}");
    }
}

#[test]
fn points_behind_a_wall_are_not_visible() {
    let cloud = rooms();
    let found = find_viewpoints(&cloud, &ViewpointConfig::default(), &mut |_| {});
    let place = found.viewpoints.iter().filter(|place| place.map_from_base.translation.z < 1.0);
    let near = |place: &&VirtualViewpoint| {
        let at = place.map_from_base.translation.vector;
        (at - Vector3::new(2.0, 1.5, 0.5)).norm()
    };
    let place = place.min_by(|a, b| near(a).total_cmp(&near(b))).unwrap();
    let eye = place.map_from_base.translation.vector;
    let seen: Vec<[f32; 3]> = place.visible.iter().map(|index| cloud[index as usize]).collect();
    let hidden = |point: &&[f32; 3]| {
        let [x, y, _] = point.map(f64::from);
        let crossing = eye.y + (y - eye.y) * (6.0 - eye.x) / (x - eye.x);
        x > 6.6 && !(2.3..3.7).contains(&crossing)
    };
    let wrong = seen.iter().filter(hidden).count();
    assert!(wrong * 50 < seen.len(), "{wrong} of {} behind the wall", seen.len());
    let of_the_near_wall = seen.iter().filter(|point| point[0] < 0.1).count();
    assert!(of_the_near_wall > 300, "{of_the_near_wall}");
    let through_the_door = seen.iter().filter(|point| point[0] > 11.9).count();
    assert!(through_the_door > 10, "{through_the_door}");
}

#[test]
fn the_axis_that_points_up_is_found() {
    let cloud = rooms();
    assert_eq!(find_up_axis(&cloud, &ViewpointConfig::default()), Axis::Z);
    let y_up: Vec<[f32; 3]> = cloud.iter().map(|[x, y, z]| [*x, *z, -*y]).collect();
    assert_eq!(find_up_axis(&y_up, &ViewpointConfig::default()), Axis::Y);
    let x_up: Vec<[f32; 3]> = cloud.iter().map(|[x, y, z]| [*z, *x, *y]).collect();
    assert_eq!(find_up_axis(&x_up, &ViewpointConfig::default()), Axis::X);
    assert_eq!(find_up_axis(&[], &ViewpointConfig::default()), Axis::Z);
}

#[test]
fn empty_and_invalid_clouds_have_no_viewpoints() {
    assert_eq!(find_viewpoints(&[], &ViewpointConfig::default(), &mut |_| {}), VirtualViewpoints::default());
    let far = [[f32::NAN, 0.0, 0.0], [1e30, 0.0, 0.0]];
    assert_eq!(find_viewpoints(&far, &ViewpointConfig::default(), &mut |_| {}), VirtualViewpoints::default());
}
