//! A LiDAR in the centre of a round hall of 6 m radius, with objects that stand there and are removed.

use super::*;
use geometry::Vector3;

/// Height of the floor in the base frame, metres. The LiDAR is 0.2 m above the base.
const FLOOR: f64 = -0.55;
const SENSOR: [f32; 3] = [0.0, 0.0, 0.2];

/// A cylinder: centre, radius, lowest and highest point above the floor, metres.
#[derive(Clone, Copy)]
struct Cylinder {
    centre: [f64; 2],
    radius: f64,
    heights: (f64, f64),
}

const PERSON: Cylinder = Cylinder { centre: [2.0, 0.3], radius: 0.25, heights: (0.0, 1.7) };

/// Range of a ray from the LiDAR, metres. The wall is at a horizontal distance of 6 m.
fn cast(ray: &Vector3, objects: &[Cylinder]) -> f64 {
    let floor = if ray.z < 0.0 { (FLOOR - f64::from(SENSOR[2])) / ray.z } else { f64::INFINITY };
    let level = ray.xy().norm();
    let met = objects.iter().filter_map(|object| {
        let along = (object.centre[0] * ray.x + object.centre[1] * ray.y) / level;
        let aside = (object.centre[0] * ray.y - object.centre[1] * ray.x) / level;
        let half = (object.radius.powi(2) - aside.powi(2)).max(0.0).sqrt();
        // The steps of 2 cm through the object also hit a hanging object from below.
        let steps = (2.0 * half / 0.02) as usize;
        (along > 0.0 && half > 0.0).then_some(0..=steps)?.find_map(|step| {
            let range = (along - half + 0.02 * step as f64) / level;
            let height = f64::from(SENSOR[2]) + range * ray.z - FLOOR;
            (object.heights.0..=object.heights.1).contains(&height).then_some(range)
        })
    });
    met.fold(floor.min(6.0 / level), f64::min)
}

/// One sweep of a LiDAR with 33 beams.
fn scan(columns: usize, objects: &[Cylinder]) -> Vec<[f32; 3]> {
    let mut points = Vec::new();
    for column in 0..columns {
        let yaw = (column as f64 + 0.3) * std::f64::consts::TAU / columns as f64;
        for beam in -16..=16 {
            let pitch = f64::from(beam).to_radians();
            let ray = Vector3::new(pitch.cos() * yaw.cos(), pitch.cos() * yaw.sin(), pitch.sin());
            let end = ray * cast(&ray, objects) + Vector3::from(SENSOR.map(f64::from));
            points.push([end.x as f32, end.y as f32, end.z as f32]);
        }
    }
    points
}

fn insert_scans(elevation_map: &mut ElevationMap, scan: &[[f32; 3]], times: usize) {
    for _ in 0..times {
        elevation_map.insert_scan(&Isometry::identity(), SENSOR, scan, 12.0);
    }
}

#[test]
fn people_who_leave_are_cleared_even_without_sight_of_the_ground() {
    let mut elevation_map = ElevationMap::new(0.1, RobotShape::default());
    insert_scans(&mut elevation_map, &scan(500, &[PERSON]), 20);
    let edge = elevation_map.index(1.8, 0.3);
    assert!(!elevation_map.is_free(edge));
    // The lowest beam hits the floor at a distance of 2.6 m.
    insert_scans(&mut elevation_map, &scan(500, &[]), 15);
    assert!(elevation_map.is_free(edge));
    assert!(!elevation_map.is_free(elevation_map.index(5.9, 0.0)), "the wall must stay");
}

/// Seen from 0.75 m above the floor, rays that end on the floor pass beside low things that are some metres away. They must not hide that nothing is there any more.
#[test]
fn legs_that_leave_are_cleared_over_the_floor_before_them() {
    let legs = Cylinder { centre: [5.15, 0.05], radius: 0.25, heights: (0.23, 0.8) };
    let crate_on_floor = Cylinder { centre: [-5.15, 0.05], radius: 0.25, heights: (0.0, 0.6) };
    let mut elevation_map = ElevationMap::new(0.1, RobotShape::default());
    insert_scans(&mut elevation_map, &scan(500, &[legs, crate_on_floor]), 5);
    let [left, stays] = [legs, crate_on_floor].map(|thing| {
        let [x, y] = thing.centre;
        elevation_map.index(x - (thing.radius - 0.05) * x.signum(), y)
    });
    assert!(elevation_map.is_obstacle(left) && elevation_map.is_obstacle(stays));
    insert_scans(&mut elevation_map, &scan(500, &[crate_on_floor]), 15);
    assert!(!elevation_map.is_obstacle(left), "nobody is there any more");
    insert_scans(&mut elevation_map, &scan(500, &[crate_on_floor]), 100);
    assert!(elevation_map.is_obstacle(stays), "a low thing that stands must stay");
}

