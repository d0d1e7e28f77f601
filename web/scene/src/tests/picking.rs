//! Tests of picking, also against a search over every point of every tile.

use super::TestTile;
use crate::picking::{Hit, PickCone, PickTarget, nearest_loop, nearest_point, nearest_target, resolve_pick};
use crate::projection::{CameraProjection, Ray};
use crate::tiles::TilePoints;
use crate::{CameraPose, LoopEdge, LoopState, WHOLE_MAP};
use glam::{DAffine3, DQuat, DVec2, DVec3};
use proptest::prelude::*;

fn brute_force(points: &TilePoints, map_from_anchor: &DAffine3, cone: &PickCone) -> Option<f64> {
    let positions = points.points.iter().map(|p| map_from_anchor.transform_point3(points.position(p)));
    positions
        .filter(|p| p.z >= cone.height_range[0] && p.z <= cone.height_range[1])
        .filter_map(|p| {
            let relative = p - cone.ray.origin;
            let along = relative.dot(cone.ray.direction);
            let off_axis = relative.cross(cone.ray.direction).length();
            (along >= CameraProjection::NEAR_M && off_axis <= along * cone.slope).then_some(along)
        })
        .reduce(f64::min)
}

proptest! {
    #[test]
    fn picking_finds_the_same_point_as_a_search_over_all_points(
        positions in prop::collection::vec(prop::array::uniform3(-6.0..6.0_f64), 1..3000),
        towards in prop::array::uniform3(-1.0..1.0_f64),
        from in prop::array::uniform3(-9.0..9.0_f64),
        turn in 0.0..6.0_f64, slope in 0.005..0.2_f64, floor in -7.0..0.0_f64, ceiling in 0.0..7.0_f64,
    ) {
        let mut positions: Vec<DVec3> = positions.into_iter().map(DVec3::from_array).collect();
        // Sorted, so that consecutive points are neighbours and the boxes of blocks are small.
        positions.sort_by(|a, b| a.x.total_cmp(&b.x));
        let made = TestTile::new(&positions, 0.1);
        let points = TilePoints::new(WHOLE_MAP, &made.block()).unwrap();
        let pose = DAffine3::from_rotation_translation(DQuat::from_rotation_z(turn), DVec3::new(1.0, 2.0, 0.5));
        let direction = DVec3::from_array(towards).try_normalize().unwrap_or(DVec3::X);
        let ray = Ray { origin: DVec3::from_array(from), direction };
        let cone = PickCone { ray, slope, height_range: [floor, ceiling] };
        let found = nearest_point(&points, &pose, &cone, f64::INFINITY).map(|(along, _)| along);
        let expected = brute_force(&points, &pose, &cone);
        prop_assert_eq!(found.is_some(), expected.is_some());
        if let (Some(found), Some(expected)) = (found, expected) {
            prop_assert!((found - expected).abs() < 1e-9);
        }
    }
}

#[test]
fn points_above_the_ceiling_limit_are_not_picked() {
    let wall: Vec<DVec3> = (0..100).map(|i| DVec3::new(5.0, 0.0, f64::from(i) * 0.05)).collect();
    let floor = [DVec3::new(9.0, 0.0, 0.0)];
    let pointss =
        [&wall[..], &floor].map(|p| TilePoints::new(WHOLE_MAP, &TestTile::new(p, 0.05).block()).unwrap());
    let origin = DVec3::new(0.0, 0.0, 4.0);
    let direction = (floor[0] - origin).normalize();
    let hit = |ceiling: f64| {
        let cone = PickCone { ray: Ray { origin, direction }, slope: 0.01, height_range: [-1.0, ceiling] };
        let all = pointss.iter().filter_map(|c| nearest_point(c, &DAffine3::IDENTITY, &cone, f64::INFINITY));
        all.map(|(_, at)| at.x).reduce(f64::min).unwrap()
    };
    assert!((hit(10.0) - 5.0).abs() < 0.01);
    assert!((hit(1.0) - 9.0).abs() < 0.01);
}

#[test]
fn the_target_nearest_to_the_pointer_is_picked() {
    let camera = CameraPose { target: DVec3::ZERO, yaw: 0.0, pitch: 0.5, distance: 10.0 };
    let projection = CameraProjection::new(camera, [1000, 800]);
    let place = |y: f64| DVec3::new(0.0, y, 0.0);
    let targets = [
        PickTarget { hit: Hit::Node(1), position: place(0.0) },
        PickTarget { hit: Hit::Node(2), position: place(0.3) },
        PickTarget { hit: Hit::Robot, position: place(5.0) },
    ];
    let at = |y: f64| projection.project(place(y)).unwrap().0;
    let nearest = |pixel| nearest_target(&targets, &projection, pixel, 22.0).map(|(_, hit)| hit);
    assert_eq!(nearest(at(0.05)), Some(Hit::Node(1)));
    assert_eq!(nearest(at(0.28)), Some(Hit::Node(2)));
    assert_eq!(nearest(at(5.0) + DVec2::new(0.0, 21.0)), Some(Hit::Robot));
    assert_eq!(nearest(at(5.0) + DVec2::new(0.0, 23.0)), None);
}

fn loop_edge(nodes: [u32; 2], ends: [[f64; 3]; 2], state: LoopState) -> LoopEdge {
    LoopEdge { nodes, ends: ends.map(DVec3::from_array), state }
}

#[test]
fn the_loop_whose_line_is_nearest_is_picked_and_only_near_it() {
    let camera = CameraPose { target: DVec3::ZERO, yaw: 0.0, pitch: 0.5, distance: 10.0 };
    let projection = CameraProjection::new(camera, [1000, 800]);
    let loops = [
        loop_edge([1, 9], [[0.0, -2.0, 0.0], [0.0, 2.0, 0.0]], LoopState::Closed),
        loop_edge([2, 8], [[1.0, -2.0, 0.0], [1.0, 2.0, 0.0]], LoopState::Rejected),
        // From in front of the camera to far behind it.
        loop_edge([3, 7], [[-4.0, 3.0, 0.0], [-60.0, 3.0, 0.0]], LoopState::Open),
    ];
    let at = |x: f64, y: f64| projection.project(DVec3::new(x, y, 0.0)).unwrap().0;
    let pick = |pixel| nearest_loop(&loops, &projection, pixel, 6.0);
    assert_eq!(pick(at(0.0, 1.3)), Some(Hit::Loop([1, 9])));
    assert_eq!(pick(at(1.0, -1.9)), Some(Hit::Loop([2, 8])));
    assert_eq!(pick(at(0.0, 0.0) + DVec2::new(0.0, 5.0)), Some(Hit::Loop([1, 9])));
    assert_eq!(pick(at(0.0, 0.0) + DVec2::new(0.0, 7.0)), None);
    assert_eq!(pick(at(0.0, 2.0) - DVec2::new(7.0, 0.0)), None, "past its end");
    assert_eq!(pick(at(-4.5, 3.0)), Some(Hit::Loop([3, 7])), "the part in front of the camera");
    let behind = loop_edge([4, 6], [[-40.0, 0.0, 0.0], [-60.0, 0.0, 0.0]], LoopState::Closed);
    assert_eq!(nearest_loop(&[behind], &projection, at(0.0, 0.0), 1e9), None);
}

#[test]
fn of_loops_at_the_same_distance_the_one_with_the_higher_state_is_picked() {
    let projection = CameraProjection::new(CameraPose::default(), [1000, 800]);
    let ends = [[0.0; 3], [1.0, 1.0, 0.0]];
    let edges = [LoopState::Closed, LoopState::Rejected, LoopState::Open];
    let loops: Vec<LoopEdge> = (0..).zip(edges).map(|(n, state)| loop_edge([n, 9], ends, state)).collect();
    let at = projection.project(DVec3::new(0.5, 0.5, 0.0)).unwrap().0;
    assert_eq!(nearest_loop(&loops, &projection, at, 6.0), Some(Hit::Loop([0, 9])));
}

#[test]
fn a_node_is_picked_within_its_drawn_radius_and_a_loop_outside_it() {
    let (node, line) = (Hit::Node(3), Hit::Loop([3, 9]));
    assert_eq!(resolve_pick(Some((4.0, node)), Some(line), 9.0), Some(node));
    assert_eq!(resolve_pick(Some((15.0, node)), Some(line), 9.0), Some(line));
    assert_eq!(resolve_pick(Some((15.0, node)), None, 9.0), Some(node));
    assert_eq!(resolve_pick(None, Some(line), 9.0), Some(line));
    assert_eq!(resolve_pick(None, None, 9.0), None);
}