/// Points of a completely visible object, and of the floor at its foot.
fn points_of(object: &Cylinder) -> Vec<[f32; 3]> {
    let ([x, y], (foot, top)) = (object.centre.map(|c| c as f32), object.heights);
    let at = |share: f64| [x, y, (FLOOR + foot + (top - foot) * share) as f32];
    let mut points: Vec<[f32; 3]> = (0..=20).map(|step| at(f64::from(step) / 20.0)).collect();
    points.push([x, y, FLOOR as f32]);
    points
}

#[test]
fn objects_that_rays_miss_stay() {
    let low = Cylinder { centre: [0.95, 0.05], radius: 0.1, heights: (0.0, 0.4) };
    let table = Cylinder { centre: [2.05, 0.05], radius: 0.4, heights: (0.70, 0.78) };
    // The bars of a railing. Nearby, no ray hits them, and some pass between them.
    let bars = [0.5, 1.05].map(|height| Cylinder {
        centre: [0.65, 0.05],
        radius: 0.1,
        heights: (height - 0.02, height + 0.02),
    });
    // A rope between two beams of the LiDAR.
    let rope = Cylinder { centre: [1.55, 0.05], radius: 0.1, heights: (0.758, 0.768) };
    for objects in [&[low][..], &[table], &bars, &[rope]] {
        let mut elevation_map = ElevationMap::new(0.1, RobotShape::default());
        let cell = elevation_map.index(objects[0].centre[0], objects[0].centre[1]);
        let seen: Vec<[f32; 3]> = objects.iter().flat_map(points_of).collect();
        for _ in 0..4 {
            elevation_map.insert_scan(&Isometry::identity(), [0.0, 0.0, 50.0], &seen, 12.0);
        }
        insert_scans(&mut elevation_map, &scan(500, objects), 40);
        assert!(elevation_map.is_obstacle(cell), "{:?}", objects[0].centre);
    }
}

#[test]
fn thin_traces_far_away_are_forgotten_within_seconds_and_a_rope_nearby_is_not() {
    let hip = Cylinder { centre: [4.05, 0.05], radius: 0.15, heights: (0.5, 0.62) };
    let rope = Cylinder { centre: [1.55, 0.05], radius: 0.1, heights: (0.758, 0.768) };
    let mut elevation_map = ElevationMap::new(0.1, RobotShape::default());
    let [far, near] = [hip, rope].map(|thing| elevation_map.index(thing.centre[0], thing.centre[1]));
    let seen: Vec<[f32; 3]> = [hip, rope].iter().flat_map(points_of).collect();
    for _ in 0..4 {
        elevation_map.insert_scan(&Isometry::identity(), [0.0, 0.0, 50.0], &seen, 12.0);
    }
    insert_scans(&mut elevation_map, &scan(500, &[rope]), 30);
    assert!(elevation_map.is_obstacle(far), "a few scans prove little about thin things");
    insert_scans(&mut elevation_map, &scan(500, &[rope]), 40);
    assert!(!elevation_map.is_obstacle(far), "nobody is there any more");
    insert_scans(&mut elevation_map, &scan(500, &[rope]), 100);
    assert!(elevation_map.is_obstacle(near), "the rope is between two beams");
}

#[test]
fn a_pole_that_every_third_scan_hits_stays() {
    let pole = Cylinder { centre: [3.05, 0.05], radius: 0.04, heights: (0.0, 3.0) };
    let mut elevation_map = ElevationMap::new(0.1, RobotShape::default());
    let cell = elevation_map.index(pole.centre[0], pole.centre[1]);
    let (met, missed) = (scan(720, &[pole]), scan(720, &[]));
    insert_scans(&mut elevation_map, &met, 4);
    for _ in 0..20 {
        insert_scans(&mut elevation_map, &met, 1);
        insert_scans(&mut elevation_map, &missed, 2);
        assert!(elevation_map.is_obstacle(cell));
    }
    insert_scans(&mut elevation_map, &missed, 12);
    assert!(!elevation_map.is_obstacle(cell), "a removed pole must be cleared");
}

#[test]
fn a_box_stays_an_obstacle_when_the_sign_above_it_is_removed() {
    // A sign above a box. Nearby, no ray hits the sign.
    let [carton, sign] =
        [(0.0, 0.45), (0.9, 1.2)].map(|heights| Cylinder { centre: [0.95, 0.05], radius: 0.1, heights });
    let mut elevation_map = ElevationMap::new(0.1, RobotShape::default());
    let cell = elevation_map.index(carton.centre[0], carton.centre[1]);
    let seen: Vec<[f32; 3]> = [carton, sign].iter().flat_map(points_of).collect();
    for _ in 0..4 {
        elevation_map.insert_scan(&Isometry::identity(), [0.0, 0.0, 50.0], &seen, 12.0);
    }
    insert_scans(&mut elevation_map, &scan(500, &[carton]), 40);
    assert!(elevation_map.is_obstacle(cell));
}

#[test]
fn an_object_with_a_hidden_foot_is_not_ground() {
    let mut elevation_map = ElevationMap::new(0.1, RobotShape::default());
    let near = Cylinder { centre: [1.3, 0.3], ..PERSON };
    insert_scans(&mut elevation_map, &scan(500, &[near]), 20);
    let edge = elevation_map.index(1.06, 0.3);
    assert!(elevation_map.is_obstacle(edge));
    assert_eq!(elevation_map.cell(edge).ground(), None);
    insert_scans(&mut elevation_map, &scan(500, &[]), 15);
    assert!(elevation_map.is_free(edge));
}

#[test]
fn stairs_are_ground_and_an_arm_is_not() {
    // Seven steps of 17 cm, beginning at 3 m.
    let mut points = scan(500, &[]);
    points.retain(|[x, y, _]| *x < 3.0 || *x > 4.96 || y.abs() > 0.5);
    for step in 0..7_u8 {
        for tread in 0..14_u8 {
            let x = 3.0 + 0.28 * f32::from(step) + 0.02 * f32::from(tread);
            points.extend(
                (-10..=10_i8).map(|y| [x, 0.05 * f32::from(y), FLOOR as f32 + 0.17 * f32::from(step + 1)]),
            );
        }
    }
    let mut elevation_map = ElevationMap::new(0.1, RobotShape::default());
    insert_scans(&mut elevation_map, &points, 30);
    let top = elevation_map.cell(elevation_map.index(4.85, 0.0)).ground();
    assert!(top.is_some_and(|top| (top - FLOOR - 7.0 * 0.17).abs() < 0.02), "{top:?}");
    assert!(
        (0..20_u8).all(|tenth| elevation_map.is_free(elevation_map.index(3.0 + 0.1 * f64::from(tenth), 0.0)))
    );
    // An arm beside the robot, above the lowest beam.
    let arm = Cylinder { centre: [1.2, 0.3], radius: 0.05, heights: (0.85, 1.4) };
    let mut elevation_map = ElevationMap::new(0.1, RobotShape::default());
    let mut with_arm = scan(500, &[]);
    with_arm.extend(points_of(&arm).into_iter().filter(|point| point[2] > FLOOR as f32 + 0.1));
    insert_scans(&mut elevation_map, &with_arm, 20);
    let place = elevation_map.index(1.2, 0.3);
    assert_eq!(elevation_map.cell(place).ground(), None);
    assert!(!elevation_map.is_free(place));
    insert_scans(&mut elevation_map, &scan(500, &[]), 20);
    assert!(elevation_map.is_free(place));
}

#[test]
fn an_object_above_the_robot_is_no_obstacle() {
    for (heights, is_free) in [((1.2, 1.4), true), ((0.7, 1.4), false), ((0.25, 0.3), false)] {
        let mut elevation_map = ElevationMap::new(0.1, RobotShape::default());
        let mut points = scan(500, &[]);
        points.extend(points_of(&Cylinder { centre: [3.0, 0.3], radius: 0.1, heights }));
        insert_scans(&mut elevation_map, &points, 5);
        assert_eq!(elevation_map.is_free(elevation_map.index(3.0, 0.3)), is_free, "{heights:?}");
    }
}

#[test]
fn an_object_on_the_floor_below_a_hanging_one_is_an_obstacle() {
    let mut elevation_map = ElevationMap::new(0.1, RobotShape::default());
    let mut points = scan(500, &[]);
    for heights in [(0.0, 0.3), (1.4, 1.6)] {
        points.extend(points_of(&Cylinder { centre: [3.0, 0.3], radius: 0.1, heights }));
    }
    insert_scans(&mut elevation_map, &points, 20);
    assert!(!elevation_map.is_free(elevation_map.index(3.0, 0.3)));
}

#[test]
fn runs_group_neighbouring_bits() {
    assert_eq!(runs(0b1000_0000_0110_1110).collect::<Vec<_>>(), [(1, 3), (5, 2), (15, 1)]);
    assert_eq!(runs(u16::MAX).collect::<Vec<_>>(), [(0, 16)]);
    assert_eq!(runs(0).count(), 0);
}
